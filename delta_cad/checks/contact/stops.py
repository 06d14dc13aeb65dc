"""Stops end the travel where they are stated: a degree before they are free, a degree beyond they meet, deep enough."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.placing import Key, relative_key
from delta_cad.checks.contact.shared_volume import NOISE_MM3, common_size, volume
from delta_cad.checks.report import CheckResult
from delta_cad.mechanism.placement import frames
from delta_cad.solids.part import Occurrence, Stop, location_of

_WITHIN_RAD = np.radians(1.0)  # of the stated angle: a third of the margin outside the cube
Y = np.array([0.0, 1.0, 0.0])


def check_stops(assembly: Assembly) -> CheckResult:
    """Turns every stopped joint to a degree before and a degree beyond each of its stops.

    Returns:
        `stops met`: least length over which a stop's parts meet along the axis, mm, as a share of what is asked.
    """
    occurrences = {o.name: o for o in assembly.occurrences}
    shares: list[tuple[float, Stop, str]] = []
    known: dict[tuple[Key, Key], float] = {}  # the stops of all chains are equal
    for stop in assembly.stops:
        missing = [name for name in (stop.a, stop.b) if name not in occurrences]
        missing += [] if stop.joint in {joint.name for joint in assembly.joints} else [f"joint {stop.joint}"]
        where = f"{stop.a} / {stop.b} at {np.degrees(stop.angle_rad):.2f} deg"
        if missing:
            shares.append((0.0, stop, f"{where}: {' and '.join(missing)} is missing"))
            continue
        pair = occurrences[stop.a], occurrences[stop.b]
        if _meeting(assembly, stop, *pair, -_WITHIN_RAD, known) != 0.0:
            shares.append((0.0, stop, f"{where} meet more than a degree before"))
            continue
        length = _meeting(assembly, stop, *pair, _WITHIN_RAD, known)
        text = f"{where} meet over {length:.2f} mm, {stop.least_mm:.2f} mm required"
        shares.append((length / stop.least_mm, stop, text))
    if not shares:
        return CheckResult("stops met", False, None, 1.0, "", detail="the assembly declares no stop")
    shares.sort(key=lambda share: share[0])
    worst, stop, text = shares[0]
    bad = [text for share, _, text in shares if share < 1.0]
    detail = f"{len(bad)} of {len(shares)} stops fail: {'; '.join(bad)}" if bad else f"least of {len(shares)}: {text}"
    return CheckResult("stops met", not bad, worst, 1.0, "", worst_pair=(stop.a, stop.b), detail=detail)


def _meeting(
    assembly: Assembly,
    stop: Stop,
    a: Occurrence,
    b: Occurrence,
    beyond_rad: float,
    known: dict[tuple[Key, Key], float],
) -> float:
    """Length along the joint's axis of what two parts share at an angle beyond their stop, mm; 0 where they are free.

    The kernel's contradictions count as free beyond the stop, and as met before it.
    """
    (joint,) = [j for j in assembly.joints if j.name == stop.joint]
    angle = stop.angle_rad + stop.sense * beyond_rad
    turned = frames(np.array([np.cos(angle), 0.0, np.sin(angle)]), Y, np.zeros(3))
    in_joint = (np.linalg.inv(joint.frame_a) @ a.placement, turned @ np.linalg.inv(joint.frame_b) @ b.placement)
    one, other = (
        relative_key(str(id(o.part)), str(beyond_rad > 0.0), frame) for o, frame in zip((a, b), in_joint, strict=True)
    )
    if (one, other) not in known:
        known[one, other] = _shared_length((a, b), in_joint, beyond_rad > 0.0)
    return known[one, other]


def _shared_length(
    pair: tuple[Occurrence, Occurrence], in_joint: tuple[np.ndarray, np.ndarray], is_beyond: bool
) -> float:
    """Length along y of what two parts share in a joint's frame, mm, as `_meeting` tells it."""
    shapes = [o.part.solid.wrapped.Moved(location_of(frame)) for o, frame in zip(pair, in_joint, strict=True)]
    common = common_size((shapes[0], shapes[1]), (volume(shapes[0]), volume(shapes[1])), volume, NOISE_MM3)
    if common is None:
        return 0.0 if is_beyond else np.inf
    return _along_y(shapes[0], shapes[1]) if common > NOISE_MM3 else 0.0


def _along_y(a: Any, b: Any) -> float:
    """Length along y of what two of the kernel's shapes share, mm."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(BRepAlgoAPI_Common(a, b).Shape(), box, False, False)
    return float(box.CornerMax().Y() - box.CornerMin().Y())
