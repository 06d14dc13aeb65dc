"""Force laws are continuous within the derived bounds, conservative at rest, and damping never works on the hand."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from delta_cad.mechanism import Cube
from haptics.rendering import force, law_table, stored_energy
from haptics.rendering.law import GAIN
from haptics.rendering.laws.constant_force import ConstantForce
from haptics.rendering.laws.home import Home
from haptics.rendering.laws.operating_resistance import PAPER_SETTINGS, OperatingResistance
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.laws.virtual_wall import VirtualWall, axis_wall
from tests.haptics.rendering.states import (
    PROPERTY,
    ROUNDING,
    SPEED_MAX,
    K,
    between,
    cube_walls,
    laws,
    near_edges,
    steepness,
    vectors,
    velocities,
)

CUBE = Cube(bottom_height=0.057, half_side=0.035)
# ---------------------------------------------------------------- continuity


@PROPERTY
@given(st.data())
def test_laws_are_continuous_with_the_derived_bound(data):
    law = data.draw(laws())
    p1, v1 = data.draw(near_edges(law)), data.draw(velocities())
    if data.draw(st.booleans()):
        p2, v2 = data.draw(near_edges(law)), data.draw(velocities())
    else:  # close by, where a step would show most
        p2 = p1 + data.draw(vectors(1e-6))
        v2 = v1 * data.draw(between(0.999, 1.0))
    along, across = steepness(law)
    bound = along * np.linalg.norm(p1 - p2) + across * np.linalg.norm(v1 - v2)
    assert np.linalg.norm(force(law, p1, v1) - force(law, p2, v2)) <= bound + ROUNDING


@PROPERTY
@given(st.data())
def test_walls_of_a_cube_together_keep_the_bound_of_one(data):
    walls = cube_walls(CUBE, stiffness=3000.0, damping=20.0)
    table = law_table(*walls)
    centre = (CUBE.lower + CUBE.upper) / 2
    corner = centre + CUBE.half_side * np.array(data.draw(st.tuples(*[st.sampled_from([-1, 0, 1])] * 3)))
    p1, p2 = (corner + data.draw(vectors(1e-3)) for _ in range(2))
    v1, v2 = data.draw(velocities()), data.draw(velocities())
    along, across = steepness(walls[0])
    bound = along * np.linalg.norm(p1 - p2) + across * np.linalg.norm(v1 - v2)
    assert np.linalg.norm(force(table, p1, v1) - force(table, p2, v2)) <= bound + ROUNDING


# ---------------------------------------------------------------- energy


@PROPERTY
@given(st.data())
def test_force_at_rest_is_minus_the_gradient_of_the_stored_energy(data):
    law = data.draw(laws())
    row = law_table(law)
    row[0, GAIN] = data.draw(between(0, 1))
    p, h = data.draw(near_edges(law)), 1e-8
    steps = h * np.eye(3)
    slope = (stored_energy(row, p + steps) - stored_energy(row, p - steps)) / (2 * h)
    # the force changes by at most k h over the step, also where it has a kink; energy and position, which is tens of
    # metres out where an edge is, are rounded to a few units of their last place
    size = K * 0.35**2 + 5.0 + abs(stored_energy(row, p)) + np.linalg.norm(force(row, p)) * np.linalg.norm(p)
    tolerance = getattr(law, "stiffness", 0.0) * h + 8 * np.finfo(float).eps * size / h
    np.testing.assert_allclose(-slope, force(row, p), rtol=0, atol=tolerance)


@pytest.mark.slow
@PROPERTY
@given(st.data())
def test_damping_never_works_on_the_hand(data):
    law = data.draw(laws())
    p, v = data.draw(near_edges(law)), data.draw(velocities())
    assert (force(law, p, v) - force(law, p)) @ v <= ROUNDING * SPEED_MAX


def loop(rng, centre, size, points):
    """A closed path of three harmonics through all sides of the centre, and its velocity over one second."""
    t = np.arange(points) / points
    a = rng.normal(size=(2, 3, 3)) * size / 3
    p, v = np.tile(centre, (points, 1)), np.zeros((points, 3))
    for n in range(1, 4):
        w = 2 * math.pi * n
        for c, (wave, slope) in zip(a, ((np.cos, lambda x: -np.sin(x)), (np.sin, np.cos)), strict=True):
            p += wave(w * t)[:, None] * c[n - 1] / n
            v += (slope(w * t) * w)[:, None] * c[n - 1] / n
    return p, v


@pytest.mark.parametrize("damping", [0.0, 20.0])
def test_work_on_the_hand_around_a_closed_path(damping):
    rng = np.random.default_rng(4)
    table = law_table(
        OperatingResistance(stiffness=400, damping=damping, dead_radius=1.5e-3, full_radius=10e-3),
        VirtualWall(stiffness=3000, damping=damping, point=(0.01, 0, 0), normal=(-1, 0.3, 0.2)),
        *cube_walls(Cube(0.01, 0.02), stiffness=2000, damping=damping),
        SpringDamper(stiffness=100, damping=0.0, point=(0, 0, 0.02)),
        ConstantForce((0.3, -0.2, 1.0)),
    )
    for _ in range(10):
        p, v = loop(rng, (0, 0, 0.02), 0.03, 40_000)
        power = (force(table, p, v) * v).sum(axis=-1)
        # kinks cost the trapezoidal rule the square of its step; measured 7e-9 here, 3e-10 with a quarter of the step
        near = 1e-7 * np.abs(power).mean()
        if damping:
            assert power.mean() < -near
        else:
            assert abs(power.mean()) < near


SAME = 1e-12  # rounding; differences of positions lose two digits


def test_energy_of_each_kind_where_it_can_be_read_off():
    assert stored_energy(SpringDamper(stiffness=200, damping=0, point=(0, 0, 1)), (0, 0, 1.1)) == pytest.approx(
        1.0, rel=SAME
    )
    setting = PAPER_SETTINGS["k0.4"]
    # half k (r1 - r0)^2, then the plateau for 10 mm
    assert stored_energy(setting, (0.02, 0, 0)) == pytest.approx(0.5 * 400 * 8.5e-3**2 + 3.4 * 0.01, rel=SAME)
    assert stored_energy(setting, (1e-3, 0, 0)) == 0.0
    returning = Home(stiffness=100, damping=10, speed=0.1)  # the pull ends at 1 N, 10 mm away
    assert stored_energy(returning, (0, 0.03, 0)) == pytest.approx(0.5 * 100 * 0.01**2 + 1.0 * 0.02, rel=SAME)
    assert stored_energy(axis_wall("+z", 0.1, stiffness=1000), (0, 0, 0.11)) == pytest.approx(0.05, rel=SAME)
    assert stored_energy(ConstantForce((0, 0, 2)), (1, 1, 0.5)) == -1.0
