"""The controller of machines whose chains do not stand alike, against vectors of a textbook."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import Design
from haptics.calibration.unknowns import LENGTHS
from haptics.control.correction import DRAWN, correct, correction, turned
from haptics.control.correction import POSITION as PLACE
from haptics.control.correction import ROWS as MADE_ROWS
from haptics.control.pose import HOLDING, POSITION, ROWS, model, pose
from haptics.control.supervisor.faults import FaultCode
from haptics.control.supervisor.limits import safety_limits
from haptics.control.supervisor.safety import Supervisor
from haptics.gravity import gravity_torque, potential_energy
from tests.haptics.calibration.devices import made, readings
from tests.haptics.model.textbook import STEP, VERTICAL, Textbook, cube_points, textbook
from tests.haptics.scene_machine import MASSES, PLACED

TILTED = np.array([2.0, -3.0, -8.0])
placed = pytest.mark.parametrize("design", PLACED.values(), ids=list(PLACED))


@placed
def test_the_pose_is_that_of_the_textbook(design: Design) -> None:
    """Position, Jacobian by differences, holding torque by differences of the potential energy, both margins."""
    book, known, out = textbook(design), model(design.geometry, MASSES, (2.0, -3.0, -8.0)), np.zeros((ROWS, 3))
    for p in cube_points(design, 20, 1):
        theta = book.angles(p)
        reach, volume = pose(known, theta, out)
        np.testing.assert_allclose(out[POSITION], p, atol=1e-12)
        J = book.jacobian(theta, p)
        np.testing.assert_allclose(out[:3].T, J, atol=1e-8 * np.abs(J).max())
        energy = []
        for e in STEP * np.eye(3):
            ahead, behind = (book.position(theta + sign * e, p) for sign in (1.0, -1.0))
            energy.append(book.potential(MASSES, ahead, TILTED) - book.potential(MASSES, behind, TILTED))
        held = np.array(energy) / (2.0 * STEP)
        np.testing.assert_allclose(out[HOLDING], held, atol=1e-8)
        np.testing.assert_allclose(gravity_torque(design.geometry, MASSES, p, TILTED), held, atol=1e-8)
        rods = np.array([book.forearm(i, theta[i], p) for i in range(3)])
        assert volume == pytest.approx(np.linalg.det(rods) / book.rod**3, rel=1e-10)
        arms = [rods[i] @ book.directions(i, theta[i])[1] for i in range(3)]
        assert reach == pytest.approx(min(arms), rel=1e-9)
    assert not np.allclose(book.angles(design.workspace.centre), book.angles(design.workspace.centre)[0], atol=1e-3)


@placed
def test_a_force_and_its_torques_do_the_same_work(design: Design) -> None:
    book, known, out = textbook(design), model(design.geometry, MASSES, (0.0, 0.0, 0.0)), np.zeros((ROWS, 3))
    rng = np.random.default_rng(3)
    for p in cube_points(design, 15, 4):
        theta, force, turn = book.angles(p), rng.normal(size=3), rng.normal(size=3)
        pose(known, theta, out)
        moved = book.position(theta + STEP * turn, p) - book.position(theta - STEP * turn, p)
        assert force @ moved == pytest.approx(2.0 * STEP * (out[:3] @ force) @ turn, rel=1e-6, abs=1e-12)


@placed
def test_the_potential_energy_is_that_of_the_textbook(design: Design) -> None:
    book, points = textbook(design), cube_points(design, 12, 5)
    known = potential_energy(design.geometry, MASSES, points, TILTED)
    shown = np.array([book.potential(MASSES, p, TILTED) for p in points])
    np.testing.assert_allclose(known, shown, atol=1e-13)


@placed
def test_the_supervisor_s_cube_is_where_the_design_has_it(design: Design) -> None:
    limits, book = safety_limits(design), textbook(design)
    found = Supervisor(limits)
    left = FaultCode.EDGE_LEFT.bit | FaultCode.EDGE_FAR.bit
    corners = cube_points(design, 8, 0)
    theta = book.angles(corners[0])
    for p in corners:
        theta = book.angles(p)
        assert ((limits.theta_low < theta) & (theta < limits.theta_high)).all()
        assert not found.check(0.0, theta, p, 1.0, 1.0) & left
    half = design.cube.half_side_mm / 1e3
    for side in (-1.0, 1.0):
        beyond = design.workspace.centre + side * (half + 1.01 * limits.edge_margin) * np.eye(3)[0]
        assert found.check(0.0, theta, beyond, 1.0, 1.0) & FaultCode.EDGE_LEFT.bit
        within = design.workspace.centre + side * (half + 0.99 * limits.edge_margin) * np.eye(3)[0]
        assert not found.check(0.0, theta, within, 1.0, 1.0) & left


@placed
def test_the_supervisor_s_ranges_are_those_of_the_textbook_over_that_cube(design: Design) -> None:
    """Over every third point of the supervisor's own grid, which holds corners and middles of faces and edges."""
    limits, book, centre = safety_limits(design), textbook(design), design.workspace.centre
    steps = np.array(np.meshgrid(*3 * [[-1.0, -0.5, 0.0, 0.5, 1.0]])).reshape(3, -1).T
    half = design.cube.half_side_mm / 1e3
    far = np.array([book.angles(p) for p in centre + (half + limits.edge_far) * steps])
    assert -0.02 < limits.theta_low + 0.05 - far.min() < 1e-12
    assert -1e-12 < limits.theta_high - 0.05 - far.max() < 0.02
    reach, volume, turn = [], [], []
    for p in centre + (half + limits.edge_margin) * steps:
        theta = book.angles(p)
        rods = np.array([book.forearm(i, theta[i], p) for i in range(3)])
        arms = np.array([rods[i] @ book.directions(i, theta[i])[1] for i in range(3)])
        reach.append(arms.min())
        volume.append(np.linalg.det(rods) / book.rod**3)
        turn.append((np.linalg.norm(rods, axis=1) / (book.arm * arms)).max())
    assert 0.95 < limits.reach_min / (0.3 * min(reach)) < 1.0 + 1e-9
    assert 0.95 < limits.volume_min / (0.3 * min(volume)) < 1.0 + 1e-9
    assert 1.0 - 1e-9 < limits.joint_speed / (1.5 * limits.speed * max(turn)) < 1.05


