"""The pictures drawn by a second process while this one goes on: software rendering keeps a core busy for seconds."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from delta_cad.assembly import Assembly
from delta_cad.export.meshes import Meshes
from delta_cad.export.views import Stage, write_views


@contextmanager
def pictures(assembly: Assembly, meshes: Meshes, directory: Path, stage: Stage) -> Iterator[None]:
    """Draws all pictures while the block runs; they are complete when it ends.

    The other process gets meshes and placements but no solids. It is spawned: the CAD kernel does not outlive a fork.

    Args:
        assembly: The machine.
        meshes: Part number -> mesh in mm.
        directory: Folder to write into, made if missing.
        stage: Outline and cube.

    Raises:
        PictureError: There is no OpenGL.
    """
    bare = {part.number: replace(part, solid=None) for part in assembly.parts}  # type: ignore[arg-type]
    light = replace(assembly, occurrences=tuple(replace(o, part=bare[o.part.number]) for o in assembly.occurrences))
    shapes = {number: meshes[number] for number in bare}
    spawn = multiprocessing.get_context("spawn")
    deaf = (signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; this process answers for both
    with ProcessPoolExecutor(1, mp_context=spawn, initializer=signal.signal, initargs=deaf) as other:
        drawn = other.submit(write_views, light, shapes, directory, stage)
        yield
        drawn.result()
