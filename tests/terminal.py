"""A command as a person runs it: what of its progress is seen on a terminal, and how it ends by Ctrl-C."""

from __future__ import annotations

import os
import pty
import re
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

HANGS_S = 120.0  # after which a command is taken to hang, on a machine however busy


def said(stderr: str) -> str:
    """What a process said beside its progress, which depends on how fast the machine is."""
    return re.sub(r"(?m)^ *\d+ s  .*\n", "", stderr)


def shown_on_a_terminal(command: Sequence[str]) -> tuple[int, bytes]:
    """Exit code, and what the command wrote to stderr where that is a terminal; its stdout is thrown away."""
    own, theirs = pty.openpty()
    with os.fdopen(own, "rb", buffering=0) as terminal:
        room = os.environ | {"TERM": "xterm"}
        run = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=theirs, env=room)
        os.close(theirs)
        shown = b""
        try:
            while piece := terminal.read(4096):
                shown += piece
        except OSError:  # the other end is closed: all was read
            pass
    return run.returncode, shown


class Ended(NamedTuple):
    """How it ended.

    Attributes:
        code: Exit code; that of the command itself where it was done before.
        seconds: From Ctrl-C to the end.
        said: What it said on stderr, without its progress.
    """

    code: int
    seconds: float
    said: str


def interrupted(command: Sequence[str], after_s: float, ready: Callable[[], bool] = lambda: True) -> Ended:
    """Runs a command and interrupts it.

    Args:
        command: Its words.
        after_s: Time from the moment it listens, and is ready, to Ctrl-C.
        ready: Asked until it is true, or the command ends.

    Returns:
        How it ended.

    Raises:
        subprocess.TimeoutExpired: It hangs.
    """
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as run:
        try:
            while run.poll() is None and not (_listens(run.pid) and ready()):
                with suppress(subprocess.TimeoutExpired):
                    run.wait(0.02)
            with suppress(subprocess.TimeoutExpired):
                run.wait(after_s)
            start = time.monotonic()
            run.send_signal(signal.SIGINT)
            _, stderr = run.communicate(timeout=HANGS_S)
        finally:
            run.kill()
        return Ended(run.returncode, time.monotonic() - start, said(stderr))


def _listens(pid: int) -> bool:
    """Whether a process has got so far that Ctrl-C is its own affair: the interpreter's start is not."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:  # it has ended
        return False
    caught = next(line.split()[1] for line in status.splitlines() if line.startswith("SigCgt:"))
    return bool(int(caught, 16) >> (signal.SIGALRM - 1) & 1)
