"""`verify`: a certificate replayed in another arithmetic, without trust in the file or in the prover."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, ProgressLine, refuse
from delta_cad.common.options import CATALOGUE, DESIGN, JSON, MASS_PROPERTIES, POSITIVE, Option, number
from delta_cad.common.units import MM_PER_M

if TYPE_CHECKING:
    from delta_cad.design import Design
    from optimizer.certify.certificate import Certificate, Replay
    from optimizer.certify.gravity import GravityAllowance

NAME = "verify"
LOADS = {"force_N", "joint_torque_N_m", "gravity_m_s2"}  # which the limits on torque are made of
TEXT = "check a certificate independently"
OPTIONS = (
    Option("certificate", type=Path, metavar="CERT", help="certificate written by `certify`"),
    DESIGN.but(settle=None, help="design that the certificate must be about and be sufficient for"),
    CATALOGUE,
    (
        MASS_PROPERTIES.but(
            help="mass_properties.json that the weight and the effective mass must come from; needs --design",
        ),
        Option(
            "--gravity-torque",
            type=float,
            metavar="N_m",
            help="torque that must be reserved for gravity at every joint; needs --design",
        ),
        Option(
            "--without-gravity",
            action="store_true",
            help="accept a certificate whatever it reserves for gravity, even nothing",
        ),
    ),
    Option(
        "--as-recorded",
        action="store_true",
        help="trust the masses and the weight recorded in the certificate; otherwise a design that states gravity or "
        "limits the effective mass needs --mass-properties",
    ),
    Option(
        "--tolerance",
        type=number(POSITIVE, unit="mm"),
        metavar="MM",
        help="the certificate must cover all machines within at least this deviation",
    ),
    JSON,
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.design import DesignError, load_design
    from delta_cad.drive.masses import MassError
    from optimizer.certify.certificate import CertificateError, UnreadableError, verify
    from optimizer.certify.file import read_certificate
    from optimizer.certify.gravity import GravityError

    name = given.certificate.name
    if given.design is None:
        if given.mass_properties is not None:
            return refuse("--mass-properties needs --design: masses belong to a machine", BAD_INPUT)
        if given.gravity_torque is not None:
            return refuse("--gravity-torque needs --design: it is taken off the torque of a machine", BAD_INPUT)
    try:
        design = None if given.design is None else load_design(given.design, given.catalogue)
        certificate = read_certificate(given.certificate)
        if given.tolerance is not None and certificate.tolerance < given.tolerance / MM_PER_M:
            held = certificate.tolerance * MM_PER_M
            raise CertificateError(
                f"it is about machines within {held:g} mm of the drawn one, not {given.tolerance:g} mm"
            )
        if design is not None and given.mass_properties is not None:
            _same_masses(certificate, design, given.mass_properties)
        if design is not None and given.gravity_torque is not None:
            _enough_reserve(certificate, design, given.gravity_torque)
        with ProgressLine() as line:
            replay = verify(
                certificate,
                design,
                progress=lambda n, share: line.show(f"proving again: {n} boxes, {share:.1%} of the cube"),
            )
    except (UnreadableError, DesignError, GravityError, MassError) as error:
        return refuse(str(error), BAD_INPUT)
    except CertificateError as error:
        text = str(error)
        reason = text if text.startswith(f"{name}: ") else f"{name}: {text}"
        if given.json:
            print(json.dumps({"certificate": str(given.certificate), "holds": False, "reason": reason}, indent=1))
        return refuse(f"{reason}; the certificate does not hold", NOT_MET)
    reason = _missing(certificate, replay)
    if design is not None:
        reason = reason or _gravity_not_compared(given, certificate, design) or _masses_not_compared(given, design)
    if given.json:
        print(json.dumps(_facts(given, certificate, replay, design, reason), indent=1))
    elif not reason:
        print(_summary(given, certificate, replay, design))
    return refuse(f"{name}: {reason}", NOT_MET) if reason else DONE


def _same_masses(certificate: Certificate, design: Design, path: Path) -> None:
    """Checks that gravity's share is that of the file."""
    from delta_cad.drive.masses import load_masses
    from delta_cad.mechanism.limits import EffectiveMass
    from optimizer.certify.certificate import CertificateError
    from optimizer.certify.gravity import allowance_of_masses

    if certificate.gravity != allowance_of_masses(path, design, certificate.tolerance):
        raise CertificateError(f"torque: gravity's share does not come from {path.name}")
    mass = certificate.limits.get(EffectiveMass)
    if mass is not None and mass.inertia != load_masses(path, design).handle_inertia:
        raise CertificateError(f"effective_mass: its masses do not come from {path.name}")


