"""Gravity's part of the torque against the potential energy's gradient, whatever masses, tilt and pose."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.range.holding import holding_torque
from delta_cad.design import Design, design_from_dict
from delta_cad.drive.held import KNOWN, NEEDED
from delta_cad.mechanism import Cube, closure_margin, forearm_vectors, jacobian, worst_joint_torque
from delta_cad.mechanism.limits import HeldMasses, Torque
from delta_cad.mechanism.limits.holding_torque import gravity_torque
from delta_cad.mechanism.placement import LinkPlacement
from optimizer.certify.certificate import CertificateError, certify, limits_of, verify
from optimizer.certify.file import certificate_from_dict, certificate_to_dict
from optimizer.certify.gravity import (
    GravityAllowance,
    GravityError,
    allowance_of_masses,
    given_allowance,
)
from tests.delta_cad.mechanism.stated_limits import limits
from tests.designs import minimal
from tests.optimizer.messages import refuses

NUMERIC_N_M = 2e-9
"""Of the oracle: central differences over 0.01 mm of an energy of some 0.3 J, see tests/test_holding.py."""


def design_with(drive: str = "capstan", gravity: tuple[float, ...] = (0.0, 0.0, -9.81), **requirements: Any) -> Design:
    motor = "maxon-re30-310007" if drive == "capstan" else "maxon-ec60flat-408057"
    data = minimal()
    required = data["requirements"] | {"gravity_m_s2": list(gravity)} | requirements
    return design_from_dict(data | {"requirements": required, "hardware": {"drive": drive, "motor": motor}})


def masses_file(path: Path, bodies: dict[str, Any], home: Any = (0.0, 0.0, 94.612), **more: Any) -> Path:
    data = {"schema": "delta-mass-properties/1", "home_mm": list(home), "bodies": bodies} | more
    path.write_text(json.dumps(data))
    return path


def random_bodies(rng: np.random.Generator) -> dict[str, Any]:
    """Masses anywhere, each chain's its own, rods on their line; some bodies without mass."""
    found = {}
    for name in KNOWN:
        centre = rng.normal(0.0, 0.03, 3)
        if name.startswith("rod"):
            centre = np.array([rng.uniform(-0.01, 0.12), 0.0, 0.0])
        if name.startswith("pinion"):
            centre = rng.normal(0.0, 1e-3, 3)
        found[name] = {"mass_kg": float(rng.choice([0.0, 0.003, 0.1]) * rng.random()), "centre_m": centre.tolist()}
    return found


def oracle(design: Design, bodies: dict[str, Any], points: np.ndarray) -> np.ndarray:
    """(n, 3) holding torque by the gradient of the potential energy of the placed links."""
    ratio = design.hardware.capstan_ratio if design.hardware.drive == "capstan" else 1.0
    placement = LinkPlacement(design.geometry, 48.0, (14.5, -36.4), ratio)
    stand_in = Assembly("stand-in", (), (), (), placement, np.array([0.0, 0.0, 94.612]))
    moving = {n: (b["mass_kg"], 1e3 * np.array(b["centre_m"])) for n, b in bodies.items() if n != "base"}
    return holding_torque(stand_in, moving, points * 1e3, np.array(design.requirements.gravity_m_s2))


