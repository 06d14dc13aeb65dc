"""`reproduce`: every published table beside ours, as a page and as JSON."""

from __future__ import annotations

import argparse
import json

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, ProgressLine, refuse
from delta_cad.common.options import JSON, OUT_FOLDER, SEED, Option, proof_minutes, reader, whole

NAME = "reproduce"
TEXT = "recompute tables 2 to 12 of the paper, beside our methods and the proved optimum"
TABLES = (4, 6, 7, 8, 9, 10, 11, 12)


def _tables(text: str) -> tuple[int, ...]:
    tables = tuple(int(part) for part in text.split(","))
    if not set(tables) <= set(TABLES):
        raise ValueError
    return tuple(table for table in TABLES if table in tables)


OPTIONS = (
    OUT_FOLDER,
    SEED,
    Option(
        "--tables",
        type=reader(f"a list of tables of {', '.join(map(str, TABLES))}", _tables),
        default=TABLES,
        metavar="4,6,...",
        help="tables to recompute; default: all",
    ),
    Option("--population", type=whole(0), metavar="N", help="population of the GA; default: as in the paper, by step"),
    Option("--generations", type=whole(0), metavar="N", help="generations of the GA; default: as in the paper"),
    proof_minutes("of the proof of each optimum"),
    JSON,
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.common.files import require_room, write_all
    from optimizer.paper.page import page, record, summary
    from optimizer.paper.placed import placed_step
    from optimizer.paper.published import published_runs
    from optimizer.paper.reproduction import Reproduction
    from optimizer.search.genetic import GENERATIONS, GeneticError

    places = given.out / "reproduce.json", given.out / "reproduce.md"
    for place in places:
        require_room(place)
    generations = GENERATIONS if given.generations is None else given.generations
    with ProgressLine() as line:
        line.show("loading the solvers; they are compiled once on a machine, in some 20 s")
        made = Reproduction(
            given.seed, given.population, generations, seconds=60.0 * given.proof_minutes, report=line.show
        )
        try:
            runs = made.recompute(published_runs(given.tables))
            first_step = any(run.run.step == 1 for run in runs)
            placed = placed_step(made.gap, made.seed, made.seconds, line.show) if first_step else None
        except GeneticError as error:
            return refuse(str(error), BAD_INPUT)
    facts = record(runs, made, placed)
    text = json.dumps(facts, indent=1, allow_nan=False) + "\n"
    write_all(dict(zip(places, (text, page(facts)), strict=True)))
    if given.json:
        print(text, end="")
    else:
        print(summary(facts))
        print(f"the tables, ours beside them: {places[1]}, {places[0]}")
    reasons = [f"the optimum of {r.run.name} is not proved" for r in runs if r.proven.status != "proved"]
    if placed is not None and placed.placed.status != "proved":
        reasons.append("the optimum of step 1 with the placement free is not proved")
    reasons += [f"GA+SQP fails on {r.run.name}" for r in runs if r.attempts["ga+sqp"].objective is None]
    return refuse("; ".join(reasons), NOT_MET) if reasons else DONE
