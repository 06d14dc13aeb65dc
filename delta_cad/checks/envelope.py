"""Outline that all bodies sweep over the cube, along the base frame's x and y.

Upper bounds, body by body:
    base: the mesh.
    geared pinion: the body of revolution about its axis.
    upper arm: each vertex runs on a circle, `R + a cos(theta) - c sin(theta)` outwards; its extremes over the enclosed
        range of theta are in closed form.
    platform: the mesh, moved by the cube's half side.
    rod: the cube is cut into boxes, those that decide ever finer. In each, elbow and wrist are enclosed (closed form in
        theta, exact in p). A point is `(1 - f) elbow + f wrist + h` with h square to the rod's direction a, and h
        reaches `|h| sqrt(1 - (a . d)^2)` along a direction d.
Each gets the mesh's deviation on top. What this adds is told by the same extents over the sampled positions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from delta_cad.assembly import Assembly
from delta_cad.checks.bodies import Body, bodies_of
from delta_cad.checks.domains import FoldError, domains
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import chain_of, fixed_frame, rigid_link, swept_links
from delta_cad.checks.motion import MM_PER_M, BoxMotion, box_motion, cube_boxes
from delta_cad.checks.report import CheckResult
from delta_cad.mechanism.geometry import RADIAL, TANGENTIAL
from delta_cad.placement import LinkPlacement
from delta_cad.tessellation import MeshLibrary

BOXES = 14  # boxes along an edge of the cube for the rods, 5 mm at first
REFINEMENTS = 6  # times that the boxes which decide are halved, to 0.1 mm
REFINED_MM = 0.02  # what the refinement may leave above the sampled outline; less than a mesh's deviation
FLOOR_BODIES = 8  # bodies whose sampled reach sets the floor of the refinement along a direction
SHARES = 24  # rod vertices are grouped by their share of the way from elbow to wrist
SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))
DIRECTIONS = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True)
class Outline:
    """Bounds of the swept outline along +x, -x, +y, -y.

    Attributes:
        reach_mm: (4,) farthest point along each direction, mm.
        bodies: The body that decides each.
    """

    reach_mm: np.ndarray
    bodies: tuple[Body, ...]

    @property
    def size_mm(self) -> np.ndarray:
        """(2,) extents along x and y, mm."""
        return self.reach_mm[0::2] + self.reach_mm[1::2]


def check_envelope(assembly: Assembly, limits: CheckLimits, meshes: MeshLibrary) -> list[CheckResult]:
    """Hold the swept outline against the rectangle W x D, either way round.

    Args:
        assembly: The machine.
        limits: The cube and the rectangle.
        meshes: The parts' meshes.

    Returns:
        `envelope width` and `envelope depth`, for the orientation that fits (or misses by less).
    """
    wanted = np.array([limits.envelope_width_mm, limits.envelope_depth_mm])
    try:
        outline = swept_outline(assembly, limits, meshes)
    except FoldError as error:
        return [
            CheckResult(f"envelope {name}", False, None, limit, "mm", detail=str(error))
            for name, limit in zip(("width", "depth"), wanted.tolist(), strict=True)
        ]
    sampler = _Sampled(assembly.placement, limits.poses_mm())
    sampled, poses = zip(*(sampler.reach(b, d) for d, b in enumerate(outline.bodies)), strict=True)
    size = outline.size_mm
    excess = [(size - wanted).max(), (size[::-1] - wanted).max()]
    along_x = bool(excess[0] <= excess[1])
    results = []
    for name, axis, limit in zip(("width", "depth"), (0, 1) if along_x else (1, 0), wanted.tolist(), strict=True):
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
    return results


def swept_outline(assembly: Assembly, limits: CheckLimits, meshes: MeshLibrary) -> Outline:
    """Rigorous bounds on the outline.

    Args:
        assembly: The machine.
        limits: The cube.
        meshes: The parts' meshes.

    Returns:
        The outline.

    Raises:
        FoldError: A chain may fold in the cube.
    """
    placement = assembly.placement
    moved = [replace(o, link=rigid_link(o, placement)) for o in assembly.occurrences]
    bodies = list(bodies_of(moved, meshes, swept_links(placement)).values())
    theta = domains(placement.geometry, limits.centre_mm, limits.half_side_mm).theta
    rods = _Rods(placement, limits)
    reach = np.stack([_reach(b, placement, limits, theta, rods) for b in bodies])
    sampler = _Sampled(placement, limits.poses_mm())
    for d in range(len(DIRECTIONS)):
        floor = max(sampler.reach(bodies[k], d)[0] for k in np.argsort(reach[:, d])[-FLOOR_BODIES:])
        for k in np.flatnonzero(reach[:, d] > floor):
            if bodies[k].link.startswith("rod"):
                reach[k, d] = rods.refined(bodies[k], d, floor)
    reach += np.array([b.mesh.deviation_mm for b in bodies])[:, None]
    decides = reach.argmax(axis=0)
    return Outline(reach.max(axis=0), tuple(bodies[k] for k in decides))


def _reach(b: Body, placement: LinkPlacement, limits: CheckLimits, theta: np.ndarray, rods: _Rods) -> np.ndarray:
    """(4,) bound on a mesh's reach along the directions, mm."""
    if b.link.startswith("rod"):
        return rods.reach(b)
    if b.link == "base" or b.link in swept_links(placement):
        frame = fixed_frame(b.link, placement)
        return (DIRECTIONS @ (frame[:3, :3] @ b.vertices.T + frame[:3, 3:])).max(axis=1)
    if b.link == "platform":
        return (DIRECTIONS @ (b.vertices + limits.centre_mm).T).max(axis=1) + limits.half_side_mm
    i = chain_of(b.link)
    on_axis = placement.geometry.base_radius * MM_PER_M
    radius = on_axis if b.link.startswith("upper_arm") else placement.pinion_centre_mm[0]
    least, most = radial_range(b.vertices, radius, theta[i])
    across = (DIRECTIONS @ TANGENTIAL[i])[:, None] * b.vertices[:, 1]
    outwards = (DIRECTIONS @ RADIAL[i])[:, None]
    return (np.maximum(outwards * least, outwards * most) + across).max(axis=1)


