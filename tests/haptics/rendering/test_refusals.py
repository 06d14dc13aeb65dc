"""What laws, their table and the functions of states refuse: the field, its value and its bound are named."""

import math

import numpy as np
import pytest

from haptics.rendering import force, law_table, stored_energy
from haptics.rendering.law import FIRST, GAIN, KIND, LawError
from haptics.rendering.laws.constant_force import ConstantForce
from haptics.rendering.laws.home import Home
from haptics.rendering.laws.operating_resistance import OperatingResistance
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.laws.virtual_wall import VirtualWall, axis_wall
from haptics.rendering.registry import COLUMNS, LAWS

NAN, INF = math.nan, math.inf
REFUSED = [
    (OperatingResistance, {"stiffness": -1.0}, "stiffness is -1.0 N/m"),
    (OperatingResistance, {"stiffness": NAN}, "stiffness is nan"),
    (OperatingResistance, {"damping": -1.0}, "damping is -1.0 N s/m"),
    (OperatingResistance, {"damping": INF}, "damping is inf"),
    (OperatingResistance, {"dead_radius": -1e-3}, "dead_radius is -0.001 m"),
    (OperatingResistance, {"full_radius": INF}, "full_radius is inf m"),
    (OperatingResistance, {"full_radius": 1e-3}, "full_radius is 0.001 m.* dead_radius, 0.001 m"),
    (OperatingResistance, {"blend": 0.0}, "blend is 0.0 m"),
    (OperatingResistance, {"origin": (0, 0)}, "origin is"),
    (SpringDamper, {"stiffness": -1.0}, "stiffness is -1.0"),
    (SpringDamper, {"damping": -1.0}, "damping is -1.0"),
    (SpringDamper, {"point": (0, NAN, 0)}, "point is"),
    (ConstantForce, {"force": (0, INF, 0)}, "force is"),
    (Home, {"stiffness": 0.0}, "stiffness is 0.0 N/m"),
    (Home, {"damping": 0.0}, "damping is 0.0 N s/m"),
    (Home, {"speed": 0.0}, "speed is 0.0 m/s"),
    (Home, {"origin": (0, 0, INF)}, "origin is"),
    (VirtualWall, {"stiffness": -1.0}, "stiffness is -1.0"),
    (VirtualWall, {"damping": NAN}, "damping is nan"),
    (VirtualWall, {"normal": (0, 0, 0)}, r"normal is \(0, 0, 0\)"),
    (VirtualWall, {"normal": (0, 0, NAN)}, "normal is"),
    (VirtualWall, {"point": 3.0}, "point is"),
    (VirtualWall, {"blend": -1.0}, "blend is -1.0 m"),
    (axis_wall, {"met": "x"}, "met is 'x'"),
    (axis_wall, {"met": "+w"}, "met is"),
    (axis_wall, {"met": "*x"}, "met is"),
    (axis_wall, {"position": NAN}, "position is nan m"),
]
ACCEPTED = {
    OperatingResistance: {"stiffness": 1.0, "damping": 1.0, "dead_radius": 1e-3, "full_radius": 2e-3},
    SpringDamper: {"stiffness": 1.0, "damping": 1.0, "point": (0, 0, 0)},
    ConstantForce: {"force": (0, 0, 1)},
    Home: {"stiffness": 1.0, "damping": 1.0, "speed": 1.0},
    VirtualWall: {"stiffness": 1.0, "point": (0, 0, 0), "normal": (0, 0, 1)},
    axis_wall: {"met": "+x", "position": 0.1, "stiffness": 1.0},
}


@pytest.mark.parametrize(("builder", "change", "says"), REFUSED)
def test_a_law_names_field_value_and_bound(builder, change, says):
    law_table(builder(**ACCEPTED[builder]))
    with pytest.raises(LawError, match=says):
        builder(**ACCEPTED[builder] | change)


@pytest.mark.parametrize(
    ("column", "value", "says"),
    [
        (KIND, -9.0, "law 1 .* kind -9.*" + ", ".join(map(str, LAWS))),
        (GAIN, 1.5, "law 1 .*gain .*1.5"),
        (GAIN, -0.1, "law 1 .*gain .*-0.1"),
        (FIRST, NAN, "law 1 .*nan"),
    ],
)
def test_a_table_refuses_what_is_no_law(column, value, says):
    bad = law_table(ConstantForce((0, 0, 1)))
    bad[0, column] = value
    with pytest.raises(LawError, match=says):
        law_table(ConstantForce((0, 0, 1)), bad)


def test_table_refuses_another_shape():
    with pytest.raises(LawError, match=rf"\({COLUMNS - 1},\).*\({COLUMNS},\)"):
        law_table(np.zeros(COLUMNS - 1))
    with pytest.raises(LawError, match=rf"\(1, 1, {COLUMNS}\)"):
        law_table(np.zeros((1, 1, COLUMNS)))


@pytest.mark.parametrize(
    ("p", "v", "says"),
    [
        (0.0, (0, 0, 0), r"p .*\(\)"),
        ((0, 0), (0, 0, 0), r"p .*\(2,\)"),
        ((0, 0, 0), (0, 0), r"v .*\(2,\)"),
        ((0, NAN, 0), (0, 0, 0), "p .*nan"),
        ((0, 0, 0), (INF, 0, 0), "v .*inf"),
    ],
)
def test_states_are_refused(p, v, says):
    with pytest.raises(LawError, match=says):
        force(ConstantForce((0, 0, 1)), p, v)


def test_stored_energy_refuses_what_force_refuses():
    with pytest.raises(LawError, match=r"p .*nan"):
        stored_energy(ConstantForce((0, 0, 1)), (NAN, 0, 0))
