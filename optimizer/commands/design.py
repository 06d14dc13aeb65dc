"""`design`: from requirements to a machine that is built and passes every check."""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import replace
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from delta_cad.common.arguments import json_option, out_option
from delta_cad.common.console import (
    BAD_INPUT,
    DONE,
    INTERRUPTED,
    NOT_MET,
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
    from optimizer.problem.brief import DesignBrief

NAME = "design"
TEXT = "find and build a machine that meets the requirements and passes every check; writes OUT/NAME"
MINUTES = 10.0
UNHURRIED = 0.5  # share of the time in which ratio and width are improved before any machine stands
ENDING = 0.08  # share in which nothing is begun any more once a machine stands: what is begun ends in time
BOUND_S, BOUND_MOST_S = 80.0, 300.0  # for a machine's bound, and where it is not close by then
TELLING = 0.5  # share by which a bound may exceed its machine, and still be told
HURRIED = "ratio, pinion and width were not improved any further: half of the time had gone without a machine"
NO_BOUND = "the time ended before it was proved how much larger a cube of this family can be"
NEAREST, NEAREST_NAME = 2, "-nearest"  # eased tasks of which one is built, and the end of its name
EASIER = (1.0, 1.12, 1.25, 1.5)  # factors by which what gives does so once more, where no machine of it passes


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
        help=f"minutes after which no new candidate is started; default: {MINUTES:g}",
    )
    command.add_argument("--resume", action="store_true", help="continue an interrupted run in DIR")
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
        return _designed(given, brief, journal)
    finally:
        journal.close()


def _designed(given: argparse.Namespace, brief: DesignBrief, journal: Journal) -> int:
    """Searches, builds and tells."""
    from delta_cad.common.beside import Beside
    from delta_cad.mechanism.proof import beforehand

    ends = monotonic() + 60.0 * given.minutes
    told: dict[str, Any] = {}
    nearest: dict[str, Any] = {}
    contradiction: list[str] = []
    interrupted = False
    search: Search | None = None
    with Line() as line:
        line.show("loading the CAD kernel")
        try:
            with Beside(beforehand.__name__, behind=True) as compiling:
                compiling.give(None)
                search = _search(given, brief, journal, line, ends, told)
                search.best()
                if not told and monotonic() < ends:
                    contradiction = _eased(given, search, journal, line, ends, nearest)
        except KeyboardInterrupt:
            interrupted = True
    late = _over(given, ends, bool(told))
    again = "; run again with --resume to go on"
    if not interrupted and not late:
        journal.remove()
    if not told:
        if interrupted or search is None:
            return refuse(f"interrupted; no machine was finished{again}", INTERRUPTED)
        reasons = [f"{hardware}: {reason}" for hardware, reason in search.tried.stuck.items()]
        if given.json:
            empty = {"name": brief.name, "passed": False, "contradiction": contradiction or reasons}
            print(json.dumps(empty | {"nearest": nearest or None, "tried": search.tried.candidates}, indent=1))
        lines = [f"enough would be {one}" for one in contradiction] or reasons
        lines += [f"the nearest machine stands in {nearest['folder']}"] if nearest else []
        lines += [f"the time was over after {given.minutes:g} min{again}"] if late else []
        return refuse_all(
            [f"{given.requirements.name}: {one}" for one in ("no machine does all that is asked", *lines)], NOT_MET
        )
    if given.json:
        print(json.dumps(told, indent=1))
    else:
        print((Path(told["folder"]) / "design.md").read_text(encoding="utf-8"), end="")
        print(f"files in {told['folder']}")
    if interrupted:
        return refuse(f"interrupted; the best machine so far stands in {told['folder']}{again}", INTERRUPTED)
    return DONE


def _over(given: argparse.Namespace, ends: float, stands: bool) -> bool:
    """Whether the time for anything else is over, which is sooner where a machine stands."""
    return monotonic() > ends - (ENDING * 60.0 * given.minutes if stands else 0.0)


