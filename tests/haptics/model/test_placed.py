"""The plant of machines whose chains do not stand alike, against vectors of a textbook."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import Design, design_from_dict
from delta_cad.drive import drive_torque
from haptics.control.pose import HOLDING, POSITION, ROWS, model, pose
from haptics.loop.hardware import real_plant
from haptics.model.machine import MachineModel, cube_centre_mm
from haptics.model.plant import FREE, STATES, advance, angles, derivative, energy, motion, plant
from tests.haptics.model.textbook import STEP, cube_points, textbook
from tests.haptics.scene_machine import MASSES, PLACED

TILTED = (2.0, -3.0, -8.0)
ZERO = np.zeros(3)
placed = pytest.mark.parametrize("design", PLACED.values(), ids=list(PLACED))


def state_of(p: np.ndarray, v: np.ndarray = ZERO) -> np.ndarray:
    state = np.zeros(STATES)
    state[:3], state[3:6] = p, v
    return state


@placed
def test_angles_rates_and_energies_are_those_of_the_textbook(design: Design) -> None:
    book, par, rng = textbook(design), plant(design.geometry, MASSES, TILTED), np.random.default_rng(2)
    for p in cube_points(design, 15, 3):
        v, out, found = rng.normal(0.0, 0.5, 3), np.zeros((6, 3)), np.zeros(3)
        angles(par, state_of(p), found)
        np.testing.assert_allclose(found, book.angles(p), atol=1e-12)
        m11, m22, m33, m12, m13, m23 = motion(par, 0.0, state_of(p, v), out)
        np.testing.assert_allclose(out[5], found, atol=1e-14)
        np.testing.assert_allclose(out[:3] @ book.jacobian(found, p), np.eye(3), atol=1e-7)
        known = book.kinetic(MASSES, p, v)
        M = np.array([[m11, m12, m13], [m12, m22, m23], [m13, m23, m33]])
        assert 0.5 * v @ M @ v == pytest.approx(known, rel=1e-7)
        kinetic, potential = energy(par, 0.0, state_of(p, v))
        assert kinetic == pytest.approx(known, rel=1e-7)
        assert potential == pytest.approx(book.potential(MASSES, p, np.array(TILTED)), abs=1e-12)


@placed
def test_forces_do_the_work_that_the_energy_gains(design: Design) -> None:
    """Power of torques and a force against the rate of the textbook's energy along the motion, by differences."""
    book, par, rng = textbook(design), plant(design.geometry, MASSES, TILTED), np.random.default_rng(5)
    out, work, step = np.zeros(STATES), np.zeros((6, 3)), 1e-4
    for p in cube_points(design, 12, 6):
        v, torque, force = rng.normal(0.0, 0.5, 3), rng.normal(0.0, 0.3, 3), rng.normal(0.0, 2.0, 3)
        theta = book.angles(p)
        derivative(par, FREE, ZERO, force, torque, state_of(p, v), theta, work, out)
        a, total = out[3:6].copy(), []
        for s in (step, -step):
            there = p + s * v + 0.5 * s * s * a
            total.append(book.kinetic(MASSES, there, v + s * a) + book.potential(MASSES, there, np.array(TILTED)))
        rates = (book.angles(p + STEP * v) - book.angles(p - STEP * v)) / (2.0 * STEP)
        assert (total[0] - total[1]) / (2.0 * step) == pytest.approx(torque @ rates + force @ v, abs=2e-4)


@placed
def test_energy_is_kept_to_the_fourth_order_of_the_step(design: Design) -> None:
    par = plant(design.geometry, MASSES, TILTED)
    start = state_of(np.array(cube_centre_mm(design)) / 1e3, np.array([0.2, -0.1, 0.15]))
    before, drift = sum(energy(par, 0.0, start)), []
    for steps in (40, 80, 160):
        state = start.copy()
        advance(par, FREE, ZERO, ZERO, ZERO, 0.1, steps, state, np.zeros((13, STATES)))
        drift.append(abs(sum(energy(par, 0.0, state)) - before))
    assert np.diff(np.log2(drift)) == pytest.approx([-4.0, -4.0], abs=0.5)
    assert drift[-1] < 1e-8


@placed
def test_the_middle_of_the_cube_is_the_machine_s(design: Design) -> None:
    np.testing.assert_allclose(np.array(cube_centre_mm(design)) / 1e3, design.workspace.centre, atol=1e-16)
    assert cube_centre_mm(design)[0] == design.cube.centre_x_mm != 0.0


def test_a_panel_s_bezel_stands_about_the_cube() -> None:
    """A stem that leaves the opening by as much on either side is pushed back as much."""
    panel = {"panel": {"thickness_mm": 2.0, "limit_mm": 3.0}}
    design = design_from_dict(PLACED["apart"].model_dump(mode="json", exclude_none=True, by_alias=True) | panel)
    machine = MachineModel(design, MASSES, drive_torque(design))
    par = real_plant(machine)._replace(structure_stiffness=0.0, knob=0.0, cable_stiffness=0.0)
    pushes, book = [], textbook(design)
    for side in (-1.0, 1.0):
        p = machine.centre + side * (machine.half_side + 4e-3) * np.eye(3)[0]
        gained = []
        for one in (par, par._replace(bezel_stiffness=0.0)):
            out, work = np.zeros(STATES), np.zeros((6, 3))
            derivative(one, FREE, ZERO, ZERO, ZERO, state_of(p), book.angles(p), work, out)
            gained.append(out[3:6].copy())
        m = np.array(motion(par, 0.0, state_of(p), np.zeros((6, 3))))
        M = np.array([[m[0], m[3], m[4]], [m[3], m[1], m[5]], [m[4], m[5], m[2]]])
        pushes.append(M @ (gained[0] - gained[1]))
    np.testing.assert_allclose(pushes, [[200.0, 0.0, 0.0], [-200.0, 0.0, 0.0]], atol=1e-6)


@placed
def test_a_loop_that_holds_the_weight_and_a_spring_keeps_their_energy(design: Design) -> None:
    """Controller's pose and plant together; what the hold of a tick adds falls with the period, energy by the textbook.

    A spring whose force is held for a period T has gained `K T / 2 |v|^2` of power: it is taken out.
    """
    book, par, stiffness = textbook(design), plant(design.geometry, MASSES, TILTED), 100.0
    known, centre = model(design.geometry, MASSES, TILTED), design.workspace.centre
    gained = []
    for period in (4e-4, 2e-4):
        state = state_of(centre + np.array([0.004, -0.003, 0.005]), np.array([0.15, 0.1, -0.1]))
        theta, out, torque, room = np.zeros(3), np.zeros((ROWS, 3)), np.zeros(3), np.zeros((13, STATES))
        energies, added = [], 0.0
        for k in range(round(0.1 / period) + 1):
            if k % round(0.02 / period) == 0:
                stretch = state[:3] - centre
                energies.append(
                    book.kinetic(MASSES, state[:3], state[3:6]) + 0.5 * stiffness * stretch @ stretch - added
                )
            angles(par, state, theta)
            pose(known, theta, out)
            torque[:] = out[:3] @ (stiffness * (centre - out[POSITION])) + out[HOLDING]
            added += 0.5 * stiffness * period**2 * state[3:6] @ state[3:6]
            advance(par, FREE, ZERO, ZERO, torque, period, 2, state, room)
        gained.append(np.ptp(energies) / energies[0])
    assert gained[0] < 2e-3
    assert gained[1] < 0.6 * gained[0]
