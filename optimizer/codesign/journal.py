"""What a search computed, kept in a file: a run that was interrupted goes on from it to the same digits."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter

from delta_cad.checks.report import CheckResult
from optimizer.codesign.candidate import Start
from optimizer.codesign.lengths import Found
from optimizer.codesign.lessons import Weighed
from optimizer.synthesis.checkpoint import Records

T = TypeVar("T")
# What a reader raises of a step that was kept by another state of the code under the same version.
UNREAD = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)


def at_once(_step: str, _of: object, compute: Callable[[], T], _told: object, _read: object) -> T:
    """Computes a step of a search that nobody keeps."""
    return compute()


class Journal(Records):
    """The steps of a search in a file, each under what it was computed from."""

    OTHER = "is of another run: requirements or seed differ"

    def __init__(self, path: Path, key: dict[str, Any], resume: bool) -> None:
        """Opens the file; see `Records`."""
        self._done: dict[tuple[str, str], Any] = {}
        super().__init__(path, key, resume)

    def take(self, record: dict[str, Any]) -> None:
        """Takes up a step."""
        self._done[str(record["step"]), str(record["of"])] = record["result"]

    def once(
        self, step: str, of: object, compute: Callable[[], T], told: Callable[[T], Any], read: Callable[[Any], T]
    ) -> T:
        """Gives what a step came to, computed only if the file does not have it as this state of the code reads it.

        Args:
            step: Kind of step.
            of: What it is computed from; its text tells one from another.
            compute: The step.
            told: Its result as JSON types.
            read: The result from these.
        """
        key = step, sha256(repr(of).encode()).hexdigest()
        if key in self._done:
            with suppress(*UNREAD):
                return read(self._done[key])
        result = compute()
        self._done[key] = told(result)
        self.append({"step": step, "of": key[1], "result": self._done[key]})
        return result


def converters(kind: Any) -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    """Makes the functions that give results of a kind as JSON types, without what is at its default, and read them."""
    adapter: TypeAdapter[Any] = TypeAdapter(kind)
    return partial(adapter.dump_python, mode="json", exclude_defaults=True), adapter.validate_python


found_told, found_read = converters(Found | None)
start_told, start_read = converters(Start | None)
results_told, results_read = converters(list[CheckResult])
# What solids weigh, the checks that this decides, and what their ball joints rub with.
weighed_told, weighed_read = converters(tuple[Weighed, list[CheckResult], tuple[float, float]])
