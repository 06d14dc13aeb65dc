"""Leads of motors and boards: drawn with their bends, tied, counted in the outline; astray or missing: told."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from math import acos, pi

import cadquery as cq
import numpy as np
import pytest
from OCP.BRepAdaptor import BRepAdaptor_Surface  # pyright: ignore[reportAttributeAccessIssue]

from delta_cad import catalogue
from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.leads import lead_names
from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.engagement import check_contacts
from delta_cad.design import DesignError, design_from_dict
from delta_cad.dimensions import DimensionError, Dimensions, dimensions
from delta_cad.dimensions import leads as leads_module
from delta_cad.dimensions.leads import (
    BEND,
    CLIP_MM,
    LEAD_MM,
    PLUG_MM,
    PLUGGED_MM,
    SENSOR_MM,
    TAIL_MM,
    SensorLeadDimensions,
    lead_dimensions,
    sensor_lead_dimensions,
)
from delta_cad.mechanism.placement import CHAINS
from delta_cad.solids.leads import make_lead, make_sensor_lead
from delta_cad.solids.part import location_of
from delta_cad.structure.hardware.refusals import least_outline_mm
from tests.committed import ROOT, changed
from tests.delta_cad.assembly.expected.comparing import make_faults, part_faults
from tests.designs import placed

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
    (leads,) = d.leads
    part = next(o.part for o in assembly.occurrences if o.part.number == "motor_lead")
    length = PLUG_MM + pi / 2.0 * (BEND + 0.5) * LEAD_MM + TAIL_MM
    assert part.solid.Volume() == pytest.approx(pi / 4.0 * LEAD_MM**2 * length, rel=1e-6)
    assert leads.behind_mm == pytest.approx(BEHIND_MM)
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


def test_a_board_s_lead_goes_from_its_header_in_bends_that_it_bears_on_to_the_leg() -> None:
    d, assembly = drawn(), machine()
    s, placed = d.sensor_lead, {o.name: o for o in assembly.occurrences}
    assert s is not None
    solid = placed["sensor_lead_1"].part.solid
    bends = [BRepAdaptor_Surface(face.wrapped) for face in solid.Faces() if face.geomType() == "TORUS"]
    assert [bend.Torus().MajorRadius() for bend in bends] == pytest.approx(2 * [(BEND + 0.5) * SENSOR_MM])
    housing = PLUGGED_MM[0] * PLUGGED_MM[1] * PLUGGED_MM[2]
    assert solid.Volume() == pytest.approx(housing + pi / 4.0 * SENSOR_MM**2 * s.length_mm, rel=1e-6)
    header = placed["encoder_board_1"].placement @ [d.encoder.board_length_mm / 2.0 - 1.0, -3.6, 0.0, 1.0]
    assert placed["sensor_lead_1"].placement[:3, 3] == pytest.approx(header[:3])
    foot = d.bracket.base_top_mm + d.bracket.foot_height_mm
    assert placed["lead_clip_1"].placement[2, 3] > foot + CLIP_MM[0] / 2.0
    end = solid.BoundingBox().zmin + s.plug_mm[2]
    assert end == pytest.approx(s.clip_z_mm - CLIP_MM[0] / 2.0 - TAIL_MM)


def test_one_that_must_go_far_aside_goes_level_between_quarter_turns() -> None:
    near, far = (SensorLeadDimensions((0.0, 0.0, 0.0), 10.5, (way, 3.0), 0.0) for way in (4.0, 40.0))
    assert near.level_mm == 0.0
    assert near.turn_rad == pytest.approx(acos(1.0 - 5.0 / 21.0))
    assert far.turn_rad == pytest.approx(pi / 2.0)
    assert far.level_mm == pytest.approx(np.hypot(40.0, 3.0) - 21.0)
    for s in (near, far):
        part = make_sensor_lead(s)
        assert part.extent_mm is not None
        box = part.solid.BoundingBox()
        assert ((box.xmin, box.xmax), (box.ymin, box.ymax), (box.zmin, box.zmax)) == tuple(
            pytest.approx(span, abs=1e-6) for span in part.extent_mm
        )


def test_a_leg_is_as_long_as_the_tie_on_it_asks_where_nothing_else_asks_for_more() -> None:
    """A direct drive with a high cube: its elbows leave room for a base so high that no tie has any."""
    data = json.loads((ROOT / "docs/gallery/direct-83.json").read_text())
    data["requirements"] |= {"envelope_width_mm": 900.0, "envelope_depth_mm": 900.0}
    data["mechanism"] |= {"upper_arm_length_mm": 68.0, "forearm_length_mm": 105.0}
    data["cube"] |= {"bottom_height_mm": 60.0, "half_side_mm": 20.0}
    data["hardware"]["motor"] = "maxon-ec45flat-411812"
    tops = {}
    for leads in ("none", "bent"):
        data["hardware"]["leads"] = leads
        d = dimensions(design_from_dict(data))
        tops[leads] = d.bracket.base_top_mm + d.bracket.foot_height_mm
    assert d.sensor_lead is not None
    tie = d.sensor_lead.clip_z_mm - CLIP_MM[0] / 2.0
    assert tops["none"] > tie >= tops["bent"]
    assert tops["bent"] == pytest.approx(tie, abs=0.2)  # in whole tenths, and the tie moves with the foot


def test_a_neighbour_s_motor_that_is_too_near_is_refused_in_closed_form(monkeypatch: pytest.MonkeyPatch) -> None:
    """The oracle of the distance is the kernel's, between the solids as they are placed."""
    solids = {
        o.name: o.part.solid.moved(cq.Location(location_of(o.placement)))
        for o in machine().occurrences
        if o.part.number in ("sensor_lead", "motor")
    }
    apart = min(solids["sensor_lead_0"].distance(solids[f"motor_{i}"]) for i in (1, 2))
    monkeypatch.setattr(leads_module, "APART_LEAST_MM", apart + 0.1)
    with pytest.raises(DimensionError, match="motors come within") as refused:
        drawn()
    (reason,) = refused.value.reasons
    reported = re.search(r"within ([\d.]+) mm", reason.message)
    assert reported is not None
    assert float(reported[1]) == pytest.approx(apart, abs=0.02)
    assert reason.field == "mechanism.base_radius_mm"
    drawn(mechanism__base_radius_mm=31.5)


