"""What the rows of laws, their table and the batches refuse, and with which words."""

import math

import numpy as np
import pytest

from delta_cad.mechanism import Cube
from haptics.rendering import force, stored_energy
from haptics.rendering.kernel import GAIN, KIND, STIFFNESS
from haptics.rendering.laws import (
    LawError,
    axis_wall_row,
    constant_row,
    cube_rows,
    home_row,
    law_table,
    resistance_row,
    spring_row,
    wall_row,
)

NAN, INF = math.nan, math.inf
REFUSED = [
    (resistance_row, {"stiffness": -1.0}, "stiffness is -1.0 N/m; it must be finite and not negative"),
    (resistance_row, {"stiffness": NAN}, "stiffness is nan"),
    (resistance_row, {"damping": -1.0}, "damping is -1.0 N s/m"),
    (resistance_row, {"damping": INF}, "damping is inf"),
    (resistance_row, {"dead_radius": -1e-3}, "dead_radius is -0.001 m"),
    (resistance_row, {"full_radius": INF}, "full_radius is inf m; it must be finite"),
    (resistance_row, {"full_radius": 1e-3}, "full_radius is 0.001 m; it must be greater than dead_radius, 0.001 m"),
    (resistance_row, {"blend": 0.0}, "blend is 0.0 m; it must be finite and positive"),
    (resistance_row, {"origin": (0, 0)}, "origin is .*; it must be three finite numbers"),
    (spring_row, {"stiffness": -1.0}, "stiffness is -1.0"),
    (spring_row, {"damping": -1.0}, "damping is -1.0"),
    (spring_row, {"point": (0, NAN, 0)}, "point is"),
    (constant_row, {"force": (0, INF, 0)}, "force is"),
    (home_row, {"stiffness": 0.0}, "stiffness is 0.0 N/m; it must be finite and positive"),
    (home_row, {"damping": 0.0}, "damping is 0.0 N s/m; it must be finite and positive"),
    (home_row, {"speed": 0.0}, "speed is 0.0 m/s; it must be finite and positive"),
    (home_row, {"origin": (0, 0, INF)}, "origin is"),
    (wall_row, {"stiffness": -1.0}, "stiffness is -1.0"),
    (wall_row, {"damping": NAN}, "damping is nan"),
    (wall_row, {"normal": (0, 0, 0)}, r"normal is \(0, 0, 0\); it must have a direction"),
    (wall_row, {"normal": (0, 0, NAN)}, "normal is"),
    (wall_row, {"point": 3.0}, "point is"),
    (wall_row, {"blend": -1.0}, "blend is -1.0 m"),
    (axis_wall_row, {"met": "x"}, "met is 'x'; it must be \"\\+x\""),
    (axis_wall_row, {"met": "+w"}, "met is"),
    (axis_wall_row, {"met": "*x"}, "met is"),
    (axis_wall_row, {"position": NAN}, "position is nan m; it must be finite"),
    (cube_rows, {"cube": Cube(0.05, 0.0)}, "half_side is 0.0 m; it must be finite and positive"),
]
ACCEPTED = {
    resistance_row: {"stiffness": 1.0, "damping": 1.0, "dead_radius": 1e-3, "full_radius": 2e-3},
    spring_row: {"stiffness": 1.0, "damping": 1.0, "point": (0, 0, 0)},
    constant_row: {"force": (0, 0, 1)},
    home_row: {"stiffness": 1.0, "damping": 1.0, "speed": 1.0},
    wall_row: {"stiffness": 1.0, "point": (0, 0, 0), "normal": (0, 0, 1)},
    axis_wall_row: {"met": "+x", "position": 0.1, "stiffness": 1.0},
    cube_rows: {"cube": Cube(0.05, 0.03), "stiffness": 1.0},
}


@pytest.mark.parametrize(("builder", "change", "says"), REFUSED)
def test_rows_name_field_value_and_bound(builder, change, says):
    law_table(builder(**ACCEPTED[builder]))
    with pytest.raises(LawError, match=says):
        builder(**ACCEPTED[builder] | change)


@pytest.mark.parametrize(
    ("column", "value", "says"),
    [
        (KIND, 9.0, "law 1 is of kind 9; it must be one of 1, 2, 3, 4, 5"),
        (GAIN, 1.5, "law 1 has gain .*1.5.*; it must be between 0 and 1"),
        (GAIN, -0.1, "law 1 has gain"),
        (STIFFNESS, NAN, "law 1 holds .*nan.*; its figures must be finite"),
    ],
)
def test_table_refuses_rows_that_no_builder_makes(column, value, says):
    bad = constant_row((0, 0, 1))
    bad[column] = value
    with pytest.raises(LawError, match=says):
        law_table(constant_row((0, 0, 1)), bad)


def test_table_refuses_another_shape():
    with pytest.raises(LawError, match=r"shape \(11,\); it must be \(12,\)"):
        law_table(np.zeros(11))
    with pytest.raises(LawError, match=r"shape \(1, 1, 12\)"):
        law_table(np.zeros((1, 1, 12)))


@pytest.mark.parametrize(
    ("p", "v", "says"),
    [
        (0.0, (0, 0, 0), r"p has the shape \(\); its last axis must be 3"),
        ((0, 0), (0, 0, 0), r"p has the shape \(2,\)"),
        ((0, 0, 0), (0, 0), r"v has the shape \(2,\)"),
        ((0, NAN, 0), (0, 0, 0), "p holds .*nan.*; it must be finite"),
        ((0, 0, 0), (INF, 0, 0), "v holds .*inf"),
    ],
)
def test_states_are_refused(p, v, says):
    with pytest.raises(LawError, match=says):
        force(constant_row((0, 0, 1)), p, v)


def test_stored_energy_refuses_what_force_refuses():
    with pytest.raises(LawError, match="p holds"):
        stored_energy(constant_row((0, 0, 1)), (NAN, 0, 0))
