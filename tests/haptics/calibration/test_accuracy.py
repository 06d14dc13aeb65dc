"""Predicted errors against simulated calibrations, whose truth is known, of good and bad sets of poses."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from delta_cad.design import Design
from delta_cad.mechanism.chains import chain_angles, chain_positions
from delta_cad.mechanism.workspace import cube_grid
from haptics.calibration.accuracy import COARSE, POSES_MOST, accuracy, helpful_poses
from haptics.calibration.fit import Fit, FitError, Noise, fit
from haptics.calibration.poses import Poses
from haptics.calibration.unknowns import ZERO, Unknowns, nominal, sigmas
from tests.haptics.calibration.devices import cube_points, made, measured, readings

NOISE = Noise(0.02e-3, 5e-5)
DEVICES, POSES = 10, 60


def middle(design: Design) -> np.ndarray:
    return np.array([0.0, 0.0, (design.cube.bottom_height_mm + design.cube.half_side_mm) / 1e3])


def on_a_line(design: Design, p: np.ndarray) -> np.ndarray:
    half = design.cube.half_side_mm / 1e3
    return middle(design) + np.outer(np.linspace(-half, half, len(p)), [1.0, 0.0, 0.0])


def in_a_plane(design: Design, p: np.ndarray) -> np.ndarray:
    return np.column_stack([p[:, :2], np.full(len(p), middle(design)[2])])


def within_10_mm(design: Design, p: np.ndarray) -> np.ndarray:
    return middle(design) + (p - middle(design)) * 5.0 / design.cube.half_side_mm


def in_the_cube(_: Design, p: np.ndarray) -> np.ndarray:
    return p


def drawn_at_random(design: Design, rng: np.random.Generator) -> Unknowns:
    """A device that is off by what the fit assumes of devices before they are measured."""
    spread = sigmas()
    spread[:, ZERO] = math.radians(0.3)  # flat over half a turn, so of no weight
    table = nominal(design.geometry).table
    return Unknowns(table + rng.normal(0.0, 1.0, table.shape) * spread)


def squares(design: Design, device: Unknowns, found: Fit) -> np.ndarray:
    """(m,) square of the true error at a grid over the cube, m^2, in the frame that the positions were measured in."""
    p = cube_grid(design.workspace, COARSE)
    read = readings(device, p)
    believed = chain_positions(found.unknowns.mechanism, found.unknowns.angles(read))
    return ((believed - p) ** 2).sum(axis=1)


@pytest.mark.parametrize("places", [in_the_cube, on_a_line, in_a_plane, within_10_mm])
def test_simulated_calibrations_err_by_what_is_predicted(
    best: Design, places: Callable[[Design, np.ndarray], np.ndarray]
) -> None:
    rng, true, predicted = np.random.default_rng(5), [], []
    for _ in range(DEVICES):
        device = drawn_at_random(best, rng)
        poses = measured(device, places(best, cube_points(best, rng, POSES)), rng)
        found = fit(best.geometry, poses, noise=NOISE)
        expected = accuracy(found, best)
        true.append(squares(best, device, found))
        predicted.append((expected.rms, expected.worst))
    rms, worst = np.sqrt(np.mean(true)), np.sqrt(np.mean(true, axis=0).max())
    # Ten devices of three or more errors each that the poses do not determine: a mean square of 30 draws is within a
    # quarter of its expectation, its root within an eighth, and the largest of 125 places somewhat above.
    assert rms == pytest.approx(np.mean(predicted, axis=0)[0], rel=0.3)
    assert worst == pytest.approx(np.mean(predicted, axis=0)[1], rel=0.35)
    assert (np.mean(predicted, axis=0)[1] > 0.1e-3) == (places is not in_the_cube)


def test_the_error_in_a_frame_of_its_own_leaves_out_where_the_device_stands(best: Design) -> None:
    """Seen by a tracker the same poses give nearly the error of the base frame: that of the frame is no part of it."""
    rng = np.random.default_rng(7)
    device = made(best, rng)
    poses = measured(device, cube_points(best, rng, POSES), rng)
    turn, shift = Rotation.from_rotvec([0.6, -1.2, 2.0]).as_matrix(), np.array([0.4, -0.1, 0.7])
    seen = Poses((poses.positions - shift) @ turn, poses.readings)
    base = accuracy(fit(best.geometry, poses, noise=NOISE), best)
    found = fit(best.geometry, seen, noise=NOISE, own_frame=True)
    own = accuracy(found, best)
    assert base.rms < own.rms < 1.5 * base.rms  # six more unknowns
    p = cube_grid(best.workspace, COARSE)
    read = readings(device, p)
    believed = chain_positions(found.unknowns.mechanism, found.unknowns.angles(read))
    off = np.linalg.norm((believed - found.frame.shift) @ found.frame.rotation - (p - shift) @ turn, axis=1)
    assert np.sqrt((off**2).mean()) == pytest.approx(own.rms, rel=0.5)  # of a single device


@pytest.mark.parametrize("places", [on_a_line, within_10_mm])
def test_the_proposed_poses_lead_to_the_error_that_is_promised(
    best: Design, places: Callable[[Design, np.ndarray], np.ndarray]
) -> None:
    rng, limit = np.random.default_rng(9), 0.1e-3
    device = made(best, rng)
    poses = measured(device, places(best, cube_points(best, rng, POSES)), rng)
    found = fit(best.geometry, poses, noise=NOISE)
    more = helpful_poses(found, best, limit)
    assert 1 <= len(more.positions) <= POSES_MOST
    assert more.accuracy.worst <= limit < accuracy(found, best).worst
    fresh = measured(device, more.positions, rng)
    both = Poses(np.vstack([poses.positions, fresh.positions]), np.vstack([poses.readings, fresh.readings]))
    again = fit(best.geometry, both, noise=NOISE)
    # the parameters have moved, and with them the derivatives; the noise's share in the misfit is another
    assert accuracy(again, best).worst == pytest.approx(more.accuracy.worst, rel=0.15)
    # as many poses as random are worse
    some = measured(device, places(best, cube_points(best, rng, len(fresh.positions))), rng)
    other = Poses(np.vstack([poses.positions, some.positions]), np.vstack([poses.readings, some.readings]))
    assert accuracy(fit(best.geometry, other, noise=NOISE), best).worst > 2.0 * limit


def test_good_poses_need_no_others(best: Design) -> None:
    rng = np.random.default_rng(2)
    found = fit(best.geometry, measured(made(best, rng), cube_points(best, rng, POSES), rng), noise=NOISE)
    assert helpful_poses(found, best, 0.1e-3).positions.shape == (0, 3)


def test_a_cube_beyond_the_device_is_refused(best: Design) -> None:
    rng = np.random.default_rng(2)
    found = fit(best.geometry, measured(made(best, rng), cube_points(best, rng, 20), rng), noise=NOISE)
    wide = best.model_copy(update={"cube": best.cube.model_copy(update={"half_side_mm": 150.0})})
    with pytest.raises(FitError, match=r"does not reach \(-150\.0, -150\.0"):
        accuracy(found, wide)


@pytest.mark.parametrize("turns", [1.0, 9.85])
def test_readings_are_the_inverse_of_angles(best: Design, turns: float) -> None:
    """Held to bisection of the sensor's law, whose waves are those of a real encoder."""
    rng = np.random.default_rng(4)
    device = made(best, rng, turns)
    p = cube_points(best, rng, 20)
    theta = chain_angles(device.mechanism, p)
    np.testing.assert_allclose(device.readings(theta), readings(device, p), rtol=0.0, atol=1e-12)