def test_a_motor_with_an_encoder_of_its_own_has_that_one_s_lead_next_to_its_own() -> None:
    at_motor = {"hardware__motor": "maxon-re30-310009-500", "hardware__encoder_at": "motor"}
    design, d = design_from_dict(changed(hardware__leads="bent", **at_motor)), drawn()
    phases, own = lead_dimensions(design, catalogue.motor.rows["maxon-re30-310009-500"])
    assert (phases.number, own.number) == ("motor_lead", "encoder_lead")
    assert own.behind_mm == pytest.approx(PLUG_MM + (BEND + 1.0) * SENSOR_MM)
    assert min(own.across_mm) - max(phases.across_mm) > (LEAD_MM + SENSOR_MM) / 2.0
    assert sensor_lead_dimensions(design, d.layers, d.bracket, d.encoder, d.motor) is None
    both = replace(d, leads=(phases, own), sensor_lead=None)
    assert lead_names(both, 0) == ("motor_lead_0_0", "motor_lead_0_1", "encoder_lead_0_0")
    assert make_lead(own).solid.BoundingBox().ymax == pytest.approx(own.behind_mm, abs=1e-6)


def test_the_outline_that_closed_forms_ask_for_counts_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """They stay within the motor's corner; ones that are straight for longer would not."""
    without = dimensions(design_from_dict(changed()))
    assert least_outline_mm(drawn()) == pytest.approx(least_outline_mm(without))
    assert without.leads == ()
    assert without.sensor_lead is None
    d = drawn()
    monkeypatch.setattr(leads_module, "PLUG_MM", PLUG_MM + 4.0)
    assert (least_outline_mm(d) > least_outline_mm(without) + 3.0).any()


