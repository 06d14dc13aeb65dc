"""The certificate as a JSON file, `delta-certificate/1`: metres, radians, doubles to the last bit."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from delta_cad.common.files import write_whole
from delta_cad.common.reading import ReadError, read_json
from delta_cad.common.refusal import LONGEST, short
from delta_cad.design import NAME_PATTERN
from delta_cad.mechanism import Cube, DeltaGeometry, GeometryError, MechanismError
from delta_cad.mechanism.geometry import THREE_FOLD, require_tolerance
from delta_cad.mechanism.limits import POSE_LIMITS, HoldingTorque, Limits
from delta_cad.mechanism.proof.findings import Finding, Verdict
from optimizer.certify.certificate import Certificate, CertificateError, UnreadableError
from optimizer.certify.gravity import GravityAllowance

_SCHEMA = "delta-certificate/1"
_STATEMENT = (
    "For every point (x, y, z) with {place} and z in [bottom_height, top_height] each "
    "condition with the verdict proved holds, with the lengths and limits below taken as exact numbers. A leaf "
    "[kx, ix, ky, iy, kz, iz] is the box [i, i + 1] / 2^k of each edge of the half y >= 0; the other half is its "
    "mirror image. Where gravity has a mass file, holding_torque is about force and gravity together, which acts on "
    "the held masses; where it has a reserve, that was given by hand and is taken off the torque."
)
_ON_AXIS = "x and y in [-half_side, half_side]"
_OFF_AXIS = (
    "x in [centre_x - half_side, centre_x + half_side], both ends rounded to doubles, y in [-half_side, half_side]"
)
# Added to the statement where chains or cube do not stand as in a three-fold symmetric machine.
_PLACED = (
    " What is left out of side_shift, side_cosine and centre_x is 0, -1/2 and 0. Chain 0 stands on the x axis, "
    "base_radius out; chains 1 and 2 stand base_radius plus side_shift out, at the azimuth whose cosine is side_cosine "
    "and at its mirror image."
)
# Added to the statement where there is a tolerance.
_WITHIN = (
    " All of this is for every machine whose lengths and offsets lie within tolerance_m of the drawn ones: of each "
    "chain by itself L_A, L_B, R, r, and where shoulder and wrist sit along the shoulder axis and along z. What is "
    "refuted is refuted of the drawn machine."
)
# A replay takes some 0.2 ms a leaf: a minute for these, which are 50 times those of the committed design.
MOST_LEAVES = 250_000
_Number = Annotated[float, Field(strict=True)]  # neither text nor true
_Point = tuple[_Number, _Number, _Number]
_Sha256 = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
_Index = Annotated[int, Field(ge=0, lt=2**60, strict=True)]  # as fine as `check_tiling` looks; fits 64 bits


class _FileSection(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class _Geometry(_FileSection):
    base_radius: _Number = Field(alias="base_radius_m")
    platform_radius: _Number = Field(alias="platform_radius_m")
    upper_arm_length: _Number = Field(alias="upper_arm_length_m")
    forearm_length: _Number = Field(alias="forearm_length_m")
    side_shift: _Number = Field(default=0.0, alias="side_shift_m")
    side_cosine: _Number = Field(default=THREE_FOLD)


class _Cube(_FileSection):
    bottom_height: _Number = Field(alias="bottom_height_m")
    half_side: _Number = Field(alias="half_side_m")
    centre_x: _Number = Field(default=0.0, alias="centre_x_m")
    top_height: _Number = Field(alias="top_height_m")


class _Gravity(_FileSection):
    force: _Number = Field(alias="force_N")
    torque: _Number = Field(alias="joint_torque_N_m")
    reserve: _Number | None = Field(alias="reserve_N_m")
    sha256: _Sha256 | None = Field(alias="mass_file_sha256")


class _Finding(_FileSection):
    condition: str
    verdict: Verdict
    limit: _Number | tuple[_Number, ...]
    point_m: _Point | None = None
    value: _Number | None = None
    box_m: tuple[_Point, _Point] | None = None


class _File(_FileSection):
    schema_id: Literal["delta-certificate/1"] = Field(alias="schema")
    statement: str
    verdict: Verdict
    design: str = Field(pattern=NAME_PATTERN)
    design_hash: _Sha256
    geometry: _Geometry
    cube: _Cube
    limits: dict[str, Any]
    tolerance_m: Annotated[float, Field(strict=True, gt=0.0)] | None = None
    gravity: _Gravity | None
    findings: list[_Finding] = Field(max_length=len(POSE_LIMITS))
    boxes: int = Field(ge=0, strict=True)
    leaves: list[tuple[_Index, _Index, _Index, _Index, _Index, _Index]] = Field(max_length=MOST_LEAVES)
    digest: _Sha256


def certificate_to_dict(certificate: Certificate) -> dict[str, Any]:
    """Gathers the certificate as plain data, with the digest of everything else."""
    cube, share = certificate.cube, certificate.gravity
    findings = []
    for f in certificate.findings:
        known = {"condition": f.condition, "verdict": f.verdict, "limit": f.limit, "point_m": f.point, "box_m": f.box}
        known["value"] = f.value if f.value is not None and math.isfinite(f.value) else None  # an open chain has none
        findings.append({key: value for key, value in known.items() if value is not None})
    data = {
        "schema": _SCHEMA,
        "statement": _statement(certificate),
        "verdict": certificate.verdict,
        "design": certificate.design,
        "design_hash": certificate.design_hash,
        "geometry": _named(_Geometry, certificate.geometry),
        "cube": _named(_Cube, cube, top_height=float(cube.upper[2])),
        "limits": certificate.limits.record(),
        "gravity": None if share is None else _named(_Gravity, share),
        "findings": findings,
        "boxes": _boxes_of(len(certificate.leaves)),
        "leaves": certificate.leaves.tolist(),
    }
    if certificate.tolerance > 0.0:
        data["tolerance_m"] = certificate.tolerance
    return data | {"digest": _digest(data)}


def _statement(c: Certificate) -> str:
    """Gives the words for what a certificate says."""
    placed = not c.geometry.three_fold or c.cube.centre_x != 0.0
    said = _STATEMENT.format(place=_OFF_AXIS if placed else _ON_AXIS)
    return said + (_PLACED if placed else "") + (_WITHIN if c.tolerance > 0.0 else "")


def _boxes_of(leaves: int) -> int:
    """Counts the boxes that halving makes on the way to some leaves: those and each whole that was halved."""
    return max(2 * leaves - 1, 0)


def _named(kind: type[_FileSection], record: object, **others: float) -> dict[str, Any]:
    """Gives the numbers of a record under the names that they have in the file, without those left as they are."""
    values = {name: others[name] if name in others else getattr(record, name) for name in kind.model_fields}
    return {
        field.alias or name: values[name] for name, field in kind.model_fields.items() if values[name] != field.default
    }


def _digest(data: dict[str, Any]) -> str:
    """Computes the SHA-256 of the canonical JSON of all but the digest itself."""
    rest = {key: value for key, value in data.items() if key != "digest"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def certificate_from_dict(data: object, file: str = "certificate") -> Certificate:
    """Makes a certificate from plain data; it still has to be verified.

    Raises:
        UnreadableError: A field is missing, unknown or of the wrong kind, or no mechanism or limit can have its value.
        CertificateError: The digest is not that of the content, the statement is not the schema's, or verdict, top
            height and count of boxes do not follow from the rest.
    """
    try:
        read = _File.model_validate(data)
        limits = _limits(read.limits)
        content = data if isinstance(data, dict) else {}
        if _digest(content) != read.digest:
            raise CertificateError(f"{file}: its content was changed: the digest is not {read.digest[:12]}")
        certificate = _certificate(read, limits)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        where = ".".join(_key(part) for part in first["loc"]) or "the file"
        raise UnreadableError(f"{file}: {where}: {first['msg']}") from None
    except MechanismError as error:
        raise UnreadableError(f"{file}: {error}") from None
    if read.statement != _statement(certificate):
        raise CertificateError(
            f"{file}: statement is not what its numbers prove; it must be the one that {_SCHEMA} has"
        )
    if certificate.verdict != read.verdict:
        raise CertificateError(f"{file}: verdict is {read.verdict}; its findings make it {certificate.verdict}")
    if float(certificate.cube.upper[2]) != read.cube.top_height:
        raise CertificateError(f"{file}: top_height_m is not bottom_height_m plus twice half_side_m")
    if read.boxes != _boxes_of(len(read.leaves)):
        made = _boxes_of(len(read.leaves))
        raise CertificateError(
            f"{file}: boxes is {short(read.boxes)}; its {len(read.leaves)} leaves are made of {made}"
        )
    return certificate


def _key(part: str | int) -> str:
    """A key of a file, or a name in it, for a message: quoted and escaped if it is not plain, and not without end."""
    return str(part) if isinstance(part, int) else part[:LONGEST] if part.isidentifier() else ascii(part[:LONGEST])


def _limits(data: dict[str, Any]) -> Limits:
    """Reads the limits; every key must be a known one."""
    known = Limits.keys()
    for key in data:
        if key not in known:
            raise GeometryError(f"limits.{_key(key)}: unknown key; known: {', '.join(known)}")
    try:
        return Limits.from_record(data)
    except GeometryError as error:
        raise GeometryError(f"limits: {error}") from None


def _certificate(read: _File, limits: Limits) -> Certificate:
    share, cube, tolerance = read.gravity, read.cube, read.tolerance_m or 0.0
    held = limits.get(HoldingTorque)
    if share is not None and (share.reserve is None) is not (share.sha256 is not None and held is not None):
        raise GeometryError("gravity: must have either reserve_N_m or mass_file_sha256 and the limit holding_torque")
    geometry = DeltaGeometry(**dict(read.geometry))
    require_tolerance(geometry, tolerance)
    order = {limit.name: n for n, limit in enumerate(POSE_LIMITS)}
    unknown = [f.condition for f in read.findings if f.condition not in order]
    if unknown:
        raise GeometryError(f"findings: condition {_key(unknown[0])} is none of {', '.join(order)}")
    return Certificate(
        design=read.design,
        design_hash=read.design_hash,
        geometry=geometry,
        cube=Cube(cube.bottom_height, cube.half_side, cube.centre_x),
        limits=limits,
        findings=tuple(
            Finding(f.condition, f.verdict, f.limit, f.point_m, f.value, f.box_m)
            for f in sorted(read.findings, key=lambda f: order[f.condition])
        ),
        leaves=np.array(read.leaves, dtype=np.int64).reshape(-1, 6),
        boxes=read.boxes,
        gravity=None
        if share is None
        else GravityAllowance(**dict(share), masses=held.masses if held and share.sha256 else None),
        tolerance=tolerance,
    )


def write_certificate(certificate: Certificate, path: str | Path) -> None:
    """Writes the file whole or not at all.

    Args:
        certificate: The certificate.
        path: Where to; replaced if it is there.

    Raises:
        CertificateError: It has more leaves than anybody would replay.
    """
    path = Path(path)
    write_whole(path, certificate_text(certificate, path.name))


def certificate_text(certificate: Certificate, file: str) -> str:
    """Gives the content of a certificate's file, of that name; raises as `write_certificate`."""
    if len(certificate.leaves) > MOST_LEAVES:
        raise CertificateError(
            f"{file}: the proof takes {len(certificate.leaves)} boxes; a certificate holds at most {MOST_LEAVES}: "
            "leave a little more room in the limits that have the least"
        )
    data = certificate_to_dict(certificate)
    leaves = data.pop("leaves")
    text = json.dumps(data, indent=1, allow_nan=False)
    lines = ",\n".join("  " + json.dumps(leaf, separators=(",", ":")) for leaf in leaves)
    return text[:-2] + ',\n "leaves": [\n' + lines + "\n ]\n}\n"


def read_certificate(path: str | Path) -> Certificate:
    """Reads a certificate; it still has to be verified.

    Raises:
        UnreadableError: It cannot be read, `parse_json` refuses it, or it has not the fields of a certificate.
        CertificateError: `certificate_from_dict` finds that it was changed.
    """
    path = Path(path)
    try:
        data = read_json(path)
    except ReadError as error:
        raise UnreadableError(str(error)) from None
    return certificate_from_dict(data, path.name)
