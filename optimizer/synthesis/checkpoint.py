"""Records of a run as lines of JSON, appended as they come: a killed run goes on from them to the same digits."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar
from zlib import crc32

from pydantic import TypeAdapter, ValidationError

from delta_cad.common.files import AppendLog, FileInUseError

T = TypeVar("T")


class CheckpointError(ValueError):
    """A checkpoint that is damaged, is not of this run, or that another run is writing."""


class Records:
    """JSON records in a file that one run at a time appends to, under the key of the run.

    The first line is the key, each further line a record with the CRC-32 of its text. Numbers are written with all
    their digits, so that they come back to the last bit. A last line that a kill cut off is left out; any other line
    that is not as it was written refuses the file, so that who reads the records need not doubt their shape.

    Attributes:
        path: The file.
        found: The records that were taken up.
    """

    OTHER = "is of another run: requirements, method, seed, steps or sizes differ"

    def __init__(self, path: Path, key: dict[str, Any], resume: bool) -> None:
        """Opens the file.

        Args:
            path: The file.
            key: What makes a run the same run, as JSON types.
            resume: Whether to take up what the file holds; else it is begun anew.

        Raises:
            CheckpointError: The file is of another run, or damaged, or another run has it open; it is left as it is
                then.
            OSError: It cannot be read or written.
        """
        self.path, self.found = path, list[dict[str, Any]]()
        try:
            self._lines = AppendLog(path)
        except FileInUseError:
            raise CheckpointError(
                f"{path.name}: another run is writing it; wait for it, or give another --out"
            ) from None
        try:
            if resume and self._lines.found:
                self._take_up(_text({"key": key}))
            else:
                self._lines.begin([_text({"key": key})])
        except BaseException:
            self.close()
            raise

    def take(self, record: dict[str, Any]) -> None:
        """Takes up a record of the file; what it raises of a record without its fields refuses the file."""
        self.found.append(record)

    def append(self, record: dict[str, Any]) -> None:
        """Keeps one more record; a kill after this does not lose it."""
        text = _text(record)
        self._lines.append(f'{{"crc32":{crc32(text.encode())},"record":{text}}}')

    def close(self) -> None:
        """Closes the file and leaves it."""
        self._lines.close()

    def remove(self) -> None:
        """Takes the file away and closes it: the run is done."""
        self._lines.remove()

    def _take_up(self, key: str) -> None:
        same = True
        for number, line in enumerate(self._lines.found, 1):
            try:
                data = json.loads(line)
                if number == 1:
                    same = _text({"key": data["key"]}) == key
                elif crc32(_text(data["record"]).encode()) == data["crc32"]:
                    self.take(data["record"])
                else:
                    raise ValueError
            except (ArithmeticError, AttributeError, KeyError, RecursionError, TypeError, ValueError):
                raise self._refused(f"is not a checkpoint, or is damaged in line {number}") from None
            if not same:
                raise self._refused(self.OTHER)

    def _refused(self, why: str) -> CheckpointError:
        return CheckpointError(f"{self._lines.path.name}: {why}; run without --resume to begin anew")


class Checkpoint(Records):
    """What the steps of a run came to, in a file, each under what it was computed from."""

    def __init__(self, path: Path, key: dict[str, Any], resume: bool) -> None:
        """Opens the file; see `Records`."""
        self._done: dict[tuple[str, str], tuple[Any]] = {}
        super().__init__(path, key, resume)

    def take(self, record: dict[str, Any]) -> None:
        """Takes up a step."""
        self._done[str(record["step"]), str(record["of"])] = (record["result"],)

    def finished(self, step: str, of: object = None) -> Any:
        """Gives what a step came to as JSON types; None where it is not kept."""
        return self._done.get(_key(step, of), (None,))[0]

    def finish(self, step: str, result: Any, of: object = None) -> None:
        """Keeps what a step came to, of JSON types."""
        key = _key(step, of)
        self._done[key] = (result,)
        self.append({"step": step, "of": key[1], "result": result})

    def memoize(
        self, step: str, of: object, compute: Callable[[], T], kind: Any, keeps: Callable[[T], bool] = lambda _: True
    ) -> T:
        """Gives the result of a step, computed only if the file does not have it as this state of the code writes it.

        Args:
            step: Kind of step.
            of: What it is computed from; its text tells one from another.
            compute: The step.
            kind: Type of its result: records, lists, tuples and numbers, by which it is written and read.
            keeps: Whether a result that was computed is kept.
        """
        if (kept := self._done.get(_key(step, of))) is not None:
            with suppress(ValidationError):  # of another state of the code under the same version
                result: T = _form(kind).validate_python(kept[0])
                if as_json(result, kind) == kept[0]:
                    return result
        result = compute()
        if keeps(result):
            self.finish(step, as_json(result, kind), of)
        return result


def _key(step: str, of: object) -> tuple[str, str]:
    return step, sha256(repr(of).encode()).hexdigest()


def remembered(store: Checkpoint | None, step: str, compute: Callable[[], T], kind: Any = Any, of: object = None) -> T:
    """Takes the result of a step from a store, or computes and keeps it; None, of a step that was stopped, is not kept.

    Args:
        store: Keeps steps; None keeps nothing.
        step: Name of the step.
        compute: The step.
        kind: Type of its result.
        of: What it is computed from, beside the run's key.
    """
    return compute() if store is None else store.memoize(step, of, compute, kind, lambda result: result is not None)


def as_json(result: object, kind: Any) -> Any:
    """Gives a result of a type as JSON types, without what has its default."""
    return _form(kind).dump_python(result, mode="json", exclude_defaults=True)


@cache
def _form(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def _text(record: dict[str, Any]) -> str:
    return json.dumps(record, separators=(",", ":"), allow_nan=False)