def points_of(n: int, rng: np.random.Generator) -> np.ndarray:
    """Adversarial: half of them on the surface of the cube, a few in its corners."""
    p = rng.uniform(-1.0, 1.0, (n, 3))
    p[np.arange(n // 2), rng.integers(0, 3, n // 2)] = rng.choice([-1.0, 1.0], n // 2)
    p[:16] = rng.choice([-1.0, 1.0], (16, 3))
    return np.array([0.0, 0.0, 0.094612]) + 0.0375 * p


def held(tmp_path: Path, design: Design, bodies: dict[str, Any], tolerance: float = 0.0) -> HeldMasses:
    masses = allowance_of_masses(masses_file(tmp_path / "m.json", bodies), design, tolerance).masses
    assert masses is not None
    return masses


@pytest.mark.parametrize("drive", ["capstan", "direct"])
@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (3.0, -5.0, -7.0), (9.81, 0.0, 0.0)])
def test_it_is_above_the_gradient_of_the_potential_energy(
    tmp_path: Path, drive: str, gravity: tuple[float, ...]
) -> None:
    rng = np.random.default_rng(5)
    design = design_with(drive, gravity)
    for _ in range(12):
        bodies = random_bodies(rng)
        points = points_of(120, rng)
        most = gravity_torque(design.geometry, points, held(tmp_path, design, bodies))
        assert (np.abs(oracle(design, bodies, points)) <= most + NUMERIC_N_M).all()


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (4.0, 0.0, -8.0)])
def test_of_three_alike_chains_nothing_is_added_to_it(tmp_path: Path, gravity: tuple[float, ...]) -> None:
    rng, design = np.random.default_rng(6), design_with(gravity=gravity)
    for _ in range(6):
        bodies = random_bodies(rng)
        for name in (name for name in KNOWN if name[-1:].isdigit()):
            kind = name.split("_")[0]
            like = next(other for other in KNOWN if other.startswith(kind))
            bodies[name] = bodies[like] | {"mass_kg": 0.0} if kind == "pinion" else bodies[like]
        points = points_of(100, rng)
        most = gravity_torque(design.geometry, points, held(tmp_path, design, bodies))
        np.testing.assert_allclose(most, np.abs(oracle(design, bodies, points)), atol=10.0 * NUMERIC_N_M)


def test_it_holds_for_a_rod_whose_centre_is_next_to_its_line(tmp_path: Path) -> None:
    """Free to turn, it hangs (or stands) so that its energy is least (or most): -+ m e |g x s| / L_B more."""
    rng, design = np.random.default_rng(4), design_with(gravity=(3.0, -5.0, -7.0))
    g, points, nothing = np.array([3.0, -5.0, -7.0]), points_of(200, rng), {"mass_kg": 0.0, "centre_m": [0.0, 0.0, 0.0]}
    mass, along, adjacent = 0.1, 0.05, np.array([0.006, 0.008])
    rod = {"mass_kg": mass, "centre_m": [along, *adjacent]}
    bodies = dict.fromkeys(NEEDED, nothing) | {"rod_1_0": rod}
    masses = held(tmp_path, design, bodies)
    assert masses.carried_mass == pytest.approx(mass * 0.05 / 0.112079, rel=1e-11)
    assert masses.loose_mass == pytest.approx(mass * 0.01 / 0.112079, rel=1e-11)  # |(0.006, 0.008)| = 0.01 m
    most = gravity_torque(design.geometry, points, masses)
    on_line = oracle(design, bodies | {"rod_1_0": rod | {"centre_m": [along, 0.0, 0.0]}}, points)

    def energy(p: np.ndarray) -> np.ndarray:
        s = forearm_vectors(design.geometry, p)[..., 1, :]
        return mass * float(np.hypot(*adjacent)) * np.linalg.norm(np.cross(g, s), axis=-1) / 0.112079

    h = 1e-6
    gradient = np.stack([energy(points + h * e) - energy(points - h * e) for e in np.eye(3)], axis=-1) / (2.0 * h)
    more = np.einsum("nij,ni->nj", jacobian(design.geometry, points), gradient)
    assert np.abs(more).max() > 1e-3  # it matters here
    for sign in (-1.0, 1.0):
        # rounding of the energy, 1e-2 J times 1e-16, over 2 h, is below the oracle's error
        assert (np.abs(on_line + sign * more) <= most + NUMERIC_N_M).all()


