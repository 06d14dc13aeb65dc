"""Dimensions: the closed forms against brute force."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from itertools import product
from math import acos, ceil, cos, degrees, hypot, pi, radians, sin, sqrt

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.design import design_from_dict
from delta_cad.dimensions import DimensionError, Dimensions, dimensions
from delta_cad.dimensions.bracket import MESHES_MM, BracketDimensions, beam_stop_angle_rad, bracket_dimensions
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.platform import base_dimensions
from delta_cad.dimensions.rules import tenths_below
from delta_cad.mechanism import elbow_positions, inverse_kinematics
from tests.committed import DATA, PUBLISHED_DATA, changed
from tests.delta_cad.dimensions.edited import edited


@pytest.mark.parametrize("length", [60.0, 82.0, 120.0])
def test_the_stop_pin_touches_the_beam_at_the_stop_angle(best_dimensions: Dimensions, length: float) -> None:
    arm = replace(best_dimensions.arm, length_mm=length)
    distance, pin = arm.flange_radius_mm + 6.0, 4.0
    angle = beam_stop_angle_rad(arm, pin, distance)
    at = np.array([distance * cos(angle), distance * sin(angle)])
    t = np.linspace(0, 1, 2_000_001)  # circles whose hull the beam is; distances are flat around the nearest
    centre = np.stack([t * length, np.zeros_like(t)], axis=1)
    radius = arm.beam_root_radius_mm + (arm.boss_radius_mm - arm.beam_root_radius_mm) * t
    gap = float((np.linalg.norm(at - centre, axis=1) - radius).min())
    assert gap == pytest.approx(pin / 2, abs=1e-9)


def capstan(d: Dimensions) -> CapstanDimensions:
    assert d.capstan is not None
    return d.capstan


def test_the_stop_pin_meets_the_slot_s_ends_three_degrees_outside_the_cube(best_dimensions: Dimensions) -> None:
    d, c = best_dimensions, capstan(best_dimensions)
    (u, z), b = d.bracket.stop_pins_mm[0], d.bracket
    pin = np.array([u - b.shoulder_u_mm, z])
    low, high = d.extremes.shoulder_min.value, d.extremes.shoulder_max.value
    free = (c.slot_width_mm - b.stop_pin_mm) / 2

    def deep(theta: float) -> float:
        """How far the pin is beyond touching the slot's walls: distance from the slot's middle line less the play."""
        angle = np.linspace(*c.slot_angles_rad, 20_001)
        x, y = cos(theta) * pin[0] + sin(theta) * pin[1], -sin(theta) * pin[0] + cos(theta) * pin[1]
        line = c.slot_radius_mm * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return float(np.hypot(line[:, 0] - x, line[:, 1] - y).min()) - free

    def stop(inside: float, outside: float) -> float:
        for _ in range(50):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if deep(middle) < 0 else (inside, middle)
        return inside

    for theta in np.linspace(low, high, 21):
        assert deep(float(theta)) < 0
    # the play is laid off along the arc instead of the chord: 1e-6 rad
    assert stop(low, low - 0.3) == pytest.approx(low - radians(3.0), abs=1e-5)
    assert stop(high, high + 0.3) == pytest.approx(high + radians(3.0), abs=1e-5)
    assert d.stops_rad == pytest.approx((low - radians(3.0), high + radians(3.0)))


def test_pinion_and_sector_wind_equal_lengths_of_cable_and_keep_their_gap(best_dimensions: Dimensions) -> None:
    c, h = capstan(best_dimensions), best_dimensions.design.hardware
    pitch, d = h.sector_radius_mm, c.cable_diameter_mm
    pinion = pitch / h.capstan_ratio
    assert c.rim_radius_mm + d / 2 == pytest.approx(pitch)
    assert c.pinion_radius_mm == pytest.approx(pinion - d / 4)  # a groove of a quarter diameter
    between = pitch + pinion + 1.0
    assert hypot(*c.pinion_axis_mm) == pytest.approx(between)
    assert pinion - d / 2 - c.pinion_bore_mm / 2 >= 0.75
    shoulder = np.array([best_dimensions.bracket.shoulder_u_mm, 0.0])
    np.testing.assert_allclose(shoulder + c.pinion_axis_mm, best_dimensions.bracket.motor_axis_mm)
    # from lug to lug: what of the rim no strand has left, both free strands, three turns less what they leave out
    left = acos((pitch + pinion) / between)
    flat = pitch * (c.rim_angles_rad[1] - c.rim_angles_rad[0] - 2 * left)
    flat += 2 * sqrt(between**2 - (pitch + pinion) ** 2) + pinion * (6 * pi - 2 * left)
    climb = 0.7 / (2 * pi * pinion)  # pitch of the groove for 0.54 mm
    ends = (5.0 + d / 2) * pi / 2 + 6.0 + 3.0 + 1.2 + 6.0  # nose, anchor's wall, sleeve; gap and carriage
    assert c.cable_length_mm == pytest.approx(flat * hypot(1.0, climb) + ends)


def boundary(corners: list[np.ndarray]) -> np.ndarray:
    """(n, 2) points along the edges of a polygon."""
    side = np.linspace(0, 1, 201)[:, None]
    return np.concatenate([a + side * (b - a) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)])


def test_the_rim_covers_both_take_offs_and_the_lug_stays_off_the_pinion_up_to_the_stops(
    best_dimensions: Dimensions,
) -> None:
    c = capstan(best_dimensions)
    pinion, left = np.array(c.pinion_axis_mm), c.run.tangent_rad
    nearest, covered = [], []
    for theta in np.linspace(*best_dimensions.stops_rad, 101):
        seen = np.arctan2(pinion[1], pinion[0]) - theta  # polar angle of the pinion in the arm's frame
        seen = c.rim_angles_rad[0] + (seen - c.rim_angles_rad[0]) % (2 * pi)
        covered.append(min(seen - left - c.rim_angles_rad[0], c.rim_angles_rad[1] - seen - left))
        end = c.rim_angles_rad[1] + theta
        radial, tangent = np.array([cos(end), sin(end)]), np.array([-sin(end), cos(end)])
        r0, r1, s = c.pitch_radius_mm - 9.2, c.pitch_radius_mm + 4.2, 13.0  # carriage, its travel, walls around it
        lug = boundary([r0 * radial, r1 * radial, r1 * radial + s * tangent, r0 * radial + s * tangent])
        nearest.append(np.linalg.norm(lug - pinion, axis=1).min() - c.pinion_radius_mm)
    assert min(nearest) >= 1.0 - 1e-6
    on_rim = min(covered) * c.pitch_radius_mm
    assert on_rim >= 4.0 - 1e-9  # beside the stop's slot
    assert min(min(nearest) - 1.0, on_rim - 4.0) == pytest.approx(0.0, abs=1e-6)  # and no longer than either asks


def test_the_cable_turns_inwards_at_the_upper_end_so_that_nothing_stands_above_the_rim(
    best_dimensions: Dimensions,
) -> None:
    """Cable, anchor's wall and sleeve there, laid off by hand along the nose."""
    c = capstan(best_dimensions)
    low, line = c.rim_angles_rad[0], c.nose_radius_mm + c.cable_diameter_mm / 2
    out, aside = np.array([cos(low), sin(low)]), np.array([sin(low), -cos(low)])
    nose = (c.rim_radius_mm - c.nose_radius_mm) * out
    np.testing.assert_allclose(c.nose_centre_mm, nose)
    turn = np.linspace(0, c.turns_rad[0], 101)
    cable = nose + line * (np.cos(turn)[:, None] * out + np.sin(turn)[:, None] * aside)
    np.testing.assert_allclose(cable[0], c.pitch_radius_mm * out)  # where it leaves the rim
    leaves = cable[-1]
    np.testing.assert_allclose(leaves, nose + line * aside, atol=1e-12)  # and from there inwards along the radius
    wall = boundary([leaves + v * aside - s * out for v, s in ((-3.2, 0), (3.2, 0), (3.2, 6.0), (-3.2, 6.0))])
    sleeve = boundary([leaves + v * aside - s * out for v, s in ((-0.9, 6.0), (0.9, 6.0), (0.9, 9.0), (-0.9, 9.0))])
    highest = np.linalg.norm(np.concatenate([cable, wall, sleeve]), axis=1).max() + c.cable_diameter_mm / 2
    assert highest <= c.rim_radius_mm + c.cable_diameter_mm + 1e-9  # the cable on the rim, and nothing above it
    assert np.linalg.norm(sleeve, axis=1).min() > best_dimensions.arm.flange_radius_mm  # the sleeve's end off the hub
    assert c.nose_radius_mm == 5.0
    # a wall of 2 mm between the stop's slot and the sector's end, which lies under the cable by the wall's half
    end = line - 3.2
    assert end == pytest.approx(c.nose_bar_radius_mm)
    slot = c.slot_radius_mm * np.array([cos(c.slot_angles_rad[0]), sin(c.slot_angles_rad[0])])
    assert end - slot @ aside - c.slot_width_mm / 2 >= 2.0


