"""The drawings of the one real build, read by readers that are not their writers.

80 s of processor: the build itself, and its drawings a second time by another process.
"""

from __future__ import annotations

import csv
import json
import re
from collections import Counter, defaultdict
from itertools import combinations
from pathlib import Path

import numpy as np
import pypdfium2
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.commands.cli import main
from delta_cad.dimensions import Dimensions
from delta_cad.export.bom import bill_of_materials
from delta_cad.export.drawings import assembly_sheet
from delta_cad.export.drawings.sheet_io.sheet import Stroke
from delta_cad.export.drawings.title import Titles
from delta_cad.export.drawings.views.leaders import lines_cross
from delta_cad.export.drawings.write import write_drawings
from delta_cad.export.mass_properties import mass_report
from tests.committed import ROOT, Built
from tests.delta_cad.export.drawings.reading import dxf_texts, svg_texts
from tests.delta_cad.export.shop.test_counts import differences


@pytest.fixture(scope="module")
def folder(built: Built) -> Path:
    return built.folder / "drawings"


def test_every_made_part_has_its_files_and_the_check_holds(built: Built, folder: Path, best_assembly: Assembly) -> None:
    made = {part.number for part in best_assembly.parts if part.is_drawn}
    expected = {f"{number}.{suffix}" for number in made for suffix in ("pdf", "svg", "dxf")} | {"assembly.pdf"}
    assert {path.name for path in folder.iterdir()} == expected
    (check,) = [c for c in built.record["checks"] if c["name"] == "drawings"]
    assert (check["passed"], check["value"]) == (True, 0.0)
    assert json.loads((built.folder / "manifest.json").read_text())["left_out"] == []


