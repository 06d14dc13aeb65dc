"""Check of the order of assembly: every part occurs once, has a free path to its seat, and each screw is reached."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from delta_cad.assembly.machine import Assembly, Insertion, Step, Unit
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.contact.access import Scene, key_swing, swing_result, up_and_down
from delta_cad.checks.contact.order.paths import Leg, Ways
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.dimensions.layers import SWING_RAD
from delta_cad.solids.part import ToolAccess

_FLEXIBLE = (
    "capstan_cable",
    "rod_spring",
    "boot",
    "motor_lead",
    "encoder_lead",
    "sensor_lead",
)  # numbers of what is laid, with no way of its own
_DRAWN_MM = 1.0  # of a screw's head out of its seat: its key goes in and out so far at least
_ALIKE_MM = 1e-4  # of the places of equal parts in equal units
_SHOWN = 8  # faults that a report names; their number is told


def members(units: tuple[Unit, ...]) -> dict[str, tuple[str, ...]]:
    """Lists the occurrences that each unit consists of when it is finished, those of its own units included.

    A unit that is asked for before it is there counts as empty.
    """
    found: dict[str, tuple[str, ...]] = {}
    for unit in units:
        found[unit.name] = tuple(
            name for step in unit.steps for insertion in step.insertions for name in brought(insertion, found)
        )
    return found


def brought(insertion: Insertion, made: dict[str, tuple[str, ...]]) -> tuple[str, ...]:
    """Lists the occurrences that come in together, of units what they consist of."""
    return (*insertion.names, *(name for unit in insertion.units for name in made.get(unit, ())))


def check_order(assembly: Assembly, limits: CheckLimits, meshes: Meshes) -> list[CheckResult]:
    """Puts the machine together in the order that it states.

    Returns:
        `assembly order`: number of faults: parts that the order has not, or twice; units that are not there when they
        are asked for; supplies that no step uses, or that steps use and nobody buys; parts that meet something on their
        way, by name, with what they meet and how far before their seat. `assembly keys`: least angle by which a key's
        handle is free to swing in a screw that a step tightens, deg, of 60. None of both where no order is stated.
    """
    if not assembly.order:
        return []
    made = members(assembly.order)
    faults = list(_uncovered(assembly, made))
    known = {o.name for o in assembly.occurrences}
    ways = Ways(assembly, meshes)
    swings = list[tuple[float, str, str]]()
    seen: set[tuple[object, ...]] = set()
    count = 0
    for unit in assembly.order:
        alike = _alike(unit, made, ways, known, assembly)
        if alike in seen:
            continue
        seen.add(alike)
        present: list[str] = []
        for step in unit.steps:
            for insertion in step.insertions:
                coming = [name for name in brought(insertion, made) if name in known]
                count += 1
                fault = _met(insertion, coming, present, ways, assembly)
                if fault:
                    faults.append((coming[:1], f"{unit.name}, {step.title}: {fault}"))
                present += coming
            if step.tightened:
                swings += _swings(step, present, assembly, limits, meshes)
    detail = f"free swing of a hexagon key in each screw when its step tightens it, least of {len(swings)} screws"
    return [_reported_faults(faults, count, assembly), swing_result("assembly keys", swings, detail)]


def _uncovered(assembly: Assembly, made: dict[str, tuple[str, ...]]) -> Iterator[tuple[list[str], str]]:
    """Parts missing or doubled, units unmade or unused, supplies unused or not bought."""
    last = assembly.order[-1].name
    counts = Counter(made[last])
    placed = [o.name for o in assembly.occurrences]
    for name in placed:
        if counts[name] != 1:
            yield [name], f"{name} comes in {counts[name]} times"
    for name in counts.keys() - set(placed):
        yield [name], f"{name} is no part of the machine"
    ready: set[str] = set()
    for unit in assembly.order:
        for step in unit.steps:
            for insertion in step.insertions:
                for part in insertion.units:
                    if part not in ready:
                        yield [], f"{unit.name}, {step.title}: {part} is not made yet"
        ready.add(unit.name)
    used = {supply for unit in assembly.order for step in unit.steps for supply in step.supplies}
    bought = {supply.number for supply in assembly.supplies}
    for number in sorted(bought - used):
        yield [number], f"{number} is used in no step"
    for number in sorted(used - bought):
        yield [number], f"{number} is used in a step and not bought"


def _met(insertion: Insertion, coming: list[str], present: list[str], ways: Ways, assembly: Assembly) -> str:
    """What keeps parts from coming in, as text."""
    if insertion.is_flexible:
        number = {o.name: o.part.number for o in assembly.occurrences}
        stiff = [name for name in coming if not number[name].startswith(_FLEXIBLE)]
        return f"{stiff[0]} is not flexible and has no way" if stiff else ""
    if not present or not coming:
        return ""
    frame = insertion.frame or coming[0]
    if not insertion.path or frame not in ways.frames:
        return f"{coming[0]} has no way"
    turn = ways.frames[frame][:3, :3]
    legs: list[Leg] = [(turn @ np.array(leg.along), leg.length_mm) for leg in insertion.path]
    met = ways.met(coming, present, legs)
    return "" if met is None else f"{met.moving} meets {met.other} {met.out_mm:.1f} mm before its seat"


def _alike(
    unit: Unit, made: dict[str, tuple[str, ...]], ways: Ways, known: set[str], assembly: Assembly
) -> tuple[object, ...]:
    """What equal units share: the same parts at the same places to each other, brought in alike."""
    numbers = {o.name: id(o.part) for o in assembly.occurrences}
    first = next((name for name in made[unit.name] if name in known), None)
    if first is None:
        return (unit.name,)
    base = np.linalg.inv(ways.frames[first])
    reported: list[object] = []
    for step in unit.steps:
        for insertion in step.insertions:
            names = [name for name in brought(insertion, made) if name in known]
            reported.append((tuple(numbers[name] for name in names), insertion.is_flexible, len(insertion.units)))
            for name in names:
                reported += np.round((base @ ways.frames[name])[:3] / _ALIKE_MM).astype(int).ravel().tolist()
            frame = insertion.frame or (names[0] if names else "")
            if frame in ways.frames:
                turn = (base @ ways.frames[frame])[:3, :3]
                for leg in insertion.path:
                    reported += [*np.round(turn @ np.array(leg.along), 6).tolist(), leg.length_mm]
        reported.append(len(step.tightened))
    return tuple(reported)


def _swings(
    step: Step, present: list[str], assembly: Assembly, limits: CheckLimits, meshes: Meshes
) -> list[tuple[float, str, str]]:
    """Swings of the keys in the screws of a step, rad, in what is there by then: at home, else where it suits most."""
    there = set(present)
    part = replace(assembly, occurrences=tuple(o for o in assembly.occurrences if o.name in there))
    at_home = Scene(part, meshes, assembly.home_mm[None, :])
    found = [(key_swing(ToolAccess(name, _DRAWN_MM, step.title), at_home), name, "") for name in step.tightened]
    if all(swing >= SWING_RAD for swing, *_ in found):
        return found
    moved = Scene(part, meshes, up_and_down(part.placement, limits))
    return [
        (swing if swing >= SWING_RAD else key_swing(ToolAccess(name, _DRAWN_MM, step.title), moved), name, "")
        for swing, name, _ in found
    ]


def _reported_faults(faults: list[tuple[list[str], str]], count: int, assembly: Assembly) -> CheckResult:
    steps = sum(len(unit.steps) for unit in assembly.order)
    detail = (
        f"{len(assembly.occurrences)} parts in {len(assembly.order)} units and {steps} steps, equal units gone through "
        f"once; {count} ways to a seat, by meshes as far as they are apart, by the exact solids where they meet"
    )
    if faults:
        detail = f"{len(faults)} faults: {'; '.join(text for _, text in faults[:_SHOWN])}; {detail}"
    names = tuple(dict.fromkeys(name for group, _ in faults[:_SHOWN] for name in group)) or None
    return CheckResult("assembly order", not faults, len(faults), 0, "", worst_pair=names, detail=detail)
