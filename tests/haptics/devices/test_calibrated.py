"""A made device behind its calibration: the controller sees the drawn one, and the hand gets what was meant."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.mechanism import inverse_kinematics, jacobian
from delta_cad.mechanism.chains import chain_angles
from delta_cad.mechanism.geometry import DeltaGeometry
from haptics.calibration.unknowns import LENGTHS, Unknowns, nominal
from haptics.devices.calibrated import CalibratedDevice
from haptics.devices.device import Reading
from tests.haptics.calibration.devices import cube_points, made, readings
from tests.haptics.devices.fake import FakeDevice


@pytest.mark.parametrize("turns", [1.0, 4.8])
def test_readings_become_those_of_the_drawn_device_at_the_same_place(best: Design, turns: float) -> None:
    rng = np.random.default_rng(1)
    device, p = made(best, rng, turns), cube_points(best, rng, 10)
    seen = CalibratedDevice(FakeDevice(list(readings(device, p))), best.geometry, device)
    for point in p:
        sample = seen.read()
        np.testing.assert_allclose(seen.position, point, atol=1e-12)
        np.testing.assert_allclose(sample.angles, inverse_kinematics(best.geometry, point), atol=1e-11)
    assert seen.time == seen.device.time


def test_a_device_as_far_off_as_a_calibration_may_hold(best: Design) -> None:
    """Arms stand up to half a radian from the drawn ones there."""
    rng = np.random.default_rng(5)
    table, p, most = nominal(best.geometry).table, cube_points(best, rng, 20), 0.0
    for _ in range(20):
        device = Unknowns(table + np.hstack([rng.choice([-5e-3, 5e-3], (3, LENGTHS)), np.zeros((3, 5))]))
        for point, angles in zip(p, chain_angles(device.mechanism, p), strict=True):
            drawn = CalibratedDevice(FakeDevice([angles]), best.geometry, device).read().angles
            wanted = inverse_kinematics(best.geometry, point)
            np.testing.assert_allclose(drawn, wanted, atol=1e-11)
            most = max(most, np.abs(wanted - angles).max())
    assert most > 0.3


def test_torques_do_the_work_that_was_meant(best: Design) -> None:
    """The force at the handle by the made device's own statics: differences of its readings along each axis."""
    rng = np.random.default_rng(2)
    device, point, force = made(best, rng), cube_points(best, rng, 1)[0], np.array([1.0, -2.0, 0.5])
    fake = FakeDevice([readings(device, point[None])[0]])
    seen = CalibratedDevice(fake, best.geometry, device)
    seen.read()
    seen.write(jacobian(best.geometry, point).T @ force)
    step, work = 1e-6, np.empty(3)
    for k, axis in enumerate(np.eye(3)):
        # motors turn the arms: their work is torque times the arm's turn, whatever the encoder says of it
        ends = [chain_angles(device.mechanism, point + sign * step * axis) for sign in (1.0, -1.0)]
        work[k] = fake.written[0] @ (ends[0] - ends[1]) / (2.0 * step)
    np.testing.assert_allclose(work, force, atol=2e-6)


def test_a_device_as_drawn_stays_as_it_is(best: Design) -> None:
    point = np.array([0.01, -0.02, 0.11])
    angles = inverse_kinematics(best.geometry, point)
    fake = FakeDevice([Reading(angles, 0.5, 4)])
    seen = CalibratedDevice(fake, best.geometry, nominal(best.geometry))
    sample = seen.read()
    np.testing.assert_allclose(sample.angles, angles, atol=1e-14)
    assert (sample.time, sample.flags) == (0.5, 4)
    seen.write([0.1, -0.2, 0.3])
    np.testing.assert_allclose(fake.written[0], [0.1, -0.2, 0.3], atol=1e-13)
    seen.close()
    assert fake.closed == 1


def test_where_nothing_is_known_nothing_is_pushed() -> None:
    short = DeltaGeometry(0.05, 0.02, 0.09, 0.1)  # its forearms do not meet with level arms
    fake = FakeDevice([np.array([np.nan, 0.9, 0.9]), np.zeros(3)])
    seen = CalibratedDevice(fake, short, nominal(short))
    for _ in range(2):
        assert np.isnan(seen.read().angles).all()
        seen.write([0.1, 0.1, 0.1])
    np.testing.assert_array_equal(fake.written, np.zeros((2, 3)))


def test_a_reading_that_is_not_fresh_leaves_the_last_place(best: Design) -> None:
    """The torques that stand for a tick that is left out are turned as before it."""
    rng = np.random.default_rng(2)
    device, point = made(best, rng), cube_points(best, rng, 1)
    angles = readings(device, point)[0]
    fake = FakeDevice([Reading(angles, 0.0), Reading(np.where([0, 1, 0], np.nan, angles), 1e-3, 0, 5)])
    seen = CalibratedDevice(fake, best.geometry, device)
    found = []
    for _ in range(2):
        found.append(seen.read())
        seen.write([0.1, -0.2, 0.3])
    assert (found[0].fresh, found[1].fresh) == (7, 5)
    np.testing.assert_array_equal(found[0].angles, found[1].angles)
    np.testing.assert_array_equal(fake.written[0], fake.written[1])
    assert np.abs(fake.written[0]).min() > 0.0
