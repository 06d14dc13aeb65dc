"""The clock of a search, which stops while other programs have the processor."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import monotonic

_SCHEDULER = Path("/proc/self/schedstat")
"""Of Linux, for the first thread of the process: ns run, ns ready to run but waiting for a processor, slices."""
LEAST = 0.25
"""Share of the time on the wall that counts at least, so that a run ends however crowded the processor is."""


class OutOfTimeError(Exception):
    """The time of a search is over, or it is to stop; what it computed stays."""


class HalfTimeError(Exception):
    """Half of the time is over without a machine: what could be built is built before anything is improved."""


def waited_s(file: Path = _SCHEDULER) -> float:
    """Reads how long this process was ready to run and did not, s; 0 where the system does not say."""
    try:
        return int(file.read_text(encoding="ascii").split()[1]) / 1e9
    except (OSError, ValueError, LookupError):
        return 0.0


class SearchClock:
    """Seconds since its making, without those in which the process waited for a processor.

    On an idle machine it is the clock on the wall; elsewhere it is slower, but never below `LEAST` of that one. What a
    second process of the search waits for its processor counts.

    Args:
        now: Clock on the wall, s.
        waited: Time waited for a processor since the process began, s.
    """

    def __init__(self, now: Callable[[], float] = monotonic, waited: Callable[[], float] = waited_s) -> None:
        self._now, self._waited = now, waited
        self._begun = now(), waited()

    def __call__(self) -> float:
        """Reads it, s."""
        wall, waited = self._now() - self._begun[0], self._waited() - self._begun[1]
        return max(wall - waited, LEAST * wall)