@pytest.mark.parametrize(("shaft", "collar"), [(6.0, 6.0), (5.0, 5.5)])
def test_set_screws_end_flush_with_the_collar(shaft: float, collar: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """M3 x 3: sunk ones would turn out against their own thread, for the key's check."""
    rows, key = catalogue.motor.rows, "maxon-re30-310007"
    row = replace(rows[key], shaft_diameter_mm=shaft)
    monkeypatch.setitem(catalogue.motor.__dict__, "rows", {**rows, key: row})
    d = dimensions(design_from_dict(changed(hardware__motor=key)))
    assert capstan(d).collar_radius_mm == pytest.approx(collar)


def test_the_keep_out_radius_contains_the_lug_and_its_screw(best_dimensions: Dimensions) -> None:
    c = capstan(best_dimensions)
    assert c.keep_out_radius_mm >= hypot(c.pitch_radius_mm + 4.2, 13.0)
    assert c.keep_out_radius_mm >= hypot(c.pitch_radius_mm, 13.0 + catalogue.screw("M3").head_height_mm)


WIDE: dict[str, float | str] = {  # its motor of 50 mm hangs low over the foot; the key of its M4 screws lower
    "motor": "maxon-re50-370354",
    "sector_radius_mm": 34.0,
    "capstan_ratio": 5.0,
    "base_radius_mm": 50.0,
    "platform_radius_mm": 40.0,
}


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"arm_thickness_mm": 12.0, "base_plate_thickness_mm": 6.0},
        {"forearm_length_mm": 120.0, "half_side_mm": 25.0, "bottom_height_mm": 70.0},
        WIDE,
        {"drive": "direct", "motor": "maxon-ec60flat-625858"},
    ],
)
def test_the_base_lies_below_all_that_passes_over_it(changes: dict[str, float | str]) -> None:
    d = edited(**changes)
    b, cube = d.bracket, d.design.cube
    top, under = d.base.top_mm, d.base.top_mm - d.base.thickness_mm
    assert top == b.base_top_mm
    over = 0.0 if d.capstan is None else b.foot_height_mm
    assert top + over <= b.motor_axis_mm[1] - d.motor.diameter_mm / 2 - 2.0 + 1e-9
    assert changes is not WIDE or top == tenths_below(b.motor_axis_mm[1] - 0.8 * 58.5)
    swept = d.capstan.keep_out_radius_mm if d.capstan is not None else d.arm.flange_radius_mm
    assert top + b.foot_height_mm <= -swept - 2.0 + 1e-9
    side = np.linspace(-cube.half_side_mm, cube.half_side_mm, 31)
    points = np.array(list(product(side, side, cube.bottom_height_mm + cube.half_side_mm + side))) / 1e3
    geometry = d.design.geometry
    elbows = elbow_positions(geometry, inverse_kinematics(geometry, points)) * 1e3
    lowest = elbows[..., 2].min()
    assert under <= lowest - d.arm.boss_radius_mm - 2.0 + 1e-3  # the sampled lowest elbow is a little too high
    over = np.hypot(elbows[..., 0], elbows[..., 1]) - d.arm.boss_radius_mm - 2.0 < d.base.radius_mm
    if over.any():
        assert top <= elbows[over][:, 2].min() - d.arm.boss_radius_mm - 2.0 + 1e-3


