"""Work beside: results in their order, what is raised and what is printed, an early end, and nothing left behind."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from delta_cad.common.worker_process import LOW_PRIORITY, WorkerProcess, WorkerProcessError

LOADS = ("json.tool",)


def results(order: list[str]) -> Iterator[object]:
    """What the tests ask of the other process, word by word."""
    for word in order:
        if word == "loaded":
            yield [name in sys.modules for name in LOADS]
        elif word == "print":
            print("a library speaks")
            yield os.getpid()
        elif word == "rank":
            yield os.nice(0)
        elif word == "threads":
            yield os.environ["OPENBLAS_NUM_THREADS"]
        elif word == "refuse":
            raise ValueError("field = 3: must be <= 2")
        elif word == "odd":
            raise _OddError(1, 2)
        elif word == "sleep":
            time.sleep(600.0)
        elif word == "die":
            print("the last word", file=sys.stderr, flush=True)
            os._exit(3)
        else:
            yield word


class _OddError(Exception):
    def __init__(self, one: int, other: int) -> None:
        super().__init__(f"{one} and {other}")


def test_results_come_in_their_order_and_what_is_printed_is_none() -> None:
    with WorkerProcess(__name__) as adjacent:
        adjacent.send(["loaded", "print", "x" * 1_000_000])
        assert adjacent.receive() == [True]
        assert adjacent.receive() != os.getpid()
        assert adjacent.receive() == "x" * 1_000_000
        with pytest.raises(WorkerProcessError):
            adjacent.receive()


def test_it_keeps_to_one_thread_and_goes_behind_where_it_is_ordered_to() -> None:
    for low, rank in ((False, 0), (True, LOW_PRIORITY)):
        with WorkerProcess(__name__, low_priority=low) as adjacent:
            adjacent.send(["rank", "threads"])
            assert adjacent.receive() == min(os.nice(0) + rank, 19)
            assert adjacent.receive() == "1"


def test_what_the_work_raises_is_raised_here() -> None:
    with WorkerProcess(__name__) as adjacent:
        adjacent.send(["a", "refuse"])
        assert adjacent.receive() == "a"
        with pytest.raises(ValueError, match="field = 3: must be <= 2"):
            adjacent.receive()


def test_what_cannot_be_carried_is_reported() -> None:
    with WorkerProcess(__name__) as adjacent:
        adjacent.send(["odd"])
        with pytest.raises(WorkerProcessError, match="_OddError: 1 and 2"):
            adjacent.receive()


def test_an_early_end_is_reported_with_the_last_word() -> None:
    with WorkerProcess(__name__) as adjacent:
        adjacent.send(["die"])
        with pytest.raises(WorkerProcessError, match="test_worker_process: ended with exit code 3: the last word"):
            adjacent.receive()


def test_a_module_that_is_not_there_is_named() -> None:
    with WorkerProcess("delta_cad.no_such_module") as adjacent:
        adjacent.send([])
        with pytest.raises(ModuleNotFoundError, match="no_such_module"):
            adjacent.receive()


def test_a_killed_process_is_reported() -> None:
    with WorkerProcess(__name__) as adjacent:
        adjacent.send(["a", "sleep"])
        assert adjacent.receive() == "a"
        adjacent._process.kill()
        with pytest.raises(WorkerProcessError, match="test_worker_process: ended by signal 9"):
            adjacent.receive()


def test_the_work_ends_with_the_process_that_ordered_it() -> None:
    """The end of the pipe is all that a kill of that process closes."""
    with WorkerProcess(__name__) as adjacent:
        adjacent.send(["a", "sleep"])
        assert adjacent.receive() == "a"
        assert adjacent._process.stdin is not None
        adjacent._process.stdin.close()
        assert adjacent._process.wait(timeout=60) == 1
        adjacent._process.stdin = None


def test_no_process_outlives_the_block() -> None:
    with WorkerProcess(__name__) as adjacent:
        process = Path(f"/proc/{adjacent._process.pid}")
        assert process.exists()
    assert not process.exists()
