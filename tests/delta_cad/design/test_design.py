"""The design file: what is accepted, what is refused and with which words, and that nothing is lost on the way."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given

from delta_cad import catalogue
from delta_cad.design import (
    HARDWARE_FAMILIES,
    Design,
    DesignError,
    design_from_dict,
    design_hash,
    design_to_dict,
    design_to_json,
    load_design,
)
from delta_cad.mechanism import DeltaGeometry
from tests.designs import UNTIMED, changed, designs, minimal

BEST = Path(__file__).parents[3] / "examples" / "synthesized.json"
PUBLISHED = Path(__file__).parents[2] / "references" / "published-optimum.json"


# What is accepted


def test_the_published_optimum_is_kept_next_to_the_committed_design() -> None:
    design = load_design(PUBLISHED)
    g = design.geometry
    assert isinstance(g, DeltaGeometry)
    lengths = (g.base_radius, g.platform_radius, g.upper_arm_length, g.forearm_length)
    assert lengths == pytest.approx((0.040, 0.030, 0.082, 0.112079), rel=1e-15)  # one rounding of mm / 1000
    assert (design.mechanism.parallelogram_width_mm, design.cube.half_side_mm) == (54.0, 37.5)
    assert design.requirements.lean_max_deg == 28.0
    raw = json.loads(PUBLISHED.read_text(encoding="utf-8"))
    assert raw["hardware"] == design_to_dict(design_from_dict(minimal()))["hardware"]


def test_the_committed_design_has_the_hardware_spelled_out_and_lengths_in_whole_micrometres() -> None:
    raw = json.loads(BEST.read_text(encoding="utf-8"))
    stated = {"capstan_ratio": 4.8, "sector_radius_mm": 38.7, "ball_diameter_mm": 6.0, "arm_thickness_mm": 6.0}
    assert raw["hardware"] == design_to_dict(design_from_dict(minimal()))["hardware"] | stated
    lengths = [*raw["mechanism"].values(), *raw["cube"].values()]
    assert lengths == [round(v, 3) for v in lengths]
    assert raw["cube"]["half_side_mm"] >= 43.0  # a cube of 86 mm; the published one has 75 mm at the same kappa
    required = raw["requirements"]
    assert required["kappa_max"] == 2.27
    assert required["couple_index_min"] == 0.4
    assert raw["mechanism"]["base_radius_mm"] + raw["mechanism"]["upper_arm_length_mm"] <= 122.0
    assert required["lean_max_deg"] == 28.0
    assert (required["joint_torque_N_m"], required["peak_torque_N_m"]) == (0.39, 0.8)
    assert (required["force_N"], required["peak_force_N"], required["stiffness_min_N_mm"]) == (3.0, 6.0, 15.0)


def test_what_may_be_missing_has_the_promised_defaults() -> None:
    design = design_from_dict(minimal())
    assert design.requirements.clearance_min_mm == 1.0
    assert design.requirements.gravity_m_s2 == (0.0, 0.0, -9.81)
    for name in ("kappa_max", "lean_max_deg", "shoulder_min_deg", "shoulder_max_deg"):
        assert getattr(design.requirements, name) is None
    assert design.provenance == {}
    hardware = design.hardware
    assert (hardware.drive, hardware.capstan_ratio, hardware.sector_radius_mm) == ("capstan", 9.85, 40.0)
    assert set(HARDWARE_FAMILIES) == {"motor", "cable", "encoder", "bearing", "tube", "knob", "foot", "magnet"}
    for entry in HARDWARE_FAMILIES:
        assert getattr(hardware, entry) in catalogue.family(entry)


def test_whole_numbers_are_numbers() -> None:
    assert design_from_dict(changed("mechanism.base_radius_mm", 40)) == design_from_dict(minimal())


def test_a_design_cannot_be_changed_by_accident() -> None:
    with pytest.raises(ValueError, match="frozen"):
        design_from_dict(minimal()).mechanism.base_radius_mm = 41.0  # pyright: ignore[reportAttributeAccessIssue]


# Nothing is lost


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
        ("revision", "B"),
    ):
        assert design_hash(design_from_dict(changed(path, value))) != design_hash(plain)


def test_requirements_that_are_not_given_are_not_written() -> None:
    written = json.loads(design_to_json(design_from_dict(changed("requirements.kappa_max", None))))["requirements"]
    assert sorted(set(written) - set(minimal()["requirements"])) == ["clearance_min_mm", "gravity_m_s2"]


def test_a_revision_is_a_where_none_is_given_and_leaves_the_hash() -> None:
    plain, first = design_from_dict(minimal()), design_from_dict(changed("revision", None))
    assert (plain.drawn_revision, first.drawn_revision) == ("A", "A")
    assert design_hash(plain) == design_hash(first)
    assert design_from_dict(changed("revision", "2.1-b")).drawn_revision == "2.1-b"
    for bad in ("", "-A", "A B", "A\n", "ABCDEFGHI", 2):
        with pytest.raises(DesignError, match=r"revision = .*must be 1 to 8 letters"):
            design_from_dict(changed("revision", bad))


def test_null_in_the_provenance_survives() -> None:
    design = design_from_dict(changed("provenance", {"gap": None}))
    assert json.loads(design_to_json(design))["provenance"] == {"gap": None}


# What is refused


@pytest.mark.parametrize("name", ["a", "A1", "dashboard-joystick", "x_2", "a" * 64])
def test_names_that_are_safe_as_file_names_are_accepted(name: str) -> None:
    assert design_from_dict(changed("name", name)).name == name


def test_a_long_value_is_cut_short_in_the_message() -> None:
    with pytest.raises(DesignError) as caught:
        design_from_dict(changed("mechanism.base_radius_mm", "x" * 10_000))
    assert len(str(caught.value)) < 200


# Files

FILES = {  # text -> field, value and place
    "digits": ("9" * 5000, "", "", ""),
    "deep": ("[" * 100_000, "", "", ""),
    "long_key": (json.dumps(minimal() | {"k" * 100_000: 1}), "k" * 100_000, "1", "unknown key"),
    "large": ('{"a": "' + " " * 4_000_000 + '"}', "", "", "4 MB"),
}


@pytest.mark.parametrize("case", FILES)
def test_a_bad_file_is_refused_in_one_line(case: str, tmp_path: Path) -> None:
    text, field, value, place = FILES[case]
    path = tmp_path / "design.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DesignError) as caught:
        load_design(path)
    assert (caught.value.file, caught.value.field, caught.value.value) == ("design.json", field, value)
    assert place in caught.value.allowed
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 500


def test_a_file_that_is_not_there_or_not_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "latin.json").write_bytes(b'{"name": "\xe4"}')
    for path in (tmp_path / "none.json", tmp_path, tmp_path / "latin.json"):
        with pytest.raises(DesignError) as caught:
            load_design(path)
        assert (caught.value.file, caught.value.field) == (path.name, "")


def test_data_nested_too_deep_is_refused() -> None:
    deep: list[Any] = []
    for _ in range(100_000):
        deep = [deep]
    with pytest.raises(DesignError):
        design_from_dict(changed("provenance", {"deep": deep}))
    while deep:  # taken apart by hand: freeing it in one go would recurse just as deep
        deep = deep.pop()


# What it costs


def test_importing_the_design_loads_neither_cad_nor_compiler() -> None:
    """What asks for a design, asks for its limits, which are numbers of NumPy; `--help` asks for neither."""
    code = "import sys, delta_cad.design, delta_cad.drive; print(*sorted(set(m.split('.')[0] for m in sys.modules)))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"cadquery", "OCP", "trimesh", "fcl", "scipy", "matplotlib", "numba", "llvmlite"} & set(loaded)
