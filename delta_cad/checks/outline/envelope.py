"""Outline of all moving bodies over the cube, along x and y of the base frame.

Upper bounds, body by body:
    base: the mesh.
    geared pinion: the body of revolution about its axis.
    upper arm: each vertex runs on a circle, `R_i + a cos(theta) - c sin(theta)` outwards; its extremes over its chain's
        enclosed range of theta are in closed form.
    platform: the mesh, moved over the cube.
    rod: branch and bound over boxes of handle positions, at every turn about itself that its sockets leave it, see
        `rod_reach`.
    spring across a pair of rods: the same of its middle, and what its body holds about that, see `sway_of`.
Each gets the mesh's deviation on top. The same extents over the sampled positions show how much this adds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.clearance.bodies import CollisionBody, bodies_of
from delta_cad.checks.clearance.joint_ranges import FoldError, joint_ranges
from delta_cad.checks.clearance.motion import box_motion, cube_boxes
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import (
    chain_of,
    clearance_frames,
    fixed_frame,
    free_tilt,
    free_turn,
    rigid_link,
    sway_of,
    swept_links,
)
from delta_cad.checks.outline.enclosed_maximum import enclosed_maximum
from delta_cad.checks.outline.rod_reach import RodReach, SpringReach, turned_reach
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.placement import LinkPlacement

_THETA_BOXES = 7  # boxes along an edge of the cube at first, for the shoulder angles
_THETA_GAP_RAD = 1e-4  # 0.01 mm at the elbow
_FLOOR_BODIES = 8  # bodies whose sampled reach sets the floor below which no rod is refined
DIRECTIONS = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True)
class _SweptOutline:
    """Bounds of the swept outline along +x, -x, +y, -y.

    Attributes:
        reach_mm: (4,) farthest point along each direction, mm.
        bodies: The body that decides each.
    """

    reach_mm: np.ndarray
    bodies: tuple[CollisionBody, ...]

    @property
    def size_mm(self) -> np.ndarray:
        """(2,) extents along x and y, mm."""
        return self.reach_mm[0::2] + self.reach_mm[1::2]


def check_envelope(
    assembly: Assembly, limits: CheckLimits, meshes: Meshes
) -> tuple[list[CheckResult], np.ndarray | None]:
    """Holds the swept outline against the rectangle W x D, either way round.

    Returns:
        results: `envelope width` and `envelope depth`, for the orientation that fits (or misses by less).
        reach_mm: (4,) bound on the outline along +x, -x, +y, -y; None where a chain may fold, so that it has none.
    """
    allowed = np.array([limits.envelope_width_mm, limits.envelope_depth_mm])
    try:
        outline = swept_outline(assembly, limits, meshes)
    except FoldError as error:
        refused = [
            CheckResult(f"envelope {name}", False, None, limit, "mm", detail=str(error))
            for name, limit in zip(("width", "depth"), allowed.tolist(), strict=True)
        ]
        return refused, None
    sampler = _Sampled(assembly, limits.poses_mm())
    sampled, poses = zip(*(sampler.reach(b, d) for d, b in enumerate(outline.bodies)), strict=True)
    size = outline.size_mm
    excess = [(size - allowed).max(), (size[::-1] - allowed).max()]
    along_x = bool(excess[0] <= excess[1])
    results = []
    for name, axis, limit in zip(("width", "depth"), (0, 1) if along_x else (1, 0), allowed.tolist(), strict=True):
        low, high = 2 * axis + 1, 2 * axis
        a, b = outline.bodies[low], outline.bodies[high]
        pose = limits.poses_mm()[poses[high]]
        misses = max(excess)
        turned = f"turned by 90 degrees it misses by {misses:.2f} mm" if misses > 0.0 else "it fits both ways round"
        detail = (
            f"along {'xy'[axis]} from {-outline.reach_mm[low]:.2f} ({a.name}) to {outline.reach_mm[high]:.2f} mm "
            f"({b.name}), a bound {size[axis] - sampled[low] - sampled[high]:.2f} mm larger than at the sampled "
            f"positions; W lies along {'x' if along_x else 'y'}, {turned}"
        )
        value = float(size[axis])
        x, y, z = pose.tolist()
        results.append(
            CheckResult(f"envelope {name}", value <= limit, value, limit, "mm", (x, y, z), (a.name, b.name), detail)
        )
    return results, outline.reach_mm


def swept_outline(assembly: Assembly, limits: CheckLimits, meshes: Meshes) -> _SweptOutline:
    """Encloses the outline that the machine sweeps over the cube.

    Raises:
        FoldError: A chain may fold in the cube.
    """
    placement = assembly.placement
    moved = [replace(o, link=rigid_link(o, placement)) for o in assembly.occurrences]
    tilt = free_tilt(assembly)
    bodies = list(bodies_of(moved, meshes, swept_links(placement), sway_of(placement, tilt)).values())
    theta = shoulder_range(placement.geometry, limits)
    swinging = {
        "rod": RodReach(placement, limits, theta, tilt),
        "swaying": SpringReach(placement, limits, theta),
    }
    searched = [swinging.get(b.link.split("_")[0]) for b in bodies]
    reach = np.stack([_reach(b, placement, limits, theta, one) for b, one in zip(bodies, searched, strict=True)])
    sampler = _Sampled(assembly, limits.poses_mm())
    for d in range(len(DIRECTIONS)):
        floor = max(sampler.reach(bodies[k], d)[0] for k in np.argsort(reach[:, d])[-_FLOOR_BODIES:])
        for k in np.flatnonzero(reach[:, d] > floor):
            if (one := searched[k]) is not None:
                reach[k, d] = one.coarse(bodies[k], DIRECTIONS[d])
        for k in np.argsort(-reach[:, d]):
            if reach[k, d] > floor and (one := searched[k]) is not None:
                reach[k, d], floor = one.refined(bodies[k], DIRECTIONS[d], floor)
    reach += np.array([b.mesh.deviation_mm for b in bodies])[:, None]
    decides = reach.argmax(axis=0)
    return _SweptOutline(reach.max(axis=0), tuple(bodies[k] for k in decides))


def _reach(
    b: CollisionBody,
    placement: LinkPlacement,
    limits: CheckLimits,
    theta: np.ndarray,
    searched: RodReach | SpringReach | None,
) -> np.ndarray:
    """(4,) bound on a mesh's reach along the directions, mm."""
    if searched is not None:
        return np.array([searched.roughest(b, d) for d in DIRECTIONS])
    if b.link == "base" or b.link in swept_links(placement):
        frame = fixed_frame(b.link, placement)
        return (DIRECTIONS @ (frame[:3, :3] @ b.vertices.T + frame[:3, 3:])).max(axis=1)
    if b.link == "platform":
        return (DIRECTIONS @ (b.vertices + limits.centre_mm).T).max(axis=1) + limits.half_side_mm
    i, g = chain_of(b.link), placement.geometry
    on_axis = g.base_radius * MM_PER_M if b.link.startswith("upper_arm") else placement.pinion_centre_mm[0]
    radius = on_axis + (g.base_radii[i] - g.base_radius) * MM_PER_M
    least, most = radial_range(b.vertices, radius, theta[i])
    across = (DIRECTIONS @ g.tangential[i])[:, None] * b.vertices[:, 1]
    outwards = (DIRECTIONS @ g.radial[i])[:, None]
    return (np.maximum(outwards * least, outwards * most) + across).max(axis=1)


