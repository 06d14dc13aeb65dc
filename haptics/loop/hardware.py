"""Real sensors and drives: data of catalogue and design, and assumptions where data are missing.

`nominal_plant` of `assumptions` is rigid, without stops and ripple; `real_plant` here has them all. Importing this
module loads numba.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.dimensions import DimensionError, Dimensions, dimensions
from delta_cad.mechanism import jacobian
from haptics.control.controller import Controller
from haptics.control.filters import low_pass
from haptics.control.supervisor.limits import SafetyLimits, checked
from haptics.control.wall_cap import STABILITY_MARGIN, WallCap
from haptics.loop.assumptions import default_controller, encoder_count, joint_friction, nominal_plant
from haptics.loop.choice import BOARD, LoopChoice
from haptics.model.machine import MachineModel
from haptics.model.plant import Plant
from haptics.model.sensor import SensorErrors

# Noise of a reading whose row in the catalogue tells none, rad rms: a count of 18 bits, or a count of its own where
# that is coarser; a quarter to four times it is the range. The MT6835's data sheet states 1.1 of it.
UNKNOWN_NOISE = 2.0 * math.pi / 2**18
# Time constants of a filter of first order in which a step settles to 2 %: the definition of textbooks, taken of the
# data sheet's, too. Three of them, to 5 %, would leave a tenth more noise; of filters that follow a steady motion
# without lag, as a delay of 10 us beside a step of 100 suggests, less.
_SETTLED = 4.0
# Share of a sensor's non-linearity that is left after it was calibrated against the mechanism's own closure or a
# fixture.
_LEFT_OVER = 0.1
# An encoder may be this much quieter than its row states, and a healthy device may be stopped for readings that repeat
# once in this time of running, s: ten years.
QUIETER, ALARM_s = 0.5, 10.0 * 365.25 * 86_400.0
# Standard deviations of a normal number that three joints at 8 kHz pass once in that time, and how much louder than its
# row states an encoder may be, or than is assumed where none does.
_TAIL, _LOUDER, _UNKNOWN_SPREAD = 7.4, 2.0, 4.0
# Share of critical damping of cable and structure, least, nominal, largest: wire rope with grease and bolted aluminium;
# loss factors of 0.02 to 0.1, from memory.
LOSS = (0.01, 0.02, 0.05)
# Structures that a device without a build may have, as multiples of the stiffness that its design requires: that is the
# least that a build passes, and without the cable, which is a spring of its own, joints, rods and arms of the committed
# design come to ten times that in the cube's centre. Each a third stiffer than the last: what noise moves jumps where
# the knob begins to ring within the band, and falls slowly beyond; between two of them it is up to 6 % more.
STIFFER = tuple(10.0 ** (k / 8.0) for k in range(9))
# The same of the structure that a build computed: a fifth softer to a fifth stiffer.
BUILT_SHARES = (0.8, 0.9, 1.0, 1.1, 1.2)
# Least stiffness at the knob, N/m, of a design that requires none: what omega.3's maker is said to claim, from memory.
_STRUCTURE = 14.5e3
# Deviation of a motor's torque from its current's, as a share, where its row tells none, from memory: 1 to 5 % is the
# range. Its waves a turn: of a brushed motor those of its commutator, maxon's 13 segments where its row tells none; of
# brushless ones six a pole pair, of which 8 are assumed.
_RIPPLE, _SEGMENTS, _POLE_WAVES = 0.02, 13, 48.0
_STOP_STIFFNESS, _STOP_RATIO = (
    500.0,
    0.3,
)  # N m/rad of an arm's steel pin on its stop, share of critical damping: guesses
_BEZEL_STIFFNESS = 2e5  # N/m of a stem on a bezel of polyacetal, with the arms' share of damping: a guess
_LEAST_LEFT = 0.01  # Of the largest flexibility, that of the stiffest direction, at least
# Way of a strand from the sector's rim to where it is held, mean of both, m: nose, anchor and carriage.
_BEYOND = 10.7e-3
_RIM = 2.7  # Angle of a sector's rim where the design cannot be built, rad


@dataclass(frozen=True)
class _Compliance:
    """Compliances of a device.

    Attributes:
        cable: Stiffness of a joint's cable, N m/rad; 0 for a direct drive.
        structure: Stiffness of the rest at the knob in its softest direction in the cube's centre, N/m.
        knob: Mass that swings on it, kg: the platform with all it carries, since most of what gives way are joints,
            rods and bars under it.
    """

    cable: float
    structure: float
    knob: float


def compliance(machine: MachineModel) -> _Compliance:
    """Computes the compliances: two strands of rope on the sector, and the structure from `structure_stiffness`.

    The strands are taken as equal, at the middle of the sector's turn, where the cable is softest; the sector's rim and
    the motor's shaft take some 3 % off.
    """
    softest = float(np.linalg.eigvalsh(structure_stiffness(machine, machine.centre))[0])
    return _Compliance(_cable_stiffness(machine), softest, machine.masses.platform)


def structure_stiffness(machine: MachineModel, p: np.ndarray) -> np.ndarray:
    """Stiffness at the knob without the cable's compliance: as built, or as the design requires without a build.

    Args:
        machine: The device.
        p: (3,) position, m.

    Returns:
        (3, 3) N/m; alike in all directions, `stiffness_min_N_mm`, where no build is at hand.
    """
    if machine.structure is None:
        required = machine.design.requirements.stiffness_min_N_mm
        return (_STRUCTURE if required is None else required * MM_PER_M) * np.eye(3)
    cable = _cable_stiffness(machine)
    columns = jacobian(machine.geometry, p)
    flexibility = machine.structure.at(p) - (columns @ columns.T / cable if cable > 0.0 else 0.0)
    values, axes = np.linalg.eigh(flexibility)
    # the two cables differ by some per cent: where little else gives way, what is left may not be negative
    return (axes / np.maximum(values, _LEAST_LEFT * values[-1])) @ axes.T


def structure_text(machine: MachineModel) -> str:
    """Where the structure's stiffness comes from."""
    if machine.structure is not None:
        return "Structure as built (structure.json)"
    required = machine.design.requirements.stiffness_min_N_mm
    what = f"assumed, {_STRUCTURE / MM_PER_M:g} N/mm" if required is None else f"required, {required:g} N/mm"
    return f"Structure as {what}: no structure.json of a build is at hand"


