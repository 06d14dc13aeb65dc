"""VTK poly data from arrays, and VTK normals: smooth over curved faces, sharp across edges."""

from __future__ import annotations

from typing import Any

import numpy as np

# Facets that turn by less belong to one smooth face: the usual crease angle; tessellation stays far below it.
CREASE_DEG = 30.0


def poly_data(points: np.ndarray, cells: np.ndarray) -> Any:
    """Makes VTK's record of a mesh or of lines.

    Args:
        points: (n, 3) points.
        cells: (m, 3) triangles or (m, 2) lines over them.
    """
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    data, place, array = vtkPolyData(), vtkPoints(), vtkCellArray()
    place.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    data.SetPoints(place)
    array.SetData(cells.shape[1], numpy_to_vtk(np.ascontiguousarray(cells, dtype=np.int64).ravel(), deep=True))
    (data.SetPolys if cells.shape[1] == 3 else data.SetLines)(array)
    return data


def shaded(mesh: Any) -> Any:
    """Splits VTK's record of a mesh along its sharp edges and adds a normal to every point.

    Args:
        mesh: Triangles wound outwards, points merged.

    Returns:
        The record in which a point is repeated for every smooth patch that meets there.
    """
    from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

    normals = vtkPolyDataNormals()
    normals.SetInputData(mesh)
    normals.SetFeatureAngle(CREASE_DEG)
    normals.ConsistencyOff()  # the tessellation is wound consistently already
    normals.Update()
    return normals.GetOutput()
