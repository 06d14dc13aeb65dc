"""Links by name: chains, rigid bodies, pinions as bodies of revolution, rods that rotate about their own axis.

The springs across a pair of rods are carried by none of them. What turns and leans about a spring's middle is taken
into its body (`sway_of`), a body of revolution about the shoulder's direction that holds it whatever the rods do. That
body is then translated with the middle, a point of the parallelogram, on a link of its own, `swaying_i_k`.
"""

from __future__ import annotations

from collections import defaultdict
from functools import cache

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.placement import CHAINS, SIDES, LinkPlacement, SpringSway, chain_stand, chain_turn, spring_sway
from delta_cad.solids.part import Occurrence

_LEAN_MAX_RAD = np.radians(60.0)  # of rods whose joints state no tilt: more than any cube asks


def rigid_link(occurrence: Occurrence, placement: LinkPlacement) -> str:
    """Names the body that carries an occurrence: the rotor of a direct drive on the shoulder axis is its arm."""
    on_axis = (placement.geometry.base_radius * MM_PER_M, 0.0)
    if occurrence.link.startswith("pinion") and placement.drive_ratio == 1.0 and placement.pinion_centre_mm == on_axis:
        return f"upper_arm_{occurrence.link[-1]}"
    return occurrence.link


def carried_by_link(assembly: Assembly) -> dict[str, list[Occurrence]]:
    """Gives the occurrences that every rigid body carries, by link name."""
    links: dict[str, list[Occurrence]] = defaultdict(list)
    for occurrence in assembly.occurrences:
        links[rigid_link(occurrence, assembly.placement)].append(occurrence)
    return links


def swept_links(placement: LinkPlacement) -> list[str]:
    """Lists the links that turn through any angle about their own y axis: the pinions of a geared drive."""
    return [f"pinion_{i}" for i in CHAINS] if placement.drive_ratio != 1.0 else []


@cache
def chain_of(link: str) -> int:
    """Gives the chain of a link, -1 for the base and the platform."""
    digits = [word for word in link.split("_") if word.isdigit()]
    return int(digits[0]) if digits else -1


def fixed_frame(link: str, placement: LinkPlacement) -> np.ndarray:
    """(4, 4) frame of the base, or of a geared pinion at angle 0 (its bodies are bodies of revolution)."""
    if link == "base":
        return np.eye(4)
    offset = np.eye(4)
    offset[[0, 2], 3] = placement.pinion_centre_mm
    return chain_stand(placement.geometry, chain_of(link)) @ offset


def free_tilt(assembly: Assembly) -> float:
    """Largest free tilt that the sockets of any rod leave it: how far it can turn about itself without lean.

    A rod that leans by `lean` can turn about itself until `cos(lean) cos(turn) = cos(tilt)`, where a lip meets a neck.

    Args:
        assembly: The machine.

    Returns:
        Tilt, rad; 0 where no ball joint holds a rod.
    """
    tilts: dict[str, float] = {}
    for joint in assembly.joints:
        for link in (joint.link_a, joint.link_b):
            if link.startswith("rod") and joint.tilt_limit_rad is not None:
                tilts[link] = min(joint.tilt_limit_rad, tilts.get(link, np.inf))
    return max(tilts.values(), default=0.0)


def free_turn(tilt_rad: float, lean_rad: np.ndarray) -> np.ndarray:
    """How far a rod can turn about itself either way before its sockets have no tilt left.

    Args:
        tilt_rad: Free tilt of the sockets.
        lean_rad: (...) lean of the rod.

    Returns:
        (...) largest turn, rad; 0 where the lean takes all of the tilt.
    """
    return np.arccos(np.clip(np.cos(tilt_rad) / np.cos(lean_rad), 0.0, 1.0))


def clearance_frames(placement: LinkPlacement, p_mm: np.ndarray) -> dict[str, np.ndarray]:
    """Computes the (n, 4, 4) frames in which bodies of all links are held apart, at handle positions (n, 3), mm.

    Those of the placement, but of geared pinions, which stand still, and besides those of what holds a swaying spring:
    its middle with its chain's axes.
    """
    links = dict(placement(p_mm))
    for name in swept_links(placement):
        links[name] = np.broadcast_to(fixed_frame(name, placement), (len(p_mm), 4, 4))
    for i in CHAINS:
        for k in SIDES:
            moved = np.broadcast_to(chain_turn(placement.geometry, i), (len(p_mm), 4, 4)).copy()
            moved[:, :3, 3] = links[f"spring_{i}_{k}"][:, :3, 3]
            links[f"swaying_{i}_{k}"] = moved
    return links


def sway_of(placement: LinkPlacement, tilt_rad: float) -> SpringSway:
    """Bounds how far the springs stray in the frames of `clearance_frames`, the rods' joints tilted by `tilt_rad`."""
    aside = max(abs(z) for _, z in placement.springs_mm)
    tilt = tilt_rad or _LEAN_MAX_RAD
    return spring_sway(placement.parallelogram_width_mm, placement.eye_inside_mm, aside, tilt)


def turn_about_x(angle_rad: np.ndarray) -> np.ndarray:
    """(..., 4, 4) rotations about x by angles (...)."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    out = np.zeros((*np.shape(angle_rad), 4, 4))
    out[..., 0, 0] = out[..., 3, 3] = 1.0
    out[..., 1, 1], out[..., 1, 2], out[..., 2, 1], out[..., 2, 2] = c, -s, s, c
    return out
