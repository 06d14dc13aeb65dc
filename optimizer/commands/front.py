"""`front`: cube size against worst kappa, torque and outline, as tables and pictures."""

from __future__ import annotations

import argparse
import json
from contextlib import suppress
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import (
    BAD_INPUT,
    DONE,
    INTERRUPTED,
    NOT_MET,
    ProgressLine,
    Request,
    refuse,
    refuse_all,
)
from delta_cad.common.options import (
    DESIGN,
    EITHER_CATALOGUE,
    JSON,
    OUT_FOLDER,
    REQUIREMENTS,
    SEED,
    Option,
    proof_minutes,
    whole,
)
from delta_cad.common.refusal import not_installed

if TYPE_CHECKING:
    from collections.abc import Callable

    from delta_cad.design import Design
    from optimizer.problem.requirements import Requirements
    from optimizer.study.convergence import Trace
    from optimizer.study.front import FrontPoint
    from optimizer.study.trade import Trade
    from optimizer.synthesis.checkpoint import Checkpoint

    Drawing = tuple[str, str, Callable[[], Any]]

NAME = "front"
TEXT = "Pareto front of cube size against worst conditioning, torque and outline, with pictures"
_AGAIN = "run again with --resume to go on"
_SEEDS = 6  # seeds of the convergence picture: the range of six holds a seventh with 5 chances in 7


class _StoppedError(Exception):
    """Ctrl-C between two pictures."""


