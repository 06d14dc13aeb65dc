"""Closed forms of what stands beside a neighbour, of chains in any places, against points in the plane."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.design import Design, design_from_dict
from delta_cad.design.stands import EVEN, Gap, gaps_of, home_x, other_stands
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.dimensions.capstan import base_radius_min_mm, cable_run, rim_y_mm
from delta_cad.dimensions.forearm import wrist_radius_min_mm
from delta_cad.mechanism import DeltaGeometry, joint_angles
from delta_cad.mechanism.placement import chain_stand
from delta_cad.mechanism.workspace import Cube
from tests.designs import placed

PLACES = [(116.3, 7.65), (110.0, -3.0), (124.0, 4.0), (95.0, 12.0), (75.0, 0.0), (140.0, -8.0)]
PAIRS = [(0, 1), (1, 2), (2, 0)]
CABLE = catalogue.cable.rows["steel-0.54-7x7"]


def geometry(phi_deg: float, shift_mm: float, radius_mm: float = 60.0) -> DeltaGeometry:
    return DeltaGeometry(radius_mm / 1e3, 0.022, 0.094, 0.148, shift_mm / 1e3, cos(radians(phi_deg)))


def in_plane(phi_deg: float, i: int, u: np.ndarray | float, t: np.ndarray | float) -> np.ndarray:
    """Points (u, t) of chain i, u from the base's centre, seen from above."""
    a = radians((0.0, phi_deg, -phi_deg)[i])
    return np.stack([u * np.cos(a) - t * np.sin(a), u * np.sin(a) + t * np.cos(a)], axis=-1)


@pytest.mark.parametrize(("phi", "shift"), PLACES)
def test_gaps_are_angles_and_radii_of_neighbours(phi: float, shift: float) -> None:
    azimuths, outs = [0.0, phi, 360.0 - phi, 360.0], [0.0, shift, shift, 0.0]
    for k, gap in enumerate(gaps_of(geometry(phi, shift))):
        angle = radians(azimuths[k + 1] - azimuths[k])
        assert (gap.sine, gap.cosine) == pytest.approx((sin(angle), cos(angle)), abs=1e-12)
        assert (gap.half_sine, gap.half_cosine) == pytest.approx((sin(angle / 2), cos(angle / 2)), abs=1e-12)
        assert (gap.out_mm, gap.next_out_mm) == pytest.approx((outs[k], outs[k + 1]))


def test_gaps_of_a_symmetric_machine_are_those_of_a_third_of_the_round() -> None:
    assert gaps_of(geometry(120.0, 0.0)) != EVEN  # a cosine that was rounded is another machine
    assert gaps_of(replace(geometry(120.0, 0.0), side_cosine=-0.5)) == EVEN


@pytest.mark.parametrize(("phi", "shift"), PLACES)
def test_stands_seen_from_one_another(phi: float, shift: float) -> None:
    g = geometry(phi, shift)
    stands = [chain_stand(g, i) for i in range(3)]
    wanted = [np.linalg.inv(stands[i]) @ stands[j] for a, b in PAIRS for i, j in ((a, b), (b, a))]
    assert np.abs(np.array(other_stands(gaps_of(g))) - np.array(wanted)).max() < 1e-12


@pytest.mark.parametrize(("phi", "shift"), PLACES)
def test_cups_on_the_least_platform_are_a_clearance_apart(phi: float, shift: float) -> None:
    cup, width, clearance = 5.4, 50.0, 2.0
    r = wrist_radius_min_mm(cup, width, clearance, gaps_of(geometry(phi, shift)))
    ends = [in_plane(phi, i, r, np.array([-width / 2, width / 2])) for i in range(3)]
    apart = min(np.linalg.norm(a - b) for i, j in PAIRS for a in ends[i] for b in ends[j])
    assert apart == pytest.approx(2 * cup + clearance, abs=1e-9)


def sectors(phi: float, shift: float, radius: float, rim: tuple[float, float], tip: float) -> list[np.ndarray]:
    """Points of each sector's strip at the height of its tip, from inside to the shoulder's axis, seen from above."""
    u, t = np.meshgrid(np.linspace(0.0, tip, 400), np.linspace(*rim, 60))
    return [in_plane(phi, i, radius + (shift if i else 0.0) - tip + u.ravel(), t.ravel()) for i in range(3)]


