"""Processes forked from one that has loaded what takes long: a test of many short processes pays for that once."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

SERVER = """
import json, os, sys, traceback
{first}
orders = os.fdopen(os.dup(0))
for line in orders:
    code, folder, environment, said = json.loads(line)
    child = os.fork()
    if child == 0:
        ended = 1
        try:
            for number, name in enumerate(("nothing", "out", "err")):
                os.dup2(os.open(os.devnull if number == 0 else said + name, os.O_RDWR | os.O_CREAT), number)
            os.chdir(folder)
            os.environ.clear()
            os.environ.update(environment)
            exec(compile(code, "<string>", "exec"), {{"__name__": "__main__"}})
            ended = 0
        except SystemExit as end:
            ended = end.code or 0
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(ended)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


class Forked:
    """A process from which others are forked.

    Args:
        first: Code that it runs before, such as imports; no threads may be left by it.
    """

    def __init__(self, first: str) -> None:
        self._command = [sys.executable, "-c", SERVER.format(first=first)]

    def __enter__(self) -> Self:
        """Starts it."""
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(self._command, stdin=pipe, stdout=pipe, text=True)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Ends it."""
        self._process.communicate()

    def run(self, code: str, folder: Path, environment: Mapping[str, str]) -> subprocess.CompletedProcess[str]:
        """Runs code in a fork, as `python -c` in a folder does.

        Args:
            code: The code.
            folder: Where it runs, and what it imports from first.
            environment: All its environment.
        """
        process, said = self._process, f"{folder}.said."
        assert process.stdin is not None
        assert process.stdout is not None
        for name in ("out", "err"):
            Path(said + name).write_text("")
        process.stdin.write(json.dumps([code, str(folder), dict(environment), said]) + "\n")
        process.stdin.flush()
        ended = int(process.stdout.readline())
        out, err = (Path(said + name).read_text() for name in ("out", "err"))
        return subprocess.CompletedProcess(["-c", code], ended, out, err)