OPTIONS = (
    REQUIREMENTS,
    OUT_FOLDER,
    Option("--points", type=whole(0), default=50, metavar="N", help="points of the front; default: 50"),
    SEED,
    Option(
        "--seeds",
        type=whole(0),
        default=_SEEDS,
        metavar="N",
        help=f"seeds of the convergence picture, 0 for no picture; default: {_SEEDS}",
    ),
    DESIGN.but(settle=None, help="design to draw; default: that of the required cube, or the largest"),
    EITHER_CATALOGUE,
    proof_minutes("of each proof"),
    Option(
        "--machines",
        action="store_true",
        help="front of complete machines: cube against effective mass, friction, stiffness and outline",
    ),
    Option("--build", action="store_true", help="with --machines: build every machine on the front, minutes each"),
    JSON,
    Option("--resume", action="store_true", help="continue an interrupted run in DIR"),
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    if given.build and not given.machines:
        return refuse("--build: with --machines only", BAD_INPUT)
    if given.resume and given.machines:
        return refuse("--resume: not with --machines, whose points come anew", BAD_INPUT)
    if given.machines:
        from optimizer.commands.machines import run as run_machines

        return run_machines(given)
    from delta_cad.design import DesignError, load_design
    from delta_cad.mechanism import MechanismError
    from optimizer.problem.requirements import RequirementsError, load_requirements, requirements_hash
    from optimizer.problem.variables import mechanism_of
    from optimizer.study.maps import require_held

    try:
        task = load_requirements(given.requirements, given.catalogue)
        design = None if given.design is None else load_design(given.design, given.catalogue)
    except (RequirementsError, DesignError) as error:
        return refuse_all([str(error), *error.more], BAD_INPUT)
    if design is not None:
        try:
            require_held(*mechanism_of(lengths_of(design)))
        except MechanismError as error:
            return refuse(f"{given.design}: {error}", BAD_INPUT)
    if find_spec("matplotlib") is None:
        return refuse(not_installed("matplotlib", "optimize"), BAD_INPUT)
    from delta_cad.common.files import require_room
    from optimizer.study.front import FrontError
    from optimizer.synthesis.checkpoint import Checkpoint, CheckpointError
    from optimizer.synthesis.infeasible import InfeasibleError

    folder = given.out / f"{task.name}-front"
    key = {
        "checkpoint": 2,
        "command": NAME,
        "requirements": requirements_hash(task),
        **{name: getattr(given, name) for name in ("points", "seed", "seeds")},
    }
    require_room(folder, folder=True)
    try:
        store = Checkpoint(folder.with_name(folder.name + ".checkpoint.jsonl"), key, given.resume)
    except CheckpointError as error:
        return refuse(str(error), BAD_INPUT)
    try:
        with Request() as stop, ProgressLine() as line:
            return _traced(task, design, given, folder, store, stop, line)
    except FrontError as error:
        store.remove()
        return refuse(f"{given.requirements.name}: {error}", BAD_INPUT)
    except InfeasibleError as error:
        store.remove()
        return refuse(f"{given.requirements.name}: {error}", NOT_MET)
    except KeyboardInterrupt:  # nobody looked for a second, or it was pressed twice
        return refuse(f"interrupted; {store.path} keeps what was found; {_AGAIN}", INTERRUPTED)
    finally:
        store.close()


def _traced(
    task: Requirements,
    design: Design | None,
    given: argparse.Namespace,
    folder: Path,
    store: Checkpoint,
    stop: Callable[[], bool],
    line: ProgressLine,
) -> int:
    """Traces, proves, draws and writes; returns the exit code."""
    from shutil import rmtree

    from optimizer.study.convergence import traces
    from optimizer.study.front import Tracer, at_side, proved, published_designs
    from optimizer.study.front_page import described, record, row, summary
    from optimizer.study.trade import trade as trades

    def point(curve: str, count: int, newest: FrontPoint | None) -> None:
        line.show(f"{curve}, point {count}" + ("" if newest is None else f": {described(row(curve, newest))}"))

    def proof(done: int, total: int) -> None:
        line.show(f"proof {done} of {total}")

    def seed(method: str, number: int, seeds: int) -> None:
        line.show(f"convergence, {method}, seed {number + 1} of {seeds}")

    trade = trades(Tracer(task, given.points, given.seed, report=point, stop=stop, store=store))
    if trade.finished:
        trade = replace(trade, main=proved(trade.main, proof, stop, store, 60.0 * given.proof_minutes))
    runs: list[Trace] = []
    subject = compared(trade)
    if trade.finished and subject is not None:
        runs = traces(at_side(task, subject.half_side), given.seeds, seed, stop, store)
    published = published_designs(task)
    facts, force_N = record(trade, given.seed, published, runs), task.requirements.force_N
    partial = folder.with_name(folder.name + ".partial")
    with suppress(_StoppedError):
        drawings = [] if stop() else _drawings(trade, design, published, runs, subject)
        if not stop():
            _write(folder, facts, force_N, drawings, stop, line)
            store.remove()
            rmtree(partial, ignore_errors=True)
            if given.json:
                print(json.dumps(facts, indent=1, allow_nan=False))
            else:
                print(*summary(facts), f"{len(trade.main.points)} points and the pictures in {folder}", sep="\n")
            return DONE
    store.close()
    # also where only proofs, seeds or pictures are missing
    _write(partial, facts | {"status": "interrupted"}, force_N, [], bool, line)
    points = sum(len(curve.points) for curve in trade.curves)
    return refuse(f"interrupted; {points} points so far in {partial}; {_AGAIN}", INTERRUPTED)


def _drawings(
    trade: Trade, design: Design | None, published: Any, runs: list[Trace], subject: FrontPoint | None
) -> list[Drawing]:
    """Lists name, caption and drawing of every picture."""
    from optimizer.problem.variables import mechanism_of
    from optimizer.study import pictures
    from optimizer.study.maps import slices

    task = trade.main.given
    force, chosen = task.requirements.force_N, None if design is not None else pictured(trade)
    lengths = lengths_of(design) if design is not None else pictured(trade).result.design_mm
    geometry, cube = mechanism_of(lengths)
    title = title_of(lengths, task.name if design is None else design.name)
    drawings: list[Drawing] = [
        (
            "front",
            "cube size against worst kappa and torque",
            lambda: pictures.front(trade.main, published, chosen, task.name),
        ),
        ("trade", "the front with another outline and with less torque", lambda: pictures.trade(trade, task.name)),
        ("workspace", "the workspace with the cube in it", lambda: pictures.workspace(geometry, cube, title)),
        (
            "maps",
            "condition number and joint torque over slices of the cube",
            lambda: pictures.maps(slices(geometry, cube, force), force, title),
        ),
    ]
    if runs and subject is not None:
        problem = f"Step 3 at a cube of {2 * subject.half_side:.4g} mm"
        draw = lambda: pictures.convergence(runs, subject.kappa, problem)  # noqa: E731
        drawings.append(("convergence", "GA and SQP over the seeds", draw))
    return drawings


def _write(
    place: Path,
    facts: dict[str, Any],
    force_N: float,
    drawings: list[Drawing],
    stop: Callable[[], bool],
    line: ProgressLine,
) -> None:
    """Puts a complete folder in its place, or raises `_StoppedError` between two pictures."""
    from delta_cad.common.files import whole_folder
    from optimizer.study import pictures
    from optimizer.study.front_page import files, page

    with whole_folder(place) as folder:
        for name, _, draw in drawings:
            line.show(f"picture: {name}")
            if stop():
                raise _StoppedError
            pictures.save(draw(), folder, name)
        text = page(facts, force_N, [(f"{name}.png", what) for name, what, _ in drawings])
        for name, content in files(facts, text).items():
            (folder / name).write_text(content, encoding="utf-8")


def pictured(trade: Trade) -> FrontPoint:
    """Finds the point at the requirements' cube, or where `synthesize` ends without one: the largest."""
    return _wanted(trade) or trade.main.points[-1]


def compared(trade: Trade) -> FrontPoint | None:
    """Finds the point at the requirements' cube, or at the knee: at the largest cube one design alone is feasible."""
    return _wanted(trade) or trade.knee


def _wanted(trade: Trade) -> FrontPoint | None:
    side = trade.main.given.step_3.half_side_mm
    return next((point for point in trade.main.points if point.half_side == side), None)


def lengths_of(design: Design) -> tuple[float, ...]:
    """Gives the variables of a design file in mm, in the optimiser's order."""
    from optimizer.problem.variables import variables_mm

    return variables_mm(design.mechanism.model_dump(), design.cube.model_dump())


def title_of(design_mm: tuple[float, ...], name: str) -> str:
    """Writes the title of a design's pictures."""
    L_A, L_B, R, r, H, L = design_mm[:6]
    lengths = ", ".join(f"{n} {v:.4g}" for n, v in (("R", R), ("r", r), ("L_A", L_A), ("L_B", L_B), ("H", H)))
    return f"{name}: cube of {2 * L:.4g} mm, {lengths} mm"
