"""`design` with the search and the build put in place: a machine of paper, its folder and its files."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from types import MappingProxyType, SimpleNamespace
from typing import Any

import pytest

from delta_cad.checks.report import CheckResult
from delta_cad.commands import pipeline
from delta_cad.commands.pipeline import Outcome
from delta_cad.common.files import write_record
from delta_cad.design import Design, design_hash, load_design
from optimizer.certify.certificate import Certificate
from optimizer.codesign import report
from optimizer.codesign.bound import Bound, Family
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection
from optimizer.codesign.report import FIGURES, certificate_of
from optimizer.codesign.search import Search
from optimizer.commands import cli
from tests.committed import BEST

BRIEF = """
name = "synthesized"
[requirements]
envelope_width_mm = 270
envelope_depth_mm = 220
[feel]
kappa_max = 2.27
[hardware]
motor = "maxon-re30-310007"
drive = "capstan"
"""
LENGTHS = (91.0, 143.196, 31.0, 24.0, 64.37, 43.165)
CHOICE = Selection("maxon-re30-310007", "capstan", 4.8, 54.0)


class Idle(nullcontext[Any]):
    """In place of a process: it takes an order and does nothing."""

    def __init__(self, *_: object, **__: object) -> None:
        super().__init__(SimpleNamespace(send=lambda _: None))


def call(*words: str | Path) -> int:
    return cli.main(["design", *map(str, words)])


def build_on_paper(best_masses: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """The masses of the one assembly stand for what is built; what is proved and computed of it is made up."""

    def build(design: Design, out: Path, *_: object, adjacent: Callable[[Path, Outcome], str], **_k: object) -> Outcome:
        folder = out / design.name
        folder.mkdir(parents=True, exist_ok=True)
        checks = [
            CheckResult("kappa", True, 2.2699, 2.27, ""),
            CheckResult("effective mass", True, 0.46, None, "kg"),
            CheckResult("envelope width", True, 247.9, 270.0, "mm"),
            CheckResult("envelope depth", True, 219.5, 220.0, "mm"),
        ]
        masses = best_masses | {"input_sha256": design_hash(design)}
        (folder / "mass_properties.json").write_text(json.dumps(masses), encoding="utf-8")
        outcome = Outcome(design, checks, masses, folder, ())
        adjacent(folder, outcome)
        write_record(folder)
        return outcome

    values = dict.fromkeys((one.key for one in FIGURES), 1.0) | {"cube_side_mm": 86.33, "effective_mass_max_kg": 0.46}
    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr(pipeline, "poor_figures", lambda *_: [])
    monkeypatch.setattr("optimizer.codesign.bound.bounded", lambda family, side, *_: bound_of(family, 1.01, side))
    monkeypatch.setattr("optimizer.codesign.relaxation.costs", lambda *_: [])
    monkeypatch.setattr(report, "results_of", lambda _: values)
    monkeypatch.setattr(report, "certificate_of", certified)


def bound_of(family: Family, factor: float, side_mm: float) -> Bound:
    return Bound(factor * side_mm, factor - 1.0, 1, family.kind, family.described())


CERTIFIED: list[Certificate] = []
"""Of the committed machine with its masses, once for all tests."""


def certified(design: Design, masses: Path) -> Certificate:
    if not CERTIFIED:
        CERTIFIED.append(certificate_of(design, masses))
    return CERTIFIED[0]


def finds(
    monkeypatch: pytest.MonkeyPatch,
    then: Callable[[], None] = lambda: None,
    left: Sequence[str] = (),
    times: int = 1,
    required: Mapping[str, float] = MappingProxyType({}),
) -> None:
    """Lets the search build the committed machine so often, with requirements that it states, and do something then."""
    stated = load_design(BEST)
    design = stated.model_copy(update={"requirements": stated.requirements.model_copy(update=dict(required))})

    def best(search: Search) -> Any:
        search.log.left = list(left)
        search.corrections[CHOICE.motor, CHOICE.drive] = Corrections(reference(), why=("the wrists were too close",))
        search.log.no_progress["faulhaber-3257g024cr capstan"] = "too weak"
        outcome = None
        for k in range(times):
            made = design.model_copy(update={"cube": design.cube.model_copy(update={"half_side_mm": 43.165 - k})})
            search.built_candidate = Candidate(made, CHOICE, LENGTHS, Corrections(reference()), 86.33)
            outcome = search.build(made)
        then()
        return search.built_candidate, outcome

    monkeypatch.setattr(Search, "best", best)


def interrupt() -> None:
    raise KeyboardInterrupt