@pytest.mark.parametrize(
    "changes", [{}, {"base_radius_mm": 36.37}, {"drive": "direct", "motor": "maxon-ec60flat-625858"}]
)
def test_what_others_only_keep_clear_of_stands_in_tenths(changes: dict[str, float | str]) -> None:
    d = edited(**changes)
    for length in (*d.bracket.foot_u_mm, d.bracket.base_top_mm, d.arm.boss_radius_mm, d.base.radius_mm):
        assert f"{length:.10g}" == f"{length:.1f}".removesuffix(".0")


DEEP = {"forearm_length_mm": 122.5, "bottom_height_mm": 48.2, "half_side_mm": 42.1}


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "changes", [{}, DEEP, {"forearm_length_mm": 120.0, "half_side_mm": 25.0, "bottom_height_mm": 70.0}]
)
def test_arms_at_their_lower_stop_keep_clear_of_foot_block_and_base(
    changes: dict[str, float | str],
) -> None:
    """The beam is the hull of two circles: distances to a family of circles along it, at the stop and above it."""
    d = edited(**changes)
    a, b = d.arm, d.bracket
    along = np.linspace(0.0, 1.0, 4001)
    radius = a.beam_root_radius_mm + (a.boss_radius_mm - a.beam_root_radius_mm) * along
    low, high = (u - b.shoulder_u_mm for u in b.foot_u_mm)
    top = b.base_top_mm + b.foot_height_mm
    block = boundary([np.array(v) for v in ((low, b.base_top_mm), (high, b.base_top_mm), (high, top), (low, top))])
    gaps, rooms = [], []
    for theta in np.linspace(d.stops_rad[0], d.stops_rad[0] + 0.5, 11):
        centres = a.length_mm * along[:, None] * np.array([cos(theta), sin(theta)])
        gaps.append(min(float((np.linalg.norm(centres - p, axis=1) - radius).min()) for p in block))
        over = centres[:, 0] - radius + b.shoulder_u_mm < d.base.radius_mm
        rooms.append((centres[over, 1] - radius[over]).min(initial=0.0) - d.base.top_mm)
    required = d.design.requirements.clearance_min_mm + MESHES_MM
    assert required == pytest.approx(2.0 + 2 * 0.065)  # two meshes, each so far off
    assert min(gaps) >= required - 1e-6
    assert min(rooms) >= required - 1e-9
    if changes is DEEP:  # and no lower than that but for the tenth that it is rounded down by
        assert min(*gaps, *rooms) - 0.1 < required
    assert b.foot_u_mm[1] - b.foot_u_mm[0] == pytest.approx(42.0)
    middle = sum(b.foot_u_mm) / 2
    for pair in (b.cheek_screw_u_mm, b.cheek_dowel_u_mm, b.base_screw_u_mm, b.base_dowel_u_mm):
        assert sum(pair) / 2 == pytest.approx(middle)
    half_widths = (-d.layers.encoder_cheek_mm[0], d.layers.motor_cheek_mm[1])
    assert feet_apart(b.foot_u_mm[0], *half_widths) >= 4.0


