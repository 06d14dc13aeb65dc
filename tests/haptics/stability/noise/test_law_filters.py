"""A filter over the whole law that makes a wall of 5 N/mm unnoticed on any structure, and what it takes from the wall.

Found by a search over laws of two filters of second order: quiet, and steady with every hand. In the product's loop it
stands as `K + 1 (C - K)`, which is any law C of static stiffness K; the oracle steps it by hand.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import bilinear

from delta_cad.design import Design
from haptics.control.filters import backward_difference, low_pass
from haptics.model.hands import CORNERS, HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand, Plant
from haptics.rendering import law_table
from haptics.rendering.laws.virtual_wall import axis_wall
from haptics.scenes.noise import in_band
from haptics.simulation.assumptions import encoder_count
from haptics.simulation.hardware import (
    LOSS,
    STIFFER,
    board_controller,
    reading_age,
    real_plant,
    sensor_errors,
    structured,
)
from haptics.simulation.loop import simulate, timing
from haptics.simulation.loops import BOARD
from haptics.stability import noise
from haptics.stability.estimator_models import LinearEstimator, linear_models
from haptics.stability.linear import linearise
from haptics.stability.noise import BARELY, FORCE, MOTION, NoisyLoop
from haptics.stability.port import impedance
from haptics.stability.walls import ACTIVE, WallAt
from tests.haptics.scene_machine import scene_machine
from tests.haptics.stability.test_whole_loop import MANY, WholeLoop

T, X, WALL = BOARD.period, np.eye(3)[0], 5000.0
DAMPING = 0.65  # N s/m of a plain difference of readings, before the filters
# Hz and share of critical of zeros, then of poles.
FILTERS = ((318.0, 0.46, 68.5, 0.11), (98.0, 0.233, 550.0, 0.216))
CLAMP = Hand(0.0, 0.5, 10e3)  # N s/m and N/m of a spring to ground on the handle, stiffer than any hand


# The same for one structure, which rings at 228 Hz: a notch there, its damping, and the corner of its velocity filter.
NOTCH, NOTCH_DAMPING, NOTCH_CORNER = ((228.0, 0.015, 342.0, 0.3),), 3.6, 225.0
RINGS = STIFFER[5]

Sections = tuple[tuple[np.ndarray, np.ndarray], ...]


def sections(filters: tuple[tuple[float, ...], ...] = FILTERS) -> Sections:
    """Numerator and denominator of each filter, of static gain 1."""

    def square(frequency: float, share: float) -> list[float]:
        w = 2.0 * math.pi * frequency
        return [1.0 / w**2, 2.0 * share / w, 1.0]

    both = [bilinear(square(f, z), square(g, p), 1.0 / T) for f, z, g, p in filters]
    return tuple((np.asarray(top), np.asarray(bottom)) for top, bottom in both)


def of(rate: LinearEstimator, damping: float, filters: Sections, stiffness: float) -> LinearEstimator:
    """C - K of a wall and damper through filters."""
    under = np.array(rate.denominator)
    over = damping * np.array(rate.numerator)
    over[: len(under)] += stiffness * under
    for top, bottom in filters:
        over, under = np.convolve(over, top), np.convolve(under, bottom)
    over[: len(under)] -= stiffness * under
    return LinearEstimator("filtered", tuple((over - over.mean()).tolist()), tuple(under.tolist()))


def law(share: float = 1.0) -> LinearEstimator:
    """That of a share of the wall's stiffness, its damping as it is."""
    (rate,) = linear_models(backward_difference(T))
    return of(rate, DAMPING, sections(), share * WALL)


def notched(share: float = 1.0) -> LinearEstimator:
    """Likewise with the notch."""
    (rate,) = linear_models(low_pass(T, NOTCH_CORNER))
    return of(rate, NOTCH_DAMPING, sections(NOTCH), share * WALL)


@pytest.fixture(scope="module")
def machine(best: Design) -> MachineModel:
    return scene_machine(best)


def structure(machine: MachineModel, share: float) -> Plant:
    plain = real_plant(machine, BOARD, 0)
    return structured(plain, share * plain.structure_stiffness, LOSS[0])


@pytest.fixture
def filtered(monkeypatch: pytest.MonkeyPatch):
    """Puts the filtered law in the place of the velocity filter; its damping is then 1."""

    def put(share: float = 1.0, made: Callable[[float], LinearEstimator] = law) -> None:
        monkeypatch.setattr(noise, "linear_models", lambda _: (made(share),))

    return put


def test_it_is_unnoticed_on_any_structure(machine: MachineModel, filtered) -> None:
    plants = [structure(machine, share) for share in np.geomspace(1.0, 10.0, 17)]
    loud = [NoisyLoop(machine, hand=BARELY, normal=X, par=par).figures(WALL, BOARD.damping) for par in plants]
    assert max(one.motion for one in loud) > 2.5 * MOTION
    filtered()
    calm = [NoisyLoop(machine, hand=BARELY, normal=X, par=par).figures(WALL, 1.0) for par in plants]
    assert all(one.quiet for one in calm)
    assert max(one.motion for one in calm) > 0.85 * MOTION  # by little
    assert max(one.force for one in calm) > 1.9 * max(one.force for one in loud)


@pytest.mark.parametrize("late", [0.5, 1.5])
@pytest.mark.parametrize("share", [0.1, 1.0, 1.0 / 0.7])
def test_it_is_steady_with_every_hand(machine: MachineModel, filtered, share: float, late: float) -> None:
    """And with none, up to what a wall of 5 N/mm is capped from; in the corners of the hands' ranges, too."""
    filtered(share)
    loop = replace(BOARD, delays=(late, late, late))
    for stiffer in STIFFER[::4]:
        par = structure(machine, stiffer)
        for hand in (BARELY, *HANDS.values(), *CORNERS.values()):
            assert NoisyLoop(machine, loop, hand=hand, normal=X, par=par).loop.radius(share * WALL, 1.0) < 1.0