@placed
def test_a_calibrated_machine_is_corrected_where_its_chains_stand(design: Design) -> None:
    """Every made chain solved by itself in the textbook; the drawn angles lead to the same position."""
    rng, wanted = np.random.default_rng(8), np.array([0.1, -0.2, 0.15])
    device, drawn, torque = made(design, rng, 4.8), textbook(design), np.zeros(3)
    known, out = correction(design.geometry, device), np.zeros((MADE_ROWS, 3))
    for p in cube_points(design, 6, 9):
        read = readings(device, p[None])[0]
        correct(known, read, out)
        theta = device.angles(read)
        np.testing.assert_allclose(out[PLACE], p, atol=1e-11)
        np.testing.assert_allclose(made_off(device.table, drawn, theta, out[PLACE]), 0.0, atol=1e-12)
        np.testing.assert_allclose(out[DRAWN], drawn.angles(out[PLACE]), atol=1e-12)
        turned(out, wanted, np.inf, torque)
        for j in range(3):
            moved = read + 1e-6 * np.eye(3)[j], read - 1e-6 * np.eye(3)[j]
            places = []
            for one in moved:
                correct(known, one, out)
                places.append((out[DRAWN].copy(), device.angles(one)[j]))
            turn, made_turn = places[0][0] - places[1][0], places[0][1] - places[1][1]
            assert wanted @ turn == pytest.approx(torque[j] * made_turn, rel=1e-5, abs=1e-12)


def made_off(table: np.ndarray, book: Textbook, theta: np.ndarray, p: np.ndarray) -> list[float]:
    """How much too long each rod of a made machine would be, m."""
    off = []
    for i, (base, platform, arm, rod, aside, above) in enumerate(table[:, :LENGTHS]):
        out = book.outwards(i)
        side = np.array([-out[1], out[0], 0.0])
        along = np.cos(theta[i]) * out + np.sin(theta[i]) * VERTICAL
        elbow = base * out + aside * side + above * VERTICAL + arm * along
        off.append(float(np.linalg.norm(p + platform * out - elbow)) - rod)
    return off
