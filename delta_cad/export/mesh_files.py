"""The pictures drawn by a second process while this one goes on: software rendering keeps a core busy for seconds."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.common.beside import Beside, BesideError
from delta_cad.export.views.scene import PictureError
from delta_cad.export.views.views import Stage, write_views

LOADS = (
    "vtkmodules.util.numpy_support",
    "vtkmodules.vtkFiltersHybrid",
    "vtkmodules.vtkFiltersSources",
    "vtkmodules.vtkIOImage",
    "vtkmodules.vtkImagingCore",
    "vtkmodules.vtkRenderingOpenGL2",
)


def results(order: tuple[Assembly, Meshes, Path, Stage]) -> Iterator[list[Path]]:
    """Draws all pictures; arguments as `write_views` has them, the machine without its solids."""
    yield write_views(*order)


def drawn(painter: Beside) -> None:
    """Waits for the pictures of a process that was started from this module and given its order.

    Raises:
        PictureError: There is no OpenGL, or the other process ended early.
        OSError: It could not write them.
    """
    try:
        painter.take()
    except BesideError as error:
        raise PictureError(str(error)) from error
