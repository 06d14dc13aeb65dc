"""An off-screen scene of the machine: shaded parts with feature edges, posed by matrices, rendered to pixels.

Needs no display: an EGL window is asked for directly, so that nothing is tried and complained about first. Pictures
are rendered larger and averaged down, which smooths lines and edges alike.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from delta_cad.export.views.shading import creased, edge_table

if TYPE_CHECKING:
    from delta_cad.assembly.tessellation import Mesh

Colour = tuple[float, float, float]
EDGE_COLOUR: Colour = (0.07, 0.08, 0.10)
GROUND_COLOUR: Colour = (1.0, 1.0, 1.0)
SKY_COLOUR: Colour = (0.86, 0.89, 0.93)
SUPERSAMPLING = 2
EDGE_WIDTH = 1.0
"""Line width in pixels of the finished picture."""
OCCLUSION_RADIUS_MM, OCCLUSION_BIAS_MM, OCCLUSION_SAMPLES = 14.0, 1.0, 24
"""How far a surface can shade another; what depth is ignored, for facets shade themselves; rays a pixel."""


class PictureError(RuntimeError):
    """No picture can be drawn: there is no OpenGL."""


def render_window(size: tuple[int, int]) -> Any:
    """An off-screen window.

    Args:
        size: Width and height, pixels, as rendered.

    Raises:
        PictureError: The machine offers no OpenGL, neither from a display nor in software.
    """
    from vtkmodules.vtkCommonCore import vtkObject

    warnings = vtkObject.GetGlobalWarningDisplay()
    vtkObject.GlobalWarningDisplayOff()  # a maker that fails is not worth a message as long as another one works
    try:
        for make in _window_makers():
            window = make()
            window.SetOffScreenRendering(1)
            window.SetSize(*size)
            window.SetMultiSamples(0)
            if window.SupportsOpenGL():
                return window
    finally:
        vtkObject.SetGlobalWarningDisplay(warnings)
    raise PictureError(
        "no OpenGL for pictures: the machine has neither a display nor software rendering; install libegl1 and libgl1"
    )


def _window_makers() -> list[Any]:
    """Kinds of windows to try, best first: without a display, then on one where there is one."""
    import vtkmodules.vtkRenderingFreeType
    import vtkmodules.vtkRenderingOpenGL2
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

    backend = vtkmodules.vtkRenderingOpenGL2  # the other module is imported for its text renderer alone
    headless = [getattr(backend, name, None) for name in ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow")]
    makers = [maker for maker in headless if maker]
    return [*makers, vtkRenderWindow] if os.environ.get("DISPLAY") or not makers else makers


class PartShape:
    """Display data of one part, shared by all its occurrences."""

    def __init__(self, mesh: Mesh, colour: Colour) -> None:
        vertices, faces = np.asarray(mesh.vertices, dtype=float), np.asarray(mesh.faces)
        self.colour = colour
        self.edges = edge_table(vertices, faces)
        self.points, self.triangles, self.normals = creased(vertices, faces)


Placed = tuple[PartShape, np.ndarray]


def placed_points(shape: PartShape, frame: np.ndarray) -> np.ndarray:
    """(n, 3) vertices of a placed part in the base frame, mm."""
    return shape.edges.vertices @ frame[:3, :3].T + frame[:3, 3]


class PartScene:
    """Placed parts as one actor a colour: few actors draw three times as fast as one a part."""

    def __init__(self, placed: Sequence[Placed]) -> None:
        """Collects display data and (4, 4) frames from the part to the base frame, mm."""
        from vtkmodules.vtkRenderingCore import vtkActor, vtkRenderer

        self.renderer = vtkRenderer()
        self.renderer.SetBackground(*GROUND_COLOUR)
        self.renderer.SetBackground2(*SKY_COLOUR)
        self.renderer.GradientBackgroundOn()
        self.renderer.DitherGradientOff()  # noise would make the files ten times larger
        _lights(self.renderer)
        self.placed = tuple(placed)
        colours: dict[Colour, list[Placed]] = {}
        for shape, frame in self.placed:
            colours.setdefault(shape.colour, []).append((shape, frame))
        for colour, placed in colours.items():
            self.renderer.AddActor(_surface(placed, colour))
        self.lines = vtkActor()
        line = self.lines.GetProperty()
        line.SetColor(*EDGE_COLOUR)
        line.SetLineWidth(EDGE_WIDTH * SUPERSAMPLING)
        line.LightingOff()
        self.renderer.AddActor(self.lines)

    def occlude(self) -> None:
        """Darkens corners and gaps by what the surroundings hide of the sky (screen-space ambient occlusion)."""
        from vtkmodules.vtkRenderingOpenGL2 import vtkRenderStepsPass, vtkSSAOPass

        shade = vtkSSAOPass()
        shade.SetRadius(OCCLUSION_RADIUS_MM)
        shade.SetBias(OCCLUSION_BIAS_MM)
        shade.SetKernelSize(OCCLUSION_SAMPLES)
        shade.BlurOn()
        shade.SetDelegatePass(vtkRenderStepsPass())
        self.renderer.SetPass(shade)

    def points_mm(self) -> np.ndarray:
        """(n, 3) all vertices in the base frame, mm."""
        return np.concatenate([placed_points(*one) for one in self.placed])

    def bounds_mm(self) -> np.ndarray:
        """(2, 3) lowest and highest coordinates of all parts, mm."""
        points = self.points_mm()
        return np.array([points.min(axis=0), points.max(axis=0)])

    def draw_edges(self, towards: np.ndarray) -> None:
        """Draws sharp edges and outlines for a parallel view.

        Args:
            towards: (3,) unit vector from the machine to the viewer.
        """
        segments = [
            shape.edges.drawn(frame[:3, :3].T @ towards) @ frame[:3, :3].T + frame[:3, 3]
            for shape, frame in self.placed
        ]
        self.lines.SetMapper(line_mapper(np.concatenate(segments)))


def _surface(placed: Sequence[Placed], colour: Colour) -> Any:
    """One shaded actor of all that has one colour."""
    from vtkmodules.vtkRenderingCore import vtkActor

    counts = np.cumsum([0] + [len(shape.points) for shape, _ in placed])
    surface = vtkActor()
    surface.SetMapper(
        surface_mapper(
            np.concatenate([shape.points @ frame[:3, :3].T + frame[:3, 3] for shape, frame in placed]),
            np.concatenate([shape.triangles + count for (shape, _), count in zip(placed, counts, strict=False)]),
            np.concatenate([shape.normals @ frame[:3, :3].T for shape, frame in placed]),
        )
    )
    material = surface.GetProperty()
    material.SetColor(*colour)
    material.SetAmbient(0.20)
    material.SetDiffuse(0.85)
    material.SetSpecular(0.18)
    material.SetSpecularPower(24.0)
    material.BackfaceCullingOn()
    return surface


def line_mapper(segments: np.ndarray) -> Any:
    """Mapper of (n, 2, 3) straight lines."""
    return surface_mapper(segments.reshape(-1, 3), np.arange(2 * len(segments)).reshape(-1, 2), None)


def surface_mapper(points: np.ndarray, cells: np.ndarray, normals: np.ndarray | None) -> Any:
    """Poly data of triangles (with normals) or lines behind a mapper that keeps lines before the faces they bound."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkRenderingCore import vtkPolyDataMapper

    data = vtkPolyData()
    place = vtkPoints()
    place.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=np.float32), deep=True))
    data.SetPoints(place)
    width = cells.shape[1]
    array = vtkCellArray()
    offsets = np.arange(0, width * len(cells) + 1, width, dtype=np.int64)
    array.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=True),
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(cells.ravel(), dtype=np.int64), deep=True),
    )
    polygons = normals is not None
    (data.SetPolys if polygons else data.SetLines)(array)
    if polygons:
        data.GetPointData().SetNormals(numpy_to_vtk(np.ascontiguousarray(normals, dtype=np.float32), deep=True))
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.ScalarVisibilityOff()
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(*((1.0, 1.0) if polygons else (0.0, 0.0)))
    return mapper


