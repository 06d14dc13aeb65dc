"""The machine from above: what each body sweeps over the cube, on the rectangle that it has to fit."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from delta_cad.checks.links import rigid_link
from delta_cad.mechanism.placement import LINKS
from delta_cad.report.subject import Subject, plain

GRID = 5  # positions along an edge of the cube
_DIGITS = 5
_MARGIN_MM = 14.0  # about the drawing, for what is written there


def outline(s: Subject) -> dict[str, Any]:
    """Draws the swept machine from above.

    Args:
        s: The machine; where its cube is out of reach, only its home position is drawn.

    Returns:
        As JSON types, mm: `bodies`, of each the corners (n, 2) of the convex hull of what it sweeps over sampled
        positions; `home`, the same of each part in the home position, the lowest first; `allowed` and `bound`, the
        rectangle and the bound on the sweep as (x, y, width, depth), the second None where there is none; `cube`, the
        same; `frame`, what holds all of it.
    """
    from scipy.spatial import ConvexHull

    links, poses = s.assembly.placement(_positions(s)), s.assembly.poses(s.assembly.home_mm)
    bodies: dict[str, list[np.ndarray]] = {link: [] for link in LINKS}
    home: list[tuple[float, np.ndarray]] = []
    for o in s.assembly.occurrences:
        link = rigid_link(o, s.assembly.placement)
        corners = s.meshes[o.part.number].vertices
        bodies[link].append(corners @ o.placement[:3, :3].T + o.placement[:3, 3])
        at = poses[o.name]
        home.append((float(at[2, 3]), _hull(corners @ at[:2, :3].T + at[:2, 3], ConvexHull)))
    hulls = []
    for link, points in bodies.items():
        if not points:
            continue
        if link == "base":  # stands still, and its parts stand apart
            hulls += [_hull(one[:, :2], ConvexHull) for one in points]
            continue
        own = np.concatenate(points)
        own = own[ConvexHull(own).vertices]
        at = links[link]
        swept = np.einsum("nij,kj->nki", at[:, :2, :3], own) + at[:, None, :2, 3]
        hulls.append(_hull(swept.reshape(-1, 2), ConvexHull))
    size, middle, half = np.array(s.stage.envelope_mm), np.array(s.stage.envelope_centre_mm), s.limits.half_side_mm
    bound = None
    if s.reach_mm is not None:
        bound = [*-s.reach_mm[1::2], *(s.reach_mm[0::2] + s.reach_mm[1::2])]
    every = np.concatenate([*hulls, [middle - size / 2.0, middle + size / 2.0]])
    low, high = every.min(axis=0) - _MARGIN_MM, every.max(axis=0) + _MARGIN_MM
    return {
        "bodies": plain(hulls, _DIGITS),
        "home": plain([hull for _, hull in sorted(home, key=lambda one: one[0])], _DIGITS),
        "allowed": plain([*(middle - size / 2.0), *size], _DIGITS),
        "bound": plain(bound, _DIGITS),
        "cube": plain([s.limits.centre_x_mm - half, -half, 2.0 * half, 2.0 * half], _DIGITS),
        "frame": plain([*low, *(high - low)], _DIGITS),
    }


def _hull(points: np.ndarray, hull: Any) -> np.ndarray:
    return points[hull(points).vertices]


def _positions(s: Subject) -> np.ndarray:
    """(n, 3) handle positions, mm."""
    if not s.reachable:
        return np.array([s.assembly.home_mm])
    steps = np.linspace(-s.limits.half_side_mm, s.limits.half_side_mm, GRID)
    return s.limits.centre_mm + np.array(list(product(steps, steps, steps)))
