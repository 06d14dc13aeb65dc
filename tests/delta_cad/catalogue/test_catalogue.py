"""The catalogue: what its rows claim must be possible, agree with each other, and say where it comes from."""

from __future__ import annotations

import math
import re
from dataclasses import FrozenInstanceError, replace
from pathlib import Path

import pytest

from delta_cad import catalogue
from delta_cad.catalogue import FAMILIES, CatalogueError, Magnet, MaterialData, Motor, Screw
from delta_cad.catalogue.reader import read_family

ROOT = Path(catalogue.__file__).parent / "data"
MOTORS = [catalogue.motor(key) for key in catalogue.family("motor")]
EACH_MOTOR = pytest.mark.parametrize("motor", MOTORS, ids=lambda motor: motor.id)
STATED = re.compile(r"yes: \S.*|(partly: .*no, from memory|no, .*)[,;] check before ordering")


@pytest.mark.parametrize("name", FAMILIES)
def test_every_row_is_reached_by_its_id_and_says_its_source(name: str) -> None:
    rows = catalogue.family(name)
    assert len(rows) >= 2
    for key, row in rows.items():
        assert FAMILIES[name](key) is row
        assert type(row) is FAMILIES[name].record
        assert row.id == key
        assert row.source
        assert row.description
        assert STATED.fullmatch(row.verified)
        assert row.source.isascii()  # it is printed, and written into tables that others open
        assert row.verified.isascii()


@pytest.mark.parametrize("name", FAMILIES)
def test_an_unknown_id_lists_the_legal_ones(name: str) -> None:
    with pytest.raises(CatalogueError) as caught:
        FAMILIES[name]("unobtainium")
    for key in catalogue.family(name):
        assert key in str(caught.value)


def test_an_unknown_family_lists_the_legal_ones() -> None:
    with pytest.raises(CatalogueError, match=r"gears.*motor, cable"):
        catalogue.family("gears")


def test_every_csv_file_is_a_family() -> None:
    files = {path.relative_to(ROOT).as_posix() for path in ROOT.rglob("*.csv")}
    assert files == {family.file for family in FAMILIES.values()}


def test_records_are_frozen_and_families_read_only() -> None:
    with pytest.raises(FrozenInstanceError):
        MOTORS[0].mass_g = 1.0  # pyright: ignore[reportAttributeAccessIssue]
    with pytest.raises(TypeError):
        catalogue.family("motor")["x"] = MOTORS[0]  # pyright: ignore[reportIndexIssue]


# Motors


def test_both_drives_have_a_choice() -> None:
    assert sum("capstan" in motor.drives for motor in MOTORS) >= 3
    assert sum("direct" in motor.drives for motor in MOTORS) >= 2
    assert {drive for motor in MOTORS for drive in motor.drives} == {"capstan", "direct", "none"}


@EACH_MOTOR
def test_stall_torque_follows_from_voltage_resistance_and_torque_constant(motor: Motor) -> None:
    expected = motor.torque_constant_N_m_A * motor.nominal_voltage_V / motor.resistance_ohm
    # makers round R and k to 3 digits (1 %) and some take the motor's friction off (up to 4.5 % here)
    assert motor.stall_torque_N_m == pytest.approx(expected, rel=0.05)


@EACH_MOTOR
def test_the_continuous_current_heats_the_winding_to_no_more_than_its_limit(motor: Motor) -> None:
    inner, outer = motor.thermal_resistance_winding_housing_K_W, motor.thermal_resistance_housing_ambient_K_W
    if inner is None and outer is not None:  # a hobby motor, rated by its surface alone: cool enough for a print
        assert outer * motor.resistance_ohm * (motor.nominal_torque_N_m / motor.torque_constant_N_m_A) ** 2 < 40.0
        return
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
    share = 0.95 if motor.drive_board else 0.6  # a gimbal motor is wound for torque at next to no speed
    assert motor.nominal_torque_N_m < motor.peak_torque_N_m < share * motor.stall_torque_N_m
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


