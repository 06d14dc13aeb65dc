"""The relative positions at which contacts across links are tested for common volume.

A contact in a revolute joint is tested over its whole range of turn, at once where a body that one of the parts cannot
leave while it turns shows that it may, see `order.swept`; where one of the two parts is a body of revolution about the
joint's axis a turn changes nothing, and one position stands for all. A ball is tested where it is turned and
tilted most of all sampled handle positions, to either side.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.clearance.joint_ranges import FoldError, joint_ranges
from delta_cad.checks.contact.features import is_turned
from delta_cad.checks.contact.placing import Key, relative_key
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import rigid_link, swept_links
from delta_cad.solids.part import Fit, Joint, Occurrence

TURNS = 36  # positions over a whole turn or over the range of a shoulder: every 10 or every 3 degrees


@dataclass(frozen=True, eq=False)
class Turning:
    """A joint about the y axis of a frame in both of its parts.

    Attributes:
        in_a: (4, 4) the frame in part a, mm.
        in_b: (4, 4) the frame in part b, mm.
        range_rad: By how much b is turned in a, from the least to the most; None: by any angle.
    """

    in_a: np.ndarray
    in_b: np.ndarray
    range_rad: tuple[float, float] | None


@dataclass(frozen=True, eq=False)
class _ContactPosition:
    """One position of a contact.

    Attributes:
        fit: The contact.
        b_in_a: (4, 4) frame of part b in the frame of part a, mm.
        pose_mm: Handle position; None where only the joint is turned.
        turning: The joint, where this is one of the positions into which it turns.
    """

    fit: Fit
    b_in_a: np.ndarray
    pose_mm: tuple[float, float, float] | None
    turning: Turning | None = None


def contact_positions(assembly: Assembly, limits: CheckLimits) -> list[_ContactPosition]:
    """Gives the positions at which contacts across links are tested; one of equal contacts stands for all."""
    poses = np.concatenate([limits.centre_mm[None], limits.poses_mm()])
    links = assembly.placement(poses)
    occurrences = {o.name: o for o in assembly.occurrences}
    joints = {frozenset((j.link_a, j.link_b)): j for j in assembly.joints}
    groups: dict[Key, list[tuple[Fit, np.ndarray, Joint | None]]] = defaultdict(list)
    for fit in assembly.fits:
        a, b = occurrences[fit.a], occurrences[fit.b]
        on = frozenset((rigid_link(a, assembly.placement), rigid_link(b, assembly.placement)))
        if fit.kind != "contact" or len(on) == 1:
            continue
        relative = np.linalg.inv(a.placement) @ _inverse(links[a.link]) @ links[b.link] @ b.placement
        key = (fit.overlap_mm3, *relative_key(a.part.number, b.part.number, relative[0]))
        groups[key].append((fit, relative, joints.get(on)))
    range_rad = _shoulder_range(assembly, limits)
    positions = []
    for group in groups.values():
        fit, relative, joint = group[0]
        if joint is not None and joint.kind == "revolute":
            turned, turning = _turned(occurrences[fit.a], occurrences[fit.b], joint, assembly, links, range_rad)
            positions += [_ContactPosition(fit, b_in_a, None, turning) for b_in_a in turned]
        else:
            positions += _extremes([(fit, relative) for fit, relative, _ in group], poses)
    return positions


def _shoulder_range(assembly: Assembly, limits: CheckLimits) -> tuple[float, float]:
    """Lowest and highest shoulder angle over the cube, enclosed, rad; any angle where the enclosure fails."""
    try:
        theta = joint_ranges(assembly.placement.geometry, limits.centre_mm, limits.half_side_mm).theta
    except FoldError:
        return -np.pi, np.pi
    return float(theta[:, 0].min()), float(theta[:, 1].max())


def _turned(
    a: Occurrence,
    b: Occurrence,
    joint: Joint,
    assembly: Assembly,
    links: Mapping[str, np.ndarray],
    range_rad: tuple[float, float],
) -> tuple[list[np.ndarray], Turning | None]:
    """Positions of part b in part a over the range of a revolute joint, and the joint, where a turn changes anything.

    The frames of the joint say how part b stands at angle 0; a shoulder's angle turns it about -y.
    """
    if rigid_link(a, assembly.placement) == joint.link_a:
        frame_a, frame_b = joint.frame_a, joint.frame_b
    else:
        frame_a, frame_b = joint.frame_b, joint.frame_a
    # an occurrence on the rotor of a direct drive stands on its arm as at every position
    in_a, in_b = (
        np.linalg.inv(links[o.link][0] @ o.placement) @ links[rigid_link(o, assembly.placement)][0] @ frame
        for o, frame in ((a, frame_a), (b, frame_b))
    )
    if is_turned(a.part, in_a) or is_turned(b.part, in_b):
        return [in_a @ np.linalg.inv(in_b)], None
    if any(link in swept_links(assembly.placement) for link in (joint.link_a, joint.link_b)):
        angles, turned = np.linspace(0.0, 2.0 * np.pi, TURNS, endpoint=False), None
    else:
        sense = -1.0 if rigid_link(a, assembly.placement) == joint.link_a else 1.0
        angles = sense * np.linspace(*range_rad, TURNS)
        turned = (float(angles.min()), float(angles.max()))
    frames = [in_a @ _about_y(angle) @ np.linalg.inv(in_b) for angle in angles.tolist()]
    return frames, Turning(in_a, in_b, turned)


def _extremes(group: list[tuple[Fit, np.ndarray]], poses: np.ndarray) -> list[_ContactPosition]:
    """The centre, and where equal contacts are turned most and tilted most, along either direction."""
    relative = np.stack([r for _, r in group])
    turn = np.einsum("kij,knij->kn", relative[:, 0, :3, :3], relative[..., :3, :3])
    axis = relative[..., :3, 1]  # of part b, seen from part a
    tilt = np.einsum("ki,kni->kn", axis[:, 0], axis)
    aside = np.einsum("ki,kni->kn", relative[:, 0, :3, 0], axis)
    picked = {0, *(int(v.argmin()) for v in (turn, tilt, aside)), int(aside.argmax())}
    positions = []
    for k in sorted(picked):
        member, pose = divmod(k, len(poses))
        x, y, z = poses[pose].tolist()
        positions.append(_ContactPosition(group[member][0], relative[member, pose], (x, y, z)))
    return positions


def _inverse(frame: np.ndarray) -> np.ndarray:
    """(..., 4, 4) inverse of rigid transforms."""
    out = np.zeros_like(frame)
    turn = np.swapaxes(frame[..., :3, :3], -1, -2)
    out[..., :3, :3], out[..., :3, 3] = turn, -(turn @ frame[..., :3, 3:])[..., 0]
    out[..., 3, 3] = 1.0
    return out


def _about_y(angle_rad: float) -> np.ndarray:
    """(4, 4) rotation about y."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, 0.0, s, 0.0], [0.0, 1.0, 0.0, 0.0], [-s, 0.0, c, 0.0], [0.0, 0.0, 0.0, 1.0]])
