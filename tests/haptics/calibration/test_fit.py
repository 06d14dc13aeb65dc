"""Calibration of synthetic devices: how much smaller errors get, how honest uncertainties are, what is not told."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from delta_cad.design import Design
from delta_cad.mechanism.chains import chain_positions
from delta_cad.mechanism.geometry import DeltaGeometry
from haptics.calibration.fit import FitError, Noise, fit, poses_needed
from haptics.calibration.poses import Poses
from haptics.calibration.record import unobservable
from haptics.calibration.unknowns import COUNT, NAMES, ZERO, Unknowns, nominal, sigmas
from tests.haptics.calibration.devices import WAVE, cube_points, made, measured, readings

NOISE = Noise(0.02e-3, 5e-5)


def error(unknowns: Unknowns, read: np.ndarray, p: np.ndarray) -> float:
    """Root mean square of the distance between where a controller believes the handle is and where it is, m."""
    off = chain_positions(unknowns.mechanism, unknowns.angles(read)) - p
    return float(np.sqrt((off**2).sum(axis=1).mean()))


def test_position_errors_of_twenty_devices_become_ten_times_smaller(best: Design) -> None:
    rng, ratios = np.random.default_rng(1), []
    for _ in range(20):
        device = made(best, rng)
        found = fit(best.geometry, measured(device, cube_points(best, rng, 60), rng), noise=NOISE)
        fresh = cube_points(best, rng, 60)
        read = readings(device, fresh)
        ratios.append(error(nominal(best.geometry), read, fresh) / error(found.unknowns, read, fresh))
        assert 0.7 < found.misfit < 1.3
    assert min(ratios) >= 10.0, sorted(ratios)


def test_exact_poses_give_the_device_back(best: Design) -> None:
    rng = np.random.default_rng(3)
    device, p = made(best, rng), cube_points(best, rng, 80)
    found = fit(best.geometry, Poses(p, readings(device, p)), noise=Noise(1e-9, 1e-10))
    off = (found.unknowns.table - device.table) / sigmas()
    together = found.unknowns.mechanism.radius_difference - device.mechanism.radius_difference
    assert np.abs(off[:, 2:]).max() < 1e-3
    assert np.abs(together).max() < 1e-7


def test_uncertainties_cover_what_devices_of_the_assumed_scatter_have(best: Design) -> None:
    rng, scores = np.random.default_rng(11), []
    for _ in range(12):
        table = nominal(best.geometry).table
        spread = sigmas(WAVE)
        spread[:, ZERO] = math.radians(0.3)  # flat over half a turn, so of no weight
        device = Unknowns(table + rng.normal(0.0, 1.0, table.shape) * spread)
        poses = measured(device, cube_points(best, rng, 25), rng)
        found = fit(best.geometry, poses, noise=NOISE, wave=WAVE)
        scores.append((found.unknowns.table - device.table) / found.sigma)
    spread = np.std(np.array(scores), axis=(0, 1))
    # 36 draws of a normal have a standard deviation of 1 +- 0.12
    assert np.all(spread > 0.55), dict(zip(NAMES, spread, strict=True))
    assert np.all(spread < 1.5), dict(zip(NAMES, spread, strict=True))


def test_noise_that_is_thought_too_small_makes_no_fit_too_sure(best: Design) -> None:
    """Poses 2.5 times as noisy as told, which are still taken: uncertainties cover what is found all the same."""
    rng, scores = np.random.default_rng(13), []
    for _ in range(8):
        device = made(best, rng)
        poses = measured(device, cube_points(best, rng, 40), rng, 2.5 * NOISE.position, 2.5 * NOISE.angle)
        found = fit(best.geometry, poses, noise=NOISE)
        assert 1.8 < found.misfit < 3.2
        scores.append(((found.unknowns.table - device.table) / found.sigma)[:, 3:6])  # which the poses tell
    assert np.sqrt(np.mean(np.square(scores))) < 1.6  # of 72 draws 1.2; 2.1 if uncertainties were those of the noise


@pytest.mark.parametrize(("position", "angle"), [(2e-6, 1e-3), (0.2e-3, 1e-6)])
def test_noise_of_either_kind_is_weighed_as_it_is(best: Design, position: float, angle: float) -> None:
    rng = np.random.default_rng(12)
    poses = measured(made(best, rng), cube_points(best, rng, 60), rng, position, angle)
    assert 0.8 < fit(best.geometry, poses, noise=Noise(position, angle)).misfit < 1.2


def test_zeros_may_be_anywhere(best: Design) -> None:
    rng = np.random.default_rng(4)
    device = made(best, rng)
    device.table[:, ZERO] = [2.5, -3.0, 1.0]
    found = fit(best.geometry, measured(device, cube_points(best, rng, 40), rng), noise=NOISE)
    assert found.misfit < 1.3
    assert np.isnan(found.before).any() or found.before.max() > 1e-2
    assert found.after.max() < 1e-4


def test_a_tracker_has_a_frame_of_its_own(best: Design) -> None:
    rng = np.random.default_rng(5)
    device = made(best, rng)
    poses = measured(device, cube_points(best, rng, 60), rng)
    turn, shift = Rotation.from_rotvec([0.6, -1.2, 2.0]).as_matrix(), np.array([0.4, -0.1, 0.7])
    seen = Poses((poses.positions - shift) @ turn, poses.readings)
    found = fit(best.geometry, seen, noise=NOISE, own_frame=True)
    assert found.frame.solved
    assert found.misfit < 1.3
    np.testing.assert_allclose(found.frame.rotation, turn, atol=4e-3)
    # distances between places are what a tracker tells whatever its frame is
    fresh = cube_points(best, rng, 60)
    read = readings(device, fresh)
    for unknowns, most in ((found.unknowns, 0.05e-3), (nominal(best.geometry), 1.0)):
        there = chain_positions(unknowns.mechanism, unknowns.angles(read))
        apart = [np.linalg.norm(np.diff(x, axis=0), axis=1) for x in (there, fresh)]
        assert np.sqrt(np.mean((apart[0] - apart[1]) ** 2)) < most
    lost = [one for one in unobservable(found) if one.never]
    assert sum(one.combinations for one in lost) == 6  # three pairs of radii, and where the device stands
    assert any({"height_offset_0", "height_offset_1", "height_offset_2"} <= set(one.names) for one in lost)


def test_what_cannot_be_distinguished_is_named(best: Design) -> None:
    rng = np.random.default_rng(6)
    found = fit(best.geometry, measured(made(best, rng), cube_points(best, rng, 40), rng), noise=NOISE)
    lost = [one for one in unobservable(found) if one.never]
    assert [one.names for one in lost] == [(f"base_radius_{i}", f"platform_radius_{i}") for i in range(3)]
    assert all("difference" in str(one) for one in lost)
    # a move along what is hidden moves nothing
    step = np.zeros(3 * COUNT)
    step[[0, 1]] = lost[0].moves
    moved = Unknowns(found.unknowns.table + (step * sigmas().ravel()).reshape(3, COUNT))
    p = cube_points(best, rng, 5)
    read = readings(found.unknowns, p)
    np.testing.assert_allclose(chain_positions(moved.mechanism, moved.angles(read)), p, atol=1e-12)


def test_poses_in_one_plane_tell_less(best: Design) -> None:
    rng = np.random.default_rng(8)
    p = cube_points(best, rng, 40)
    device = made(best, rng)
    flat = np.column_stack([p[:, :2], np.full(len(p), p[:, 2].mean())])
    whole, plane = (fit(best.geometry, measured(device, x, rng), noise=NOISE) for x in (p, flat))
    assert (plane.singular_values < 1.0).sum() > (whole.singular_values < 1.0).sum()
    assert np.all(plane.sigma.sum(axis=1) > whole.sigma.sum(axis=1))


def test_encoders_on_the_motors_turn_with_the_ratio(best: Design) -> None:
    rng = np.random.default_rng(9)
    device = made(best, rng, turns=4.8)
    found = fit(best.geometry, measured(device, cube_points(best, rng, 60), rng), noise=NOISE, turns=4.8)
    assert found.misfit < 1.3
    np.testing.assert_allclose(found.unknowns.table[:, ZERO + 1 :], device.table[:, ZERO + 1 :], atol=4e-4)


@pytest.mark.parametrize(("own", "least"), [(False, 14), (True, 16)])
def test_too_few_poses_are_refused_with_the_number_needed(best: Design, own: bool, least: int) -> None:
    rng = np.random.default_rng(2)
    assert poses_needed(own) == least
    poses = measured(made(best, rng), cube_points(best, rng, least), rng)
    fit(best.geometry, poses, own_frame=own)
    fewer = Poses(poses.positions[1:], poses.readings[1:])
    with pytest.raises(FitError, match=f"{least - 1} poses; at least {least}"):
        fit(best.geometry, fewer, own_frame=own)


def test_positions_and_readings_of_no_device_are_refused(best: Design) -> None:
    rng = np.random.default_rng(2)
    poses = measured(made(best, rng), cube_points(best, rng, 20), rng)
    far = poses.positions.copy()
    far[3, 2] += 0.4
    with pytest.raises(FitError, match="pose 4"):
        fit(best.geometry, Poses(far, poses.readings))
    short = DeltaGeometry(0.05, 0.02, 0.09, 0.1)  # its forearms do not meet with level arms
    with pytest.raises(FitError, match="zeros"):
        fit(short, Poses(poses.positions, np.zeros((20, 3))), own_frame=True)


def test_a_wrong_pose_shows(best: Design) -> None:
    rng = np.random.default_rng(2)
    poses = measured(made(best, rng), cube_points(best, rng, 40), rng)
    wrong = poses.positions.copy()
    wrong[7] += [0.0, 0.003, 0.0]
    found = fit(best.geometry, Poses(wrong, poses.readings), noise=NOISE)
    assert found.misfit > 3.0
    assert found.after.argmax() == 7


@pytest.mark.parametrize(("own", "count"), [(False, 14), (True, 16)])
def test_noise_alone_explains_as_few_poses_as_are_enough(best: Design, own: bool, count: int) -> None:
    """What is left of devices as scattered as the drawing assumes, in units of the noise: 1 in the mean."""
    rng, left = np.random.default_rng(7), []
    for _ in range(24):
        spread = sigmas(WAVE)
        spread[:, ZERO] = math.radians(0.3)  # flat over half a turn, so of no weight
        device = Unknowns(nominal(best.geometry).table + rng.normal(size=spread.shape) * spread)
        poses = measured(device, cube_points(best, rng, count), rng)
        left.append(fit(best.geometry, poses, noise=NOISE, wave=WAVE, own_frame=own).misfit ** 2)
    assert np.mean(left) == pytest.approx(1.0, abs=0.15)  # 24 times some 20 degrees of freedom: 0.065 is one sigma
