"""`front --machines`: the front of a brief's machines, each with its design file and, if asked, built."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING

from delta_cad.common.console import BAD_INPUT, DONE, INTERRUPTED, ProgressLine, Request, refuse, refuse_all

if TYPE_CHECKING:
    from optimizer.study.machines import MachinePoint


def run(given: argparse.Namespace) -> int:
    """Traces the front and writes its folder; returns the exit code."""
    from optimizer.problem.brief import load_brief
    from optimizer.problem.validation import RequirementsError

    try:
        brief = load_brief(given.requirements, given.catalogue)
    except RequirementsError as error:
        return refuse_all(error.lines, BAD_INPUT)
    from delta_cad.common.files import require_room

    folder = given.out / f"{brief.name}-machines"
    require_room(folder, folder=True)
    from optimizer.codesign.search import Search
    from optimizer.codesign.search_log import verdict
    from optimizer.search.clock import OutOfTimeError
    from optimizer.study.machines import build_front, front, marked, record, write_front

    search = Search(brief, seed=given.seed)
    found: list[MachinePoint] = []
    interrupted = False
    try:
        with Request() as stop, ProgressLine() as line:
            search.stop, search.report, search.tell = stop, line.show, line.keep
            front(search, found)
    except (KeyboardInterrupt, OutOfTimeError):
        interrupted = True
    points = marked(found)
    if points:
        with ProgressLine() as line:
            line.show("files")
            write_front(points, brief.name, folder)
    if given.build and points and not interrupted:
        try:
            with ProgressLine() as line:
                build_front(points, brief.name, given.out, line)
        except KeyboardInterrupt:
            interrupted = True
    if not points and not interrupted:
        ends, why = verdict(search.log, "done", stands=False)
        return refuse_all([f"{ends}: {given.requirements.name}: {why}", *search.log.reasons], ends.code)
    if given.json:
        print(json.dumps(record(points, brief.name), indent=1, allow_nan=False))
    elif points:
        best = sum(point.on_front for point in points)
        print(f"{len(points)} machines, {best} of them beaten by none, in {folder}/machines.html")
    if interrupted:
        return refuse(
            f"interrupted; {len(points)} machines stand in {folder}" if points else "interrupted", INTERRUPTED
        )
    return DONE
