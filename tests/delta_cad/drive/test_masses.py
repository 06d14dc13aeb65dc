"""Masses: a rod's energy against a sum over its particles, the paper's lumps, and files that are refused."""

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from delta_cad.design import design_hash, load_design
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import MassError, Masses, PointMasses, load_masses, masses_from_dict, rod_masses
from tests.committed import BEST

LENGTH = 0.112
DESIGN = load_design(BEST)
DRIVE = drive_torque(DESIGN)


def data(**bodies: Any) -> dict[str, Any]:
    def body(mass: float, centre: list[float], inertia: list[float]) -> dict[str, Any]:
        return {"mass_kg": mass, "centre_m": centre, "inertia_kg_m2": np.diag(inertia).tolist()}

    known = {f"upper_arm_{i}": body(0.1, [0.013, 0.003, -0.004], [2e-5, 1.2e-4, 1.1e-4]) for i in range(3)}
    known |= {f"rod_{i}_{j}": body(0.003, [0.05, 0.0, 0.0], [1e-8, 4e-6, 4e-6]) for i in range(3) for j in range(2)}
    known |= {f"pinion_{i}": body(0.0015, [0.0, 0.0085, 0.0], [2e-8, 1.9e-8, 2e-8]) for i in range(3)}
    known["platform"] = body(0.07, [0.0, 0.0, 0.007], [4e-5, 4e-5, 5e-5])
    return {"schema": "delta-mass-properties/1", "bodies": deepcopy(known | bodies)}


@given(
    st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(1e-4, 1.0)), min_size=1, max_size=6),
    st.tuples(*[st.floats(-2.0, 2.0)] * 6),
)
def test_a_rods_energy_is_that_of_its_particles(particles: list[tuple[float, float]], ends: tuple[float, ...]) -> None:
    place, mass = np.array(particles).T
    u, v = np.array(ends[:3]), np.array(ends[3:])
    centre = (place * mass).sum() / mass.sum()
    inertia = (mass * ((place - centre) * LENGTH) ** 2).sum()
    uu, uv, vv = rod_masses(mass.sum(), centre * LENGTH, inertia, LENGTH)
    velocity = (1.0 - place)[:, None] * u + place[:, None] * v
    exact = 0.5 * (mass * (velocity**2).sum(axis=1)).sum()
    assert 0.5 * (uu * u @ u + 2.0 * uv * u @ v + vv * v @ v) == pytest.approx(exact, rel=1e-12, abs=1e-15)


def test_what_the_file_says_is_what_the_dynamics_gets() -> None:
    masses = masses_from_dict(data(), LENGTH, DRIVE)
    assert masses.platform == 0.07
    assert masses.arm_along == pytest.approx(0.1 * 0.013)
    assert masses.arm_across == pytest.approx(-0.1 * 0.004)
    assert masses.arm_inertia == pytest.approx(1.2e-4 + 0.1 * (0.013**2 + 0.004**2))  # Steiner, about the shoulder's y
    # both rods: all their mass, its first moment and its second about the elbow are kept
    total = masses.rod_elbow + 2.0 * masses.rod_cross + masses.rod_wrist
    assert total == pytest.approx(2.0 * 0.003)
    assert (masses.rod_cross + masses.rod_wrist) * LENGTH == pytest.approx(2.0 * 0.003 * 0.05)
    assert masses.rod_wrist * LENGTH**2 == pytest.approx(2.0 * (4e-6 + 0.003 * 0.05**2))
    assert masses.rotor_inertia == pytest.approx(DRIVE.ratio**2 * (3.33e-6 + 1.9e-8))  # RE 30 and a pinion
    bare = data()
    for i in range(3):
        del bare["bodies"][f"pinion_{i}"]
    assert masses_from_dict(bare, LENGTH, DRIVE).rotor_inertia == DRIVE.reflected_inertia_kg_m2
    assert masses_from_dict(bare, LENGTH).rotor_inertia == 0.0


def test_lumped_rods_weigh_the_same_and_resist_a_turn_three_times_as_much() -> None:
    lumped = PointMasses(0.07, 0.1, 0.006).masses(0.08)
    uu, uv, vv = rod_masses(0.006, LENGTH / 2.0, 0.006 * LENGTH**2 / 12.0, LENGTH)
    even = Masses(0.07, lumped.arm_along, 0.0, lumped.arm_inertia, uu, uv, vv)
    assert lumped.at_wrists == pytest.approx(even.at_wrists)
    assert lumped.at_elbow == pytest.approx(even.at_elbow)
    assert lumped.rod_elbow + lumped.rod_wrist == pytest.approx(3.0 * (uu - 2.0 * uv + vv))
    assert lumped.arm_along == pytest.approx(0.05 * 0.08)
    assert lumped.arm_inertia == pytest.approx(0.05 * 0.08**2)


def bad(body: str, key: str, value: Any) -> dict[str, Any]:
    changed = data()
    changed["bodies"][body][key] = value
    return changed


