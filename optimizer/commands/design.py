"""`design`: from requirements to a machine that is built and passes every check."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import (
    BAD_INPUT,
    DONE,
    INTERRUPTED,
    NOT_MET,
    Line,
    catalogue_option,
    natural,
    refuse,
    refuse_all,
)

if TYPE_CHECKING:
    from delta_cad.commands.pipeline import Outcome
    from delta_cad.design import Design
    from optimizer.problem.brief import DesignBrief

NAME = "design"
TEXT = "from requirements to a built machine that passes every check; writes OUT/NAME"
MINUTES = 10.0


def _minutes(text: str) -> float:
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise ValueError(text)
    return value


_minutes.__name__ = "number of minutes"  # as argparse names it


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    command.add_argument("requirements", type=Path, metavar="REQ.toml", help="requirements file")
    command.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="default: out")
    command.add_argument("--seed", type=natural, default=0, metavar="N", help="of everything random; default: 0")
    command.add_argument(
        "--minutes",
        type=_minutes,
        default=MINUTES,
        metavar="M",
        help=f"no new machine is begun later; default: {MINUTES:g}",
    )
    catalogue_option(command, "the requirements file")
    command.add_argument("--json", action="store_true", help="the result as JSON on stdout")


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from optimizer.problem.brief import load_brief
    from optimizer.problem.validation import RequirementsError

    try:
        brief = load_brief(given.requirements, given.catalogue)
    except RequirementsError as error:
        return refuse_all(error.lines, BAD_INPUT)
    from delta_cad.common.files import require_room

    try:
        require_room(given.out / brief.name, folder=True)
    except OSError as error:
        return refuse(f"--out {given.out}: {error.strerror or error}; must be a folder that can be written", BAD_INPUT)
    return _designed(given, brief)


def _designed(given: argparse.Namespace, brief: DesignBrief) -> int:
    """Searches, builds and tells."""
    from delta_cad.commands.pipeline import build, check_moving
    from optimizer.codesign.candidate import solid
    from optimizer.codesign.costs import costs
    from optimizer.codesign.output import certificate_of, facts_of, placed, report, with_provenance, write_beside
    from optimizer.codesign.reference import reference
    from optimizer.codesign.search import Search

    ends = monotonic() + 60.0 * given.minutes
    told: dict[str, Any] = {}
    interrupted = False
    with Line() as line:
        line.show("loading the CAD kernel")

        def made(design: Design) -> Outcome:
            stated = with_provenance(design, brief, _again(given), given.seed)

            def beside(folder: Path, outcome: Outcome) -> None:
                standing = search.standing
                if not outcome.passed or standing is None:
                    return
                line.show("what each limit costs")
                known = search.lessons[standing.choice.motor, standing.choice.drive]
                tried = replace(search.tried, built=[*search.tried.built, (stated, ())])
                facts = facts_of(brief, outcome, tried)
                text = report(facts, outcome.results, tried, known.why, brief.notes, costs(brief, standing, known))
                line.show("certificate")
                certificate = certificate_of(stated, folder / "mass_properties.json")
                write_beside(folder, placed(stated, brief, given.out / brief.name), text, certificate)
                told.update(facts)

            return build(stated, given.out, line.show, beside=beside)

        search = Search(
            brief=brief,
            build=made,
            moving=lambda design: check_moving(solid(design), line.show),
            first=reference(),
            seed=given.seed,
            stop=lambda: monotonic() > ends,
            report=line.show,
            tell=line.keep,
        )
        try:
            search.best()
        except KeyboardInterrupt:
            interrupted = True
    if not told:
        if interrupted:
            return refuse("interrupted; no machine was finished", INTERRUPTED)
        reasons = [f"{hardware}: {reason}" for hardware, reason in search.tried.stuck.items()]
        if given.json:
            empty = {"name": brief.name, "passed": False, "contradiction": reasons, "nearest": None}
            print(json.dumps(empty | {"tried": search.tried.candidates}, indent=1))
        late = [f"the time was over after {given.minutes:g} min: raise --minutes"] if monotonic() > ends else []
        return refuse_all([f"{given.requirements.name}: {reason}" for reason in (*late, *reasons)], NOT_MET)
    if given.json:
        print(json.dumps(told, indent=1))
    else:
        print((Path(told["folder"]) / "design.md").read_text(encoding="utf-8"), end="")
        print(f"files in {told['folder']}")
    if interrupted:
        return refuse(f"interrupted; the best machine so far stands in {told['folder']}", INTERRUPTED)
    return DONE


def _again(given: argparse.Namespace) -> str:
    """Writes the command that gives the same design."""
    return f"python -m optimizer design {given.requirements.name} --seed {given.seed}"
