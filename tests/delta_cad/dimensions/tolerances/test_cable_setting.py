"""The pull that sets a cable, by hand and against the laid cable at every angle of the arm and any friction."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, remainder, sin, tanh, tau

import numpy as np
import pytest

from delta_cad.design import load_design
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.dimensions.bracket import key_rad
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.tolerances.cable_setting import CableSetting, bench_pull_N, cable_setting
from tests.committed import COMMITTED, ROOT


def of(d: Dimensions) -> tuple[CableSetting, CapstanDimensions]:
    setting = cable_setting(d)
    assert setting is not None
    return setting, setting.capstan


def test_what_the_readings_say_by_hand(best_dimensions: Dimensions) -> None:
    """Arm of 91 mm, sector of 38.7: a balance of 20 N is read to 0.3 N, a hand pulls up to 10 degrees askew."""
    setting, c = of(best_dimensions)
    low, high = setting.pull_N
    assert (setting.balance_N, setting.off_N) == (20.0, pytest.approx(0.3))
    assert setting.proven_N == pytest.approx((low - 0.3) * cos(radians(10.0)) * 91.0 / 38.7)
    assert setting.slips_N == pytest.approx((high + 0.3) * 91.0 / 38.7)
    both = setting.slips_N / tanh(0.12 * c.run.wrap_rad / 2.0)  # (e^x + 1) / (e^x - 1) of their difference
    assert setting.tension_N == pytest.approx(both / 2.0)
    assert setting.tight_N == pytest.approx((both + setting.slips_N) / 2.0)
    assert setting.needed_N == pytest.approx(0.8 / 0.96 / 0.0387)  # the controlled torque, less what the drive loses
    assert low == pytest.approx(round(low / 0.2) * 0.2)  # its divisions
    assert high - low >= max(0.14 * low, setting.step_N[1] - 0.2)
    assert bench_pull_N(best_dimensions) == 50  # 157 / 3.15


@pytest.mark.parametrize("machine", ["best_dimensions", "placed_dimensions"])
def test_what_stands_at_the_lower_reading_holds_the_drive_everywhere(
    machine: str, request: pytest.FixtureRequest
) -> None:
    setting, c = of(request.getfixturevalue(machine))
    angles = np.linspace(-0.5, 0.5, 31) * c.run.stroke_rad
    for friction in (0.12, 0.17, 0.23, 0.3):
        mean = setting.proven_N / float(c.laid(np.array([setting.arm_rad])).held_N(friction, setting.rises)[0])
        for outer_tight in (True, False):
            held = mean * c.laid(angles).held_N(friction, outer_tight)
            assert held.min() >= setting.needed_N * (1.0 - 1e-3)  # between the angles of its table
            assert np.all(held >= setting.held_N(angles) * (1.0 - 1e-3))
    worst = setting.held_N(angles).min()
    assert setting.needed_N * (1.0 - 1e-3) <= worst <= 1.08 * setting.needed_N  # and asks for no more than that


def test_a_looser_cable_creeps_too_early_and_a_tighter_one_too_late(best_dimensions: Dimensions) -> None:
    """At both ends of the band of friction a cable with what the drive needs lies between the readings or above."""
    setting, c = of(best_dimensions)
    laid = c.laid(np.array([setting.arm_rad]))
    for friction in (0.12, 0.3):
        for_1_N = float(laid.held_N(friction, setting.rises)[0]) / setting.lever
        step = setting.step_rad / tau * 0.5 / float(laid.length_mm[0])  # M3: half a millimetre a turn
        low, high = setting.step_N
        for stiff in best_dimensions.cable.stiffness_N:
            assert low * (1.0 - 1e-9) <= for_1_N * stiff * step <= high * (1.0 + 1e-9)
    assert high <= setting.pull_N[1] - setting.pull_N[0] + 0.2  # a step does not pass over the window, to a division


def test_where_it_is_pulled_a_set_screw_faces_its_key(best_dimensions: Dimensions) -> None:
    """The pinion turns against the arm by the ratio; its key comes along x of the chain's plane."""
    d, (setting, c) = best_dimensions, of(best_dimensions)
    arm = sum(d.stops_rad) / 2.0 + setting.arm_rad
    assert remainder(d.set_screws_rad[setting.screw] - c.ratio * arm, tau) == pytest.approx(0.0, abs=1e-9)
    slotted = replace(d, capstan=replace(c, collar_y_mm=(c.middle_y_mm + 4.0, c.middle_y_mm + 8.6)))
    other, at_motor = of(slotted)  # the collar in the motor's pilot: a slot of the cheek leads the key in askew
    key = key_rad(at_motor, d.bracket, d.motor)
    assert abs(key) > 0.1
    turned = d.set_screws_rad[other.screw] - c.ratio * (sum(d.stops_rad) / 2.0 + other.arm_rad)
    assert remainder(turned - key, tau) == pytest.approx(0.0, abs=1e-9)
    room = c.run.stroke_rad / 2.0 - (setting.arm_rad if setting.rises else -setting.arm_rad)
    assert room > radians(5.0)  # to creep


