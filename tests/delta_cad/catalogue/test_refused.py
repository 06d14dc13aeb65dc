"""Files of the catalogue that are refused: a good one with one thing wrong."""

from __future__ import annotations

import csv
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from delta_cad import catalogue
from delta_cad.catalogue import FAMILIES, CatalogueError, Magnet
from delta_cad.catalogue.reader import DATA, read_family


def magnets(tmp_path: Path, **cells: str) -> Path:
    """The magnet file with some cells of its second row changed."""
    with (DATA / "magnets.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    rows[1] |= cells
    path = tmp_path / "magnets.csv"
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    return path


def test_a_good_copy_is_read(tmp_path: Path) -> None:
    assert read_family(magnets(tmp_path), Magnet) == catalogue.family("magnet")


@pytest.mark.parametrize(
    ("column", "cell"),
    [
        *(("mass_g", cell) for cell in ("0", "-1", "nan", "inf", "light", "", "1e-13", "1e13")),
        ("source", ""),
        *(("id", cell) for cell in ("ndfeb-6x2.5-diametric", "a b")),
        ("verified", "yes"),
    ],
)
def test_a_row_that_cannot_be_true_is_refused(column: str, cell: str, tmp_path: Path) -> None:
    with pytest.raises(CatalogueError) as caught:
        read_family(magnets(tmp_path, **{column: cell}), Magnet)
    assert str(caught.value).startswith(f"magnets.csv line 3: {column} = {cell!r}: ")


@pytest.mark.parametrize(
    ("name", "column", "cell"),
    [
        ("motors.csv", "mount_count", "4.0"),
        ("motors.csv", "mount_count", "0"),
        ("motors.csv", "drives", "capstan;"),
        ("motors.csv", "max_winding_temperature_C", "-5"),
        ("motors.csv", "cogging_torque_N_m", "-1"),
        ("bearings.csv", "ball_count", "7.5"),
        ("fasteners/screws.csv", "lengths_mm", "5;4"),
        ("fasteners/screws.csv", "lengths_mm", "4;4"),
        ("materials.csv", "red", "-0.1"),
        ("feet.csv", "diameter_mm", "1e-320"),
        ("encoders.csv", "board_length_mm", "1e-200"),
    ],
)
def test_a_cell_that_is_not_what_its_field_says_is_refused(name: str, column: str, cell: str, tmp_path: Path) -> None:
    family = next(family for family in FAMILIES.values() if family.file == name)
    with (DATA / name).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    rows[0][column] = cell
    path = tmp_path / Path(name).name
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    with pytest.raises(CatalogueError) as caught:
        read_family(path, family.record)
    assert str(caught.value).startswith(f"{path.name} line 2: {column} = {cell!r}: ")


@pytest.mark.parametrize(
    ("family", "cells", "words"),
    [
        ("motor", {"drives": "capstan;belt"}, "drives = capstan;belt"),
        ("motor", {"shaft_diameter_mm": 100.0}, "shaft_diameter_mm < pilot_diameter_mm"),
        ("bearing", {"outer_mm": 9.0}, "outer_ring_inner_mm < outer_mm"),
        ("encoder", {"air_gap_min_mm": 9.0}, "air_gap_min_mm < air_gap_max_mm"),
        ("encoder", {"board_width_mm": 99.0}, "board_width_mm <= board_length_mm"),
        ("motor", {"peak_torque_N_m": 0.001}, "peak_torque_N_m = 0.001"),
        ("motor", {"max_radial_load_N": ""}, "both or neither"),
        ("bearing", {"ball_diameter_mm": 4.0}, "2 ball_diameter_mm < outer_mm - bore_mm"),
        ("bearing", {"fillet_max_mm": 0.1}, "fillet_max_mm >= 0.2: drawings leave inner edges so round"),
        ("magnet", {"price_EUR": 2.0}, "price_source"),
        ("adhesive", {"kind": "glue"}, "kind = glue"),
        ("tension_spring", {"wire_mm": 6.0}, "wire_mm < mean_diameter_mm"),
        ("tension_spring", {"length_max_mm": 6.0}, "free_length_mm < length_max_mm"),
        ("tension_spring", {"initial_tension_N": 60.0}, "initial_tension_N < force_max_N"),
        ("wave_spring", {"inner_mm": 16.0}, "inner_mm < housing_mm"),
        ("wave_spring", {"work_height_mm": 3.0}, "work_height_mm < free_height_mm"),
        ("tube", {"inner_mm": 99.0}, "inner_mm < outer_mm"),
        ("foot", {"stud_length_mm": "", "hole_diameter_mm": ""}, "either stud_length_mm or hole_diameter_mm"),
        ("foot", {"stud_length_mm": 5.0, "hole_diameter_mm": 4.0}, "either stud_length_mm or hole_diameter_mm"),
    ],
)
def test_fields_that_contradict_each_other_are_refused(
    family: str, cells: dict[str, Any], words: str, tmp_path: Path
) -> None:
    path = tmp_path / Path(FAMILIES[family].file).name
    with (DATA / FAMILIES[family].file).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerow(rows[0] | cells)
    with pytest.raises(CatalogueError, match=rf"{path.name} line 2: .*{words}"):
        read_family(path, FAMILIES[family].record)


def test_a_file_with_other_columns_or_cells_is_refused(tmp_path: Path) -> None:
    header = ",".join(field.name for field in fields(Magnet))
    path = tmp_path / "magnets.csv"
    for text, words in (
        ("id,mass\n", r"mass_g.*\['mass'\]"),
        ("", "mass_g"),
        (header + ",id\n", "magnets.csv: "),
        (header + "\na,b\n", "line 2: .*12"),
        (header + "\n" + ",".join("x" * 13) + "\n", "line 2: .*12"),
        (header + '\n"a"b\n', "magnets.csv: "),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(CatalogueError, match=words):
            read_family(path, Magnet)
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(CatalogueError, match=r"^magnets\.csv: "):
        read_family(path, Magnet)
    with pytest.raises(CatalogueError, match=r"^none\.csv: "):
        read_family(tmp_path / "none.csv", Magnet)
