"""`design`: from requirements to a machine that is built and passes every check."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from delta_cad.common.arguments import OUT, json_option, out_option
from delta_cad.common.console import (
    BAD_INPUT,
    CUT_SHORT,
    Line,
    Request,
    catalogue_option,
    natural,
    refuse,
    refuse_all,
    refuse_folder,
)

if TYPE_CHECKING:
    from delta_cad.commands.pipeline import Moved, Outcome
    from delta_cad.design import Design
    from optimizer.codesign.journal import Journal
    from optimizer.codesign.lessons import Lessons
    from optimizer.codesign.search import Search
    from optimizer.codesign.tried import End, Tried
    from optimizer.problem.brief import DesignBrief

NAME = "design"
TEXT = "find and build a machine that meets the requirements and passes every check; writes OUT/NAME"
MINUTES = 10.0
UNHURRIED = 0.5  # share of the time in which ratio and width are improved before any machine stands
GRACE_S = 20.0  # beyond the time, in which a build that was begun may end
BOUND_S, BOUND_MOST_S = 80.0, 300.0  # for a machine's bound, and where it is not close by then
CLOSING = 0.3  # share of the time from the begin of a build to that of its bound, which report and manifest then take
TELLING = 0.5  # share by which a bound may exceed its machine, and still be told
HURRIED = "half of the time had gone without a machine: ratio, pinion and width were not improved to the end"
NO_BOUND = "the time ended before it was proved how much larger a cube of this family can be"
NEAREST, NEAREST_NAME = 2, "-nearest"  # eased tasks of which one is built, and the end of its name
EASIER = (1.0, 1.12, 1.25, 1.5)  # factors by which what gives does so once more, where no machine of it passes
AMBER, PLAIN = "\033[33m", "\033[0m"


def _minutes(text: str) -> float:
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise ValueError(text)
    return value


_minutes.__name__ = "number of minutes"  # as argparse names it


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    command.add_argument("requirements", type=Path, metavar="REQ.toml", help="requirements file")
    out_option(command)
    command.add_argument("--seed", type=natural, default=0, metavar="N", help="random seed; default: 0")
    command.add_argument(
        "--minutes",
        type=_minutes,
        default=MINUTES,
        metavar="M",
        help=f"time of the search, minutes; waiting for a processor does not count; default: {MINUTES:g}",
    )
    command.add_argument(
        "--resume", action="store_true", help="continue a run that was stopped, or whose time was over, in DIR"
    )
    catalogue_option(command, "the requirements file")
    json_option(command)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from optimizer.problem.brief import brief_hash, load_brief
    from optimizer.problem.validation import RequirementsError

    try:
        brief = load_brief(given.requirements, given.catalogue)
    except RequirementsError as error:
        return refuse_all(error.lines, BAD_INPUT)
    from delta_cad.common.files import require_room

    try:
        require_room(given.out / brief.name, folder=True)
    except OSError as error:
        return refuse_folder(given.out, error)
    from optimizer.codesign.journal import Journal
    from optimizer.synthesis.checkpoint import CheckpointError

    own_parts = sha256(repr(brief.own_parts).encode()).hexdigest()  # the file names their folder, not their rows
    key = {"design": 1, "requirements": brief_hash(brief), "own_parts": own_parts, "seed": given.seed}
    key["version"] = version("delta-haptics")
    try:
        journal = Journal(given.out / f"{brief.name}.design.jsonl", key, given.resume)
    except CheckpointError as error:
        return refuse(str(error), BAD_INPUT)
    try:
        return _designed(Run(given, brief, journal, Line(), _clock()))
    finally:
        journal.close()


def _clock() -> Callable[[], float]:
    from optimizer.search.clock import SearchClock

    return SearchClock()


@dataclass
class Run:
    """One run of the command.

    Attributes:
        given: Arguments.
        brief: The requirements.
        journal: What was computed already.
        line: Progress.
        clock: Seconds that count, since the run began.
    """

    given: argparse.Namespace
    brief: DesignBrief
    journal: Journal
    line: Line
    clock: Callable[[], float]

    def over(self, ahead_s: float = 0.0, share: float = 1.0) -> bool:
        """Whether so much of the time is over, so many seconds from now."""
        return self.clock() + ahead_s > share * 60.0 * self.given.minutes


def _designed(run: Run) -> int:
    """Searches, builds and prints the verdict with what shows it."""
    from delta_cad.common.beside import Beside
    from delta_cad.mechanism.proof import beforehand
    from optimizer.codesign.tried import Tried
    from optimizer.search.clock import OutOfTimeError

    facts: dict[str, Any] = {}
    nearest: dict[str, Any] = {}
    eased: list[str] = []
    tried, end = Tried(), "done"
    with run.line as line:
        line.show("loading the CAD kernel")
        try:
            with Beside(beforehand.__name__, behind=True) as compiling:
                compiling.give(None)
                search = _search(run, run.brief, facts)
                tried = search.tried
                search.best()
                if not facts:
                    eased = _eased(run, search, nearest)
        except OutOfTimeError:
            end = "time"
        except KeyboardInterrupt:
            end = "stopped"
    if end == "done" and not run.over():
        run.journal.remove()
    return _concluded(run, tried, end, facts, eased, nearest)


def _concluded(
    run: Run, tried: Tried, end: End, facts: dict[str, Any], eased: list[str], nearest: dict[str, Any]
) -> int:
    """Prints the verdict, first, and what shows it; returns the exit code."""
    from optimizer.codesign.pages.output import headline, judged, no_facts
    from optimizer.codesign.tried import Verdict, verdict

    given = run.given
    ends, why = verdict(tried, end, bool(facts))
    first = f"{ends}: {judged(facts) or headline(facts)}" if facts else f"{ends}: {given.requirements.name}: {why}"
    lines, open_ = [first.removesuffix(": ")], end != "done" and bool(tried.left)
    if ends.code == CUT_SHORT or open_:
        lines.append(_command(given, given.seed if end != "done" else given.seed + 1, resume=end != "done"))
    if facts:
        left = f"not looked at to the end: {', '.join(tried.left)}"
        page = (Path(facts["folder"]) / "design.md").read_text(encoding="utf-8")
        lines += [left] * open_ + ([] if given.json else page.splitlines()) + [f"files in {facts['folder']}"]
    else:
        lines += [*tried.reasons, *(f"closed forms have a machine with {one}" for one in eased)]
        lines += [f"the nearest machine stands in {nearest['folder']}"] if nearest else []
    if given.json:
        told = facts or no_facts(run.brief.name, ends, tried, nearest)
        if ends is Verdict.INFEASIBLE:
            told["contradiction"] = eased or tried.reasons
        print(json.dumps(told | {"verdict": str(ends), "left": tried.left}, indent=1))
        return ends.code if facts and ends.code != CUT_SHORT else refuse_all(lines, ends.code)
    if facts.get("poor") and sys.stdout.isatty():
        lines[0] = f"{AMBER}{lines[0]}{PLAIN}"
    print("\n".join(lines))
    return ends.code


def _search(run: Run, brief: DesignBrief, facts: dict[str, Any], bounding: bool = True) -> Search:
    """Makes the search of a task, whose machines are built into their folder; `facts` gets those of what passes.

    A bound on the cubes of its family is sought where one is of use, and wanted.
    """
    from delta_cad.commands.pipeline import Outcome, build, check_moving
    from delta_cad.design import design_hash
    from optimizer.codesign.bound import Bound, Family, bounded
    from optimizer.codesign.candidate import solid
    from optimizer.codesign.costs import costs
    from optimizer.codesign.journal import results_read, results_told
    from optimizer.codesign.learning import with_least_radius
    from optimizer.codesign.lessons import reference
    from optimizer.codesign.pages.design import design_page
    from optimizer.codesign.pages.output import (
        UNITS,
        certificate_of,
        facts_of,
        judged,
        placed,
        report,
        with_provenance,
        write_beside,
        write_design,
    )
    from optimizer.codesign.search import Search
    from optimizer.codesign.tried import Posed
    from optimizer.search.clock import OutOfTimeError

    given, line, once = run.given, run.line, run.journal.once
    looked: dict[str, Moved] = {}  # at what moves of the last machine, which a build then takes over

    def hurried() -> bool:
        return not facts and run.over(share=UNHURRIED)

    def goes_on(step: str) -> None:
        if run.over(-GRACE_S):
            raise OutOfTimeError
        line.show(step)

    def moving(design: Design) -> list[Any]:
        of = design_hash(design)

        def compute() -> list[Any]:
            looked.clear()
            looked[of] = check_moving(solid(design, search.begin), search.begin)
            return looked[of].results

        return once("moving", of, compute, results_told, results_read)

    def bound_of(family: Family, side_mm: float, begun: float, stopped: list[bool]) -> Bound | None:
        """What none of the family exceeds, as far as there is time for it; None where that says nothing."""
        at = run.clock()
        closing = CLOSING * (at - begun)
        try:
            with Request() as asked:
                found = bounded(
                    family,
                    side_mm,
                    lambda: asked() or run.over(closing) or run.clock() > at + BOUND_MOST_S,
                    line.show,
                    lambda: run.clock() > at + BOUND_S,
                )
                stopped.append(asked())
        except KeyboardInterrupt:
            stopped.append(True)
            return None
        return found if found.gap <= TELLING else None

    def made(design: Design) -> Outcome:
        stated = with_provenance(design, brief, _again(given), given.seed)
        begun, remarks = run.clock(), [HURRIED] if hurried() else []
        new: dict[str, Any] = {}
        stopped: list[bool] = []  # by hand while the bound was sought: the machine is written first

        def beside(folder: Path, outcome: Outcome) -> str:
            standing = search.standing
            if not outcome.passed or standing is None:
                write_design(folder, placed(stated, brief, folder))  # to build it again and see what fails
                return ""
            line.show("what each limit costs")
            key = standing.choice.motor, standing.choice.drive
            known, of = search.lessons[key], " ".join(key)  # stuck at another ratio or width
            stuck = {name: why for name, why in search.tried.stuck.items() if name != of}
            posed = [*search.tried.posed, Posed(standing.choice, standing.score, ())]
            tried = replace(search.tried, built=[*search.tried.built, (stated, ())], posed=posed, stuck=stuck)
            cost = costs(brief, standing, known)
            line.show("certificate")
            certificate = certificate_of(stated, folder / "mass_properties.json")
            bound = None
            if brief.objective == "cube_side" and bounding:
                family = Family(brief, standing, search.lessons | {key: with_least_radius(standing, known)})
                if (bound := bound_of(family, standing.side_mm, begun, stopped)) is None:
                    remarks.append(NO_BOUND)
            new.update(facts_of(brief, outcome, tried, bound))
            notes, unit = (*brief.notes, *remarks), UNITS[brief.objective]
            text = report(brief, new, tried, known.why, notes, cost, bound)
            page = design_page(brief, new, tried, known.why, notes, cost, bound, unit)
            write_beside(folder, placed(stated, brief, given.out / brief.name), text, page, certificate)
            return judged(new)

        def compute() -> Outcome:
            for remark in remarks:
                line.keep(remark)
            if (moved := looked.get(design_hash(design))) is None:  # a run that goes on
                return build(stated, given.out, goes_on, beside=beside)
            machine = solid(design, goes_on)
            machine = replace(machine, dimensions=replace(machine.dimensions, design=stated))
            return build(stated, given.out, goes_on, beside=beside, made=machine, clearance=moved.clearance)

        def kept(outcome: Outcome) -> dict[str, Any]:
            return {"results": results_told(outcome.results), "facts": new, "remarks": remarks}

        def read(data: dict[str, Any]) -> Outcome:
            folder = given.out / brief.name
            if data["facts"] and not (data["remarks"] == remarks and _stands(folder / "design.json", stated)):
                return compute()
            new.update(data["facts"])
            return Outcome(stated, results_read(data["results"]), {}, folder, (), new.get("cost_EUR"))

        outcome = once("built", design_hash(stated), compute, kept, read)
        facts.update(new)
        if any(stopped):
            raise KeyboardInterrupt
        return outcome

    search = Search(
        brief=brief,
        build=made,
        moving=moving,
        first=reference(),
        seed=given.seed,
        stop=run.over,
        hurried=hurried,
        report=line.show,
        tell=line.keep,
        once=once,
    )
    return search


def _stands(path: Path, design: Design) -> bool:
    """Decides whether a folder holds the machine of a design."""
    from delta_cad.design import DesignError, design_hash, load_design

    try:
        return design_hash(load_design(path)) == design_hash(design)
    except DesignError:
        return False


def _eased(run: Run, search: Search, facts: dict[str, Any]) -> list[str]:
    """Finds the limits of which each would be enough to give, and builds the machine of the least change.

    Args:
        run: The run.
        search: The search that found no machine.
        facts: Gets those of the machine that was built.

    Returns:
        What would be enough, a line each.
    """
    from delta_cad.design import NAME_LONGEST
    from optimizer.codesign.variants.nearest import reliefs
    from optimizer.search.clock import OutOfTimeError

    found = reliefs(search)
    for one in found:
        run.line.keep(f"closed forms have a machine with {one}")
    lessons: dict[tuple[str, ...], dict[tuple[str, str], Lessons]] = {}  # what failed teaches holds of the next
    name = f"{search.brief.name[: NAME_LONGEST - len(NEAREST_NAME)]}{NEAREST_NAME}"
    with suppress(OutOfTimeError):
        for one, factor in [(one, factor) for factor in EASIER for one in found[:NEAREST]]:
            near = _search(run, one.further(factor).model_copy(update={"name": name}), facts, bounding=False)
            choice, known = one.start.choice, replace(one.start.lessons, why=())
            near.finely, near.lessons = False, lessons.setdefault(one.fields, {(choice.motor, choice.drive): known})
            near.built(choice, -math.inf, one.start.lengths_mm)
            if facts:
                break
    return [str(one) for one in found]


def _command(given: argparse.Namespace, seed: int, resume: bool) -> str:
    """Writes the command that goes on with a run.

    Args:
        given: Its arguments.
        seed: Of the next one.
        resume: Whether it takes up what was computed.
    """
    words = ["python -m optimizer design", quote(str(given.requirements))]
    words += [] if given.out == OUT else ["--out", quote(str(given.out))]
    words += ["--seed", str(seed)] if seed else []
    words += [] if given.minutes == MINUTES else ["--minutes", f"{given.minutes:g}"]
    words += [] if given.catalogue is None else ["--catalogue", quote(str(given.catalogue))]
    words += ["--json"] if given.json else []
    return " ".join([*words, *(["--resume"] if resume else [])])


def _again(given: argparse.Namespace) -> str:
    """Writes the command that gives the same design."""
    return f"python -m optimizer design {given.requirements.name} --seed {given.seed}"