def shoulder_range(g: DeltaGeometry, limits: CheckLimits) -> np.ndarray:
    """Encloses the shoulder angles over the cube closely, (3, 2) lowest and highest of each chain, rad.

    Raises:
        FoldError: A chain may fold in the cube.
    """
    widest = joint_ranges(g, limits.centre_mm, limits.half_side_mm).theta
    boxes = cube_boxes(limits.centre_mm, limits.half_side_mm, _THETA_BOXES)
    theta = np.empty_like(widest)
    for i, end in product(range(len(theta)), range(2)):
        sign = (-1.0, 1.0)[end]

        def bounds(
            centres: np.ndarray, halves: np.ndarray, i: int = i, sign: float = sign
        ) -> tuple[np.ndarray, np.ndarray]:
            motion = box_motion(g, centres, halves)
            at_centre = sign * motion.theta[:, i]
            return at_centre + motion.theta_change[:, i], at_centre

        theta[i, end] = sign * min(enclosed_maximum(bounds, *boxes, _THETA_GAP_RAD)[0], sign * widest[i, end])
    return theta


def radial_range(points: np.ndarray, radius_mm: float, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Computes the range of the radial distance of points that turn about a tangential axis of their chain.

    Args:
        points: (n, 3) points in the turning link's frame, mm.
        radius_mm: Radial position of the axis, mm.
        theta: (2,) lowest and highest angle, rad.

    Returns:
        least, most: each (n,), mm.
    """
    amplitude, phase = np.hypot(points[:, 0], points[:, 2]), np.arctan2(points[:, 2], points[:, 0])
    ends = amplitude[:, None] * np.cos(phase[:, None] + theta)
    start, width = np.mod(phase + theta[0], 2.0 * np.pi), theta[1] - theta[0]
    top = (start + width >= 2.0 * np.pi) | (start == 0.0)
    bottom = np.mod(np.pi - start, 2.0 * np.pi) <= width
    least = np.where(bottom, -amplitude, ends.min(axis=1))
    most = np.where(top, amplitude, ends.max(axis=1))
    return radius_mm + least, radius_mm + most


class _Sampled:
    """Reach of bodies over sampled positions, from below; rods as far turned about themselves as they can be."""

    def __init__(self, assembly: Assembly, poses: np.ndarray) -> None:
        placement = assembly.placement
        self._links, self._tilt = clearance_frames(placement, poses), free_tilt(assembly)
        self._across = placement.geometry.tangential

    def reach(self, b: CollisionBody, direction: int) -> tuple[float, int]:
        """Reach of the body's mesh, mm, and the index of the position."""
        frame, d = self._links[b.link], DIRECTIONS[direction]
        axes, turn = d @ frame[:, :3, :3], np.zeros(len(frame))
        if b.link.startswith("rod"):
            lean = np.arccos(np.clip(frame[:, :3, 1] @ self._across[chain_of(b.link)], -1.0, 1.0))
            turn = free_turn(self._tilt, lean)
        along = turned_reach(axes, b.hull, turn[:, None]).max(axis=1) + frame[:, :3, 3] @ d
        return float(along.max()), int(along.argmax())