def test_holes_are_reported_as_the_list_of_holes_has_them(built: Built, folder: Path) -> None:
    """The oracle is `holes.csv`: of each part's diameters and threads as many as there stand."""
    with (built.folder / "holes.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for number in {row["part"] for row in rows}:
        counted: Counter[str] = Counter()
        texts = svg_texts(folder / f"{number}.svg")
        for text, after in zip(texts, [*texts[1:], ""], strict=True):  # a callout may go on in the next line
            if match := re.match(r"(?:(\d+)x )?(Ø[\d.]+|M[\d.]+)(?= |$)", text):
                both = "from both" in text or after.startswith("from both")
                counted[match[2]] += int(match[1] or 1) * (2 if both else 1)
        expected: Counter[str] = Counter()
        for row in (row for row in rows if row["part"] == number and "slot" not in row["callout"]):
            thread = re.match(r"M[\d.]+", row["callout"])
            expected[thread[0] if thread else f"Ø{float(row['diameter_mm']):g}"] += 1
        assert {key: counted[key] for key in expected} == dict(expected), number


@pytest.mark.parametrize("number", ["base_plate", "motor_cheek", "encoder_cheek"])
def test_a_table_s_coordinates_are_those_of_the_list_of_holes_along_the_axes_that_a_note_names(
    number: str, built: Built, folder: Path
) -> None:
    texts = svg_texts(folder / f"{number}.svg")
    words = re.sub(r"\s+", " ", " ".join(texts))
    zero = [float(value) for value in re.search(r"which is \(([^)]*)\)", words)[1].split(",")]  # type: ignore[index]
    reported = re.search(r"right is (-?)([XYZ]) there, its up (-?)([XYZ])\.", words)
    assert reported is not None
    with (built.folder / "holes.csv").open(encoding="utf-8") as file:
        own = [row for row in csv.DictReader(file) if row["part"] == number and row["x_mm"]]
    starts = [[float(row[f"{axis}_mm"]) for axis in "xyz"] for row in own]
    rows = {  # of the table, which comes after the view: its tag, and two coordinates
        tag: (float(right), float(up))
        for tag, right, up in zip(texts, texts[1:], texts[2:], strict=False)
        if re.fullmatch(r"[A-Z]\d+", tag) and all(re.fullmatch(r"-?[\d.]+", one) for one in (right, up))
    }
    assert len(rows) >= 6
    for tag, (right, up) in rows.items():
        point = list(zero)
        for value, sense, axis in ((right, reported[1], reported[2]), (up, reported[3], reported[4])):
            point["XYZ".index(axis)] += -value if sense else value
        kept = ["XYZ".index(reported[2]), "XYZ".index(reported[4])]
        assert any(all(abs(at[j] - point[j]) < 2e-3 for j in kept) for at in starts), (tag, point)


def test_what_the_machine_needs_stands_on_the_drawings(folder: Path, best_dimensions: Dimensions) -> None:
    d = best_dimensions
    wanted = {
        "foot_block": [f"{d.layers.motor_cheek_mm[0] - d.layers.encoder_cheek_mm[1]:g} ±0.02"],
        "upper_arm": [f"{d.arm.length_mm:g}", f"{d.layers.arm_mm[1] - d.layers.bearings_mm[0][1]:g} ±0.02"],
        "cross_bar": ["48.569 ±0.02", "Ø8 h6 (0/-0.009)", "Ra 0.8"],
        "shoulder_shaft": ["Ø8 h6 (0/-0.009)", "Ra 0.8", f"{d.shaft.y_mm[1] - d.shaft.y_mm[0]:g}", "8 across flats"],
        "platform": [f"{d.platform.radius_mm:g}"],
        "base_plate": [f"Ø{2 * d.base.radius_mm:g}", f"{d.base.thickness_mm:g}"],
        "handle_stem": ["2x M6"],
    }
    for number, texts in wanted.items():
        found = [text.lstrip("-") for text in svg_texts(folder / f"{number}.svg")]
        assert [text for text in texts if text not in found] == [], number


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    "number", ["sector", "base_plate", "shoulder_shaft", "motor_cheek", "platform", "rod_cup", "pinion", "cup_shell"]
)
def test_the_three_files_say_the_same_and_the_dxf_is_sound(number: str, folder: Path) -> None:
    from ezdxf.filemanagement import readfile

    texts = svg_texts(folder / f"{number}.svg")
    document = readfile(folder / f"{number}.dxf")
    assert document.audit().errors == []
    assert dxf_texts((folder / f"{number}.dxf").read_text(encoding="utf-8")) == texts
    with pypdfium2.PdfDocument(folder / f"{number}.pdf") as read:
        words = "".join("".join(page.get_textpage().get_text_range() for page in read).split())
        size = [round(side * 25.4 / 72.0) for side in read[0].get_size()]
    assert size in ([297, 210], [420, 297])
    letters = ["".join(text.split()) for text in texts]  # the reader joins texts that stand close: letters count
    assert [text for text in letters if text not in words] == []
    assert Counter(words) == Counter("".join(letters))


def test_a_reader_that_shares_no_code_opens_every_dxf(folder: Path) -> None:
    """GDAL, in C++: it draws a dimension by its block, so that each text is one of its own."""
    assert_read(folder)


def assert_read(folder: Path) -> None:
    """Holds that GDAL opens each DXF of a folder and finds all texts of its SVG."""
    from pyogrio.raw import read

    for path in sorted(folder.glob("*.dxf")):
        meta, _, shapes, values = read(path)
        columns = dict(zip(meta["fields"], values, strict=True))
        said = Counter(text.replace("⌀", "Ø") for text in columns["Text"] if isinstance(text, str))
        assert said == Counter(svg_texts(path.with_suffix(".svg"))), path.name
        assert len(shapes) > 100
        assert {"visible", "dimension", "text", "frame"} <= set(columns["Layer"]), path.name


