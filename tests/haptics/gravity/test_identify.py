"""What the published torques tell: two sums of masses, found again from torques made up, and no third."""

import json
from pathlib import Path

import numpy as np
import pytest

from delta_cad.common.units import GRAVITY_M_S2
from delta_cad.drive.masses import PointMasses
from delta_cad.mechanism import DeltaGeometry
from haptics.gravity import gravity_torque, published
from haptics.gravity import identify as module
from haptics.gravity.identify import identify

PAPER = json.loads((Path(__file__).parents[2] / "references" / "rcim2018.json").read_text())
GEOMETRY = DeltaGeometry(0.040, 0.030, 0.082, 0.1121)


def test_the_numbers_are_those_of_the_paper() -> None:
    rows = PAPER["gravity_torques_mN_m"]
    assert [tuple(row["position_mm"]) for row in rows] == list(published.GRAVITY_POSITIONS_MM)
    assert [tuple(row["torque"]) for row in rows] == list(published.GRAVITY_TORQUES_MN_M)
    assert PAPER["table_13_max_stiffness_N_per_mm"] == published.STIFFNESS_N_PER_MM


def test_two_sums_explain_six_torques_as_well_as_their_own_noise() -> None:
    found = identify()
    assert found.rank == 2
    assert found.rms_N_m < found.spread_N_m
    # any three masses with these sums give the fitted torques: here m3 = 0
    masses = PointMasses(found.at_wrists_kg, 2.0 * found.at_elbow_kg, 0.0)
    home = gravity_torque(GEOMETRY, masses, [0.0, 0.0, found.origin_height_m], [0.0, 0.0, -GRAVITY_M_S2])
    assert home == pytest.approx(found.torques_N_m[0], rel=1e-9)


def test_no_third_mass_shows_at_any_position() -> None:
    p = np.array([0.0, 0.0, 0.0946]) + np.random.default_rng(2).uniform(-0.03, 0.03, (50, 3))
    one, other = PointMasses(0.05, 0.04, 0.01), PointMasses(0.05 - 0.0075, 0.04 - 0.005, 0.01 + 0.005)
    torques = [gravity_torque(GEOMETRY, masses, p, [1.0, 2.0, -9.0]) for masses in (one, other)]
    assert torques[0] == pytest.approx(torques[1], rel=1e-12)


def test_made_up_masses_are_found_again(monkeypatch: pytest.MonkeyPatch) -> None:
    p = module._positions(0.070)
    torque = gravity_torque(GEOMETRY, PointMasses(0.03, 0.05, 0.02), p, [0.0, 0.0, -GRAVITY_M_S2])
    monkeypatch.setattr(published, "GRAVITY_TORQUES_MN_M", tuple(map(tuple, (torque * 1e3).tolist())))
    found = identify()
    assert found.at_wrists_kg == pytest.approx(0.06, rel=1e-4)
    assert found.at_elbow_kg == pytest.approx(0.035, rel=1e-4)
    assert found.origin_height_m == pytest.approx(0.070, abs=1e-6)
    assert found.rms_N_m < 1e-8