def radial_range(points: np.ndarray, radius_mm: float, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest distance along the chain's radial direction while points turn about a tangential axis.

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


class _Rods:
    """Bounds on the reach of the rods over boxes of handle positions."""

    def __init__(self, placement: LinkPlacement, limits: CheckLimits) -> None:
        self._placement, self._geometry = placement, placement.geometry
        self._forearm = self._geometry.forearm_length * MM_PER_M
        self._cube = cube_boxes(limits.centre_mm, limits.half_side_mm, BOXES)
        self._motion = box_motion(self._geometry, *self._cube)

    def reach(self, b: Body) -> np.ndarray:
        """(4,) bound on the reach of a rod's body, mm."""
        return np.array([self._bound(b, d, *self._cube, self._motion).max() for d in range(len(DIRECTIONS))])

    def refined(self, b: Body, direction: int, floor_mm: float) -> float:
        """Closer bound along one direction, not below `floor_mm`, by cutting the boxes that decide, mm."""
        centres, halves = self._cube
        bound = self._bound(b, direction, centres, halves, self._motion)
        for _ in range(REFINEMENTS):
            keep = bound > floor_mm + REFINED_MM
            if not keep.any() or keep.sum() > BOXES**3:
                break
            halves = np.repeat(halves[keep] / 2.0, 8, axis=0)
            centres = np.repeat(centres[keep], 8, axis=0) + halves * np.tile(SIGNS, (int(keep.sum()), 1))
            bound = self._bound(b, direction, centres, halves, box_motion(self._geometry, centres, halves))
        return max(float(bound.max()), floor_mm + REFINED_MM)

    def _bound(self, b: Body, direction: int, centres: np.ndarray, halves: np.ndarray, motion: BoxMotion) -> np.ndarray:
        """(n,) bound on the reach of a rod's body along one direction in each box, mm."""
        i, j = (int(word) for word in b.link.split("_")[1:])
        d, g = DIRECTIONS[direction], self._geometry
        low, high = motion.theta[:, i] - motion.theta_change[:, i], motion.theta[:, i] + motion.theta_change[:, i]
        least, most = cosine_range(low, high)
        outwards, arm = float(d @ RADIAL[i]), g.upper_arm_length * MM_PER_M
        elbow = np.sort(outwards * (g.base_radius * MM_PER_M + arm * np.stack([least, most])), axis=0)
        middle, spread = centres @ d + outwards * g.platform_radius * MM_PER_M, halves @ np.abs(d)
        wrist = np.stack([middle - spread, middle + spread])
        first, last = wrist[0] - elbow[1], wrist[1] - elbow[0]
        along = np.where(first * last <= 0.0, 0.0, np.minimum(np.abs(first), np.abs(last))) / self._forearm
        across = np.sqrt(np.maximum(1.0 - along**2, 0.0))
        points = b.vertices
        share, off = points[:, 0] / self._forearm, np.hypot(points[:, 1], points[:, 2])
        edges = np.linspace(share.min(), share.max(), SHARES + 1)
        group = np.clip(np.searchsorted(edges, share, side="right") - 1, 0, SHARES - 1)
        best = np.full(len(centres), -np.inf)
        for k in np.unique(group):
            radius = off[group == k].max()
            for f in (edges[k], edges[k + 1]):
                here = (1.0 - f) * elbow[1 if f <= 1.0 else 0] + f * wrist[1 if f >= 0.0 else 0]
                best = np.maximum(best, here + radius * across)
        return best + (j - 0.5) * self._placement.parallelogram_width_mm * float(d @ TANGENTIAL[i])


def cosine_range(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest cosine over ranges of angles within (-2 pi, 2 pi), each (n,)."""
    ends = np.stack([np.cos(low), np.cos(high)])
    most = np.where((low <= 0.0) & (high >= 0.0), 1.0, ends.max(axis=0))
    over = (low <= -np.pi) & (high >= -np.pi) | (low <= np.pi) & (high >= np.pi)
    return np.where(over, -1.0, ends.min(axis=0)), most


class _Sampled:
    """Reach of bodies over sampled positions, from below."""

    def __init__(self, placement: LinkPlacement, poses: np.ndarray) -> None:
        self._links = dict(placement(poses))
        for name in swept_links(placement):
            self._links[name] = np.broadcast_to(fixed_frame(name, placement), (len(poses), 4, 4))

    def reach(self, b: Body, direction: int) -> tuple[float, int]:
        """Reach of the body's mesh, mm, and the index of the position."""
        frame, d = self._links[b.link], DIRECTIONS[direction]
        along = ((d @ frame[:, :3, :3]) @ b.hull.T).max(axis=1) + frame[:, :3, 3] @ d
        return float(along.max()), int(along.argmax())
