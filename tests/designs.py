"""Designs to read and to refuse: the least one, one field of it changed, random ones, and what a reader must say."""

from __future__ import annotations

import math
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


def hanging() -> dict[str, Any]:
    """A design within reach and without a singularity, whose platform hangs below its elbows: det S < 0."""
    lengths = {"base_radius_mm": 56.0, "platform_radius_mm": 24.0, "upper_arm_length_mm": 99.0}
    lengths |= {"forearm_length_mm": 87.0, "parallelogram_width_mm": 30.0}
    return minimal() | {"mechanism": lengths, "cube": {"bottom_height_mm": 34.5, "half_side_mm": 9.5}}


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

REFUSED = [
    ("mechanism.forearm_length_mm", -3, "mechanism.forearm_length_mm = -3: must be > 0 and <= 2000 mm"),
    ("mechanism.forearm_length_mm", 0, "mechanism.forearm_length_mm = 0: must be > 0 and <= 2000 mm"),
    ("mechanism.forearm_length_mm", 2000.5, "mechanism.forearm_length_mm = 2000.5: must be > 0 and <= 2000 mm"),
    ("mechanism.forearm_length_mm", "112", 'mechanism.forearm_length_mm = "112": must be a number > 0'),
    ("mechanism.forearm_length_mm", True, "mechanism.forearm_length_mm = true: must be a number > 0"),
    ("mechanism.forearm_length_mm", None, "mechanism.forearm_length_mm = null: must be a number > 0"),
    ("mechanism.forearm_length_mm", [1.0], "mechanism.forearm_length_mm = [1.0]: must be a number > 0"),
    ("mechanism.forearm_length_mm", 10**400, "mechanism.forearm_length_mm = 1000000"),
    ("mechanism.forearm_length_mm", MISSING, "mechanism.forearm_length_mm: is missing; must be a number > 0"),
    (
        "mechanism.forearm_mm",
        3,
        "mechanism.forearm_mm = 3: unknown key; did you mean forearm_length_mm? known here: base_radius_mm, platform",
    ),
    ("mechanism", MISSING, "mechanism: is missing; must be an object"),
    ("mechanism", [], "mechanism = []: must be an object"),
    (
        "motor",
        "x",
        'motor = "x": unknown key; did you mean hardware.motor? known here: schema, name, mechanism',
    ),
    ("schema", "delta-design/2", 'schema = "delta-design/2": must be "delta-design/1"'),
    ("schema", 1, 'schema = 1: must be "delta-design/1"'),
    ("schema", MISSING, 'schema: is missing; must be "delta-design/1"'),
    ("cube.half_side_mm", math.nan, "cube.half_side_mm = NaN: must be finite"),
    ("cube.half_side_mm", -math.inf, "cube.half_side_mm = -Infinity: must be finite"),
    ("cube.bottom_height_mm", -1.0, "cube.bottom_height_mm = -1.0: must be > 0 and <= 2000 mm"),
    ("requirements.force_N", 0, "requirements.force_N = 0: must be >= 1e-06 and <= 1000 N"),
    ("requirements.joint_torque_N_m", 0, "requirements.joint_torque_N_m = 0: must be >= 1e-06 and <= 100 N m"),
    ("requirements.peak_torque_N_m", 101, "requirements.peak_torque_N_m = 101: must be > 0 and <= 100 N m"),
    ("requirements.kappa_max", 0.5, "requirements.kappa_max = 0.5: must be >= 1 and <= 1e+06"),
    ("requirements.lean_max_deg", 90, "requirements.lean_max_deg = 90: must be > 0 and < 90 deg"),
    ("requirements.clearance_min_mm", -1, "requirements.clearance_min_mm = -1: must be >= 0 and <= 100 mm"),
    ("requirements.gravity_m_s2", [0, 0], "requirements.gravity_m_s2[2]: is missing; must be a list of 3 numbers"),
    ("requirements.gravity_m_s2", [0, 0, "9"], 'requirements.gravity_m_s2[2] = "9": must be a list of 3 numbers'),
    ("requirements.gravity_m_s2", [0, 0, -9810], "requirements.gravity_m_s2[2] = -9810: must be a list of 3 numbers"),
    ("requirements.gravity_m_s2", -9.81, "requirements.gravity_m_s2 = -9.81: must be a list of 3 numbers"),
    ("hardware", None, "hardware = null: must be an object"),
    ("hardware.drive", "belt", 'hardware.drive = "belt": must be "capstan" or "direct"'),
    ("hardware.capstan_ratio", 1, "hardware.capstan_ratio = 1: must be >= 2 and <= 30"),
    ("hardware.motor", 7, "hardware.motor = 7: must be one of maxon-re30-310007, "),
    ("hardware.motor", "re30", 'hardware.motor = "re30": must be one of maxon-re30-310007, '),
    ("hardware.bearing", "689", 'hardware.bearing = "689": must be one of 688, '),
    ("provenance", [], "provenance = []: must be an object"),
    ("provenance", {"gap": [1.0, math.inf]}, "provenance.gap[1] = Infinity: must be finite"),
    ("provenance", {"when": Marked("a time")}, "provenance.when = "),
]
