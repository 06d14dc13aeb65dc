"""Why results differ from the paper's: table 13 and figures 14 to 16 again, one assumption changed at a time.

Source:
    [RCIM2018] table 13, figures 14 to 16. Hand, friction, delay, filter, noise and compliance are not given there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from delta_cad.common.units import MM_PER_M
from haptics.gravity.published import STIFFNESS_N_PER_MM
from haptics.loop.assumptions import CURRENT_LAG
from haptics.loop.choice import BOARD, DAMPED, PAPER
from haptics.loop.wall_trial import WallBench
from haptics.loop.walls import WallSearch, search
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand
from haptics.rendering.laws.virtual_wall import AXES
from haptics.scenes.bench import NOMINAL, PERIOD, Assumed
from haptics.scenes.home import home
from haptics.scenes.record import Scene
from haptics.scenes.resistance import resistance

STEP, CEILING, _TOLERANCE = 1000.0, 40e3, 50.0  # N/m, as of the scene


@dataclass(frozen=True)
class WallCase:
    """Largest stable walls under one set of assumptions.

    Attributes:
        name: What is other than in the scene.
        limits_N_per_mm: By axis; NaN where the wall that ends the search was not even reached.
        never_oscillated: Axes along which no wall up to the ceiling oscillated.
        lean_N: Force of the hand.
    """

    name: str
    limits_N_per_mm: dict[str, float]
    never_oscillated: tuple[str, ...]
    lean_N: float

    @property
    def not_reached(self) -> list[str]:
        """Axes along which the hand does not bring the handle to the wall against friction."""
        return [axis for axis in AXES if math.isnan(self.limits_N_per_mm[axis])]

    @property
    def reaches_published(self) -> bool:
        """Whether it bears the paper's wall along every axis."""
        return all(self.limits_N_per_mm[axis] >= STIFFNESS_N_PER_MM[axis] for axis in AXES)


def cases(
    machine: MachineModel, hand: str, delay: float, seed: int, progress: Callable[[str], None] = lambda _: None
) -> list[WallCase]:
    """Searches the limits of each case.

    Args:
        machine: The device.
        hand: Name of the hand in `HANDS`.
        delay: From reading to torque, s.
        seed: Of the places of the counts.
        progress: Told what is searched.

    Returns:
        The scene's own first.
    """
    found = []
    for name, bench in _benches(machine, hand, delay, seed):
        progress(name)
        benches = {axis: bench(axis) for axis in AXES}
        searches = {
            axis: search(one.stands, step=STEP, ceiling=CEILING, tolerance=_TOLERANCE) for axis, one in benches.items()
        }
        limits = {axis: _limit(benches[axis], one) for axis, one in searches.items()}
        never = tuple(axis for axis, one in searches.items() if one.ceiling_reached)
        found.append(WallCase(name, limits, never, benches["x"].lean))
    return found


def _limit(bench: WallBench, found: WallSearch) -> float:
    """Largest stable wall, N/mm; NaN where the next wall tried was not reached, so that it says nothing of a limit."""
    failed = [stiffness for stiffness, stood in found.history if not stood]
    if failed and not bench.trial(min(failed)).reached:
        return math.nan
    return found.bisection / MM_PER_M


def _benches(
    machine: MachineModel, hand: str, delay: float, seed: int
) -> Iterator[tuple[str, Callable[[str], WallBench]]]:
    who = HANDS[hand]
    rigid = _without_grasp(who)
    yield "as simulated", lambda axis: WallBench(machine, axis, who, delay=delay, seed=seed)
    for other in sorted(HANDS.keys() - {hand}):
        yield f"{other} hand", lambda axis, o=other: WallBench(machine, axis, HANDS[o], delay=delay, seed=seed)
    yield "arm rigid on the handle", lambda axis: WallBench(machine, axis, rigid, delay=delay, seed=seed)
    for name, other in (("no delay", 0.0), ("a period of delay", PERIOD)):
        yield name, lambda axis, d=other: WallBench(machine, axis, who, delay=d, seed=seed)
    yield "least friction", lambda axis: WallBench(machine, axis, who, "least", delay, seed=seed)
    yield "largest friction", lambda axis: WallBench(machine, axis, who, "largest", delay, seed=seed)
    whole = replace(PAPER, delays=(0.0, delay / PERIOD, 1.0))
    yield "noise, cable, structure", lambda axis: WallBench(machine, axis, who, seed=seed, loop=whole)
    for loop in (BOARD, DAMPED):
        yield loop.label, lambda axis, one=loop: WallBench(machine, axis, who, seed=seed, loop=one)


def _without_grasp(hand: Hand) -> Hand:
    """The same arm without a grasp between it and the handle, as models of two and three parameters have it."""
    return hand._replace(grasp_stiffness=0.0, grasp_damping=0.0)


def damping_needed(stiffness_N_per_mm: float, delay: float) -> float:
    """Computes the damping that a wall of the scene's loop takes, `K (T / 2 + delay + lag)`, N s/m."""
    return MM_PER_M * stiffness_N_per_mm * (PERIOD / 2.0 + delay + CURRENT_LAG)


