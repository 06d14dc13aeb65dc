"""Tolerances in the AP242 files of parts: in the text, read without the kernel, and by the kernel's reader."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.general import EDGES
from delta_cad.export.drawings.part.controlled import Controlled, controlled
from delta_cad.export.shop.pmi import GENERAL, toleranced
from delta_cad.export.step import write_part_step
from delta_cad.solids.part import Part
from tests.delta_cad.export.shop.reading import Entities, entities, of_kind, strings

# part -> fits as (letter, what, grade), threads, places, squares, coaxialities and datums, by hand from the drawing
DRAWN: dict[str, tuple[dict[tuple[str, str, str], int], int, int, int, int, str]] = {
    "upper_arm": (
        {("H", "hole", "7"): 3},
        0,
        2,
        1,
        0,
        "ABC",
    ),  # shoulder, dowels; the bar's bore has its own deviations
    "motor_cheek": ({("H", "hole", "7"): 5}, 0, 5, 1, 0, "ABC"),  # seat, pilot, stop pin, dowels; screws of both
    "encoder_cheek": ({("H", "hole", "6"): 1, ("H", "hole", "7"): 2}, 4, 2, 1, 0, "AB"),  # reamed in place; screws
    "foot_block": ({("H", "hole", "7"): 4}, 4, 5, 1, 0, "ABC"),  # both slots, dowel, threads below and across
    "sector": ({("G", "hole", "7"): 1, ("H", "hole", "7"): 2}, 0, 2, 1, 0, "ABC"),  # dowels, the slot's ends
    "pinion": ({("H", "hole", "7"): 1}, 2, 0, 0, 1, "A"),
    "platform": ({}, 1, 1, 0, 0, "A"),
    "shoulder_shaft": ({("h", "shaft", "6"): 1}, 1, 0, 1, 1, "A"),
    "cross_bar": ({("h", "shaft", "6"): 1, ("h", "shaft", "7"): 2}, 0, 0, 0, 1, "A"),
    "cup_shell": ({}, 0, 0, 0, 0, ""),
    "handle_stem": ({}, 2, 0, 0, 0, ""),
}
SQUARE_MM = defaultdict(float, motor_cheek=0.02, encoder_cheek=0.04, upper_arm=0.012)  # as loose as their chains bear
EDGES_OF = {"upper_arm": 1, "sector": 1, "pinion": 1, "cross_bar": 1}  # functional edges, by hand from the drawings
TWICE = {"pinion": 1, "cross_bar": 1, "handle_stem": 0}  # which of its rounds a part has at either end


def measures(found: Entities, texts: list[str]) -> list[float]:
    """The measures that instances refer to."""
    values = []
    for text in texts:
        for number in re.findall(r"#(\d+)", text):
            values += [float(v) for v in re.findall(r"_MEASURE\(([-+.\dE]+)\)", found[int(number)])]
    return values


@pytest.fixture(scope="module")
def held(best_dimensions: Dimensions) -> dict[str, Controlled]:
    return defaultdict(Controlled, controlled(best_dimensions))


@pytest.fixture(scope="module")
def files(
    best_assembly: Assembly, held: dict[str, Controlled], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pmi")
    parts = {part.number: part for part in best_assembly.parts}
    for number in DRAWN:
        write_part_step(parts[number], folder / f"{number}.step", held=held[number])
    return {number: folder / f"{number}.step" for number in DRAWN}


def the_part(assembly: Assembly, number: str) -> Part:
    return next(part for part in assembly.parts if part.number == number)


@pytest.mark.parametrize("number", DRAWN)
def test_the_text_says_what_the_drawing_asks(
    number: str, files: dict[str, Path], best_assembly: Assembly, held: dict[str, Controlled]
) -> None:
    fits, threads, places, squares, coaxialities, datums = DRAWN[number]
    found, part, required = entities(files[number]), the_part(best_assembly, number), held[number]
    said = [tuple(strings(text)) for text in of_kind(found, "LIMITS_AND_FITS")]
    assert {fit: said.count((*fit, "")) for fit in fits} == fits
    assert len(said) == sum(fits.values())
    made = [*required.rounds, *([required.rounds[TWICE[number]]] if number in TWICE else [])]
    rounds = [one for one in made if number != "sector"]
    lengths = [length.tolerance_mm for length in (*required.lengths, *required.depths)]
    assert len(of_kind(found, "DIMENSIONAL_SIZE")) == len(toleranced(part)) + len(made)
    slots = [slot for hole in part.holes for slot in hole.slots]
    assert len(slots) == {"foot_block": 2}.get(number, 0)
    assert len(of_kind(found, "DIMENSIONAL_LOCATION")) == len(lengths) + len(slots)
    limits = of_kind(found, "TOLERANCE_VALUE")
    expected = [um / 1000 for bore in toleranced(part) for um in bore.deviations_um or ()]
    expected += [mm for one in rounds for mm in one.deviations_mm or ()] + [
        sign * t for t in lengths for sign in (-1, 1)
    ]
    expected += [limit for _ in slots for limit in (0.0, 0.010)]  # 3 H7
    expected += [-0.05, 0.05] if number == "sector" else []  # of its rim's radius
    assert sorted(measures(found, limits)) == pytest.approx(sorted(expected), abs=1e-12)
    counts = [len(of_kind(found, f"{kind}_TOLERANCE")) for kind in ("POSITION", "PERPENDICULARITY", "COAXIALITY")]
    assert counts == [places, squares, coaxialities]
    assert "RUNOUT" not in files[number].read_text()
    named = {int(n) for text in found.values() for n in re.findall(r"#(\d+)", re.sub(r"'[^']*'", "", text))}
    assert named <= found.keys()  # nothing refers to what was taken out
    letters = {strings(text)[-1] for text in of_kind(found, "DATUM")}
    assert letters == set(datums)
    reported = [text for one in of_kind(found, "DESCRIPTIVE_REPRESENTATION_ITEM") for text in [strings(one)] if text]
    assert sum(text[0] == "thread" for text in reported) == threads
    notes = {text[0]: text[1] for text in reported}
    assert {key: notes[key] for key in GENERAL} == GENERAL
    assert notes["material"] == part.material.name
    assert notes["remark"] == part.description
    edges = {key: text for key, text in notes.items() if key.startswith("edge ")}
    assert len(edges) == EDGES_OF.get(number, 0)
    assert set(edges.values()) == {edge.text for edge in required.edges}


def test_a_slots_width_lies_between_its_long_sides(files: dict[str, Path]) -> None:
    """The width is that of the pin, 3 mm, with the deviations of H7 up to 3 mm, read back by the kernel."""
    from OCP.TDF import TDF_LabelSequence
    from OCP.XCAFDoc import XCAFDoc_Dimension

    document, tool = read(files["foot_block"])
    assert document is not None
    sizes = TDF_LabelSequence()
    tool.GetDimensionLabels(sizes)
    read_back = [XCAFDoc_Dimension.Set_s(sizes.Value(k)).GetObject() for k in range(1, sizes.Length() + 1)]
    widths = [one for one in read_back if one.GetType().name.endswith("Location_LinearDistance")]
    widths = [one for one in widths if abs(one.GetValue() - 3.0) < 1e-9]
    assert len(widths) == 2
    for one in widths:
        assert (one.GetUpperTolValue(), abs(one.GetLowerTolValue())) == pytest.approx((0.010, 0.0))


def test_drawing_and_step_leave_inner_edges_no_rounder_than_any_bearing_s_corner() -> None:
    """A ring that stands on a fillet wider than its own corner does not reach its shoulder."""
    assert GENERAL["edges"] == EDGES
    inside = float(re.search(r"up to \+([\d.]+) inside", EDGES)[1])  # type: ignore[index]
    known = [row.fillet_max_mm for row in catalogue.bearing.rows.values() if row.fillet_max_mm is not None]
    assert inside <= min(known)


def test_the_kernel_still_states_grades_two_too_high(
    best_assembly: Assembly, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A kernel that is mended must be noticed: then `mend_tolerances` goes."""
    monkeypatch.setattr("delta_cad.export.step.mend_tolerances", lambda _: None)
    write_part_step(the_part(best_assembly, "pinion"), tmp_path / "p.step")
    (fit,) = of_kind(entities(tmp_path / "p.step"), "LIMITS_AND_FITS")
    assert strings(fit)[2] == "9"