def test_the_closed_form_of_where_they_stand_out_is_that_of_their_solids() -> None:
    d, assembly = drawn(), machine()
    placed = [o for o in assembly.occurrences if o.part.number == "motor_lead"]
    found = []
    for o in placed:
        vertices = np.array([v.toTuple() for v in o.part.solid.tessellate(1e-3, 0.05)[0]])
        found.append(vertices @ o.placement[:2, :3].T + o.placement[:2, 3])
    (leads,) = d.leads
    back = d.bracket.motor_axis_mm[0], d.layers.motor_face_mm + d.motor.length_mm
    reported = np.concatenate([(np.array(leads.outside_mm) + back) @ d.turn(i)[:2, :2].T for i in CHAINS])
    solids = np.concatenate(found)
    assert reported.max(axis=0) == pytest.approx(solids.max(axis=0), abs=0.01)
    assert reported[:, 0].min() == pytest.approx(solids[:, 0].min(), abs=0.01)


def test_behind_a_placed_machine_a_lead_reaches_no_farther_than_its_motor_s_corner() -> None:
    """Points of a lead's middle line, half a lead farther: the corner of the motor of chain 1 is farther behind."""
    d = dimensions(design_from_dict(placed()))
    (leads,) = d.leads
    turns = np.linspace(0.0, pi / 2.0, 181)
    centre = d.bracket.motor_axis_mm[0] - leads.inside_mm - leads.bend_mm
    end = d.layers.motor_face_mm + d.motor.length_mm
    line = np.stack([centre + leads.bend_mm * np.cos(turns), end + PLUG_MM + leads.bend_mm * np.sin(turns)], axis=-1)
    behind = -d.stand(1)[0, :2]
    corner = behind @ [d.bracket.motor_axis_mm[0] + d.motor.diameter_mm / 2.0, end]
    off = corner - (line @ behind).max() - LEAD_MM / 2.0
    assert 0.0 <= off < 0.1  # in whole tenths of what it is farther inside
    assert leads.inside_mm + LEAD_MM < d.motor.diameter_mm / 2.0


def test_a_brushless_motor_has_three() -> None:
    design = design_from_dict(changed(hardware__leads="bent"))
    (leads,) = lead_dimensions(design, catalogue.motor.rows["maxon-ec60flat-625858"])
    assert len(leads.across_mm) == 3
    assert sum(leads.across_mm) == pytest.approx(0.0)


@pytest.mark.parametrize("number", ["motor_lead", "sensor_lead", "lead_clip"])
def test_one_that_is_missing_or_off_its_place_is_refused(number: str) -> None:
    assembly = machine()
    name = next(o.name for o in assembly.occurrences if o.part.number == number)
    assert part_faults(assembly, drawn()) == make_faults(assembly, drawn()) == []
    missing = replace(assembly, occurrences=tuple(o for o in assembly.occurrences if o.name != name))
    assert len(part_faults(missing, drawn())) == 1
    off = np.eye(4)
    off[2, 3] = 40.0
    astray = (replace(o, placement=o.placement @ off) if o.name == name else o for o in assembly.occurrences)
    found = check_contacts(replace(assembly, occurrences=tuple(astray)))
    assert not found.passed
    assert name in (found.worst_pair or ())


def test_the_manual_has_a_step_for_them_and_a_motor_comes_off_without_them() -> None:
    assembly = machine()
    reported = {step.title: step for unit in assembly.order for step in unit.steps}
    assert sorted(reported["Leads"].insertions[0].names) == sorted(leads_of(assembly))
    assert [insertion.names for insertion in reported["The encoder's lead"].insertions] == [
        ("lead_clip_2",),
        ("sensor_lead_2",),
    ]
    assert all(set(leads_of(assembly)) & set(removal.loose) for removal in assembly.removals)


def test_anything_else_is_refused_by_field() -> None:
    with pytest.raises(DesignError, match=r"hardware\.leads = .*must be .bent. or .none."):
        design_from_dict(changed(hardware__leads="straight"))
