"""`python -m optimizer certify` and `verify`: what they write, tell and refuse."""

from __future__ import annotations

import hashlib
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from delta_cad.common import console
from delta_cad.design import design_hash, load_design
from delta_cad.mechanism import conditioning, reach_excess, rod_lean, worst_joint_torque
from delta_cad.mechanism.proof import prove as proving
from tests.committed import BEST
from tests.optimizer.certify.designs import call, changed, masses, redigested
from tests.optimizer.messages import holds
from tests.terminal import shown_on_a_terminal


def test_a_certificate_is_written_where_it_is_wanted_and_verify_says_what_it_is_about(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "new" / "certificate.json"
    assert call("certify", "--design", BEST, "--out", out) == 0
    assert [f.name for f in out.parent.iterdir()] == ["certificate.json"]
    assert capsys.readouterr().err == ""
    assert call("verify", out, "--design", BEST, "--json") == 1
    reported = json.loads(capsys.readouterr().out)
    assert (reported["holds"], reported["gravity_counted_in"]) == (False, False)


def test_proved_bounds_hold_and_are_a_hundred_thousandth_from_what_is_attained(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Adversarial: 200,000 points inside, on faces, on edges; and the attained value is attained at its point."""
    path = changed(tmp_path)
    assert call("certify", "--design", path, "--out", tmp_path / "c.json", "--json") == 0
    reported = json.loads(capsys.readouterr().out)
    design = load_design(path)
    g, rng = design.geometry, np.random.default_rng(0)
    p = rng.uniform(-1.0, 1.0, (200_000, 3))
    k = np.arange(len(p))
    for _ in range(2):
        p[k[: len(p) // 2], rng.integers(0, 3, len(p) // 2)] = rng.choice([-1.0, 1.0], len(p) // 2)
    p = np.array([0.0, 0.0, 0.094612]) + 0.0375 * p
    rows = {row["figure"]: row for row in reported["conditions"]}
    figures = {
        "kappa": (conditioning(g, p), lambda q: conditioning(g, q)),
        "torque, no gravity": (worst_joint_torque(g, p, 3.0).max(-1), lambda q: worst_joint_torque(g, q, 3.0).max(-1)),
        "lean": (np.degrees(np.abs(rod_lean(g, p)).max(-1)), lambda q: np.degrees(np.abs(rod_lean(g, q)).max(-1))),
    }
    for name, (values, figure) in figures.items():
        row = rows[name]
        # a thousandth of a degree beside a few digits of rounding; else the bound's own distance of 1e-5
        assert values.max() <= row["proved"]
        assert row["attained"] <= row["proved"] <= row["attained"] * (1.0 + 1.0001e-5) + 1e-3 * (name == "lean")
        assert float(figure(np.array(row["at_mm"]) / 1e3)) == pytest.approx(row["attained"], rel=1e-9)
    assert rows["kappa"]["verdict"] == "not asked"
    assert rows["kappa"]["limit"] is None
    assert rows["torque, no gravity"]["room"] == pytest.approx(0.8 - rows["torque, no gravity"]["attained"], rel=1e-12)


def test_weight_of_a_build_is_taken_off_and_checked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = changed(tmp_path, kappa_max=2.3)
    file, out = masses(tmp_path, load_design(path)), tmp_path / "c.json"
    assert call("certify", "--design", path, "--out", out, "--mass-properties", file, "--json") == 0
    reported = json.loads(capsys.readouterr().out)
    gravity = reported["gravity"]
    assert gravity["source"] == "mass properties"
    assert gravity["mass_properties_sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    carried = 0.01 + 6 * 0.01 * 0.02 / 0.112079
    assert gravity["carried_mass_kg"] == pytest.approx(carried, rel=1e-11)
    rows = {row["condition"]: row for row in reported["conditions"]}
    row, alone = rows["holding_torque"], rows["torque"]
    assert row["verdict"] == "proved"
    assert row["limit"] == 0.8
    assert alone["attained"] < row["attained"] <= row["proved"] <= row["attained"] * (1.0 + 1.0001e-5)
    assert call("verify", out, "--json") == 0
    reported = json.loads(capsys.readouterr().out)
    assert reported["mass_properties_sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    lighter = json.loads(out.read_text())
    lighter["gravity"] |= {"mass_file_sha256": None, "reserve_N_m": 1e-3}
    lighter["limits"]["torque_max_N_m"] = 0.7989
    for finding in lighter["findings"]:
        if finding["condition"] == "torque":
            finding["limit"] = 0.7989
    (tmp_path / "by_hand.json").write_text(json.dumps(redigested(lighter)))
    assert call("verify", tmp_path / "by_hand.json", "--design", path, "--as-recorded") == 0
    capsys.readouterr()
    assert call("verify", tmp_path / "by_hand.json", "--design", path, "--mass-properties", file) == 1
    assert "gravity's share does not come from" in capsys.readouterr().err
    file.write_text(file.read_text() + "\n")
    assert call("verify", out, "--design", path, "--mass-properties", file) == 1
    assert "torque: gravity's share does not come from mass_properties.json" in capsys.readouterr().err


def test_a_share_of_gravity_that_was_made_less_is_noticed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = changed(tmp_path), tmp_path / "c.json"
    assert call("certify", "--design", path, "--out", out, "--gravity-torque", "0.48") == 0
    capsys.readouterr()
    assert call("verify", out, "--design", path, "--gravity-torque", "0.48", "--json") == 0
    assert json.loads(capsys.readouterr().out)["gravity_torque_checked"] is True
    none = json.loads(out.read_text())
    for forged in (none | {"gravity": none["gravity"] | {"reserve_N_m": 0.0}}, none | {"gravity": None}):
        (tmp_path / "less.json").write_text(json.dumps(redigested(forged)))
        assert call("verify", tmp_path / "less.json", "--design", path, "--gravity-torque", "0.48") == 1
        capsys.readouterr()


def test_no_bound_is_reported_looser_than_the_limit_that_is_proved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The bounds beside a proof keep some distance from the extreme: 1e-5, or a thousandth of a degree."""
    loose, out = changed(tmp_path), tmp_path / "c.json"
    assert call("certify", "--design", loose, "--out", out, "--json") == 0
    free = {row["figure"]: row["attained"] for row in json.loads(capsys.readouterr().out)["conditions"]}
    near = {
        "kappa_max": free["kappa"] * (1.0 + 3e-6),
        "lean_max_deg": free["lean"] + 3e-4,
        "shoulder_min_deg": free["shoulder, smallest"] - 3e-4,
        "shoulder_max_deg": free["shoulder, largest"] + 3e-4,
    }
    path = changed(tmp_path, **near)
    assert call("certify", "--design", path, "--out", out, "--json") == 0
    rows = {row["figure"]: row for row in json.loads(capsys.readouterr().out)["conditions"]}
    for figure in ("kappa", "lean", "shoulder, smallest", "shoulder, largest"):
        assert rows[figure]["verdict"] == "proved"
        assert rows[figure]["proved"] == rows[figure]["limit"], figure
    assert call("verify", out, "--design", path, "--without-gravity") == 0


@pytest.mark.slow
def test_tight_certificates_prove_what_was_not_required(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = changed(tmp_path), tmp_path / "c.json"
    assert call("certify", "--design", path, "--out", out, "--tight", "--json") == 0
    reported = json.loads(capsys.readouterr().out)
    assert reported["tight"]
    assert call("verify", out, "--design", path, "--json", "--without-gravity") == 0
    assert json.loads(capsys.readouterr().out)["proved"] == [
        "reach", "assembly_mode", "torque", "kappa", "lean", "shoulder", "elbow_angle", "friction", "position_step",
        "couple_index",
    ]  # fmt: skip
    limits = json.loads(out.read_text())["limits"]
    assert call("verify", out, "--json") == 0
    again = json.loads(capsys.readouterr().out)
    assert again["limits"] == limits
    assert again["cube"]["half_side_m"] == 0.0375
    rows = {row["figure"]: row for row in reported["conditions"]}
    assert limits["kappa_max"] == rows["kappa"]["proved"]
    assert limits["elbow_arm_min_m"] == pytest.approx(rows["elbow arm"]["proved"] / 1e3, rel=1e-14)


def test_refuted_design_exits_1_with_each_condition_its_excess_and_its_point(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = changed(tmp_path, kappa_max=2.2, lean_max_deg=27.0, shoulder_min_deg=-30), tmp_path / "c.json"
    assert call("certify", "--design", path, "--out", out) == 1
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert holds(err, "kappa 2.26769 -37.500 132.112 0.0677 2.2")
    assert holds(err, "shoulder -39.2403 9.24 -30")
    assert call("verify", out, "--json") == 1
    reported = json.loads(capsys.readouterr().out)
    assert reported["holds"] is False
    assert reported["refuted"] == ["kappa", "lean", "shoulder"]


@pytest.mark.slow
def test_a_cube_out_of_reach(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Chain 0 and all corners are in order; chain 1 folds on the edge of the bottom face, by 0.015 mm.

    The points that loading looks at, in the planes of the chains, are within reach from 30.941 mm on.
    """
    path, out = changed(tmp_path), tmp_path / "c.json"
    data = json.loads(path.read_text())
    data["mechanism"] |= {"base_radius_mm": 65.0, "platform_radius_mm": 40.0, "forearm_length_mm": 113.0}
    path.write_text(json.dumps(data | {"cube": {"bottom_height_mm": 30.945, "half_side_mm": 20.0}}))
    assert call("certify", "--design", path, "--out", out) == 1
    reported, err = capsys.readouterr()
    found = re.match(
        r"design\.json: reach is refuted: a chain is (\S+) mm out of reach at \((.*)\) mm; assembly_mode", err
    )
    assert found is not None
    excess, point = float(found[1]), np.array([float(x) for x in found[2].split(",")])
    assert excess == pytest.approx(float(reach_excess(load_design(path).geometry, point / 1e3).max()) * 1e3, abs=1e-6)
    assert 0.0 < excess <= 0.02
    data["mechanism"] |= {"base_radius_mm": 40.0, "platform_radius_mm": 40.0}
    path.write_text(json.dumps(data | {"cube": {"bottom_height_mm": 31.0, "half_side_mm": 20.0}}))
    # exactly on the fold: neither, however many boxes
    assert call("certify", "--design", path, "--out", out, "--json", "--max-boxes", "20000") == 1
    reported, err = capsys.readouterr()
    assert "reach is undecided in the box (" in err
    assert json.loads(reported)["verdict"] == "undecided"


def refused(tmp_path: Path, *arguments: str | Path) -> tuple[int, set[str]]:
    before = {f.name for f in tmp_path.iterdir()}
    try:
        code = call(*arguments)
    except SystemExit as error:
        code = int(error.code or 0)
    return code, {f.name for f in tmp_path.iterdir()} - before


def test_bad_input_exits_2_in_one_line_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = changed(tmp_path)
    (tmp_path / "dir").mkdir()
    (tmp_path / "text.json").write_text("{")
    (tmp_path / "list.json").write_text("[1]")
    assert call("certify", "--design", path, "--out", "right.json") == 0
    capsys.readouterr()
    weak = changed(tmp_path, force_N=1e-9).rename(tmp_path / "weak.json")
    faint = changed(tmp_path, joint_torque_N_m=1e-9).rename(tmp_path / "faint.json")
    changed(tmp_path)
    cases = (
        (("certify",), "--design"),
        (("certify", "--design", "none.json"), "none.json: "),
        (("certify", "--design", "text.json"), "text.json: "),
        (("certify", "--design", weak), "weak.json: requirements.force_N 1e-09 1e-06 1000"),
        (("certify", "--design", faint), "faint.json: requirements.joint_torque_N_m 1e-09 1e-06 100"),
        (("certify", "--design", path, "--gravity-torque", "0.8"), "gravity torque = 0.8: 0"),
        (("certify", "--design", path, "--gravity-torque", "x"), "--gravity-torque"),
        (("certify", "--design", path, "--mass-properties", "none.json"), "none.json: "),
        (("certify", "--design", path, "--mass-properties", "list.json"), "list.json: "),
        (
            ("certify", "--design", path, "--mass-properties", "a", "--gravity-torque", "0.1"),
            "--mass-properties --gravity-torque",
        ),
        (("certify", "--design", path, "--out", "dir"), "dir: "),
        (("certify", "--design", path, "--out", "text.json/c.json"), "text.json/c.json: "),
        (("verify",), "required: CERT"),
        (("verify", "none.json"), "none.json: "),
        (("verify", "text.json"), "text.json: "),
        (("verify", "list.json"), "list.json: "),
        (("verify", path), "design.json: schema: "),
        (("verify", path, "--mass-properties", "none.json"), "--mass-properties --design"),
        (("verify", path, "--gravity-torque", "0.1"), "--gravity-torque --design"),
        (("verify", path, "--gravity-torque", "0.1", "--mass-properties", "a"), "--mass-properties --gravity-torque"),
        (("verify", "right.json", "--design", path, "--gravity-torque", "nan"), "gravity torque = nan: 0"),
        (("verify", path, "--design", "none.json"), "none.json: "),
    )
    for arguments, words in cases:
        assert refused(tmp_path, *arguments) == (2, set()), arguments
        reported, err = capsys.readouterr()
        assert reported == ""
        assert holds(err, words)
        assert err.count("\n") == 1


def test_a_proof_ends_with_its_time_and_says_what_it_reached(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = changed(tmp_path)
    monkeypatch.setattr(proving, "CHUNK", 5)
    assert call("certify", "--design", path, "--out", tmp_path / "c.json", "--proof-minutes", "1e-9", "--json") == 1
    reported, err = capsys.readouterr()
    assert "undecided" in {row["verdict"] for row in json.loads(reported)["conditions"]}
    assert "the time was over after 5 boxes: raise --proof-minutes" in err


def test_an_interrupted_proof_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = changed(tmp_path)
    monkeypatch.setattr(console.ProgressLine, "show", lambda *_: os.kill(os.getpid(), signal.SIGINT))
    assert call("certify", "--design", path, "--out", tmp_path / "c.json") == console.INTERRUPTED
    assert capsys.readouterr().err == "interrupted; nothing was written\n"
    assert [f.name for f in tmp_path.iterdir()] == ["design.json"]


def test_a_certificate_that_cannot_be_finished_leaves_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "c.json"
    out.write_text("old")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    assert call("certify", "--design", changed(tmp_path), "--out", out) == 2
    assert out.read_text() == "old"
    assert sorted(f.name for f in tmp_path.iterdir()) == ["c.json", "design.json"]


def test_the_same_design_gives_the_same_bytes(tmp_path: Path) -> None:
    path = changed(tmp_path)
    for name in ("a.json", "b.json"):
        assert call("certify", "--design", path, "--out", tmp_path / name) == 0
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    assert json.loads((tmp_path / "a.json").read_text())["design_hash"] == design_hash(load_design(path))


@pytest.mark.slow
def test_progress_appears_on_a_terminal_only(tmp_path: Path) -> None:
    path = changed(tmp_path)
    command = [sys.executable, "-m", "optimizer", "certify", "--design", str(path), "--out", str(tmp_path / "c.json")]
    code, shown = shown_on_a_terminal(command)
    assert code == 0
    assert b"loading the prover; it is compiled once on a machine" in shown
    assert b"100.0% of the cube" in shown
    assert shown.endswith(b"\r\x1b[K")


def test_verify_loads_no_compiler(tmp_path: Path) -> None:
    assert call("certify", "--design", changed(tmp_path), "--out", tmp_path / "c.json") == 0
    code = (
        "import sys\nfrom optimizer.commands.cli import main\n"
        f"assert main(['verify', {str(tmp_path / 'c.json')!r}]) == 0\nassert 'numba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
