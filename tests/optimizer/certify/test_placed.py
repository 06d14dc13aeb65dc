"""Certificates of machines whose chains and cube stand elsewhere: made, written, read, replayed, and forged."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from delta_cad.design import Design, design_from_dict
from delta_cad.mechanism import cube_extremes
from delta_cad.mechanism.geometry import THREE_FOLD
from delta_cad.mechanism.limits import Limits
from optimizer.certify.certificate import Certificate, CertificateError, UnreadableError, certify, verify
from optimizer.certify.file import certificate_from_dict, certificate_to_dict, read_certificate, write_certificate
from optimizer.certify.gravity import GravityError, allowance_of_masses
from tests.delta_cad.mechanism.stated_limits import limits
from tests.designs import minimal
from tests.optimizer.certify.designs import masses, redigested
from tests.optimizer.messages import refuses

KEYS = {"geometry": ("side_shift_m", "side_cosine"), "cube": ("centre_x_m",)}
MECHANISM: dict[str, Any] = {
    "base_radius_mm": 31.19,
    "platform_radius_mm": 22.55,
    "upper_arm_length_mm": 94.4,
    "forearm_length_mm": 148.4,
    "parallelogram_width_mm": 50.0,
}


def design_of(radii: list[float] | None, phi_deg: float | None, centre_mm: float | None) -> Design:
    data = minimal() | {"mechanism": MECHANISM.copy(), "cube": {"bottom_height_mm": 75.8, "half_side_mm": 40.0}}
    data["hardware"] = {"drive": "capstan", "motor": "maxon-re30-310007", "ball_diameter_mm": 6.0}
    if radii is not None:
        data["mechanism"] |= {"base_radius_mm": radii[0], "base_radii_mm": radii}
    if phi_deg is not None:
        data["mechanism"]["azimuths_deg"] = [0.0, phi_deg, -phi_deg]
    if centre_mm is not None:
        data["cube"]["centre_x_mm"] = centre_mm
    return design_from_dict(data)


DESIGNS = {
    "study": design_of([31.19, 38.45, 38.45], 116.3, 11.1),
    "wide": design_of([38.0, 30.0, 30.0], 124.0, -6.0),
    "shifted": design_of([31.19, 38.45, 38.45], None, None),
    "turned": design_of(None, 112.0, None),
    "aside": design_of(None, None, 7.0),
}


def tight(design: Design) -> Limits:
    """Limits a thousandth above the extremes."""
    e = cube_extremes(design.geometry, design.workspace, 3.0)
    return limits(
        force=3.0,
        torque_max=e.torque_max.value * 1.001,
        kappa_max=e.kappa_max.value * 1.001,
        shoulder=(e.shoulder_min.value - 0.001, e.shoulder_max.value + 0.001),
        lean_max=e.lean_max.value * 1.001,
    )


@pytest.fixture(scope="module")
def proved() -> Certificate:
    return certify(DESIGNS["study"], tight(DESIGNS["study"]))


@pytest.mark.parametrize("name", DESIGNS)
def test_it_is_proved_written_read_and_proved_again(name: str, tmp_path: Path) -> None:
    design, path = DESIGNS[name], tmp_path / "certificate.json"
    certificate = certify(design, tight(design))
    assert certificate.verdict == "proved"
    write_certificate(certificate, path)
    read = read_certificate(path)
    assert (read.geometry, read.cube) == (design.geometry, design.workspace)
    assert set(verify(read, design).proved) == set(certificate.limits.names)
    data = json.loads(path.read_text())
    g, cube = design.geometry, design.workspace
    placed = {"side_shift_m": g.side_shift, "side_cosine": g.side_cosine, "centre_x_m": cube.centre_x}
    unplaced = {"side_shift_m": 0.0, "side_cosine": THREE_FOLD, "centre_x_m": 0.0}
    found = {key: data[section][key] for section, keys in KEYS.items() for key in keys if key in data[section]}
    assert found == {key: value for key, value in placed.items() if value != unplaced[key]}
    assert "centre_x - half_side" in data["statement"]


def test_of_a_symmetric_machine_nothing_is_written_of_its_placement() -> None:
    design = design_of([31.19] * 3, 120.0, 0.0)
    same = design_of(None, None, None)
    assert (design.geometry, design.workspace) == (same.geometry, same.workspace)
    data = certificate_to_dict(certify(design, limits()))
    assert list(data["geometry"]) == ["base_radius_m", "platform_radius_m", "upper_arm_length_m", "forearm_length_m"]
    assert list(data["cube"]) == ["bottom_height_m", "half_side_m", "top_height_m"]
    assert "with x and y in [-half_side, half_side] and z in" in data["statement"]
    assert not any(word in data["statement"] for word in ("side_shift", "side_cosine", "centre_x"))


@pytest.mark.parametrize(("section", "key"), [(section, key) for section, keys in KEYS.items() for key in keys])
def test_what_is_left_out_or_changed_of_the_placement_is_noticed(proved: Certificate, section: str, key: str) -> None:
    data = json.loads(json.dumps(certificate_to_dict(proved)))
    content = {k: v for k, v in data[section].items() if k != key}
    for forged in (content, content | {key: data[section][key] + 1e-9}):
        other = certificate_from_dict(redigested(data | {section: forged}))
        with pytest.raises(CertificateError, match="other dimensions"):
            verify(other, DESIGNS["study"])
        with pytest.raises(CertificateError, match="digest"):
            certificate_from_dict(data | {section: forged})
    without = certificate_from_dict(redigested(data | {section: content}))
    with pytest.raises(CertificateError, match="could not be proved again"):  # the limits are those of the machine
        verify(without)


def test_the_words_of_a_symmetric_machine_do_not_fit_a_placed_one(proved: Certificate) -> None:
    data = certificate_to_dict(proved)
    words = certificate_to_dict(
        replace(proved, geometry=design_of(None, None, None).geometry, cube=replace(proved.cube, centre_x=0.0))
    )
    assert words["statement"] != data["statement"]
    with refuses(CertificateError, "certificate: statement"):
        certificate_from_dict(redigested(json.loads(json.dumps(data | {"statement": words["statement"]}))))


def changed(data: dict[str, Any], section: str, key: str, value: object) -> dict[str, Any]:
    return redigested(json.loads(json.dumps(data | {section: data[section] | {key: value}})))


def test_a_placement_that_cannot_be_is_refused_with_its_bound(proved: Certificate) -> None:
    data = certificate_to_dict(proved)
    for section, key, value, wanted in (
        ("geometry", "side_cosine", 0.7, "certificate: side_cosine is 0.7 0.500000"),
        ("geometry", "side_shift_m", -0.04, "certificate: side_shift is -0.04"),
        ("geometry", "side_cosine", "0.1", "certificate: geometry.side_cosine"),
        ("cube", "centre_x_m", 11.1, "certificate: centre_x is 11.1 10"),
        ("cube", "centre_x", 0.01, "certificate: cube.centre_x"),
    ):
        with refuses(UnreadableError, wanted):
            certificate_from_dict(changed(data, section, key, value))


def test_masses_are_those_of_a_machine_at_home_where_its_arms_stand_alike(tmp_path: Path) -> None:
    design = DESIGNS["study"]
    path = masses(tmp_path, design)
    assert allowance_of_masses(path, design).masses is not None
    data = json.loads(path.read_text())
    path.write_text(json.dumps(data | {"home_mm": [0.0, *data["home_mm"][1:]]}))
    with refuses(GravityError, f"mass_properties.json: home_mm 0.0 115.8 {float(design.home_mm[0])!r}"):
        allowance_of_masses(path, design)
