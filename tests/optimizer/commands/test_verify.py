"""`python -m optimizer verify`: what it refuses, and what it says of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from delta_cad.design import load_design
from optimizer.certify.file import MOST_LEAVES
from tests.optimizer.certify.designs import call, changed, masses, redigested


def test_tampered_certificates_exit_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = changed(tmp_path, kappa_max=2.5), tmp_path / "c.json"
    assert call("certify", "--design", path, "--out", out, "--gravity-torque", "0.1") == 0
    capsys.readouterr()
    good = json.loads(out.read_text())

    def refused(words: str, fitting: bool = True, **change: Any) -> None:
        data = good | change
        if fitting:
            data = redigested(data)
        out.write_text(json.dumps(data))
        assert call("verify", out, "--design", path, "--json") == 1
        told, err = capsys.readouterr()
        assert words in err
        assert err.startswith("c.json: ")
        assert err.count("c.json") == 1
        assert err.endswith("the certificate does not hold\n")
        assert json.loads(told)["holds"] is False
        assert words in json.loads(told)["reason"]

    refused("its content was changed", fitting=False, boxes=1)
    for count in (0, len(good["leaves"]), good["boxes"] - 1, good["boxes"] + 1, 999_999_999):
        refused(f"boxes is {count}; its", boxes=count)
    refused('it is about a design called "another"', design="another")
    refused("boxes are missing", leaves=good["leaves"][1:], boxes=good["boxes"] - 2)
    refused("overlap", leaves=[*good["leaves"], good["leaves"][0]], boxes=good["boxes"] + 2)
    refused("is about the design of hash", design_hash="0" * 64)
    looser = good["limits"] | {"kappa_max": 3.0}
    findings = [f | {"limit": 3.0} if f["condition"] == "kappa" else f for f in good["findings"]]
    refused("kappa: design", limits=looser, findings=findings)
    refused("kappa: the limit of its finding", limits=good["limits"] | {"kappa_max": 2.4})
    refused("torque: the torque of 0.7 N m is more", gravity=good["gravity"] | {"reserve_N_m": 0.2})
    smaller = {"bottom_height_m": 0.057112, "half_side_m": 0.01, "top_height_m": 0.057112 + 2 * 0.01}
    refused("other dimensions", cube=smaller)
    refused("statement is not what its numbers prove", statement="All is well, everything up to 100 N.")


def test_a_certificate_with_fields_that_no_design_has_is_unreadable_and_nothing_of_it_reaches_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = changed(tmp_path), tmp_path / "c.json"
    file = masses(tmp_path, load_design(path))
    assert call("certify", "--design", path, "--out", out, "--mass-properties", file) == 0
    capsys.readouterr()
    good = json.loads(out.read_text())
    evil = "\x1b[31mred\nline"
    for change, where in (
        ({"boxes": -5}, "boxes"),
        ({"design": evil}, "design"),
        ({"design": "fine\n"}, "design"),
        ({"design_hash": evil}, "design_hash"),
        ({"gravity": good["gravity"] | {"mass_file_sha256": evil}}, "gravity.mass_file_sha256"),
        ({evil: 1}, "'\\x1b[31mred\\nline'"),
    ):
        out.write_text(json.dumps(redigested(good | change)))
        assert call("verify", out) == 2
        told, err = capsys.readouterr()
        assert told == ""
        assert err.startswith(f"c.json: {where}: ")
        assert "\x1b" not in err
        assert err.count("\n") == 1
    out.write_text(json.dumps(good | {"digest": evil}))
    assert call("verify", out) == 2
    assert capsys.readouterr().err.startswith("c.json: digest: ")


def test_another_design_exits_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("certify", "--design", changed(tmp_path), "--out", tmp_path / "c.json") == 0
    assert call("verify", tmp_path / "c.json", "--design", changed(tmp_path, force_N=3.1)) == 1
    assert "it is about the design of hash" in capsys.readouterr().err


def test_a_mass_limit_that_is_missing_laxer_or_of_other_masses_does_not_hold(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = changed(tmp_path, effective_mass_max_kg=50.0), tmp_path / "c.json"
    file = masses(tmp_path, load_design(path), turning=2e-6)
    assert call("certify", "--design", path, "--out", out, "--mass-properties", file) == 0
    good = json.loads(out.read_text())
    without = [f for f in good["findings"] if f["condition"] != "effective_mass"]
    laxer = [f | {"limit": 51.0} if f["condition"] == "effective_mass" else f for f in good["findings"]]
    light = good["limits"]["inertia"] | {"elbow_mass_kg": 0.0}
    for change, words in (
        ({"limits": good["limits"] | {"effective_mass_max_kg": None, "inertia": None}, "findings": without}, "design"),
        ({"limits": good["limits"] | {"effective_mass_max_kg": 51.0}, "findings": laxer}, "design"),
        ({"limits": good["limits"] | {"inertia": light}}, "its masses do not come from mass_properties.json"),
    ):
        out.write_text(json.dumps(redigested(good | change)))
        assert call("verify", out, "--design", path, "--mass-properties", file) == 1
        err = capsys.readouterr().err
        assert err.startswith(f"c.json: effective_mass: {words}")
        assert err.endswith("the certificate does not hold\n")
    out.write_text(json.dumps(redigested(good | {"limits": good["limits"] | {"effective_mass_max_kg": 49.0}})))
    assert call("verify", out, "--design", path, "--mass-properties", file) == 1
    assert "effective_mass: the limit of its finding is not the one proved" in capsys.readouterr().err
    heavier = good["limits"] | {"inertia": good["limits"]["inertia"] | {"elbow_mass_kg": 1000.0}}
    out.write_text(json.dumps(redigested(good | {"limits": heavier})))
    assert call("verify", out) == 1
    assert "effective_mass: it could not be proved again in the box" in capsys.readouterr().err


def test_a_share_of_gravity_that_was_compared_with_nothing_is_not_enough(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Any share can be written into a file, and the digest that fits it."""
    path, out = changed(tmp_path), tmp_path / "c.json"
    file = masses(tmp_path, load_design(path))
    lighter = {"carried_mass_kg": 1e-9, "arm_moment_kg_m": 0.0, "loose_moment_kg_m": 0.0}
    for hand, change, as_recorded in (("0", {}, 1), ("1e-12", {}, 0), (None, {}, 0), (None, lighter, 0)):
        given = ("--mass-properties", file) if hand is None else ("--gravity-torque", hand)
        assert call("certify", "--design", path, "--out", out, *given) == 0
        good = json.loads(out.read_text())
        if change:
            good["limits"]["held_masses"] |= change
        out.write_text(json.dumps(redigested(good)))
        capsys.readouterr()
        assert call("verify", out, "--design", path, "--json") == 1
        told, err = capsys.readouterr()
        assert "design.json states requirements.gravity_m_s2 = [0, 0, -9.81], and" in err
        assert json.loads(told)["holds"] is False
        assert call("verify", out, "--design", path, "--as-recorded") == as_recorded
        assert call("verify", out, "--design", path, "--without-gravity") == 0
        if hand is not None:
            assert call("verify", out, "--design", path, "--gravity-torque", hand) == 0
        assert call("verify", out, "--design", path, "--mass-properties", file) == int(hand is not None or bool(change))


