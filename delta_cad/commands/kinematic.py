"""Figures of anybody's delta, of which lengths alone are known: workspace, cube, conditioning, angles."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from math import degrees, hypot, pi

import numpy as np

from delta_cad.commands.collared import CollaredDelta
from delta_cad.commands.inspection import OUTLINE, InspectionRow, dimension_rows, limit_rows, other_rows, reach_rows
from delta_cad.common.units import MM_PER_M
from delta_cad.design import DesignError
from delta_cad.design.lengths import FREE_TORQUE_N_M, Lengths
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
