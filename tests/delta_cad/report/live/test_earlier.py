"""The first minute of the live page: the last build's solids, where they are, and the words for what is being done."""

from __future__ import annotations

import shutil
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.design import Design, design_from_dict
from delta_cad.mechanism.placement import LINKS
from delta_cad.report.live.earlier import Earlier, earlier_machine
from delta_cad.report.live.page import LivePage
from delta_cad.report.subject import Subject
from tests.committed import Built, changed
from tests.delta_cad.report.live.test_page import drawn, guard, page, show_solids

__all__ = ["guard", "page"]  # fixtures


def test_the_parts_of_the_model_are_where_the_assembly_has_them(
    built: Built, best: Design, best_assembly: Assembly
) -> None:
    found = earlier_machine(best, built.folder)
    assert found is not None
    assert found.same
    bodies = {body.name: body for body in found.bodies}
    assert bodies.keys() == {o.name for o in best_assembly.occurrences}
    for o in best_assembly.occurrences:
        box = o.part.solid.BoundingBox(0.05)
        ends = (box.xmin, box.xmax), (box.ymin, box.ymax), (box.zmin, box.zmax)
        corners = np.array(list(product(*ends)))
        placed = corners @ o.placement[:3, :3].T + o.placement[:3, 3]
        body = bodies[o.name]
        assert body.link == o.link
        points = 1000.0 * body.points_m
        assert (points.min(axis=0) > placed.min(axis=0) - 0.1).all(), o.name
        assert (points.max(axis=0) < placed.max(axis=0) + 0.1).all(), o.name
    at = best_assembly.home_mm
    for link in LINKS:
        assert found.placement(at)[link] == pytest.approx(best_assembly.placement(at)[link], abs=1e-9)


def test_a_build_of_another_design_is_placed_as_that_one(built: Built, best: Design, tmp_path: Path) -> None:
    other = design_from_dict(changed(mechanism__forearm_length_mm=143.0))
    assert earlier_machine(other, tmp_path) is None
    assert (known := earlier_machine(other, built.folder)) is not None
    assert not known.same
    assert known.placement.geometry == best.geometry != other.geometry
    folder = tmp_path / "damaged"
    shutil.copytree(built.folder, folder)
    (folder / "assembly.glb").write_bytes(b"no model")
    assert earlier_machine(best, folder) is None
    (folder / "design.json").unlink()
    assert earlier_machine(other, folder) is None


@pytest.fixture
def machine(built: Built, best: Design) -> Earlier:
    found = earlier_machine(best, built.folder)
    assert found is not None
    return found


def test_the_last_solids_move_in_place_of_lines_until_there_are_others(
    page: LivePage, machine: Earlier, subject: Subject
) -> None:
    assert drawn(page)["arms"]
    page.show_earlier(machine)
    assert not drawn(page)["arms"]
    frame = page._earlier_frames["platform"]
    page.move(page.own.centre_mm + np.array([5.0, -3.0, 4.0]))
    assert frame.visible
    assert 1000.0 * np.array(frame.position) == pytest.approx(page.handle_mm)
    show_solids(page, subject, np.zeros(3))
    assert page._earlier_frames == {}
    assert not drawn(page)["arms"]


def test_solids_of_another_design_stand_next_to_the_lines_of_this_one(page: LivePage, machine: Earlier) -> None:
    page.show_earlier(Earlier(machine.bodies, machine.placement, same=False))
    assert drawn(page)["arms"]
    assert page._earlier_frames["platform"].visible


def test_what_is_being_done_is_a_sentence_over_all_else(page: LivePage) -> None:
    page.say("The solids are being made <now>.")
    assert "The solids are being made &lt;now&gt;." in page._doing.content
    page.say("")
    assert page._doing.content == ""
