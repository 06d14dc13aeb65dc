"""The motors' leads: drawn with their bend behind each motor, counted in the outline; astray or missing: told."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import pi

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.order.stated import order
from delta_cad.checks.contact.engagement import check_contacts
from delta_cad.checks.presence import check_presence
from delta_cad.design import DesignError, design_from_dict
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.dimensions.installation.leads import BEND, LEAD_MM, PLUG_MM, TAIL_MM, lead_dimensions
from delta_cad.mechanism.placement import CHAINS, chain_frame
from delta_cad.structure.refusals import least_outline_mm
from tests.committed import changed

BEHIND_MM = PLUG_MM + (BEND + 1.0) * LEAD_MM


def drawn(**values: object) -> Dimensions:
    return dimensions(design_from_dict(changed(hardware__leads="bent", **values)))


@cache
def machine() -> Assembly:
    return assemble(drawn())


def leads_of(assembly: Assembly) -> list[str]:
    return [o.name for o in assembly.occurrences if o.part.number == "motor_lead"]


def test_a_lead_is_a_rod_of_its_diameter_with_the_bend_that_it_bears() -> None:
    d, assembly = drawn(), machine()
    assert d.leads is not None
    part = next(o.part for o in assembly.occurrences if o.part.number == "motor_lead")
    length = PLUG_MM + pi / 2.0 * (BEND + 0.5) * LEAD_MM + TAIL_MM
    assert part.solid.Volume() == pytest.approx(pi / 4.0 * LEAD_MM**2 * length, rel=1e-6)
    assert d.leads.behind_mm == pytest.approx(BEHIND_MM)
    box = part.solid.BoundingBox()
    assert box.ymax == pytest.approx(BEHIND_MM, abs=1e-6)


def test_each_begins_on_the_back_of_its_motor_and_bends_inwards() -> None:
    d, assembly = drawn(), machine()
    assert len(leads_of(assembly)) == 6
    placed = {o.name: o.placement for o in assembly.occurrences}
    for name in leads_of(assembly):
        chain = name.split("_")[2]
        in_motor = np.linalg.inv(placed[f"motor_{chain}"]) @ placed[name]
        assert in_motor[1, 3] == pytest.approx(d.motor.length_mm)
        assert np.hypot(in_motor[0, 3], in_motor[2, 3]) < d.motor.diameter_mm / 2 - LEAD_MM
        tail = placed[name][:3, 3] - BEHIND_MM * placed[name][:3, 2]
        assert np.hypot(*tail[:2]) < np.hypot(*placed[name][:2, 3])
        assert tail[2] == pytest.approx(placed[name][2, 3])
    assert check_contacts(assembly).passed


def test_the_outline_that_closed_forms_ask_for_counts_them() -> None:
    without = dimensions(design_from_dict(changed()))
    assert (least_outline_mm(drawn()) > least_outline_mm(without) + 0.2).any()
    assert without.leads is None


def test_the_closed_form_of_where_they_stand_out_is_that_of_their_solids() -> None:
    d, assembly = drawn(), machine()
    placed = [o for o in assembly.occurrences if o.part.number == "motor_lead"]
    found = []
    for o in placed:
        vertices = np.array([v.toTuple() for v in o.part.solid.tessellate(1e-3, 0.05)[0]])
        found.append(vertices @ o.placement[:2, :3].T + o.placement[:2, 3])
    assert d.leads is not None
    back = d.bracket.motor_axis_mm[0], d.layers.motor_cheek_mm[1] + d.motor.length_mm
    told = np.concatenate([np.add(d.leads.outside_mm, back) @ chain_frame(i)[:2, :2].T for i in CHAINS])
    solids = np.concatenate(found)
    assert told.max(axis=0) == pytest.approx(solids.max(axis=0), abs=0.01)
    assert told[:, 0].min() == pytest.approx(solids[:, 0].min(), abs=0.01)


def test_a_brushless_motor_has_three() -> None:
    design = design_from_dict(changed(hardware__leads="bent"))
    leads = lead_dimensions(design, catalogue.motor.rows["maxon-ec60flat-625858"])
    assert leads is not None
    assert len(leads.across_mm) == 3
    assert sum(leads.across_mm) == pytest.approx(0.0)


def test_one_that_is_missing_or_off_its_motor_is_refused() -> None:
    assembly = machine()
    name = leads_of(assembly)[0]
    assert check_presence(assembly).passed
    missing = replace(assembly, occurrences=tuple(o for o in assembly.occurrences if o.name != name))
    assert not check_presence(missing).passed
    off = np.eye(4)
    off[2, 3] = 40.0
    astray = (replace(o, placement=o.placement @ off) if o.name == name else o for o in assembly.occurrences)
    found = check_contacts(replace(assembly, occurrences=tuple(astray)))
    assert not found.passed
    assert name in (found.worst_pair or ())


def test_the_manual_has_a_step_for_them_and_a_motor_comes_off_without_them() -> None:
    assembly = machine()
    steps = [step for unit in order(drawn(), assembly.occurrences) for step in unit.steps if step.title == "Leads"]
    assert len(steps) == 1
    assert sorted(steps[0].brings[0].names) == sorted(leads_of(assembly))
    assert all(set(leads_of(assembly)) & set(removal.loose) for removal in assembly.removals)


def test_anything_else_is_refused_by_field() -> None:
    with pytest.raises(DesignError, match=r"hardware\.leads = .*must be .bent. or .none."):
        design_from_dict(changed(hardware__leads="straight"))
