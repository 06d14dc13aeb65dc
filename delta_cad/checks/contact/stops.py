"""End stops act where stated, free a degree before and in contact a degree beyond, and their pins are held."""

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
from delta_cad.structure.strength import PRESSED_N_mm2

_WITHIN_RAD = np.radians(1.0)  # of the stated angle: a third of the margin outside the cube
_SKIN_MM = 0.05  # around a pin, in which what holds it is measured
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


def check_stop_pressure(assembly: Assembly, torque_N_m: float) -> CheckResult:
    """Presses each stop pin against the wall that holds it by the largest torque at its joint.

    The pin is stiff beside the wall and the pressure linear along it: `F / (d h) (1 + 6 a / h)`, with h the length that
    is held, measured on the solids, and a from its middle to the pin's free end, where the force is taken to act.

    Args:
        assembly: The placed parts with their stops, whose pins are `a`.
        torque_N_m: At the joint, driven against its stop without a blow.

    Returns:
        `stop pressure`: largest pressure, N/mm^2; its limit is half the proof stress of EN AW-6082.
    """
    occurrences, joints = {o.name: o for o in assembly.occurrences}, {joint.name: joint for joint in assembly.joints}
    holders = {contact.a: contact.b for contact in assembly.contacts if contact.kind == "cylinder"}
    rows: list[tuple[float, str, str]] = []
    known: dict[Key, tuple[float, float]] = {}  # the pins of all chains are held alike
    for stop in assembly.stops:
        pin, holder = occurrences.get(stop.a), occurrences.get(holders.get(stop.a, ""))
        if pin is None or holder is None or stop.joint not in joints:
            rows.append((np.inf, stop.a, f"{stop.a} is held by nothing"))
            continue
        frame = np.linalg.inv(pin.placement) @ holder.placement
        key = relative_key(str(id(pin.part)), str(id(holder.part)), frame)
        if key not in known:
            known[key] = _held(pin, holder, frame)
        held, lever = known[key]
        if held <= 0.0:
            rows.append((np.inf, stop.a, f"{stop.a} is not held in {holder.name}"))
            continue
        at = np.linalg.inv(joints[stop.joint].frame_a) @ pin.placement[:, 3]
        force = 1000.0 * torque_N_m / float(np.hypot(at[0], at[2]))
        pressure = force / (_wide(pin) * held) * (1.0 + 6.0 * lever / held)
        rows.append((pressure, stop.a, f"{stop.a}, held over {held:.2f} mm, bears {force:.0f} N at its end"))
    if not rows:
        return CheckResult("stop pressure", False, None, PRESSED_N_mm2, "N/mm^2", detail="the assembly has no stop")
    worst, name, text = max(rows)
    value = worst if np.isfinite(worst) else None
    detail = f"{text}; half the proof stress of EN AW-6082 is allowed"
    passed = worst <= PRESSED_N_mm2
    return CheckResult("stop pressure", passed, value, PRESSED_N_mm2, "N/mm^2", worst_pair=(name,), detail=detail)


def _wide(pin: Occurrence) -> float:
    return float(pin.part.solid.BoundingBox(1e-3).xlen)


def _held(pin: Occurrence, holder: Occurrence, frame: np.ndarray) -> tuple[float, float]:
    """Length over which a part holds a pin, and the way from its middle to the pin's further end, mm.

    Measured by the part's volume in a skin around the pin: what is held on a part of its round counts by that part.
    """
    import cadquery as cq

    box = pin.part.solid.BoundingBox(1e-3)
    radius, long = box.xlen / 2.0, box.zlen
    outer = cq.Solid.makeCylinder(radius + _SKIN_MM, long, cq.Vector(0, 0, box.zmin))
    skin = outer.cut(cq.Solid.makeCylinder(radius, long, cq.Vector(0, 0, box.zmin)))
    common = skin.intersect(holder.part.solid.moved(cq.Location(location_of(frame))))
    size = common.Volume()
    if size <= NOISE_MM3:
        return 0.0, 0.0
    middle = cq.Shape.centerOfMass(common).z
    around = np.pi * ((radius + _SKIN_MM) ** 2 - radius**2)
    return size / around, max(box.zmax - middle, middle - box.zmin)


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
    """Length along y of the common volume of two parts in a joint's frame, mm, from `_meeting`."""
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