def _cable_stiffness(machine: MachineModel) -> float:
    """Stiffness of a joint's cable, N m/rad; 0 for a direct drive."""
    design = machine.design
    if design.hardware.drive != "capstan":
        return 0.0
    row = catalogue.cable.chosen(design.hardware)
    _, pull = row.stiffness_N  # settled
    sizes = _sizes(machine)
    low, high = (0.0, _RIM) if sizes is None or sizes.capstan is None else sizes.capstan.rim_angles_rad
    radius = design.hardware.sector_radius_mm / MM_PER_M
    strand = radius * (high - low) / 2.0 + _BEYOND
    return 2.0 * pull / strand * radius**2


# The last design and its dimensions: walls are asked for at many poses, and a direct drive's dimensions take a second.
_LAST: list[tuple[Design, Dimensions | None]] = []


def _sizes(machine: MachineModel) -> Dimensions | None:
    """The dimensions of a design; None where it cannot be built, which has no stops and a sector as wide as most."""
    if not (_LAST and _LAST[0][0] is machine.design):
        try:
            found = dimensions(machine.design)
        except DimensionError:
            found = None
        _LAST[:] = [(machine.design, found)]
    return _LAST[0][1]


def sensor_errors(machine: MachineModel, loop: LoopChoice = BOARD) -> SensorErrors:
    """Errors of a design's encoders beyond their count; what is left of the non-linearity once they are calibrated.

    Half of it goes with one wave a turn, half with two. Optical encoders on motors have counts and no noise. The noise
    ahead of a chip's filter is taken as white: half the bandwidth lets half of its variance through.

    Args:
        machine: The device.
        loop: How often they are read, and how their filters are set.
    """
    hardware = machine.design.hardware
    if hardware.encoder_at == "motor":
        return SensorErrors(turns=machine.drive.ratio, at_motor=1.0)
    row = catalogue.encoder.chosen(hardware)
    count = 2.0 * math.pi / row.counts_per_turn
    noise = max(UNKNOWN_NOISE, count) if row.noise_rms_deg is None else math.radians(row.noise_rms_deg)
    wave = 0.5 * _LEFT_OVER * math.radians(row.nonlinearity_deg or 0.0)
    if row.settling_us is None:
        return SensorErrors(noise, wave, wave)
    lag = row.settling_us * 1e-6 / _SETTLED / loop.sensing
    return SensorErrors(math.sqrt(loop.sensing) * noise, wave, wave, kept=math.exp(-loop.period / lag))


