"""`verify`: a certificate replayed in another arithmetic, without trust in the file or in the prover."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.console import BAD_INPUT, DONE, NOT_MET, Line, refuse

if TYPE_CHECKING:
    from delta_cad.design import Design
    from optimizer.certificate import Certificate, Replay

NAME = "verify"
TEXT = "independent replay of a certificate: holds, or what is wrong with it"


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    command.add_argument("certificate", type=Path, metavar="CERT", help="certificate of `certify`")
    command.add_argument(
        "--design", type=Path, metavar="FILE", help="design that it should be about, and be enough for"
    )
    command.add_argument(
        "--mass-properties",
        type=Path,
        metavar="FILE",
        help="file that gravity's share should come from; needs --design",
    )
    command.add_argument("--json", action="store_true", help="the same facts as JSON on stdout")


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.design import DesignError, load_design
    from optimizer.certificate import CertificateError, UnreadableError, verify
    from optimizer.certificate_file import read_certificate
    from optimizer.certificate_gravity import GravityError

    name = given.certificate.name
    if given.mass_properties is not None and given.design is None:
        return refuse("--mass-properties needs --design: masses belong to a machine", BAD_INPUT)
    certificate = None
    try:
        design = None if given.design is None else load_design(given.design)
        certificate = read_certificate(given.certificate)
        if design is not None and given.mass_properties is not None:
            _same_masses(certificate, design, given.mass_properties)
        with Line() as line:
            replay = verify(
                certificate,
                design,
                progress=lambda n, share: line.show(f"proving again: {n} boxes, {share:.1%} of the cube"),
            )
    except (UnreadableError, DesignError, GravityError) as error:
        return refuse(str(error), BAD_INPUT)
    except CertificateError as error:
        text = str(error)
        reason = text if text.startswith(f"{name}: ") else f"{name}: {text}"
        if given.json:
            print(json.dumps({"certificate": str(given.certificate), "holds": False, "reason": reason}, indent=1))
        return refuse(f"{reason}; the certificate does not hold", NOT_MET)
    reason = _missing(certificate, replay)
    if given.json:
        print(json.dumps(_facts(given, certificate, replay, reason), indent=1))
    elif not reason:
        print(_summary(given, certificate, replay))
    return refuse(f"{name}: {reason}", NOT_MET) if reason else DONE


def _same_masses(certificate: Certificate, design: Design, path: Path) -> None:
    """Holds that gravity's share is that of the file."""
    from optimizer.certificate import CertificateError
    from optimizer.certificate_gravity import read_masses

    recorded = None if certificate.gravity is None else certificate.gravity.masses
    if recorded != read_masses(path, design):
        raise CertificateError(f"torque: gravity's share does not come from {path.name}")


def _missing(certificate: Certificate, replay: Replay) -> str:
    """Why a certificate that replays is no proof of its design; "" if it is."""
    from optimizer.certificate_report import place

    parts = []
    for finding in certificate.findings:
        if finding.condition in replay.refuted and finding.point is not None:
            x, y, z = finding.point
            parts.append(f"{finding.condition} is refuted at {place((1e3 * x, 1e3 * y, 1e3 * z))}, confirmed")
        elif finding.condition in replay.undecided:
            parts.append(f"{finding.condition} is undecided")
    return "it does not prove the design: " + "; ".join(parts) if parts else ""


def _facts(given: argparse.Namespace, certificate: Certificate, replay: Replay, reason: str) -> dict[str, Any]:
    from optimizer.certificate_file import certificate_to_dict

    share, told = certificate.gravity, certificate_to_dict(certificate)
    return {
        "certificate": str(given.certificate),
        "holds": not reason,
        "reason": reason or None,
        "design": certificate.design,
        "design_checked": given.design is not None,
        "masses_checked": given.mass_properties is not None,
        "geometry": told["geometry"],
        "cube": told["cube"],
        "limits": told["limits"],
        "proved": list(replay.proved),
        "refuted": list(replay.refuted),
        "undecided": list(replay.undecided),
        "gravity_taken_off": share is not None,
        "gravity_weight_N": None if share is None else share.weight,
        "gravity_reserve_N_m": None if share is None else share.reserve,
        "leaves": replay.leaves,
        "boxes": replay.boxes,
    }


def _summary(given: argparse.Namespace, certificate: Certificate, replay: Replay) -> str:
    from optimizer.certificate_report import limit_words

    about = "" if given.design is None else f", and covers all that {given.design.name} asks"
    if certificate.gravity is None:
        gravity = "gravity is NOT taken off the torque"
    elif certificate.gravity.masses is None:
        gravity = f"gravity is taken off by hand, {certificate.gravity.reserve:g} N m"
    else:
        checked = "checked" if given.mass_properties is not None else "as recorded, their file not given"
        gravity = f"gravity is taken off, {certificate.gravity.masses.carried_mass:.4g} kg at the wrists, {checked}"
    g, cube = certificate.geometry, certificate.cube
    L_A, L_B, R, r = (1e3 * x for x in (g.upper_arm_length, g.forearm_length, g.base_radius, g.platform_radius))
    side, low = 2e3 * cube.half_side, 1e3 * cube.bottom_height
    return (
        f"{given.certificate.name} holds: {', '.join(replay.proved)} proved again at every point of the cube{about}\n"
        f"{'; '.join(limit_words(certificate.limits, name) for name in replay.proved)}\n"
        f"{certificate.design}: L_A {L_A:g}, L_B {L_B:g}, R {R:g}, r {r:g}, cube of {side:g} from {low:g} mm up\n"
        f"{replay.leaves} boxes of the certificate tile the cube, {replay.boxes} examined; {gravity}"
    )
