"""Faults of sensors and amplifiers in the closed loop of plant and controller: when the force is off, what until then.

The board loop of the committed design at 8 kHz, its encoders with counts, noise and waves. A hand presses the handle
into a wall with the force that is rendered and slides it along; the fault begins where it is fastest. Every run has a
twin with the same noise and no fault: what a fault does is the difference of the two.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from delta_cad.design import load_design
from delta_cad.mechanism import jacobian
from haptics.control.controller import Controller
from haptics.control.supervisor.faults import LATCHING, FaultCode, State, findings
from haptics.loop.assumptions import encoder_count
from haptics.loop.choice import BOARD, LoopChoice
from haptics.loop.hardware import board_controller, reading_age, real_plant, sensor_errors
from haptics.loop.simulation import HEALTHY, LoopFault, SimulatedRun, Wrong, simulate, timing
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand, Plant
from haptics.rendering import law_table
from haptics.rendering.laws.virtual_wall import axis_wall
from tests.committed import BEST
from tests.haptics.scene_machine import scene_machine

FORCES_N = (0.0, 1.0, 3.0, 6.0, 9.0)
MOTIONS = {"rest": 0.0, "slow": 0.02, "fast": 0.5}  # Name -> speed at which the fault begins, m/s
STROKE = 0.02  # Of the hand along the wall, m
WALL_N_m = 1e5  # As the law has it; the controller holds it to what the loop bears
BEGIN = 1280  # Tick at which a fault begins: the force is in, the hand at rest on the wall
RAMP = 0.02  # Time in which the force comes in, s; a device takes half a second
SUBSTEPS = 2
GRIP = Hand(0.1, 10.0, 500.0)


class Case(NamedTuple):
    """A fault of the matrix.

    Attributes:
        name: For a person.
        fault: What goes wrong.
        within: Time within which the force is off, s; None where it is not off in every motion.
    """

    name: str
    fault: LoopFault
    within: float | None


def _fault(wrong: Wrong, joint: int, size: float = 0.0, noticed: int = 0) -> LoopFault:
    return LoopFault(int(wrong), BEGIN, joint, size, noticed)


FAST_s, SLOW_s = 0.02, 0.1
CASES = (
    Case("one reading not fresh (CRC, plug, bus)", _fault(Wrong.UNREAD, 0), FAST_s),
    Case("all readings not fresh, or late and detected as late", _fault(Wrong.UNREAD, 3), FAST_s),
    Case("one encoder frozen, reported as fresh", _fault(Wrong.FROZEN, 0), FAST_s),
    Case("all encoders frozen, reported as fresh", _fault(Wrong.FROZEN, 3), FAST_s),
    Case("unplugged, reported as fresh: all bits 1", _fault(Wrong.UNPLUGGED, 0), FAST_s),
    Case("bit 12 stuck at the wrong value", _fault(Wrong.BIT, 0, 12.0), SLOW_s),
    Case("reading jumps by 1 degree", _fault(Wrong.OFFSET, 0, np.pi / 180.0), SLOW_s),
    Case("bit 6 stuck at the wrong value", _fault(Wrong.BIT, 0, 6.0), None),
    Case("reading jumps by 0.05 degrees", _fault(Wrong.OFFSET, 0, 0.05 * np.pi / 180.0), None),
    Case("reading drifts by 0.5 degrees a second", _fault(Wrong.DRIFT, 0, 0.5 * np.pi / 180.0), None),
    Case("reading drifts by 20 degrees a second", _fault(Wrong.DRIFT, 0, 20.0 * np.pi / 180.0), None),
    Case("reading drifts upwards by 300 degrees a second", _fault(Wrong.DRIFT, 0, 300.0 * np.pi / 180.0), None),
    Case("reading drifts downwards by 300 degrees a second", _fault(Wrong.DRIFT, 0, -300.0 * np.pi / 180.0), None),
    Case("readings 8 ticks old, reported as fresh", _fault(Wrong.LATE, 3, 8.0), None),
    Case("readings 40 ticks old, reported as fresh", _fault(Wrong.LATE, 3, 40.0), None),
    Case("encoders of two joints exchanged", _fault(Wrong.SWAPPED, 0), None),
    Case("one amplifier gives no torque", _fault(Wrong.WEAK, 0), None),
    Case("one amplifier gives full torque upwards", _fault(Wrong.FULL, 0, 0.8), None),
    Case("one amplifier gives full torque downwards", _fault(Wrong.FULL, 0, -0.8), None),
    Case("the same, detected by its drive within 5 ms", _fault(Wrong.FULL, 0, -0.8, 40), SLOW_s),
)


class Outcome(NamedTuple):
    """What a fault did.

    Attributes:
        off: Time from its begin until no force is commanded and the supervisor is in FAULT, s; infinite if never.
        codes: Faults that latched, whether or not the force is off.
        force: Largest difference of the motors' force on the handle to the twin's until then, N.
        travel: Largest difference of the handle's position until then, m.
        speed: Largest difference of its speed, m/s.
        energy: Largest work of the difference in force on the handle, J.
    """

    off: float
    codes: tuple[FaultCode, ...]
    force: float
    travel: float
    speed: float
    energy: float


@cache
def machine() -> MachineModel:
    """The committed design with the masses of its build."""
    return scene_machine(load_design(BEST))


@cache
def device(loop: LoopChoice = BOARD) -> tuple[Plant, Controller]:
    """The plant and a loop's controller."""
    return real_plant(machine(), loop), board_controller(machine(), loop, ramp=RAMP)


