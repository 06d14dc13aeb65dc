"""The machine that the tests know, the published optimum, what a build came to, and what test workers share."""

from __future__ import annotations

import fcntl
import json
import pickle
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

Made = TypeVar("Made")
ROOT = Path(__file__).parents[1]
COMMITTED = ROOT / "best.json"
BEST = ROOT / "examples" / "synthesized.json"
"""The machine whose figures the tests know: `best.json` is whatever `design` finds best, and is looked at by itself."""
DATA: dict[str, Any] = json.loads(BEST.read_text())
PUBLISHED = Path(__file__).parent / "references" / "published-optimum.json"
"""The published optimum of [RCIM2018] table 12 with the same hardware: where the paper's figures are the oracle."""
PUBLISHED_DATA: dict[str, Any] = json.loads(PUBLISHED.read_text())


def changed(**values: Any) -> dict[str, Any]:
    """That machine's data with some of them changed, as "section__field" or "section"."""
    data = deepcopy(DATA)
    for name, value in values.items():
        section, _, field = name.partition("__")
        if field:
            data[section][field] = value
        else:
            data[section] = value
    return data


@dataclass(frozen=True)
class Built:
    """What a build from the command line came to."""

    code: int
    stdout: str
    stderr: str
    folder: Path

    @property
    def record(self) -> dict[str, Any]:
        return json.loads(self.stdout)


@dataclass(frozen=True)
class Shared:
    """What several test workers want, made by the first that asks for it while the others wait."""

    folder: Path

    def once(self, name: str, make: Callable[[], Made]) -> Made:
        """Makes something that can be pickled, or takes what was made."""
        kept = self.folder / f"{name}.pickle"
        with open(self.folder / f"{name}.lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not kept.exists():
                kept.write_bytes(pickle.dumps(make()))
        return pickle.loads(kept.read_bytes())
