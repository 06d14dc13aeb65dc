"""What a search went through."""

from __future__ import annotations

from dataclasses import dataclass, field

from delta_cad.design import Design
from optimizer.codesign.choice import Choice


@dataclass(frozen=True)
class Posed:
    """A candidate.

    Attributes:
        choice: Its hardware.
        score: What is sought, larger is better.
        failed: Of a machine that was made the checks that fail; None: nobody made it.
    """

    choice: Choice
    score: float
    failed: tuple[str, ...] | None = None


@dataclass
class Tried:
    """What a search went through.

    Attributes:
        candidates: Number of candidates that were posed.
        posed: Those of them that have lengths, and the machines that were made, in order.
        built: Machines that were made: design, and the names of the checks that failed.
        stuck: Hardware -> why it was given up.
    """

    candidates: int = 0
    posed: list[Posed] = field(default_factory=list)
    built: list[tuple[Design, tuple[str, ...]]] = field(default_factory=list)
    stuck: dict[str, str] = field(default_factory=dict)