def test_every_item_stands_in_the_list_and_has_a_balloon(built: Built, folder: Path) -> None:
    listed = json.loads((built.folder / "bom.json").read_text())["items"]
    rows = [row for row in listed if row["make_or_buy"] != "jig"]  # no jig is part of the machine
    with pypdfium2.PdfDocument(folder / "assembly.pdf") as read:
        pages = [page.get_textpage().get_text_range() for page in read]
    *views, last = (page for page in pages)
    for row in rows:
        assert re.search(rf"^{row['item']}\s+{row['quantity']}\s+{row['part_number']}\b", " ".join(pages), re.M) or (
            row["part_number"] in last
        )
    alone = Counter(word for page in views for word in page.split() if word.isdigit())
    placed = [row["item"] for row in rows if row["source"] or row["make_or_buy"] == "make"]
    assert [item for item in placed if item <= 38 and not alone[str(item)]] == []


def test_leaders_of_balloons_cross_none() -> None:
    """Points in two columns whose order from below is not that in which their leaders stay apart."""
    spots = np.random.default_rng(7).uniform((0.0, 0.0), (200.0, 120.0), (40, 2))
    for count in (7, 24, 40):
        points = {k + 1: (float(x), float(y)) for k, (x, y) in enumerate(spots[:count])}
        items = assembly_sheet.balloons(points, (0.0, 0.0, 200.0, 120.0))
        lines = [np.array(item.points) for item in items if isinstance(item, Stroke)]
        assert sorted(map(tuple, (line[1] for line in lines))) == sorted(points.values())
        assert not any(lines_cross(a, b) for a, b in combinations(lines, 2)), count


@pytest.mark.slow
@pytest.mark.parametrize("name", ["desk-150", "direct-83"])
def test_two_other_machines_are_drawn_without_fault(name: str, tmp_path: Path) -> None:
    """A large one with capstans and a direct drive: the checker, what the STEP files state, the other reader."""
    design = ROOT / "docs" / "gallery" / f"{name}.json"
    assert main(["build", "--design", str(design), "--out", str(tmp_path)]) == 0
    folder = tmp_path / name
    checks = {one["name"]: one for one in json.loads((folder / "checks.json").read_text())["checks"]}
    assert checks["drawings"]["passed"]
    assert differences(folder) == {}
    assert_read(folder / "drawings")


@pytest.mark.slow
def test_drawings_are_the_same_bytes_each_time(
    folder: Path, best_dimensions: Dimensions, best_assembly: Assembly, tmp_path: Path
) -> None:
    """Made once more, by another process, of solids that did not go through a pickle."""
    drawn = write_drawings(best_dimensions, best_assembly, mass_report(best_assembly), tmp_path / "again")
    again = sorted((tmp_path / "again").iterdir())
    made = sum(bool(part.make) for part in best_assembly.parts)
    assert (drawn.count, drawn.faults) == (len([path for path in again if path.suffix == ".pdf"]), {})
    assert drawn.count >= made > 0
    for path in again:
        assert path.read_bytes() == (folder / path.name).read_bytes(), path.name


def test_what_no_view_shows_is_drawn_by_itself(best_assembly: Assembly, monkeypatch: pytest.MonkeyPatch) -> None:
    """A larger machine hides parts that this one shows: each has its one balloon all the same."""
    hidden = {"sector", "pinion", "encoder_board", "set_screw_M3x4", "upper_arm", "motor", "wave_spring", "motor_cheek"}
    drive = assembly_sheet._views(best_assembly, best_assembly.poses(best_assembly.home_mm))[2]
    drive.placed = [one for one in drive.placed if one[0].part.number not in hidden]
    monkeypatch.setattr(assembly_sheet, "_views", lambda *_: [drive])
    there = hidden | {one.part.number for one, _ in drive.placed}
    rows = [row for row in bill_of_materials(best_assembly, defaultdict(float)) if row.part_number in there]
    drawing = assembly_sheet.assembly_drawing(best_assembly, rows, Titles(*["-"] * 8))
    items = assembly_sheet.placed_items(best_assembly, rows)
    assert len(items) > len(hidden) > assembly_sheet.ALONE
    assert assembly_sheet.balloon_faults(drawing, items, rows) == []
