"""An off-screen scene of the machine: shaded parts with feature edges, posed by matrices, rendered to pixels.

Needs no display: an EGL window is asked for directly, so that nothing is tried and complained about first. Pictures
are rendered larger and averaged down, which smooths lines and edges alike.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from delta_cad.export.views.polydata import CREASE_DEG, poly_data, shaded

if TYPE_CHECKING:
    from delta_cad.assembly.tessellation import Mesh

Colour = tuple[float, float, float]
_EDGE_COLOUR: Colour = (0.07, 0.08, 0.10)
_GROUND_COLOUR: Colour = (1.0, 1.0, 1.0)
_SKY_COLOUR: Colour = (0.86, 0.89, 0.93)
SUPERSAMPLING = 2
_EDGE_WIDTH = 1.0  # Line width in pixels of the finished picture.


class PictureError(RuntimeError):
    """No picture can be drawn: there is no OpenGL."""


def render_window(size: tuple[int, int]) -> Any:
    """Opens an off-screen window of two layers, scene and annotations.

    Args:
        size: Width and height of the finished picture, pixels.

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
            window.SetSize(*(SUPERSAMPLING * side for side in size))
            window.SetMultiSamples(0)
            window.SetNumberOfLayers(2)
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


@dataclass(frozen=True)
class Placed:
    """A part as it stands in the base frame.

    Attributes:
        points: (n, 3) vertices, mm.
        triangles: (m, 3) indices of vertices.
        colour: sRGB.
    """

    points: np.ndarray
    triangles: np.ndarray
    colour: Colour


def placed(mesh: Mesh, frame: np.ndarray, colour: Colour) -> Placed:
    """Moves a part's mesh by a (4, 4) frame from the part to the base frame, mm."""
    return Placed(mesh.vertices @ frame[:3, :3].T + frame[:3, 3], mesh.faces, colour)


def joined(parts: Sequence[Placed]) -> Any:
    """Makes one mesh of parts, VTK's record of it."""
    starts = np.cumsum([0] + [len(part.points) for part in parts])
    triangles = [part.triangles + start for part, start in zip(parts, starts, strict=False)]
    return poly_data(np.concatenate([part.points for part in parts]), np.concatenate(triangles))


class PartScene:
    """Placed parts as one actor a colour: few actors draw three times as fast as one a part."""

    def __init__(self, parts: Sequence[Placed]) -> None:
        """Collects placed parts."""
        from vtkmodules.vtkRenderingCore import vtkRenderer

        self.renderer = vtkRenderer()
        self.renderer.SetBackground(*_GROUND_COLOUR)
        self.renderer.SetBackground2(*_SKY_COLOUR)
        self.renderer.GradientBackgroundOn()
        self.renderer.DitherGradientOff()  # noise would make the files ten times larger
        _lights(self.renderer)
        self.points_mm = np.concatenate([part.points for part in parts])
        """(n, 3) all vertices in the base frame, mm."""
        self.bounds_mm = np.array([self.points_mm.min(axis=0), self.points_mm.max(axis=0)])
        """(2, 3) lowest and highest coordinates of all parts, mm."""
        for colour in dict.fromkeys(part.colour for part in parts):
            mesh = joined([part for part in parts if part.colour == colour])
            self.renderer.AddActor(_surface(mesh, colour))
            self.renderer.AddActor(_edges(mesh, self.renderer.GetActiveCamera()))


def _surface(mesh: Any, colour: Colour) -> Any:
    """One shaded actor of all that has one colour, kept behind the lines that bound it."""
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    mapper = vtkPolyDataMapper()
    mapper.SetInputData(shaded(mesh))
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(1.0, 1.0)
    surface = vtkActor()
    surface.SetMapper(mapper)
    material = surface.GetProperty()
    material.SetColor(*colour)
    material.SetAmbient(0.20)
    material.SetDiffuse(0.85)
    material.SetSpecular(0.18)
    material.SetSpecularPower(24.0)
    material.BackfaceCullingOn()
    return surface


def _edges(mesh: Any, camera: Any) -> Any:
    """Sharp edges of a mesh, and the outline where its surface turns away from a parallel camera."""
    from vtkmodules.vtkFiltersHybrid import vtkPolyDataSilhouette

    edges = vtkPolyDataSilhouette()
    edges.SetInputData(mesh)
    edges.SetCamera(camera)
    edges.SetDirectionToCameraVector()
    edges.SetFeatureAngle(CREASE_DEG)
    return flat_actor(edges, _EDGE_COLOUR, _EDGE_WIDTH)


def flat_actor(source: Any, colour: Colour, width: float = 1.0) -> Any:
    """Makes lines or faces of one colour that no light changes, hidden by what is before them.

    Args:
        source: VTK's filter that gives them, or its record of them.
        colour: sRGB.
        width: Line width, pixels of the finished picture.
    """
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    mapper = vtkPolyDataMapper()
    if source.IsA("vtkPolyData"):
        mapper.SetInputData(source)
    else:
        mapper.SetInputConnection(source.GetOutputPort())
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, 0.0)
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(*colour)
    actor.GetProperty().SetLineWidth(width * SUPERSAMPLING)
    actor.GetProperty().LightingOff()
    return actor


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


def flat_shapes(shapes: Sequence[np.ndarray], colour: Colour, width: float = 1.0) -> Any:
    """Makes an actor of lines (2, 3) or triangles (3, 3), mm, as `flat_actor` does."""
    corners = np.array(shapes)
    cells = np.arange(corners.shape[0] * corners.shape[1]).reshape(corners.shape[:2])
    return flat_actor(poly_data(corners.reshape(-1, 3), cells), colour, width)


def aim(renderer: Any, target: np.ndarray, towards: np.ndarray, up: np.ndarray, height_mm: float) -> Any:
    """Sets a parallel camera, and makes the layer over it for annotations.

    Args:
        renderer: The scene.
        target: (3,) middle of the picture, mm.
        towards: (3,) unit vector to the viewer.
        up: (3,) unit vector upwards in the picture.
        height_mm: Of the picture.
    """
    from vtkmodules.vtkRenderingCore import vtkRenderer

    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*target)
    camera.SetPosition(*(target + 1000.0 * towards))
    camera.SetViewUp(*up)
    camera.SetParallelScale(height_mm / 2.0)
    renderer.ResetCameraClippingRange()
    overlay = vtkRenderer()
    overlay.SetLayer(1)
    overlay.SetViewport(renderer.GetViewport())
    overlay.SetActiveCamera(camera)
    return overlay


def photograph(window: Any, layers: Sequence[Any], path: Path) -> None:
    """Renders a scene into a PNG file, averaged down to the finished picture.

    Raises:
        OSError: It cannot be written.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkImagingCore import vtkImageShrink3D
    from vtkmodules.vtkIOImage import vtkPNGWriter
    from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

    for layer in layers:
        window.AddRenderer(layer)
    picture = vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ReadFrontBufferOff()
    smooth = vtkImageShrink3D()
    smooth.SetInputConnection(picture.GetOutputPort())
    smooth.SetShrinkFactors(SUPERSAMPLING, SUPERSAMPLING, 1)
    smooth.AveragingOn()
    writer = vtkPNGWriter()
    writer.SetInputConnection(smooth.GetOutputPort())
    writer.WriteToMemoryOn()  # a full disk is told by Python, not by VTK
    writer.Write()
    for layer in layers:
        window.RemoveRenderer(layer)
    path.write_bytes(vtk_to_numpy(writer.GetResult()).tobytes())
