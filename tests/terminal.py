"""A command on a terminal: what a person would see of its progress."""

from __future__ import annotations

import os
import pty
import subprocess
from collections.abc import Sequence


def shown_on_a_terminal(command: Sequence[str]) -> tuple[int, bytes]:
    """Exit code, and what the command wrote to stderr where that is a terminal; its stdout is thrown away."""
    ours, theirs = pty.openpty()
    with os.fdopen(ours, "rb", buffering=0) as terminal:
        run = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=theirs)
        os.close(theirs)
        shown = b""
        try:
            while piece := terminal.read(4096):
                shown += piece
        except OSError:  # the other end is closed: all was read
            pass
    return run.returncode, shown
