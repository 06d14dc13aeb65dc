"""Chains in places of their own: shapes before CAD are held apart about each, placed here by angles alone."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
import pytest
import trimesh

from delta_cad.assembly.tessellation import tessellate
from delta_cad.design import Design
from delta_cad.dimensions import Dimensions, dimensions, link_placement
from delta_cad.interference.moving_bodies import cup_margin
from delta_cad.interference.shapes import union_distance
from delta_cad.interference.static_obstacles import (
    _on_round,
    _shaft_end,
    are_alike,
    cheeks,
    key_swing_rad,
    motor,
    pinion,
    pinion_clearance_mm,
    sector_clearance_mm,
    slide_in_clearance_mm,
)
from delta_cad.mechanism import joint_angles
from delta_cad.mechanism.inverse import forearm_vectors
from delta_cad.solids.forearm import make_rod_cup
from delta_cad.structure.hardware.refusals import ALONE, least_outline_mm
from delta_cad.structure.loads import sampled_mm
from tests.delta_cad.interference.machines import machine, of, synthesized

FREE = {"mechanism__platform_radius_mm": 30.0, "requirements__envelope_width_mm": 900.0}


def uneven(phi: float, radii_mm: tuple[float, float], **values: Any) -> Design:
    """The committed machine on a wide platform, its chains in places of their own."""
    places = {
        "mechanism__azimuths_deg": [0.0, phi, -phi],
        "mechanism__base_radius_mm": radii_mm[0],
        "mechanism__base_radii_mm": [radii_mm[0], radii_mm[1], radii_mm[1]],
    }
    return of("best.json", **(FREE | places | values))


def place_of(azimuth_deg: float) -> np.ndarray:
    c, s = np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def by_pairs(
    d: Dimensions, azimuths_deg: tuple[float, ...], more_mm: tuple[float, ...]
) -> dict[tuple[int, int], float]:
    """Least distance of a pinion of chain j to what stands with chain i, in the shoulder frame of i."""
    assert d.capstan is not None
    points = np.concatenate([_on_round(one) for one in pinion(d.capstan, d)])
    found = {}
    for i, j in permutations(range(3), 2):
        out = np.array([d.bracket.shoulder_u_mm, 0.0, 0.0])
        own, other = (out + np.array([more_mm[k], 0.0, 0.0]) for k in (i, j))
        seen = ((points + other) @ place_of(azimuths_deg[j]).T) @ place_of(azimuths_deg[i]) - own
        found[i, j] = float(union_distance([*cheeks(d), motor(d)], seen).min())
    return found


@pytest.mark.parametrize(("phi", "more_mm"), [(124.0, 4.0), (112.0, -2.0), (120.0, 3.0)])
def test_pinions_keep_off_what_stands_with_each_other_chain(phi: float, more_mm: float) -> None:
    d = dimensions(uneven(phi, (40.0, 40.0 + more_mm)))
    found = by_pairs(d, (0.0, phi, -phi), (0.0, more_mm, more_mm))
    assert d.capstan is not None
    assert pinion_clearance_mm(d, d.capstan) == pytest.approx(min(found.values()), abs=1e-9)
    assert max(found.values()) - min(found.values()) > 0.5  # not what one chain would see


def test_a_drive_slides_in_along_its_own_radius_past_each_other_chain() -> None:
    """Seen at its end alone it is as far off as a pinion or nearer, and no place of the way is left out."""
    d = dimensions(uneven(112.0, (40.0, 38.0)))
    assert d.capstan is not None
    swing, slid = sector_clearance_mm(d, d.capstan), slide_in_clearance_mm(d, d.capstan)
    points = np.concatenate([_on_round(one) for one in (motor(d), *pinion(d.capstan, d), _shaft_end(d.capstan, d))])
    found, radii = np.inf, (0.0, -2.0, -2.0)
    for i, j in permutations(range(3), 2):
        turn, own = place_of((0.0, 112.0, -112.0)[i]), place_of((0.0, 112.0, -112.0)[j])
        for way in np.linspace(0.0, 40.0, 21):
            for first, second in ((way, 0.0), (0.0, way)):
                out = np.array([d.bracket.shoulder_u_mm + radii[j] + first, 0.0, 0.0])
                seen = (points + out) @ own.T @ turn - [d.bracket.shoulder_u_mm + radii[i] + second, 0.0, 0.0]
                found = min(found, float(union_distance(cheeks(d)[:1], seen).min()))
    assert slid == pytest.approx(found, abs=1e-9)
    assert swing > 0.0


def test_a_key_is_swung_in_each_chains_screws(monkeypatch: pytest.MonkeyPatch) -> None:
    """Motors of chains 1 and 2 that stand near each other leave it no room; those of chain 0 do."""
    near = {"mechanism__azimuths_deg": [0.0, 130.0, -130.0], "mechanism__base_radius_mm": 60.0}
    d = dimensions(machine("motors", **near, mechanism__platform_radius_mm=53.0))
    assert not are_alike(d.design)
    assert not are_alike(synthesized(cube__centre_x_mm=5.0))
    assert are_alike(synthesized())
    assert key_swing_rad(d) < np.radians(60.0)
    monkeypatch.setattr("delta_cad.interference.static_obstacles.are_alike", lambda _: True)
    assert key_swing_rad(d) > np.radians(75.0)


@pytest.mark.parametrize("phi", [116.0, 126.0])
def test_cups_of_neighbouring_wrists_lack_nothing_where_their_solids_are_as_far_apart(phi: float) -> None:
    """Turned about themselves as far as they go, at the position where they are nearest of some."""
    d = dimensions(uneven(phi, (40.0, 43.0)))
    f, g = d.forearm, d.design.geometry
    positions = sampled_mm(d.design.workspace, 3)
    needed = 2.0
    reserve = cup_margin(d, needed)(positions, False, None)[:, 0]
    at = positions[int(np.argmin(reserve))]
    cup = tessellate(make_rod_cup(d).solid, 0.01, 0.1)
    manager, least = trimesh.collision.CollisionManager(), np.inf
    for name in ("one", "other"):
        manager.add_object(name, trimesh.Trimesh(cup.vertices, cup.faces, process=False))
    links = link_placement(d)(at[None])
    for i in range(3):
        j = (i + 1) % 3
        frames = []
        for link in (f"rod_{i}_1", f"rod_{j}_0"):
            frame = links[link][0]
            lean = np.arccos(min(1.0, float(frame[:3, 1] @ g.tangential[int(link[4])])))
            free = np.arccos(np.cos(f.tilt_limit_rad) / np.cos(lean))
            frames.append([wrist_frame(frame, f.length_mm, turn) for turn in np.linspace(-free, free, 9)])
        for one in frames[0]:
            for other in frames[1]:
                manager.set_transform("one", one)
                manager.set_transform("other", other)
                least = min(least, float(manager.min_distance_internal()))
    assert cup_margin(d, least - 0.3)(at[None], False, None).min() > 0.0
    assert cup_margin(d, least + 0.25)(at[None], False, None).min() < 0.0


def wrist_frame(rod: np.ndarray, length_mm: float, turn: float) -> np.ndarray:
    """Frame of a wrist's cup of a rod that is turned about itself."""
    c, s = np.cos(turn), np.sin(turn)
    turned = rod @ np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])
    return turned @ np.array([[-1.0, 0, 0, length_mm], [0, -1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


def test_a_machine_takes_at_least_what_its_own_elbows_and_motors_reach() -> None:
    """No more than what occurs: each arm is as level as it gets in its own chain."""
    design = uneven(124.0, (40.0, 44.0), cube__centre_x_mm=5.0)
    d = dimensions(design)
    theta = joint_angles(design.geometry, sampled_mm(design.workspace) / 1000.0)
    points = []
    for i, (phi, radius) in enumerate(zip((0.0, 124.0, -124.0), (40.0, 44.0, 44.0), strict=True)):
        out = (radius + d.arm.length_mm * np.cos(theta[:, i])).max()
        half, long = d.forearm.bar_length_mm / 2, d.layers.motor_face_mm + d.motor.length_mm
        u = d.bracket.motor_axis_mm[0] + radius - 40.0
        chain = [(out, half), (out, -half), (out + d.arm.boss_radius_mm, 0.0)]
        chain += [(u + side * d.motor.diameter_mm / 2, long) for side in (-1.0, 1.0)]
        for leads in d.leads:
            chain += [(u + across, long + behind) for across, behind in leads.outside_mm]
        points += [place_of(phi)[:2, :2] @ point for point in chain]
    size = np.maximum(np.ptp(points, axis=0), np.ptp(d.base.reach_mm, axis=1))
    assert least_outline_mm(d) == pytest.approx(size, abs=0.02)


@pytest.mark.parametrize(
    ("phi", "forearm_mm", "half_mm", "bottom_mm", "aside_mm", "refused"),
    [
        (100.0, 116.2, 16.7, 52.2, -20.0, True),
        (100.0, 112.5, 19.2, 55.5, -15.1, True),
        (100.0, 114.0, 28.1, 51.4, 8.3, False),
        (135.0, 102.6, 15.8, 46.7, -16.7, False),
    ],
)
def test_where_rods_let_the_platform_turn_follows_each_chains_own_axis(
    phi: float, forearm_mm: float, half_mm: float, bottom_mm: float, aside_mm: float, refused: bool
) -> None:
    """Refused where the determinant of the couples changes its sign over the cube; at 120 degrees each would differ."""
    design = synthesized(
        mechanism__azimuths_deg=[0.0, phi, -phi],
        mechanism__base_radius_mm=85.69,
        mechanism__platform_radius_mm=36.12,
        mechanism__upper_arm_length_mm=64.8,
        mechanism__forearm_length_mm=forearm_mm,
        cube__bottom_height_mm=bottom_mm,
        cube__half_side_mm=half_mm,
        cube__centre_x_mm=aside_mm,
    )
    rods = forearm_vectors(design.geometry, sampled_mm(design.workspace) / 1000.0)
    across = np.stack([place_of(azimuth)[:, 1] for azimuth in (0.0, phi, -phi)])
    determinant = np.linalg.det(np.cross(across, rods))
    assert bool(determinant.min() <= 0.0 <= determinant.max()) == refused
    assert bool([*ALONE["turning"](design)]) == refused
