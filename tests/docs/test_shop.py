"""What a shop asks: each file and field that the page names is in the build, and says what the page says.

An answer that is a figure is calculated here, from the design's lengths, standards by hand, or chains of tolerances; a
column of figures is held against a rule that it must follow.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable
from math import ceil, isclose
from pathlib import Path
from typing import Any

import pypdfium2
import pytest

from delta_cad.commands.cli import main
from delta_cad.design import load_design
from delta_cad.dimensions import Dimensions, dimensions
from tests.committed import COMMITTED, ROOT, Built
from tests.delta_cad.export.drawings.reading import svg_symbols

PAGE = ROOT / "docs" / "how-to" / "shop.md"
ROW = re.compile(r"^\| (?P<question>[^|]+) \| `(?P<file>[^`]+)` \| `(?P<told>[^`]+)` \|$")
LEAST = 50


def rows() -> list[tuple[str, str, str]]:
    """Question, file and what stands there, of each row of the page's tables."""
    lines = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    lines = [line for line in lines if not line.startswith("| question |")]
    found = [ROW.match(line) for line in lines]
    assert all(found), [line for line, match in zip(lines, found, strict=True) if match is None]
    return [(match["question"], match["file"], match["told"]) for match in found if match is not None]


def keys(value: Any) -> set[str]:
    """All keys and texts of a JSON value."""
    if isinstance(value, dict):
        return set(value) | {key for one in value.values() for key in keys(one)}
    if isinstance(value, list):
        return {key for one in value for key in keys(one)}
    return {value} if isinstance(value, str) else set()


def says(path: Path, wording: str) -> bool:
    """Whether a file says something, read as its kind is."""
    if path.suffix == ".pdf":
        with pypdfium2.PdfDocument(path) as read:
            words = " ".join(" ".join(page.get_textpage().get_text_range() for page in read).split())
        return wording in words
    if path.suffix == ".svg":
        return wording in svg_symbols(path)
    if path.suffix == ".csv":
        with path.open(encoding="utf-8", newline="") as file:
            table = list(csv.DictReader(file))
        return any(row.get(wording) for row in table)
    if path.suffix == ".json":
        return wording in keys(json.loads(path.read_text(encoding="utf-8")))
    return wording in path.read_text(encoding="utf-8")


def missing(folder: Path) -> list[tuple[str, str]]:
    """Answers of the page that a build has not where the page says."""
    return [(file, wording) for _, file, wording in rows() if not says(folder / file, wording)]


def link_mm(folder: Path, part: str, what: str) -> float:
    """Largest deviation of a part's dimension in the chains of tolerances of a build, which all hold, mm."""
    record = json.loads((folder / "tolerances.json").read_text(encoding="utf-8"))
    chains = [*record["chains"], *record["lengths"]]
    assert all(chain["holds"] for chain in chains)
    found = {
        one["deviation_mm"][1]
        for chain in chains
        for one in chain["links"]
        if (one["part"], one["what"]) == (part, what)
    }
    (deviation,) = found
    return deviation


def square(_: Dimensions, folder: Path) -> str:
    """A zone over the seat's depth tilts the bearing: what the chain of its tilt has for it."""
    return f"perpendicularity Ø{2.0 * link_mm(folder, 'motor_cheek', 'seat out of square'):.3g} A"


def ball(d: Dimensions, _: Path) -> str:
    """Its hole is wider than the pin by the adhesive, 0.025 around it, and deeper than the pin by 0.3."""
    f = d.forearm
    hole, past = f.pin_diameter_mm + 2 * 0.025, f.pin_past_mm + 0.3
    return f"Ø{hole:.2f} ±0.02, floor {past:g} past the ball's centre, eroded"


def shaft(d: Dimensions, _: Path) -> str:
    """Two diameters of thread, and the run-out of DIN 76-1, short, to the next half millimetre."""
    size, run_out = int(d.shaft.end_screw[1:]), {4: 2.4, 3: 1.8}
    return f"M{size} x {2 * size}, drilled {ceil(2 * (2 * size + run_out[size])) / 2:g} deep"


def ground(_: Dimensions, folder: Path) -> str:
    """The loosest class of ISO 2768-1, and never a looser one than m, with which each chain of tolerances holds."""
    loosest = json.loads((folder / "tolerances.json").read_text(encoding="utf-8"))["loosest_class"]
    return f"ISO 2768-{'fH' if loosest == 'f' else 'mK'}"


