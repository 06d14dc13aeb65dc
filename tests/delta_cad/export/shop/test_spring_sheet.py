"""Sheets of springs: what stands in them is what loads and rates are computed with, and nothing lies over anything."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.export.bom import bill_of_materials
from delta_cad.export.drawings.checker import sheet_faults
from delta_cad.export.drawings.sheet_io.sheet import Drawing
from delta_cad.export.drawings.spring_sheet import spring_drawing
from delta_cad.export.drawings.write import titles_of
from delta_cad.solids.part import Part
from delta_cad.structure.strength import allowables
from tests.delta_cad.export.machine import unit_masses

SPRINGS = ("rod_spring", "wave_spring")


def part(assembly: Assembly, number: str) -> Part:
    return next(one for one in assembly.parts if one.number == number)


def sheet_of(d: Dimensions, assembly: Assembly, number: str) -> Drawing:
    one = part(assembly, number)
    found = spring_drawing(d, one, titles_of(d, one, 6, "1 g"))
    assert found is not None
    return found


def table(drawing: Drawing) -> dict[str, str]:
    """The rows of a sheet: what, and its value with all its lines."""
    (sheet,) = drawing.sheets
    left, low, _, high = sheet.frames["table"]
    texts = [text for text in sheet.texts if left <= text.at[0] and low <= text.at[1] <= high]
    names = sorted((text for text in texts if text.at[0] == texts[0].at[0]), key=lambda text: -text.at[1])
    ends = [name.at[1] for name in names[1:]] + [-1.0]
    values = [text for text in texts if text not in names]
    return {
        name.text: " ".join(value.text for value in values if end + 0.1 < value.at[1] <= name.at[1] + 0.1)
        for name, end in zip(names, ends, strict=True)
    }


def first(text: str) -> float:
    match = re.search(r"\d+(\.\d+)?", text)
    assert match is not None
    return float(match[0])


def stated(rows: dict[str, str], name: str) -> tuple[float, float]:
    """Height or length, mm, and load, N, of the row whose name begins so."""
    (key,) = [one for one in rows if one.startswith(f"{name} at ")]
    return float(key.rpartition(" ")[2]), first(rows[key])


def test_loads_of_a_tension_spring_follow_from_its_wire(best_dimensions: Dimensions, best_assembly: Assembly) -> None:
    """EN 13906-2 by hand, from the wire, the diameter and the coils that the sheet states."""
    rows = table(sheet_of(best_dimensions, best_assembly, "rod_spring"))
    wire, outer = float(rows["Wire"].rpartition(" ")[2]), first(rows["Outside diameter De"])
    coils, free = first(rows["Active coils n"]), first(rows["Free length L0 inside the loops"])
    rate = 81500.0 * wire**4 / (8.0 * (outer - wire) ** 3 * coils)
    assert first(rows["Rate R"]) == pytest.approx(rate, rel=2e-3)
    for name in ("Load F1", "Load F2"):
        length, load = stated(rows, name)
        assert load == pytest.approx(first(rows["Initial tension F0"]) + rate * (length - free), abs=0.02)
        assert "±10 %" in next(value for key, value in rows.items() if key.startswith(name))
    joint = best_dimensions.forearm.joint
    assert stated(rows, "Load F1")[1] == pytest.approx(joint.spring_N, abs=0.01)
    assert allowables(best_dimensions).preload_reserve_N == pytest.approx(0.1 * joint.preload_N)


def test_loads_of_a_wave_spring_keep_the_preload(best_dimensions: Dimensions, best_assembly: Assembly) -> None:
    """By the usual formula from the strip that it states; at its largest height no less than loads count with."""
    rows = table(sheet_of(best_dimensions, best_assembly, "wave_spring"))
    thick, waves = float(rows["Strip"].rpartition(" ")[2]), first(rows["Waves"])
    outer, inner = first(rows["Outside diameter De, unloaded"]), first(rows["Inside diameter Di"])
    mean, width = (outer + inner) / 2.0, (outer - inner) / 2.0
    rate = 193e3 * width * thick**3 * waves**4 * outer / (3.88 * mean**3 * inner)
    assert first(rows["Rate R"]) == pytest.approx(rate, rel=0.02)
    free = first(rows["Free height L0"])
    (work, load), (high, least), (low, most) = (stated(rows, name) for name in ("Load F", "Load F1", "Load F2"))
    assert low < work < high < free
    assert load == pytest.approx(rate * (free - work), rel=0.02)
    assert least == pytest.approx(allowables(best_dimensions).preload_N, abs=0.005)
    assert most == pytest.approx(1.2 * rate * (free - low), rel=0.02)
    assert rows["Rate R"].split(",")[0].endswith("+20/0 %")


@pytest.mark.parametrize("row", [*catalogue.tension_spring.rows.values(), *catalogue.wave_spring.rows.values()])
def test_the_sheet_of_every_spring_of_the_catalogue_is_sound(
    row: catalogue.TensionSpring | catalogue.WaveSpring, best_dimensions: Dimensions, best_assembly: Assembly
) -> None:
    assert row.to_drawing
    d = best_dimensions
    if isinstance(row, catalogue.TensionSpring):
        d = replace(d, forearm=replace(d.forearm, spring=row))
    else:
        d = replace(d, preload=row)
    drawing = sheet_of(d, best_assembly, SPRINGS[isinstance(row, catalogue.WaveSpring)])
    assert [fault for sheet in drawing.sheets for fault in sheet_faults(sheet)] == []


def test_what_nobody_has_in_stock_is_made_and_what_a_maker_sells_is_bought(
    best_assembly: Assembly,
) -> None:
    kinds = {row.part_number: row.make_or_buy for row in bill_of_materials(best_assembly, unit_masses(best_assembly))}
    drawn = {"encoder_board", "crimp_sleeve", *SPRINGS}
    assert {kinds[number] for number in drawn} == {"make"}
    assert {one.number for one in best_assembly.parts if one.to_drawing} == drawn
    assert not catalogue.encoder("as5048a-board").to_drawing
    sold = replace(catalogue.tension_spring("0.6x5.6-21"), maker="maker", order_code="article 12")
    assert not sold.to_drawing
