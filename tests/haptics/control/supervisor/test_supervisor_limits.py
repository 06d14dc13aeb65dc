"""Limits: what follows from a design, and what is refused."""

import math

import numpy as np
import pytest

from delta_cad.design import DesignError, design_from_dict
from delta_cad.mechanism import inverse_kinematics, jacobian
from haptics.control.supervisor.faults import FaultCode, State, described
from haptics.control.supervisor.limits import SafetyLimits, checked, safety_limits
from haptics.control.supervisor.safety import Supervisor
from haptics.model.motor_heat import Heat
from tests.designs import changed
from tests.haptics.control.supervisor.rig import DESIGN, GEOMETRY, LIMITS, with_limits


def test_they_follow_from_the_design() -> None:
    assert LIMITS.torque == 0.8
    assert LIMITS.encoder_count == 2.0 * math.pi / 2**21
    assert LIMITS.motor.continuous == pytest.approx(9.85 * 0.96 * 0.085)
    assert LIMITS.energy == pytest.approx(3.0 * math.sqrt(3.0) * 0.075)
    assert LIMITS.joint_acceleration == pytest.approx(2.0 * 0.8 / (9.85**2 * 3.33e-6))


def test_all_of_the_cube_is_inside_the_limits() -> None:
    rng = np.random.default_rng(1)
    p = rng.uniform(-1, 1, (2000, 3)) * 0.0375 + [0.0, 0.0, 0.057112 + 0.0375]
    theta, jac = inverse_kinematics(GEOMETRY, p), jacobian(GEOMETRY, p)
    assert theta.min() > LIMITS.theta_low
    assert theta.max() < LIMITS.theta_high
    turn = np.linalg.norm(np.linalg.inv(jac), axis=-1).max() * LIMITS.speed
    assert turn < LIMITS.joint_speed < 2.0 * turn  # 1.5 times, and a margin around the cube


def test_a_change_is_taken_and_what_follows_from_it_follows() -> None:
    slow = safety_limits(DESIGN, speed=1.0, period=2e-3, energy=0.1)
    assert slow.speed == 1.0
    assert slow.joint_speed == pytest.approx(LIMITS.joint_speed / 2)
    assert slow.late == pytest.approx(2.0 * LIMITS.late)
    assert slow.energy_start == 0.1


def test_a_weak_motor_limits_the_torque() -> None:
    weak = design_from_dict(changed("requirements.joint_torque_N_m", 50.0))
    assert safety_limits(weak).torque < 5.0


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(ValueError, match=r"colour, taste.* period, .* housing_time"):
        safety_limits(DESIGN, colour=1.0, taste=2.0)


def test_a_margin_out_of_reach_is_refused() -> None:
    with pytest.raises(DesignError, match=r"cube\.half_side_mm = 37\.5: .* by 40 mm"):
        safety_limits(DESIGN, edge_margin=0.04, edge_far=0.05)


@pytest.mark.parametrize("name", [*SafetyLimits._fields[:-1], *Heat._fields])
@pytest.mark.parametrize("value", [math.nan, -math.inf])
def test_no_limit_may_be_no_number(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"^{name} is -?(nan|inf)"):
        checked(with_limits(**{name: value}))


@pytest.mark.parametrize("name", ["period", "torque", "slew", "energy", "late_ticks", "winding_time"])
def test_what_must_be_positive(name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name} is 0.0"):
        checked(with_limits(**{name: 0.0}))


@pytest.mark.parametrize("name", ["frozen_turn", "frozen_torque", "stale"])
def test_what_may_be_switched_off(name: str) -> None:
    assert checked(with_limits(**{name: math.inf}))


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"theta_low": 2.0}, "theta_low is 2.0.* theta_high"),
        ({"late": 5e-4}, "period is 0.001.* late"),
        ({"missed": 1e-3}, "late is .* missed"),
        ({"edge_far": 1e-3}, "edge_margin is .* edge_far"),
        ({"reach_low": 1e-3}, "reach_min is .* reach_low"),
        ({"volume_low": 1e-3}, "volume_min is .* volume_low"),
        ({"ambient": 99.0}, "ambient is 99.0.* derate"),
        ({"derate": 125.0}, "derate is 125.0.* hottest"),
        ({"gravity_slew": 401.0}, "gravity_slew is 401.0.* slew"),
        ({"energy_start": 1.0}, "energy_start is 1.0.* energy"),
    ],
)
def test_what_contradicts_itself_is_refused(changes: dict[str, float], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        Supervisor(with_limits(**changes))


def test_findings_in_words() -> None:
    assert described(0) == "no findings"
    text = described(FaultCode.OVERSPEED.bit | FaultCode.TICK_LATE.bit)
    assert text == "6 TICK_LATE: a tick came late (warning); 14 OVERSPEED: the handle is too fast (fault)"
    assert Supervisor(LIMITS).state is State.DISABLED