def sensor_limits(machine: MachineModel, loop: LoopChoice = BOARD) -> dict[str, float]:
    """The supervisor's limits of a reading that follow from a design's encoders: `repeats`, `all_repeat`, `kink`.

    Whatever was read before, the next reading of noise that is `s` counts rms new falls into one count of all with a
    probability of at most `p = 1 / (sqrt(2 pi) s)`, the density's largest value; so n readings in a row repeat with at
    most p^n, and those of three joints together with p^(3 n). The limit is the n at which a healthy device is stopped
    less than once in `ALARM_s` of running, with an encoder that has `QUIETER` of the noise that its row states. An
    encoder whose row states no noise, or that counts lines on the motor, repeats rightly at rest: no limit then, and
    what sees that it stands still is ANGLE_FROZEN alone. A gain of speed that noise makes up is that of three readings,
    `n0 - 2 n1 + n2`: `_TAIL` standard deviations of it, of `_LOUDER` than the stated noise.

    Args:
        machine: The device.
        loop: How often they are read, and how their filters are set.

    Returns:
        Limit -> ticks, or rad for what noise adds to `kink`.
    """
    errors, hardware = sensor_errors(machine, loop), machine.design.hardware
    stated = hardware.encoder_at == "motor" or catalogue.encoder.chosen(hardware).noise_rms_deg is not None
    new = QUIETER * errors.noise * math.sqrt(1.0 - errors.kept**2) / encoder_count(machine) if stated else 0.0
    likely = 1.0 / (math.sqrt(2.0 * math.pi) * new) if new > 0.0 else math.inf
    needed = math.log(3.0 * ALARM_s / loop.period) / -math.log(likely) if likely < 1.0 else math.inf
    return {
        "repeats": float(math.ceil(needed)) if needed < math.inf else math.inf,
        "all_repeat": float(math.ceil(needed / 3.0)) if needed < math.inf else math.inf,
        "kink": _TAIL * math.sqrt(6.0) * (_LOUDER if stated else _UNKNOWN_SPREAD) * errors.noise,
    }


def reading_age(machine: MachineModel, loop: LoopChoice = BOARD) -> float:
    """Age of a reading when it is read, s: what the catalogue tells, 0 where no source does, and what the chip's filter
    lags more as the loop sets it.
    """
    hardware = machine.design.hardware
    if hardware.encoder_at == "motor":
        return 0.0
    row = catalogue.encoder.chosen(hardware)
    slower = (row.settling_us or 0.0) / _SETTLED * (1.0 / loop.sensing - 1.0)
    return ((row.latency_us or 0.0) + slower) * 1e-6


def _ripple_waves(motor: catalogue.Motor) -> float:
    """Counts the waves of a motor's torque in a turn: segments pass two brushes, which an odd number meets in turn."""
    if motor.commutation != "brushed":
        return _POLE_WAVES
    segments = _SEGMENTS if motor.commutator_segments is None else motor.commutator_segments
    return float(segments * (2 if segments % 2 else 1))


def drive_damping(machine: MachineModel, share: float) -> float:
    """Physical damping of a joint by its motor, N m s/rad at the joint.

    Args:
        machine: The device.
        share: Of the short-circuit damping `k_t^2 / R`, which a resistor across the motor of (1 / share - 1) R gives,
            or the amplifier's inner loop; no controller takes part.
    """
    motor = catalogue.motor.chosen(machine.design.hardware)
    return share * machine.drive.ratio**2 * motor.torque_constant_N_m_A**2 / motor.resistance_ohm


def stiff_plant(machine: MachineModel, loop: LoopChoice = BOARD, place: int = 1) -> Plant:
    """The device in a loop, rigid, with friction at a place of its range: 0 least, 1 nominal, 2 largest."""
    par = joint_friction(machine).of(nominal_plant(machine), place)
    return par._replace(
        viscous=par.viscous + drive_damping(machine, loop.drive_damping),
        contact_damping=drive_damping(machine, loop.contact_damping - loop.drive_damping),
        current_lag=loop.current_lag,
    )


