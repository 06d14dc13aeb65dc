"""Vertex normals that are smooth over curved faces and sharp across edges, for display."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

CREASE_RAD = np.deg2rad(30.0)
"""Facets that turn by less belong to one smooth face: the usual crease angle; tessellation stays far below it."""


def creased(
    vertices: np.ndarray, faces: np.ndarray, crease_rad: float = CREASE_RAD
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Splits a mesh along its sharp edges.

    Args:
        vertices: (n, 3) points, any unit.
        faces: (m, 3) triangles.
        crease_rad: Angle between facets above which their common edge is sharp, rad.

    Returns:
        (k, 3) points, (m, 3) triangles over them, (k, 3) unit normals; each point is repeated once for every smooth
        patch that meets there.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    corners = vertices[faces]
    placed = _places(vertices)[faces]
    units = _facet_normals(corners)
    _, a, b = _neighbours(placed)
    smooth = np.einsum("ij,ij->i", units[a], units[b]) > np.cos(crease_rad)
    count = len(faces)
    graph = coo_array((np.ones(int(smooth.sum())), (a[smooth], b[smooth])), shape=(count, count))
    _, patch = connected_components(graph, directed=False)
    keys = placed.ravel().astype(np.int64) * count + np.repeat(patch, 3)
    _, first, index = np.unique(keys, return_index=True, return_inverse=True)
    index = index.reshape(-1)
    normals = np.zeros((len(first), 3))
    weights = _corner_angles(corners)
    np.add.at(normals, index, (units[:, None, :] * weights[:, :, None]).reshape(-1, 3))
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, size, out=np.tile([0.0, 0.0, 1.0], (len(first), 1)), where=size > 0.0)
    return vertices[faces.ravel()[first]], index.reshape(-1, 3), normals


@dataclass(frozen=True)
class EdgeTable:
    """Edges of a mesh with the normals of the facets on either side.

    Attributes:
        vertices: (n, 3) points.
        ends: (k, 2) indices of the end points of each edge.
        left: (k, 3) unit normal of one neighbouring facet.
        right: (k, 3) unit normal of the other.
        sharp: (k,) whether the surface turns there by more than the crease angle.
    """

    vertices: np.ndarray
    ends: np.ndarray
    left: np.ndarray
    right: np.ndarray
    sharp: np.ndarray

    def drawn(self, towards: np.ndarray) -> np.ndarray:
        """Edges to draw in a parallel view: the sharp ones, and the outline where the surface turns away.

        Args:
            towards: (3,) direction from the part to the viewer, in the frame of the vertices.

        Returns:
            (m, 2, 3) end points.
        """
        outline = (self.left @ towards > 0.0) != (self.right @ towards > 0.0)
        return self.vertices[self.ends[self.sharp | outline]]


def edge_table(vertices: np.ndarray, faces: np.ndarray, crease_rad: float = CREASE_RAD) -> EdgeTable:
    """Collects the edges of a mesh for drawing.

    Args:
        vertices: (n, 3) points, any unit.
        faces: (m, 3) triangles.
        crease_rad: Angle between facets above which their common edge is sharp, rad.
    """
    _, first, place = np.unique(_places(vertices), return_index=True, return_inverse=True)
    ends, a, b = _neighbours(place.reshape(-1)[faces])
    units = _facet_normals(vertices[faces])
    sharp = np.einsum("ij,ij->i", units[a], units[b]) <= np.cos(crease_rad)
    return EdgeTable(vertices, first[ends], units[a], units[b], sharp)


def _places(vertices: np.ndarray) -> np.ndarray:
    """(n,) number of the place of each vertex: vertices at one place count as one, however they are numbered."""
    scale = float(np.abs(vertices).max()) or 1.0
    grid = np.round(vertices / scale * 1e6).astype(np.int64) + 2_000_000
    return np.unique((grid[:, 0] << 44) | (grid[:, 1] << 22) | grid[:, 2], return_inverse=True)[1].reshape(-1)


def _facet_normals(corners: np.ndarray) -> np.ndarray:
    """(m, 3) unit normals of (m, 3, 3) triangles; zero where a triangle has no area."""
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(areas, axis=1, keepdims=True)
    return np.divide(areas, lengths, out=np.zeros_like(areas), where=lengths > 0.0)


def _neighbours(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges shared by two triangles, and those two triangles: (k, 2), (k,), (k,)."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(faces)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owner = edges[order], owner[order]
    same = (edges[1:] == edges[:-1]).all(axis=1)
    return edges[1:][same], owner[:-1][same], owner[1:][same]


def _corner_angles(corners: np.ndarray) -> np.ndarray:
    """(m, 3) interior angles, rad: weights that do not depend on how a face is cut into triangles."""
    sides = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(sides, axis=2, keepdims=True)
    sides = np.divide(sides, lengths, out=np.zeros_like(sides), where=lengths > 0.0)
    cosines = -np.einsum("ijk,ijk->ij", sides, np.roll(sides, 1, axis=1))
    return np.arccos(np.clip(cosines, -1.0, 1.0))
