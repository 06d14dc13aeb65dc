"""Virtual walls across each axis, against which a hand pushes the handle and holds it: do they stand?

Source:
    [RCIM2018] eq. (24), figures 17 and 18, table 13.
"""

from __future__ import annotations

from typing import Any

from delta_cad.common.units import MM_PER_M
from haptics.control.supervisor.faults import described
from haptics.gravity.published import STIFFNESS_N_PER_MM
from haptics.loop.assumptions import DELAY
from haptics.loop.choice import LoopChoice
from haptics.loop.wall_trial import READY, WallBench, WallTrial
from haptics.loop.walls import START, WallSearch, search
from haptics.model.hands import HAND_MODELS
from haptics.model.machine import MachineModel
from haptics.rendering.laws.virtual_wall import AXES
from haptics.scenes.bench import PERIOD, motors_force
from haptics.scenes.record import Promise, Scene, SceneRun, series, supervised

# First step, ceiling and tolerance of the search for the limit, N/m: coarser and farther than the paper's protocol,
# which `stiffness` follows.
STEP, CEILING, _TOLERANCE = 1000.0, 40e3, 25.0
_ABOVE = 1.3  # Times the limit: clearly beyond it
_VERDICTS = {"settles": "stands", "sustained": "oscillates", "grows": "oscillates and grows", "diverged": "diverges"}


def wall(
    machine: MachineModel,
    *,
    hand: str = "medium",
    delay: float = DELAY[1] * PERIOD,
    seed: int = 0,
    loop: LoopChoice | None = None,
) -> Scene:
    """Three walls across each axis: the paper's first, the paper's largest, and one above our own limit.

    Args:
        machine: The device.
        hand: Name in `HAND_MODELS`.
        delay: Of the paper loop, s.
        seed: Seed of the places of the encoders' counts.
        loop: In place of the paper loop, with all that the device has; see `WallBench`.

    Returns:
        The scene: 9 runs.
    """
    who = HAND_MODELS[hand]
    runs: list[SceneRun] = []
    limits: dict[str, dict[str, Any]] = {}
    for axis in AXES:
        bench = WallBench(machine, axis, who.hand, delay=delay, seed=seed, loop=loop)
        limit_search = search(bench.stands, step=STEP, ceiling=CEILING, tolerance=_TOLERANCE)
        published = MM_PER_M * STIFFNESS_N_PER_MM[axis]
        limits[axis] = {
            "simulated_N_per_mm": limit_search.bisection / MM_PER_M,
            "never_oscillated": limit_search.ceiling_reached,
            "published_N_per_mm": STIFFNESS_N_PER_MM[axis],
        }
        above = _ABOVE * (limit_search.bisection or START)
        for role, stiffness in (("first", START), ("published", published), ("above", above)):
            runs.append(_run(machine, axis, role, bench.trial(stiffness), limit_search))
    first = [run for run in runs if run.facts["role"] == "first"]
    promises = [
        Promise(
            f"the paper's first wall, {START / MM_PER_M:g} N/mm, stands across each axis",
            all(run.facts["stable"] for run in first),
        ),
        Promise("the supervisor finds no fault there", not any(run.facts["supervisor_fault"] for run in first)),
    ]
    facts = {
        "hand": {"name": hand, **who.hand._asdict(), "meaning": who.meaning, "source": who.source},
        "force_limit_N": machine.design.requirements.force_N,
        "limits": limits,
    }
    return Scene("wall", "figures 17 and 18", runs, facts, promises, _discussion(hand, limits, runs))


def _run(machine: MachineModel, axis: str, role: str, trial: WallTrial, limit_search: WallSearch) -> SceneRun:
    stiffness, verdict = trial.stiffness / MM_PER_M, trial.verdict
    if verdict is not None:
        text = _VERDICTS[verdict.kind]
    else:
        text = f"fault: {described(trial.faults)}" if trial.faults else "is not leant on: the handle is driven off"
    facts: dict[str, Any] = {
        "axis": axis,
        "role": role,
        "stiffness_N_per_mm": stiffness,
        "share_of_simulated_limit": trial.stiffness / limit_search.bisection if limit_search.bisection else None,
        "verdict": text,
        "stable": trial.stable,
        "penetration_at_end_mm": MM_PER_M * float(trial.depth[-100:].mean()),
        "force_at_end_N": float(trial.push[-100:].mean()),
        "largest_force_N": float(trial.push.max()),
        "count_um": 1e6 * trial.resolution,
    }
    if verdict is not None:
        facts |= {
            "swing_um": 1e6 * verdict.swing,
            "force_swing_N": verdict.force_swing,
            "frequency_Hz": verdict.frequency,
            "share_in_contact": verdict.contact,
        }
    columns = series(
        trial.recording,
        READY,
        motors_force(machine, trial.recording),
        penetration_mm=MM_PER_M * trial.depth,
        wall_force_N=trial.push,
    )
    label = f"{axis}, {stiffness:.3g} N/mm"
    return SceneRun(f"{axis}_{role}", label, trial.recording, columns, facts | supervised(trial.recording, READY))


def _discussion(hand: str, limits: dict[str, dict[str, Any]], runs: list[SceneRun]) -> list[str]:
    said = []
    for axis, limit in limits.items():
        own, theirs = limit["simulated_N_per_mm"], limit["published_N_per_mm"]
        more = "more than " if limit["never_oscillated"] else ""
        said.append(
            f"{axis}: with a {hand} hand walls stand up to {more}{own:.1f} N/mm here; the paper felt oscillation "
            f"above {theirs:g} N/mm."
        )
    worst = max((run for run in runs if run.facts.get("swing_um")), key=lambda run: run.facts["swing_um"], default=None)
    if worst is not None and not worst.facts["stable"]:
        f = worst.facts
        said.append(
            f"Beyond the limit the handle swings by {f['swing_um']:.0f} um at {f['frequency_Hz']:.0f} Hz "
            f"({worst.label}), the force by {f['force_swing_N']:.2g} N."
        )
    said.append(
        "The limit depends on hand, friction and delay, which the paper does not give; `stiffness` gives the range. "
        "Hands differ by what their grasps damp: a loop hardly feels the arm behind. Nothing was fitted to the paper."
    )
    return said