def base_screws(_: Dimensions, folder: Path) -> str:
    """A screw's length less what of the plate is under its head ends before the thread's usable end."""
    with (folder / "bom.csv").open(encoding="utf-8", newline="") as file:
        sizes = [re.fullmatch(r"screw_M4x(\d+)", row["part_number"]) for row in csv.DictReader(file)]
    with (folder / "holes.csv").open(encoding="utf-8", newline="") as file:
        (rest,) = {float(r["depth_mm"]) for r in csv.DictReader(file) if r["callout"] == "4.5 through, foot blocks"}
    inside = max(int(size[1]) - rest for size in sizes if size is not None)
    assert inside <= 11.0
    return "screws from below reach 11 at most"


FIGURES: dict[str, Callable[[Dimensions, Path], str]] = {
    "Quantity per machine 3": lambda d, _: f"Quantity per machine {len(d.design.azimuths_deg)}",
    "ISO 2768-mK": ground,
    "Ø16 H7 (+0.018/0)": lambda d, _: f"Ø{d.bearing.outer_mm:g} H7 (+{ISO_286[7, 18] / 1000:g}/0)",
    "Ø2.5 h7 (0/-0.01)": lambda d, _: f"Ø{d.forearm.pin_diameter_mm:g} h7 (0/-{ISO_286[7, 3] / 1000:g})",
    "2x Ø2.5 h7": lambda d, _: f"2x Ø{d.forearm.pin_diameter_mm:g} h7",
    "2x M6": lambda d, _: f"2x {d.platform.stem_thread}",
    "M4 x 8, drilled 10.5 deep": shaft,
    "perpendicularity Ø0.02 A": square,
    "position Ø0.05 A B C": lambda _, f: f"position Ø{2 * link_mm(f, 'motor_cheek', 'seat from its dowels'):g} A B C",
    "coaxiality Ø0.05 A": lambda _, f: f"coaxiality Ø{2 * link_mm(f, 'pinion', 'groove off its bore'):g} A",
    "position Ø0.05 CZ A": lambda _, f: f"position Ø{2 * link_mm(f, 'base_plate', 'place of a dowel'):g} CZ A",
    "with a mandrel 16 h5 in both seats": lambda d, _: f"with a mandrel {d.bearing.outer_mm:g} h5 in both seats",
    "equally long to 0.04 mm": lambda d, _: (  # either rod's seats, on the balls of one jig, off by their play
        f"equally long to {2 * (d.forearm.seat_diameter_mm + 0.005 - d.forearm.ball_diameter_mm):.2g} mm"
    ),
    "6.010 goes in and turns": lambda d, _: f"{d.forearm.seat_diameter_mm - 0.005:.3f} goes in and turns",
    "Ø2.55 ±0.02, floor 0.9 past the ball's centre, eroded": ball,
    "at assembly; delivered SØ6 ±0.005": lambda d, _: (  # what lapping takes, 0.01 to 0.02, from memory
        f"at assembly; delivered SØ{d.forearm.seat_diameter_mm - 0.015:.3g} ±0.005"
    ),
    "its seat lapped with ball and paste to (6.015) and gauged": lambda d, _: (
        f"its seat lapped with ball and paste to ({d.forearm.seat_diameter_mm:.3f}) and gauged"
    ),
    "screws from below reach 11 at most": base_screws,
}
"""Words of the page that are a figure -> their calculation."""
ISO_286 = {(7, 18): 18, (7, 3): 10}
"""Grade and upper end of the range of diameter, mm -> standard tolerance, um, of ISO 286-1 by hand."""
NORMS = re.compile(
    r"EN AW-7075 T6|EN 485-2|EN 755-2|1\.4305 \(\+A\)|EN 10088-3|DIN 76-1|VDI 2230|\bG10\b|6g|Chain 0|from 0|^0 and|"
    r"ISO (965-1: 6H|13715|8015|6411-A1/2\.12|10074, 0\.025 mm|14405-1)"
)
"""Names of materials, norms, grades and places, in which a digit is no figure of the machine."""
DRAWN = {
    "position Ø0.15 A B C": "screws go in with it at all limits: the check of mating patterns holds",
    "surface Ra 0.8": "goes with the grade",
    "surface Ra 1.6": "goes with the grade",
    "R1.6": "a cutter's",
    "up to +0.2 inside": "a bearing's ring has it",
    "with a round bottom x 1.5 long": "the lug's wall",
    "0/-0.3": "the bond bears it; none longer goes into the jig",
}
"""Figures that are chosen, and why none is calculated."""


def uncalculated() -> list[str]:
    """Words of the page with a figure that nothing here calculates or gives a reason for."""
    figures = [wording for _, _, wording in rows() if re.search(r"\d", NORMS.sub("", wording))]
    return [wording for wording in figures if wording not in FIGURES and wording not in DRAWN]


