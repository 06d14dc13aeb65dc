"""The effect of encoder noise: a held spring, and a wall under a leaning hand, with three encoders.

The board loop, or the one that is chosen, and the device with all that gives way. The design's own encoder stands
with a coarse one of the catalogue and one without any error; each figure with the prediction by the covariance of the
linear loop (`loop/noise.py`), which knows no friction that sticks and no counts.
"""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from haptics.control.supervisor.faults import FaultCode
from haptics.loop.assumptions import encoder_count
from haptics.loop.choice import BOARD, LoopChoice
from haptics.loop.hardware import board_controller, reading_age, real_plant, sensor_errors, structure_text
from haptics.loop.noise import FORCE, LEAST_FELT, MOTION, SPRING, BAND_Hz, NoisyLoop
from haptics.loop.simulation import SimulatedRun, simulate, timing
from haptics.loop.wall_trial import LOOP_SUBSTEPS
from haptics.loop.walls import capped
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, Hand
from haptics.model.sensor import EXACT, SensorErrors
from haptics.rendering import law_table
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.laws.virtual_wall import axis_wall
from haptics.scenes.bench import motors_force
from haptics.scenes.record import Promise, Scene, SceneRun, series, supervised

_COARSE = "as5048a-board"  # The row beside which the design's own is shown
_WALL = 5000.0  # Stiffness of the wall, N/m
_LEAN = 0.6  # Force with which the hand leans on it, as a share of the design's
READY, _LASTS = 1.6, 2.0  # The ramp of the supervisor and the hand's way into the wall; what is looked at after it, s
_WHO = "medium"
_IN_HAND = 0.9  # Share of the damping that noise allows that is applied: two seconds do not tell 5 % of a variance


def noise(machine: MachineModel, *, loop: LoopChoice = BOARD, seed: int = 0) -> Scene:
    """A held spring and a wall with three encoders.

    Args:
        machine: The device.
        loop: The loop.
        seed: Seed of noise and places of counts.

    Returns:
        The scene: 6 runs.
    """
    stiffness, requested = SPRING
    limit = NoisyLoop(machine, loop).damping_limit(stiffness)
    own = machine.design.hardware.encoder_at or machine.design.hardware.encoder
    coarse = replace(machine, design=_with_encoder(machine, _COARSE))
    sensors = {
        "own": (f"the design's own ({own})", sensor_errors(machine, loop), encoder_count(machine)),
        "coarse": (_COARSE, sensor_errors(coarse, loop), encoder_count(coarse)),
        "exact": ("without any error", EXACT, 0.0),
    }
    damping = min(requested, _IN_HAND * limit)
    runs = []
    for role, (label, errors, count) in sensors.items():
        for law in ("spring", "wall"):
            runs.append(_run(machine, loop, law, role, label, errors, count, damping, seed))
    facts: dict[str, Any] = {
        "assumptions": _assumptions(machine, loop, seed),
        "spring": {
            "stiffness_N_per_m": stiffness,
            "damping_asked_N_s_per_m": requested,
            "damping_limit_by_noise_N_s_per_m": limit,
            "damping_applied_N_s_per_m": damping,
        },
        "wall": {"stiffness_N_per_mm": _WALL / MM_PER_M, "damping_N_s_per_m": loop.damping, "hand": _WHO},
        "limits": {"force_N_rms": FORCE, "motion_um_rms": 1e6 * MOTION, "band_Hz": list(BAND_Hz)},
        "least_felt_um": 1e6 * LEAST_FELT,
    }
    mine = [run for run in runs if run.facts["encoder"] == "own"]
    force, motion = (max(run.facts[what] for run in mine) for what in ("force_N_rms", "motion_um_rms"))
    promises = [
        Promise(
            f"at the centre noise commands at most {FORCE:g} N rms, a limit of this project: {force:.3f} N",
            force <= FORCE,
        ),
        Promise(
            f"it moves the handle by at most {1e6 * MOTION:g} um rms in {BAND_Hz[0]:g} to {BAND_Hz[1]:g} Hz, likewise: "
            f"{motion:.3f} um",
            motion <= 1e6 * MOTION,
        ),
        Promise("the supervisor finds nothing", not any(run.facts["supervisor_bits"] for run in mine)),
    ]
    return Scene("noise", "no figure", runs, facts, promises, _discussion(machine, runs, requested, limit))


