"""The other core: what a page shows once its sliders rest, computed one piece after the other in a process of its own.

Pieces are short, and only those of the present setting are begun; a longer one ends at the next look at its flag.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from typing import Any

from optimizer.codesign.corrections import Corrections
from optimizer.codesign.hardware import Selection

_NICE = 5  # of 19: answers while a slider moves go first
_JOIN_S = 2.0
_RELIEF = (1.02, 1.05, 1.1, 1.2, 1.4, 1.8, 2.5, 4.0)  # factors by which a limit is eased, the least first


class AbandonedError(Exception):
    """The piece is not wanted any more."""


class StoppedError(Exception):
    """The process was ended, or died."""


@dataclass(frozen=True)
class Parts:
    """What the closed forms of the parts make of lengths.

    Attributes:
        choice: The hardware as they change it.
        corrections: What they ask of lengths.
        lengths_mm: (9) lengths that they pass; None where there are none.
        why: Why there are none; "".
    """

    choice: Selection
    corrections: Corrections | None
    lengths_mm: tuple[float, ...] | None
    why: str = ""


class Background:
    """A process that computes pieces, and is gone when this is closed."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._number = 0  # of the piece under way
        self._pipe, other = context.Pipe()
        flags, self._flag = context.Pipe(duplex=False)
        self._process = context.Process(target=_work, args=(other, flags), daemon=True)
        self._process.start()
        other.close()
        flags.close()

    def compute(self, piece: Callable[..., Any], *arguments: Any) -> Any:
        """Computes a piece and waits for it.

        Args:
            piece: A function of this module's list, called with a flag to look at, and the arguments.
            arguments: They have to be picklable.

        Raises:
            AbandonedError: `abandon` was called meanwhile.
            StoppedError: The process is gone.
            Exception: What the piece raised.
        """
        self._number += 1
        try:
            self._pipe.send((self._number, piece, arguments))
            result = self._pipe.recv()
        except (OSError, EOFError, ValueError) as error:
            raise StoppedError(str(error)) from None
        if isinstance(result, Exception):
            raise result
        return result

    def abandon(self) -> None:
        """Ends the piece under way at its next look."""
        with suppress(OSError):
            self._flag.send(self._number)

    def close(self) -> None:
        """Ends the process; who waits for a piece of it gets a `StoppedError`."""
        self._process.kill()
        self._process.join(_JOIN_S)


def _work(pipe: Connection, flags: Connection) -> None:
    """Computes pieces until nobody sends any."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the process that ends this one
    os.nice(_NICE)

    number = abandoned = 0

    def tick() -> None:
        nonlocal abandoned
        while flags.poll():
            abandoned = flags.recv()
        if abandoned >= number:
            raise AbandonedError

    with suppress(EOFError, OSError):
        while True:
            number, piece, arguments = pipe.recv()
            try:
                pipe.send(piece(tick, *arguments))
            except Exception as error:
                pipe.send(
                    error if isinstance(error, AbandonedError) else RuntimeError(f"{type(error).__name__}: {error}")
                )


Tick = Callable[[], None]


def cold(tick: Tick, task: Any, known: Corrections) -> Any:
    """Finds the lengths of a task from nothing; see `model.cold`."""
    from optimizer.studio import model

    return model.cold(task, known, tick)


def point(tick: Tick, found: Any, values: dict[str, float | None]) -> Any:
    """Finds the largest cube of a machine's task with other values of some fields, from its lengths."""
    from optimizer.studio import model

    task = replace(found.task, brief=found.brief.with_values(values))
    solver = model.Solver()
    solver.known[task.key] = found.corrections
    solver.last = replace(found, task=task, size=None)
    return solver.settle(task, tick)


def parts(tick: Tick, found: Any) -> Parts:
    """Holds lengths against the closed forms of the parts, and changes them until these pass; see `fixed_point`."""
    from optimizer.codesign.search import Search

    task = found.task
    search = Search(brief=task.brief, report=lambda _: tick(), stop=lambda: _ticked(tick))
    candidate = search.fixed_point(task.choice, found.lengths_mm, weighing=False)
    if candidate is None:
        why = next(iter(search.log.no_progress.values()), "the closed forms of its parts pass no lengths")
        return Parts(task.choice, None, None, why)
    return Parts(candidate.choice, replace(candidate.corrections, why=()), candidate.lengths_mm)


def _ticked(tick: Tick) -> bool:
    tick()
    return False


def relief(tick: Tick, task: Any, field: str, eases: int, known: Corrections) -> float | None:
    """Finds how far one limit has to give for a task to have lengths.

    Args:
        tick: Raises where nobody waits any more.
        task: A task without lengths.
        field: Table and field of the limit.
        eases: 1 where a larger value is easier to meet, -1 where a smaller one is.
        known: What is known of the hardware.

    Returns:
        The least change, of some, with which there are lengths; None where the largest has none.
    """
    from optimizer.studio import model

    own = task.brief.value(field)

    def enough(factor: float) -> bool:
        tick()
        value = own * factor if eases > 0 else own / factor
        return model.cold(replace(task, brief=task.brief.with_values({field: value})), known, tick) is not None

    low, high = -1, len(_RELIEF) - 1  # too little, and enough
    if not enough(_RELIEF[high]):
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if enough(_RELIEF[middle]) else (middle, high)
    return own * _RELIEF[high] if eases > 0 else own / _RELIEF[high]