def feet_apart(inner: float, encoder_side: float, motor_side: float) -> float:
    """Least distance of two neighbouring feet, rectangles from `inner` outwards, mm."""
    far = inner + 42.0
    one = [np.array(v) for v in ((inner, -encoder_side), (inner, motor_side), (far, motor_side), (far, -encoder_side))]
    turn = np.array([[-0.5, sqrt(0.75)], [-sqrt(0.75), -0.5]])
    p, q = boundary(one), boundary([v @ turn for v in one])
    return float(min(np.linalg.norm(q - v, axis=1).min() for v in p))


def direct_bracket(d: Dimensions, shoulder: tuple[float, float], elbow_mm: float) -> BracketDimensions:
    """A direct drive's bracket on a base radius of 40 mm, for a range of the shoulder and the lowest elbow."""
    return bracket_dimensions(
        base_radius_mm=40.0,
        shoulder_rad=shoulder,
        lowest_elbow_mm=elbow_mm,
        base_thickness_mm=8.0,
        half_width_mm=17.0,
        leg_mm=11.0,
        arm=d.arm,
        capstan=None,
        bearing=d.bearing,
        motor=d.motor,
        clearance_mm=1.0,
    )


@pytest.mark.parametrize("lowest", [-50.0, -60.0, -65.0, -70.0, -75.0])
def test_the_deeper_arms_swing_the_lower_lies_the_base(lowest: float) -> None:
    """A foot that would come nearer than 12 mm to the centre goes down instead; then the arms leave it room."""
    d = edited()

    def arm_down(degrees: float) -> BracketDimensions:
        shoulder = (radians(degrees), d.extremes.shoulder_max.value)
        return direct_bracket(d, shoulder, d.arm.length_mm * sin(radians(degrees)))

    made = arm_down(lowest)
    assert made.foot_u_mm[0] >= 12.0 - 1e-9
    assert arm_down(lowest - 1.0).base_top_mm <= made.base_top_mm + 1e-9


