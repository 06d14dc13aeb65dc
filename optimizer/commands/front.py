"""`front`: cube size against worst kappa, torque and outline, as tables and pictures."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import BAD_INPUT, DONE, INTERRUPTED, NOT_MET, Interrupt, Line, natural, refuse

if TYPE_CHECKING:
    from collections.abc import Callable

    from delta_cad.design import Design
    from optimizer.front.convergence import Trace
    from optimizer.front.front import Point
    from optimizer.front.trade import Trade
    from optimizer.problem.requirements import Requirements

NAME = "front"
TEXT = "the front of cube size against worst kappa, torque and outline, with pictures"
SEEDS = 6
"""Of the convergence picture: the range of six holds a seventh with 5 chances in 7."""


class _StoppedError(Exception):
    """Ctrl-C between two pictures."""


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    command.add_argument("requirements", type=Path, metavar="REQ.toml", help="requirements file")
    command.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="default: out")
    command.add_argument("--points", type=natural, default=50, metavar="N", help="of the front; default: 50")
    command.add_argument("--seed", type=natural, default=0, metavar="N", help="of the cold starts; default: 0")
    command.add_argument(
        "--seeds", type=natural, default=SEEDS, metavar="N", help=f"of the convergence; 0 for none; default: {SEEDS}"
    )
    command.add_argument(
        "--design", type=Path, metavar="FILE", help="design to picture; default: the requirements' cube, or the largest"
    )
    command.add_argument("--json", action="store_true", help="the facts as JSON on stdout")
    command.add_argument("--resume", action="store_true", help="take up what an interrupted run left in DIR")


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.design import DesignError, load_design
    from delta_cad.mechanism import Cube, MechanismError
    from optimizer.front.maps import require_held
    from optimizer.problem.requirements import RequirementsError, load_requirements, requirements_hash

    try:
        task = load_requirements(given.requirements)
        design = None if given.design is None else load_design(given.design)
    except (RequirementsError, DesignError) as error:
        return refuse(str(error), BAD_INPUT)
    if design is not None:
        try:
            require_held(design.geometry, Cube(design.cube.bottom_height_mm / 1e3, design.cube.half_side_mm / 1e3))
        except MechanismError as error:
            return refuse(f"{given.design}: {error}", BAD_INPUT)
    if find_spec("matplotlib") is None:
        return refuse("the pictures need matplotlib: pip install 'delta-haptics[optimize]'", BAD_INPUT)
    from optimizer.front.front import FrontError
    from optimizer.synthesis.checkpoint import Checkpoint, CheckpointError
    from optimizer.synthesis.infeasible import InfeasibleError

    folder = given.out / f"{task.name}-front"
    key = {
        "checkpoint": 1,
        "command": NAME,
        "requirements": requirements_hash(task),
        **{name: getattr(given, name) for name in ("points", "seed", "seeds")},
    }
    try:
        store = Checkpoint(folder.with_name(folder.name + ".checkpoint.jsonl"), key, given.resume)
    except CheckpointError as error:
        return refuse(str(error), BAD_INPUT)
    except OSError as error:
        return refuse(f"{given.out}: {error.strerror or error}", BAD_INPUT)
    with Interrupt() as asked, Line() as line:
        try:
            return _Run(task, design, given, folder, store, asked, line).run()
        except FrontError as error:
            store.remove()
            return refuse(f"{given.requirements.name}: {error}", BAD_INPUT)
        except InfeasibleError as error:
            store.remove()
            return refuse(f"{given.requirements.name}: {error}", NOT_MET)
        except OSError as error:
            store.close()
            return refuse(f"{error.filename or folder}: {error.strerror or error}", BAD_INPUT)


class _Run:
    """One run of the command."""

    def __init__(
        self,
        task: Requirements,
        design: Design | None,
        given: argparse.Namespace,
        folder: Path,
        store: Any,
        asked: Callable[[], bool],
        line: Line,
    ) -> None:
        self.task, self.design, self.given, self.folder = task, design, given, folder
        self.store, self.asked, self.line = store, asked, line

    def run(self) -> int:
        """Everything, in order; returns the exit code."""
        from optimizer.front.convergence import traces
        from optimizer.front.limits import at_side
        from optimizer.front.page import record
        from optimizer.front.proof import proved
        from optimizer.front.published import published_designs
        from optimizer.front.trade import Trader

        trader = Trader(self.task, self.given.points, self.given.seed, self._point, self.asked, self.store)
        trade = trader.trade()
        if trade.finished:
            trade = replace(trade, main=proved(trade.main, self._proof, self.asked, self.store))
        found: list[Trace] = []
        subject = self._convergence_point(trade)
        if trade.finished and subject is not None:
            found = traces(at_side(self.task, subject.half_side), self.given.seeds, self._seed, self.asked, self.store)
        published = published_designs(self.task)
        facts = record(trade, self.given.seed, published, found)
        if not self.asked():
            try:
                self._write(trade, facts, published, found, subject)
            except _StoppedError:
                pass
            else:
                self.store.remove()
                return self._tell(trade, facts)
        return self._interrupted(trade, facts, published)

    def _write(self, trade: Trade, facts: dict[str, Any], published: Any, found: list[Trace], subject: Any) -> None:
        from delta_cad.common.files import whole_folder
        from optimizer.front.page import page, write_csv, write_facts
        from optimizer.pictures import convergence, front, maps, workspace
        from optimizer.pictures import trade as trades

        chosen = None if self.design is not None else self._chosen(trade)
        geometry, cube, name = self._pictured(chosen)
        force, task = self.task.requirements.force_N, self.task.name

        def slices() -> Any:
            from optimizer.front.maps import slices

            return maps.maps(slices(geometry, cube, force), force, name)

        drawings: list[tuple[str, str, Callable[[], Any]]] = [
            (
                "front",
                "cube size against worst kappa and torque",
                lambda: front.front(trade.main, published, chosen, task),
            ),
            ("trade", "the front with another outline and with less torque", lambda: trades.trade(trade, task)),
            ("workspace", "the workspace with the cube in it", lambda: workspace.workspace(geometry, cube, name)),
            ("maps", "condition number and joint torque over slices of the cube", slices),
        ]
        if found:
            title = f"Step 3 at a cube of {2 * subject.half_side:.4g} mm"
            draw = lambda: convergence.convergence(found, subject.kappa, title)  # noqa: E731
            drawings.append(("convergence", "GA and SQP over the seeds", draw))
        with whole_folder(self.folder) as folder:
            self._draw(drawings, folder)
            write_csv(trade, folder / "front.csv")
            write_facts(facts, folder / "front.json")
            text = page(trade, published, [(f"{name}.png", what) for name, what, _ in drawings])
            (folder / "front.md").write_text(text, encoding="utf-8")

    def _draw(self, drawings: list[tuple[str, str, Callable[[], Any]]], folder: Path) -> None:
        from optimizer.pictures.style import save

        for name, _, draw in drawings:
            self.line.show(f"picture: {name}")
            if self.asked():
                raise _StoppedError
            save(draw(), folder, name)

    def _interrupted(self, trade: Trade, facts: dict[str, Any], published: Any) -> int:
        from delta_cad.common.files import whole_folder
        from optimizer.front.page import page, write_csv, write_facts

        self.store.close()
        trade = replace(trade, finished=False)  # also where only proofs, seeds or pictures are missing
        partial = self.folder.with_name(self.folder.name + ".partial")
        with whole_folder(partial) as folder:
            write_csv(trade, folder / "front.csv")
            write_facts(facts | {"status": "interrupted"}, folder / "front.json")
            (folder / "front.md").write_text(page(trade, published, []), encoding="utf-8")
        points = sum(len(curve.points) for curve in trade.curves)
        return refuse(
            f"interrupted; {points} points so far in {partial}; run again with --resume to go on", INTERRUPTED
        )

    def _tell(self, trade: Trade, facts: dict[str, Any]) -> int:
        from shutil import rmtree

        rmtree(self.folder.with_name(self.folder.name + ".partial"), ignore_errors=True)
        if self.given.json:
            print(json.dumps(facts, indent=1, allow_nan=False))
            return DONE
        from optimizer.front.page import telling

        for what, point in telling(trade):
            print(f"{what}: {_words(point)}")
        beyond = " and ".join(trade.main.beyond) or "not found"
        print(f"1 % beyond the largest contradict each other: {beyond}")
        print(f"{len(trade.main.points)} points and the pictures in {self.folder}")
        return DONE

    def _chosen(self, trade: Trade) -> Point:
        """The point at the requirements' cube, or where `synthesize` ends without one: the largest."""
        wanted = self.task.step_3.half_side_mm
        points = trade.main.points
        return next((point for point in points if point.half_side == wanted), points[-1])

    def _convergence_point(self, trade: Trade) -> Point | None:
        """At the requirements' cube, or at the knee: at the largest cube one design alone is feasible."""
        wanted = self.task.step_3.half_side_mm
        return next((point for point in trade.main.points if point.half_side == wanted), trade.knee)

    def _pictured(self, chosen: Point | None) -> tuple[Any, Any, str]:
        from delta_cad.mechanism import Cube, DeltaGeometry

        if self.design is not None:
            d = self.design
            sizes = d.mechanism
            L_A, L_B, R, r = (
                sizes.upper_arm_length_mm,
                sizes.forearm_length_mm,
                sizes.base_radius_mm,
                sizes.platform_radius_mm,
            )
            H, L, name = d.cube.bottom_height_mm, d.cube.half_side_mm, d.name
        else:
            assert chosen is not None  # one of the two is given
            (L_A, L_B, R, r, H, L), name = chosen.result.design_mm, self.task.name
        geometry = DeltaGeometry(
            base_radius=R / 1e3, platform_radius=r / 1e3, upper_arm_length=L_A / 1e3, forearm_length=L_B / 1e3
        )
        lengths = ", ".join(f"{n} {v:.4g}" for n, v in (("R", R), ("r", r), ("L_A", L_A), ("L_B", L_B), ("H", H)))
        return geometry, Cube(H / 1e3, L / 1e3), f"{name}: cube of {2 * L:.4g} mm, {lengths} mm"

    def _point(self, curve: str, count: int, newest: Point | None) -> None:
        told = "" if newest is None else f": {_words(newest)}"
        self.line.show(f"{curve}, point {count}{told}")

    def _proof(self, done: int, total: int) -> None:
        self.line.show(f"proof {done} of {total}")

    def _seed(self, method: str, seed: int, seeds: int) -> None:
        self.line.show(f"convergence, {method}, seed {seed + 1} of {seeds}")


def _words(point: Point) -> str:
    binds = f"; binds: {', '.join(point.active)}" if point.active else ""
    return f"cube of {2 * point.half_side:.4g} mm, worst kappa {point.kappa:.4g}, torque {point.torque:.4g} N m{binds}"
