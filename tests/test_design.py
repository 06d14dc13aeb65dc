"""The design file: what is accepted, what is refused and with which words, and that nothing is lost on the way."""

from __future__ import annotations

import copy
import json
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from delta_cad import catalogue
from delta_cad.design import (
    HARDWARE_FAMILIES,
    Design,
    DesignError,
    design_from_dict,
    design_hash,
    design_schema,
    design_to_dict,
    design_to_json,
    load_design,
)
from delta_cad.design_sums import impossible_sum
from delta_cad.mechanism import DeltaGeometry, UnreachableError, closure_margin, inverse_kinematics

BEST = Path(__file__).parent.parent / "best.json"
MISSING = object()
UNTIMED = settings(deadline=None)  # nothing is timed in a test: the machine may be shared


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


# What is accepted


def test_the_committed_design_is_the_published_optimum_with_the_hardware_spelled_out() -> None:
    design = load_design(BEST)
    g = design.geometry
    assert isinstance(g, DeltaGeometry)
    lengths = (g.base_radius, g.platform_radius, g.upper_arm_length, g.forearm_length)
    assert lengths == pytest.approx((0.040, 0.030, 0.082, 0.112079), rel=1e-15)  # one rounding of mm / 1000
    assert (design.mechanism.parallelogram_width_mm, design.cube.half_side_mm) == (54.0, 37.5)
    assert design.requirements.lean_max_deg == 28.0
    raw = json.loads(BEST.read_text(encoding="utf-8"))
    assert raw["hardware"] == design_from_dict(minimal()).model_dump()["hardware"]


def test_what_may_be_missing_has_the_promised_defaults() -> None:
    design = design_from_dict(minimal())
    assert design.requirements.clearance_min_mm == 1.0
    assert design.requirements.gravity_m_s2 == (0.0, 0.0, -9.81)
    for name in ("kappa_max", "lean_max_deg", "shoulder_min_deg", "shoulder_max_deg"):
        assert getattr(design.requirements, name) is None
    assert design.provenance == {}
    hardware = design.hardware
    assert (hardware.drive, hardware.capstan_ratio, hardware.sector_radius_mm) == ("capstan", 9.85, 40.0)
    for entry, family in HARDWARE_FAMILIES.items():
        assert getattr(hardware, entry) in catalogue.family(family)


def test_whole_numbers_are_numbers() -> None:
    assert design_from_dict(changed("mechanism.base_radius_mm", 40)) == design_from_dict(minimal())


def test_a_design_cannot_be_changed_by_accident() -> None:
    with pytest.raises(ValueError, match="frozen"):
        design_from_dict(minimal()).mechanism.base_radius_mm = 41.0  # pyright: ignore[reportAttributeAccessIssue]


# Nothing is lost

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


