"""`design`: from requirements to a machine that is built and passes every check."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import (
    BAD_INPUT,
    CUT_SHORT,
    ProgressLine,
    refuse,
    refuse_all,
    refuse_folder,
)
from delta_cad.common.options import (
    JSON,
    NO_CACHE,
    OUT,
    OUT_FOLDER,
    POSITIVE,
    PROGRESS,
    REQUIREMENTS,
    REQUIREMENTS_CATALOGUE,
    SEED,
    Option,
    number,
)

if TYPE_CHECKING:
    from optimizer.codesign.run import Builder
    from optimizer.codesign.search_log import End, Journal, SearchLog, Verdict
    from optimizer.problem.brief import DesignBrief

NAME = "design"
TEXT = "find and build a machine that meets the requirements and passes every check; writes OUT/NAME"
MINUTES = 10.0
_AMBER, _PLAIN = "\033[33m", "\033[0m"


OPTIONS = (
    REQUIREMENTS,
    OUT_FOLDER,
    SEED,
    Option(
        "--minutes",
        type=number(POSITIVE, unit="min"),
        default=MINUTES,
        metavar="M",
        help=f"time of the search, minutes; waiting for a processor does not count; default: {MINUTES:g}",
    ),
    Option("--resume", action="store_true", help="continue a run that was stopped, or whose time was over, in DIR"),
    REQUIREMENTS_CATALOGUE,
    NO_CACHE,
    PROGRESS,
    JSON,
)


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
    from optimizer.codesign.search_log import Journal
    from optimizer.synthesis.checkpoint import CheckpointError

    own_parts = sha256(repr(brief.own_parts).encode()).hexdigest()  # the file names their folder, not their rows
    key = {"design": 2, "requirements": brief_hash(brief), "own_parts": own_parts, "seed": given.seed}
    key["version"] = version("delta-haptics")
    try:
        journal = Journal(given.out / f"{brief.name}.design.jsonl", key, given.resume)
    except CheckpointError as error:
        return refuse(str(error), BAD_INPUT)
    try:
        return _designed(given, brief, journal)
    finally:
        journal.close()


def _clock() -> Callable[[], float]:
    from optimizer.search.clock import SearchClock

    return SearchClock()


def _designed(given: argparse.Namespace, brief: DesignBrief, journal: Journal) -> int:
    """Searches, builds and prints the verdict with what shows it; returns the exit code."""
    from delta_cad.common.worker_process import WorkerProcess
    from delta_cad.mechanism.proof import beforehand
    from optimizer.codesign.search_log import SearchLog, Verdict
    from optimizer.problem.brief import brief_hash
    from optimizer.search.clock import OutOfTimeError

    clock, limit_s = _clock(), 60.0 * given.minutes
    builder: Builder | None = None
    ends: Verdict | None = None
    end: End = "done"
    eased, near = list[str](), dict[str, Any]()
    with ProgressLine(work=f"design {brief_hash(brief)[:16]}") as line:
        line.show("loading the CAD kernel")
        if given.resume:
            line.left.forget()
        try:
            with WorkerProcess(beforehand.__name__, low_priority=True) as compiling:
                compiling.send(None)
                from optimizer.codesign.run import Builder, Run, nearest_machine

                command = _recorded(given)
                run = Run(given.out, given.seed, command, limit_s, clock, journal.memoize, line.show, line.keep)
                builder = Builder(run, brief)
                builder.search.best()
                if not builder.facts:  # the verdict is known now; the nearest machine takes longer
                    ends = _judged(given, builder.search.log, end, {})
                    known = "not possible as stated" if builder.search.log.impossible else "no machine found"
                    _say(given, f"{known}; looking for limits whose change makes one possible")
                    nearest_machine(run, builder.search, lambda text: _say(given, text), eased, near)
        except OutOfTimeError:
            end = "time"
        except KeyboardInterrupt:
            end = "stopped"
        if end != "done" or clock() > limit_s:
            line.left.forget()
    log, facts = (builder.search.log, builder.facts) if builder else (SearchLog(), {})
    if ends is None:
        ends = _judged(given, log, end, facts)
    elif end != "done":
        cut = "time over" if end == "time" else "stopped"
        _say(given, f"{cut} before a nearest machine was built; {_command(given, given.seed, resume=True)}")
    if end == "done" and clock() <= limit_s:
        journal.remove()
    if given.json:
        from optimizer.codesign.report import no_facts

        record = facts or no_facts(brief.name, ends, log, near)
        if ends is Verdict.INFEASIBLE:
            record["contradiction"] = eased or log.reasons
        print(json.dumps(record | {"verdict": str(ends), "left": log.left}, indent=1))
    ProgressLine.event("end", code=ends.code, folder=(facts or near).get("folder"))
    return ends.code


def _say(given: argparse.Namespace, text: str) -> None:
    """Prints a line at once; with `--json` on stderr."""
    if given.json:
        refuse(text, CUT_SHORT)
    else:
        print(text, flush=True)


def _judged(given: argparse.Namespace, log: SearchLog, end: End, facts: dict[str, Any]) -> Verdict:
    """Prints the verdict on a search, first, and what shows it; with `--json` nothing of a machine that stands."""
    from optimizer.codesign.report import shown
    from optimizer.codesign.search_log import verdict

    ends, why = verdict(log, end, bool(facts))
    words = shown(facts) if facts else f"{given.requirements.name}: {why}"
    first, open_ = f"{ends}: {words}".removesuffix(": "), end != "done" and bool(log.left)
    lines = [f"{_AMBER}{first}{_PLAIN}" if facts.get("poor") and sys.stdout.isatty() else first]
    if ends.code == CUT_SHORT or open_:
        lines.append(_command(given, given.seed if end != "done" else given.seed + 1, resume=end != "done"))
    if facts:
        left = f"not fully searched: {', '.join(log.left)}"
        page = (Path(facts["folder"]) / "design.md").read_text(encoding="utf-8")
        opens = f"open {Path(facts['folder']) / 'report.html'}"
        lines += [left] * open_ + ([] if given.json else page.splitlines()) + [f"files in {facts['folder']}", opens]
    else:
        lines += [one for one in log.reasons if one != why]
    ProgressLine.event("verdict", verdict=str(ends), text=first)
    for line in [] if given.json and facts and ends.code != CUT_SHORT else lines:
        _say(given, line)
    return ends


def _options(given: argparse.Namespace) -> list[str]:
    """Writes the options on which a result depends, beside the seed."""
    words = [] if given.minutes == MINUTES else ["--minutes", f"{given.minutes:g}"]
    return words + ([] if given.catalogue is None else ["--catalogue", quote(str(given.catalogue))])


def _recorded(given: argparse.Namespace) -> str:
    """Writes the command that a design file records."""
    words = ["python -m optimizer design", quote(given.requirements.name), "--seed", str(given.seed)]
    return " ".join([*words, *_options(given)])


def _command(given: argparse.Namespace, seed: int, resume: bool) -> str:
    """Writes the command that goes on with a run."""
    words = ["python -m optimizer design", quote(str(given.requirements))]
    words += [] if given.out == OUT else ["--out", quote(str(given.out))]
    words += ["--seed", str(seed)] if seed else []
    words += _options(given)
    words += ["--progress", given.progress] if given.progress != "text" else []
    words += ["--json"] if given.json else []
    return " ".join([*words, *(["--resume"] if resume else [])])
