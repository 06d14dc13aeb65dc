"""`synthesize`: the three steps from a requirements file to a design file."""

from __future__ import annotations

import argparse
import json
import math
import shlex
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from delta_cad.common.command_line import Parser
from delta_cad.common.console import (
    BAD_INPUT,
    DONE,
    INTERRUPTED,
    NOT_MET,
    ProgressLine,
    Request,
    Step,
    refuse,
    refuse_all,
)
from delta_cad.common.options import (
    JSON,
    POSITIVE,
    PROGRESS,
    REQUIREMENTS,
    REQUIREMENTS_CATALOGUE,
    SEED,
    Option,
    add_options,
    number,
    proof_minutes,
    reader,
    whole,
)

if TYPE_CHECKING:
    from optimizer.problem.requirements import Requirements
    from optimizer.search.result import Result
    from optimizer.synthesis.checkpoint import Checkpoint
    from optimizer.synthesis.output import DesignFile
    from optimizer.synthesis.three_step import Progress

NAME = "synthesize"
TEXT = "the three steps of dimensional synthesis; writes the design file of the last step"
METHODS = ("ga", "sqp", "ga+sqp", "proven")
# Boxes of designs: of the method `proven`, up to some minutes; beside the result of another, up to some seconds.
_GAP, BOXES, _BOXES_IN_BACKGROUND = 1e-5, 2_000_000, 100_000


# Arguments that make a run another run; what its proofs may cost does not.
_NAMES = ("method", "seed", "steps", "population", "generations")


def _steps(text: str) -> tuple[int, ...]:
    steps = tuple(int(part) for part in text.split(","))
    if not set(steps) <= {1, 2, 3} or list(steps) != sorted(set(steps)):
        raise ValueError
    return steps


