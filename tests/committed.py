"""The committed design's file, the published optimum's, and what a build came to."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
BEST = ROOT / "best.json"
DATA: dict[str, Any] = json.loads(BEST.read_text())
PUBLISHED = Path(__file__).parent / "references" / "published-optimum.json"
"""The published optimum of [RCIM2018] table 12 with the same hardware: where the paper's figures are the oracle."""
PUBLISHED_DATA: dict[str, Any] = json.loads(PUBLISHED.read_text())


def changed(**values: Any) -> dict[str, Any]:
    """The committed design's data with some of them changed, as "section__field" or "section"."""
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