def test_the_default_motor_is_of_one_family_with_its_other_windings() -> None:
    """Copper that fills the same space gives the same k^2 / R; brushes take some of that from windings of few turns.

    The 12 V and 36 V windings are those of two public models of the motor, the 48 V one is a row.
    """
    motor, other = catalogue.motor("maxon-re30-310007"), catalogue.motor("maxon-re30-310009")
    assert (motor.torque_constant_N_m_A, motor.resistance_ohm) == (0.0259, 0.611)
    windings = [(0.0139, 0.198), (0.0259, 0.611), (0.0398, 1.43), (other.torque_constant_N_m_A, other.resistance_ohm)]
    goodness = [k**2 / r for k, r in windings]
    assert goodness == sorted(goodness)
    assert 3.31e-6 <= motor.rotor_inertia_kg_m2 <= other.rotor_inertia_kg_m2
    assert motor.nominal_torque_N_m == pytest.approx((3.44 - 0.16) * 0.0259, rel=0.002)  # rounded to 85.0 mN m
    assert (motor.diameter_mm, motor.length_mm) == (30.0, 68.0)
    for row in (motor, other):
        assert (row.max_radial_load_N, row.radial_load_distance_mm, row.max_axial_load_N) == (28.0, 5.0, 5.6)


@EACH_MOTOR
def test_idling_costs_a_small_share_of_the_torque(motor: Motor) -> None:
    if motor.no_load_current_A is not None:
        idle = motor.no_load_current_A * motor.torque_constant_N_m_A
        assert 0.01 < idle / motor.nominal_torque_N_m < 0.1  # brushes and bearings of small motors


@EACH_MOTOR
def test_a_winding_without_iron_does_not_cog(motor: Motor) -> None:
    assert motor.cogging_torque_N_m == (0.0 if motor.commutation == "brushed" else None)


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
    if b.ball_count is not None and b.ball_diameter_mm is not None:
        pitch = (b.bore_mm + b.outer_mm) / 2.0
        assert 0.25 < b.ball_diameter_mm / ((b.outer_mm - b.bore_mm) / 2.0) < 0.75
        assert 0.5 < b.ball_count * b.ball_diameter_mm / (math.pi * pitch) < 0.8  # the cage needs the rest
        # ISO 76: C0 = f0 Z D^2, f0 12.3 to 14.7 N/mm^2 for these D / pitch, less for shallow races
        assert 10.0 < b.static_load_N / (b.ball_count * b.ball_diameter_mm**2) < 15.0


@pytest.mark.parametrize("key", [*catalogue.family("screw"), *catalogue.family("low_screw")])
def test_screws_follow_the_rules_of_their_standards(key: str) -> None:
    low = key.startswith("low-")
    s = (catalogue.low_screw if low else catalogue.screw)(key)
    assert key == f"{'low-' * low}M{s.diameter_mm:g}"
    assert s.order_code == f"{s.standard} M{s.diameter_mm:g} A2-70"
    assert s.standard == ("DIN 7984" if low else "ISO 4762")
    assert s.head_height_mm == (pytest.approx(0.69 * s.diameter_mm, rel=0.04) if low else s.diameter_mm)  # k = d
    assert s.tap_drill_mm == pytest.approx(
        s.diameter_mm - s.pitch_mm, abs=0.0501
    )  # drills come in steps of 0.05 to 0.1 mm
    assert s.diameter_mm < s.clearance_hole_mm <= 1.2 * s.diameter_mm
    assert s.clearance_hole_mm < s.head_diameter_mm < s.counterbore_diameter_mm
    buried = s.counterbore_depth_mm - s.head_height_mm  # DIN 974-1: 0.3 to 0.4 mm below M6, 0.6 mm from there on
    assert buried == pytest.approx(0.35 if s.diameter_mm < 6.0 else 0.6, abs=0.051)
    assert s.socket_depth_mm < s.head_height_mm
    assert s.socket_mm * 2.0 / math.sqrt(3.0) < s.head_diameter_mm


