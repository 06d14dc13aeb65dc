"""A worker process: it computes the results of one order on the other core while this process goes on.

The other process is a fresh interpreter: the CAD kernel does not outlive a fork, and a caller's script need not be
importable. It loads its modules while the order is still being made. It has a session of its own, so that Ctrl-C
reaches us alone.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from tempfile import TemporaryFile
from threading import Thread
from types import TracebackType
from typing import Any, Self

_BLAS_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
"""Threads for products of matrices, one in the other process: more would only take turns with us on our core."""
LOW_PRIORITY = 5  # nice steps of 19: a third of the time of one that goes first


class WorkerProcessError(Exception):
    """The worker ended early, or failed in a way that cannot be carried over."""


class WorkerProcess:
    """A process that works through one order; gone when the block ends.

    Args:
        module: Full name of the module whose `results(order)` gives the results one by one. `LOADS`, if it has that,
            names modules that the work will need.
        low_priority: Whether others go first where there are more processes than cores, as nobody waits for its
            results soon.
    """

    def __init__(self, module: str, *, low_priority: bool = False) -> None:
        self._module = module
        self._sending: Thread | None = None
        self._stderr = TemporaryFile()  # noqa: SIM115  (closed where the block ends)
        command = [sys.executable, "-c", f"from {__name__} import work; work({module!r}, {low_priority})"]
        pipe, room = subprocess.PIPE, os.environ | dict.fromkeys(_BLAS_THREADS, "1")
        self._process = subprocess.Popen(
            command, stdin=pipe, stdout=pipe, stderr=self._stderr, env=room, start_new_session=True
        )

    def __enter__(self) -> Self:
        """Gives the process itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Ends the process, whatever it is at."""
        self._process.kill()
        if self._sending is not None:
            self._sending.join()
        self._process.communicate()
        self._stderr.close()

    def send(self, order: object) -> None:
        """Sends the order, which has to be picklable, without waiting until it is read; a worker takes only one."""
        sending = Thread(target=self._write, args=(pickle.dumps(order),), daemon=True)
        sending.start()
        self._sending = sending

    def _write(self, order: bytes) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(order)
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # it ended early: `receive` says so

    def receive(self) -> Any:
        """Waits for the next result.

        Raises:
            WorkerProcessError: The process ended before it; the text is the last that it said.
            Exception: What the work raised.
        """
        assert self._process.stdout is not None
        try:
            result = pickle.load(self._process.stdout)
        except (EOFError, pickle.UnpicklingError):
            self._process.wait()
            self._stderr.seek(0)
            said = self._stderr.read().decode(errors="replace").strip().splitlines()
            code = self._process.returncode
            ended = f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
            last = ": ".join([ended, *said[-1:]])
            raise WorkerProcessError(f"{self._module.rpartition('.')[2]}: {last}") from None
        if isinstance(result, Exception):
            raise result
        return result


def work(module: str, low_priority: bool) -> None:
    """Loads what the work needs, takes the order and sends the results, or what was raised: the other part."""
    if low_priority and hasattr(os, "nice"):  # not on Windows
        os.nice(LOW_PRIORITY)
    channel, sys.stdout = sys.stdout.buffer, sys.stderr  # what a library prints is no result
    try:
        work = import_module(module)
        for name in getattr(work, "LOADS", ()):
            import_module(name)
        results: Callable[[Any], Iterator[Any]] = work.results
        order = pickle.load(sys.stdin.buffer)
        Thread(target=_end_with_the_other, daemon=True).start()
        for result in results(order):
            pickle.dump(result, channel)
            channel.flush()
    except EOFError:
        return  # nobody wants it any more
    except Exception as error:
        pickle.dump(_carried(error), channel)
        channel.flush()


def _end_with_the_other() -> None:
    """Ends this process when the one that ordered is killed: it would go on filling a folder that nobody wants."""
    while os.read(sys.stdin.fileno(), 1):  # not through Python's own buffer, whose lock the interpreter's end wants
        pass
    os._exit(1)


def _carried(error: Exception) -> Exception:
    """The exception as it arrives, or its text where it does not survive pickling."""
    try:
        return pickle.loads(pickle.dumps(error))
    except Exception:
        return WorkerProcessError(f"{type(error).__name__}: {error}")
