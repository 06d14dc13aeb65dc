"""The page's own kinematics against the mechanism's: every link's frame, and the figures at a position."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.joint import known_joints
from delta_cad.mechanism import inverse_kinematics, rod_lean
from delta_cad.mechanism.limits import HandleFriction, HandleInertia
from delta_cad.mechanism.limits.effective_mass import effective_mass
from delta_cad.mechanism.limits.friction import friction
from delta_cad.mechanism.limits.position_step import position_step
from delta_cad.mechanism.placement import LINKS, LinkPlacement
from delta_cad.mechanism.statics import conditioning, worst_joint_torque
from delta_cad.report.fields import Handle
from delta_cad.report.page import ASSETS, mechanism

INERTIA = HandleInertia(0.071, 0.0043, 0.0011, 3.1e-4)
POSES = 60
EXACT = 1e-9  # both are closed forms in doubles; what differs is the order of a few dozen roundings


@pytest.fixture(scope="module")
def positions(best_dimensions: Dimensions) -> np.ndarray:
    """Corners of the cube and random positions in it, mm."""
    cube = best_dimensions.design.cube
    half, centre = cube.half_side_mm, np.array([0.0, 0.0, cube.bottom_height_mm + cube.half_side_mm])
    corners = half * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    return centre + np.concatenate([corners, np.random.default_rng(7).uniform(-half, half, (POSES, 3))])


@pytest.fixture(scope="module", params=["geared", "direct", "placed"])
def placement(request: pytest.FixtureRequest, best_dimensions: Dimensions) -> LinkPlacement:
    d = best_dimensions
    springs = ((41.0, -1.5), (102.0, 1.5))
    if request.param == "direct":
        radius_mm = 1000.0 * d.design.geometry.base_radius
        return LinkPlacement(d.design.geometry, d.forearm.width_mm, (radius_mm, 0.0), 1.0, springs, 2.5)
    geometry = d.design.geometry
    if request.param == "placed":
        geometry = replace(geometry, side_shift=0.004, side_cosine=np.cos(np.radians(117.0)))
    return LinkPlacement(geometry, d.forearm.width_mm, d.bracket.motor_axis_mm, 4.8, springs, 2.5)


@pytest.fixture(scope="module")
def script(chromium: Any) -> Any:
    page = chromium.new_page()
    page.add_script_tag(content=(ASSETS / "kinematics.js").read_text(encoding="utf-8"))
    yield page
    page.close()


def wording(placement: LinkPlacement, d: Dimensions) -> str:
    known = known_joints(d.design)
    handle = Handle(INERTIA, known["friction"], known["encoder_count"])
    return json.dumps(mechanism(placement, d.design.requirements.force_N, handle))


def test_every_link_is_where_the_assembly_has_it(
    script: Any, placement: LinkPlacement, best_dimensions: Dimensions, positions: np.ndarray
) -> None:
    ask = "([m, all]) => all.map((p) => Delta.links(JSON.parse(m), p))"
    found = script.evaluate(ask, [wording(placement, best_dimensions), positions.tolist()])
    frames = placement(positions)
    assert set(found[0]) == set(LINKS) == set(frames)
    for link in LINKS:
        own = np.array([one[link] for one in found]).reshape(-1, 4, 4)
        assert np.abs(own - frames[link]).max() < EXACT, link


def test_the_figures_there_are_the_mechanisms(
    script: Any, placement: LinkPlacement, best_dimensions: Dimensions, positions: np.ndarray
) -> None:
    g, known = placement.geometry, known_joints(best_dimensions.design)
    rubs, count = known["friction"], known["encoder_count"]
    assert isinstance(rubs, HandleFriction)
    ask = "([m, all]) => all.map((p) => Delta.figures(JSON.parse(m), p))"
    found = script.evaluate(ask, [wording(placement, best_dimensions), positions.tolist()])
    p = positions / 1000.0
    force = best_dimensions.design.requirements.force_N
    for name, expected in (
        ("shoulder", inverse_kinematics(g, p)),
        ("lean", rod_lean(g, p)),
        ("kappa", conditioning(g, p)),
        ("torque", worst_joint_torque(g, p, force)),
        ("effective_mass", effective_mass(g, p, INERTIA)),
        ("friction", friction(g, p, rubs)),
        ("position_step", 1000.0 * position_step(g, p, count)),
    ):
        own = np.array([one[name] for one in found])
        assert np.abs(own - expected).max() < EXACT * np.abs(expected).max(), name


def test_out_of_reach_there_is_nothing(script: Any, placement: LinkPlacement, best_dimensions: Dimensions) -> None:
    ask = "([m, p]) => [Delta.links(JSON.parse(m), p), Delta.figures(JSON.parse(m), p)]"
    assert script.evaluate(ask, [wording(placement, best_dimensions), [0.0, 0.0, 900.0]]) == [None, None]


def test_what_is_not_known_is_none(script: Any, placement: LinkPlacement) -> None:
    m = json.dumps(mechanism(placement, 3.0, Handle(INERTIA, None, None)))
    found = script.evaluate("(m) => Delta.figures(JSON.parse(m), [0, 0, 100])", m)
    assert found["friction"] is None
    assert found["position_step"] is None
