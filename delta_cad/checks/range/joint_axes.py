"""Joint axes of the solids: cylindrical faces of a joint are centred on its declared frame, in both links."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.features import features, off_axis
from delta_cad.checks.links import rigid_link
from delta_cad.checks.range.joints import LEVER_MM, ORIGIN_MM
from delta_cad.checks.report import CheckResult
from delta_cad.solids.part import Joint, Occurrence


def check_joint_axes(assembly: Assembly) -> CheckResult:
    """Holds the seats of the solids against the frames of the joints, in the frames of the links.

    Each part that a contact fit names between the two links of a joint must have one cylinder (revolute) on the
    frame's y axis, or the centre of one spherical face (ball) in its origin. Where a link has no such part, one of any
    part that it carries must. The value is the largest distance, mm.
    """
    offsets = [
        (_nearest(o_set, joint, frame), joint, o_set)
        for joint in assembly.joints
        for frame, o_set in _seats(assembly, joint)
    ]
    name = "joint axes of the solids"
    if not offsets:
        return CheckResult(name, False, None, ORIGIN_MM, "mm", detail="the assembly declares no joint")
    off, joint, carriers = max(offsets, key=lambda f: f[0])
    names = tuple(o.name for o in carriers[:3])
    where = "cylinder on the axis" if joint.kind == "revolute" else "ball in the centre"
    detail = (
        f"distance of the solids' axes and ball centres from the joints' frames, angles over {LEVER_MM:g} mm; "
        f"largest of {len(offsets)} seats of {len(assembly.joints)} joints"
    )
    passed = off <= ORIGIN_MM
    if not passed:
        detail = f"{' and '.join(names) or 'a link without parts'} has no {where} of joint {joint.name}; " + detail
    value = off if np.isfinite(off) else None
    return CheckResult(name, passed, value, ORIGIN_MM, "mm", None, (joint.name, *names), detail)


def _seats(assembly: Assembly, joint: Joint) -> Iterator[tuple[np.ndarray, list[Occurrence]]]:
    """Lists the links of a joint, each with its frame and the parts in contact; without a contact, all its parts."""
    occurrences = {o.name: o for o in assembly.occurrences}
    links = (joint.link_a, joint.link_b)
    ends: dict[str, dict[str, Occurrence]] = {link: {} for link in links}
    for fit in assembly.fits:
        if fit.kind != "contact" or not fit.guides or fit.a not in occurrences or fit.b not in occurrences:
            continue
        pair = {rigid_link(o, assembly.placement): o for o in (occurrences[fit.a], occurrences[fit.b])}
        if set(pair) == set(links):
            for link, o in pair.items():
                ends[link][o.name] = o
    for link, frame in zip(links, (joint.frame_a, joint.frame_b), strict=True):
        if ends[link]:
            yield from ((frame, [o]) for o in ends[link].values())
        else:
            yield frame, [o for o in assembly.occurrences if o.link == link]


def _nearest(carriers: list[Occurrence], joint: Joint, frame: np.ndarray) -> float:
    """Smallest distance of any axis or ball centre of some parts of a link from a joint's frame, mm."""
    best = np.inf
    for o in carriers:
        offsets = features(o.part.solid)
        if joint.kind == "revolute":
            for cylinder in offsets.cylinders:
                best = min(best, off_axis(cylinder.moved(o.placement), frame, LEVER_MM))
        elif len(offsets.balls):
            centres = offsets.balls @ o.placement[:3, :3].T + o.placement[:3, 3]
            best = min(best, float(np.linalg.norm(centres - frame[:3, 3], axis=1).min()))
    return best
