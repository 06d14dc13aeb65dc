"""The result of a check: its record, and its form in `checks.json`."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from math import isfinite
from typing import Any


@dataclass(frozen=True)
class CheckResult:
    """One check's verdict with the figure behind it.

    Attributes:
        name: What was checked, unique in a report.
        passed: Whether it holds.
        value: The figure that decides, in `unit`; None where there is none, or none that is finite.
        limit: What the value is held against, in `unit`; None where there is none.
        unit: Unit of value and limit, "" for counts.
        worst_pose_mm: Handle position that decides, base frame, mm.
        worst_pair: The occurrences, parts or joints that decide, by name.
        detail: One sentence or more for a person: method, counts, and on failure which and by how much.
        kind: Label of the check in `CHECKS` that found it, by which a page sums them up; "" elsewhere. Not recorded.
    """

    name: str
    passed: bool
    value: float | None
    limit: float | None
    unit: str
    worst_pose_mm: tuple[float, float, float] | None = None
    worst_pair: tuple[str, ...] | None = None
    detail: str = ""
    kind: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        """Plain Python numbers instead of NumPy's, so that records compare and print alike; an infinite one is none."""
        object.__setattr__(self, "passed", bool(self.passed))
        for name in ("value", "limit"):
            number = getattr(self, name)
            object.__setattr__(self, name, None if number is None or not isfinite(number) else float(number))

    def to_json(self) -> dict[str, Any]:
        """Gives the record as JSON types, keys as the attributes; `kind` is left out."""
        record = asdict(self)
        del record["kind"]
        for key in ("worst_pose_mm", "worst_pair"):
            record[key] = None if record[key] is None else list(record[key])
        return record


def all_passed(results: Iterable[CheckResult]) -> bool:
    """Decides whether every check of a report holds."""
    return all(result.passed for result in results)


def grouped(results: Iterable[CheckResult]) -> dict[str, list[CheckResult]]:
    """Gathers results under their name without the numbers of chain, side and copy."""
    groups: dict[str, list[CheckResult]] = {}
    for result in results:
        name = re.sub(r"(?<=[a-z])(_[0-9em])+(?=_|\b)", "", result.name)
        name = "solids" if name.startswith("solid ") else name
        groups.setdefault(name, []).append(result)
    return groups


def closeness(result: CheckResult) -> tuple[bool, float]:
    """Gives a key by which failures come first, then what is closest to its limit."""
    if result.value is None or result.limit is None:
        return (result.passed, 0.0)
    return (result.passed, abs(result.value - result.limit))
