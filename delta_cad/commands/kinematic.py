"""Figures of anybody's delta, of which lengths alone are known: workspace, cube, conditioning, angles."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import degrees, hypot, pi
from typing import NamedTuple

import numpy as np

from delta_cad.commands.inspection import OUTLINE, InspectionRow, dimension_rows, limit_rows, other_rows, reach_rows
from delta_cad.common.units import MM_PER_M
from delta_cad.design import DesignError
from delta_cad.design.lengths import FREE_TORQUE_N_M, Lengths
from delta_cad.mechanism import kernel
from delta_cad.mechanism.errors import UnreachableError
from delta_cad.mechanism.geometry import VERTICAL, DeltaGeometry, chain_coordinates
from delta_cad.mechanism.inverse import forearm_determinant
from delta_cad.mechanism.limits import POSE_LIMITS
from delta_cad.mechanism.workspace import CubeSearch, cube_extremes

_GRID = 61  # points along an edge of the box in which the workspace is sampled
_DIRECTIONS, _RADII, _HALVINGS = 72, 200, 30  # of the circle that is reached all round
_COUNT = 41  # points along an edge of the cube at which reach is looked at
_OVER = "over the cube (sampled and polished)"
_CONVENTIONS = (
    ("z axis", "from the base to the platform, 0 in the plane of the shoulder axes"),
    ("x axis", "through chain 0; chains 1 and 2 follow anticlockwise about z"),
    ("angles", "0 is a level upper arm, positive towards the platform"),
)


class _Pose(NamedTuple):
    """Angles and bars at positions; NaN where a chain cannot be closed.

    Attributes:
        theta: (..., 3 chains) rad.
        bars: (..., 3 chains, 3) from the elbow's end of the bars to the wrist's, m.
        lever: (..., 3 chains) component of a bar along the elbow's direction of motion times L_A, m^2.
        elbow: (..., 3 chains) angle between upper arm and the line from elbow to wrist, 0 stretched, rad.
        lean: (..., 3 chains) of the bars out of their chain's plane, rad.
    """

    theta: np.ndarray
    bars: np.ndarray
    lever: np.ndarray
    elbow: np.ndarray
    lean: np.ndarray


@dataclass(frozen=True)
class CollaredDelta:
    """A delta whose bars begin and end in collars beside the joints' axes, sampled, without any proof.

    In the plane in which an upper arm turns, elbow and wrist are `d + e` farther apart than the ends of the bars: with
    v the wrist's distance from that plane and b the bars' length they are `rho = d + e + sqrt(b^2 - v^2)` apart in it,
    so that a chain closes as one without collars whose forearm is `sqrt(rho^2 + v^2)` long. The bars push along
    themselves. With collars of 0 all is as in `delta_cad.mechanism`.

    Source: R. E. Stamper, A Three Degree of Freedom Parallel Manipulator with Only Translational Degrees of Freedom,
    thesis, University of Maryland, 1997: the manipulator that libnifalcon computes.

    Attributes:
        geometry: Its lengths; the forearm's is that of the bars.
        collars: d + e, m.
    """

    geometry: DeltaGeometry
    collars: float

    def pose(self, p: np.ndarray) -> _Pose:
        """Computes angles and bars at positions (..., 3) in m, elbows outwards."""
        g, (q, t, z) = self.geometry, chain_coordinates(self.geometry, p)
        left = g.forearm_length**2 - t * t
        bar = np.sqrt(np.where(left >= 0.0, left, np.nan))  # in the arm's plane
        apart = self.collars + bar
        rho2, m, w2 = kernel.chain_closure.py_func(q, t, z, g.upper_arm_length, np.hypot(apart, t))
        w = np.sqrt(np.where(w2 >= 0.0, w2, np.nan))
        cos, sin = kernel.arm.py_func(q, z, np.where(rho2 > 0.0, rho2, np.nan), m, w)
        share = bar / np.where(apart > 0.0, apart, np.nan)
        out, up = share * (q - g.upper_arm_length * cos), share * (z - g.upper_arm_length * sin)
        bars = out[..., None] * g.radial + t[..., None] * g.tangential + up[..., None] * VERTICAL
        along = (out * cos + up * sin) / share
        elbow = np.arccos(np.clip(along / np.hypot(apart, t), -1.0, 1.0))
        return _Pose(np.arctan2(sin, cos), bars, share * w * g.upper_arm_length, elbow, np.arctan2(t, bar))

    def jacobian(self, p: np.ndarray) -> np.ndarray:
        """Computes (..., 3 axes, 3 chains) m/rad, `v = J theta_dot`; NaN where a chain cannot be closed."""
        pose = self.pose(p)
        rows = pose.bars / np.where(pose.lever == 0.0, np.nan, pose.lever)[..., None]
        closed = np.asarray(np.isfinite(rows).all(axis=(-2, -1)) & (forearm_determinant(pose.bars) != 0.0))
        found = np.linalg.inv(np.where(closed[..., None, None], rows, np.eye(3)))
        return np.where(closed[..., None, None], found, np.nan)

    def conditioning(self, p: np.ndarray) -> np.ndarray:
        """Computes (...) condition number of the Jacobian."""
        values = self.singular_values(p)
        return values[..., 0] / values[..., 2]

    def singular_values(self, p: np.ndarray) -> np.ndarray:
        """Computes (..., 3) singular values of the Jacobian, descending, m/rad."""
        found = self.jacobian(p)
        closed = np.asarray(np.isfinite(found).all(axis=(-2, -1)))
        values = np.linalg.svd(np.where(closed[..., None, None], found, np.eye(3)), compute_uv=False)
        return np.where(closed[..., None], values, np.nan)

    def worst_torque(self, p: np.ndarray, force: float) -> np.ndarray:
        """Computes (..., 3 chains) largest torque over all directions of a force, N m."""
        return force * np.linalg.norm(self.jacobian(p), axis=-2)

    def in_reach(self, p: np.ndarray) -> np.ndarray:
        """Decides (...) whether each position is reached in the machine's own assembly, platform above the elbows."""
        margins = self.margins(p)
        return (p[..., 2] > 0.0) & (margins[0] > 0.0) & (margins[1] > 0.0)

    def margins(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Computes (...) least lever of a chain, m^2, and determinant of the bars' directions: positive in reach."""
        pose = self.pose(p)
        return pose.lever.min(axis=-1), forearm_determinant(pose.bars) / self.geometry.forearm_length**3

    def require(self, p: np.ndarray) -> None:
        """Refuses positions (n, 3) of which one is not reached.

        Raises:
            UnreachableError: The message names the position.
        """
        bad = p[~self.in_reach(p)]
        if len(bad):
            x, y, z = bad[0] * MM_PER_M
            raise UnreachableError(
                f"position ({x:.3f}, {y:.3f}, {z:.3f}) mm is not reached with elbows outwards and the platform above "
                "them; make the cube smaller or move it"
            )


def kinematic_rows(lengths: Lengths, file: str) -> list[InspectionRow]:
    """Inspects a delta by its lengths.

    Args:
        lengths: The lengths and the cube.
        file: Name of their file, for errors.

    Raises:
        UnreachableError: A point of the cube is out of reach.
        DesignError: A limit is stated that is not computed of a delta with collars.
    """
    design, delta = lengths.design, CollaredDelta(lengths.design.geometry, lengths.collars_m)
    if lengths.collars_m:
        figures = list(_collared_rows(lengths, delta, file))
    else:
        extremes = cube_extremes(design.geometry, design.workspace, design.requirements.force_N)
        of_hardware = {figure.words for kind in POSE_LIMITS if kind.needs for figure in kind.figures}
        figures = [row for row in limit_rows(design) if row.quantity not in of_hardware]
        if design.requirements.joint_torque_N_m == FREE_TORQUE_N_M:  # none is stated
            figures = [
                replace(row, limit="", holds=None) if row.quantity.startswith("torque for") else row for row in figures
            ]
        figures += [*other_rows(extremes), *reach_rows(design)]
    conventions = [InspectionRow("conventions", name, words, "") for name, words in _CONVENTIONS]
    return [*_dimensions(lengths), *figures, *_workspace(lengths, delta), *conventions]


def _dimensions(lengths: Lengths) -> Iterator[InspectionRow]:
    """The lengths: what is known of the radii, and collars."""
    design, m = lengths.design, lengths.design.mechanism
    for row in dimension_rows(design):
        if row.group == OUTLINE or row.quantity == "parallelogram width L_c":
            continue
        if lengths.difference_mm is None or not row.quantity.startswith(("base radius", "platform radius")):
            yield row
        elif row.quantity.startswith("base radius"):
            yield InspectionRow(row.group, "base radius less platform radius, R - r", lengths.difference_mm, "mm")
    for place in ("elbow", "wrist") if lengths.collars_m else ():
        value = getattr(m, f"collar_{place}_mm")
        yield InspectionRow("dimensions", f"collar at the {place}, from its axis to the bars", value, "mm")


def _collared_rows(lengths: Lengths, delta: CollaredDelta, file: str) -> Iterator[InspectionRow]:
    """Figures over the cube of a delta with collars."""
    design, required = lengths.design, lengths.design.requirements
    search, force = CubeSearch(design.workspace, _COUNT), required.force_N
    delta.require(search.points)
    torque = None if required.joint_torque_N_m == FREE_TORQUE_N_M else required.joint_torque_N_m
    for k, words in enumerate(("elbow arm times L_A", "assembly mode, det S / L_B^3")):
        found = search(lambda p, k=k: delta.margins(p)[k], 1.0)
        x, y, z = (MM_PER_M * v for v in found.position)
        value, unit = (found.value * MM_PER_M**2, "mm^2") if k == 0 else (found.value, "")
        yield InspectionRow(_OVER, words, value, unit, "> 0", found.value > 0.0, (x, y, z))
    most, least = True, False
    table: tuple[tuple[str, str, Callable[[np.ndarray], np.ndarray], bool, str, float | None], ...] = (
        (
            f"torque for {force:g} N in the worst direction",
            "N m",
            lambda p: delta.worst_torque(p, force).max(axis=-1),
            most,
            "joint_torque_N_m",
            torque,
        ),
        ("kappa", "", delta.conditioning, most, "kappa_max", required.kappa_max),
        (
            "lean",
            "deg",
            lambda p: np.degrees(np.abs(delta.pose(p).lean)).max(axis=-1),
            most,
            "lean_max_deg",
            required.lean_max_deg,
        ),
        (
            "shoulder, smallest",
            "deg",
            lambda p: np.degrees(delta.pose(p).theta).min(axis=-1),
            least,
            "shoulder_min_deg",
            required.shoulder_min_deg,
        ),
        (
            "shoulder, largest",
            "deg",
            lambda p: np.degrees(delta.pose(p).theta).max(axis=-1),
            most,
            "shoulder_max_deg",
            required.shoulder_max_deg,
        ),
        (
            "elbow angle",
            "deg",
            lambda p: 180.0 - np.degrees(delta.pose(p).elbow).max(axis=-1),
            least,
            "elbow_angle_min_deg",
            required.elbow_angle_min_deg,
        ),
        (
            "smallest singular value of J",
            "mm/deg",
            lambda p: delta.singular_values(p)[..., 2] * MM_PER_M / degrees(1.0),
            least,
            "",
            None,
        ),
        (
            "largest singular value of J",
            "mm/deg",
            lambda p: delta.singular_values(p)[..., 0] * MM_PER_M / degrees(1.0),
            most,
            "",
            None,
        ),
    )
    held = {field for *_, field, _ in table}
    stated = (field.name for kind in POSE_LIMITS for field in kind.fields_)
    for name in stated:
        if name not in held and (value := getattr(required, name)) is not None:
            allowed = "is not computed of a delta with collars: leave it out"
            raise DesignError(file, f"requirements.{name}", f"{value:g}", allowed)
    for words, unit, of, is_most, _, bound in table:
        found = search(of, -1.0 if is_most else 1.0)
        x, y, z = (MM_PER_M * v for v in found.position)
        limit, holds = "", None
        if bound is not None:
            limit = f"{'<=' if is_most else '>='} {bound:g}"
            holds = found.value <= bound if is_most else found.value >= bound
        yield InspectionRow(_OVER, words, found.value, unit, limit, holds, (x, y, z))


def _workspace(lengths: Lengths, delta: CollaredDelta) -> list[InspectionRow]:
    """What is reached at all: volume, extents, and the circle that is reached all round at the cube's middle."""
    g, middle = delta.geometry, lengths.design.workspace.centre
    links = g.upper_arm_length + g.forearm_length + delta.collars
    side = links + float(np.abs(g.radius_differences).max())
    x, z = np.linspace(-side, side, _GRID), np.linspace(0.0, links, _GRID)
    p = np.stack(np.meshgrid(x, x, z, indexing="ij"), axis=-1).reshape(-1, 3)
    reached = p[delta.in_reach(p)] * MM_PER_M
    if not len(reached):
        return []
    step, rise = 2.0 * side / (_GRID - 1) * MM_PER_M, links / (_GRID - 1) * MM_PER_M
    group = f"workspace (sampled every {step:.3g} mm, {rise:.3g} mm along z)"
    litres = len(reached) * step**2 * rise / 1e6
    rows = [InspectionRow(group, "volume, elbows outwards and the platform above them", litres, "dm^3")]
    for k, name in enumerate("xyz"):
        low, high = reached[:, k].min(), reached[:, k].max()
        rows.append(InspectionRow(group, f"extent along {name}", f"{low:.1f} to {high:.1f}", "mm"))
    words = "radius that is reached all round, at the height of the cube's middle"
    return [*rows, InspectionRow(group, words, _radius(delta, middle, side) * MM_PER_M, "mm")]


def _radius(delta: CollaredDelta, middle: np.ndarray, most: float) -> float:
    """The largest circle about the base's axis, at a height, within which all sampled directions are reached, m."""
    angles = np.arange(_DIRECTIONS) * 2.0 * pi / _DIRECTIONS
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=-1)

    def reached(radius: float) -> bool:
        p = np.concatenate([radius * ways, np.full((_DIRECTIONS, 1), middle[2])], axis=-1)
        return bool(delta.in_reach(p).all())

    steps = np.linspace(0.0, hypot(most, middle[2]), _RADII)
    beyond = next((k for k, radius in enumerate(steps) if not reached(float(radius))), len(steps) - 1)
    if beyond == 0:
        return 0.0
    low, high = float(steps[beyond - 1]), float(steps[beyond])
    for _ in range(_HALVINGS):
        half = (low + high) / 2.0
        low, high = (half, high) if reached(half) else (low, half)
    return low
