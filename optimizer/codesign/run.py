"""Runs a search within its time, builds its machines into their folder, and the nearest one if there is none."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from delta_cad.checks.report import CheckResult
from delta_cad.commands import pipeline
from delta_cad.commands.pipeline import Moved, Outcome
from delta_cad.common.console import Request
from delta_cad.design import NAME_LONGEST, Design, DesignError, design_hash, load_design
from optimizer.codesign import bound, candidate, relaxation, report, search_log
from optimizer.codesign.bound import Bound, Family
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.corrections import Corrections
from optimizer.codesign.hardware import direct_alternative
from optimizer.codesign.search import Search
from optimizer.codesign.search_log import Built
from optimizer.codesign.updates import with_least_radius
from optimizer.problem.brief import DesignBrief
from optimizer.search.clock import OutOfTimeError

_UNHURRIED = 0.5  # share of the time in which ratio and width are improved before any machine stands
GRACE_S = 20.0  # beyond the time, in which a build that was begun may come to its bound
_BOUND_S, _BOUND_MOST_S = 80.0, 300.0  # for a machine's bound, and where it is not close by then
_OTHERS_SHARE = 0.05  # of the time: for the bound of symmetric machines beside one with placed chains
_STATED = 0.5  # share by which a bound may exceed its machine, and still be stated
HURRIED = "half of the time had gone without a machine: ratio, pinion and width were not improved to the end"
NO_DIRECT_DRIVE = "half of the time had gone: no direct drive was tried in place of the capstan, --minutes gives more"
NO_BOUND = "no useful bound on the cubes of this family was proved in its share of the time"
_NEAREST, _NEAREST_NAME = 2, "-nearest"  # eased tasks of which one is built, and the end of its name
_EASIER = (1.0, 1.12, 1.25, 1.5)  # factors by which what gives does so once more, where no machine of it passes


@dataclass
class Run:
    """Time, place and progress of a search.

    Attributes:
        out: Folder of the folders of machines.
        seed: Of everything random.
        command: The one that gives the same design, in the folder of the requirements file.
        limit_s: The time that it has.
        clock: Seconds that count, since it began.
        memoize: Keeps what was computed, as `Journal.memoize` does.
        show: Progress: what is being done.
        keep: Progress: what was found.
        closing_s: The longest that a build of it took after its bound, as measured.
    """

    out: Path
    seed: int
    command: str
    limit_s: float
    clock: Callable[[], float]
    memoize: Callable[..., Any]
    show: Callable[[str], None]
    keep: Callable[[str], None]
    closing_s: float = 0.0

    def over(self, ahead_s: float = 0.0, share: float = 1.0) -> bool:
        """Whether so much of the time is over, so many seconds from now."""
        return self.clock() + ahead_s > share * self.limit_s


class Builder:
    """Builds the machines of a task into their folder.

    Attributes:
        facts: Of the machine that passes and stands; {} before there is one.
        search: The search whose machines these are.
    """

    def __init__(self, run: Run, brief: DesignBrief, bounding: bool = True) -> None:
        """Makes it.

        Args:
            run: The run.
            brief: The requirements of the task.
            bounding: Whether a bound on the cubes of a machine's family is sought.
        """
        self._run, self._brief, self._bounding = run, brief, bounding
        self._moved: dict[str, Moved] = {}  # of the last machine that moved, which a build then takes over
        self._closes_s: float | None = None  # when the bound of the build under way ended, which is ended from then on
        self._stopped = False  # by hand while the bound was sought: the machine is written first
        self.facts: dict[str, Any] = {}
        self.search = Search(
            brief=brief,
            build=self._built,
            moving=self._moving,
            seed=run.seed,
            stop=run.over,
            hurried=self._hurried,
            report=run.show,
            tell=run.keep,
            memoize=run.memoize,
        )

    def _hurried(self) -> bool:
        return not self.facts and self._run.over(share=_UNHURRIED)

    def _goes_on(self, step: str) -> None:
        if self._closes_s is None and self._run.over(-GRACE_S):
            raise OutOfTimeError
        self._run.show(step)

    def _moving(self, design: Design) -> list[CheckResult]:
        of, begin = design_hash(design), self.search.begin

        def compute() -> list[CheckResult]:
            self._moved = {of: pipeline.check_moving(candidate.solid(design, begin), begin)}
            return self._moved[of].results

        return self._run.memoize("moving", of, compute, list[CheckResult])

    def _bound(self, machine: Candidate, known: Corrections) -> Bound | None:
        """What no machine of the family exceeds, as far as there is time for it; None where that says nothing."""
        run, at, choice = self._run, self._run.clock(), machine.choice
        kept = self.search.corrections | {(choice.motor, choice.drive): with_least_radius(machine, known)}
        # a placed machine belongs to no symmetric family: the proof need not go below its cube
        side_mm = machine.side_mm / (1.0 + bound.GAP if choice.placed else 1.0)
        most_s = _OTHERS_SHARE * run.limit_s if choice.placed else _BOUND_MOST_S
        try:
            with Request() as required:
                found = bound.bounded(
                    Family(self._brief, machine, kept),
                    side_mm,
                    lambda: required() or run.over(run.closing_s) or run.clock() > at + most_s,
                    run.show,
                    lambda: run.clock() > at + _BOUND_S,
                )
                self._stopped = required()
        except KeyboardInterrupt:
            self._stopped = True
            return None
        if found.gap > _STATED:
            return None
        return replace(found, placed_mm=machine.side_mm) if choice.placed else found

    def _built(self, design: Design) -> Outcome:
        """Builds a machine, or reuses that of an earlier run if it has no remark."""
        run, folder = self._run, self._run.out / self._brief.name
        stated = report.with_provenance(design, self._brief, run.command, run.seed)
        remarks, begun = [HURRIED] if self._hurried() else [], list[Built]()

        def compute() -> Built:
            built = Built([], {}, [*remarks])
            begun.append(built)
            for remark in remarks:
                run.keep(remark)
            machine, self._closes_s = None, None
            if (moved := self._moved.get(design_hash(design))) is not None:  # else it is a run that goes on
                machine = candidate.solid(design, self._goes_on)
                machine = replace(machine, dimensions=replace(machine.dimensions, design=stated))
            outcome = pipeline.build(
                stated,
                run.out,
                self._goes_on,
                adjacent=lambda folder, outcome: self._write(stated, built, folder, outcome),
                made=machine,
                clearance=moved and moved.clearance,
            )
            if self._closes_s is not None:
                run.closing_s = max(run.closing_s, run.clock() - self._closes_s)
            built.results = outcome.results
            return built

        built = run.memoize("built", design_hash(stated), compute, Built)
        if built.facts and not begun and not (built.remarks == remarks and _stands(folder, stated)):
            built = compute()
        self.facts.update(built.facts)
        if self._stopped:
            raise KeyboardInterrupt
        return Outcome(stated, built.results, {}, folder, (), built.facts.get("cost_EUR"))

    def _write(self, stated: Design, built: Built, folder: Path, outcome: Outcome) -> None:
        """Writes the design among the files of a build and, of one that passes, bound, certificate and pages."""
        run, brief, search, built_candidate = self._run, self._brief, self.search, self.search.built_candidate
        if not outcome.passed or built_candidate is None:
            report.write_design(folder, report.placed(stated, brief, folder))  # to build it again and see what fails
            return
        run.show("what each limit costs")
        key = built_candidate.choice.motor, built_candidate.choice.drive
        known, log = search.corrections[key], search.log.with_passed(built_candidate, stated)
        costs = relaxation.costs(brief, built_candidate, known)
        symmetric, _ = search.symmetric.get(key, (None, None))
        run.show("certificate")
        certificate = report.certificate_of(stated, folder / "mass_properties.json")
        proved = None
        if brief.objective == "cube_side" and self._bounding:
            proved = self._bound(built_candidate, known)
            if proved is None:
                built.remarks.append(NO_BOUND)
        run.show("direct drive in place of the capstan")
        left_out = stated.hardware.drive != "direct" and self._hurried()
        alternative = NO_DIRECT_DRIVE if left_out else direct_alternative(brief, stated)
        self._closes_s = run.clock()
        placement = report.placement_of(brief, built_candidate, symmetric)
        built.facts = report.facts_of(brief, outcome, log, proved, placement)
        notes = *brief.notes, *built.remarks, *filter(None, (alternative,))
        found = report.DesignReport(brief, built.facts, log, known.why, notes, costs, proved)
        found.write(folder, report.placed(stated, brief, run.out / brief.name), certificate)


def _stands(folder: Path, design: Design) -> bool:
    """Decides whether a folder holds the machine of a design."""
    try:
        return design_hash(load_design(folder / "design.json")) == design_hash(design)
    except DesignError:
        return False


def nearest_machine(
    run: Run, search: Search, say: Callable[[str], None], eased: list[str], facts: dict[str, Any]
) -> None:
    """Finds the limits of which each would be enough to give, and builds the machine of the least change.

    Args:
        run: The run.
        search: The search that found no machine.
        say: Prints what was found at once.
        eased: Gets what would be enough, a line each.
        facts: Gets those of the machine that was built.
    """
    found = relaxation.minimal_relaxations(search)
    eased += map(str, found)
    for words in eased:
        say(f"closed forms have a machine with {words}")
    corrections: dict[tuple[str, ...], dict[tuple[str, str], Corrections]] = {}  # what failed teaches holds of the next
    name = f"{search.brief.name[: NAME_LONGEST - len(_NEAREST_NAME)]}{_NEAREST_NAME}"
    with suppress(OutOfTimeError):
        for one in [one.further(factor) for factor in _EASIER for one in found[:_NEAREST]]:
            builder = Builder(run, one.brief.model_copy(update={"name": name}), bounding=False)
            choice, known = one.start.choice, replace(one.start.corrections, why=())
            near, builder.facts = builder.search, facts
            near.finely, near.phase = False, search_log.NEAREST
            near.corrections = corrections.setdefault(one.fields, {(choice.motor, choice.drive): known})
            near.built(choice, -math.inf, one.start.lengths_mm)
            if facts:
                say(f"the nearest machine stands in {facts['folder']}, with {one}")
                return
        if found:
            tried = " or ".join(" and ".join(one.fields) for one in found[:_NEAREST])
            say(f"no machine passed every check with {tried} changed up to {_EASIER[-1]:g} times further")
        elif not run.over():
            say(f"no change of limits up to a factor of {relaxation.MOST:g} was enough")