def _enough_reserve(certificate: Certificate, design: Design, reserve: float) -> None:
    """Checks that at least a torque given by hand is left for gravity."""
    from optimizer.certify.certificate import CertificateError
    from optimizer.certify.gravity import given_allowance

    given_allowance(design, reserve)  # refuses what is no reserve
    wanted, share = reserve, certificate.gravity
    if share is None and wanted == 0.0:
        return
    if share is None:
        raise CertificateError(f"torque: nothing is left for gravity, not {wanted:.9g} N m")
    if share.reserve is None:
        raise CertificateError("torque: gravity's share comes from a mass file: compare it with that")
    if share.reserve < wanted:
        raise CertificateError(f"torque: only {share.reserve:.9g} N m are left for gravity, not {wanted:.9g} N m")


def _missing(certificate: Certificate, replay: Replay) -> str:
    """Explains why a certificate that replays does not prove its design; "" if it does."""
    from optimizer.certify.report import place

    parts = []
    for finding in certificate.findings:
        if finding.condition in replay.refuted and finding.point is not None:
            x, y, z = finding.point
            parts.append(
                f"{finding.condition} is refuted at {place((MM_PER_M * x, MM_PER_M * y, MM_PER_M * z))}, confirmed"
            )
        elif finding.condition in replay.undecided:
            parts.append(f"{finding.condition} is undecided")
    return "it does not prove the design: " + "; ".join(parts) if parts else ""


def _gravity_not_compared(given: argparse.Namespace, certificate: Certificate, design: Design) -> str:
    """Why a certificate's share of gravity is not enough for a design that states gravity; "" if it is.

    Whoever wrote a certificate may have written any share, and a digest that fits it: what counts is what the share was
    compared with, or that whoever asks takes its word.
    """
    compared = given.mass_properties is not None or given.gravity_torque is not None
    if compared or given.without_gravity or not any(design.requirements.gravity_m_s2):
        return ""
    x, y, z = design.requirements.gravity_m_s2
    share, states = certificate.gravity, f"{given.design.name} states requirements.gravity_m_s2 = [{x:g}, {y:g}, {z:g}]"
    if share is None or share.reserve == 0.0:
        return (
            f"it does not prove the design: {states}, and nothing of the torque is left for it; certify with "
            "--mass-properties (of a build) or --gravity-torque, or verify with --without-gravity"
        )
    if given.as_recorded:
        return ""
    left = "masses that gravity acts on" if share.reserve is None else f"{share.reserve:.4g} N m left for it"
    return (
        f"it does not prove the design: {states}, and the {left} were compared with nothing; give "
        "--mass-properties (of a build) or --gravity-torque, or --as-recorded to take its word"
    )


def _masses_not_compared(given: argparse.Namespace, design: Design) -> str:
    """Why the masses of a certificate are not enough for a design that limits the effective mass; "" if they are."""
    most = design.requirements.effective_mass_max_kg
    if most is None or given.mass_properties is not None or given.as_recorded:
        return ""
    return (
        f"it does not prove the design: {given.design.name} states requirements.effective_mass_max_kg = {most:g}, and "
        "the masses were compared with nothing; give --mass-properties (of a build), or --as-recorded to take its word"
    )


def _facts(
    given: argparse.Namespace, certificate: Certificate, replay: Replay, design: Design | None, reason: str
) -> dict[str, Any]:
    from optimizer.certify.file import certificate_to_dict

    share, content = certificate.gravity, certificate_to_dict(certificate)
    return {
        "certificate": str(given.certificate),
        "holds": not reason,
        "reason": reason or None,
        "design": certificate.design,
        "design_checked": given.design is not None,
        "masses_checked": given.mass_properties is not None,
        "gravity_torque_checked": given.gravity_torque is not None,
        "geometry": content["geometry"],
        "cube": content["cube"],
        "limits": content["limits"],
        "tolerance_mm": certificate.tolerance * MM_PER_M,
        "proved": list(replay.proved),
        "refuted": list(replay.refuted),
        "undecided": list(replay.undecided),
        "left_to_build": [] if design is None else _left_to_build(certificate, design),
        "gravity_counted_in": share is not None,
        "gravity_reserve_N_m": None if share is None else share.reserve,
        "mass_properties_sha256": None if share is None else share.sha256,
        "leaves": replay.leaves,
        "boxes": replay.boxes,
    }