def test_arms_that_swing_straight_down_leave_no_room_for_the_feet() -> None:
    d = edited()
    with pytest.raises(DimensionError, match=r"^foot_block, place: .* -86\.9 deg "):
        direct_bracket(d, (radians(-86.9), 1.0), -82.0)


@pytest.mark.parametrize("drive", ["capstan", "direct"])
@pytest.mark.parametrize("thickness", [8.0, 8.5, 20.0])
def test_the_stack_along_the_shoulder_axis_is_in_order(drive: str, thickness: float) -> None:
    motor = DATA["hardware"]["motor"] if drive == "capstan" else "maxon-ec60flat-625858"
    d = edited(drive=drive, motor=motor, arm_thickness_mm=thickness)
    s, cheek = d.layers, d.bearing.width_mm + 1.0
    assert s.arm_mm == pytest.approx((-thickness / 2, thickness / 2))
    assert s.arm_mm[0] - s.encoder_cheek_mm[1] == pytest.approx(1.0)
    assert s.motor_cheek_mm[0] - s.sector_mm[1] == pytest.approx(1.0)
    assert s.encoder_cheek_mm[1] - s.encoder_cheek_mm[0] == pytest.approx(cheek)
    assert s.motor_cheek_mm[1] - s.motor_cheek_mm[0] >= cheek - 1e-9
    assert s.encoder_head_mm[1] == s.encoder_cheek_mm[0]
    assert s.encoder_head_mm[0] - s.encoder_board_mm[1] == pytest.approx(5.0)
    gap = d.shaft.y_mm[0] - s.encoder_board_mm[1] - d.encoder.chip_height_mm
    assert d.encoder.air_gap_min_mm < gap < d.encoder.air_gap_max_mm
    if drive == "direct":
        assert s.sector_mm == (s.arm_mm[1], s.arm_mm[1])
        assert s.bearings_mm == ()
        end = s.motor_cheek_mm[1] - d.motor.shaft_length_mm
        assert end >= d.shaft.y_mm[1]  # the motor's shaft ends before the stub
        assert s.arm_mm[1] - end >= d.motor.shaft_diameter_mm / 2  # and is clamped by the arm
        return
    assert s.sector_mm[0] >= s.arm_mm[1] + 2.2
    c = capstan(d)
    sides = s.sector_mm[1] - c.end_y_mm[0], c.end_y_mm[1] - s.sector_mm[0]
    assert [side - c.cable_diameter_mm / 2 for side in sides] == pytest.approx([sides[0] - c.cable_diameter_mm / 2] * 2)
    assert 0.8 - 1e-9 <= sides[0] - c.cable_diameter_mm / 2 < 0.85  # what rounds the rim's width up
    assert abs(c.run.made_lug_mm - c.run.lug_mm) <= 0.05
    stack = [y for pair in (s.sector_mm, s.motor_cheek_mm, s.encoder_cheek_mm, s.encoder_head_mm) for y in pair]
    stack += [*c.pinion_y_mm, *c.collar_y_mm, *c.end_y_mm]
    assert [round(2 * y, 1) for y in stack] == pytest.approx([2 * y for y in stack], abs=1e-9)  # tenths, from a middle
    (e0, e1), (m0, m1) = s.bearings_mm
    assert [e1 - e0, m1 - m0] == pytest.approx([d.bearing.width_mm] * 2)
    assert m0 == s.motor_cheek_mm[0]
    assert (m0 - e0) >= 30.0 - 1e-9  # middle to middle
    assert e1 <= s.encoder_cheek_mm[1] + 1e-9
    assert d.preload is not None
    assert e0 - d.preload.work_height_mm - 1.0 >= s.encoder_head_mm[0] - 1e-9  # spring and lip behind it
    assert d.shaft.head_to_y_mm == e0
    assert d.shaft.y_mm[1] < m1  # the washer presses on the inner ring, not on the shaft


