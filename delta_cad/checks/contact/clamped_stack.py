"""Material and gaps under the head of a screw, along lines beside its shank."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from delta_cad.assembly.tessellation import Mesh

_LINES = 12
_RING = 0.9  # of the head's radius: outside of any clearance hole (0.62 for M3), inside of the head
_FIRST_RAD = 0.1234  # turns the lines away from the seams of meshes, which lie at even parts of a turn


def largest_gaps(parts: Sequence[tuple[Mesh, np.ndarray]], head_mm: float, start_mm: float) -> np.ndarray:
    """Measures the largest gap between different parts along lines from under a screw's head to its thread.

    A gap with the same part on both sides is the slit of a clamp, and no fault.

    Args:
        parts: Meshes near the screw and their (4, 4) placements in its frame: z along the axis, head above 0.
        head_mm: Radius of the head.
        start_mm: z at which the thread begins.

    Returns:
        (LINES,) gaps, mm; infinite where a line meets nothing more before the thread.
    """
    angle = _FIRST_RAD + 2.0 * np.pi * np.arange(_LINES) / _LINES
    at = _RING * head_mm * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    met = [_met(mesh, frame, at, _RING * head_mm) for mesh, frame in parts]
    return np.array(
        [_gap([(top, low, k) for k, m in enumerate(met) for low, top in m[i]], start_mm) for i in range(_LINES)]
    )


def _gap(met: list[tuple[float, float, int]], start_mm: float) -> float:
    """Largest gap on one line that meets (top, low, part) of material."""
    reached, above, gap = 0.0, -1, 0.0
    for top, low, part in sorted(met, reverse=True):
        if low >= reached - 1e-9:  # above the head's seat, or within what was counted
            continue
        if top < reached and part != above:
            gap = max(gap, reached - top)
        reached, above = low, part
        if reached <= start_mm - 1e-6:  # material beside the thread itself
            return gap
    return gap if reached <= start_mm else np.inf


def _met(mesh: Mesh, frame: np.ndarray, at: np.ndarray, ring_mm: float) -> list[list[tuple[float, float]]]:
    """Per line along z at (x, y) the (low, top) intervals inside a mesh, mm."""
    corners = (mesh.vertices @ frame[:3, :3].T + frame[:3, 3])[mesh.faces]
    near = ((corners[..., :2].min(axis=1) <= ring_mm) & (corners[..., :2].max(axis=1) >= -ring_mm)).all(axis=1)
    a, b, c = np.moveaxis(corners[near], 1, 0)
    p = at[:, None, :]

    def side(q: np.ndarray, r: np.ndarray) -> np.ndarray:
        return (r[:, 0] - q[:, 0]) * (p[..., 1] - q[:, 1]) - (r[:, 1] - q[:, 1]) * (p[..., 0] - q[:, 0])

    u, v, w = side(b, c), side(c, a), side(a, b)
    inside = ((u > 0) & (v > 0) & (w > 0)) | ((u < 0) & (v < 0) & (w < 0))
    line, triangle = np.nonzero(inside)
    weights = np.stack([u, v, w], axis=-1)[line, triangle]
    z = np.stack([a[triangle, 2], b[triangle, 2], c[triangle, 2]], axis=-1)
    height = (weights * z).sum(axis=1) / weights.sum(axis=1)
    layers = []
    for i in range(len(at)):
        levels = np.sort(height[line == i]).tolist()
        layers.append(list(zip(levels[::2], levels[1::2], strict=False)))
    return layers