def test_a_low_headed_screw_differs_from_the_usual_one_in_its_head_alone() -> None:
    shared = (
        "diameter_mm",
        "pitch_mm",
        "head_diameter_mm",
        "clearance_hole_mm",
        "counterbore_diameter_mm",
        "tap_drill_mm",
    )
    for s in catalogue.low_screw.rows.values():
        cap = catalogue.screw(f"M{s.diameter_mm:g}")
        assert [getattr(s, name) for name in shared] == [getattr(cap, name) for name in shared]
        assert (s.head_height_mm, s.socket_mm, s.socket_depth_mm) < (cap.head_height_mm, cap.socket_mm)
        buried = cap.counterbore_depth_mm - cap.head_height_mm
        assert s.counterbore_depth_mm - s.head_height_mm == pytest.approx(buried)
        assert set(s.lengths_mm) < {*cap.lengths_mm, 25.0}


@EACH_MOTOR
def test_a_motor_is_held_by_low_heads_where_its_thread_has_them(motor: Motor) -> None:
    size = motor.mount_thread
    assert motor.mount_screw.diameter_mm == catalogue.screw(size).diameter_mm
    assert motor.mount_screw.standard == ("ISO 4762" if size in ("M2", "M2.5") else "DIN 7984")


def test_screw_sizes_are_those_of_the_standard() -> None:
    m3 = catalogue.screw("M3")
    assert isinstance(m3, Screw)
    sizes = (m3.head_diameter_mm, m3.socket_mm, m3.clearance_hole_mm, m3.tap_drill_mm, m3.pitch_mm)
    assert sizes == (5.5, 2.5, 3.4, 2.5, 0.5)
    assert m3.lengths_mm[:3] == (5.0, 6.0, 8.0)


def test_set_screws_go_with_the_cap_screws() -> None:
    assert set(catalogue.family("set_screw")) <= set(catalogue.family("screw"))
    for key in catalogue.family("set_screw"):
        s, cap = catalogue.set_screw(key), catalogue.screw(key)
        assert (s.diameter_mm, s.pitch_mm, s.tap_drill_mm) == (cap.diameter_mm, cap.pitch_mm, cap.tap_drill_mm)
        assert s.socket_mm * 2.0 / math.sqrt(3.0) < s.tap_drill_mm  # the key goes into the core of the thread
        assert s.socket_mm < cap.socket_mm
        assert s.lengths_mm == tuple(sorted(set(s.lengths_mm)))
        assert s.lengths_mm[0] > s.diameter_mm - 1e-9  # as long as thick at the least, or it would tilt


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
        assert encoder.counts_per_turn in (2**14, 2**18, 2**21)
    sensor = catalogue.encoder("as5048a-board")
    assert sensor.noise_rms_deg is not None
    assert sensor.noise_rms_deg * sensor.counts_per_turn / 360.0 == pytest.approx(2.73, abs=0.005)  # the data sheet's
    assert sensor.nonlinearity_deg == 0.8


def test_the_default_encoder_is_as_its_data_sheet_and_its_magnet_gives_the_field_that_it_asks() -> None:
    """MT6835 rev. 1.3, chapters 5, 6 and 13; the field on the axis of a cylinder magnetised across."""
    e = catalogue.encoder("mt6835-board")
    assert (e.noise_rms_deg, e.nonlinearity_deg, e.latency_us, e.centring_mm) == (0.0015, 0.5, 10.0, 0.3)
    assert 0.85 <= e.chip_height_mm <= 1.2
    assert e.air_gap_max_mm <= 3.0
    magnet, remanence_T = catalogue.magnet(e.magnet), 1.17  # the least of N35

    def field_T(far_mm: float) -> float:
        near, end = far_mm, far_mm + magnet.thickness_mm
        radius = magnet.diameter_mm / 2.0
        return remanence_T / 4.0 * (end / math.hypot(end, radius) - near / math.hypot(near, radius))

    sensor_mm = 0.37  # below the chip's face, at most
    assert 0.03 < field_T(e.air_gap_max_mm + sensor_mm) < field_T(e.air_gap_min_mm) < 1.0