@pytest.mark.parametrize("stiffer", [STIFFER[3], pytest.param(STIFFER[8], marks=pytest.mark.slow)])
def test_a_loop_written_anew_agrees(machine: MachineModel, filtered, stiffer: float) -> None:
    par, age = structure(machine, stiffer), reading_age(machine)

    def other(hand: Hand | None) -> WholeLoop:
        return WholeLoop(machine, par, machine.centre, X, hand, T, math.inf, age, sections=sections())

    for hand in (None, *HANDS.values()):
        assert other(hand).radius(WALL / 0.7, DAMPING) < 1.0
    assert other(HANDS["firm"]).radius(3.0 * WALL, DAMPING) > 1.0  # the oracle can fail
    filtered()
    told = NoisyLoop(machine, hand=HANDS["light"], normal=X, par=par).figures(WALL, 1.0)
    force, ways = other(HANDS["light"]).shaken(WALL, DAMPING, deviation(machine), 24_000, MANY, 3000)
    narrow = in_band(ways, T).reshape(-1, 3, MANY).swapaxes(1, 2).reshape(-1, 3)
    moved = np.sqrt(np.linalg.eigvalsh(narrow.T @ narrow / len(narrow))[-1])
    assert force == pytest.approx(told.force, rel=0.02)
    assert moved == pytest.approx(told.motion, rel=0.03)  # a narrow line: the estimate deviates by 1 %
    assert moved <= MOTION
    assert force <= FORCE


def deviation(machine: MachineModel) -> float:
    return math.hypot(sensor_errors(machine).noise, encoder_count(machine) / math.sqrt(12.0))


def gives(machine: MachineModel, par: Plant, estimator: LinearEstimator, damping: float) -> np.ndarray:
    """Frequencies at which the wall gives energy to whoever moves the handle, averaged, Hz."""
    at = WallAt(machine, place=0)
    at.here = linearise(par, machine.centre)
    port = at.at_handle()
    z = impedance(port, estimator, WALL, damping)
    return port.frequency[np.real(z) < ACTIVE * np.abs(z)] / (2.0 * math.pi)


def test_it_gives_energy_where_the_default_takes_it(machine: MachineModel, filtered) -> None:
    """Why it is not the default: passive loads that are no hand of the set make it swing."""
    par = structure(machine, STIFFER[4])
    (plain,) = linear_models(low_pass(T, BOARD.corner))
    assert not len(gives(machine, par, plain, BOARD.damping))
    active = gives(machine, par, law(), 1.0)
    assert active.min() < 60.0
    assert active.max() > 110.0
    assert NoisyLoop(machine, hand=CLAMP, normal=X, par=par).loop.radius(WALL, BOARD.damping) < 1.0
    filtered()
    assert NoisyLoop(machine, hand=CLAMP, normal=X, par=par).loop.radius(WALL, 1.0) > 1.0


def test_a_notch_for_a_structure_that_is_known(machine: MachineModel, filtered) -> None:
    """Known to a fifth of its stiffness it is unnoticed, steady and gives no energy; twice as stiff it is noticed."""
    assert not len(gives(machine, structure(machine, RINGS), notched(), 1.0))

    def figures(share: float) -> noise.NoiseFigures:
        return NoisyLoop(machine, hand=BARELY, normal=X, par=structure(machine, share * RINGS)).figures(WALL, 1.0)

    filtered(made=notched)
    assert all(figures(share).quiet for share in (0.8, 0.9, 1.0, 1.1, 1.2))
    assert figures(2.0).motion > 1.5 * MOTION
    filtered(1.0 / 0.7, notched)
    for hand in (BARELY, *HANDS.values()):
        par = structure(machine, RINGS)
        assert NoisyLoop(machine, hand=hand, normal=X, par=par).loop.radius(WALL / 0.7, 1.0) < 1.0


@pytest.mark.parametrize("stiffer", [STIFFER[2], STIFFER[8]])
def test_friction_that_sticks_does_not_hide_the_motion(machine: MachineModel, stiffer: float) -> None:
    """A handle that 1.8 N press into the default wall: joints stick, and the knob rings on its structure."""
    par, ticks = structure(machine, stiffer), round(5.6 / T)
    push = np.zeros((ticks, 3))
    ramp = np.clip((np.arange(ticks) * T - 0.6) / 0.6, 0.0, 1.0)
    push[:, 0] = 1.8 * ramp**2 * (3.0 - 2.0 * ramp)
    record = simulate(
        par, board_controller(machine, energy=1e3, energy_start=1e3, ramp_power=1e3),
        law_table(axis_wall("+x", float(machine.centre[0]), stiffness=WALL, damping=BOARD.damping)),
        timing(T, BOARD.delay + reading_age(machine), 2), machine.centre, hand=BARELY,
        anchor=np.tile(machine.centre, (ticks, 1)), push=push, count=encoder_count(machine),
        errors=sensor_errors(machine), seed=1,
    )  # fmt: skip
    late = record.time >= 1.6
    assert np.ptp(record.position[late, 0]) < 2e-5
    moved = math.sqrt(float(np.linalg.eigvalsh(np.cov(in_band(record.knob[late], T).T))[-1]))
    told = NoisyLoop(machine, hand=BARELY, normal=X, par=par).figures(WALL, BOARD.damping).motion
    assert moved == pytest.approx(told, rel=0.3)
    assert moved > 1.5 * MOTION
