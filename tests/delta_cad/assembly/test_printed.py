"""The order in which a printed machine is put together: what its sheets leave to assembly is done in a step.

4 s of processor: the solids of one printed machine.
"""

from __future__ import annotations

import pytest

from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.machine import Assembly
from delta_cad.design import load_design
from delta_cad.dimensions import dimensions
from tests.committed import ROOT

REAMER = "drill 2.9 mm, reamer 3 H7"
NAMES = {"bar_adhesive": "etaining compound", "tube_adhesive": "Epoxy paste"}


@pytest.fixture(scope="module")
def printed() -> Assembly:
    return assemble(dimensions(load_design(ROOT / "docs" / "gallery" / "maker-60.json")))


def test_every_pair_of_parts_that_is_reamed_together_has_its_step(printed: Assembly) -> None:
    left = {(p.number, b.reamed_with) for p in printed.parts for h in p.holes for b in h.bores if b.reamed_with}
    assert ("base_plate", "foot_block") in left
    steps = [step for unit in printed.order for step in unit.steps if REAMER in step.tools]
    words = [" ".join(step.words) for step in steps]
    for part, name in (("base_plate", "plate's holes"), ("motor_cheek", "cheeks' holes")):
        (drilled,) = {b.predrilled_mm for p in printed.parts if p.number == part for h in p.holes for b in h.bores} - {
            0.0
        }
        found = [text for text in words if f"through the {name} of {drilled:g} mm" in text]
        assert len(found) == 3, part  # one of each drive
        assert all("ream" in text and "deep into the block" in text for text in found)


@pytest.mark.parametrize("machine", ["printed", "best_assembly"])
def test_a_step_lists_the_adhesives_that_its_words_name(machine: str, request: pytest.FixtureRequest) -> None:
    assembly: Assembly = request.getfixturevalue(machine)
    for step in (step for unit in assembly.order for step in unit.steps):
        words = " ".join(step.words)
        assert {key for key, name in NAMES.items() if name in words} == set(step.supplies) & set(NAMES), step.title
