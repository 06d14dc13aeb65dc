"""Loads of every part against their allowable values, the required stiffness at the knob, and how the base is held."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isfinite
from typing import Any

import numpy as np

from delta_cad import catalogue
from delta_cad.checks.report import CheckResult
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.platform import FACTOR, FOOT_FRICTION, MOUNT_SCREW, firmer_mounting
from delta_cad.dimensions.sizes import largest_force_N
from delta_cad.structure.loads import Load, screw_pull_N
from delta_cad.structure.mounting import upset
from delta_cad.structure.report import KnobStiffness, StructureReport, structure_report
from delta_cad.structure.strength import screw_N

_JOINT_MIN_N_MM = 500.0  # below, the joints are what gives most at the knob


def check_structure(d: Dimensions, bodies: Mapping[str, Any]) -> list[CheckResult]:
    """Checks loads and stiffness of a machine.

    Args:
        d: Its dimensions; where its design requires no stiffness at the knob, that is reported, not judged.
        bodies: `bodies` of its mass report.

    Returns:
        One result for the stiffness, one for that of a ball joint, one for the first mode, which is only reported, one
        for each load and case, and what holds the base: its screws, or its weight against tipping and sliding.
    """
    found = structure_report(d, bodies)
    count = len(found.stiffness.positions_mm)
    loads = [_load(case, force, load, count) for case, (force, all_) in found.cases.items() for load in all_]
    knob = _check_knob(found.stiffness, d.design.requirements.stiffness_min_N_mm)
    return [
        knob,
        check_joint(found.stiffness.table.joint_N_mm),
        _first_mode(found),
        *loads,
        *_base(d, bodies, found.stiffness),
    ]


def _base(d: Dimensions, bodies: Mapping[str, Any], over: KnobStiffness) -> Iterator[CheckResult]:
    """Checks what holds the base against a user's push, `FACTOR` times the largest force at the handle."""
    force, knob = FACTOR * largest_force_N(d.design.requirements), over.table.knob_mm
    who = f"{force:g} N at the knob, {FACTOR:g} times the largest force, worst of {len(over.positions_mm)} positions"
    if d.is_screwed_down:
        weight = sum(float(body["mass_kg"]) for body in bodies.values())
        weight *= float(np.linalg.norm(d.design.requirements.gravity_m_s2))
        pulls, limit = screw_pull_N(over.table, over.positions_mm, force, weight), screw_N(catalogue.screw(MOUNT_SCREW))
        pull, k = float(pulls.max()), int(pulls.argmax())
        detail = f"{who}, pull on the most loaded screw, which also carries the whole weight; limit: its clamping force"
        place = _place(over.positions_mm[k])
        yield CheckResult("structure mounting screw", pull <= limit, pull, limit, "N", place, None, detail)
    if not d.stands_free:
        return
    found = upset(d, bodies, over.positions_mm, knob, force)
    stands = min(found.tips_N, found.slides_N) >= force
    on = "its feet" if d.bench is None else "its pads"
    heavier = f", or {found.added_kg:.1f} kg more amid {on}" if isfinite(found.added_kg) else ""
    more = "" if stands else f"; {firmer_mounting(d)}{heavier}"
    tips = f"least force at the knob that tips it over the line through two of {on}; limit: {who}{more}"
    slides = f"least force that slides it, friction of {on} {FOOT_FRICTION:g}; limit: {who}{more}"
    place = _place(found.tips_mm)
    yield CheckResult("structure tipping", found.tips_N >= force, found.tips_N, force, "N", place, None, tips)
    yield CheckResult("structure sliding", found.slides_N >= force, found.slides_N, force, "N", None, None, slides)


def check_joint(value_N_mm: float) -> CheckResult:
    """Checks the stiffness of a ball joint with its rod's end, along the rod, N/mm."""
    detail = (
        "along the rod at rest, tension or compression: ball in its cup with the largest clearance, and the rod's end"
    )
    name = "structure ball joint stiffness"
    return CheckResult(name, value_N_mm >= _JOINT_MIN_N_MM, value_N_mm, _JOINT_MIN_N_MM, "N/mm", detail=detail)


def _check_knob(over: KnobStiffness, required_N_mm: float | None) -> CheckResult:
    """Checks the smallest stiffness at the knob over the sampled cube, of new cables; without a limit it reports it."""
    values, shares = over.new.stiffness_N_mm, over.new.shares
    k, centre, settled = int(np.argmin(values)), len(over.positions_mm) - 1, over.softest.stiffness_N_mm
    value = over.least_N_mm
    most = sorted(shares, key=lambda name: -shares[name][k])[:3]
    reported = ", ".join(f"{name} {shares[name][k]:.0%}" for name in most)
    x, y, z = (float(c) for c in over.new.direction[k])
    detail = (
        f"softest of {len(values)} positions, corners among them, {over.table.knob_mm:g} mm over the wrists, "
        f"actuators held, along ({x:.2f}, {y:.2f}, {z:.2f}): {reported}; {value:.1f} N/mm with new cables, "
        f"{settled.min():.1f} with settled ones; {values[centre]:.1f} and {settled[centre]:.1f} N/mm in the centre; "
        f"ball joints {over.table.joint_N_mm:g} N/mm"
    )
    passed = required_N_mm is None or value >= required_N_mm
    if not passed:
        detail += f"; requirements.stiffness_min_N_mm = {required_N_mm:g}"
    return CheckResult(
        "structure stiffness at the knob",
        passed,
        value,
        required_N_mm,
        "N/mm",
        _place(over.positions_mm[k]),
        None,
        detail,
    )


def _first_mode(found: StructureReport) -> CheckResult:
    over, modes = found.stiffness, found.modes_Hz
    k = int(modes.argmin())
    detail = f"lowest of {len(modes)} positions, actuators held, nobody's hand; {modes[-1]:.1f} Hz in the centre"
    return CheckResult(
        "structure first mode", True, float(modes[k]), None, "Hz", _place(over.positions_mm[k]), None, detail
    )


def _load(case: str, force_N: float, load: Load, count: int) -> CheckResult:
    detail = (
        f"{force_N:g} N at the knob in the worst direction, {case}, with the weight; largest of {count} positions; "
        f"margin {load.margin:.3g}: {load.source}"
    )
    name = f"structure {load.name}" + ("" if case == "for ever" else f", {case}")
    pair = (f"chain_{load.chain}",)
    return CheckResult(name, load.holds, load.value, load.limit, load.unit, load.position_mm, pair, detail)


def _place(position_mm: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in position_mm)
    return x, y, z
