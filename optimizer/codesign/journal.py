"""What a search computed, kept in a file: a run that was interrupted goes on from it to the same digits."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

from delta_cad.checks.report import CheckResult
from delta_cad.drive.masses import Masses
from optimizer.codesign.candidate import Start
from optimizer.codesign.choice import Choice
from optimizer.codesign.lengths import Found
from optimizer.codesign.lessons import Crowded, Lessons, Weighed
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


def found_told(found: Found | None) -> dict[str, Any] | None:
    """Gives lengths as JSON types."""
    return None if found is None else asdict(found)


def found_read(data: dict[str, Any] | None) -> Found | None:
    """Reads lengths that `found_told` gave."""
    return None if data is None else Found(**{**data, "lengths_mm": tuple(data["lengths_mm"])})


def start_told(start: Start | None) -> dict[str, Any] | None:
    """Gives where a search may begin as JSON types: of what is known that which is not as in the beginning."""
    if start is None:
        return None
    first, told = Lessons(start.lessons.weighed), asdict(start.lessons)
    lessons = {
        name: told[name] for name in told if name == "weighed" or getattr(start.lessons, name) != getattr(first, name)
    }
    return {"choice": asdict(start.choice), "lengths_mm": list(start.lengths_mm), "lessons": lessons}


def start_read(data: dict[str, Any] | None) -> Start | None:
    """Reads what `start_told` gave."""
    if data is None:
        return None
    lists: dict[str, Any] = data["lessons"]
    told: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in lists.items()}
    told["crowded"] = tuple(Crowded(*one) for one in told.get("crowded", ()))
    told["weighed"] = _weighed_read(told["weighed"])
    return Start(Choice(**data["choice"]), tuple(data["lengths_mm"]), Lessons(**told))


def results_told(results: list[CheckResult]) -> list[dict[str, Any]]:
    """Gives checks as JSON types."""
    return [result.to_json() for result in results]


def results_read(data: list[dict[str, Any]]) -> list[CheckResult]:
    """Reads checks that `results_told` gave."""
    found = []
    for one in data:
        tuples = {key: None if one[key] is None else tuple(one[key]) for key in ("worst_pose_mm", "worst_pair")}
        fields: dict[str, Any] = {**one, **tuples}
        found.append(CheckResult(**fields))
    return found


Told = tuple[Weighed, list[CheckResult], tuple[float, float]]
"""What solids weigh, the checks that this decides, and what their ball joints rub with."""


def weighed_told(made: Told) -> dict[str, Any]:
    """Gives a machine that was weighed as JSON types."""
    weighed, results, rubbed = made
    return {"weighed": asdict(weighed), "results": results_told(results), "rubbed": list(rubbed)}


def weighed_read(data: dict[str, Any]) -> Told:
    """Reads what `weighed_told` gave."""
    upright, level = data["rubbed"]
    return _weighed_read(data["weighed"]), results_read(data["results"]), (upright, level)


def _weighed_read(data: dict[str, Any]) -> Weighed:
    fields: dict[str, Any] = data | {"masses": Masses(**data["masses"])}
    return Weighed(**fields)
