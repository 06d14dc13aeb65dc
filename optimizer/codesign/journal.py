"""What a search computed, kept in a file: a run that was interrupted goes on from it to the same digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from optimizer.synthesis.checkpoint import Checkpoint

T = TypeVar("T")


def at_once(_step: str, _of: object, compute: Callable[[], T], _kind: object) -> T:
    """Computes a step of a search that nobody keeps."""
    return compute()


class Journal(Checkpoint):
    """The steps of a search in a file, each under what it was computed from."""

    OTHER = "is of another run: requirements or seed differ"