def test_masses_of_another_design_are_refused_with_their_field(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = changed(tmp_path), tmp_path / "c.json"
    file = masses(tmp_path, load_design(path))
    assert call("certify", "--design", path, "--out", out, "--mass-properties", file) == 0
    capsys.readouterr()
    file.write_text(json.dumps(json.loads(file.read_text()) | {"input_sha256": "0" * 64}))
    for command in (("certify", "--out", tmp_path / "d.json"), ("verify", out)):
        assert call(*command, "--design", path, "--mass-properties", file) == 2
        told, err = capsys.readouterr()
        assert told == ""
        assert err.startswith("mass_properties.json: input_sha256 = ")
    assert not (tmp_path / "d.json").exists()


def test_what_overflows_in_a_replay_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """NumPy's warnings, errors in these tests, came before it."""
    out = tmp_path / "c.json"
    assert call("certify", "--design", changed(tmp_path), "--out", out) == 0
    good = json.loads(out.read_text())
    capsys.readouterr()
    for length in ("upper_arm_length_m", "forearm_length_m"):
        out.write_text(json.dumps(redigested(good | {"geometry": good["geometry"] | {length: 5e-324}})))
        assert call("verify", out) == 1
        told, err = capsys.readouterr()
        assert (told, err.count("\n")) == ("", 1)
        assert "it could not be proved again in the box" in err


def test_figures_of_findings_are_those_that_a_proof_gives(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = changed(tmp_path, kappa_max=2.2), tmp_path / "c.json"
    assert call("certify", "--design", path, "--out", out) == 1
    assert call("verify", out, "--design", path) == 1
    assert "kappa is refuted at (" in capsys.readouterr().err
    good = json.loads(out.read_text())
    box = [[0.0, 0.0, good["cube"]["bottom_height_m"]], [0.01, 0.01, 0.1]]

    def refused(condition: str, change: dict[str, Any], **whole: Any) -> None:
        findings = [f | change if f["condition"] == condition else f for f in good["findings"]]
        out.write_text(json.dumps(redigested(good | {"findings": findings} | whole)))
        assert call("verify", out) == 1
        err = capsys.readouterr().err
        assert err.startswith(f"c.json: {condition}: ")
        assert err.endswith("the certificate does not hold\n")

    refused("torque", {"value": 0.0001})
    refused("torque", {"point_m": [9.0, 9.0, 9.0]})
    refused("torque", {"box_m": box})
    kappa = next(f["value"] for f in good["findings"] if f["condition"] == "kappa")
    refused("kappa", {"value": kappa * (1.0 + 1e-6)})
    refused("kappa", {"value": None})
    refused("kappa", {"box_m": box})
    open_ = {"verdict": "undecided", "value": None, "point_m": None}
    for corners in (None, box, [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], box[::-1]):
        refused("kappa", open_ | {"box_m": corners}, verdict="undecided")
    refused("kappa", {"verdict": "undecided"}, verdict="undecided")
    c = good["cube"]
    side, low = c["half_side_m"], c["bottom_height_m"]
    half = [[-side, 0.0, low], [side, side, low + (c["top_height_m"] - low)]]
    findings = [f | open_ | {"box_m": half} if f["condition"] == "kappa" else f for f in good["findings"]]
    out.write_text(json.dumps(redigested(good | {"findings": findings, "verdict": "undecided"})))
    assert call("verify", out) == 1
    assert "it does not prove the design: kappa is undecided" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("kappa_max", "2.3"),
        ("kappa_max", True),
        ("kappa_max", [2.3]),
        ("kappa_max", 10**400),
        ("elbow_arm_min_m", {"m": 0.0}),
        ("force_N", False),
        ("torque_max_N_m", "0.8"),
        ("lean_max_rad", []),
        ("shoulder_rad", 1.0),
        ("shoulder_rad", [1.0]),
        ("shoulder_rad", [-1.0, 0.0, 1.0]),
        ("shoulder_rad", [-1.0, "1.0"]),
        ("shoulder_rad", [False, True]),
        ("assembly_mode", 1),
        ("assembly_mode", "true"),
        ("effective_mass_max_kg", "1.0"),
        ("couple_index_min", "0.1"),
        ("couple_index_min", 1.5),
        ("friction_max_N", "1.0"),
        ("joint_friction_N_m", True),
        ("ball_friction_level_N", [0.1]),
        ("encoder_count_rad", "0.001"),
        ("effective_mass_max_kg", None),
        ("inertia", None),
        ("inertia", 1.0),
        ("inertia", [1.0, 1.0, 1.0, 1.0]),
        ("inertia", {"carried_mass_kg": 1.0}),
        ("inertia.elbow_mass_kg", None),
        ("inertia.elbow_mass_kg", True),
        ("inertia.elbow_mass_kg", "0.1"),
        ("inertia.elbow_mass_kg", -1.0),
        ("inertia.speed_m_s", 1.0),
        ("speed_m_s", 1.0),
    ],
    ids=str,
)
def test_limits_that_are_no_numbers_are_refused_by_their_key(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], whole: dict[str, Any], key: str, value: Any
) -> None:
    data = json.loads(json.dumps(whole))
    *tables, last = key.split(".")
    table = data["limits"]
    for name in tables:
        table = table[name]
    table[last] = value
    (tmp_path / "c.json").write_text(json.dumps(data))
    assert call("verify", tmp_path / "c.json") == 2
    told, err = capsys.readouterr()
    assert told == ""
    assert err.startswith("c.json: limits")
    assert last.removesuffix("_kg") in err or err.startswith("c.json: limits: inertia must have carried_mass_kg, ")
    assert err.count("\n") == 1


