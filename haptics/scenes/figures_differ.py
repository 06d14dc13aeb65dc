"""The paper's figures 14 to 16 again, one assumption of their models changed at a time.

Source:
    [RCIM2018] figures 14 to 16. Friction, delay, noise and what gives way are not given there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.scenes.bench import NOMINAL, PERIOD, Assumed
from haptics.scenes.home import home
from haptics.scenes.record import Scene
from haptics.scenes.resistance import resistance

SCENES: dict[str, Callable[..., Scene]] = {"resistance": resistance, "home": home}
AS_SIMULATED = "as simulated"
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
        done = SCENES[scene](machine, delay=late, seed=seed, assumed=assumed)
        found.append(FigureCase(name, _figures(done), done.kept))
    return found


def _assumptions(scene: str, delay: float) -> Iterator[tuple[str, float, Assumed]]:
    yield AS_SIMULATED, delay, NOMINAL
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
    told = _corners if scene == "resistance" else _ways
    figures = "Figures 14 and 15" if scene == "resistance" else "Figure 16"
    cases = "; ".join(f"{one.name} {told(one)}" for one in found)
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
