"""The history of a search, the resulting verdict, and the journal from which an interrupted search continues."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, Literal, NamedTuple, TypeVar

from delta_cad.checks.report import CheckResult
from delta_cad.common.console import CUT_SHORT, DONE, NOT_MET, Step
from delta_cad.design import Design
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.hardware import Selection
from optimizer.synthesis.checkpoint import Checkpoint

T = TypeVar("T")


@dataclass(frozen=True)
class Trial:
    """A candidate.

    Attributes:
        choice: Its hardware.
        score: What is sought, larger is better.
        failed: Of a machine that was made the checks that fail; None: nobody made it.
    """

    choice: Selection
    score: float
    failed: tuple[str, ...] | None = None


@dataclass
class Built:
    """A build, as a run that goes on takes it over.

    Attributes:
        results: All checks.
        facts: Of a machine that passes; else {}.
        remarks: What the time left undone.
    """

    results: list[CheckResult]
    facts: dict[str, Any]
    remarks: list[str]


@dataclass
class SearchLog:
    """What a search went through; hardware is named "motor drive".

    Attributes:
        candidates: Number of candidates that were posed.
        trials: Those of them that have lengths, and the machines that were made, in order.
        built: Machines that were made: design, and the names of the checks that failed.
        no_progress: Hardware -> why it was given up.
        inconclusive: Hardware of which a candidate failed in a way that shows nothing of others.
        placed: What placed chains came to, before a machine was made, a line each.
        left: Hardware that was not looked at to its end.
        impossible: Bounds, by closed form or proof, that no machine of any hardware meets.
    """

    candidates: int = 0
    trials: list[Trial] = field(default_factory=list)
    built: list[tuple[Design, tuple[str, ...]]] = field(default_factory=list)
    no_progress: dict[str, str] = field(default_factory=dict)
    inconclusive: set[str] = field(default_factory=set)
    placed: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    impossible: list[str] = field(default_factory=list)

    def ended(self, hardware: str) -> None:
        """Notes that hardware was looked at to its end."""
        self.left = [one for one in self.left if one != hardware]

    def with_passed(self, machine: Candidate, design: Design) -> SearchLog:
        """Adds a machine that passes every check, last, with its design as written; its hardware is no longer stuck."""
        name = f"{machine.choice.motor} {machine.choice.drive}"
        return replace(
            self,
            built=[*self.built, (design, ())],
            trials=[*self.trials, Trial(machine.choice, machine.score, ())],
            no_progress={hardware: why for hardware, why in self.no_progress.items() if hardware != name},
        )

    @property
    def reasons(self) -> list[str]:
        """Why there is no machine of any hardware that was looked at, a line each."""
        return self.impossible or [f"{hardware}: {why}" for hardware, why in self.no_progress.items()]


def worded(objective: str, score: float) -> str:
    """Says what a score of an objective is."""
    words = {"cube_side": f"{score:.2f} mm of cube", "cost": f"{-score:.0f} EUR"}
    words["effective_mass"] = f"{-score:.4g} kg effective mass"
    return words.get(objective, f"{-score:.2f} mm of width and depth")


class Phase(NamedTuple):
    """Where a search is: its step, and how much of that is done."""

    name: str
    number: int
    done: int = 0
    total: int = 0
    of: int = 4

    def step(self, words: str, log: SearchLog, objective: str, ready: float | None) -> Step:
        """Step of progress, with `best_so_far`, which an eased task does not have."""
        best = "" if self.of == NEAREST.of else best_so_far(log, objective, ready, self.number <= PARTS.number)
        return Step(words, self.name, self.number, self.of, self.done, self.total, best)


ESTIMATES = Phase("estimates of motors", 1)
PARTS = Phase("parts of the likeliest motors", 2)
REFINEMENT = Phase("ratio, lengths, placement", 3)
BUILDING = Phase("checks and files of a machine", 4)
# Where no machine does all that is required.
RELAXATIONS = Phase("limits whose change suffices", 1, of=2)
NEAREST = Phase("nearest machine", 2, of=2)


def best_so_far(log: SearchLog, objective: str, ready: float | None, estimating: bool) -> str:
    """Says what a search has come to: its best machine, else a candidate, else an estimate; "" where there is none.

    Args:
        log: Its history.
        objective: What is sought.
        ready: Score of the candidate that closed forms and its masses pass; None: none.
        estimating: Whether estimates are all there is; what is refined or built comes to less.
    """
    passed = [trial.score for trial in log.trials if trial.failed == ()]
    if passed:
        return f"{worded(objective, max(passed))}, built"
    if ready is not None:
        return f"{worded(objective, ready)} by closed forms"
    estimated = [trial.score for trial in log.trials] if estimating else []
    return f"about {worded(objective, max(estimated))}" if estimated else ""


class Verdict(Enum):
    """How a search ended: its name, and the exit code of the command."""

    BUILT = "built", DONE
    INFEASIBLE = "infeasible", NOT_MET
    NOT_FOUND = "not found in time", CUT_SHORT
    STOPPED = "stopped", CUT_SHORT

    def __str__(self) -> str:
        return self.value[0]

    @property
    def code(self) -> int:
        """Exit code."""
        return self.value[1]


End = Literal["done", "time", "stopped"]
"""What ended a search: itself, its time, or Ctrl-C."""


def verdict(log: SearchLog, end: End, stands: bool) -> tuple[Verdict, str]:
    """Decides how a search ended.

    That no machine exists is shown before the search: by closed forms or a proof, and for placed chains by a search,
    which the message says is no proof. A search that went through all hardware to its end without a machine has the
    same verdict, and says that it is no proof: lengths are searched locally. Time that was over, or candidates that the
    search did not know how to mend, leave it open.

    Returns:
        The verdict, and what it rests on, or what was left open; "" where a machine stands.
    """
    left = f"not fully searched: {', '.join(log.left)}" if log.left else ""
    if end == "stopped":
        return Verdict.STOPPED, left
    if stands:
        return Verdict.BUILT, ""
    if log.impossible:
        return Verdict.INFEASIBLE, log.impossible[0]
    if left:
        return Verdict.NOT_FOUND, left
    if log.inconclusive or not log.no_progress:
        return Verdict.NOT_FOUND, f"no further candidate to try of {', '.join(sorted(log.inconclusive))}"
    return (
        Verdict.INFEASIBLE,
        f"none of {len(log.no_progress)} motors and drives has a machine; no proof, as lengths are local optima",
    )


def unmemoized(_step: str, _of: object, compute: Callable[[], T], _kind: object) -> T:
    """Computes a step of a search that nobody keeps."""
    return compute()


class Journal(Checkpoint):
    """The steps of a search in a file, each under what it was computed from."""

    OTHER = "is of another run: requirements or seed differ, or another version of the program wrote it"