def read(path: Path) -> Any:
    """The kernel's tool for dimensions and tolerances of a file."""
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document, reader = TDocStd_Document(TCollection_ExtendedString("MDTV-XCAF")), STEPCAFControl_Reader()
    reader.SetGDTMode(True)
    reader.ReadFile(str(path))
    assert reader.Transfer(document)
    return document, XCAFDoc_DocumentTool.DimTolTool_s(document.Main())


@pytest.mark.parametrize("number", ["encoder_cheek", "upper_arm"])
def test_a_reader_gets_values_and_deviations_back(
    number: str, files: dict[str, Path], best_assembly: Assembly, held: dict[str, Controlled]
) -> None:
    from OCP.TDF import TDF_LabelSequence
    from OCP.XCAFDoc import XCAFDoc_Dimension, XCAFDoc_GeomTolerance

    document, tool = read(files[number])
    assert document is not None  # its labels live as long as it does
    sizes, zones = TDF_LabelSequence(), TDF_LabelSequence()
    tool.GetDimensionLabels(sizes)
    tool.GetGeomToleranceLabels(zones)
    got = []
    for k in range(1, sizes.Length() + 1):
        size = XCAFDoc_Dimension.Set_s(sizes.Value(k)).GetObject()  # the one that is there
        deviations = (size.GetLowerTolValue(), size.GetUpperTolValue()) if size.IsDimWithPlusMinusTolerance() else ()
        got.append((round(size.GetValue(), 6), *(round(abs(v), 6) for v in deviations)))
    required = [
        (round(b.diameter_mm, 6), *(round(abs(um) / 1000, 6) for um in b.deviations_um or ()))
        for b in toleranced(the_part(best_assembly, number))
    ]
    lengths = [*held[number].lengths, *held[number].depths]
    required += [(round(abs(one.end_mm - one.start_mm), 6), one.tolerance_mm, one.tolerance_mm) for one in lengths]
    assert sorted(got) == sorted(required)
    values = []
    for k in range(1, zones.Length() + 1):
        values.append(round(XCAFDoc_GeomTolerance.Set_s(zones.Value(k)).GetObject().GetValue(), 6))
    places = {
        "encoder_cheek": [0.1, 0.2],
        "upper_arm": [0.05, 0.05],
    }  # of screws; of dowels before they are reamed, bar
    assert sorted(values) == sorted(
        [SQUARE_MM[number]] * DRAWN[number][3] + places.get(number, [0.05] * DRAWN[number][2])
    )


def test_files_are_the_same_bytes_and_other_schemas_and_bought_parts_have_none(
    best_assembly: Assembly, files: dict[str, Path], held: dict[str, Controlled], tmp_path: Path
) -> None:
    arm = the_part(best_assembly, "upper_arm")
    write_part_step(arm, tmp_path / "again.step", held=held["upper_arm"])
    assert (tmp_path / "again.step").read_bytes() == files["upper_arm"].read_bytes()
    write_part_step(arm, tmp_path / "old.step", "AP214")
    write_part_step(replace(arm, make=False), tmp_path / "bought.step")
    for name in ("old", "bought"):
        found = entities(tmp_path / f"{name}.step")
        assert of_kind(found, "DIMENSIONAL_SIZE") + of_kind(found, "GENERAL_PROPERTY") == []
