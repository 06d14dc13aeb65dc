"""`best.json` is what `optimizer design joystick.toml` writes, and does what is asked of the joystick."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from delta_cad.design import load_design
from optimizer.problem.brief import brief_hash, load_brief
from tests.committed import COMMITTED, ROOT, Built

TASK = ROOT / "joystick.toml"


def test_it_comes_from_the_committed_requirements() -> None:
    provenance = json.loads(COMMITTED.read_text())["provenance"]
    assert provenance["command"] == f"python -m optimizer design {TASK.name} --seed 0"
    assert provenance["requirements_sha256"] == brief_hash(load_brief(TASK))


def test_it_states_all_that_the_requirements_ask() -> None:
    asked, stated = load_brief(TASK), load_design(COMMITTED).requirements
    for part in (asked.requirements, asked.feel):
        for name, value in part.model_dump(exclude_none=True).items():
            assert getattr(stated, name) == pytest.approx(value), name


def test_its_build_passes_and_keeps_what_is_asked_of_the_hand(committed: Built) -> None:
    record = committed.record
    assert (committed.code, record["failed"]) == (0, [])
    found = {check["name"]: check["value"] for check in record["checks"]}
    assert found["effective mass"] <= 0.40
    assert found["friction"] <= 0.80
    assert found["structure stiffness at the knob"] >= 15.0
    assert found["structure first mode"] >= 40.0
    assert record["moving_mass_kg"] <= 0.400


def test_no_number_of_a_machine_stands_in_the_requirements() -> None:
    """A bound, a ratio or a size in them would be one that somebody had copied."""
    text = Path(TASK).read_text()
    assert "[bounds_mm]" not in text
    assert "capstan_ratio" not in text
    assert "_radius_mm" not in text
