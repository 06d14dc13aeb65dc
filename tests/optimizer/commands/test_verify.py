"""`python -m optimizer verify`: what it refuses, and what it says of it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from delta_cad.design import load_design
from optimizer.certify.file import MOST_LEAVES
from tests.committed import ROOT
from tests.designs import named
from tests.optimizer.certify.designs import call, changed, masses, redigested


class Whole(NamedTuple):
    """A certificate about every limit, its design and the masses behind it."""

    data: dict[str, Any]
    design: Path
    masses: Path


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Whole:
    folder = tmp_path_factory.mktemp("whole")
    required = {"kappa_max": 2.5, "lean_max_deg": 28.0, "shoulder_min_deg": -45.0, "effective_mass_max_kg": 50.0}
    required |= {
        "couple_index_min": 0.1,
        "elbow_angle_min_deg": 10.0,
        "friction_max_N": 2.0,
        "position_step_max_mm": 0.2,
    }
    path = changed(folder, **required)
    file = masses(folder, load_design(path), turning=2e-6)
    assert call("certify", "--design", path, "--out", folder / "c.json", "--mass-properties", file) == 0
    data = json.loads((folder / "c.json").read_text())
    assert None not in data["limits"].values()
    return Whole(data, path, file)


def put(data: Any, path: str, value: Any) -> None:
    """Sets what a dotted path leads to; a finding is named by its condition."""
    *tables, last = path.split(".")
    for part in (*tables, None):
        name: Any = last if part is None else part
        if isinstance(data, list):
            names = [one.get("condition") if isinstance(one, dict) else None for one in data]
            name = int(name) if name.isdigit() else names.index(name)
        if part is None:
            data[name] = value
        else:
            data = data[name]


CASES = [json.loads(line) for line in (ROOT / "tests/optimizer/certify/refused.jsonl").read_text().splitlines()]


@pytest.mark.parametrize("case", CASES, ids=named)
def test_a_certificate_that_is_changed_is_refused_in_one_line(
    case: dict[str, Any], whole: Whole, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = json.loads(json.dumps(whole.data))
    for path, value in case["set"].items():
        put(data, path, value)
    out = tmp_path / "c.json"
    out.write_text(json.dumps(redigested(data) if case.get("fits", True) else data))
    more = ("--design", whole.design, "--mass-properties", whole.masses) if case.get("design") else ()
    assert call("verify", out, *more, "--json") == case["code"]
    reported, err = capsys.readouterr()
    assert (err.count("\n"), err.count("c.json"), "\x1b" in err) == (1, 1, False)
    if case["code"] == 2:
        assert (reported, err.startswith(f"c.json: {case['says']}")) == ("", True), err
        assert case.get("names", "") in err or err.startswith("c.json: limits: inertia must have carried_mass_kg, ")
    else:
        assert case["says"] in err
        assert err.endswith("the certificate does not hold\n")
        assert json.loads(reported)["holds"] is False
        assert case["says"] in json.loads(reported)["reason"]


Forged = Callable[[dict[str, Any]], dict[str, Any]]
FORGED: list[tuple[Forged, str]] = [
    *((lambda c, add=add: {"boxes": c["boxes"] + add}, "; its ") for add in (-1, 1)),
    (lambda c: {"boxes": len(c["leaves"])}, "; its "),
    (lambda c: {"leaves": c["leaves"][1:], "boxes": c["boxes"] - 2}, "boxes are missing"),
    (lambda c: {"leaves": [*c["leaves"], c["leaves"][0]], "boxes": c["boxes"] + 2}, "overlap"),
    (
        lambda c: {
            "limits": c["limits"] | {"effective_mass_max_kg": None, "inertia": None},
            "findings": [f for f in c["findings"] if f["condition"] != "effective_mass"],
        },
        "effective_mass: design",
    ),
    (
        lambda c: {
            "gravity": c["gravity"] | {"mass_file_sha256": None, "reserve_N_m": 0.2},
            "limits": {key: value for key, value in c["limits"].items() if "held" not in key and "holding" not in key},
            "findings": [f for f in c["findings"] if f["condition"] != "holding_torque"],
        },
        "torque: the torque of 0.8 N m is more",
    ),
]


@pytest.mark.parametrize(("forged", "words"), FORGED, ids=[words for _, words in FORGED])
def test_a_certificate_that_is_forged_does_not_hold(
    forged: Forged, words: str, whole: Whole, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "c.json").write_text(json.dumps(redigested(whole.data | forged(whole.data))))
    more = () if "torque" in words else ("--mass-properties", whole.masses)
    assert call("verify", tmp_path / "c.json", "--design", whole.design, *more) == 1
    err = capsys.readouterr().err
    assert words in err
    assert err.endswith("the certificate does not hold\n")


def test_another_design_exits_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("certify", "--design", changed(tmp_path), "--out", tmp_path / "c.json") == 0
    assert call("verify", tmp_path / "c.json", "--design", changed(tmp_path, force_N=3.1)) == 1
    assert "it is about the design of hash" in capsys.readouterr().err


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
        reported, err = capsys.readouterr()
        assert "design.json states requirements.gravity_m_s2 = [0, 0, -9.81], and" in err
        assert json.loads(reported)["holds"] is False
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
        reported, err = capsys.readouterr()
        assert reported == ""
        assert err.startswith("mass_properties.json: input_sha256 = ")
    assert not (tmp_path / "d.json").exists()


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


def test_a_file_that_two_readers_could_read_differently_or_not_at_all_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], whole: Whole
) -> None:
    """The digest is over what was read: of a key that stands twice it covers the last one only."""
    text = json.dumps(whole.data)
    for content, words in (
        (text[:-1] + ', "boxes": 1}', "boxes = 1: is given more than once"),
        (text.replace('"kappa_max": ', '"kappa_max": 1.5, "kappa_max": ', 1), "kappa_max = "),
        (text.replace('"half_side_m": ', '"half_side_m": NaN, "_": ', 1), "NaN is no number"),
        (text[:-1] + ', "x": ' + "[" * 100 + "]" * 100 + "}", "is nested deeper than"),
        (text[:-1] + " " * 64_000_000 + "}", "is larger than 64 MB"),
    ):
        (tmp_path / "c.json").write_text(content)
        assert call("verify", tmp_path / "c.json") == 2
        reported, err = capsys.readouterr()
        assert (reported, err.count("\n")) == ("", 1)
        assert words in err
    leaves = [whole.data["leaves"][0]] * (MOST_LEAVES + 1)
    (tmp_path / "c.json").write_text(json.dumps(redigested(whole.data | {"leaves": leaves})))
    assert call("verify", tmp_path / "c.json") == 2
    assert capsys.readouterr().err.startswith("c.json: leaves: ")
    # a fault of each is gathered before one is told: six megabytes of ones took a minute and four gigabytes
    (tmp_path / "c.json").write_text(json.dumps(whole.data | {"findings": [1] * 1000}))
    assert call("verify", tmp_path / "c.json") == 2
    assert capsys.readouterr().err.startswith("c.json: findings: List should have at most ")


def test_more_leaves_than_anybody_would_replay_are_not_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("optimizer.certify.file.MOST_LEAVES", 10)
    assert call("certify", "--design", changed(tmp_path), "--out", tmp_path / "c.json") == 1
    assert "a certificate holds at most 10" in capsys.readouterr().err
    assert not (tmp_path / "c.json").exists()