@pytest.mark.parametrize(("phi", "shift"), [*PLACES[:3], PLACES[5]])
@pytest.mark.parametrize("radius", [30.0, 34.0])
def test_a_sector_s_tip_passes_the_inner_side_of_the_next_one(phi: float, shift: float, radius: float) -> None:
    """The rim lies as far out as the narrowest pair asks: the tip keeps the clearance there, and not a tenth more."""
    run, clearance = cable_run(39.6, 4.85, (-0.8, 1.1), CABLE), 2.0
    tip, gaps = 39.6 + CABLE.diameter_mm / 2, gaps_of(geometry(phi, shift, radius))
    low, high = rim_y_mm(run, CABLE.diameter_mm, 1.0, radius, clearance, gaps)
    strips = sectors(phi, shift, radius, (low, high), tip)
    found = []
    for i, j in PAIRS:
        normal = in_plane(phi, j, 0.0, 1.0)
        corners = [in_plane(phi, i, radius + (shift if i else 0.0) - tip, t) for t in (low, high)]
        found.append(low - max(corner @ normal for corner in corners))
    by_arm = 0.5 + rim_y_mm(run, CABLE.diameter_mm, 0.0, 1e3, clearance, gaps)[0]
    assert min(found) >= clearance - 1e-9
    if low > by_arm:
        assert min(found) <= clearance + 0.1 * 2.0
    apart = [np.linalg.norm(strips[i][::7, None] - strips[j][None, ::7], axis=-1).min() for i, j in PAIRS]
    assert min(apart) >= clearance - 1e-9


@pytest.mark.parametrize(("phi", "shift"), PLACES)
def test_on_the_least_base_a_tip_passes_the_neighbour_s_flange(phi: float, shift: float) -> None:
    run, clearance, flange = cable_run(39.6, 4.85, (-0.8, 1.1), CABLE), 2.0, 13.0
    gaps, cable, tip = gaps_of(geometry(phi, shift)), CABLE.diameter_mm, 39.6 + CABLE.diameter_mm / 2
    least = base_radius_min_mm(run, cable, 5.0, flange, clearance, gaps)

    def room(radius: float) -> float:
        """From the tips of all sectors, at the outer sides of their rims, to the next chains' shoulder axes."""
        outer = rim_y_mm(run, cable, 5.0, radius, clearance, gaps)[1]
        found = []
        for i, j in PAIRS:
            corner = in_plane(phi, i, radius + (shift if i else 0.0) - tip, outer)
            found.append(radius + (shift if j else 0.0) - corner @ in_plane(phi, j, 1.0, 0.0))
        return min(found) - flange - clearance

    assert -1e-9 <= room(least) <= 0.2  # a rim lies on whole tenths, and is reckoned a tenth farther out
    assert room(least - 1.0) < room(least) - 0.4


@pytest.mark.parametrize(("phi", "shift"), PLACES)
def test_the_arms_stand_alike_at_home(phi: float, shift: float) -> None:
    g, cube = geometry(phi, shift), Cube(0.08, 0.04, 0.009)
    x = home_x(g, cube)
    angles = joint_angles(g, np.array([x, 0.0, 0.12]))
    assert np.ptp(angles) < 1e-12
    assert abs(x - 0.009) <= 0.04


def leg_gap_mm(d: Dimensions) -> float:
    """Least distance, seen from above, of the encoder legs' inner ends from the motors that lie across them."""
    b, face, radius = d.bracket, d.layers.motor_face_mm, d.motor.diameter_mm / 2
    azimuths, outs = [radians(a) for a in d.design.azimuths_deg], d.outs_mm
    found = []
    head = b.shoulder_u_mm + 8.0 - b.head_radius_mm  # inner edge of a leg at the shoulder's height
    for i, j in PAIRS:
        for share in np.linspace(0.0, 1.0, 200):
            height = share * b.base_top_mm
            inner = head + share * (b.foot_u_mm[0] - head) + outs[j]
            off = height - b.motor_axis_mm[1]
            if abs(off) > radius:
                continue
            wide = np.sqrt(radius**2 - off**2)
            a = azimuths[j] - azimuths[i]
            u, t = inner * cos(a) + -d.layers.encoder_cheek_mm[0] * sin(a), inner * sin(a) - 10.0 * cos(a)
            if t > face:
                found.append(b.motor_axis_mm[0] + outs[i] - wide - u)
    return min(found, default=np.inf)


