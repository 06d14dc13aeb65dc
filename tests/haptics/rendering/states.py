"""Random laws, positions near the edges where they change, velocities, and the bounds of their slopes."""

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from haptics.rendering.kernel import ANCHOR, BLEND, DAMPING, FIRST, KIND, STIFFNESS, WALL
from haptics.rendering.laws import constant_row, home_row, resistance_row, spring_row, wall_row

PROPERTY = settings(max_examples=200, deadline=None)
SPEED_MAX = 1.0  # m/s, of the states drawn below
K = 1e4  # N/m, largest stiffness drawn
BOX = 0.1  # m, half side of the states' and anchors' box
ROUNDING = 64 * np.finfo(float).eps * (K * 4 * BOX + 600.0)  # of forces: products of these, each to a few units


def between(low, high):
    return st.floats(low, high, allow_subnormal=False)


def vectors(most):
    return st.tuples(*[between(-most, most)] * 3).map(np.array)


def directions():
    return vectors(1.0).filter(lambda n: np.linalg.norm(n) > 0.1).map(lambda n: n / np.linalg.norm(n))


def velocities():
    return st.builds(lambda n, s: n * s, directions(), between(0, SPEED_MAX))


def resistances():
    return st.builds(
        lambda k, b, r0, way, o, blend: resistance_row(
            stiffness=k, damping=b, dead_radius=r0, full_radius=r0 + way, origin=o, blend=blend
        ),
        between(0, K),
        between(0, 500),
        between(0, 0.01),
        between(1e-3, 0.05),
        vectors(BOX),
        between(1e-4, 0.01),
    )


def springs():
    return st.builds(
        lambda k, b, o: spring_row(stiffness=k, damping=b, point=o), between(0, K), between(0, 500), vectors(BOX)
    )


def homes():
    return st.builds(
        lambda k, b, s, o: home_row(stiffness=k, damping=b, speed=s, origin=o),
        between(1, K),
        between(0.1, 500),
        between(0.01, 1),
        vectors(BOX),
    )


def walls():
    return st.builds(
        lambda k, b, o, n, blend: wall_row(stiffness=k, damping=b, point=o, normal=n, blend=blend),
        between(0, K),
        between(0, 500),
        vectors(BOX),
        directions(),
        between(1e-4, 0.01),
    )


def constants():
    return vectors(5.0).map(constant_row)


def laws():
    return st.one_of(resistances(), springs(), homes(), walls(), constants())


def steepness(row):
    """Bounds of |dF/dp| at the largest speed drawn and of |dF/dv|, read from the parameters alone."""
    k, b = row[STIFFNESS], row[DAMPING]
    return k + (b * SPEED_MAX / row[BLEND] if row[BLEND] else 0.0), b


@st.composite
def near_edges(draw, row):
    """A position anywhere, or within 20 um of the surface on which the law changes."""
    if draw(st.booleans()):
        return draw(vectors(BOX))
    n, off = draw(directions()), draw(between(-2e-5, 2e-5))
    anchor = row[ANCHOR : ANCHOR + 3]
    if row[KIND] == WALL:
        normal = row[FIRST : FIRST + 3]
        return anchor + (n - normal * (n @ normal)) * 0.01 + off * normal
    return anchor + n * (draw(st.sampled_from([0.0, row[FIRST], row[FIRST + 1]])) + off)