def test_a_direct_drive_stops_at_two_pins_three_degrees_outside() -> None:
    d = edited(drive="direct", motor="maxon-ec60flat-625858")
    assert d.capstan is None
    assert len(d.bracket.stop_pins_mm) == 2
    distance = d.arm.flange_radius_mm + 6.0
    touch = degrees(beam_stop_angle_rad(d.arm, 4.0, distance))
    low, high = degrees(d.extremes.shoulder_min.value), degrees(d.extremes.shoulder_max.value)
    seen = [degrees(np.arctan2(z, u - d.bracket.shoulder_u_mm)) for u, z in d.bracket.stop_pins_mm]
    assert seen == pytest.approx([low - touch - 3.0, high + touch + 3.0])


@pytest.mark.parametrize(
    ("magnet", "clearance"),
    [("ndfeb-6x2.5-diametric", 2.4), ("ndfeb-8x2.5-diametric", 2.0), ("ndfeb-8x2.5-diametric", 2.4)],
)
def test_a_direct_drives_stub_keeps_its_clearance_from_the_cheek_it_turns_in(magnet: str, clearance: float) -> None:
    """Meshes of both are up to 0.05 mm off; the passage was a bearing's, whatever magnet and clearance were."""
    data = deepcopy(PUBLISHED_DATA)
    data["hardware"] |= {"drive": "direct", "motor": "maxon-ec60flat-625858", "magnet": magnet, "arm_thickness_mm": 9.0}
    data["requirements"]["clearance_min_mm"] = clearance
    d = dimensions(design_from_dict(data))
    assert d.bracket.passage_mm - d.shaft.head_diameter_mm >= 2 * (clearance + 0.1) - 1e-9
    assert d.bracket.passage_mm <= 2 * d.bracket.head_radius_mm - 6.0


def test_the_bore_of_a_wide_platforms_boss_is_no_deeper_than_a_drill() -> None:
    p = edited(parallelogram_width_mm=107.0, platform_radius_mm=50.0).platform
    assert 9.9 < p.boss_length_mm / p.bar_bore_mm <= 10.0


