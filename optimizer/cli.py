"""The command line: arguments, progress, exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

import argparse
import json
import math
import os
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from optimizer.requirements import Requirements
    from optimizer.result import Result
    from optimizer.three_step import Progress

DONE, NOT_MET, BAD_INPUT = 0, 1, 2
INTERRUPTED = 130  # 128 + SIGINT, as shells have it
METHODS = ("ga", "sqp", "ga+sqp")
EXIT_CODES = "exit codes: 0 done; 1 the requirements cannot be met, or were not; 2 the input or the usage is wrong"


class _Parser(argparse.ArgumentParser):
    """Usage errors in one line, as all other errors."""

    def error(self, message: str) -> Any:
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def parser() -> argparse.ArgumentParser:
    """The arguments of `python -m optimizer`."""
    top = _Parser(
        prog="python -m optimizer",
        description="Dimensions of a delta haptic device from the customer's requirements.",
        epilog=EXIT_CODES,
    )
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    text = "the three steps of dimensional synthesis; writes the last step's design file"
    command = commands.add_parser("synthesize", help=text, description=text, epilog=EXIT_CODES)
    command.add_argument("requirements", type=Path, metavar="REQ.toml", help="requirements file")
    command.add_argument("--method", choices=METHODS, default="ga+sqp", help="default: ga+sqp")
    command.add_argument("--seed", type=_natural, default=0, metavar="N", help="of everything random; default: 0")
    command.add_argument("--steps", type=_steps, default=(1, 2, 3), metavar="1,2,3", help="which steps; default: all")
    command.add_argument("--out", type=Path, default=Path("best.json"), metavar="FILE", help="default: best.json")
    command.add_argument("--population", type=_natural, metavar="N", help="of the GA; default: 100, 220, 220 by step")
    command.add_argument("--generations", type=_natural, default=100, metavar="N", help="of the GA; default: 100")
    command.add_argument("--json", action="store_true", help="the results as JSON on stdout")
    command.add_argument("--resume", action="store_true", help="take up what an interrupted run left beside FILE")
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code; a reader that goes away early is no error of ours."""
    try:
        code = _synthesize(parser().parse_args(arguments))
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left goes nowhere
        return DONE
    except KeyboardInterrupt:
        return _refuse("interrupted; nothing was written", INTERRUPTED)
    return code


def _natural(text: str) -> int:
    value = int(text)
    if value < 0:
        raise ValueError(text)
    return value


def _steps(text: str) -> tuple[int, ...]:
    steps = tuple(int(part) for part in text.split(","))
    if not set(steps) <= {1, 2, 3} or list(steps) != sorted(set(steps)):
        raise ValueError(text)
    return steps


_natural.__name__, _steps.__name__ = "whole number", "list of steps such as 1,2,3:"  # as argparse names them


def _refuse(message: str, code: int) -> int:
    print(" ".join(message.split()), file=sys.stderr)
    return code


def _synthesize(given: argparse.Namespace) -> int:
    from optimizer.requirements import RequirementsError, load_requirements, requirements_hash

    try:
        task = load_requirements(given.requirements)
    except RequirementsError as error:
        return _refuse(str(error), BAD_INPUT)
    from optimizer.checkpoint import Checkpoint, CheckpointError
    from optimizer.genetic import GeneticError
    from optimizer.infeasible import InfeasibleError
    from optimizer.problem import ProblemError
    from optimizer.three_step import Run

    key = {
        "checkpoint": 1,
        "requirements": requirements_hash(task),
        **{name: getattr(given, name) for name in ("method", "seed", "steps", "population", "generations")},
    }
    try:
        store = Checkpoint(given.out.with_name(given.out.name + ".checkpoint.jsonl"), key, given.resume)
    except CheckpointError as error:
        return _refuse(str(error), BAD_INPUT)
    except OSError as error:
        return _refuse(f"{given.out}: {error.strerror or error}", BAD_INPUT)
    sizes = {"population": given.population, "generations": given.generations}
    with _Interrupt() as asked, _Line() as line:
        try:
            run = Run(task, given.method, given.seed, given.steps, **sizes, report=line.show, stop=asked, store=store)
            results = run.results()
        except (ProblemError, GeneticError) as error:
            store.remove()
            return _refuse(f"{given.requirements.name}: {error}", BAD_INPUT)
        except InfeasibleError as error:
            store.remove()
            return _refuse(f"{given.requirements.name}: {error}", NOT_MET)
    return _deliver(task, given, results, store)


def _deliver(task: Requirements, given: argparse.Namespace, results: list[Result], store: Any) -> int:
    """Writes the design of the last step, prints the results, and says how it went."""
    from delta_cad.design import DesignError
    from optimizer.output import design_of, write_design

    last, interrupted = results[-1], results[-1].status == "interrupted"
    store.close() if interrupted else store.remove()
    problem = ""
    if last.feasible:
        try:
            write_design(design_of(task, results, given.method, given.seed, given.out.name), given.out)
        except DesignError as error:
            problem = f"{given.out.name} was not written: {error}"
        except OSError as error:
            return _refuse(f"{given.out}: {error.strerror or error}", BAD_INPUT)
    else:
        lacking = ", ".join(f"{name} by {value:.3g}" for name, value in last.violations.items() if value > 0.0)
        problem = f"{given.out.name} was not written: step {last.problem.step} misses {lacking}; {last.advice}"
    if given.json:
        print(json.dumps({"name": task.name, "steps": [result.record() for result in results]}, indent=1))
    else:
        for result in results:
            print(_summary(result))
    if interrupted:
        kept = problem or f"best so far in {given.out}"
        return _refuse(f"interrupted; {kept}; run again with --resume to go on", INTERRUPTED)
    return _refuse(f"{given.requirements.name}: {problem}", NOT_MET) if problem else DONE


def _summary(result: Result) -> str:
    lengths = ", ".join(
        f"{name} {value:.4g}" for name, value in zip(("L_A", "L_B", "R", "r", "H", "L"), result.design_mm, strict=True)
    )
    goal = "worst kappa" if result.problem.step == 3 else "half side"
    unit = "" if result.problem.step == 3 else " mm"
    return (
        f"step {result.problem.step} {result.method}: {goal} {result.objective:.5g}{unit} at {lengths} mm; "
        f"torque {result.max_torque:.4g} N m, kappa {result.max_kappa:.4g}; {result.status}: {result.advice}"
    )


class _Interrupt:
    """Whether Ctrl-C was pressed; a second one interrupts at once."""

    def __init__(self) -> None:
        self._asked = False
        self._before: Any = None

    def __enter__(self) -> Callable[[], bool]:
        self._before = signal.signal(signal.SIGINT, self._take)
        return lambda: self._asked

    def __exit__(self, *_: object) -> None:
        signal.signal(signal.SIGINT, self._before)

    def _take(self, _number: int, _frame: FrameType | None) -> None:
        if self._asked:
            raise KeyboardInterrupt
        self._asked = True


class _Line:
    """One line of progress on stderr, on a terminal only."""

    def __init__(self) -> None:
        self._wanted = sys.stderr.isatty()

    def __enter__(self) -> _Line:
        return self

    def __exit__(self, *_: object) -> None:
        if self._wanted:
            print("\r\033[K", end="", file=sys.stderr, flush=True)

    def show(self, at: Progress) -> None:
        if self._wanted:
            what = "kappa" if at.step == 3 else "half side"
            best = "none feasible yet" if math.isnan(at.best) else f"{what} {at.best:.5g}"
            text = f"\r\033[Kstep {at.step} {at.phase} {at.done}/{at.total}: {best}"
            print(text, end="", file=sys.stderr, flush=True)