def _lights(renderer: Any) -> None:
    """Key light over the left shoulder, weak fill from the right, rim from behind; all turn with the camera."""
    from vtkmodules.vtkRenderingCore import vtkLight

    renderer.RemoveAllLights()
    renderer.AutomaticLightCreationOff()
    for position, intensity in (((-0.7, 0.9, 1.0), 0.85), ((1.0, 0.1, 0.6), 0.33), ((0.2, 0.8, -1.0), 0.25)):
        light = vtkLight()
        light.SetLightTypeToCameraLight()
        light.SetPosition(*position)
        light.SetIntensity(intensity)
        renderer.AddLight(light)


def photograph(window: Any) -> np.ndarray:
    """Renders the window.

    Args:
        window: Off-screen window with its renderers.

    Returns:
        (height, width, 3) bytes of the finished picture, averaged down, first row on top.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

    window.Render()
    width, height = window.GetSize()
    pixels = vtkUnsignedCharArray()
    window.GetPixelData(0, 0, width - 1, height - 1, 1, pixels, 0)
    n = SUPERSAMPLING
    raw = vtk_to_numpy(pixels).reshape(height // n, n, width // n, n, 3)
    total = np.zeros((height // n, width // n, 3), dtype=np.uint16)
    for row in range(n):
        for column in range(n):
            total += raw[:, row, :, column]
    return (total // (n * n)).astype(np.uint8)[::-1]