def laws(force: float) -> np.ndarray:
    """The wall, in the cube's middle, or before the handle where it is to give no force."""
    face = machine().centre[0] + (2e-3 if force == 0.0 else 0.0)
    return law_table(axis_wall("+x", float(face), stiffness=WALL_N_m))


@cache
def run(
    force: float, motion: str, seconds: float, fault: LoopFault = HEALTHY, loop: LoopChoice = BOARD
) -> SimulatedRun:
    """One run: a force, N, a motion, how long it goes on after the fault's begin, s; without a fault it is the twin."""
    plant, controller = device(loop)
    ticks = BEGIN + round(seconds / loop.period)
    speed = MOTIONS[motion]
    rate = speed / STROKE
    anchor = np.tile(machine().centre, (ticks, 1))
    anchor[:, 1] += STROKE * np.sin(rate * (np.arange(ticks) - BEGIN) * loop.period)
    push = np.zeros((ticks, 3))
    push[:, 0] = force
    clock = timing(loop.period, loop.delay + reading_age(machine(), loop), round(SUBSTEPS * loop.period / BOARD.period))
    return simulate(
        plant, controller, laws(force), clock, anchor[0].copy(), hand=GRIP, anchor=anchor, push=push,
        count=encoder_count(machine()), errors=sensor_errors(machine(), loop), seed=1, fault=fault,
    )  # fmt: skip


def motor_force(run: SimulatedRun) -> np.ndarray:
    """(n, 3) force of the motors on the handle, N: J^-T of what they give."""
    columns = jacobian(machine().geometry, run.position)
    return np.linalg.solve(np.swapaxes(columns, -1, -2), run.applied[..., None])[..., 0]


def outcome(record: SimulatedRun, twin: SimulatedRun) -> Outcome:
    """What a fault did, against its twin of the same length."""
    commanded = np.abs(record.rendered).max(axis=1) > 0.0
    stopped = (record.state == State.FAULT) & ~commanded
    stopped[:BEGIN] = False
    at = np.flatnonzero(stopped)
    end = int(at[0]) + 1 if len(at) else len(stopped)
    until = slice(BEGIN, end)
    wrong = (motor_force(record) - motor_force(twin))[until]
    speed = (record.velocity - twin.velocity)[until]
    period = record.time[1]
    work = np.cumsum((wrong * record.velocity[until]).sum(axis=1)) * period
    bits = int(np.bitwise_or.reduce(record.bits[BEGIN:])) & LATCHING
    return Outcome(
        off=(at[0] - BEGIN) * period if len(at) else np.inf,
        codes=findings(bits),
        force=float(np.linalg.norm(wrong, axis=1).max()),
        travel=float(np.linalg.norm((record.knob - twin.knob)[until], axis=1).max()),
        speed=float(np.linalg.norm(speed, axis=1).max()),
        energy=float(max(work.max(), 0.0)),
    )


def judged(case: Case, force: float, motion: str, seconds: float, loop: LoopChoice = BOARD) -> Outcome:
    """One place of the matrix."""
    return outcome(run(force, motion, seconds, case.fault, loop), run(force, motion, seconds, loop=loop))