def test_a_motor_that_would_meet_the_next_chain_s_leg_goes_farther_out(placed_dimensions: Dimensions) -> None:
    """Within the arms' outline it would; so it stands out of it, just as far as the leg and its lead ask."""
    d = placed_dimensions
    assert leg_gap_mm(d) >= 0.95  # 1 mm at the heights at which it is looked at
    data = placed()
    data["mechanism"]["azimuths_deg"] = [0.0, 121.0, -121.0]
    data["mechanism"]["platform_radius_mm"] = 23.5
    wide = dimensions(design_from_dict(data))
    assert wide.capstan is not None
    assert d.capstan is not None

    def behind(one: Dimensions) -> tuple[float, float]:
        """How far the motor of chain 1, and its arm, reach behind the base."""
        b, a = one.bracket, radians(one.design.azimuths_deg[1])
        out, end = one.outs_mm[1], one.layers.motor_face_mm + one.motor.length_mm
        motor = -(b.motor_axis_mm[0] + out + one.motor.diameter_mm / 2) * cos(a) + end * sin(a)
        elbow = -(b.shoulder_u_mm + out + one.arm.length_mm) * cos(a) + one.forearm.width_mm / 2 * sin(a)
        return motor, elbow + 5.8

    motor, arm = behind(d)
    assert arm + 1.0 < motor < arm + 12.0
    motor, arm = behind(wide)
    assert motor <= arm + 1e-9


@pytest.mark.parametrize(("phi", "radii"), [(116.3, (30.8, 38.45)), (122.0, (36.0, 32.0)), (121.0, (31.19, 35.0))])
def test_the_base_plate_holds_all_that_stands_on_it(phi: float, radii: tuple[float, float]) -> None:
    data = placed()
    data["mechanism"] |= {"azimuths_deg": [0.0, phi, -phi], "base_radii_mm": [radii[0], radii[1], radii[1]]}
    data["mechanism"]["platform_radius_mm"] = 23.7
    d = dimensions(design_from_dict(data))
    b, wide = d.base, max(-d.layers.encoder_cheek_mm[0], d.layers.motor_cheek_mm[1])
    rim = np.array(b.rim_mm or [(0.0, 0.0, float(b.radius_mm))])
    normals = np.stack([np.cos(w := np.linspace(0.0, 2.0 * pi, 3601)), np.sin(w)])
    support = (rim[:, :2] @ normals + rim[:, 2:]).max(axis=0)

    def room(points: np.ndarray) -> float:
        return float((support - points @ normals).min())

    for i in range(3):
        out = radii[min(i, 1)] - radii[0]
        assert room(in_plane(phi, i, d.bracket.foot_u_mm[1] + out, np.array([-wide, wide]))) >= 4.0 - 1e-3
    between = [phi / 2, 180.0, -phi / 2]
    assert np.cos(b.between_rad) == pytest.approx(np.cos(np.radians(between)))
    feet = b.foot_circle_mm / 2 * np.stack([np.cos(b.between_rad), np.sin(b.between_rad)], axis=-1)
    assert room(feet) >= 10.0 - 1e-3
    for sign in (-1.0, 1.0):
        turns = np.array(b.between_rad) + sign * b.mount_spread_rad
        assert room(b.mount_circle_mm / 2 * np.stack([np.cos(turns), np.sin(turns)], axis=-1)) >= 8.0 - 1e-3
    nearest = min(0.0, radii[1] - radii[0]) + d.bracket.foot_u_mm[0]
    assert b.centre_hole_mm / 2 <= nearest - 8.0


def test_a_design_tells_its_azimuths() -> None:
    data = placed()
    assert design_from_dict(data).azimuths_deg == pytest.approx((0.0, 116.3, 243.7))
    del data["mechanism"]["azimuths_deg"]
    even: Design = design_from_dict(data)
    assert even.azimuths_deg == (0.0, 120.0, 240.0)
    assert Gap() in EVEN
