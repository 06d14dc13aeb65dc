"""`python -m optimizer verify`: what it refuses, and what it says of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from delta_cad.design import load_design
from tests.optimizer.designs_to_certify import call, changed, masses, redigested


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
    refused("boxes are missing", leaves=good["leaves"][1:])
    refused("overlap", leaves=[*good["leaves"], good["leaves"][0]])
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
    weighed = good["gravity"]["masses"]
    for change, where in (
        ({"boxes": -5}, "boxes"),
        ({"design": evil}, "design"),
        ({"design": "fine\n"}, "design"),
        ({"design_hash": evil}, "design_hash"),
        ({"gravity": good["gravity"] | {"masses": weighed | {"file_sha256": evil}}}, "gravity.masses.file_sha256"),
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
