"""The phases of a run as lines of JSON, appended as they come: what a killed run leaves can be taken up."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from optimizer.genetic import Generation


class CheckpointError(ValueError):
    """A checkpoint that is not of this run."""


class Checkpoint:
    """A `Store` in a file.

    The first line is the run's key; each further line is one generation or what one phase came to. A last line that a
    kill cut off is left out. Numbers are written with all their digits, so that they come back to the last bit.

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
            CheckpointError: The file is of another run, or no checkpoint.
            OSError: It cannot be read or written.
        """
        self.path = path
        self._done: dict[str, dict[str, Any]] = {}
        self._kept: dict[str, list[Generation]] = {}
        lines = _whole_lines(path) if resume and path.exists() else []
        if lines:
            self._take_up(lines, key)
        path.parent.mkdir(parents=True, exist_ok=True)
        # what was cut off is cut away, so that the next line is whole
        path.write_text("".join(line + "\n" for line in lines or [_text({"key": key})]), encoding="utf-8")
        self._file: TextIO = path.open("a", encoding="utf-8")

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
        """Closes the file and takes it away: the run is done."""
        self.close()
        self.path.unlink(missing_ok=True)

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


def _whole_lines(path: Path) -> list[str]:
    text = path.read_text(encoding="utf-8", errors="replace")
    return text[: text.rfind("\n") + 1].splitlines()


def _text(record: dict[str, Any]) -> str:
    return json.dumps(record, separators=(",", ":"), allow_nan=False)
