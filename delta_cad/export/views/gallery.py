"""The pictures drawn by a second process while this one goes on: software rendering keeps a core busy for seconds."""

from __future__ import annotations

import errno
import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryFile
from threading import Thread

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
        OSError: It could not write them.
    """
    bare = {part.number: replace(part, solid=None) for part in assembly.parts}  # type: ignore[arg-type]
    light = replace(assembly, occurrences=tuple(replace(o, part=bare[o.part.number]) for o in assembly.occurrences))
    order = pickle.dumps((light, {number: meshes[number] for number in bare}, directory, stage))
    command = [sys.executable, "-m", "delta_cad.export.views.gallery"]
    with (
        TemporaryFile() as complaint,
        subprocess.Popen(command, stdin=subprocess.PIPE, stderr=complaint, start_new_session=True) as painter,
    ):
        assert painter.stdin is not None
        try:
            with suppress(BrokenPipeError):  # it ended early, and its exit code says so below
                painter.stdin.write(order)
                painter.stdin.flush()
            yield
            painter.wait()
        except BaseException:
            painter.kill()
            raise
        finally:
            with suppress(BrokenPipeError):
                painter.stdin.close()
        complaint.seek(0)
        lines = [line for line in complaint.read().decode(errors="replace").split("\n") if line.strip()]
    last = lines[-1] if lines else ""
    if painter.returncode == os.EX_IOERR:
        raise OSError(errno.EIO, last, str(directory))
    if painter.returncode:
        ended = f"was ended by signal {-painter.returncode}" if painter.returncode < 0 else "failed"
        raise PictureError(f"the process that draws the pictures {ended}" + (f": {last}" if last else ""))


def _draw() -> None:
    assembly, shapes, directory, stage = pickle.load(sys.stdin.buffer)
    Thread(target=_end_with_the_builder, daemon=True).start()
    try:
        write_views(assembly, shapes, directory, stage)
    except PictureError as error:
        sys.exit(str(error))
    except OSError as error:
        print(error.strerror or error, file=sys.stderr)
        sys.exit(os.EX_IOERR)


def _end_with_the_builder() -> None:
    """Ends this process when the one that ordered the pictures is killed: it would go on filling the folder."""
    while os.read(sys.stdin.fileno(), 1):  # not through Python's own buffer, whose lock the interpreter's end wants
        pass
    os._exit(1)


if __name__ == "__main__":
    _draw()
