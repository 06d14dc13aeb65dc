"""Sensors and drives as they are: what catalogue and design tell of them, and what is assumed where they do not.

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
from haptics.control.wall_cap import SHARE, WallCap
from haptics.model.machine import MachineModel
from haptics.model.plant import Plant
from haptics.model.sensor import SensorErrors
from haptics.simulation.assumptions import default_controller, joint_friction, nominal_plant
from haptics.simulation.loops import BOARD, LoopChoice

# Noise of a reading whose row in the catalogue tells none, rad rms: a count of 18 bits, or a count of its own where
# that is coarser; a quarter to four times it is the range. The MT6835's data sheet states 1.1 of it.
UNKNOWN_NOISE = 2.0 * math.pi / 2**18
# Time constants of a filter of first order in which a step settles to 2 %: the definition of textbooks, taken of the
# data sheet's, too. Three of them, to 5 %, would leave a tenth more noise; of filters that follow a steady motion
# without lag, as a delay of 10 us beside a step of 100 suggests, less.
SETTLED = 4.0
# Share of a sensor's non-linearity that is left after it was calibrated against the mechanism's own closure or a
# fixture.
LEFT_OVER = 0.1
# Pull over stretch of a rope whose row tells none, N/mm^2 of its circle: the softest of those listed.
ROPE_N_mm2 = 42.4e3
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
STRUCTURE = 14.5e3
# Deviation of a motor's torque from its current's, as a share, where its row tells none, from memory: 1 to 5 % is the
# range. Its waves a turn: of a brushed motor those of its commutator, maxon's 13 segments where its row tells none; of
# brushless ones six a pole pair, of which 8 are assumed.
RIPPLE, SEGMENTS, POLE_WAVES = 0.02, 13, 48.0
STOP_STIFFNESS, STOP_RATIO = 500.0, 0.3  # N m/rad of an arm's steel pin on its stop, share of critical damping: guesses
BEZEL_STIFFNESS = 2e5  # N/m of a stem on a bezel of polyacetal, with the arms' share of damping: a guess
LEAST_LEFT = 0.01  # Of the largest flexibility, that of the stiffest direction, at least
# Way of a strand from the sector's rim to where it is held, mean of both, m: nose, anchor and carriage.
BEYOND = 10.7e-3
RIM = 2.7  # Angle of a sector's rim where the design cannot be built, rad


@dataclass(frozen=True)
class Compliance:
    """What gives way in a device.

    Attributes:
        cable: Stiffness of a joint's cable, N m/rad; 0 for a direct drive.
        structure: Stiffness of the rest at the knob in its softest direction in the cube's centre, N/m.
        knob: Mass that swings on it, kg: the platform with all it carries, since most of what gives way are joints,
            rods and bars under it.
    """

    cable: float
    structure: float
    knob: float


def compliance(machine: MachineModel) -> Compliance:
    """Computes what gives way: two strands of rope on the sector, and the structure, as `structure_stiffness` has it.

    The strands are taken as equal, at the middle of the sector's turn, where the cable is softest; the sector's rim and
    the motor's shaft take some 3 % off.
    """
    softest = float(np.linalg.eigvalsh(structure_stiffness(machine, machine.centre))[0])
    return Compliance(cable_stiffness(machine), softest, machine.masses.platform)


def structure_stiffness(machine: MachineModel, p: np.ndarray) -> np.ndarray:
    """Stiffness at the knob of what gives way besides the cable: as built, or as the design requires without a build.

    Args:
        machine: The device.
        p: (3,) position, m.

    Returns:
        (3, 3) N/m; alike in all directions, `stiffness_min_N_mm`, where no build is at hand.
    """
    if machine.structure is None:
        required = machine.design.requirements.stiffness_min_N_mm
        return (STRUCTURE if required is None else required * MM_PER_M) * np.eye(3)
    cable = cable_stiffness(machine)
    columns = jacobian(machine.geometry, p)
    flexibility = machine.structure.at(p) - (columns @ columns.T / cable if cable > 0.0 else 0.0)
    values, axes = np.linalg.eigh(flexibility)
    # the two cables differ by some per cent: where little else gives way, what is left may not be negative
    return (axes / np.maximum(values, LEAST_LEFT * values[-1])) @ axes.T


def structure_text(machine: MachineModel) -> str:
    """Where the structure's stiffness comes from."""
    if machine.structure is not None:
        return "Structure as built (structure.json)"
    required = machine.design.requirements.stiffness_min_N_mm
    what = f"assumed, {STRUCTURE / MM_PER_M:g} N/mm" if required is None else f"required, {required:g} N/mm"
    return f"Structure as {what}: no structure.json of a build is at hand"