@UNTIMED
@given(design=designs())
def test_what_is_written_is_read_back_to_the_last_bit(design: Design, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("design") / "design.json"
    path.write_text(design_to_json(design), encoding="utf-8")
    again = load_design(path)
    assert again == design
    assert design_hash(again) == design_hash(design)
    assert re.fullmatch(r"[0-9a-f]{64}", design_hash(design))


def test_the_hash_sees_values_and_not_their_spelling() -> None:
    plain = design_from_dict(minimal())
    reordered = json.loads(json.dumps(minimal(), sort_keys=True))
    spelled_out = design_to_dict(plain)
    assert design_hash(design_from_dict(reordered)) == design_hash(plain)
    assert design_hash(design_from_dict(spelled_out)) == design_hash(plain)
    for path, value in (
        ("mechanism.forearm_length_mm", math.nextafter(112.079, 200.0)),
        ("requirements.lean_max_deg", 28.0),
        ("hardware.knob", "din319-32"),
        ("provenance", {"seed": 1}),
    ):
        assert design_hash(design_from_dict(changed(path, value))) != design_hash(plain)


def test_requirements_that_are_not_given_are_not_written() -> None:
    written = json.loads(design_to_json(design_from_dict(changed("requirements.kappa_max", None))))["requirements"]
    assert sorted(set(written) - set(minimal()["requirements"])) == ["clearance_min_mm", "gravity_m_s2"]


def test_null_in_the_provenance_survives() -> None:
    design = design_from_dict(changed("provenance", {"gap": None}))
    assert json.loads(design_to_json(design))["provenance"] == {"gap": None}


# What is refused: (field to change, value, field that is blamed, words that must be there)

REFUSED = [
    ("mechanism.forearm_length_mm", -3, "mechanism.forearm_length_mm = -3: must be > 0 and <= 1000 mm"),
    ("mechanism.forearm_length_mm", 0, "mechanism.forearm_length_mm = 0: must be > 0 and <= 1000 mm"),
    ("mechanism.forearm_length_mm", 1000.5, "mechanism.forearm_length_mm = 1000.5: must be > 0 and <= 1000 mm"),
    ("mechanism.forearm_length_mm", "112", 'mechanism.forearm_length_mm = "112": must be a number > 0'),
    ("mechanism.forearm_length_mm", True, "mechanism.forearm_length_mm = true: must be a number > 0"),
    ("mechanism.forearm_length_mm", None, "mechanism.forearm_length_mm = null: must be a number > 0"),
    ("mechanism.forearm_length_mm", [1.0], "mechanism.forearm_length_mm = [1.0]: must be a number > 0"),
    ("mechanism.forearm_length_mm", 10**400, "mechanism.forearm_length_mm = 1000000"),
    ("mechanism.forearm_length_mm", MISSING, "mechanism.forearm_length_mm: is missing; must be a number > 0"),
    (
        "mechanism.forearm_mm",
        3,
        "mechanism.forearm_mm = 3: unknown key; known here: base_radius_mm, platform_radius_mm",
    ),
    ("mechanism", MISSING, "mechanism: is missing; must be an object"),
    ("mechanism", [], "mechanism = []: must be an object"),
    ("motor", "x", 'motor = "x": unknown key; known here: schema, name, mechanism, cube, requirements, hardware'),
    ("schema", "delta-design/2", 'schema = "delta-design/2": must be "delta-design/1"'),
    ("schema", 1, 'schema = 1: must be "delta-design/1"'),
    ("schema", MISSING, 'schema: is missing; must be "delta-design/1"'),
    ("cube.half_side_mm", math.nan, "cube.half_side_mm = NaN: must be finite"),
    ("cube.half_side_mm", -math.inf, "cube.half_side_mm = -Infinity: must be finite"),
    ("cube.bottom_height_mm", -1.0, "cube.bottom_height_mm = -1.0: must be > 0 and <= 2000 mm"),
    ("requirements.force_N", 0, "requirements.force_N = 0: must be > 0 and <= 1000 N"),
    ("requirements.joint_torque_N_m", 0, "requirements.joint_torque_N_m = 0: must be > 0 and <= 100 N m"),
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
    ("provenance", {"when": object()}, "provenance.when = "),
]


@pytest.mark.parametrize(("path", "value", "words"), REFUSED, ids=lambda item: str(item)[:40])
def test_a_bad_field_is_named_with_its_value_and_what_is_allowed(path: str, value: object, words: str) -> None:
    with pytest.raises(DesignError) as caught:
        design_from_dict(changed(path, value), "best.json")
    error = caught.value
    assert str(error).startswith(f"best.json: {words}")
    assert "\n" not in str(error)
    assert error.file == "best.json"
    assert error.field == re.split(r" = |: ", words)[0]
    assert error.allowed


@pytest.mark.parametrize(
    "name", ["", ".", "..", "a/b", "a\\b", "a b", "-a", "a-", "x\n", "a.rejected", "ä", "a" * 65, 5]
)
def test_names_that_are_not_safe_as_file_names_are_refused(name: object) -> None:
    with pytest.raises(DesignError, match="safe as a file name") as caught:
        design_from_dict(changed("name", name))
    assert caught.value.field == "name"


@pytest.mark.parametrize("name", ["a", "A1", "dashboard-joystick", "x_2", "a" * 64])
def test_names_that_are_safe_as_file_names_are_accepted(name: str) -> None:
    assert design_from_dict(changed("name", name)).name == name


@pytest.mark.parametrize(
    ("motor", "drive", "legal"),
    [
        ("maxon-ec60flat-625858", "capstan", "maxon-re30-310007"),
        ("maxon-re30-310007", "direct", "maxon-ec60flat-625858"),
    ],
)
def test_a_motor_that_does_not_suit_the_drive_is_refused(motor: str, drive: str, legal: str) -> None:
    data = minimal() | {"hardware": {"motor": motor, "drive": drive}}
    with pytest.raises(DesignError, match=f"is not for the {drive} drive; must be one of .*{legal}") as caught:
        design_from_dict(data)
    assert caught.value.field == "hardware.motor"
    assert design_from_dict(minimal() | {"hardware": {"motor": legal, "drive": drive}}).hardware.motor == legal


@pytest.mark.parametrize(("data", "value"), [([], "[]"), ("design", '"design"'), (None, "null"), (3, "3")])
def test_a_file_that_holds_no_object_is_refused(data: object, value: str) -> None:
    with pytest.raises(DesignError, match="must be an object") as caught:
        design_from_dict(data, "best.json")
    assert str(caught.value) == f"best.json: {value}: must be an object"


def test_a_long_value_is_cut_short_in_the_message() -> None:
    with pytest.raises(DesignError) as caught:
        design_from_dict(changed("mechanism.base_radius_mm", "x" * 10_000))
    assert len(str(caught.value)) < 200


# Files

FILES = {
    "empty": ("", "is not JSON"),
    "broken": ('{"schema": ', "is not JSON: Expecting value at line 1 column 12"),
    "repeated": ('{"name": "a", "name": "b"}', 'name = "b": is given more than once'),
    "repeated_inside": (
        '{"cube": {"half_side_mm": 1, "half_side_mm": 2}}',
        "half_side_mm = 2: is given more than once",
    ),
    "overflow": ('{"schema": "delta-design/1", "name": 1e999}', "name = Infinity: must be finite"),
    "nan": ('{"schema": "delta-design/1", "name": NaN}', "name = NaN: must be finite"),
    "digits": ("9" * 5000, "is not JSON we can read"),
    "deep": ("[" * 100_000, "is not JSON we can read"),
}


@pytest.mark.parametrize("case", FILES)
def test_a_bad_file_is_refused_in_one_line(case: str, tmp_path: Path) -> None:
    text, words = FILES[case]
    path = tmp_path / "design.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DesignError) as caught:
        load_design(path)
    assert words in str(caught.value)
    assert str(caught.value).startswith("design.json: ")
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_or_not_text_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DesignError, match=r"none\.json: cannot be read: No such file"):
        load_design(tmp_path / "none.json")
    with pytest.raises(DesignError, match="cannot be read: Is a directory"):
        load_design(tmp_path)
    (tmp_path / "latin.json").write_bytes(b'{"name": "\xe4"}')
    with pytest.raises(DesignError, match="is not UTF-8 text"):
        load_design(tmp_path / "latin.json")


