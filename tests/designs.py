"""Designs to read and to refuse: the least one, one field of it changed, random ones, and what a reader must say."""

from __future__ import annotations

from typing import Any

from hypothesis import settings
from hypothesis import strategies as st

from delta_cad.design import Design, design_from_dict


class Marked:
    """A value that is like no other, and has the same name in every process."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __repr__(self) -> str:
        return self.name


MISSING = Marked("missing")
UNTIMED = settings(deadline=None)  # nothing is timed in a test: the machine may be shared


def named(item: object) -> str:
    """Short name of a parameter in a test's id."""
    return str(item)[:40]


def minimal() -> dict[str, Any]:
    """The published optimum with nothing that has a default."""
    return {
        "schema": "delta-design/1",
        "name": "dashboard-joystick",
        "mechanism": {
            "base_radius_mm": 40.0,
            "platform_radius_mm": 30.0,
            "upper_arm_length_mm": 82.0,
            "forearm_length_mm": 112.079,
            "parallelogram_width_mm": 54.0,
        },
        "cube": {"bottom_height_mm": 57.112, "half_side_mm": 37.5},
        "requirements": {
            "envelope_width_mm": 270.0,
            "envelope_depth_mm": 220.0,
            "force_N": 3.0,
            "joint_torque_N_m": 0.8,
        },
    }


def below_elbows() -> dict[str, Any]:
    """A design within reach and without a singularity, whose platform hangs below its elbows: det S < 0."""
    lengths = {"base_radius_mm": 56.0, "platform_radius_mm": 24.0, "upper_arm_length_mm": 99.0}
    lengths |= {"forearm_length_mm": 87.0, "parallelogram_width_mm": 30.0}
    return minimal() | {"mechanism": lengths, "cube": {"bottom_height_mm": 34.5, "half_side_mm": 9.5}}


def placed() -> dict[str, Any]:
    """Three equal chains placed for a rectangle, a capstan machine that can be built; chains 1 and 2 stand farther out.

    Its parts are those of a three-fold symmetric machine but for base plate and platform; its outline is wide.
    """
    mechanism = {"platform_radius_mm": 22.55, "upper_arm_length_mm": 94.4, "forearm_length_mm": 148.4}
    mechanism |= {"parallelogram_width_mm": 50.0, "azimuths_deg": [0.0, 116.3, -116.3]}
    return minimal() | {
        "name": "placed",
        "mechanism": mechanism | {"base_radii_mm": [30.8, 38.45, 38.45]},
        "cube": {"bottom_height_mm": 75.8, "half_side_mm": 43.9, "centre_x_mm": 11.1},
        "requirements": {
            "envelope_width_mm": 280.0,
            "envelope_depth_mm": 232.0,
            "force_N": 2.9,
            "joint_torque_N_m": 0.395,
            "clearance_min_mm": 2.0,
        },
        "hardware": {
            "capstan_ratio": 4.85,
            "sector_radius_mm": 39.6,
            "arm_thickness_mm": 5.0,
            "ball_diameter_mm": 6.0,
            "leads": "bent",
        },
        "panel": {"thickness_mm": 2.0, "limit_mm": 3.0},
    }


def changed(path: str, value: object) -> dict[str, Any]:
    """The minimal design with one field changed, or taken away."""
    data = minimal()
    *sections, last = path.split(".")
    place = data
    for section in sections:
        place = place.setdefault(section, {})
    if value is MISSING:
        del place[last]
    else:
        place[last] = value
    return data


PLAIN = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**53), 2**53)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


@st.composite
def designs(draw: st.DrawFn) -> Design:
    """Designs of the sizes that the build is made for, all of them possible."""
    data = minimal()
    data["name"] = draw(st.from_regex(r"[A-Za-z0-9]([A-Za-z0-9_-]{0,20}[A-Za-z0-9])?", fullmatch=True))
    arm, forearm = draw(st.floats(75, 90)), draw(st.floats(100, 150))
    data["mechanism"] |= {
        "upper_arm_length_mm": arm,
        "forearm_length_mm": forearm,
        "platform_radius_mm": draw(st.floats(25, 40)),
        "parallelogram_width_mm": draw(st.floats(40, 60)),
    }
    # at least 8 mm over the fold, and low enough that no corner is out of reach
    data["cube"] = {"bottom_height_mm": forearm - arm + draw(st.floats(8, 15)), "half_side_mm": draw(st.floats(5, 12))}
    optional = {"kappa_max": 3.0, "lean_max_deg": 28.0, "shoulder_min_deg": -45.0, "shoulder_max_deg": 80.0}
    data["requirements"] |= {key: optional[key] for key in draw(st.sets(st.sampled_from(sorted(optional))))}
    data["requirements"]["gravity_m_s2"] = draw(st.tuples(*[st.floats(-10, 10)] * 3).map(list))
    data["hardware"] = {
        "capstan_ratio": draw(st.floats(5, 12)),
        "tube": draw(st.sampled_from(["cfrp-5x3", "cfrp-6x4"])),
    }
    data["provenance"] = draw(st.dictionaries(st.text(max_size=5), PLAIN, max_size=3))
    return design_from_dict(data)


# What is refused: (field to change, value, field that is blamed, words that must be there)