def test_a_file_that_two_readers_could_read_differently_or_not_at_all_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], whole: dict[str, Any]
) -> None:
    """The digest is over what was read: of a key that stands twice it covers the last one only."""
    text = json.dumps(whole)
    for content, words in (
        (text[:-1] + ', "boxes": 1}', "boxes = 1: is given more than once"),
        (text.replace('"kappa_max": ', '"kappa_max": 1.5, "kappa_max": ', 1), "kappa_max = "),
        (text.replace('"half_side_m": ', '"half_side_m": NaN, "_": ', 1), "NaN is no number"),
        (text[:-1] + ', "x": ' + "[" * 100 + "]" * 100 + "}", "is nested deeper than"),
        (text[:-1] + " " * 64_000_000 + "}", "is larger than 64 MB"),
    ):
        (tmp_path / "c.json").write_text(content)
        assert call("verify", tmp_path / "c.json") == 2
        told, err = capsys.readouterr()
        assert (told, err.count("\n")) == ("", 1)
        assert words in err
    leaves = [whole["leaves"][0]] * (MOST_LEAVES + 1)
    (tmp_path / "c.json").write_text(json.dumps(redigested(whole | {"leaves": leaves})))
    assert call("verify", tmp_path / "c.json") == 2
    assert capsys.readouterr().err.startswith("c.json: leaves: ")
    # a fault of each is gathered before one is told: six megabytes of ones took a minute and four gigabytes
    (tmp_path / "c.json").write_text(json.dumps(whole | {"findings": [1] * 1000}))
    assert call("verify", tmp_path / "c.json") == 2
    assert capsys.readouterr().err.startswith("c.json: findings: List should have at most ")
    (tmp_path / "c.json").write_text(json.dumps(redigested(whole | {"boxes": 10**1000})))
    assert call("verify", tmp_path / "c.json") == 2
    assert capsys.readouterr().err.startswith("c.json: boxes = 1000")