def test_the_rims_halves_are_those_of_the_drums(best_dimensions: Dimensions) -> None:
    """As the arm rises the outer half grows, so that its strand is the one that gets tight: off the polar angles."""
    d, (_, c) = best_dimensions, of(best_dimensions)
    for turned in (-0.8, 0.0, 0.8):
        pinion = c.direction_rad - (sum(d.stops_rad) / 2.0 + turned)  # in the arm's frame
        outer, inner = c.laid(np.array([turned])).outer[0], c.laid(np.array([turned])).inner[0]
        assert outer.angle_rad[0] == pytest.approx((c.rim_angles_rad[1] - pinion - c.run.tangent_rad) % tau, abs=1e-9)
        assert inner.angle_rad[0] == pytest.approx((pinion - c.run.tangent_rad - c.rim_angles_rad[0]) % tau, abs=1e-9)
    whole = float(c.laid(np.zeros(1)).length_mm[0])
    flat = 2.0 * c.run.middle_mm + c.run.wrap_rad * c.run.pinion_mm
    assert whole == pytest.approx(flat + (5.0 + 0.27) * pi / 2.0 + 6.0 + 1.2 + 6.0)


def test_the_strands_of_the_tightest_setting_under_a_difference(best_dimensions: Dimensions) -> None:
    setting, c = of(best_dimensions)
    turned, more = np.array([[-0.9, 0.9]]), np.array([[0.0, 15.0]])
    slack, tight = setting.strands_N(turned, more)
    np.testing.assert_allclose(tight - slack, more)
    assert slack[0, 0] == pytest.approx(setting.tension_N)
    either = [c.laid(turned[0]).strands_N(setting.tension_N, more[0], 0.12, outer)[0][1] for outer in (True, False)]
    assert slack[0, 1] == pytest.approx(max(either))
    assert abs(either[0] - either[1]) > 0.5  # the shorter strand takes more of it


def test_a_direct_drive_has_nothing_to_set(direct_dimensions: Dimensions) -> None:
    assert cable_setting(direct_dimensions) is None


def test_a_weaker_drive_needs_a_smaller_pull(best_dimensions: Dimensions) -> None:
    d = best_dimensions
    required = d.design.requirements.model_copy(update={"peak_torque_N_m": 0.6})
    weak, _ = of(replace(d, design=d.design.model_copy(update={"requirements": required})))
    strong, _ = of(d)
    assert weak.needed_N == pytest.approx(0.75 * strong.needed_N)
    assert weak.pull_N[0] < 0.85 * strong.pull_N[0]
    assert sin(weak.arm_rad) == pytest.approx(sin(strong.arm_rad))


def test_what_the_page_of_limits_says_of_cables() -> None:
    """Of the committed machine, its arm in the middle; steel at 17 and aluminium at 23 parts in a million a kelvin."""
    page = " ".join((ROOT / "docs" / "limits.md").read_text(encoding="utf-8").split())
    d = dimensions(load_design(COMMITTED))
    _, c = of(d)
    low, high = (c.laid(np.zeros(1)).pulled(1.0, friction)["mean"] for friction in (0.3, 0.12))
    assert f"Of a pull at the carriage {100 * low:.0f} to {100 * high:.0f} % come to be the mean tension" in page
    assert f"a strand of {c.run.free_mm:.0f} mm does not sound" in page
    warmed = (23e-6 - 17e-6) * 10.0 * d.cable.stiffness_N[1]
    assert f"about {warmed:.0f} N in 10 K" in page