def _left_to_build(certificate: Certificate, design: Design) -> list[str]:
    """Lists requirements of a design that no certificate covers: a build checks them."""
    proved = {field.name for limit in certificate.limits for field in limit.fields_} | LOADS
    return [name for name in design.requirements.model_dump(exclude_none=True) if name not in proved]


def _summary(given: argparse.Namespace, certificate: Certificate, replay: Replay, design: Design | None) -> str:
    from optimizer.certify.report import rounded

    about = ""
    if design is not None:
        left = f"; {', '.join(rest)} are the build's to check" if (rest := _left_to_build(certificate, design)) else ""
        about = f", and covers all that {given.design.name} asks of every position{left}"
    if certificate.tolerance > 0.0:
        within = certificate.tolerance * MM_PER_M
        about = f" and for every machine within {within:g} mm of the drawn lengths and offsets{about}"
    g, cube = certificate.geometry, certificate.cube
    L_A, L_B, R, r = (MM_PER_M * x for x in (g.upper_arm_length, g.forearm_length, g.base_radius, g.platform_radius))
    side, low = 2.0 * MM_PER_M * cube.half_side, MM_PER_M * cube.bottom_height
    return (
        f"{given.certificate.name} holds: {', '.join(replay.proved)} proved again at every point of the cube{about}; "
        f"{_gravity_sentence(given, certificate.gravity)}\n"
        f"{'; '.join(certificate.limits[name].words(rounded) for name in replay.proved)}\n"
        f"{certificate.design}: L_A {L_A:g}, L_B {L_B:g}, R {R:g}, r {r:g}, cube of {side:g} from {low:g} mm up\n"
        f"{replay.leaves} boxes of the certificate tile the cube, {replay.boxes} examined"
        f"{_mass_sentence(given, certificate)}"
    )


def _mass_sentence(given: argparse.Namespace, certificate: Certificate) -> str:
    """Describes the masses with which the effective mass is proved; forged ones with a new digest are proved, too."""
    from delta_cad.mechanism.limits import EffectiveMass

    mass = certificate.limits.get(EffectiveMass)
    if mass is None:
        return ""
    m = mass.inertia
    checked = "checked" if given.mass_properties is not None else "AS RECORDED, their file not given: --mass-properties"
    return (
        f"\nthe effective mass is that of {m.carried_mass:.4g} kg carried, {m.elbow_mass:.4g} kg at an elbow, "
        f"{m.cross_mass:.4g} kg between both and {m.joint_inertia:.4g} kg m^2 at a joint, {checked}"
    )


def _gravity_sentence(given: argparse.Namespace, share: GravityAllowance | None) -> str:
    """Says for what share of gravity it holds, and what that was compared with: of a design, what it asks for is."""
    nothing = "NOTHING GIVEN TO COMPARE THAT WITH: --gravity-torque or --mass-properties"
    if share is None:
        compared = "as asked" if given.gravity_torque == 0.0 or given.without_gravity else nothing
        return f"GRAVITY is NOT taken off the torque, {compared}"
    if share.masses is None:
        left = f"GRAVITY is taken off by hand, {share.reserve:g} N m of every joint's {share.torque:g} N m"
        if given.gravity_torque is None:
            return f"{left}, {nothing}"
        return f"{left}, at least the {given.gravity_torque:g} N m given"
    m, file = share.masses, share.sha256 or ""
    checked = "checked" if given.mass_properties is not None else "AS RECORDED, its file not given: --mass-properties"
    return (
        f"GRAVITY is counted in, {m.carried_mass:.4g} kg at the wrists and {m.arm_moment:.4g} kg m about the shoulder, "
        f"of the mass file of SHA-256 {file[:12]}, {checked}"
    )