def wrong(d: Dimensions, folder: Path) -> dict[str, str]:
    """Words of the page -> what is calculated of a build, where it is something else."""
    stated = {wording for _, _, wording in rows()}
    found = {wording: FIGURES[wording](d, folder) for wording in FIGURES if wording in stated}
    return {wording: figure for wording, figure in found.items() if figure != wording}


def faulty_columns(folder: Path) -> list[str]:
    """Rules that columns of figures break, of which the page names the column alone."""
    with (folder / "holes.csv").open(encoding="utf-8", newline="") as file:
        holes = list(csv.DictReader(file))
    threads = [row for row in holes if row["thread"]]
    faults = [  # ISO metric coarse threads: a tap drill is the nominal diameter less the pitch
        f"{row['thread']} is drilled {row['diameter_mm']}"
        for row in threads
        if not isclose(float(row["diameter_mm"]), float(row["thread"][1:]) - PITCH_MM[row["thread"]], abs_tol=0.051)
    ]
    faults += [
        f"{row['fit']} of {row['diameter_mm']} is from {row['lower_um']} to {row['upper_um']}"
        for row in holes
        if row["fit"].startswith("H") and not (float(row["lower_um"]) == 0.0 < float(row["upper_um"]))
    ]
    record = json.loads((folder / "tolerances.json").read_text(encoding="utf-8"))
    faults += [
        f"{one['part']}, {one['what']}: {one['largest_mm']} is less than is asked for"
        for chain in record["chains"]
        for one in chain["links"]
        if one.get("largest_mm", 1e9) < one["deviation_mm"][1] - 1e-5
    ]
    cost = json.loads((folder / "cost.json").read_text(encoding="utf-8"))
    for key in ("made_EUR", "bought_EUR"):
        totals = (
            [cost[key][count] for count in sorted(cost[key], key=int)] if isinstance(cost[key], dict) else cost[key]
        )
        faults += [f"{key} rises with the number of machines"] if sorted(totals, reverse=True) != list(totals) else []
    return faults


PITCH_MM = {"M2": 0.4, "M2.5": 0.45, "M3": 0.5, "M4": 0.7, "M5": 0.8, "M6": 1.0}


def test_each_question_is_there_once() -> None:
    questions = [question for question, _, _ in rows()]
    assert len(set(questions)) == len(questions) >= LEAST


def test_each_answer_stands_where_the_page_says(built: Built) -> None:
    assert missing(built.folder) == []


def test_each_figure_is_calculated_or_chosen_for_a_reason(built: Built, best_dimensions: Dimensions) -> None:
    assert uncalculated() == []
    assert set(FIGURES) | set(DRAWN) <= {wording for _, _, wording in rows()}
    assert wrong(best_dimensions, built.folder) == {}
    assert faulty_columns(built.folder) == []


def test_a_figure_that_is_another_is_noticed(built: Built, best_dimensions: Dimensions, tmp_path: Path) -> None:
    for name in ("tolerances.json", "holes.csv", "cost.json", "bom.csv"):
        text = (built.folder / name).read_text(encoding="utf-8")
        text = text.replace("0.025,", "0.03,").replace("0.025\n", "0.03\n") if name == "tolerances.json" else text
        (tmp_path / name).write_text(text.replace(",3.3,14.0,through,M4", ",3.5,14.0,through,M4"), encoding="utf-8")
    assert wrong(best_dimensions, tmp_path)["position Ø0.05 A B C"] == "position Ø0.06 A B C"
    assert "M4 is drilled 3.5" in faulty_columns(tmp_path)


@pytest.mark.slow
def test_the_machine_that_the_page_names_has_each_answer_and_drawings_without_a_fault(tmp_path: Path) -> None:
    assert main(["build", "--design", str(COMMITTED), "--out", str(tmp_path), "--no-report"]) == 0
    design = load_design(COMMITTED)
    assert missing(tmp_path / design.name) == []
    assert wrong(dimensions(design), tmp_path / design.name) == {}
    assert faulty_columns(tmp_path / design.name) == []


@pytest.mark.parametrize(
    ("file", "wording"),
    [
        ("drawings/pinion.pdf", "right-hand helical groove"),
        ("drawings/motor_cheek.svg", "position Ø0.04 A B C"),
        ("holes.csv", "colour"),
        ("checks.json", "dfm colours"),
        ("parts/pinion.step", "POSITION_TOLERANCE"),
    ],
)
def test_what_does_not_stand_there_is_noticed(built: Built, file: str, wording: str) -> None:
    assert not says(built.folder / file, wording)
