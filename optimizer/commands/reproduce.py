"""`reproduce`: every published table beside ours, as a page and as JSON."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, Line, natural, refuse

NAME = "reproduce"
TEXT = "the paper's tables 2 to 12 recomputed: what follows from them, our methods, and the proven optimum"
TABLES = (4, 6, 7, 8, 9, 10, 11, 12)


def _tables(text: str) -> tuple[int, ...]:
    tables = tuple(int(part) for part in text.split(","))
    if not set(tables) <= set(TABLES):
        raise ValueError(text)
    return tuple(table for table in TABLES if table in tables)


_tables.__name__ = f"list of tables of {', '.join(map(str, TABLES))}:"  # as argparse names it


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    command.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="default: out")
    command.add_argument("--seed", type=natural, default=0, metavar="N", help="of everything random; default: 0")
    command.add_argument(
        "--tables", type=_tables, default=TABLES, metavar="4,6,...", help="tables of results; default: all"
    )
    command.add_argument("--population", type=natural, metavar="N", help="of the GA; default: the paper's, by step")
    command.add_argument("--generations", type=natural, metavar="N", help="of the GA; default: the paper's")
    command.add_argument("--json", action="store_true", help="the facts as JSON on stdout too")


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.common.files import write_all
    from optimizer.paper.cases import cases
    from optimizer.paper.facts import facts
    from optimizer.paper.page import page
    from optimizer.paper.runs import Reproduction
    from optimizer.search.genetic import GeneticError

    with Line() as line:
        line.show("loading the solvers; they are compiled once on a machine, in some 20 s")
        run = Reproduction(given.seed, given.population, given.generations, tell=line.show)
        try:
            rows = run.recompute(cases(given.tables))
        except GeneticError as error:
            return refuse(str(error), BAD_INPUT)
    told = facts(rows, run)
    text = json.dumps(told, indent=1, allow_nan=False) + "\n"
    try:
        write_all({given.out / "reproduce.json": text, given.out / "reproduce.md": page(told)})
    except OSError as error:
        return refuse(f"{given.out}: {error.strerror or error}", BAD_INPUT)
    if given.json:
        print(text, end="")
    else:
        print("\n".join((told["summary"], *told["verdict"])))
        print(f"the tables, ours beside them: {given.out / 'reproduce.md'}, {given.out / 'reproduce.json'}")
    open_ = [row.case.name for row in rows if row.proven.status != "proved"]
    lost = [row.case.name for row in rows if row.method("ga+sqp").objective is None]
    reasons = [f"the optimum of {name} is not proved" for name in open_] + [f"GA+SQP fails on {name}" for name in lost]
    return refuse("; ".join(reasons), NOT_MET) if reasons else DONE