def cable_stiffness(machine: MachineModel) -> float:
    """Stiffness of a joint's cable, N m/rad; 0 for a direct drive."""
    design = machine.design
    if design.hardware.drive != "capstan":
        return 0.0
    row = catalogue.cable.chosen(design.hardware)
    pull = row.axial_stiffness_N or ROPE_N_mm2 * math.pi / 4.0 * row.diameter_mm**2
    sizes = _sizes(machine)
    low, high = (0.0, RIM) if sizes is None or sizes.capstan is None else sizes.capstan.rim_angles_rad
    radius = design.hardware.sector_radius_mm / MM_PER_M
    strand = radius * (high - low) / 2.0 + BEYOND
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
    wave = 0.5 * LEFT_OVER * math.radians(row.nonlinearity_deg or 0.0)
    if row.settling_us is None:
        return SensorErrors(noise, wave, wave)
    lag = row.settling_us * 1e-6 / SETTLED / loop.sensing
    return SensorErrors(math.sqrt(loop.sensing) * noise, wave, wave, kept=math.exp(-loop.period / lag))


def reading_age(machine: MachineModel, loop: LoopChoice = BOARD) -> float:
    """Age of a reading when it is read, s: what the catalogue tells, 0 where no source does, and what the chip's filter
    lags more as the loop sets it.
    """
    hardware = machine.design.hardware
    if hardware.encoder_at == "motor":
        return 0.0
    row = catalogue.encoder.chosen(hardware)
    slower = (row.settling_us or 0.0) / SETTLED * (1.0 / loop.sensing - 1.0)
    return ((row.latency_us or 0.0) + slower) * 1e-6


def ripple_waves(motor: catalogue.Motor) -> float:
    """Counts the waves of a motor's torque in a turn: segments pass two brushes, which an odd number meets in turn."""
    if motor.commutation != "brushed":
        return POLE_WAVES
    segments = SEGMENTS if motor.commutator_segments is None else motor.commutator_segments
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

    Returns:
        The plant.
    """
    friction, gives = joint_friction(machine), compliance(machine)
    par, design = stiff_plant(machine, loop, place), machine.design
    motor = catalogue.motor.chosen(design.hardware)
    sizes = _sizes(machine)
    low, high = (-math.inf, math.inf) if sizes is None else sizes.stops_rad
    stop_damping = 2.0 * STOP_RATIO * math.sqrt(STOP_STIFFNESS * par.joint_inertia)
    waves = ripple_waves(motor)
    par = par._replace(
        platform=par.platform - gives.knob,
        knob=gives.knob,
        structure_stiffness=gives.structure,
        structure_damping=2.0 * LOSS[place] * math.sqrt(gives.structure * gives.knob),
        stop_low=low,
        stop_high=high,
        stop_stiffness=STOP_STIFFNESS,
        stop_damping=stop_damping,
        ripple=RIPPLE if motor.torque_ripple is None else motor.torque_ripple,
        ripple_per_rad=waves * machine.drive.ratio,
        cogging=machine.drive.ratio * (motor.cogging_torque_N_m or 0.0),
        cogging_per_rad=waves * machine.drive.ratio,
    )
    if sizes is not None and sizes.panel is not None:
        par = par._replace(
            bezel_half=sizes.panel.half_mm / MM_PER_M,
            bezel_limit=sizes.panel.limit_mm / MM_PER_M,
            bezel_stiffness=BEZEL_STIFFNESS,
            bezel_damping=2.0 * STOP_RATIO * math.sqrt(BEZEL_STIFFNESS * machine.masses.platform),
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
    """The controller of a device in a loop: its period, its velocity filter, and the walls that it bears.

    Args:
        machine: The device.
        loop: The loop.
        **limits: Any of `SafetyLimits`, to replace what follows from the design.
    """
    plain = default_controller(machine, loop.period, low_pass(loop.period, loop.corner), **limits)
    return plain._replace(walls=wall_cap(machine, loop))


def wall_cap(machine: MachineModel, loop: LoopChoice = BOARD, share: float = SHARE) -> WallCap:
    """What walls a loop bears: with the least friction and the largest delay.

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