def _with_encoder(machine: MachineModel, name: str) -> Any:
    hardware = machine.design.hardware.model_copy(update={"encoder": name, "encoder_at": None})
    return machine.design.model_copy(update={"hardware": hardware})


def _assumptions(machine: MachineModel, loop: LoopChoice, seed: int) -> dict[str, Any]:
    errors = sensor_errors(machine, loop)
    return {
        "loop": loop.label,
        "period_s": loop.period,
        "delay_s": loop.delay + reading_age(machine, loop),
        "seed": seed,
        "current_lag_s": loop.current_lag,
        "velocity_filter_Hz": loop.corner,
        "encoder_count_rad": encoder_count(machine),
        "encoder_noise_rad": errors.noise,
        "encoder_nonlinearity_rad": errors.once + errors.twice,
    }


def _run(
    machine: MachineModel, loop: LoopChoice, law: str, role: str, label: str, errors: SensorErrors, count: float,
    damping: float, seed: int,
) -> SceneRun:  # fmt: skip
    held = law == "spring"
    stiffness, damping = (SPRING[0], damping) if held else (_WALL, loop.damping)
    hand: Hand = FREE if held else HANDS[_WHO]
    recording = _simulate_law(machine, loop, stiffness, damping, hand, errors, count, seed)
    late = recording.time >= READY
    width = math.hypot(errors.noise, count / math.sqrt(12.0))
    normal = None if held else np.array([1.0, 0.0, 0.0])
    same = real_plant(machine, loop)  # its structure alike in all directions
    reported = NoisyLoop(machine, loop, hand=hand, noise=width, kept=errors.kept, normal=normal, par=same).figures(
        stiffness, damping
    )
    bits = int(np.bitwise_or.reduce(recording.bits[1:]))
    facts: dict[str, Any] = {
        "law": law,
        "encoder": role,
        "stiffness_N_per_m": stiffness,
        "damping_N_s_per_m": damping,
        "force_N_rms": _noisiest(recording.force[late]),
        "force_predicted_N_rms": reported.force,
        "motion_um_rms": 1e6 * _noisiest(in_band(recording.knob[late], loop.period)),
        "motion_predicted_um_rms": 1e6 * reported.motion,
        "supervisor_bits": bits,
    }
    shown = SimulatedRun(**{field.name: getattr(recording, field.name)[late] for field in fields(recording)})
    columns = series(shown, READY, motors_force(machine, shown))
    return SceneRun(f"{law}_{role}", f"{law}, {label}", shown, columns, facts | supervised(recording, 0.0))