def test_lengths_within_a_tolerance_are_within_what_is_loose(tmp_path: Path) -> None:
    rng, within = np.random.default_rng(12), 2e-4
    design = design_with()
    bodies = random_bodies(rng)
    masses = held(tmp_path, design, bodies, within)
    for _ in range(20):
        L_A, L_B = np.array([82.0, 112.079]) + 1e3 * within * rng.choice([-1.0, 1.0], 2)
        lengths = design.mechanism.model_copy(update={"upper_arm_length_mm": L_A, "forearm_length_mm": L_B})
        other = design.model_copy(update={"mechanism": lengths})
        points = points_of(60, rng)
        most = gravity_torque(other.geometry, points, masses)
        assert (np.abs(oracle(other, bodies, points)) <= most + NUMERIC_N_M).all()


def test_force_and_gravity_together_stay_within_the_torque_that_is_proved(tmp_path: Path) -> None:
    """The certificate's meaning, sampled: force of 3 N in the direction that adds to gravity, at 4000 points."""
    rng = np.random.default_rng(8)
    for gravity in ((0.0, 0.0, -9.81), (3.0, -5.0, -7.0)):
        design = design_with(gravity=gravity)
        bodies = random_bodies(rng)
        share = allowance_of_masses(masses_file(tmp_path / "m.json", bodies), design)
        points = points_of(4000, rng)
        total = np.abs(oracle(design, bodies, points)) + worst_joint_torque(design.geometry, points, 3.0)
        low, high = 0.01, 5.0  # the least torque that is proved
        for _ in range(20):
            middle = (low + high) / 2.0
            enough = certify(design, replace(share, torque=middle).limits(limits_of(design, None)))
            low, high = (low, middle) if enough.verdict == "proved" else (middle, high)
        assert total.max() <= high + NUMERIC_N_M
        assert high <= (1.05 if gravity[1] == 0.0 else 1.5) * total.max()  # no nonsense of a bound either


def shares() -> tuple[Design, GravityAllowance]:
    design = design_with()
    return design, given_allowance(design, 0.11)


def test_a_share_given_by_hand_is_taken_off_and_replayed() -> None:
    design, share = shares()
    certificate = certify(design, gravity=share)
    torque = certificate.limits.get(Torque)
    assert torque is not None
    assert torque.force == 3.0
    assert 0.69 - 1e-15 < torque.torque_max <= 0.69
    assert certificate.verdict == "proved"
    assert verify(certificate, design).proved == ("reach", "assembly_mode", "torque")
    data = json.loads(json.dumps(certificate_to_dict(certificate)))
    assert data["gravity"]["reserve_N_m"] == 0.11
    assert certificate_from_dict(data).gravity == share


def test_masses_are_recorded_and_come_back(tmp_path: Path) -> None:
    design = design_with()
    bodies = random_bodies(np.random.default_rng(2))
    share = allowance_of_masses(masses_file(tmp_path / "m.json", bodies), design)
    certificate = certify(design, gravity=share)
    assert "holding_torque" in verify(certificate, design).proved
    assert certificate_from_dict(json.loads(json.dumps(certificate_to_dict(certificate)))).gravity == share
    assert share.masses is not None
    lighter = replace(share.masses, carried_mass=share.masses.carried_mass * (1 - 1e-9))
    for forged in (
        replace(share, masses=lighter),
        replace(share, masses=replace(share.masses, gravity_z=-9.8)),
        replace(share, torque=share.torque * (1 - 1e-9)),
        replace(share, force=share.force * (1 + 1e-9)),
    ):
        with pytest.raises(CertificateError, match=r"^torque: "):
            verify(replace(certificate, gravity=forged))
    light = certify(design, gravity=replace(share, masses=replace(share.masses, gravity_z=-1.0)))
    verify(light)
    with pytest.raises(CertificateError, match=r"^torque: "):
        verify(light, design)
    without = certify(design, limits())
    for given in (share, given_allowance(design, 0.11)):
        with pytest.raises(CertificateError, match="torque"):
            verify(replace(without, gravity=given))
    data = certificate_to_dict(certificate)
    for wrong in ({"reserve_N_m": 0.1}, {"mass_file_sha256": None}):
        with pytest.raises(CertificateError):
            certificate_from_dict(data | {"gravity": data["gravity"] | wrong})