def _search(
    given: argparse.Namespace,
    brief: DesignBrief,
    journal: Journal,
    line: Line,
    ends: float,
    told: dict[str, Any],
    bounding: bool = True,
) -> Search:
    """Makes the search of a task, whose machines are built into their folder; `told` gets the facts of what passes.

    A bound on the cubes of its family is sought where one is of use, and wanted.
    """
    from delta_cad.commands.pipeline import Outcome, build, check_moving
    from delta_cad.design import design_hash
    from optimizer.codesign.bound import Family, bounded
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
        placed,
        report,
        with_provenance,
        write_beside,
        write_design,
    )
    from optimizer.codesign.search import Search
    from optimizer.codesign.tried import Posed

    haste: list[str] = []  # what is told of a machine that had to be built as it was

    def hurried() -> bool:
        if not told and monotonic() > ends - (1.0 - UNHURRIED) * 60.0 * given.minutes:
            if not haste:
                haste.append(HURRIED)
                line.keep(HURRIED)
            return True
        return False

    looked: dict[str, Moved] = {}  # at what moves of the last machine, which a build then takes over

    def moving(design: Design) -> list[Any]:
        of = design_hash(design)

        def compute() -> list[Any]:
            looked.clear()
            looked[of] = check_moving(solid(design), line.show)
            return looked[of].results

        return journal.once("moving", of, compute, results_told, results_read)

    def made(design: Design) -> Outcome:
        stated = with_provenance(design, brief, _again(given), given.seed)
        facts: dict[str, Any] = {}
        stopped: list[bool] = []  # by hand while the bound was sought: the machine is written first

        def beside(folder: Path, outcome: Outcome) -> None:
            standing = search.standing
            if not outcome.passed or standing is None:
                write_design(folder, placed(stated, brief, folder))  # to build it again and see what fails
                return
            line.show("what each limit costs")
            key = standing.choice.motor, standing.choice.drive
            known, of = search.lessons[key], " ".join(key)  # stuck at another ratio or width
            stuck = {name: why for name, why in search.tried.stuck.items() if name != of}
            posed = [*search.tried.posed, Posed(standing.choice, standing.score, ())]
            tried = replace(search.tried, built=[*search.tried.built, (stated, ())], posed=posed, stuck=stuck)
            begun = monotonic()
            bound, notes = None, (*brief.notes, *haste)
            if brief.objective == "cube_side" and bounding:
                family = Family(brief, standing, search.lessons | {key: with_least_radius(standing, known)})
                try:
                    with Request() as asked:
                        bound = bounded(
                            family,
                            standing.side_mm,
                            lambda: asked() or _over(given, ends, True) or monotonic() > begun + BOUND_MOST_S,
                            line.show,
                            lambda: monotonic() > begun + BOUND_S,
                        )
                        stopped.append(asked())
                except KeyboardInterrupt:
                    stopped.append(True)
                if bound is not None and bound.gap > TELLING:
                    bound, notes = None, (*notes, NO_BOUND)
            facts.update(facts_of(brief, outcome, tried, bound))
            cost = costs(brief, standing, known)
            text = report(facts, outcome.results, tried, known.why, notes, cost, bound)
            unit = UNITS[brief.objective]
            page = design_page(facts, outcome.results, tried, known.why, notes, cost, bound, unit)
            line.show("certificate")
            certificate = certificate_of(stated, folder / "mass_properties.json")
            write_beside(folder, placed(stated, brief, given.out / brief.name), text, page, certificate)

        def compute() -> Outcome:
            if (moved := looked.get(design_hash(design))) is None:  # a run that goes on
                return build(stated, given.out, line.show, beside=beside)
            machine = solid(design)
            machine = replace(machine, dimensions=replace(machine.dimensions, design=stated))
            return build(stated, given.out, line.show, beside=beside, made=machine, clearance=moved.clearance)

        def kept(outcome: Outcome) -> dict[str, Any]:
            return {"results": results_told(outcome.results), "facts": facts}

        def read(data: dict[str, Any]) -> Outcome:
            folder = given.out / brief.name
            if data["facts"] and not _stands(folder / "design.json", stated):
                return compute()
            facts.update(data["facts"])
            price = data["facts"].get("cost_EUR")
            return Outcome(stated, results_read(data["results"]), {}, folder, (), price)

        outcome = journal.once("built", design_hash(stated), compute, kept, read)
        told.update(facts)
        if any(stopped):
            raise KeyboardInterrupt
        return outcome

    search = Search(
        brief=brief,
        build=made,
        moving=moving,
        first=reference(),
        seed=given.seed,
        stop=lambda: _over(given, ends, bool(told)),
        hurried=hurried,
        report=line.show,
        tell=line.keep,
        once=journal.once,
    )
    return search


def _stands(path: Path, design: Design) -> bool:
    """Decides whether a folder holds the machine of a design."""
    from delta_cad.design import DesignError, design_hash, load_design

    try:
        return design_hash(load_design(path)) == design_hash(design)
    except DesignError:
        return False


def _eased(
    given: argparse.Namespace, search: Search, journal: Journal, line: Line, ends: float, told: dict[str, Any]
) -> list[str]:
    """Finds the limits of which each would be enough to give, and builds the machine of the least change."""
    from delta_cad.design import NAME_LONGEST
    from optimizer.codesign.nearest import reliefs

    found = reliefs(search)
    for one in found:
        line.keep(f"enough would be {one}")
    tries = [(one, factor) for factor in EASIER for one in found[:NEAREST]]
    lessons: dict[tuple[str, ...], dict[tuple[str, str], Lessons]] = {}  # what failed teaches holds of the next
    for one, factor in tries if monotonic() < ends else []:
        named = f"{search.brief.name[: NAME_LONGEST - len(NEAREST_NAME)]}{NEAREST_NAME}"
        brief = one.further(factor).model_copy(update={"name": named})
        near = _search(given, brief, journal, line, ends, told, bounding=False)
        choice, known = one.start.choice, replace(one.start.lessons, why=())
        near.finely, near.lessons = False, lessons.setdefault(one.fields, {(choice.motor, choice.drive): known})
        near.built(choice, -math.inf, one.start.lengths_mm)
        if told:
            break
    return [str(one) for one in found]


def _again(given: argparse.Namespace) -> str:
    """Writes the command that gives the same design."""
    return f"python -m optimizer design {given.requirements.name} --seed {given.seed}"