def test_a_ropes_mass_is_that_of_its_wires() -> None:
    for key in catalogue.family("cable"):
        row = catalogue.cable(key)
        wires, across = {"7x7": (49, 9), "7x19": (133, 15)}[row.construction]
        straight = wires * math.pi / 4.0 * (row.diameter_mm / across) ** 2 * 7.9
        assert 1.0 < row.mass_g_m / straight < 1.15  # their lay makes them longer


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
        factor = {"7x7": 1.20e-5, "7x19": 1.62e-5}[c.construction]  # percent of stretch = W[lb] factor / D[in]^2
        pound, inch = 4.448222, 25.4
        stretch = c.breaking_load_N / pound * factor / (c.diameter_mm / inch) ** 2 / 100.0
        assert c.axial_stiffness_N is not None
        assert c.axial_stiffness_N == pytest.approx(c.breaking_load_N / stretch, rel=0.005)  # written with 3 digits
        assert 0.25 < c.axial_stiffness_N / (area * 193e3) < 0.45  # of a solid wire that fills the circle
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


def test_balls_weigh_what_steel_weighs_and_come_in_two_grades() -> None:
    for key in catalogue.family("ball"):
        b = catalogue.ball(key)
        assert key == f"{b.diameter_mm:g}-g{b.grade}"
        volume = math.pi / 6.0 * b.diameter_mm**3
        assert b.mass_g == pytest.approx(volume * catalogue.material(b.material).density_kg_m3 * 1e-6, rel=0.003)
        assert b.roundness_um == pytest.approx(b.grade / 40.0)  # ISO 3290: 0.025 um a grade
        assert b.lot_variation_um == pytest.approx(b.grade / 20.0)
    assert {catalogue.ball(key).diameter_mm for key in catalogue.family("ball")} == {5.0, 6.0, 8.0, 10.0}


def test_tension_springs_keep_the_law_of_their_wire() -> None:
    for key in catalogue.family("tension_spring"):
        s = catalogue.tension_spring(key)
        rate = s.shear_modulus_Pa * 1e-6 * s.wire_mm**4 / (8.0 * s.mean_diameter_mm**3 * s.active_coils)
        assert s.rate_N_mm == pytest.approx(rate, rel=2e-4)  # four digits
        assert s.force_N(s.free_length_mm) == s.initial_tension_N
        assert s.force_N(s.length_max_mm) == pytest.approx(s.force_max_N, abs=0.006)
        index = s.mean_diameter_mm / s.wire_mm
        factor = (index + 0.5) / (index - 0.75)  # of the curvature, EN 13906-2
        stress = factor * 8.0 * s.force_max_N * s.mean_diameter_mm / (math.pi * s.wire_mm**3)
        assert stress < 0.45 * 2170.0  # N/mm^2: EN 10270-1 DH of 0.8 mm, thinner wire is stronger
        assert stress / factor < 0.45 * 1920.0  # at rest, of the class SM at its thickest: mollificiomodenese.it
        assert f"F0 {s.initial_tension_N:g} N" in s.order_code
        body = (s.active_coils + 1.0) * s.wire_mm
        assert body < s.free_length_mm < body + 3.0 * s.mean_diameter_mm  # the rest are the loops
    pair = catalogue.tension_spring("0.6x5.6-25")
    assert pair.force_N(45.0) == pytest.approx(10.4, abs=0.1)  # what holds a pair of rods 54 mm apart


