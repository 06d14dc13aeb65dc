"""Walls that withstand the cutting force, and faces that a tool can reach."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from delta_cad.checks.dfm.bores import Finding
from delta_cad.checks.dfm.lines import FAR_MM, Lines, face_points
from delta_cad.solids.part import Part

LEAST_WALL_MM = 0.5  # of metal and hard plastic: thinner ones give way before the cutter
ACROSS = 0.9  # cosine between a wall's two sides' normals: a wedge between others ends in an edge
SIGHT_MM = 0.1  # off a face, from where it is seen: the kernel takes lines closer to a bore's rim for hits
INTO_MM = 1e-3  # below a face, from where a line goes through the wall


def walls(part: Part) -> Iterator[Finding]:
    """The thinnest wall of a part, square to its faces."""
    lines, thin = Lines(part.solid), (np.inf, np.zeros(3))
    for _, points in face_points(part.solid):
        for point, normal in points:
            hit = lines.first(point - INTO_MM * normal, -normal, min(thin[0], FAR_MM))
            if hit is not None and hit[1] @ -normal > ACROSS and hit[0] + INTO_MM < thin[0]:
                thin = hit[0] + INTO_MM, point
    if np.isfinite(thin[0]):
        x, y, z = thin[1]
        where = f"{part.number}: {thin[0]:.2f} mm at ({x:.1f}, {y:.1f}, {z:.1f})"
        yield Finding(part.number, round(float(thin[0]), 3), LEAST_WALL_MM, where, is_least=True)


def undercuts(part: Part) -> Iterator[Finding]:
    """Faces of which no point is seen from outside along its normal or an axis of the part or of a bore.

    A straight tool comes to a face along its normal, or beside it along another of these.
    """
    lines = Lines(part.solid)
    ways = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    for bore in (bore for hole in part.holes for bore in hole.bores):
        ways += [-np.array(bore.direction)] + ([np.array(bore.direction)] if bore.through else [])
    distinct = list({tuple(np.round(way, 6)): way for way in ways}.values())
    for face, points in face_points(part.solid):
        if points and not any(_seen(lines, point, normal, distinct) for point, normal in points):
            x, y, z = points[len(points) // 2][0]
            where = f"{part.number}: a face of {face.Area():.1f} mm^2 at ({x:.1f}, {y:.1f}, {z:.1f})"
            yield Finding(part.number, float(face.Area()), 0.0, where)


def _seen(lines: Lines, point: np.ndarray, normal: np.ndarray, ways: list[np.ndarray]) -> bool:
    start = point + SIGHT_MM * normal
    return any(way @ normal > -1e-6 and lines.is_free(start, way) for way in (normal, *ways))
