"""What stands in sentences: what a certificate proves, of which design, and what cannot be read."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from delta_cad.design import design_hash
from delta_cad.mechanism.limits import Kappa, Lean, Limits
from delta_cad.report.statements import assumptions, certificate, provenance
from delta_cad.report.statements import proof as proved
from delta_cad.report.subject import Subject


@pytest.fixture
def proof(subject: Subject) -> dict[str, Any]:
    """A certificate's data, all but its leaves."""
    required = subject.design.requirements.model_dump()
    limits = Limits.stated(required)
    findings = [{"condition": limit.name, "verdict": "proved", "limit": limit.thresholds()} for limit in limits]
    return {
        "schema": "delta-certificate/1",
        "verdict": "proved",
        "design_hash": design_hash(subject.design),
        "limits": limits.record(),
        "findings": findings,
        "boxes": 1067,
    }


def written(folder: Path, data: object) -> Path:
    path = folder / "certificate.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def test_it_tells_each_limit_in_the_units_of_people(subject: Subject, proof: dict[str, Any], tmp_path: Path) -> None:
    proof["findings"][-1]["verdict"] = "undecided"
    found = certificate(subject.design, written(tmp_path, proof))
    assert found["found"] is True
    assert "86.33 mm" in found["words"]
    assert "1067 boxes" in found["words"]
    wording = ", ".join(found["proved"])
    assert "kappa <= 2.27" in wording
    assert "0.39 N m" in wording
    assert "28 deg" in wording
    assert "rad" not in wording.replace("radius", "")
    assert len(found["open"]) == 1
    assert found["open"][0].endswith(": undecided")


def test_a_tolerance_is_reported_in_mm(subject: Subject, proof: dict[str, Any], tmp_path: Path) -> None:
    found = certificate(subject.design, written(tmp_path, proof | {"tolerance_m": 4e-5}))
    assert "within 0.04 mm of the drawn one" in found["words"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"design_hash": "ab" * 32}, "another design"),
        ({"schema": "delta-certificate/9"}, "another design"),
        ({"boxes": None}, "cannot be read"),
        ({"findings": [3]}, "cannot be read"),
        ({"limits": {"kappa_max": "much"}}, "cannot be read"),
        ({"limits": []}, "cannot be read"),
        ({"tolerance_m": "small"}, "cannot be read"),
    ],
)
def test_what_is_not_about_this_machine_proves_nothing(
    change: dict[str, Any], said: str, subject: Subject, proof: dict[str, Any], tmp_path: Path
) -> None:
    found = certificate(subject.design, written(tmp_path, proof | change))
    assert found["found"] is False
    assert said in found["words"]
    assert found["proved"] == []


def test_without_a_certificate_the_build_proves_its_own_limits(subject: Subject) -> None:
    kept = Limits.of(Kappa(2.5), Lean(math.radians(31.0)))
    found = proved(replace(subject, limits=replace(subject.limits, pose=kept)))
    assert "86.33 mm" in found["words"]
    assert "conditioning: kappa <= 2.5" in found["proved"]
    assert any(text.startswith("within reach: ") for text in found["proved"])
    assert found["open"] == []
    broken = Limits.of(Kappa(1.5))
    found = proved(replace(subject, limits=replace(subject.limits, pose=broken)))
    assert found["open"] == ["conditioning: kappa <= 1.5: refuted"]
    assert not any("kappa" in text for text in found["proved"])


def test_what_is_no_certificate_proves_nothing(subject: Subject, tmp_path: Path) -> None:
    path = tmp_path / "certificate.json"
    assert certificate(subject.design, path) == {"found": False, "words": "", "proved": [], "open": []}
    assert certificate(subject.design, written(tmp_path, ["no", "certificate"]))["found"] is False
    path.write_text("{")
    assert "cannot be read" in certificate(subject.design, path)["words"]


def test_assumptions_name_what_was_taken(subject: Subject) -> None:
    wording = " ".join(assumptions(subject))
    for word in ("40 mm over the wrists", "(0, 0, -9.81) m/s²", "0.08 (0.05 to 0.15)", "96 %", "nothing was measured"):
        assert word in wording


def test_the_command_names_a_file_that_a_person_can_save(subject: Subject) -> None:
    found = provenance(subject, {"python": "3.11"})
    assert found["command"] == "python -m delta_cad build --design synthesized.json"
    assert found["input_sha256"] == design_hash(subject.design)
    assert "steps" not in found["lengths"]
    assert found["lengths"]["seed"] == 1
