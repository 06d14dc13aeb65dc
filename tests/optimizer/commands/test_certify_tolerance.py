"""`certify --tolerance` and `verify --tolerance`: what is proved of all machines within it, told and refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from delta_cad.design import load_design
from optimizer.certify.certificate import CertificateError, verify
from optimizer.certify.file import read_certificate
from tests.committed import BEST
from tests.optimizer.certify.designs import call, changed, masses, redigested

ROOMY = {"kappa_max": 2.35, "lean_max_deg": 29.0, "shoulder_min_deg": -45.0, "shoulder_max_deg": 70.0}


def test_all_machines_within_a_tolerance_are_proved_replayed_and_the_largest_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = changed(tmp_path, **ROOMY), tmp_path / "c.json"
    file = masses(tmp_path, load_design(path))
    weighed = ("--mass-properties", file)
    assert call("certify", "--design", path, "--out", out, "--tolerance", "0.05", *weighed, "--json") == 0
    wording = json.loads(capsys.readouterr().out)["tolerance"]
    assert (wording["certified_mm"], wording["proved"], wording["needs"]) == (0.05, True, [])
    assert 0.05 < wording["largest_mm"] < 0.5
    assert wording["first_to_break"] == ["kappa"]
    assert json.loads(out.read_text())["tolerance_m"] == 0.05 / 1e3
    for least in ("0.05", "0.01"):
        assert call("verify", out, "--design", path, *weighed, "--tolerance", least) == 0
        assert "for every machine within 0.05 mm of the drawn lengths and offsets" in capsys.readouterr().out
    assert call("verify", out, "--design", path, *weighed, "--tolerance", "0.051") == 1
    assert "it is about machines within 0.05 mm of the drawn one, not 0.051 mm" in capsys.readouterr().err
    certificate = read_certificate(out)
    with pytest.raises(CertificateError, match="kappa: it could not be proved again"):
        verify(replace(certificate, tolerance=6.0 * wording["largest_mm"] / 1e3))
    drawn = verify(replace(certificate, tolerance=0.0))
    assert drawn.proved == verify(certificate).proved

    assert call("certify", "--design", path, "--out", out, "--tolerance", "max", *weighed, "--json") == 0
    largest = json.loads(capsys.readouterr().out)["tolerance"]
    assert largest["certified_mm"] == largest["largest_mm"] == pytest.approx(wording["largest_mm"], rel=0.011)
    assert call("verify", out, "--design", path, *weighed, "--json") == 0
    assert json.loads(capsys.readouterr().out)["tolerance_mm"] == pytest.approx(largest["largest_mm"], rel=1e-12)


@pytest.mark.slow
def test_the_committed_design_is_at_its_limits_and_is_reported_what_gives_room(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its lean is 4 deg and its torque a tenth off their limits; the three others decide the size of its cube."""
    out = tmp_path / "c.json"
    assert call("certify", "--design", BEST, "--out", out, "--tolerance", "0.05", "--json") == 1
    wording, err = capsys.readouterr()
    wording = json.loads(wording)["tolerance"]
    assert not wording["proved"]
    assert 1e-5 < wording["largest_mm"] < 1e-3
    assert wording["needs_for_mm"] == 0.05
    needs = {need["figure"]: need["limit"] for need in wording["needs"]}
    assert needs.keys() == {"kappa", "shoulder, smallest", "couple index"}
    assert "0.05 mm would need kappa <= 2." in err
    assert err.count("\n") == 1
    assert call("verify", out, "--design", BEST, "--without-gravity") == 1
    assert "kappa is undecided; shoulder is undecided; couple_index is undecided" in capsys.readouterr().err
    data = json.loads(BEST.read_text())
    data["requirements"] |= {
        "kappa_max": needs["kappa"] + 1e-9,
        "shoulder_min_deg": needs["shoulder, smallest"] - 1e-9,
        "couple_index_min": needs["couple index"] - 1e-9,
    }
    (tmp_path / "roomy.json").write_text(json.dumps(data))
    assert call("certify", "--design", tmp_path / "roomy.json", "--out", out, "--tolerance", "0.05") == 0
    assert "within 0.05 mm of every length and offset the limits are all proved" in capsys.readouterr().out