def test_the_rod_adds_up_to_its_length(best_dimensions: Dimensions) -> None:
    f, m = best_dimensions.forearm, best_dimensions.design.mechanism
    assert f.tube_length_mm + 2 * f.shoulder_mm == pytest.approx(m.forearm_length_mm)
    assert f.bar_length_mm + 2 * f.stand_off_mm == pytest.approx(m.parallelogram_width_mm)
    assert best_dimensions.platform.boss_length_mm < f.bar_length_mm
    assert degrees(f.tilt_limit_rad) == pytest.approx(DATA["requirements"]["lean_max_deg"] + 3.0)


def test_the_base_plate_carries_the_feet_and_its_holes(best_dimensions: Dimensions) -> None:
    b, k = best_dimensions.base, best_dimensions.bracket
    layers = best_dimensions.layers
    corner = max(hypot(k.foot_u_mm[1], y) for y in (*layers.encoder_cheek_mm, *layers.motor_cheek_mm))
    assert corner + 4.0 <= b.radius_mm < corner + 5.0  # a whole number of millimetres, for a rim of 4 mm
    assert b.radius_mm == round(b.radius_mm)
    assert b.mount_circle_mm / 2 + b.mount_hole_mm / 2 < b.radius_mm - 2.0
    assert b.centre_hole_mm / 2 < k.foot_u_mm[0]


def test_a_plate_that_would_stand_out_alone_is_six_sided(best_dimensions: Dimensions) -> None:
    """It holds what the disc holds: the blocks with their rim, feet and mounting holes; behind it ends where asked."""
    bracket, (_, width) = (
        replace(best_dimensions.bracket, foot_u_mm=(50.0, 92.0)),
        best_dimensions.layers.motor_cheek_mm,
    )
    disc, plate = (base_dimensions(bracket, 8.0, width, behind) for behind in (200.0, 88.7))
    assert disc.rim_mm == ()
    radius = float(ceil(hypot(92.0, width) + 4.0))
    assert disc.reach_mm == ((-radius, radius), (-radius, radius))
    (x0, x1), (y0, y1) = plate.reach_mm
    assert x0 == pytest.approx(-88.0)
    assert x1 == pytest.approx(92.0 + 4.0)
    assert y1 == pytest.approx(-y0)
    assert y1 <= radius
    centres, radii = np.array(plate.rim_mm)[:, :2], np.array(plate.rim_mm)[:, 2]
    normals = np.stack([np.cos(a := np.linspace(0.0, 2.0 * pi, 3601)), np.sin(a)])
    support = (centres @ normals + radii[:, None]).max(axis=0)

    def room(x: float, y: float) -> float:
        return float((support - np.array([x, y]) @ normals).min())

    def turned(radius: float, degree: float) -> tuple[float, float]:
        return radius * cos(radians(degree)), radius * sin(radians(degree))

    corner = degrees(np.arctan2(width, 92.0))
    assert room(*turned(hypot(92.0, width), 120.0 + corner)) >= 4.0 - 1e-3
    assert room(*turned(plate.foot_circle_mm / 2, 180.0)) == pytest.approx(10.0, abs=1e-3)
    for side in (-18.0, 18.0):
        assert room(*turned(plate.mount_circle_mm / 2, 60.0 + side)) == pytest.approx(8.0, abs=1e-3)
    between = (plate.foot_circle_mm - plate.centre_hole_mm) / 2  # feet to the hole in the middle
    assert between / 2 - plate.window_mm / 2 >= 5.0
    small = base_dimensions(replace(bracket, foot_u_mm=(75.0, 117.0)), 8.0, width, 60.0)
    assert small.window_mm == 0.0  # no room
    assert small.centre_hole_mm / 2 <= small.foot_circle_mm / 2 - 8.0
