"""The phases of a run as lines of JSON, appended as they come: what a killed run leaves can be taken up."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from optimizer.search.genetic import Generation


class CheckpointError(ValueError):
    """A checkpoint that is not of this run, or that another run is writing."""


class Checkpoint:
    """A `Store` in a file.

    The first line is the run's key; each further line is one generation or what one phase came to. A last line that a
    kill cut off is left out. Numbers are written with all their digits, so that they come back to the last bit.

    The file is locked as long as it is open, so that two runs never share one; the system releases the lock of a
    process that was killed.

    Attributes:
        path: The file.
    """

    def __init__(self, path: Path, key: dict[str, Any], resume: bool) -> None:
        """Opens the file.

        Args:
            path: The file.
            key: What makes a run the same run: requirements' hash, method, seed, steps and sizes.
            resume: Whether to take up what the file holds; else it is begun anew.

        Raises:
            CheckpointError: The file is of another run, or no checkpoint, or another run has it open; it is left as
                it is then.
            OSError: It cannot be read or written.
        """
        self.path = path
        self._done: dict[str, dict[str, Any]] = {}
        self._kept: dict[str, list[Generation]] = {}
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file: TextIO = _locked(path)
        try:
            lines = _whole_lines(path) if resume else []
            if lines:
                self._take_up(lines, key)
        except CheckpointError:
            self._file.close()
            raise
        # what was cut off is cut away, so that the next line is whole
        self._file.truncate(0)
        self._file.write("".join(line + "\n" for line in lines or [_text({"key": key})]))
        self._file.flush()

    def finished(self, phase: str) -> dict[str, Any] | None:
        """What a finished phase came to."""
        return self._done.get(phase)

    def finish(self, phase: str, data: dict[str, Any]) -> None:
        """Keeps what a phase came to."""
        self._done[phase] = data
        self._append({"phase": phase, "result": data})

    def generations(self, phase: str) -> Sequence[Generation]:
        """The generations of a phase that were kept."""
        return list(self._kept.get(phase, []))

    def keep(self, phase: str, generation: Generation) -> None:
        """Keeps one more."""
        self._kept.setdefault(phase, []).append(generation)
        told = {"objective": generation.objective.tolist(), "margins": generation.margins.tolist()}
        self._append({"phase": phase, "generation": told})

    def close(self) -> None:
        """Closes the file and leaves it."""
        self._file.close()

    def remove(self) -> None:
        """Takes the file away and closes it: the run is done."""
        if not self._file.closed:  # else it may be another run's by now
            self.path.unlink(missing_ok=True)
        self.close()

    def _append(self, record: dict[str, Any]) -> None:
        self._file.write(_text(record) + "\n")
        self._file.flush()

    def _take_up(self, lines: list[str], key: dict[str, Any]) -> None:
        try:
            records = [json.loads(line) for line in lines]
            if records[0]["key"] != json.loads(_text(key)):
                raise CheckpointError(
                    f"{self.path.name}: is of another run: requirements, method, seed, steps or sizes differ; "
                    "run without --resume to begin anew"
                )
            for record in records[1:]:
                if "result" in record:
                    self._done[record["phase"]] = record["result"]
                else:
                    told = record["generation"]
                    generation = Generation(np.array(told["objective"]), np.array(told["margins"]))
                    self._kept.setdefault(record["phase"], []).append(generation)
        except (json.JSONDecodeError, KeyError, TypeError):
            raise CheckpointError(f"{self.path.name}: is not a checkpoint") from None


def _locked(path: Path) -> TextIO:
    """The file, open at its end and locked; made if it is not there."""
    while True:
        file = path.open("a", encoding="utf-8")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.close()
            raise CheckpointError(
                f"{path.name}: another run is writing it; wait for it, or give another --out"
            ) from None
        try:
            if os.path.samestat(os.fstat(file.fileno()), path.stat()):
                return file
        except FileNotFoundError:
            pass  # the run that had it was done between opening and locking: the file is no longer in its folder
        file.close()


def _whole_lines(path: Path) -> list[str]:
    text = path.read_text(encoding="utf-8", errors="replace")
    return text[: text.rfind("\n") + 1].splitlines()


def _text(record: dict[str, Any]) -> str:
    return json.dumps(record, separators=(",", ":"), allow_nan=False)