@pytest.mark.parametrize(
    ("field", "forged"),
    [
        *(("reserve", value) for value in (0.11 * (1 + 1e-9), 0.2, float("nan"), -1.0, None)),
        ("force", 3.0 * (1 + 1e-9)),
        ("torque", 0.8 * (1 - 1e-9)),
    ],
)
def test_a_share_that_is_looser_than_reported_is_refused(field: str, forged: float | None) -> None:
    design, share = shares()
    certificate = certify(design, gravity=share)
    with pytest.raises(CertificateError, match=r"^torque: "):
        verify(replace(certificate, gravity=replace(share, **{field: forged})))


def test_gravity_that_takes_all_of_the_torque_is_refused() -> None:
    design, share = shares()
    for reserve in (0.8, -0.1, float("nan"), float("inf")):
        with refuses(GravityError, "0", "requirements.joint_torque_N_m", "0.8"):
            given_allowance(design, reserve)
    with refuses(GravityError, "0.9", "0.8"):
        certify(design, gravity=replace(share, reserve=0.9))


BODIES = {name: {"mass_kg": 0.01, "centre_m": [0.01, 0.0, 0.0]} for name in KNOWN}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"schema": "other/1"}, "schema: "),
        ({"home_mm": [0.0, 0.0, 99.0]}, "home_mm = [0.0, 0.0, 99.0]: "),
        ({"home_mm": "there"}, "home_mm = there: "),
        ({"bodies": None}, "bodies: "),
        ({"bodies": BODIES | {"tail": BODIES["base"]}}, "bodies.tail: "),
        ({"bodies": {n: b for n, b in BODIES.items() if n != "platform"}}, "bodies.platform: "),
        ({"bodies": {n: b for n, b in BODIES.items() if n != "rod_2_1"}}, "bodies.rod_2_1: "),
        (
            {"bodies": BODIES | {"platform": {"mass_kg": -1.0, "centre_m": [0, 0, 0]}}},
            "mass_kg = -1.0: 0",
        ),
        (
            {"bodies": BODIES | {"platform": {"mass_kg": True, "centre_m": [0, 0, 0]}}},
            "mass_kg = true: 0",
        ),
        (
            {"bodies": BODIES | {"platform": {"mass_kg": 1.0, "centre_m": [0, 0]}}},
            "centre_m = [0, 0]: 3",
        ),
    ],
)
def test_mass_properties_that_do_not_fit_are_refused(tmp_path: Path, change: dict[str, Any], words: str) -> None:
    path = masses_file(tmp_path / "m.json", **({"bodies": BODIES} | change))
    with refuses(GravityError, "m.json: ", words):
        allowance_of_masses(path, design_with())


def test_mass_properties_that_cannot_be_read(tmp_path: Path) -> None:
    with refuses(GravityError, "none.json"):
        allowance_of_masses(tmp_path / "none.json", design_with())
    (tmp_path / "m.json").write_text("{")
    with refuses(GravityError, "m.json"):
        allowance_of_masses(tmp_path / "m.json", design_with())


def test_a_pinion_is_not_needed(tmp_path: Path) -> None:
    design = design_with("direct")
    few = {name: BODIES[name] for name in NEEDED}
    assert held(tmp_path, design, few).carried_mass > 0.0


def test_sampled_points_are_in_reach() -> None:
    design, cube = design_with(), Cube(0.057112, 0.0375)
    points = points_of(100, np.random.default_rng(0))
    assert (points >= cube.lower - 1e-12).all()
    assert (points <= cube.upper + 1e-12).all()
    assert (closure_margin(design.geometry, points) > 0.0).all()
