"""Every part that the design states is there, once, on its link and of its kind; nothing is there that it does not.

The same of what is bought beside the parts: cords, adhesives, grease.
"""

from __future__ import annotations

from collections import Counter
from fnmatch import fnmatchcase

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.report import CheckResult

SHOWN = 8  # faults that a report names; their number is told
ROUNDING = 1e-9  # of a rotation's products: a few turns one after the other are off by 1e-15, a part stretched so by nm


def check_presence(assembly: Assembly) -> CheckResult:
    """Holds the placed parts against what the design states of every joint and drive.

    Returns:
        `parts present`: the number of faults, each named in the detail: a part that is missing, too many, of another
        number, on another link, or stated nowhere; a name given twice; a number that two different parts bear, which
        the bill of materials could not tell apart; a part that its placement mirrors, stretches or puts nowhere;
        something bought beside the parts that is missing, doubled, too little, ordered as something else or stated
        nowhere.
    """
    faults: list[tuple[str, str]] = []
    unseen = {o.name: o for o in assembly.occurrences}
    counts = Counter(o.name for o in assembly.occurrences)
    faults += [(name, f"{name} is there {count} times") for name, count in counts.items() if count > 1]
    for row in assembly.stated:
        found = [o for name, o in unseen.items() if fnmatchcase(name, row.names)]
        if len(found) != row.count:
            what = f"{row.group} has {len(found)} of {row.count} {row.names}"
            faults += [(o.name, what) for o in found[:1]] or [(row.names, what)]
        for o in found:
            del unseen[o.name]
            if not fnmatchcase(o.part.number, row.number):
                faults.append((o.name, f"{o.name} of {row.group} is a {o.part.number}, stated is {row.number}"))
            if o.link != row.link:
                faults.append((o.name, f"{o.name} of {row.group} is on {o.link}, stated is {row.link}"))
    faults += [(name, f"{name} ({o.part.number}) is stated by no joint and no drive") for name, o in unseen.items()]
    faults += [(o.name, f"{o.name} is {how}") for o in assembly.occurrences if (how := _misplaced(o.placement))]
    first = {}
    for o in assembly.occurrences:
        if first.setdefault(o.part.number, o).part is not o.part:
            other = first[o.part.number].name
            faults.append((o.name, f"{o.name} and {other} are different parts of one number {o.part.number}"))
    faults += _supplied(assembly)
    total = sum(row.count for row in assembly.stated)
    detail = f"{total} parts stated by {len({row.group for row in assembly.stated})} joints, drives and groups"
    if faults:
        detail = f"{len(faults)} faults: {'; '.join(text for _, text in faults[:SHOWN])}; {detail}"
    names = tuple(dict.fromkeys(name for name, _ in faults[:SHOWN])) or None
    return CheckResult("parts present", not faults, len(faults), 0, "", worst_pair=names, detail=detail)


def _misplaced(frame: np.ndarray) -> str:
    """What a placement does to a part that no motion does; "" for a motion."""
    turn = frame[:3, :3]
    if not np.isfinite(frame).all() or (frame[3] != (0.0, 0.0, 0.0, 1.0)).any():
        return "placed nowhere"
    if np.abs(turn @ turn.T - np.eye(3)).max() > ROUNDING:
        return "stretched by its placement"
    return "" if np.linalg.det(turn) > 0.0 else "mirrored by its placement"


def _supplied(assembly: Assembly) -> list[tuple[str, str]]:
    """What is wrong with the list of what is bought beside the parts: number and text of each fault."""
    stated = {need.number for need in assembly.needs}
    faults = [
        (s.number, f"{s.number} is bought, but stated nowhere") for s in assembly.supplies if s.number not in stated
    ]
    for need in assembly.needs:
        found = [supply for supply in assembly.supplies if supply.number == need.number]
        if len(found) != 1:
            faults.append((need.number, f"{need.number} is bought in {len(found)} lines, stated is 1"))
        for supply in found:
            if supply.quantity != need.quantity:
                faults.append((need.number, f"{supply.quantity} {need.number} are bought, stated are {need.quantity}"))
            if not fnmatchcase(supply.order_code, need.order_code):
                faults.append((need.number, f"{need.number} is ordered as {supply.order_code}"))
    return faults