def test_data_nested_too_deep_is_refused() -> None:
    deep: list[Any] = []
    for _ in range(100_000):
        deep = [deep]
    with pytest.raises(DesignError, match="is nested too deep"):
        design_from_dict(changed("provenance", {"deep": deep}))
    while deep:  # taken apart by hand: freeing it in one go would recurse just as deep
        deep = deep.pop()


# Lengths that cannot go together


def test_a_cube_under_the_fold_is_refused_with_the_height_of_the_fold() -> None:
    bound = 112.079 - 82.0  # a = R - r = 10 lies inside the cube's half side: the fold is straight above it
    design_from_dict(changed("cube.bottom_height_mm", bound + 1e-9))
    with pytest.raises(DesignError, match=r"must be >= 30\.079 mm, where upper arm and forearm fold in line") as caught:
        design_from_dict(changed("cube.bottom_height_mm", bound - 1e-9))
    assert caught.value.field == "cube.bottom_height_mm"


@UNTIMED
@given(
    st.floats(20, 60), st.floats(20, 60), st.floats(50, 120), st.floats(50, 200), st.floats(10, 150), st.floats(5, 60)
)
def test_a_refused_cube_has_a_point_the_mechanism_cannot_reach(
    base: float, platform: float, arm: float, forearm: float, bottom: float, side: float
) -> None:
    """Oracle: the inverse kinematics of the mechanism, which knows eq. (7) in another form."""
    data = minimal()
    data["mechanism"] |= {
        "base_radius_mm": base,
        "platform_radius_mm": platform,
        "upper_arm_length_mm": arm,
        "forearm_length_mm": forearm,
        "parallelogram_width_mm": 10.0,
    }
    data["cube"] = {"bottom_height_mm": bottom, "half_side_mm": side}
    g = DeltaGeometry(base / 1e3, platform / 1e3, arm / 1e3, forearm / 1e3)
    corners = np.array([(x, y, z) for x in (-side, side) for y in (-side, side) for z in (bottom, bottom + 2 * side)])
    nearest = np.array([np.clip(base - platform, -side, side), 0.0, bottom])
    points = np.vstack([corners, nearest]) / 1e3
    try:
        design = design_from_dict(data)
    except DesignError:
        with pytest.raises(UnreachableError):
            inverse_kinematics(g, points)
    else:
        # the bounds carry a slack of 1e-12 relative, so margins (m^2) may be below zero by that much
        assert closure_margin(g, points).min() >= -1e-12
        assert impossible_sum(design) is None


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("mechanism.forearm_length_mm", 60.0, r"must be >= 73\.1547 mm for chain 1 to reach the cube's corner"),
        ("mechanism.platform_radius_mm", 122.0, r"must be < 122 mm, base_radius_mm \+ upper_arm_length_mm"),
        ("mechanism.parallelogram_width_mm", 87.93, r"must be < 87\.923 mm, or the balls of neighbouring chains meet"),
        ("hardware.capstan_ratio", 12.3, r"must be < 12\.2324, or the pinion's groove .* cuts into the motor's 6 mm"),
    ],
)
def test_an_impossible_sum_is_refused_with_the_bound(path: str, value: float, words: str) -> None:
    with pytest.raises(DesignError, match=words) as caught:
        design_from_dict(changed(path, value))
    assert caught.value.field == path