@pytest.mark.parametrize(
    ("given_data", "field", "value"),
    [
        ([], "schema", ""),
        ({"schema": "delta-mass-properties/2"}, "schema", ""),
        ({"schema": "delta-mass-properties/1", "bodies": 3}, "bodies.upper_arm_0", ""),
        (data(platform=None), "bodies.platform", ""),
        (bad("rod_1_1", "mass_kg", "heavy"), "bodies.rod_1_1.mass_kg", '"heavy"'),
        (bad("rod_1_1", "centre_m", [0.0, 0.0]), "bodies.rod_1_1.centre_m", "[0.0, 0.0]"),
        (bad("platform", "mass_kg", float("nan")), "bodies.platform.mass_kg", "NaN"),
        (bad("platform", "mass_kg", -0.1), "bodies.platform.mass_kg", "-0.1"),
        (bad("platform", "mass_kg", 0.0), "bodies.platform.mass_kg", "0.0"),
        (bad("platform", "mass_kg", 1e200), "bodies.platform.mass_kg", "1e+200"),
        (bad("platform", "mass_kg", True), "bodies.platform.mass_kg", "true"),
        (bad("platform", "mass_kg", 10**400), "bodies.platform.mass_kg", "1" + 56 * "0" + "..."),
        (bad("rod_0_0", "centre_m", [0.1, "0", 0.0]), "bodies.rod_0_0.centre_m", '[0.1, "0", 0.0]'),
        (bad("rod_0_0", "centre_m", [[0.1], [0.1, 0.2], 0.0]), "bodies.rod_0_0.centre_m", "[[0.1], [0.1, 0.2], 0.0]"),
        (
            bad("upper_arm_0", "inertia_kg_m2", np.diag([1e-5, -1.0, 1e-5]).tolist()),
            "bodies.upper_arm_0.inertia_kg_m2",
            "",
        ),
        (bad("upper_arm_0", "inertia_kg_m2", [1e-5, 1e-5, 1e-5]), "bodies.upper_arm_0.inertia_kg_m2", ""),
        (bad("upper_arm_2", "mass_kg", 0.11), "bodies.upper_arm_*", ""),
        (bad("rod_0_1", "centre_m", [0.051, 0.0, 0.0]), "bodies.rod_*", ""),
        (bad("rod_2_0", "inertia_kg_m2", np.diag([1e-8, 5e-6, 5e-6]).tolist()), "bodies.rod_*", ""),
    ],
)
def test_masses_that_are_refused(given_data: object, field: str, value: str) -> None:
    with pytest.raises(MassError) as caught:
        masses_from_dict(given_data, LENGTH)
    assert (caught.value.file, caught.value.field, caught.value.value) == ("masses", field, value)


def test_a_rod_that_is_no_rod_is_refused() -> None:
    flat = {"mass_kg": 0.003, "centre_m": [0.05, 0.0, 0.0], "inertia_kg_m2": np.diag([1e-8, 4e-6, 5e-6]).tolist()}
    with pytest.raises(MassError) as caught:
        masses_from_dict(data(**{f"rod_{i}_{j}": flat for i in range(3) for j in range(2)}), LENGTH)
    assert caught.value.field == "bodies.rod_0_0.inertia_kg_m2"


def test_a_malformed_pinion_is_refused() -> None:
    with pytest.raises(MassError) as caught:
        masses_from_dict(bad("pinion_0", "mass_kg", []), LENGTH, DRIVE)
    assert caught.value.field == "bodies.pinion_0.mass_kg"


@pytest.mark.parametrize("value", [float("nan"), -1e-9])
def test_masses_must_be_finite_and_not_negative(value: float) -> None:
    with pytest.raises(MassError) as caught:
        Masses(value, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert (caught.value.field, caught.value.value) == ("platform", repr(value))
    with pytest.raises(MassError) as caught:
        Masses(0.1, 0.0, float("inf"), 0.0, 0.0, 0.0, 0.0)
    assert caught.value.field == "arm_across"


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(MassError) as caught:
        load_masses(tmp_path / "none.json", DESIGN)
    assert (caught.value.file, caught.value.field) == ("none.json", "")
    file = tmp_path / "half.json"
    file.write_text("{")
    with pytest.raises(MassError) as caught:
        load_masses(file, DESIGN)
    assert (caught.value.file, caught.value.field) == ("half.json", "")
    file.write_text(json.dumps(data()))
    assert load_masses(file, DESIGN) == masses_from_dict(data(), DESIGN.geometry.forearm_length, DRIVE)


def test_a_file_that_says_another_design_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "masses.json"
    file.write_text(json.dumps(data() | {"input_sha256": design_hash(DESIGN)}))
    known = load_masses(file, DESIGN)
    for other in ("0" * 64, design_hash(DESIGN)[:12], 1, None):
        file.write_text(json.dumps(data() | {"input_sha256": other}))
        with pytest.raises(MassError, match=DESIGN.name) as caught:
            load_masses(file, DESIGN)
        assert (caught.value.file, caught.value.field) == ("masses.json", "input_sha256")
    file.write_text(json.dumps(data()))  # it does not say: the user's word
    assert load_masses(file, DESIGN) == known