def real_plant(machine: MachineModel, loop: LoopChoice = BOARD, place: int = 1) -> Plant:
    """The device in a loop with all that it has: cable and structure that give way, stops, ripple, cogging.

    Args:
        machine: The device.
        loop: Whose current loop and drive damping it has.
        place: Of friction and of what cable and structure damp: 0 least, 1 nominal, 2 largest.
    """
    friction, gives = joint_friction(machine), compliance(machine)
    par, design = stiff_plant(machine, loop, place), machine.design
    motor = catalogue.motor.chosen(design.hardware)
    sizes = _sizes(machine)
    low, high = (-math.inf, math.inf) if sizes is None else sizes.stops_rad
    stop_damping = 2.0 * _STOP_RATIO * math.sqrt(_STOP_STIFFNESS * par.joint_inertia)
    waves = _ripple_waves(motor)
    par = par._replace(
        platform=par.platform - gives.knob,
        knob=gives.knob,
        structure_stiffness=gives.structure,
        structure_damping=2.0 * LOSS[place] * math.sqrt(gives.structure * gives.knob),
        stop_low=low,
        stop_high=high,
        stop_stiffness=_STOP_STIFFNESS,
        stop_damping=stop_damping,
        ripple=_RIPPLE if motor.torque_ripple is None else motor.torque_ripple,
        ripple_per_rad=waves * machine.drive.ratio,
        cogging=machine.drive.ratio * (motor.cogging_torque_N_m or 0.0),
        cogging_per_rad=waves * machine.drive.ratio,
    )
    if sizes is not None and sizes.panel is not None:
        par = par._replace(
            bezel_x=float(machine.centre[0]),
            bezel_half=sizes.panel.half_mm / MM_PER_M,
            bezel_limit=sizes.panel.limit_mm / MM_PER_M,
            bezel_stiffness=_BEZEL_STIFFNESS,
            bezel_damping=2.0 * _STOP_RATIO * math.sqrt(_BEZEL_STIFFNESS * machine.masses.platform),
        )
    if gives.cable == 0.0:
        return par
    rotor, arm = machine.masses.rotor_inertia, machine.masses.arm_inertia
    both = rotor * arm / (rotor + arm)
    return par._replace(
        coulomb=friction.drive[place],
        arm_coulomb=friction.coulomb[place] - friction.drive[place],
        joint_inertia=arm,
        rotor_inertia=rotor,
        cable_stiffness=gives.cable,
        cable_damping=2.0 * LOSS[place] * math.sqrt(gives.cable * both),
    )


def board_controller(machine: MachineModel, loop: LoopChoice = BOARD, **limits: float) -> Controller:
    """The controller of a device in a loop: its period, its velocity filter, and its stable walls.

    Args:
        machine: The device.
        loop: The loop.
        **limits: Any of `SafetyLimits`, to replace what follows from the design.
    """
    plain = default_controller(machine, loop.period, low_pass(loop.period, loop.corner), **limits)
    known = {name: value for name, value in sensor_limits(machine, loop).items() if name not in limits}
    return plain._replace(limits=with_sensors(plain.limits, known), walls=wall_cap(machine, loop))


def with_sensors(limits: SafetyLimits, known: dict[str, float]) -> SafetyLimits:
    """Limits with those of `sensor_limits`, whose `kink` comes on top."""
    return checked(limits._replace(**{**known, "kink": limits.kink + known.get("kink", 0.0)}))


def wall_cap(machine: MachineModel, loop: LoopChoice = BOARD, share: float = STABILITY_MARGIN) -> WallCap:
    """The stable walls of a loop: with the least friction and the largest delay.

    Args:
        machine: The device.
        loop: The loop.
        share: Of the closed form.
    """
    cost = loop.period / 2.0 + loop.delays[2] * loop.period + reading_age(machine, loop) + loop.current_lag
    return WallCap(
        share=share,
        friction=stiff_plant(machine, loop, 0).in_contact.viscous,
        cost=cost,
        inertia=machine.masses.arm_inertia + machine.masses.rotor_inertia,
        late=cost + 1.0 / (2.0 * math.pi * loop.corner),
        damping=loop.damping,
        blend=loop.blend,
    )