def test_a_forearm_too_long_for_a_corner_is_refused() -> None:
    """With R - r outside the cube a corner is nearer to shoulder 1 than any point is to shoulder 0."""
    data = minimal()
    data["mechanism"] |= {"base_radius_mm": 100.0, "platform_radius_mm": 20.0, "forearm_length_mm": 153.0}
    data["mechanism"]["parallelogram_width_mm"] = 20.0
    data["cube"] = {"bottom_height_mm": 20.0, "half_side_mm": 10.0}
    u, v = (
        10.0 * (math.cos(math.pi / 3) + math.sin(math.pi / 3)),
        10.0 * (math.sin(math.pi / 3) - math.cos(math.pi / 3)),
    )
    bound = math.hypot(v, math.hypot(u - 80.0, 20.0) + 82.0)  # 151.33 mm
    with pytest.raises(DesignError, match=rf"must be <= {bound:.6g} mm for chain [12] to reach") as caught:
        design_from_dict(data)
    assert caught.value.field == "mechanism.forearm_length_mm"
    data["mechanism"]["forearm_length_mm"] = bound - 1e-6
    design_from_dict(data)


def test_the_balls_meet_where_the_bound_says() -> None:
    """Oracle: the wrist centres themselves, placed by rotation."""
    bound = 87.923048  # 2 sqrt(3) 30 - 2 x 8
    r, half = 30.0, bound / 2.0
    turn = np.exp(2j * np.pi / 3.0)
    distance = abs((r + 1j * half) - turn * (r - 1j * half))
    assert distance == pytest.approx(8.0, abs=1e-6)  # the bound is written to 1e-6 mm
    design_from_dict(changed("mechanism.parallelogram_width_mm", bound - 1e-6))


def test_a_pinion_bound_does_not_concern_a_direct_drive() -> None:
    hardware = {"drive": "direct", "motor": "maxon-ec60flat-625858", "capstan_ratio": 30.0}
    assert design_from_dict(minimal() | {"hardware": hardware}).hardware.drive == "direct"


def test_the_shoulder_range_must_not_be_empty() -> None:
    data = minimal()
    data["requirements"] |= {"shoulder_min_deg": 10.0, "shoulder_max_deg": 10.0}
    with pytest.raises(DesignError, match="must be > shoulder_min_deg = 10 deg") as caught:
        design_from_dict(data)
    assert caught.value.field == "requirements.shoulder_max_deg"


