"""Records of a run as lines of JSON, appended as they come: what a killed run leaves can be taken up."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from delta_cad.common.files import AppendLog, FileInUseError
from optimizer.search.genetic import Generation


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
    """What each phase of a run came to, and each generation of its GA, in a file."""

    def __init__(self, path: Path, key: dict[str, Any], resume: bool) -> None:
        """Opens the file; see `Records`."""
        self._done: dict[str, dict[str, Any]] = {}
        self._kept: dict[str, list[Generation]] = {}
        super().__init__(path, key, resume)

    def take(self, record: dict[str, Any]) -> None:
        """Takes up what a phase came to, or a generation of it."""
        phase = str(record["phase"])
        if "result" in record:
            self._done[phase] = dict(record["result"])
        else:
            arrays = {name: np.array(values, dtype=float) for name, values in record["generation"].items()}
            self._kept.setdefault(phase, []).append(Generation(**arrays))

    def finished(self, phase: str) -> dict[str, Any] | None:
        """Gives the result of a finished phase; None where it is not finished."""
        return self._done.get(phase)

    def finish(self, phase: str, data: dict[str, Any]) -> None:
        """Keeps what a phase came to."""
        self._done[phase] = data
        self.append({"phase": phase, "result": data})

    def generations(self, phase: str) -> Sequence[Generation]:
        """Gives the generations of a phase that were kept."""
        return list(self._kept.get(phase, []))

    def keep(self, phase: str, generation: Generation) -> None:
        """Keeps one more generation."""
        self._kept.setdefault(phase, []).append(generation)
        lists = {name: values.tolist() for name, values in generation._asdict().items()}
        self.append({"phase": phase, "generation": lists})


def _text(record: dict[str, Any]) -> str:
    return json.dumps(record, separators=(",", ":"), allow_nan=False)
