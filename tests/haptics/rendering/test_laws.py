"""Force laws against their equations as printed, the home function in flight, tables, batches, turned frames."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from delta_cad.mechanism import Cube
from haptics.rendering import (
    constant_force,
    force,
    home,
    law_table,
    operating_resistance,
    spring_damper,
    stored_energy,
    virtual_wall,
)
from haptics.rendering.law import GAIN, KIND
from haptics.rendering.laws.home import Home
from haptics.rendering.laws.operating_resistance import PAPER_SETTINGS
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.laws.virtual_wall import WALL_BLEND, VirtualWall, axis_wall
from haptics.rendering.registry import COLUMNS
from haptics.rendering.table import fade, total_energy, total_force
from tests.haptics.rendering.states import (
    BOX,
    PROPERTY,
    ROUNDING,
    K,
    between,
    cube_walls,
    directions,
    laws,
    steepness,
    vectors,
    velocities,
    walls,
)

# ---------------------------------------------------------------- equations as printed


def equation_23(p, v, k, b, r0, r1):
    """Eq. (23) as printed, for one state around the origin."""
    d = np.linalg.norm(p)
    if d < r0:
        return np.zeros(3)
    return k * (min(d, r1) - r0) * (-p / d) - b * v


@PROPERTY
@given(directions(), between(0, 0.05), velocities(), st.sampled_from(list(PAPER_SETTINGS)))
def test_resistance_is_equation_23_away_from_the_blend(n, d, v, name):
    setting = PAPER_SETTINGS[name]
    k, b, r0, r1 = setting.stiffness, setting.damping, setting.dead_radius, setting.full_radius
    blend = 1e-3
    found = operating_resistance(n * d, v, stiffness=k, damping=b, dead_radius=r0, full_radius=r1, blend=blend)
    p = n * d
    if np.linalg.norm(p) < r0 or np.linalg.norm(p) > r0 + blend:
        np.testing.assert_allclose(found, equation_23(p, v, k, b, r0, r1), rtol=0, atol=ROUNDING)
    else:  # between the force without and with the whole damping
        still, whole = equation_23(p, 0 * v, k, b, r0, r1), equation_23(p, v, k, b, r0, r1)
        assert (found <= np.maximum(still, whole) + ROUNDING).all()
        assert (found >= np.minimum(still, whole) - ROUNDING).all()


def test_damping_of_the_resistance_is_half_in_the_middle_of_the_blend():
    found = operating_resistance(
        (0, 0, 2e-3), (0.1, 0, 0), stiffness=0, damping=8, dead_radius=1.5e-3, full_radius=4e-3, blend=1e-3
    )
    np.testing.assert_allclose(found, (-0.4, 0, 0), rtol=1e-12, atol=0)  # d - r0 is rounded: 1e-16 of 0.5 mm


@pytest.mark.parametrize(("name", "plateau", "r1"), [("k0.4", 3.4, 10e-3), ("k0.8", 2.8, 5e-3)])
def test_settings_of_the_paper(name, plateau, r1):
    setting = PAPER_SETTINGS[name]
    assert setting.plateau == pytest.approx(plateau, rel=1e-12)  # rounding
    assert setting.damping == 500.0
    assert setting.dead_radius == 1.5e-3
    assert setting.full_radius == r1
    far = force(replace(setting, origin=(0, 0, 0.09)), (0.03, 0, 0.09))
    np.testing.assert_allclose(far, (-plateau, 0, 0), rtol=1e-12, atol=1e-15)  # rounding


def test_applied_damping_takes_the_place_of_the_one_requested():
    setting = PAPER_SETTINGS["k0.4"]
    state = (0.02, 0, 0), (0, 0.1, 0)
    assert force(setting, *state)[1] == -500.0 * 0.1
    assert force(replace(setting, damping=7.0), *state)[1] == -7.0 * 0.1
    assert force(replace(setting, damping=0.0), *state)[1] == 0.0


@PROPERTY
@given(vectors(BOX), velocities(), vectors(BOX), between(0, K), between(0, 500))
def test_spring_damper_is_its_equation(p, v, point, k, b):
    found = spring_damper(p, v, stiffness=k, damping=b, point=point)
    np.testing.assert_allclose(found, k * (point - p) - b * v, rtol=0, atol=ROUNDING)


def test_constant_force_is_the_same_everywhere():
    p = np.random.default_rng(1).normal(size=(4, 5, 3))
    np.testing.assert_array_equal(constant_force(p, (1, -2, 3)), np.broadcast_to((1.0, -2.0, 3.0), p.shape))


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [1, -1])
def test_wall_across_an_axis_is_equation_24(axis, side):
    stiffness, face, e = 1100.0, 0.03 * side, np.eye(3)[axis]
    wall = axis_wall("+-"[side < 0] + "xyz"[axis], face, stiffness=stiffness)
    for x in np.linspace(-0.05, 0.05, 41):
        into = side * (x - face)
        expected = -stiffness * (x - face) * e if into > 0 else np.zeros(3)  # on the handle, so with the minus
        elsewhere = 0.02 * (1 - e)
        np.testing.assert_allclose(force(wall, x * e + elsewhere), expected, rtol=0, atol=ROUNDING)


def test_damping_of_a_wall_acts_in_contact_only_and_fades_in():
    wall = {"stiffness": 1000.0, "damping": 10.0, "point": (0, 0, 0), "normal": (0, 0, 2), "blend": 1e-3}
    down = (0.3, 0.0, -0.1)
    depths = np.array([-1e-3, 0.0, 0.5e-3, 1e-3, 2e-3])
    p = np.stack([0 * depths, 0 * depths, -depths], axis=-1)
    # K x + b min(1, x / blend) 0.1 m/s, and nothing along the wall
    np.testing.assert_allclose(virtual_wall(p, down, **wall)[:, 2], [0, 0, 1.0, 2.0, 3.0], rtol=1e-12, atol=0)
    np.testing.assert_array_equal(virtual_wall(p, down, **wall)[:, :2], 0.0)


def test_wall_lets_go_where_its_damping_would_pull():
    pulled = virtual_wall((0, 0, -1e-3), (0, 0, 0.2), stiffness=1000, damping=10, point=(0, 0, 0), normal=(0, 0, 1))
    np.testing.assert_array_equal(pulled, 0.0)


def test_wall_at_touch_down_makes_no_step_at_speed():
    depth = np.array([0.0, 1e-9])
    p = np.stack([0 * depth, 0 * depth, -depth], axis=-1)
    found = virtual_wall(p, (0, 0, -1.0), stiffness=5000, damping=500, point=(0, 0, 0), normal=(0, 0, 1))
    assert found[0, 2] == 0.0
    # 1 nm of K + b V / blend
    assert found[1, 2] == pytest.approx(1e-9 * (5000 + 500 * 1.0 / WALL_BLEND), rel=1e-9)


@PROPERTY
@given(walls(), vectors(BOX), velocities())
def test_wall_never_pulls_and_pushes_along_its_normal(wall, p, v):
    f, n = force(wall, p, v), wall.normal
    assert f @ n >= 0.0
    np.testing.assert_allclose(f - (f @ n) * n, 0.0, rtol=0, atol=ROUNDING)
    if (wall.point - p) @ n < -1e-15:  # rounding of the depth: 4 eps of 0.3 m
        assert not f.any()


@pytest.mark.parametrize("length", [1e-200, 1e-3, 1.0, 1e200])
def test_normal_may_have_any_length(length):
    wall = VirtualWall(stiffness=1, point=(0, 0, 0), normal=np.array([1, -2, 2]) * length)
    np.testing.assert_allclose(force(wall, (-3, 0, 0)), (1 / 3, -2 / 3, 2 / 3), rtol=2e-15, atol=0)  # rounding, twice


CUBE = Cube(bottom_height=0.057, half_side=0.035)


@PROPERTY
@given(st.tuples(*[between(-0.06, 0.06)] * 3).map(np.array), velocities())
def test_cube_of_walls_is_three_walls_one_for_each_coordinate(offset, v):
    k, b, blend = 3000.0, 5.0, 1e-3
    p = (CUBE.lower + CUBE.upper) / 2 + offset
    expected = np.zeros(3)
    for axis in range(3):
        for face, free in ((CUBE.upper[axis], -1.0), (CUBE.lower[axis], 1.0)):
            x = free * (face - p[axis])
            if x > 0:
                expected[axis] += free * max(0.0, k * x - b * min(1.0, x / blend) * free * v[axis])
    found = force(law_table(*cube_walls(CUBE, stiffness=k, damping=b, blend=blend)), p, v)
    np.testing.assert_allclose(found, expected, rtol=0, atol=ROUNDING)
    if (np.abs(offset) < CUBE.half_side - 1e-12).all():
        assert not found.any()


# ---------------------------------------------------------------- home


def fly_home(law, p, v, mass, seconds, dt=1e-4):
    """Path of a free mass under a law, by symplectic Euler."""
    path = []
    for _ in range(round(seconds / dt)):
        v = v + dt / mass * force(law, p, v)
        p = p + dt * v
        path.append((p, v))
    return map(np.array, zip(*path, strict=True))


@pytest.mark.parametrize("start", [(0.05, -0.03, 0.02), (0.0, 0.0, -0.04), (1e-4, 0, 0)])
def test_home_brings_the_handle_back_no_faster_than_the_limit(start):
    origin, limit = np.array([0.0, 0.0, 0.09]), 0.1
    law = Home(stiffness=100, damping=10, speed=limit, origin=origin)  # critical: b = 2 sqrt(k m) at 0.25 kg
    p, v = fly_home(law, origin + start, np.zeros(3), 0.2, 1.6)
    speed = np.linalg.norm(v, axis=1)
    assert speed.max() <= limit * (1 + 1e-12)  # rounding: a step goes 0.5 % of the way from v to w
    if np.linalg.norm(start) > 0.03:
        assert speed.max() > 0.95 * limit  # and it uses it
    assert np.linalg.norm(p[-1] - origin) < 1e-5  # 0.4 s at the speed limit, then 1.2 s of the slow root, 13.8/s
    distance = np.linalg.norm(p - origin, axis=1)
    assert (np.diff(distance) < 1e-12).all()  # no overshoot; rounding at the origin


def test_home_slows_a_handle_that_is_too_fast():
    law = Home(stiffness=100, damping=10, speed=0.1)
    _, v = fly_home(law, np.array([0.05, 0, 0]), np.array([0.1, 0.5, 0.3]), 0.2, 0.2)
    speed = np.linalg.norm(v, axis=1)
    assert (np.diff(speed)[speed[:-1] > 0.1] < 0).all()
    assert speed[-1] < 0.12


def test_home_pull_ends_at_damping_times_speed():
    p = np.array([(0.2, 0, 0), (0, -0.05, 0), (0, 0, 0.005), (0, 0, 0)])
    found = home(p, stiffness=100, damping=10, speed=0.1)
    np.testing.assert_allclose(found, [(-1, 0, 0), (0, 1, 0), (0, 0, -0.5), (0, 0, 0)], rtol=1e-15, atol=0)  # rounding


def test_switching_on_makes_no_step():
    table = law_table(Home(stiffness=100, damping=10, speed=0.1))
    p, v = np.array([0.05, 0.0, 0.0]), np.array([0.0, 0.2, 0.0])
    whole = np.linalg.norm(force(table, p, v))
    gain, last, forces = 0.0, np.zeros(3), []
    for _ in range(120):
        gain = fade(gain, 1.0, 0.01)
        table[0, GAIN] = gain
        now = force(table, p, v)
        assert np.linalg.norm(now - last) <= 0.01 * whole * (1 + 1e-9)  # rounding of the sum of hundredths
        last = now
        forces.append(np.linalg.norm(now))
    assert forces[-1] == whole
    assert gain == 1.0
    for _ in range(120):
        gain = fade(gain, 0.0, 0.01)
    assert gain == 0.0


# ---------------------------------------------------------------- table and batches


def rotation(axis, angle):
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


@PROPERTY
@given(laws(), vectors(BOX), velocities(), directions(), between(-3, 3))
def test_laws_turn_with_the_frame(law, p, v, axis, angle):
    turn = rotation(axis, angle)
    vectors_of = [name for name, parameter in law.parameters().items() if parameter.width == 3]
    turned = replace(law, **{name: turn @ getattr(law, name) for name in vectors_of})
    along, across = steepness(law)
    blur = 1e-15 * (along + across)  # rotated positions and velocities are rounded: 4 eps of 0.2 m or m/s
    np.testing.assert_allclose(force(turned, turn @ p, turn @ v), turn @ force(law, p, v), atol=ROUNDING + blur, rtol=0)


@PROPERTY
@given(st.lists(laws(), max_size=5), vectors(BOX), velocities(), between(0, 1))
def test_table_is_the_sum_of_its_laws_times_their_gains(drawn, p, v, gain):
    table = law_table(*drawn)
    if drawn:
        table[0, GAIN] = gain
    expected = sum((row[GAIN] * force(drawn[i], p, v) for i, row in enumerate(table)), np.zeros(3))
    np.testing.assert_allclose(force(table, p, v), expected, rtol=0, atol=6 * ROUNDING)
    assert total_force(table, *p, *v) == tuple(force(table, p, v))
    assert total_energy(table, *p) == stored_energy(table, p)


def test_a_row_of_unknown_kind_gives_neither_force_nor_energy():
    table = law_table(SpringDamper(stiffness=100, damping=1, point=(0, 0, 0)))
    table[0, KIND] = 99
    assert total_force(table, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0) == (0.0, 0.0, 0.0)
    assert total_energy(table, 1.0, 0.0, 0.0) == 0.0


def test_no_laws_no_force():
    assert law_table().shape == (0, COLUMNS)
    np.testing.assert_array_equal(force(law_table(), np.ones((2, 3))), 0.0)


def test_positions_and_velocities_are_broadcast():
    rng = np.random.default_rng(2)
    p, v = rng.normal(size=(4, 1, 3)) * 0.05, rng.normal(size=(5, 3)) * 0.1
    setting = PAPER_SETTINGS["k0.8"]
    found = force(setting, p, v)
    assert found.shape == (4, 5, 3)
    for i in range(4):
        for j in range(5):
            np.testing.assert_array_equal(found[i, j], total_force(law_table(setting), *p[i, 0], *v[j]))
    assert force(setting, np.empty((0, 3))).shape == (0, 3)
    assert stored_energy(setting, p).shape == (4, 1)
    np.testing.assert_array_equal(force(setting, np.asfortranarray(p[:, 0])), force(setting, p[:, 0]))
