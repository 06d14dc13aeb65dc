"""What a search computed, kept in a file: a run that was interrupted goes on from it to the same digits."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from optimizer.synthesis.checkpoint import Records

T = TypeVar("T")


def unmemoized(_step: str, _of: object, compute: Callable[[], T], _kind: object) -> T:
    """Computes a step of a search that nobody keeps."""
    return compute()


class Journal(Records):
    """The steps of a search in a file, each under what it was computed from."""

    OTHER = "is of another run: requirements or seed differ"

    def __init__(self, path: Path, key: dict[str, Any], resume: bool) -> None:
        """Opens the file; see `Records`."""
        self._done: dict[tuple[str, str], tuple[Any]] = {}
        super().__init__(path, key, resume)

    def take(self, record: dict[str, Any]) -> None:
        """Takes up a step."""
        self._done[str(record["step"]), str(record["of"])] = (record["result"],)

    def memoize(self, step: str, of: object, compute: Callable[[], T], kind: Any) -> T:
        """Gives the result of a step, computed only if the file does not have it as this state of the code writes it.

        Args:
            step: Kind of step.
            of: What it is computed from; its text tells one from another.
            compute: The step.
            kind: Type of its result: dataclasses, lists, tuples and numbers, by which it is written and read.
        """
        key = step, sha256(repr(of).encode()).hexdigest()
        if (kept := self._done.get(key)) is not None:
            with suppress(ValidationError):  # of another state of the code under the same version
                result: T = _form(kind).validate_python(kept[0])
                if as_json(result, kind) == kept[0]:
                    return result
        result = compute()
        self._done[key] = (as_json(result, kind),)
        self.append({"step": step, "of": key[1], "result": self._done[key][0]})
        return result


def as_json(result: object, kind: Any) -> Any:
    """Gives a result of a type as JSON types, without what has its default."""
    return _form(kind).dump_python(result, mode="json", exclude_defaults=True)


@cache
def _form(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)
