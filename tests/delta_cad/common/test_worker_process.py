"""Work beside: results in their order, what is raised and what is printed, an early end, and nothing left behind."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from delta_cad.common.worker_process import BEHIND, Beside, BesideError

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
    with Beside(__name__) as beside:
        beside.give(["loaded", "print", "x" * 1_000_000])
        assert beside.take() == [True]
        assert beside.take() != os.getpid()
        assert beside.take() == "x" * 1_000_000
        with pytest.raises(BesideError):
            beside.take()


def test_it_keeps_to_one_thread_and_goes_behind_where_it_is_told_to() -> None:
    for behind, rank in ((False, 0), (True, BEHIND)):
        with Beside(__name__, behind=behind) as beside:
            beside.give(["rank", "threads"])
            assert beside.take() == min(os.nice(0) + rank, 19)
            assert beside.take() == "1"


def test_what_the_work_raises_is_raised_here() -> None:
    with Beside(__name__) as beside:
        beside.give(["a", "refuse"])
        assert beside.take() == "a"
        with pytest.raises(ValueError, match="field = 3: must be <= 2"):
            beside.take()


def test_what_cannot_be_carried_is_told() -> None:
    with Beside(__name__) as beside:
        beside.give(["odd"])
        with pytest.raises(BesideError, match="_OddError: 1 and 2"):
            beside.take()


def test_an_early_end_is_told_with_the_last_word() -> None:
    with Beside(__name__) as beside:
        beside.give(["die"])
        with pytest.raises(BesideError, match="test_beside: ended with exit code 3: the last word"):
            beside.take()


def test_a_module_that_is_not_there_is_named() -> None:
    with Beside("delta_cad.no_such_module") as beside:
        beside.give([])
        with pytest.raises(ModuleNotFoundError, match="no_such_module"):
            beside.take()


def test_a_killed_process_is_told() -> None:
    with Beside(__name__) as beside:
        beside.give(["a", "sleep"])
        assert beside.take() == "a"
        beside._process.kill()
        with pytest.raises(BesideError, match="test_beside: ended by signal 9"):
            beside.take()


def test_the_work_ends_with_the_process_that_ordered_it() -> None:
    """The end of the pipe is all that a kill of that process closes."""
    with Beside(__name__) as beside:
        beside.give(["a", "sleep"])
        assert beside.take() == "a"
        assert beside._process.stdin is not None
        beside._process.stdin.close()
        assert beside._process.wait(timeout=60) == 1
        beside._process.stdin = None


def test_no_process_outlives_the_block() -> None:
    with Beside(__name__) as beside:
        process = Path(f"/proc/{beside._process.pid}")
        assert process.exists()
    assert not process.exists()