@pytest.mark.slow
def test_a_search_that_the_time_ends_says_what_it_reached_and_no_more(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, out = changed(tmp_path, **ROOMY), tmp_path / "c.json"

    def wording(requested: str, minutes: float, code: int) -> dict[str, Any]:
        assert call(*certify, "--tolerance", requested, "--proof-minutes", str(minutes), "--json") == code
        wording, err = capsys.readouterr()
        assert ("time was over" in err) == (code != 0)
        assert "would need" not in err
        return json.loads(wording)["tolerance"]

    certify = ("certify", "--design", path, "--out", out)
    none = wording("max", 1e-9, 1)
    assert (none["largest_mm"], none["time_was_over_for"], none["certified_mm"]) == (0.0, "largest", 0.0)
    assert "tolerance_m" not in json.loads(out.read_text())  # that of the drawn machine, which is proved
    requested = wording("0.01", 1e-9, 0)
    assert (requested["proved"], requested["time_was_over_for"]) == (True, "largest")
    calls = iter(range(10**9))
    monkeypatch.setattr("optimizer.commands.certify.monotonic", lambda: float(next(calls)))  # s, a look each
    some = wording("max", 0.3, 1)
    assert 0.0 < some["largest_mm"] == some["certified_mm"]
    assert some["needs"] == []
    assert call("verify", out, "--tolerance", f"{some['largest_mm']:g}") == 0
    capsys.readouterr()
    whole = wording("max", 1e6, 0)
    assert (whole["time_was_over_for"], whole["largest_mm"] >= some["largest_mm"]) == (None, True)


@pytest.mark.parametrize("value", ["-0.1", "0", "nan", "inf", "small", "50"])
def test_a_tolerance_that_is_none_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str], value: str) -> None:
    try:
        code = call("certify", "--design", changed(tmp_path), "--out", tmp_path / "c.json", f"--tolerance={value}")
    except SystemExit as error:
        code = error.code
    assert code == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "--tolerance" in err
    assert not (tmp_path / "c.json").exists()


@pytest.mark.slow
def test_a_certificate_that_is_changed_in_its_tolerance_does_not_hold(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = changed(tmp_path, **ROOMY), tmp_path / "c.json"
    assert call("certify", "--design", path, "--out", out, "--tolerance", "0.01") == 0
    good = json.loads(out.read_text())
    without = {key: value for key, value in good.items() if key != "tolerance_m"}
    cases: list[tuple[Any, int, str]] = [
        (good | {"tolerance_m": "1e-5"}, 2, "tolerance_m"),
        (good | {"tolerance_m": True}, 2, "tolerance_m"),
        (good | {"tolerance_m": 0.0}, 2, "tolerance_m"),
        (good | {"tolerance_m": -1e-5}, 2, "tolerance_m"),
        (good | {"tolerance_m": 0.02}, 2, "tolerance is 0.02 m"),
        (good | {"tolerance_m": 1e-3}, 1, "it could not be proved again"),
        (without, 1, "statement is not what its numbers prove"),
    ]
    for data, code, words in cases:
        out.write_text(json.dumps(redigested(data)))
        capsys.readouterr()
        assert call("verify", out) == code
        assert words in capsys.readouterr().err


def test_the_tolerance_of_the_parts_is_that_of_their_chains(tmp_path: Path) -> None:
    """0.302 mm, most of it the turn of a cheek on its dowels, is more than a design at its limits has room for."""
    out = tmp_path / "certificate.json"
    assert call("certify", "--design", BEST, "--out", out, "--tolerance", "parts") == 1
    assert json.loads(out.read_text(encoding="utf-8"))["tolerance_m"] == pytest.approx(0.302e-3)
