"""The way home of a handle that is let go away from the origin: settling time, overshoot, oscillation.

A damping beyond what the loop bears is applied uncapped, too, and shows what the cap prevents.

Source:
    [RCIM2018] figure 16, with k = 0.4 N/mm; b = 500 N s/m was chosen there, 400 shown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import jacobian
from haptics.loop.assumptions import DELAY, encoder_count
from haptics.loop.simulation import SimulatedRun
from haptics.loop.wall_trial import LEAST, decay_ratio, off_line, oscillation, strongest_line
from haptics.model.machine import MachineModel
from haptics.rendering.laws.operating_resistance import PAPER_SETTINGS, OperatingResistance
from haptics.scenes.bench import (
    NOMINAL,
    PERIOD,
    READY,
    Assumed,
    damping_limit,
    friction_force,
    friction_holds,
    mass_for_damping,
    motors_force,
    rendered,
    smallest_mass,
)
from haptics.scenes.record import Promise, Scene, SceneRun, series, supervised

_SETTING = "k0.4"
DAMPINGS = (2.0, 5.0, 10.0, 20.0, 400.0, 500.0)  # N s/m; the last two are the paper's
_PAPERS = DAMPINGS[-2:]
_FREE_S = 6.0  # Time that the handle is given, s; a damper of 500 N s/m takes about that
_START = 0.6  # Where it is let go along (1, 1, 1): share of half the cube's side
_WINDOW = (
    0.5  # Length of each of the two windows at the end of the way in which the handle is tested for oscillation, s
)
_SLOW = 0.1  # Motion slower than this is the way home, not a buzz, s
# Times the friction that may hold the handle before it is home: the bristles' bend and one count beyond it.
_ARRIVED = 1.05
STILL = 1e-7  # Swing, m, below which no frequency is given: ten times the last digit of the series that are written
# Counts of the encoders that a swing must have to be called a ringing; what is less, hardly any of them sees.
_RINGS = 0.5


@dataclass(frozen=True)
class _Buzz:
    """Swing of the handle at the end of its way, and the force behind it.

    Attributes:
        swing: Peak to peak of the position along its main direction in the last window, m.
        force: Peak to peak of the rendered force along it, N.
        frequency: Frequency of the position's strongest line, Hz; None where the swing is below `STILL`.
        kind: Kind of `oscillation`; "free" where no force is rendered at all, so that no loop can oscillate.
        saturated: Share of the time in which the force is at its limit.
        ratio: Root mean square of the position in the last window to that in the one before.
        counts: The swing in counts of the encoder that sees most of it.
    """

    swing: float
    force: float
    frequency: float | None
    kind: str
    saturated: float
    ratio: float
    counts: float


def home(
    machine: MachineModel, *, delay: float = DELAY[1] * PERIOD, seed: int = 0, assumed: Assumed = NOMINAL
) -> Scene:
    """Lets the handle go with several dampings.

    Args:
        machine: The device.
        delay: s.
        seed: Seed of the places of the encoders' counts.
        assumed: Of the device.

    Returns:
        The scene: a run for each damping as it is applied, and for those of the paper one more without the cap.
    """
    setting, mass = PAPER_SETTINGS[_SETTING], smallest_mass(machine)
    cap = damping_limit(mass, delay, setting.stiffness)
    required_of: dict[float, list[float]] = {}
    for requested in DAMPINGS:
        required_of.setdefault(min(cap.applied(requested), assumed.damping), []).append(requested)
    runs = [_released(machine, setting, b, requested, delay, seed, assumed) for b, requested in required_of.items()]
    beyond = [b for b in _PAPERS if cap.applied(b) < b]
    runs += [_released(machine, setting, b, [b], delay, seed, assumed, capped=False) for b in beyond]
    middle, start = machine.centre, _start(machine)
    facts: dict[str, Any] = {
        "setting": _SETTING,
        "stiffness_N_per_m": setting.stiffness,
        "start_mm": [float(x) for x in MM_PER_M * start],
        "distance_at_start_mm": MM_PER_M * float(np.linalg.norm(start - middle)),
        "dead_radius_mm": MM_PER_M * setting.dead_radius,
        "largest_friction_N": friction_holds(machine),
        "home_radius_mm": MM_PER_M * _home_radius(machine, setting),
        "force_limit_N": machine.design.requirements.force_N,
        "smallest_effective_mass_kg": mass,
        "damping_limit_N_s_per_m": cap.limit,
        "damping_cap_N_s_per_m": cap.cap,
        "ideal_damper_settling_s": {
            f"{b:g}": ideal_settling(machine, setting, b, float(np.linalg.norm(start - middle))) for b in beyond
        },
        "mass_for_the_papers_damping_kg": mass_for_damping(setting.damping, delay, setting.stiffness),
    }
    safe = [run for run in runs if run.facts["capped"]]
    promises = [
        Promise(
            f"with damping up to the cap of {cap.cap:.1f} N s/m the handle comes home",
            all(run.facts["settling_s"] is not None for run in safe),
        ),
        Promise("and falls into no limit cycle there", not any(run.facts["limit_cycle"] for run in safe)),
        Promise("the supervisor finds no fault", not any(run.facts["supervisor_fault"] for run in safe)),
    ]
    return Scene("home", "figure 16", runs, facts, promises, _discussion(facts, runs))


def ideal_settling(machine: MachineModel, setting: OperatingResistance, damping: float, distance: float) -> float:
    """Time of an ideal, continuous damper without mass and friction to the home radius, s.

    Args:
        machine: The device, for its force limit and home radius.
        setting: k, r0, r1.
        damping: N s/m.
        distance: At the start, m.

    Returns:
        `b dd/dt = -min(k (d - r0), limit)` in closed form.
    """
    k, r0 = setting.stiffness, setting.dead_radius
    most = min(setting.plateau, machine.design.requirements.force_N)
    knee, end = r0 + most / k, _home_radius(machine, setting)
    plateau = max(distance - max(knee, end), 0.0) * damping / most
    return plateau + (damping / k * math.log((min(distance, knee) - r0) / (end - r0)) if end < knee else 0.0)


def _start(machine: MachineModel) -> np.ndarray:
    return machine.centre + _START * machine.half_side * np.ones(3) / math.sqrt(3.0)


def _home_radius(machine: MachineModel, setting: OperatingResistance) -> float:
    """Distance within which friction may hold the handle against the spring, m."""
    return setting.dead_radius + _ARRIVED * friction_holds(machine) / setting.stiffness


def _released(
    machine: MachineModel,
    setting: OperatingResistance,
    applied: float,
    requested: list[float],
    delay: float,
    seed: int,
    assumed: Assumed,
    *,
    capped: bool = True,
) -> SceneRun:
    middle, start = machine.centre, _start(machine)
    ticks = round((READY + _FREE_S) / PERIOD)
    time = np.arange(ticks) * PERIOD - READY
    limit = machine.design.requirements.force_N
    anchor = np.tile(start, (ticks, 1))
    recording = rendered(machine, setting, applied, delay, seed, start, anchor, held=time < 0.0, assumed=assumed)
    free = time >= 0.0
    along = recording.position - middle
    distance = np.linalg.norm(along, axis=1)
    outside = ~(distance[free] <= _home_radius(machine, setting))  # also where it is no number
    last = int(np.flatnonzero(outside)[-1]) + 1 if outside.any() else 0
    beyond = -np.nanmin(along[free] @ (start - middle)) / np.linalg.norm(start - middle)
    buzz = _buzzing(machine, recording, limit, _until(distance, time, setting.dead_radius))
    direction = (start - middle) / np.linalg.norm(start - middle)
    settles = last < len(outside)
    found = supervised(recording, READY)
    runs_on = not found["supervisor_fault"]  # after a fault the motors only brake: what moves is no property of the law
    driven = buzz.force > 2.0 * friction_force(machine, direction)  # else the force cannot shake the handle loose
    moves = math.isfinite(buzz.swing) and buzz.counts >= _RINGS
    facts: dict[str, Any] = {
        "damping_asked_N_s_per_m": requested,
        "damping_applied_N_s_per_m": applied,
        "capped": capped,
        "settling_s": PERIOD * last if settles else None,
        "overshoot_mm": MM_PER_M * max(0.0, float(beyond) - setting.dead_radius),
        "distance_at_end_mm": MM_PER_M * float(distance[-round(_WINDOW / PERIOD) :].mean()),
        "limit_cycle": runs_on and driven and buzz.kind in ("sustained", "grows"),
        "chatters": runs_on and driven and buzz.kind == "settles",
        "swing_um": 1e6 * buzz.swing,
        "force_swing_N": buzz.force,
        "frequency_Hz": buzz.frequency,
        "oscillation": buzz.kind,
        "rings": runs_on and moves and not driven,
        "swing_against_half_a_second_before": buzz.ratio,
        "share_of_time_at_force_limit": buzz.saturated,
    } | found
    facts["verdict"] = _verdict(facts)
    columns = series(recording, READY, motors_force(machine, recording), distance_mm=MM_PER_M * distance)
    name = f"b{applied:.3g}" + ("" if capped else "_uncapped")
    note = " (uncapped)"
    if capped:
        note = "" if requested == [applied] else f" ({' and '.join(f'{b:g}' for b in requested)} asked)"
    return SceneRun(name, f"b = {applied:.3g} N s/m{note}", recording, columns, facts)


def _verdict(facts: dict[str, Any]) -> str:
    if facts["supervisor_fault"]:
        return "fault: " + str(facts["supervisor_findings"])
    way = "comes home" if facts["settling_s"] is not None else "creeps, not home in time"
    if facts["limit_cycle"]:
        limited = " at the force limit" if facts["share_of_time_at_force_limit"] > 0.5 else ""
        return f"{way}, limit cycle{limited}"
    if facts["rings"]:
        return f"{way}, rings in the dead zone" if facts["oscillation"] == "free" else f"{way}, swings within friction"
    return f"{way}, chatters by single counts" if facts["chatters"] else way


def _until(distance: np.ndarray, time: np.ndarray, dead_radius: float) -> int:
    """Ticks up to which a run is tested: up to the dead zone, where there is no force, if it takes long; else all."""
    arrived = np.flatnonzero((distance <= dead_radius) & (time > 2.0 * _WINDOW + 2.0 * _SLOW))
    early = (distance[(time > 0.0) & (time <= 2.0 * _WINDOW + 2.0 * _SLOW)] <= dead_radius).any()
    return int(arrived[0]) if len(arrived) and not early else len(time)


def _buzzing(machine: MachineModel, recording: SimulatedRun, limit: float, until: int) -> _Buzz:
    """Amplitude and frequency of what the handle does in the two windows before a tick, its slow way taken off.

    Args:
        machine: The device.
        recording: At least two windows and the two ends of the moving mean before it.
        limit: Limit of the force, N.
        until: The tick.

    Returns:
        The buzz along the direction in which it is largest; "diverged" if the handle left what can be reached.
    """
    if not np.isfinite(recording.position).all():
        return _Buzz(math.inf, math.inf, None, "diverged", 0.0, math.inf, math.inf)
    edge, n = round(_SLOW / PERIOD / 2.0), 2 * round(_WINDOW / PERIOD)
    mean = np.hanning(2 * edge + 3)[1:-1]
    mean /= mean.sum()
    swings = []
    for array in (recording.position, recording.force):
        tail = array[until - n - 2 * edge : until]
        slow = np.column_stack([np.convolve(tail[:, k], mean, mode="valid") for k in range(3)])
        swings.append(tail[edge : edge + n] - slow)
    position, force = swings
    along = np.linalg.svd(position, full_matrices=False)[2][0]
    count = encoder_count(machine) * float(np.abs(along @ jacobian(machine.geometry, machine.centre)).max())
    resolution = max(count, 3.0 * LEAST)  # what is felt, however fine the encoder
    size = np.linalg.norm(recording.force[until - n : until], axis=1)
    x, f = position @ along, force @ along
    last = off_line(x[-(n // 2) :])
    swing = float(np.ptp(last))
    pushed = bool(size.any())  # in the dead zone no force is rendered
    kind = oscillation(x, size, PERIOD, resolution, window=_WINDOW).kind if pushed else "free"
    return _Buzz(
        swing,
        float(np.ptp(off_line(f[-(n // 2) :]))),
        strongest_line(last, PERIOD) if swing > STILL else None,
        kind,
        float(np.mean(size > 0.99 * limit)),
        decay_ratio(x),
        swing / resolution,
    )


def _discussion(facts: dict[str, Any], runs: list[SceneRun]) -> list[str]:
    said = [
        f"The loop bears {facts['damping_limit_N_s_per_m']:.0f} N s/m at 1 kHz, "
        f"{facts['damping_limit_N_s_per_m'] * PERIOD / facts['smallest_effective_mass_kg']:.2f} m / T of the smallest "
        f"effective mass, {facts['smallest_effective_mass_kg']:.3f} kg (2 m / T would be the most, without filter and "
        f"delay); half of it, {facts['damping_cap_N_s_per_m']:.1f} N s/m, is applied at most."
    ]
    for run in runs:
        f = run.facts
        if f["capped"] and f["chatters"]:
            said.append(
                f"With {f['damping_applied_N_s_per_m']:.1f} N s/m single counts of the encoders, seen as velocity, "
                f"make {f['force_swing_N']:.1f} N peak to peak of force at rest: stable, but to be felt."
            )
        if f["rings"]:
            said.append(_ringing(f))
        if not f["capped"] and not f["limit_cycle"]:
            said.append(f"b = {f['damping_applied_N_s_per_m']:g} N s/m applied as the paper has it: {f['verdict']}.")
        elif not f["capped"]:
            said.append(
                f"b = {f['damping_applied_N_s_per_m']:g} N s/m applied as the paper has it: {f['verdict']}. The "
                f"handle shakes by {f['swing_um']:.0f} um at {f['frequency_Hz']:.0f} Hz, the force by "
                f"{f['force_swing_N']:.1f} N peak to peak, at its limit "
                f"{100.0 * f['share_of_time_at_force_limit']:.0f} % of the time; "
                f"after {_FREE_S:g} s it is {f['distance_at_end_mm']:.1f} mm from the origin."
            )
    for b, seconds in facts["ideal_damper_settling_s"].items():
        said.append(f"An ideal damper of {b} N s/m without sampling would take {seconds:.1f} s to come home.")
    said.append(
        f"The paper chose b = 500 N s/m because nothing oscillated. Why it did not is not known: velocity filter, "
        f"masses and friction are not given. Here that b would take an effective mass of "
        f"{facts['mass_for_the_papers_damping_kg']:.2g} kg with the same margin."
    )
    said.append(
        f"The handle stops where friction, {facts['largest_friction_N']:.2f} N at most, holds it against the spring, "
        f"up to {facts['home_radius_mm']:.1f} mm from the origin; that radius counts as home."
    )
    return said


def _ringing(f: dict[str, Any]) -> str:
    if f["oscillation"] == "free":
        does, why = "rings", "no force is asked for there: mass on what friction gives way before it slips"
    else:
        does, why = "swings", f"the force, {f['force_swing_N']:.2f} N peak to peak, does not overcome friction"
    return (
        f"With {f['damping_applied_N_s_per_m']:.1f} N s/m the handle still {does} by {f['swing_um']:.0f} um at "
        f"{f['frequency_Hz']:.0f} Hz at the end, {f['swing_against_half_a_second_before']:.2f} times what it was half "
        f"a second before; {why}."
    )
