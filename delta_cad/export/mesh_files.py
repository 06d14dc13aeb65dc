"""Files of a build that need no solids, written by a second process: STL, 3MF, GLB, simulation models, pictures.

Software rendering keeps a core busy for seconds; what all these need is loaded while the solids are still being made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.common.worker_process import WorkerProcess, WorkerProcessError
from delta_cad.drive import DriveReport
from delta_cad.export.glb import write_glb
from delta_cad.export.meshes import write_3mf, write_stl
from delta_cad.export.robot import Robot, mjcf, sdf, urdf
from delta_cad.export.views.scene import PictureError
from delta_cad.export.views.views import Stage, write_views

LOADS = (
    "scipy.spatial.transform",
    "trimesh.exchange.gltf",
    "trimesh.exchange.stl",
    "vtkmodules.util.numpy_support",
    "vtkmodules.vtkFiltersHybrid",
    "vtkmodules.vtkFiltersSources",
    "vtkmodules.vtkIOImage",
    "vtkmodules.vtkImagingCore",
    "vtkmodules.vtkRenderingOpenGL2",
)


_Moves = tuple[Mapping[str, Any], DriveReport, tuple[float, float], Sequence[float], tuple[float, float]]
"""Masses, drive, stops, gravity and friction, as `Robot` and `mjcf` take them."""


def results(order: tuple[Assembly, Meshes, Path, Stage | None, _Moves]) -> Iterator[list[Path]]:
    """Writes the files into a folder, then the pictures.

    Args:
        order: The machine without its solids, its meshes by part number, the build's folder, outline and cube (None:
            no pictures are made), and what the twins need.

    Yields:
        The pictures' files.
    """
    assembly, meshes, folder, stage, moves = order
    parts = folder / "parts"
    parts.mkdir(exist_ok=True)
    for part in assembly.parts:
        if part.make:
            mesh = meshes[part.number]
            write_stl(mesh, parts / f"{part.number}.stl", part.number)
            if not part.material.process:  # of what is printed the build writes the body to print, as it stands
                write_3mf(mesh, parts / f"{part.number}.3mf", part.number, part.description, part.material.name)
    write_glb(assembly, meshes, folder / "assembly.glb")
    masses, drive, stops, gravity, friction = moves
    robot = Robot(assembly, masses["bodies"], drive, stops, friction)
    for name, text in (("twin.xml", mjcf(robot, gravity)), ("machine.urdf", urdf(robot)), ("machine.sdf", sdf(robot))):
        (folder / name).write_text(text, encoding="utf-8")
    yield [] if stage is None else write_views(assembly, meshes, folder / "views", stage)


def written(writer: WorkerProcess) -> None:
    """Waits for the pictures of another process that was given its order, and all else that it writes.

    Raises:
        MeshError: A mesh cannot be written.
        PictureError: There is no OpenGL, or the other process ended early.
        OSError: It could not write them.
    """
    try:
        writer.receive()
    except WorkerProcessError as error:
        raise PictureError(str(error)) from error