def test_more_leaves_than_anybody_would_replay_are_not_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("optimizer.certify.file.MOST_LEAVES", 10)
    assert call("certify", "--design", changed(tmp_path), "--out", tmp_path / "c.json") == 1
    assert "a certificate holds at most 10" in capsys.readouterr().err
    assert not (tmp_path / "c.json").exists()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """A certificate about every limit."""
    folder = tmp_path_factory.mktemp("whole")
    asked = {"kappa_max": 2.5, "lean_max_deg": 28.0, "shoulder_min_deg": -45.0, "effective_mass_max_kg": 50.0}
    asked |= {"couple_index_min": 0.1, "elbow_angle_min_deg": 10.0, "friction_max_N": 2.0, "position_step_max_mm": 0.2}
    path = changed(folder, **asked)
    file = masses(folder, load_design(path), turning=2e-6)
    assert call("certify", "--design", path, "--out", folder / "c.json", "--mass-properties", file) == 0
    data = json.loads((folder / "c.json").read_text())
    assert None not in data["limits"].values()
    return data


@pytest.mark.parametrize("value", ["0.04", True, None])
@pytest.mark.parametrize(
    "where", ["geometry.base_radius_m", "cube.half_side_m", "boxes", "leaves.0", "leaves.0.1", "findings.0.limit"]
)
def test_text_and_truth_are_no_numbers_anywhere(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], whole: dict[str, Any], where: str, value: Any
) -> None:
    data = json.loads(json.dumps(whole))
    *path, last = (int(part) if part.isdigit() else part for part in where.split("."))
    table: Any = data
    for part in path:
        table = table[part]
    table[last] = value
    (tmp_path / "c.json").write_text(json.dumps(redigested(data)))
    assert call("verify", tmp_path / "c.json") == 2
    assert capsys.readouterr().err.startswith(f"c.json: {where}")


@pytest.mark.parametrize(("where", "value"), [("boxes", 5.0), ("leaves.0.1", 0.0), ("design", 1), ("verdict", True)])
def test_whole_numbers_and_text_are_not_taken_for_another_kind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], whole: dict[str, Any], where: str, value: Any
) -> None:
    test_text_and_truth_are_no_numbers_anywhere(tmp_path, capsys, whole, where, value)
