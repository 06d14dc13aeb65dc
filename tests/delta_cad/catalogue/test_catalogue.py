"""The catalogue: what its rows claim must be possible, agree with each other, and say where it comes from."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable
from dataclasses import FrozenInstanceError, fields
from pathlib import Path
from typing import Any

import pytest

from delta_cad import catalogue
from delta_cad.catalogue import FAMILIES, CatalogueError, CatalogueRow, Magnet, MaterialData, Motor, Screw
from delta_cad.catalogue.reader import read_family

ROOT = Path(catalogue.__file__).parent / "data"
MOTORS = [catalogue.motor(key) for key in catalogue.family("motor")]
EACH_MOTOR = pytest.mark.parametrize("motor", MOTORS, ids=lambda motor: motor.id)
ACCESS: dict[str, Callable[[str], CatalogueRow]] = {
    "motor": catalogue.motor,
    "bearing": catalogue.bearing,
    "encoder": catalogue.encoder,
    "screw": catalogue.screw,
    "hex_screw": catalogue.hex_screw,
    "hex_nut": catalogue.hex_nut,
    "dowel": catalogue.dowel,
    "tube": catalogue.tube,
    "knob": catalogue.knob,
    "foot": catalogue.foot,
    "magnet": catalogue.magnet,
    "cable": catalogue.cable,
    "material": catalogue.material,
}


@pytest.mark.parametrize("name", FAMILIES)
def test_every_row_is_reached_by_its_id_and_says_its_source(name: str) -> None:
    rows = catalogue.family(name)
    assert len(rows) >= 2
    for key, row in rows.items():
        assert ACCESS[name](key) is row
        assert type(row) is FAMILIES[name].record
        assert row.id == key
        assert row.source
        assert row.description
        assert re.match(r"yes: |partly: .*no, from memory, check before ordering$|no, from memory", row.verified)


@pytest.mark.parametrize("name", FAMILIES)
def test_an_unknown_id_lists_the_legal_ones(name: str) -> None:
    with pytest.raises(CatalogueError) as caught:
        ACCESS[name]("unobtainium")
    for key in catalogue.family(name):
        assert key in str(caught.value)


def test_an_unknown_family_lists_the_legal_ones() -> None:
    with pytest.raises(CatalogueError, match=r"gears.*motor, bearing"):
        catalogue.family("gears")


def test_every_csv_file_is_a_family() -> None:
    assert {path.name for path in ROOT.glob("*.csv")} == {family.file for family in FAMILIES.values()}
    assert set(FAMILIES) == set(ACCESS)


def test_records_are_frozen_and_families_read_only() -> None:
    with pytest.raises(FrozenInstanceError):
        MOTORS[0].mass_g = 1.0  # pyright: ignore[reportAttributeAccessIssue]
    with pytest.raises(TypeError):
        catalogue.family("motor")["x"] = MOTORS[0]  # pyright: ignore[reportIndexIssue]


# Motors


def test_both_drives_have_a_choice() -> None:
    assert sum("capstan" in motor.drives for motor in MOTORS) >= 3
    assert sum("direct" in motor.drives for motor in MOTORS) >= 2
    assert {drive for motor in MOTORS for drive in motor.drives} == {"capstan", "direct"}


@EACH_MOTOR
def test_stall_torque_follows_from_voltage_resistance_and_torque_constant(motor: Motor) -> None:
    expected = motor.torque_constant_N_m_A * motor.nominal_voltage_V / motor.resistance_ohm
    # makers round R and k to 3 digits (1 %) and some take the motor's friction off (up to 4.5 % here)
    assert motor.stall_torque_N_m == pytest.approx(expected, rel=0.05)


@EACH_MOTOR
def test_the_continuous_current_heats_the_winding_to_no_more_than_its_limit(motor: Motor) -> None:
    inner, outer = motor.thermal_resistance_winding_housing_K_W, motor.thermal_resistance_housing_ambient_K_W
    if inner is None or outer is None or motor.max_winding_temperature_C is None:
        assert motor.thermal_resistance_winding_housing_K_W is motor.thermal_resistance_housing_ambient_K_W is None
        return
    current = motor.nominal_torque_N_m / motor.torque_constant_N_m_A
    copper = 1.0 + 0.0039 * (motor.max_winding_temperature_C - 25.0)  # resistance of hot copper
    rise = (inner + outer) * copper * motor.resistance_ohm * current**2
    allowed = motor.max_winding_temperature_C - 25.0
    # the makers' figure holds at nominal speed: iron and brush losses leave 50 to 100 % of the rise to the copper;
    # 10 % over is the rounding of torque, resistance and thermal resistances
    assert 0.45 * allowed < rise < 1.10 * allowed


@EACH_MOTOR
def test_the_peak_torque_is_short_and_bounded(motor: Motor) -> None:
    assert motor.nominal_torque_N_m < motor.peak_torque_N_m < 0.6 * motor.stall_torque_N_m
    assert motor.peak_torque_N_m <= 3.01 * motor.nominal_torque_N_m  # 3 x, rounded to 3 digits
    inner, time = motor.thermal_resistance_winding_housing_K_W, motor.thermal_time_constant_winding_s
    if inner is None or time is None:
        return
    current = motor.peak_torque_N_m / motor.torque_constant_N_m_A
    rise = inner * motor.resistance_ohm * current**2 * (1.0 - math.exp(-motor.peak_time_s / time))
    assert rise < 40.0  # K, what `peak_reason` promises


@EACH_MOTOR
def test_the_rotor_inertia_is_that_of_a_rotor_inside_the_motor(motor: Motor) -> None:
    radius = motor.diameter_mm / 2000.0
    assert 0.01 < motor.rotor_inertia_kg_m2 / (motor.mass_g / 1000.0 * radius**2) < 0.5


@EACH_MOTOR
def test_the_mechanical_time_constant_is_that_of_a_servo_motor(motor: Motor) -> None:
    """R J / k^2 between 2 and 15 ms; a wrong power of ten in J, R or k leaves this range."""
    assert 0.002 < motor.resistance_ohm * motor.rotor_inertia_kg_m2 / motor.torque_constant_N_m_A**2 < 0.015


@EACH_MOTOR
def test_the_motor_has_the_density_of_a_motor(motor: Motor) -> None:
    volume = math.pi / 4.0 * motor.diameter_mm**2 * motor.length_mm / 1000.0  # cm^3
    assert 2.0 < motor.mass_g / volume < 8.0  # flat motors are open, solid steel is 7.9


@EACH_MOTOR
def test_the_mounting_face_has_room_for_pilot_holes_and_shaft(motor: Motor) -> None:
    thread = catalogue.screw(motor.mount_thread).diameter_mm
    assert motor.shaft_diameter_mm < motor.pilot_diameter_mm
    assert motor.pilot_diameter_mm + thread < motor.mount_circle_mm < motor.diameter_mm - thread
    assert motor.pilot_height_mm < motor.shaft_length_mm
    assert 2 <= motor.mount_count <= 8


def test_the_default_motor_is_what_two_sources_say() -> None:
    """PR2 driver source and the IEEE figures of the feasibility study: 25.9 mN m/A, 0.611 ohm, 85 mN m."""
    motor = catalogue.motor("maxon-re30-310007")
    assert (motor.torque_constant_N_m_A, motor.resistance_ohm) == (0.0259, 0.611)
    assert motor.nominal_torque_N_m == pytest.approx((3.44 - 0.16) * 0.0259, rel=0.002)  # rounded to 85.0 mN m
    assert (motor.diameter_mm, motor.length_mm) == (30.0, 68.0)


# The other families


@pytest.mark.parametrize("key", catalogue.family("bearing"))
def test_bearings_nest_and_weigh_what_steel_weighs(key: str) -> None:
    b = catalogue.bearing(key)
    assert b.bore_mm < b.shaft_shoulder_min_mm < b.inner_ring_outer_mm < b.outer_ring_inner_mm
    assert b.outer_ring_inner_mm < b.outer_mm
    assert b.inner_ring_outer_mm < b.housing_shoulder_max_mm < b.outer_mm
    ring = math.pi / 4.0 * (b.outer_mm**2 - b.bore_mm**2) * b.width_mm * 7.85e-3  # g, if it were solid
    assert 0.5 < b.mass_g / ring < 0.9
    assert 0.25 < b.static_load_N / b.dynamic_load_N < 0.5  # deep groove


@pytest.mark.parametrize("key", catalogue.family("screw"))
def test_screws_follow_the_rules_of_their_standards(key: str) -> None:
    s = catalogue.screw(key)
    assert key == f"M{s.diameter_mm:g}"
    assert s.head_height_mm == s.diameter_mm  # ISO 4762: k = d
    assert s.tap_drill_mm == pytest.approx(
        s.diameter_mm - s.pitch_mm, abs=0.0501
    )  # drills come in steps of 0.05 to 0.1 mm
    assert s.diameter_mm < s.clearance_hole_mm <= 1.2 * s.diameter_mm
    assert s.clearance_hole_mm < s.head_diameter_mm < s.counterbore_diameter_mm
    buried = s.counterbore_depth_mm - s.head_height_mm  # DIN 974-1: 0.3 to 0.4 mm below M6, 0.6 mm from there on
    assert buried == pytest.approx(0.35 if s.diameter_mm < 6.0 else 0.6, abs=0.051)
    assert s.socket_depth_mm < s.head_height_mm
    assert s.socket_mm * 2.0 / math.sqrt(3.0) < s.head_diameter_mm


def test_screw_sizes_are_those_of_the_standard() -> None:
    m3 = catalogue.screw("M3")
    assert isinstance(m3, Screw)
    sizes = (m3.head_diameter_mm, m3.socket_mm, m3.clearance_hole_mm, m3.tap_drill_mm, m3.pitch_mm)
    assert sizes == (5.5, 2.5, 3.4, 2.5, 0.5)
    assert m3.lengths_mm[:3] == (5.0, 6.0, 8.0)


@pytest.mark.parametrize("family", ["hex_screw", "hex_nut"])
def test_hexagon_screws_and_nuts_go_with_the_cap_screws(family: str) -> None:
    for key, row in catalogue.family(family).items():
        cap = catalogue.screw(key)
        assert isinstance(row, catalogue.HexScrew | catalogue.HexNut)
        assert (row.diameter_mm, row.tap_drill_mm) == (cap.diameter_mm, cap.tap_drill_mm)
        assert row.across_flats_mm > 1.5 * row.diameter_mm  # the spanner turns the head, not the thread


def test_dowels_come_in_three_sizes() -> None:
    dowels = [catalogue.dowel(key) for key in ("3", "4", "5")]
    assert [d.diameter_mm for d in dowels] == [3.0, 4.0, 5.0]
    assert all(d.chamfer_mm < d.diameter_mm / 4.0 < d.lengths_mm[0] for d in dowels)


def test_parts_name_materials_and_partners_that_exist() -> None:
    for key in catalogue.family("tube"):
        tube = catalogue.tube(key)
        assert catalogue.material(tube.material).density_kg_m3 > 0.0
        assert 0.5 <= (tube.outer_mm - tube.inner_mm) / 2.0 <= 1.5
    for key in catalogue.family("encoder"):
        encoder = catalogue.encoder(key)
        assert isinstance(catalogue.magnet(encoder.magnet), Magnet)
        assert encoder.air_gap_min_mm < encoder.air_gap_max_mm
        assert encoder.hole_spacing_length_mm + encoder.hole_diameter_mm < encoder.board_length_mm
        assert (
            encoder.hole_spacing_width_mm + encoder.hole_diameter_mm < encoder.board_width_mm < encoder.board_length_mm
        )
        assert encoder.counts_per_turn == 2**14


def test_magnets_weigh_what_neodymium_weighs() -> None:
    density = catalogue.material("ndfeb").density_kg_m3
    for key in catalogue.family("magnet"):
        m = catalogue.magnet(key)
        mass = math.pi / 4.0 * m.diameter_mm**2 * m.thickness_mm * density * 1e-6
        assert m.mass_g == pytest.approx(mass, rel=0.01)  # written with two digits


def test_knobs_are_balls_with_a_flat_foot() -> None:
    for key in catalogue.family("knob"):
        k = catalogue.knob(key)
        assert k.height_mm < k.diameter_mm
        chord = 2.0 * math.sqrt(k.diameter_mm**2 / 4.0 - (k.height_mm - k.diameter_mm / 2.0) ** 2)
        assert k.foot_diameter_mm <= chord + 3.0  # a short neck may stand out of the ball, never by more than 1.5 mm
        assert k.thread_depth_mm < k.height_mm
        assert float(k.thread.removeprefix("M")) < k.foot_diameter_mm
        ball = math.pi / 6.0 * k.diameter_mm**3 * catalogue.material("pf31").density_kg_m3 * 1e-6
        assert 0.5 * ball < k.mass_g < 1.1 * ball


def test_feet_have_a_stud_or_a_hole() -> None:
    for key in catalogue.family("foot"):
        f = catalogue.foot(key)
        assert (f.stud_length_mm is None) != (f.hole_diameter_mm is None)
        assert catalogue.screw(f.thread).diameter_mm <= (f.hole_diameter_mm or f.diameter_mm / 2.0)


def test_cables_are_as_strong_as_stranded_steel() -> None:
    for key in catalogue.family("cable"):
        c = catalogue.cable(key)
        area = math.pi / 4.0 * c.diameter_mm**2  # mm^2 of the circle around the rope
        assert 600.0 < c.breaking_load_N / area < 1200.0  # N/mm^2: half to two thirds metal of 1500 to 1800 N/mm^2
        assert 0.5 < c.mass_g_m / (area * 7.9) < 0.75  # fill of the circle
        assert c.construction in {"7x7", "7x19"}
    assert catalogue.cable("steel-0.54-7x7").breaking_load_N == pytest.approx(16.0 * 9.81, rel=0.005)  # 16 kg, rounded


def test_materials_are_in_SI_and_have_a_colour() -> None:
    for key in catalogue.family("material"):
        m = catalogue.material(key)
        assert isinstance(m, MaterialData)
        assert 900.0 < m.density_kg_m3 < 9000.0
        assert 1e6 < m.youngs_modulus_Pa < 2.2e11
        assert all(0.0 <= channel <= 1.0 for channel in m.colour)
        if m.yield_strength_Pa is not None:
            assert 1e-4 < m.yield_strength_Pa / m.youngs_modulus_Pa < 0.05  # strain at yield
    assert {"aluminium-7075", "aluminium-6082", "aluminium-black", "stainless-1.4305", "steel", "pom-c", "pa12"} <= set(
        catalogue.family("material")
    )
    assert {"cfrp", "rubber", "fr4", "ndfeb"} <= set(catalogue.family("material"))


# Bad files: a copy of the magnets with one thing wrong


def magnets(tmp_path: Path, **cells: str) -> Path:
    """The magnet file with some cells of its second row changed."""
    with (ROOT / "magnets.csv").open(encoding="utf-8", newline="") as file:
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
        *(("mass_g", cell) for cell in ("0", "-1", "nan", "inf", "light", "")),
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
        ("screws.csv", "lengths_mm", "5;4"),
        ("screws.csv", "lengths_mm", "4;4"),
        ("materials.csv", "red", "-0.1"),
    ],
)
def test_a_cell_that_is_not_what_its_field_says_is_refused(name: str, column: str, cell: str, tmp_path: Path) -> None:
    family = next(family for family in FAMILIES.values() if family.file == name)
    with (ROOT / name).open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    rows[0][column] = cell
    path = tmp_path / name
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    with pytest.raises(CatalogueError) as caught:
        read_family(path, family.record)
    assert str(caught.value).startswith(f"{name} line 2: {column} = {cell!r}: ")


@pytest.mark.parametrize(
    ("family", "cells", "words"),
    [
        ("motor", {"drives": "capstan;belt"}, "drives = capstan;belt"),
        ("motor", {"shaft_diameter_mm": 100.0}, "shaft_diameter_mm < pilot_diameter_mm"),
        ("bearing", {"outer_mm": 9.0}, "outer_ring_inner_mm < outer_mm"),
        ("encoder", {"air_gap_min_mm": 9.0}, "air_gap_min_mm < air_gap_max_mm"),
        ("encoder", {"board_width_mm": 99.0}, "board_width_mm <= board_length_mm"),
        ("tube", {"inner_mm": 99.0}, "inner_mm < outer_mm"),
        ("foot", {"stud_length_mm": "", "hole_diameter_mm": ""}, "either stud_length_mm or hole_diameter_mm"),
        ("foot", {"stud_length_mm": 5.0, "hole_diameter_mm": 4.0}, "either stud_length_mm or hole_diameter_mm"),
    ],
)
def test_fields_that_contradict_each_other_are_refused(
    family: str, cells: dict[str, Any], words: str, tmp_path: Path
) -> None:
    path = tmp_path / FAMILIES[family].file
    with (ROOT / path.name).open(encoding="utf-8", newline="") as file:
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
        (header + "\na,b\n", "line 2: .*10"),
        (header + "\n" + ",".join("x" * 11) + "\n", "line 2: .*10"),
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
