"""`atlas`: many sets of requirements at once, on a local or a given Dask cluster."""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import BAD_INPUT, DONE, INTERRUPTED, NOT_MET, ProgressLine, Request, refuse, refuse_all
from delta_cad.common.options import JSON, OUT_FOLDER, Option, whole
from delta_cad.common.refusal import not_installed

if TYPE_CHECKING:
    from optimizer.study.cluster import Failure
    from optimizer.study.grid import Grid
    from optimizer.synthesis.checkpoint import Checkpoint

NAME = "atlas"
TEXT = "many sets of requirements on this machine or a Dask cluster"
_NEEDS = ("dask", "distributed", "matplotlib")
OPTIONS = (
    Option("grid", type=Path, metavar="GRID.toml", help="grid file: base, axes, method, seeds"),
    Option("--scheduler", metavar="ADDRESS", help="address of a Dask cluster; default: processes on this machine"),
    Option("--workers", type=whole(1), metavar="N", help="number of processes on this machine; default: its cores"),
    OUT_FOLDER,
    JSON,
    Option("--resume", action="store_true", help="continue an interrupted run in DIR"),
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    lacking = [name for name in _NEEDS if find_spec(name) is None]
    if lacking:
        return refuse(not_installed(" and ".join(lacking), "optimize,atlas"), BAD_INPUT)
    if given.scheduler is not None and given.workers is not None:
        return refuse("--workers is of this machine; a cluster given with --scheduler has its own", BAD_INPUT)
    from optimizer.problem.requirements import RequirementsError
    from optimizer.study.grid import load_grid

    try:
        grid = load_grid(given.grid)
    except RequirementsError as error:
        return refuse_all(error.lines, BAD_INPUT)
    from optimizer.study.cluster import key_of
    from optimizer.synthesis.checkpoint import Checkpoint, CheckpointError

    folder = given.out / "atlas" / grid.name
    try:
        store = Checkpoint(folder / "rows.jsonl", key_of(grid), given.resume)
    except CheckpointError as error:
        return refuse(str(error), BAD_INPUT)
    try:
        return _solve(grid, store, folder, given)
    finally:
        store.close()


def _solve(grid: Grid, store: Checkpoint, folder: Path, given: argparse.Namespace) -> int:
    """Solves what is not solved yet, and writes the atlas once all is."""
    from optimizer.study.cluster import ClusterError, collect, given_cluster, local_cluster, workers_here

    found = {one.index: row for one in grid.sets if (row := store.finished(f"set/{one.index}")) is not None}
    remaining = [one for one in grid.sets if one.index not in found]
    total = len(grid.sets)
    failed: list[Failure] = []

    def take(row: dict[str, Any]) -> None:
        found[row["index"]] = row
        store.finish(f"set/{row['index']}", row)
        show()

    def show() -> None:
        met = sum(row["feasible"] for row in found.values())
        line.show(f"atlas {len(found)}/{total} sets: {met} met, {len(found) - met} not")

    try:
        with Request() as stop, ProgressLine() as line:
            if remaining:
                line.show(f"atlas {len(found)}/{total} sets; starting workers")
                workers = min(given.workers or workers_here(), len(remaining))
                with local_cluster(workers) if given.scheduler is None else given_cluster(given.scheduler) as client:
                    show()
                    failed = collect(client, remaining, take, stop)
    except ClusterError as error:
        return refuse(str(error), BAD_INPUT)
    except KeyboardInterrupt:  # nobody looked for a second, or it was pressed twice
        failed = []
    if len(found) < total:
        kept = f"{len(found)} of {total} sets are kept; run again with --resume to go on"
        if failed:
            first = f"the first, set {failed[0].place}: {failed[0].reason}"
            return refuse(f"{len(failed)} sets came to no result, {first}; {kept}", NOT_MET)
        return refuse(f"interrupted; {kept}", INTERRUPTED)
    _write(grid, [found[one.index] for one in grid.sets], folder, given.json)
    store.remove()
    return DONE


def _write(grid: Grid, rows: list[dict[str, Any]], folder: Path, as_json: bool) -> None:
    from delta_cad.common.files import write_all
    from optimizer.study.atlas import PICTURE, atlas_files
    from optimizer.study.pictures import atlas_map, png

    contents = atlas_files(grid, rows, folder, lambda: png(atlas_map(grid, rows)))
    write_all(contents)
    if folder / PICTURE not in contents:
        (folder / PICTURE).unlink(missing_ok=True)
    met = sum(row["feasible"] for row in rows)
    said = f"{len(rows)} sets, {met} met, {len(rows) - met} not; {folder / 'atlas.md'}\n"
    print(contents[folder / "atlas.json"] if as_json else said, end="")
