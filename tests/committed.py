"""The committed design's file, and what its build came to."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

BEST = Path(__file__).parents[1] / "best.json"


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