def discussion(found: list[WallCase], hand: str, delay: float) -> list[str]:
    """Says in sentences what the cases show; every figure is one of theirs."""
    who, own = HANDS[hand], found[0]
    needs = {axis: damping_needed(STIFFNESS_N_PER_MM[axis], delay) for axis in AXES}
    said = [
        f"Table 13 again: {_by_axis(own.limits_N_per_mm)} N/mm where the paper has {_by_axis(STIFFNESS_N_PER_MM)}; "
        f"from the softest axis on {_order(own.limits_N_per_mm)} here, {_order(STIFFNESS_N_PER_MM)} there. In this "
        f"loop the paper's walls take {_by_axis(needs)} N s/m, K (T/2 + delay + lag); the grasp gives "
        f"{who.grasp_damping:g}, and what friction takes comes on top. The arm's {who.damping:g} N s/m is behind the "
        "grasp's spring, where a loop feels little."
    ]
    reach = [one.name for one in found[1:] if one.reaches_published]
    if reach:
        said.append(f"The paper's walls stand along every axis with: {'; '.join(reach)}.")
    cases = (
        f"{one.name}: {_by_axis(one.limits_N_per_mm)}{' and more' if one.never_oscillated else ''}" for one in found[1:]
    )
    for one in found:
        if one.not_reached:
            said.append(
                f"With {one.name} there is no figure along {', '.join(one.not_reached)}: friction holds the handle "
                f"before the wall against the hand's {one.lean_N:.2f} N."
            )
    said.append(
        f"One change alone, N/mm: {'; '.join(cases)}. Which of them the paper had it does not say, so that nothing is "
        "fitted to it."
    )
    return said


def _by_axis(values: Mapping[str, float]) -> str:
    """Each axis with its value, in the paper's order."""
    return ", ".join(f"{axis} {'-' if math.isnan(values[axis]) else format(values[axis], '.1f')}" for axis in AXES)


def _order(values: Mapping[str, float]) -> str:
    """The axes from the least value to the largest."""
    return ", ".join(sorted(AXES, key=lambda axis: values[axis]))


_SCENES: dict[str, Callable[..., Scene]] = {"resistance": resistance, "home": home}
_AS_SIMULATED = "as simulated"
# N s/m; by the eigenvalues, which know nothing that sticks, an upper corner bears this and less than twice as much.
MILD = 5.0


@dataclass(frozen=True)
class FigureCase:
    """A scene under one set of assumptions.

    Attributes:
        name: What is other than in the scene.
        figures: Setting or run -> its figures, units in their names.
        kept: Whether the scene keeps its promises.
    """

    name: str
    figures: dict[str, dict[str, Any]]
    kept: bool


def figure_cases(
    machine: MachineModel, scene: str, delay: float, seed: int, progress: Callable[[str], None] = lambda _: None
) -> list[FigureCase]:
    """Simulates a scene under each set of assumptions.

    Args:
        machine: The device.
        scene: "resistance" or "home".
        delay: Of the scene's own case, from reading to torque, s.
        seed: Of the places of the counts, and of the noise.
        progress: Told what is simulated.

    Returns:
        The scene's own first.
    """
    found = []
    for name, late, assumed in _assumptions(scene, delay):
        progress(name)
        done = _SCENES[scene](machine, delay=late, seed=seed, assumed=assumed)
        found.append(FigureCase(name, _figures(done), done.kept))
    return found


def _assumptions(scene: str, delay: float) -> Iterator[tuple[str, float, Assumed]]:
    yield _AS_SIMULATED, delay, NOMINAL
    yield "no delay", 0.0, NOMINAL
    yield "a period of delay", PERIOD, NOMINAL
    yield "least friction", delay, Assumed(friction=0)
    yield "largest friction", delay, Assumed(friction=2)
    yield "noise", delay, Assumed(noise=True)
    yield "cable, structure", delay, Assumed(gives=True)
    if scene == "resistance":
        yield f"cable, structure, {MILD:g} N s/m at most", delay, Assumed(gives=True, damping=MILD)
        yield from ((f"led by a {name} hand", delay, Assumed(hand=hand)) for name, hand in HANDS.items())


def _figures(scene: Scene) -> dict[str, dict[str, Any]]:
    """What the paper's figures show of a scene."""
    if scene.name == "resistance":
        names = ("damping_applied_N_s_per_m", "least_corner_force_N", "rms_deviation_N", "largest_deviation_N")
        return {one: {name: facts[name] for name in names} for one, facts in scene.facts["settings"].items()}
    names = ("damping_applied_N_s_per_m", "capped", "settling_s", "overshoot_mm", "swing_um", "verdict")
    return {run.name: {name: run.facts[name] for name in names} for run in scene.runs}


def figure_discussion(scene: str, found: list[FigureCase]) -> list[str]:
    """Says in sentences what the cases show; every figure is one of theirs."""
    reported = _corners if scene == "resistance" else _ways
    figures = "Figures 14 and 15" if scene == "resistance" else "Figure 16"
    cases = "; ".join(f"{one.name} {reported(one)}" for one in found)
    unit = "least force at a corner in N (off the law by N rms)" if scene == "resistance" else "s until home"
    said = [f"{figures} again, one change alone, {unit}: {cases}."]
    lost = [one.name for one in found if not one.kept]
    said.append(f"Promises are not kept with: {', '.join(lost)}." if lost else "Promises are kept in all of them.")
    if scene == "home":
        shaken = [one.name for one in found if any("limit cycle" in f["verdict"] for f in _uncapped(one))]
        said.append(f"The paper's damping without a cap falls into a limit cycle with: {', '.join(shaken) or 'none'}.")
    return said


def _corners(case: FigureCase) -> str:
    parts = (f"{f['least_corner_force_N']:.2f} ({f['rms_deviation_N']:.2f})" for f in case.figures.values())
    return " and ".join(parts)


def _ways(case: FigureCase) -> str:
    times = [f["settling_s"] for f in case.figures.values() if f["capped"]]
    return " / ".join("-" if one is None else f"{one:.2f}" for one in times)


def _uncapped(case: FigureCase) -> list[dict[str, Any]]:
    return [figures for figures in case.figures.values() if not figures["capped"]]
