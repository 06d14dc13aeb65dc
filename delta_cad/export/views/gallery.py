"""The pictures drawn by a second process while this one goes on: software rendering keeps a core busy for seconds."""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from delta_cad.assembly.machine import Assembly
from delta_cad.export.meshes import Meshes
from delta_cad.export.views.scene import PictureError
from delta_cad.export.views.views import Stage, write_views


@contextmanager
def pictures(assembly: Assembly, meshes: Meshes, directory: Path, stage: Stage) -> Iterator[None]:
    """Draws all pictures while the block runs; they are complete when it ends.

    The other process gets meshes and placements but no solids. It is a fresh interpreter: the CAD kernel does not
    outlive a fork, and a caller's script need not be importable. It has a session of its own, so that Ctrl-C reaches us
    alone.

    Args:
        assembly: The machine.
        meshes: Part number -> mesh in mm.
        directory: Folder to write into, made if missing.
        stage: Outline and cube.

    Raises:
        PictureError: There is no OpenGL, or the other process ended early.
    """
    bare = {part.number: replace(part, solid=None) for part in assembly.parts}  # type: ignore[arg-type]
    light = replace(assembly, occurrences=tuple(replace(o, part=bare[o.part.number]) for o in assembly.occurrences))
    order = pickle.dumps((light, {number: meshes[number] for number in bare}, directory, stage))
    command = [sys.executable, "-m", "delta_cad.export.views.gallery"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True) as painter:
        try:
            if painter.stdin is not None:
                painter.stdin.write(order)
                painter.stdin.close()
                painter.stdin = None
            yield
            _, complaint = painter.communicate()
        except BaseException:
            painter.kill()
            raise
    if painter.returncode:
        raise PictureError(complaint.decode(errors="replace").strip().splitlines()[-1])


def _draw() -> None:
    assembly, shapes, directory, stage = pickle.loads(sys.stdin.buffer.read())
    try:
        write_views(assembly, shapes, directory, stage)
    except PictureError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    _draw()