def _simulate_law(
    machine: MachineModel, loop: LoopChoice, stiffness: float, damping: float, hand: Hand, errors: SensorErrors,
    count: float, seed: int,
) -> SimulatedRun:  # fmt: skip
    """Simulates a spring about the cube's centre with nobody, or a wall across x that a hand leans on.

    Args:
        machine: The device.
        loop: The loop.
        stiffness: K, N/m.
        damping: B, N s/m.
        hand: Who leans on a wall; `FREE` for the spring.
        errors: Of the encoders.
        count: Of the encoders, rad.
        seed: Of the noise.

    Returns:
        The run; the wall is leant on from `READY` on.
    """
    centre, ticks = machine.centre, round((READY + _LASTS) / loop.period)
    anchor = np.tile(centre, (ticks, 1))
    if hand.stiffness > 0.0:
        lean = _LEAN * machine.design.requirements.force_N
        share = np.clip((np.arange(ticks) * loop.period - 0.6) / 0.6, 0.0, 1.0)
        anchor[:, 0] += share**2 * (3.0 - 2.0 * share) * (lean / stiffness + lean / hand.leaning)
        law = capped(machine, axis_wall("+x", float(centre[0]), stiffness=stiffness, damping=damping), centre, loop)
    else:
        law = SpringDamper(stiffness=stiffness, damping=damping, point=centre)
    # the encoders are any, and not those whose noise the limits of readings follow from
    controller = board_controller(machine, loop, repeats=math.inf, all_repeat=math.inf, kink=math.inf)
    return simulate(
        real_plant(machine, loop),
        controller._replace(force=machine.design.requirements.force_N),
        law_table(law),
        timing(loop.period, loop.delay + reading_age(machine, loop), LOOP_SUBSTEPS),
        centre,
        hand=hand,
        anchor=anchor,
        push=np.zeros_like(anchor),
        count=count,
        errors=errors,
        seed=seed,
    )


def in_band(series: np.ndarray, period: float) -> np.ndarray:
    """The part of a series (n, k) that lies in the band, by its lines; the first and last tenth are left out."""
    lines = np.fft.rfft(series - series.mean(axis=0), axis=0)
    at = np.fft.rfftfreq(len(series), period)
    lines[(at < BAND_Hz[0]) | (at > BAND_Hz[1])] = 0.0
    edge = len(series) // 10
    return np.fft.irfft(lines, len(series), axis=0)[edge:-edge]


def _noisiest(series: np.ndarray) -> float:
    """Root mean square of a series (n, 3) off its mean, in the direction where that is largest."""
    return math.sqrt(max(0.0, float(np.linalg.eigvalsh(np.cov(series.T, bias=True))[-1])))


def _felt(motion: float) -> str:
    """Says who feels a motion in the band, m rms, by the least threshold that a source has."""
    if motion <= LEAST_FELT:
        return f"No hand is known to feel this noise: {1e6 * motion:.3f} um is below {1e6 * LEAST_FELT:g} um."
    return (
        f"Sensitive hands may feel it: {1e6 * motion:.3f} um is {motion / LEAST_FELT:.1f} times the "
        f"{1e6 * LEAST_FELT:g} um that the most sensitive of 19 subjects detected through a grasped cylinder "
        "(Brisben et al. 1999)."
    )


def _discussion(machine: MachineModel, runs: list[SceneRun], requested: float, limit: float) -> list[str]:
    by = {(run.facts["law"], run.facts["encoder"]): run.facts for run in runs}
    force, motion = (by["wall", "coarse"][f"{what}_rms"] for what in ("force_predicted_N", "motion_predicted_um"))
    said = [
        _felt(1e-6 * max(run.facts["motion_um_rms"] for run in runs if run.facts["encoder"] == "own")),
        f"Noise alone limits a spring's damping to {limit:.3g} N s/m, at {FORCE:g} N and {1e6 * MOTION:g} um rms; "
        f"{requested:g} were requested.",
        f"With the {_COARSE} noise is predicted to command {force:.2f} N rms in a wall of {_WALL / MM_PER_M:g} N/mm, "
        f"and to move the handle by {motion:.2f} um rms in the band.",
        "Predictions leave out friction that sticks: it stiffens a handle at rest, and changes its motion by a third.",
        f"{structure_text(machine)}, its softest direction in all. Where it rings within 150 to 500 Hz it moves the "
        "handle ten times as far: `feel` gives the range.",
    ]
    for law in ("spring", "wall"):
        bits = by[law, "coarse"]["supervisor_bits"]
        if bits & FaultCode.RAMP_HELD.bit:
            said.append(f"With it a {law} never comes in: noise gives the hand power, and its ramp is held.")
        elif bits & FaultCode.ENERGY_LIMITED.bit:
            said.append(f"With it the supervisor takes a {law} away: noise has given the hand all that it may give.")
    return said
