"""`atlas`: many sets of requirements at once, on a local or a given Dask cluster."""

from __future__ import annotations

import argparse
import json
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from delta_cad.common.arguments import json_option, out_option
from delta_cad.common.console import BAD_INPUT, DONE, INTERRUPTED, NOT_MET, Line, Request, natural, refuse, refuse_all
from delta_cad.common.refusal import not_installed

if TYPE_CHECKING:
    from optimizer.study.atlas_file import RowFile
    from optimizer.study.cluster import Failure
    from optimizer.study.grid import Grid

NAME = "atlas"
TEXT = "many sets of requirements on this machine or a Dask cluster"
NEEDS = ("dask", "distributed", "matplotlib")


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    command.add_argument("grid", type=Path, metavar="GRID.toml", help="grid file: base, axes, method, seeds")
    command.add_argument(
        "--scheduler", metavar="ADDRESS", help="address of a Dask cluster; default: processes on this machine"
    )
    command.add_argument(
        "--workers", type=natural, metavar="N", help="number of processes on this machine; default: its cores"
    )
    out_option(command)
    json_option(command)
    command.add_argument("--resume", action="store_true", help="continue an interrupted run in DIR")


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    lacking = [name for name in NEEDS if find_spec(name) is None]
    if lacking:
        return refuse(not_installed(" and ".join(lacking), "optimize,atlas"), BAD_INPUT)
    if given.scheduler is not None and given.workers is not None:
        return refuse("--workers is of this machine; a cluster given with --scheduler has its own", BAD_INPUT)
    if given.workers == 0:
        return refuse("--workers = 0: must be at least 1", BAD_INPUT)
    from optimizer.problem.requirements import RequirementsError
    from optimizer.study.grid import load_grid

    try:
        grid = load_grid(given.grid)
    except RequirementsError as error:
        return refuse_all(error.lines, BAD_INPUT)
    from optimizer.study.atlas_file import RowFile
    from optimizer.study.cluster import key_of
    from optimizer.synthesis.checkpoint import CheckpointError

    folder = given.out / "atlas" / grid.name
    try:
        rows = RowFile(folder / "rows.jsonl", key_of(grid), given.resume)
    except CheckpointError as error:
        return refuse(str(error), BAD_INPUT)
    try:
        return _solve(grid, rows, folder, given)
    finally:
        rows.close()


def _solve(grid: Grid, rows: RowFile, folder: Path, given: argparse.Namespace) -> int:
    """Solves what is not solved yet, and writes the atlas once all is."""
    from optimizer.study.cluster import ClusterError, collect, given_cluster, local_cluster, workers_here

    todo = [one for one in grid.sets if one.index not in rows.rows]
    failed: list[Failure] = []
    try:
        with Request() as stop, Line() as line:
            if todo:
                line.show(f"atlas {len(rows.rows)}/{len(grid.sets)} sets; starting workers")
                workers = min(given.workers or workers_here(), len(todo))
                with local_cluster(workers) if given.scheduler is None else given_cluster(given.scheduler) as client:

                    def take(row: dict[str, object]) -> None:
                        rows.add(row)
                        line.show(_status(grid, rows))

                    line.show(_status(grid, rows))
                    failed = collect(client, todo, take, stop)
    except ClusterError as error:
        return refuse(str(error), BAD_INPUT)
    except KeyboardInterrupt:  # nobody looked for a second, or it was pressed twice
        failed = []
    missing = len(grid.sets) - len(rows.rows)
    kept = f"{len(rows.rows)} of {len(grid.sets)} sets are kept; run again with --resume to go on"
    if missing:
        if failed:
            first = f"the first, set {failed[0].place}: {failed[0].reason}"
            return refuse(f"{len(failed)} sets came to no result, {first}; {kept}", NOT_MET)
        return refuse(f"interrupted; {kept}", INTERRUPTED)
    return _deliver(grid, rows, folder, given)


def _deliver(grid: Grid, rows: RowFile, folder: Path, given: argparse.Namespace) -> int:
    from delta_cad.common.files import write_all
    from optimizer.study.atlas_file import csv_text, design_files, record
    from optimizer.study.atlas_page import mapped, page
    from optimizer.study.pictures.atlas import png

    ordered = [rows.rows[one.index] for one in grid.sets]
    picture = folder / "atlas.png"
    text = json.dumps(record(grid, ordered), indent=1, allow_nan=False)
    contents: dict[Path, str | bytes] = {picture: png(grid, ordered)} if mapped(grid) else {}
    contents |= {
        folder / "atlas.json": text + "\n",
        folder / "atlas.csv": csv_text(ordered),
        folder / "atlas.md": page(grid, ordered, picture.name if contents else None, folder.as_posix()),
    }
    contents |= {folder / name: content for name, content in design_files(ordered).items()}
    write_all(contents)
    if picture not in contents:
        picture.unlink(missing_ok=True)
    rows.remove()
    met = sum(row["feasible"] for row in ordered)
    print(text if given.json else f"{len(ordered)} sets, {met} met, {len(ordered) - met} not; {folder / 'atlas.md'}")
    return DONE


def _status(grid: Grid, rows: RowFile) -> str:
    met = sum(bool(row["feasible"]) for row in rows.rows.values())
    done = len(rows.rows)
    return f"atlas {done}/{len(grid.sets)} sets: {met} met, {done - met} not"
