"""Random laws, positions near the edges where they change, velocities, and the bounds of their slopes."""

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from haptics.rendering.laws.constant_force import ConstantForce
from haptics.rendering.laws.home import Home
from haptics.rendering.laws.operating_resistance import OperatingResistance
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.laws.virtual_wall import VirtualWall, axis_wall

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
        lambda k, b, r0, way, o, blend: OperatingResistance(
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
        lambda k, b, o: SpringDamper(stiffness=k, damping=b, point=o), between(0, K), between(0, 500), vectors(BOX)
    )


def homes():
    return st.builds(
        lambda k, b, s, o: Home(stiffness=k, damping=b, speed=s, origin=o),
        between(1, K),
        between(0.1, 500),
        between(0.01, 1),
        vectors(BOX),
    )


def walls():
    return st.builds(
        lambda k, b, o, n, blend: VirtualWall(stiffness=k, damping=b, point=o, normal=n, blend=blend),
        between(0, K),
        between(0, 500),
        vectors(BOX),
        directions(),
        between(1e-4, 0.01),
    )


def cube_walls(cube, **parameters):
    """Six walls around a cube, inside of which none is touched."""
    faces = (("+", cube.upper), ("-", cube.lower))
    return tuple(axis_wall(sign + a, face[k], **parameters) for sign, face in faces for k, a in enumerate("xyz"))


def constants():
    return vectors(5.0).map(ConstantForce)


def laws():
    return st.one_of(resistances(), springs(), homes(), walls(), constants())


def steepness(law):
    """Bounds of |dF/dp| at the largest speed drawn and of |dF/dv|, read from the parameters alone."""
    k, b, blend = (getattr(law, name, 0.0) for name in ("stiffness", "damping", "blend"))
    return k + (b * SPEED_MAX / blend if blend else 0.0), b


@st.composite
def near_edges(draw, law):
    """A position anywhere, or within 20 um of the surface on which the law changes."""
    if isinstance(law, ConstantForce) or draw(st.booleans()):
        return draw(vectors(BOX))
    n, off = draw(directions()), draw(between(-2e-5, 2e-5))
    if isinstance(law, VirtualWall):
        return law.point + (n - law.normal * (n @ law.normal)) * 0.01 + off * law.normal
    if isinstance(law, OperatingResistance):
        return law.origin + n * (draw(st.sampled_from([0.0, law.dead_radius, law.full_radius])) + off)
    if isinstance(law, Home):
        return law.origin + n * (draw(st.sampled_from([0.0, law.damping * law.speed / law.stiffness])) + off)
    return law.point + n * off