# The schema


def violations(schema: dict[str, Any], data: object, root: dict[str, Any]) -> list[str]:
    """A small JSON Schema checker, for the keywords that the schema uses; an unknown keyword fails."""
    found: list[str] = []
    for key, rule in schema.items():
        number = isinstance(data, int | float) and not isinstance(data, bool)
        match key:
            case "title" | "description" | "default" | "$defs" | "$schema" | "items":
                pass
            case "$ref":
                found += violations(root["$defs"][rule.removeprefix("#/$defs/")], data, root)
            case "type":
                kinds = {
                    "object": isinstance(data, dict),
                    "array": isinstance(data, list),
                    "string": isinstance(data, str),
                    "number": number,
                    "null": data is None,
                }
                found += [] if kinds[rule] else [key]
            case "required":
                found += [f"{key} {name}" for name in rule if isinstance(data, dict) and name not in data]
            case "properties" if isinstance(data, dict):
                found += [f"{n}: {v}" for n in rule if n in data for v in violations(rule[n], data[n], root)]
            case "additionalProperties" if isinstance(data, dict) and rule is False:
                found += [f"{key} {name}" for name in data if name not in schema["properties"]]
            case "properties" | "additionalProperties":
                pass
            case "const":
                found += [] if data == rule else [key]
            case "enum":
                found += [] if data in rule else [key]
            case "pattern":
                found += [] if not isinstance(data, str) or re.search(rule, data) else [key]
            case "anyOf":
                found += [] if any(not violations(option, data, root) for option in rule) else [key]
            case "prefixItems":
                pairs = zip(rule, data, strict=False) if isinstance(data, list) else ()
                found += [violation for part, item in pairs for violation in violations(part, item, root)]
            case "minItems":
                found += [key] if isinstance(data, list) and len(data) < rule else []
            case "maxItems":
                found += [key] if isinstance(data, list) and len(data) > rule else []
            case "exclusiveMinimum":
                found += [key] if number and not data > rule else []
            case "minimum":
                found += [key] if number and not data >= rule else []
            case "exclusiveMaximum":
                found += [key] if number and not data < rule else []
            case "maximum":
                found += [key] if number and not data <= rule else []
            case _:
                raise AssertionError(f"the checker does not know {key}")
    return found


def test_the_schema_accepts_what_the_reader_accepts() -> None:
    schema = design_schema()
    assert violations(schema, json.loads(BEST.read_text(encoding="utf-8")), schema) == []
    assert violations(schema, minimal(), schema) == []
    assert violations(schema, json.loads(json.dumps(schema["$defs"]["Hardware"]["properties"])), schema) != []


@UNTIMED
@given(design=designs())
def test_the_schema_accepts_every_written_design(design: Design) -> None:
    schema = design_schema()
    assert violations(schema, json.loads(design_to_json(design)), schema) == []


IN_SCHEMA = [
    (path, value)
    for path, value, _ in REFUSED
    if "provenance" not in path and not (isinstance(value, float) and not math.isfinite(value))
]


@pytest.mark.parametrize(("path", "value"), IN_SCHEMA, ids=lambda item: str(item)[:40])
def test_the_schema_refuses_what_the_reader_refuses(path: str, value: object) -> None:
    schema = design_schema()
    assert violations(schema, changed(path, value), schema) != []


def test_the_schema_is_json_and_does_not_change_when_read() -> None:
    schema = design_schema()
    untouched = copy.deepcopy(schema)
    schema["$defs"]["Hardware"]["properties"]["motor"]["enum"].clear()
    assert design_schema() == untouched == json.loads(json.dumps(untouched))


# What it costs


def test_importing_the_design_loads_no_cad_and_no_numerics() -> None:
    """Cheap to import: the command line's --help must stay under half a second."""
    code = "import sys, delta_cad.design, delta_cad.drive; print(*sorted(set(m.split('.')[0] for m in sys.modules)))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"cadquery", "OCP", "trimesh", "fcl", "numpy", "scipy", "matplotlib"} & set(loaded)
