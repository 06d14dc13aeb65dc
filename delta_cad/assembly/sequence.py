"""The order in which a machine is put together, as `sequence.toml` has it: its steps for this machine, with figures.

A step names what comes in; the path to its seat was stated where the part is placed.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import replace
from fnmatch import fnmatchcase
from math import degrees
from pathlib import Path
from typing import Any

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.builder import DOWN, IN, OUT, AssemblyBuilder, straight
from delta_cad.assembly.machine import Insertion, Step, Unit
from delta_cad.assembly.supplies import BAR_ADHESIVE
from delta_cad.design.process import any_printed
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import SET_SCREW, TENSION_SCREW, SET_TORQUE_N_m
from delta_cad.dimensions.forearm import TUBE_ADHESIVE
from delta_cad.dimensions.joint import CLEARANCE_MM, CLEARANCE_TOLERANCE_MM
from delta_cad.dimensions.leads import SENSOR_MM, STRAIGHT_MM
from delta_cad.dimensions.panel import TEMPLATE
from delta_cad.dimensions.platform import BENCH_HOLE, FACTOR, WRIST_MARK
from delta_cad.dimensions.rules import tenths_above
from delta_cad.dimensions.sizes import largest_force_N
from delta_cad.dimensions.tolerances import LIP_ROOM_MM, PREDRILLED_MM, END_TORQUE_N_m
from delta_cad.dimensions.tolerances.cable_setting import STROKES, bench_pull_N, cable_setting
from delta_cad.dimensions.tolerances.machine import general_class
from delta_cad.dimensions.tolerances.zero import (
    CALIBRATED_MM,
    ZERO_DEG,
    calibrated_chain,
    stop_chain,
    travel_off_deg,
)
from delta_cad.mechanism import joint_angles
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids.bought_parts import CORD_SLACK_MM
from delta_cad.solids.brackets import DOWEL_DEPTH_MM, base_pin_mm, cheek_dowel_depth_mm, is_base_slotted, is_slotted
from delta_cad.solids.part import Consumable

STEPS = Path(__file__).with_name("sequence.toml")
_MELT_C = 230.0  # of the iron that sets inserts: above what PETG and polyamide soften at; from memory
_PATHS = {"IN": IN, "OUT": OUT, "DOWN": DOWN, "INWARDS": straight(-1.0, 0.0, 0.0)}


def assembly_sequence(builder: AssemblyBuilder, supplies: Iterable[Consumable]) -> tuple[Unit, ...]:
    """States how a machine is put together.

    Args:
        builder: With all its parts placed.
        supplies: What is bought beside them.

    Returns:
        The units in the order in which they are made, the machine last.
    """
    return _Sequence(builder, {supply.number for supply in supplies}).units()


def _conditions(d: Dimensions) -> dict[str, bool]:
    holding = {
        "capstan": d.capstan is not None,
        "sensor": d.sensed_at_shoulder,
        "sensor_lead": d.sensor_lead is not None,
        "leads": bool(d.leads),
        "panel": d.panel is not None,
        "feet": d.has_feet,
        "stud": d.foot.stud_length_mm is not None,
        "slot": d.capstan is not None and d.capstan.collar_at_motor,
        "screwed": d.is_screwed_down and d.bench is None,
        "sleeves": bool(d.sleeve_mm),
        "bench": d.bench is not None,
        "even": d.design.geometry.three_fold and not d.design.workspace.centre_x,
        "alike": d.design.geometry.three_fold,
        "off_axis": bool(d.design.workspace.centre_x),
        "printed": any_printed(d.design.hardware),
        "printed_bosses": d.is_printed("upper_arm") or d.is_printed("platform"),
        "slotted": is_slotted(d, "m", 1),
        "base_slotted": is_base_slotted(d),
        "boards": bool(d.motor.drive_board),
    }
    names = {"direct": "capstan", "own_encoder": "sensor", "no_slot": "slot"}
    names |= {"cut_bosses": "printed_bosses", "reamed": "slotted", "base_reamed": "base_slotted"}
    names |= {"no_stud": "stud", "no_sleeves": "sleeves", "uneven": "even", "not_alike": "alike"}
    return holding | {name: not holding[of] for name, of in names.items()}


def _values(d: Dimensions) -> dict[str, Any]:
    """The figures that steps name: of what this machine has."""
    f, c, cube, tension = d.forearm, d.capstan, d.design.cube, catalogue.screw(TENSION_SCREW)
    low, high = (degrees(stop) for stop in d.stops_rad)
    found: dict[str, Any] = {
        "d": d,
        "f": f,
        "c": c,
        "retainer": catalogue.adhesive(BAR_ADHESIVE).description,
        "tube_adhesive": catalogue.adhesive(TUBE_ADHESIVE).description,
        "goes_mm": f.seat_diameter_mm - 2 * CLEARANCE_TOLERANCE_MM,
        "not_goes_mm": f.seat_diameter_mm + 2 * CLEARANCE_TOLERANCE_MM,
        "lip_room_mm": LIP_ROOM_MM,
        "rods_mm": 4 * (CLEARANCE_MM + CLEARANCE_TOLERANCE_MM),  # two seats of either rod on the jig's balls
        "over_balls_mm": f.width_mm + f.ball_diameter_mm,
        "stub_mm": d.layers.arm_mm[0] - d.shaft.y_mm[0],
        "tension_key": tension.socket_mm,
        "set_key": catalogue.set_screw(SET_SCREW).socket_mm,
        "set_torque_N_m": SET_TORQUE_N_m,
        "low_deg": low,
        "high_deg": high,
        "travel_deg": high - low,
        "counts": (high - low) / 360.0 * d.encoder.counts_per_turn,
        "calibrated_mm": CALIBRATED_MM,
        "zero_off_deg": calibrated_chain(d).worst[1],
        "zero_deg": ZERO_DEG,
        "predrilled_mm": PREDRILLED_MM,
        "reamed_mm": cheek_dowel_depth_mm(d),
        "straight_mm": STRAIGHT_MM,
        "cord_slack_mm": CORD_SLACK_MM,
        "base_reamed_mm": DOWEL_DEPTH_MM,
        "pins_under_mm": d.base.thickness_mm - base_pin_mm(d)[0],
        "cube_mm": cube.bottom_height_mm + cube.half_side_mm,
        "home_deg": degrees(d.home_rad),
        "middle_deg": np.degrees(joint_angles(d.design.geometry, d.design.workspace.centre)),
        "off_mm": abs(cube.centre_x_mm or 0.0),
        "off_way": "towards" if (cube.centre_x_mm or 0.0) > 0.0 else "away from",
        "template": TEMPLATE,
        "melt_C": _MELT_C,
        "wrist_mark": WRIST_MARK,
        "mount_drill_mm": catalogue.screw(BENCH_HOLE).clearance_hole_mm,
        "stand_N": FACTOR * largest_force_N(d.design.requirements),
    }
    if d.sensed_at_shoulder:
        general = general_class(d)
        found["stop_off_deg"] = tenths_above(stop_chain(d, general).worst[1])
        found["travel_off_deg"] = tenths_above(travel_off_deg(d, general))
    if c is not None:
        s = cable_setting(d)
        assert s is not None
        half, upper = c.run.stroke_rad / 2.0, s.arm_rad > 0.0
        found |= {
            "pinion_off_mm": d.layers.motor_cheek_mm[0] - c.pinion_y_mm[0],
            "collar_end": "first" if c.collar_at_motor else "last",
            "slack_mm": c.bench_mm[0],
            "slack_off_mm": c.bench_mm[1],
            "pull_N": bench_pull_N(d),
            "strokes": STROKES,
            "at_deg": degrees(half - abs(s.arm_rad)),
            "at_stop": "upper" if upper else "lower",
            "faces": "the slot in the motor cheek's edge" if c.collar_at_motor else "outwards",
            "goes": "rises" if s.rises else "falls",
            "stands_N": s.pull_N[0],
            "creeps_N": s.pull_N[1],
            "step_deg": degrees(s.step_rad),
            "step_N": s.step_N,
            "needed_N": s.needed_N,
            "tension_N": s.tension_N,
            "balance_N": s.balance_N,
            "head_held": f"a spanner {d.shaft.flats_mm:g}" if d.shaft.flats_mm else "soft jaws",
            "end_torque_N_m": END_TORQUE_N_m[d.shaft.end_screw],
        }
    if d.leads:
        furthest = max(d.leads, key=lambda leads: leads.behind_mm)
        found["lead_bend_mm"] = furthest.bend_mm - furthest.diameter_mm / 2.0
        found["lead_behind_mm"] = furthest.behind_mm
    if (s := d.sensor_lead) is not None:
        found["clip_low_mm"] = -s.clip_z_mm - d.encoder.board_length_mm / 2.0
        found["sensor_bend_mm"] = s.bend_mm - SENSOR_MM / 2.0
    if (p := d.panel) is not None:
        found["opening_mm"] = p.half_mm + p.opening_mm - p.stem_radius_mm
        found["collar_mm"] = p.collar_mm - d.platform.boss_diameter_mm / 2
    return found


class _Sequence:
    """The steps of the file for a machine whose parts are placed.

    Args:
        builder: That placed them.
        bought: Numbers of what is bought beside them.
    """

    def __init__(self, builder: AssemblyBuilder, bought: set[str]) -> None:
        self._paths, self._bought = builder.paths, bought
        self._numbers = {o.name: o.part.number for o in builder.occurrences}
        self._holding, self._values = _conditions(builder.d), _values(builder.d)
        self._rows: dict[str, dict[str, Any]] = {}

    def units(self) -> tuple[Unit, ...]:
        """Gives the units in the order of the file."""
        found = []
        for unit in tomllib.loads(STEPS.read_text(encoding="utf-8"))["unit"]:
            if self._holds(unit):
                rows = [self._inherited(row) for row in unit["step"]]
                found += [self._unit(unit, rows, at) for at in _places(unit["name"])]
        return tuple(found)

    def _inherited(self, row: dict[str, Any]) -> dict[str, Any]:
        """A step with what it takes from an earlier one."""
        whole = self._rows.get(row.get("like", ""), {}) | row
        self._rows.setdefault(row["title"], whole)
        return whole

    def _unit(self, unit: dict[str, Any], rows: list[dict[str, Any]], at: dict[str, int]) -> Unit:
        """A unit; the part that it begins with is there, and has no path."""
        first, *rest = [
            self._step(row, at | place) for row in rows if self._holds(row) for place in _places(row["title"])
        ]
        if first.insertions and first.insertions[0].names:
            first = replace(first, insertions=(Insertion(first.insertions[0].names), *first.insertions[1:]))
        (title,) = self._texts([unit["title"]], at)
        kind = unit["name"].partition("{")[0].strip()
        return Unit(unit["name"].format(**at), kind, title, (first, *rest))

    def _step(self, row: dict[str, Any], at: dict[str, int]) -> Step:
        insertions = tuple(insertion for one in row.get("insert", ()) for insertion in self._insertions(one, at))
        coming = (name for insertion in insertions for name in insertion.names)
        screws = tuple(name for name in coming if self._numbers[name].startswith("screw_"))
        torque = row.get("torque_N_m")
        return Step(
            title=row["title"].format(**at),
            words=self._texts(row["words"], at),
            insertions=insertions,
            tightened=self._named(row["tightened"], at) if "tightened" in row else screws,
            torque_N_m=None if torque is None else float(torque.format(**self._values)),
            tools=self._texts(row.get("tools", ()), at),
            supplies=tuple(number for number in self._texts(row.get("supplies", ()), at) if number in self._bought),
            checks=self._texts(row.get("checks", ()), at),
            shown=self._named(row.get("shown", ()), at),
            unseen=self._named(row.get("unseen", ()), at),
        )

    def _insertions(self, one: str | dict[str, Any], at: dict[str, int]) -> list[Insertion]:
        if isinstance(one, str):
            return [Insertion((name,), *self._paths[name]) for name in self._named([one], at)]
        if not self._holds(one):
            return []
        if "part" in one:
            return self._insertions(one["part"], at)
        if "laid" in one:
            return [Insertion(self._named(one["laid"], at), is_flexible=True)]
        return [Insertion((), _PATHS[one["path"]], one["frame"].format(**at), (one["unit"].format(**at),))]

    def _named(self, patterns: Iterable[str], at: dict[str, int]) -> tuple[str, ...]:
        """Occurrences of patterns, of each in the order in which they were placed."""
        exact = [pattern.format(**at) for pattern in patterns]
        return tuple(name for pattern in exact for name in self._numbers if fnmatchcase(name, pattern))

    def _texts(self, rows: Iterable[str | dict[str, str]], at: dict[str, int]) -> tuple[str, ...]:
        """Texts with their figures, of those with a condition the ones that hold."""
        every = (row.items() if isinstance(row, dict) else [("", row)] for row in rows)
        holding = (text for items in every for when, text in items if not when or self._holding[when])
        return tuple(text.format(**self._values, **at) for text in holding)

    def _holds(self, row: dict[str, Any]) -> bool:
        return all(self._holding[one] for one in row.get("when", "").split(", ") if one)


def _places(text: str) -> list[dict[str, int]]:
    """Chains, or rods, that a text with {i}, or with {i} and {j}, is for; one of neither for anything else."""
    if "{j}" in text:
        return [{"i": i, "j": j} for i in CHAINS for j in SIDES]
    return [{"i": i} for i in CHAINS] if "{i}" in text else [{}]