def test_wave_springs_preload_a_bearing_softly() -> None:
    for key in catalogue.family("wave_spring"):
        w = catalogue.wave_spring(key)
        outer, inner, thickness = (float(part) for part in key.split("-")[0].split("x"))
        assert (inner, thickness) == (w.inner_mm, w.thickness_mm)
        assert 0.2 < w.housing_mm - outer < 0.5  # it grows when it is pressed flat
        assert w.work_height_mm < 1.5
        assert w.rate_N_mm is not None
        stroke = w.free_height_mm - w.work_height_mm
        assert w.force_N == pytest.approx(w.rate_N_mm * stroke, abs=0.06)
        assert w.waves is not None
        mean, width = (outer + inner) / 2.0, (outer - inner) / 2.0
        force = 193e3 * width * thickness**3 * w.waves**4 * stroke * outer / (3.88 * mean**3 * inner)
        assert w.force_N == pytest.approx(force, rel=0.01)  # written with two or three digits
        assert 3.0 * math.pi * w.force_N * mean / (4.0 * width * thickness**2 * w.waves**2) <= 1250.0  # bending, N/mm^2
        if w.force_N < 15.0:  # the others are for larger forces
            assert w.rate_N_mm <= 15.0
            assert w.force_N == pytest.approx(10.0, abs=1.0 if w.housing_mm == 16.0 else 1.5)  # 0.18 mm strip at 19 mm


def test_each_bearing_has_a_wave_spring_that_presses_on_its_outer_ring_alone() -> None:
    springs = [catalogue.wave_spring(key) for key in catalogue.family("wave_spring")]
    for key in catalogue.family("bearing"):
        b = catalogue.bearing(key)
        fitting = [w for w in springs if w.housing_mm == b.outer_mm]
        assert fitting, key
        assert all(b.inner_ring_outer_mm + 1.0 < w.inner_mm < b.outer_mm for w in fitting)  # off the inner ring, shield


def test_adhesives_are_weaker_than_what_they_join() -> None:
    kinds = set()
    for key in catalogue.family("adhesive"):
        a = catalogue.adhesive(key)
        kinds.add(a.kind)
        if a.shear_strength_MPa is not None:
            assert 10.0 < a.shear_strength_MPa < 40.0
    assert kinds == {"retaining", "structural"}


def test_a_copy_of_a_file_is_read_and_an_id_given_twice_is_refused(tmp_path: Path) -> None:
    text = (ROOT / "magnets.csv").read_text(encoding="utf-8")
    path = tmp_path / "magnets.csv"
    path.write_text(text, encoding="utf-8")
    assert read_family(path, Magnet) == catalogue.family("magnet")
    path.write_text(text + text.splitlines()[1] + "\n", encoding="utf-8")
    with pytest.raises(CatalogueError, match=r"magnets.csv line \d+: id = 'ndfeb-6x2.5-diametric': must be unique"):
        read_family(path, Magnet)


def test_a_file_with_other_columns_or_cells_is_refused(tmp_path: Path) -> None:
    header = ",".join(catalogue.magnet.columns)
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


def test_a_ropes_stiffness_goes_from_new_to_settled() -> None:
    """By hand, 7x7 of 0.54 mm: new 57.3 GPa over its circle less a tenth, settled its maker's 16.8 kN."""
    row = catalogue.cable("steel-0.54-7x7")
    handbook = 57.3e3 * math.pi / 4.0 * 0.54**2
    assert row.stiffness_N == (pytest.approx(0.9 * handbook), 16800.0)
    unstated = replace(row, axial_stiffness_N=None)
    assert unstated.stiffness_N == (pytest.approx(0.9 * handbook), pytest.approx(handbook))
    soft = replace(row, axial_stiffness_N=9000.0)  # of both the softer is the new one's
    assert soft.stiffness_N == (pytest.approx(8100.0), 9000.0)
    other = replace(unstated, construction="1x3")
    assert other.stiffness_N[1] == pytest.approx(42.4e3 * math.pi / 4.0 * 0.54**2)