OPTIONS = (
    REQUIREMENTS,
    Option("--method", choices=METHODS, default="ga+sqp", help="search method; default: ga+sqp"),
    SEED,
    Option(
        "--steps",
        type=reader("a list of steps such as 1,2,3", _steps),
        default=(1, 2, 3),
        metavar="1,2,3",
        help="steps to run; default: all",
    ),
    Option(
        "--out", type=Path, metavar="FILE", help="design file to write; default: NAME.json, with the name in REQ.toml"
    ),
    Option("--force", action="store_true", help="overwrite FILE even if it holds another design"),
    Option("--population", type=whole(0), metavar="N", help="population of the GA; default: 100, 220, 220 by step"),
    Option("--generations", type=whole(0), default=100, metavar="N", help="generations of the GA; default: 100"),
    Option("--gap", type=number(POSITIVE), default=_GAP, help=f"relative gap at which a proof ends; default: {_GAP:g}"),
    Option(
        "--boxes",
        type=whole(0),
        metavar="N",
        help="boxes of designs after which a proof ends; "
        f"default: {BOXES:,} for proven, {_BOXES_IN_BACKGROUND:,} beside another method",
    ),
    REQUIREMENTS_CATALOGUE,
    proof_minutes("of a step's proof"),
    Option("--no-proof", action="store_true", help="skip the bound beside the result of ga, sqp, ga+sqp"),
    PROGRESS,
    JSON,
    Option("--resume", action="store_true", help="continue an interrupted run beside FILE"),
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from optimizer.problem.requirements import RequirementsError, load_requirements, requirements_hash

    try:
        task = load_requirements(given.requirements, given.catalogue)
    except RequirementsError as error:
        return refuse_all(error.lines, BAD_INPUT)
    from delta_cad.common.files import require_room
    from optimizer.synthesis.checkpoint import Checkpoint, CheckpointError
    from optimizer.synthesis.output import DesignFile, OtherDesignError

    given.out = given.out or Path(f"{task.name}.json")
    try:
        file = DesignFile(given.out, task, given.force)
    except OtherDesignError as error:
        return refuse(str(error), BAD_INPUT)

    key = {
        "checkpoint": 4,
        "requirements": requirements_hash(task),
        **{name: getattr(given, name) for name in _NAMES},
    }
    require_room(given.out)
    try:
        store = Checkpoint(given.out.with_name(given.out.name + ".checkpoint.jsonl"), key, given.resume)
    except CheckpointError as error:
        return refuse(str(error), BAD_INPUT)
    try:
        return _solve(task, given, store, file)
    finally:
        store.close()


def _solve(task: Requirements, given: argparse.Namespace, store: Checkpoint, file: DesignFile) -> int:
    """Runs the steps, keeps the best design so far in its file and delivers what they come to."""
    from delta_cad.design import DesignError
    from optimizer.globalopt.bound import Effort
    from optimizer.problem.step import ProblemError
    from optimizer.search.genetic import GeneticError
    from optimizer.synthesis.infeasible import InfeasibleError
    from optimizer.synthesis.output import design_of
    from optimizer.synthesis.three_step import Run

    def keep(results: list[Result], coming: str) -> None:
        with suppress(DesignError):  # the last one is told
            name = given.out.name
            file.keep(design_of(task, results, given.method, given.seed, name, _again(given), coming, given.out.parent))

    def end(message: str, code: int) -> int:
        file.withdraw()
        store.remove()
        return refuse(message, code)

    boxes = (BOXES if given.method == "proven" else _BOXES_IN_BACKGROUND) if given.boxes is None else given.boxes
    effort = Effort(given.gap, boxes, 60.0 * given.proof_minutes)
    try:
        with Request() as stop:
            with ProgressLine() as line:
                results = Run(
                    task,
                    given.method,
                    given.seed,
                    given.steps,
                    given.population,
                    given.generations,
                    effort,
                    prove=not given.no_proof,
                    report=lambda at: line.show(_status(at)),
                    stop=stop,
                    store=store,
                    found=keep,
                ).results()
            return _deliver(task, given, results, store, file)
    except (ProblemError, GeneticError) as error:
        return end(f"{given.requirements.name}: {error}", BAD_INPUT)
    except InfeasibleError as error:
        return end(f"{given.requirements.name}: {error}", NOT_MET)
    except KeyboardInterrupt:  # nobody looked for a second, or it was pressed twice
        return refuse(_interrupted(given, file), INTERRUPTED)


def _interrupted(given: argparse.Namespace, file: DesignFile, problem: str = "") -> str:
    """Describes what an interrupted run leaves, and how to continue it."""
    kept = f"best so far in {given.out}" if file.kept else "no design was written"
    if not file.kept and given.out.exists():
        kept = f"{given.out} is left as it was"
    return f"interrupted; {problem or kept}; run again with --resume to go on"


def _again(given: argparse.Namespace) -> str:
    """Writes the command that gives the same design, without what is at its default."""
    words = [f"python -m optimizer synthesize {given.requirements.name} --method {given.method} --seed {given.seed}"]
    usual = Parser(add_help=False)
    add_options(usual, OPTIONS)
    default = usual.parse_args(["REQ.toml"])
    for name in ("steps", "population", "generations", "gap", "boxes", "proof_minutes"):
        value = getattr(given, name)
        if value != getattr(default, name):
            text = ",".join(map(str, value)) if name == "steps" else f"{value:g}"
            words.append(f"--{name.replace('_', '-')} {text}")
    if given.catalogue is not None:
        words.append(f"--catalogue {shlex.quote(str(given.catalogue))}")
    return " ".join([*words, *(["--no-proof"] if given.no_proof else [])])


def _deliver(
    task: Requirements, given: argparse.Namespace, results: list[Result], store: Checkpoint, file: DesignFile
) -> int:
    """Writes the design of the last step, prints the results, and says how it went."""
    from delta_cad.design import DesignError
    from optimizer.synthesis.output import design_of

    last, interrupted = results[-1], results[-1].status == "interrupted"
    problem = ""
    if last.tiny and last.feasible:
        least = f"{last.design_mm[5]:.2g} mm, less than a micrometre"
        problem = f"{given.out.name} was not written: the half side of step {last.problem.step} is {least}"
        problem += "; relax [limits], or bounds_mm.half_side where it is fixed"
    elif last.feasible:
        coming = f"step {last.problem.step} was interrupted" if interrupted else None
        try:
            name, folder = given.out.name, given.out.parent
            design = design_of(task, results, given.method, given.seed, name, _again(given), coming, folder)
            (file.keep if interrupted else file.finish)(design)
        except DesignError as error:
            problem = f"{given.out.name} was not written: {error}"
    else:
        lacking = ", ".join(f"{name} by {value:.3g}" for name, value in last.violations.items() if value > 0.0)
        problem = f"{given.out.name} was not written: step {last.problem.step} misses {lacking}; {last.advice}"
    if not interrupted:
        store.remove()
    if given.json:
        print(json.dumps({"name": task.name, "steps": [result.record() for result in results]}, indent=1))
    else:
        for result in results:
            print(_summary(result))
    if interrupted:
        return refuse(_interrupted(given, file, "" if file.kept else problem), INTERRUPTED)
    if problem:
        file.withdraw()
    return refuse(f"{given.requirements.name}: {problem}", NOT_MET) if problem else DONE


def _summary(result: Result) -> str:
    from optimizer.problem.variables import LENGTHS, named

    lengths = ", ".join(
        f"{name} {value:.4g}" for name, value in zip(("L_A", "L_B", "R", "r", "H", "L"), result.design_mm, strict=False)
    )
    placed = dict(list(named(result.design_mm).items())[len(LENGTHS) :])
    lengths += " mm" + "".join(f", {name} {value:.4g}" for name, value in placed.items())
    figures = [(limit.figures[0], result.worst(type(limit))) for limit in result.reported_limits]
    wording = ", ".join(f"{one.words} {value * one.scale:.4g} {one.unit}".rstrip() for one, value in figures)
    goal = "worst kappa" if result.problem.step == 3 else "half side"
    unit = "" if result.problem.step == 3 else " mm"
    return (
        f"step {result.problem.step} {result.method}: {goal} {result.objective:.5g}{unit} at {lengths}; "
        f"{_bound(result, unit)}"
        f"{wording}; {result.status}: {result.advice}"
    )


def _bound(result: Result, unit: str) -> str:
    proof = result.proof
    if proof is None or proof.bound is None or proof.gap is None:
        return ""
    third = result.problem.step == 3
    word, where = ("below", " at this half side") if third else ("above", "")
    return f"proved: none {word} {proof.bound:.6g}{unit}{where}, gap {proof.gap:.1e}, {proof.boxes:,} boxes; "


def _status(at: Progress) -> Step:
    """Step of progress of a run: of the paper's three steps, whichever are run."""
    what = "kappa" if at.step == 3 else "half side"
    best = "" if math.isnan(at.best) else f"{what} {at.best:.5g}"
    units = (at.done, at.total) if at.phase in ("ga", "sqp") else (0, 0)
    if at.phase == "conflict":
        words = "no feasible design found: searching what contradicts what"
    elif at.certifying:
        words = f"{at.done:,} boxes: certifying a design, {at.certifying:,} boxes of its cube"
    elif at.phase == "proof" and at.done == 0 and not best:
        words = "loading; compiles for some 20 s when it runs for the first time"
    elif at.phase == "proof":
        words = f"{at.done:,} boxes: bound {at.bound:.6g}"
    else:
        words = "" if best else "none feasible yet"
    return Step(words, at.phase, at.step, 3, *units, best)
