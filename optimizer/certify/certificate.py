"""Certificate of a design: what holds at every point of its cube, with the boxes that prove it, made and replayed.

`certify` runs the prover, `delta_cad.mechanism.proof`, which compiles. `verify` believes neither it nor the file: it
checks that the boxes tile the cube in exact integers, and proves each condition again over each box in another
arithmetic (`replay`), without the compiler.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design, design_hash
from delta_cad.dimensions.joint import limit_values
from delta_cad.mechanism import Cube, DeltaGeometry
from delta_cad.mechanism.limits import EffectiveMass, HandleInertia, Limits
from delta_cad.mechanism.proof.findings import Finding, Verdict
from delta_cad.mechanism.proof.prove import DEEPEST, Progress, half_of, prove
from optimizer.certify.gravity import GravityAllowance
from optimizer.certify.replay import breaks, replay
from optimizer.certify.tiling import Cell, TilingError, check_tiling, corners

# Relative difference between a figure told and the same computed here: by two machines, with some hundred roundings.
_SAME = 1e-9


class CertificateError(ValueError):
    """A certificate that is not one, or does not prove what it says; the message says what."""


class UnreadableError(CertificateError):
    """What was given is no certificate at all."""


@dataclass(frozen=True)
class Certificate:
    """The limits on every point of a cube, and the verdict on each.

    Attributes:
        design: Name of the design.
        design_hash: SHA-256 of the design file's content.
        geometry: The mechanism; its doubles, in metres, are what the proof is about.
        cube: The cube; likewise.
        limits: The conditions, room for gravity left by them.
        findings: One for each condition.
        leaves: (n, 6) boxes that cover the half y >= 0 of the cube, see `delta_cad.mechanism.proof`; empty where
            nothing is proved.
        boxes: Boxes that the prover examined; a file holds those that its leaves are made of.
        gravity: How gravity is counted in; None if it is not.
        tolerance: What is proved is proved for every machine whose lengths and offsets are within it, m, README (43).
    """

    design: str
    design_hash: str
    geometry: DeltaGeometry
    cube: Cube
    limits: Limits
    findings: tuple[Finding, ...]
    leaves: np.ndarray
    boxes: int
    gravity: GravityAllowance | None = None
    tolerance: float = 0.0

    @property
    def verdict(self) -> Verdict:
        """The verdict on all conditions: refuted if any is, else undecided if any is, else proved."""
        verdicts = {finding.verdict for finding in self.findings}
        if "refuted" in verdicts:
            return "refuted"
        return "undecided" if "undecided" in verdicts else "proved"


@dataclass(frozen=True)
class Replay:
    """A certificate that held.

    Attributes:
        proved: Conditions proved again over the whole cube.
        refuted: Conditions whose point was confirmed to break them.
        undecided: Conditions that the certificate leaves open.
        leaves: Boxes of the certificate.
        boxes: Boxes examined; more than the leaves where the second arithmetic is coarser.
    """

    proved: tuple[str, ...]
    refuted: tuple[str, ...]
    undecided: tuple[str, ...]
    leaves: int
    boxes: int


def values_of(
    design: Design, inertia: HandleInertia | None = None, gravity: GravityAllowance | None = None
) -> dict[str, Any]:
    """Gathers `limit_values` of a design, with what moves, where it is known, and how gravity is counted in."""
    return limit_values(design, {"inertia": inertia, "held_masses": None if gravity is None else gravity.masses})


def certify(
    design: Design,
    limits: Limits | None = None,
    *,
    gravity: GravityAllowance | None = None,
    tolerance: float = 0.0,
    max_boxes: int = 5_000_000,
    progress: Progress | None = None,
) -> Certificate:
    """Decides each condition for every point of the design's cube.

    Args:
        design: The design.
        limits: The limits, with room for gravity already left; None takes those of its requirements, less the room.
        gravity: How gravity is counted in; None leaves it out.
        tolerance: Of every length and offset of every chain, m.
        max_boxes: Boxes after which what is open is undecided.
        progress: As `prove` calls it.

    Raises:
        GravityError: Gravity takes all the torque.
        GeometryError: The tolerance is negative or too large.
    """
    geometry, cube = design.geometry, design.workspace
    conditions = limits_of(design, gravity) if limits is None else limits
    proof = prove(geometry, cube, conditions, tolerance=tolerance, max_boxes=max_boxes, progress=progress)
    complete = any(finding.verdict == "proved" for finding in proof.findings)
    return Certificate(
        design=design.name,
        design_hash=design_hash(design),
        geometry=geometry,
        cube=cube,
        limits=conditions,
        findings=proof.findings,
        leaves=proof.leaves if complete else proof.leaves[:0],
        boxes=proof.boxes,
        gravity=gravity,
        tolerance=tolerance,
    )


def limits_of(design: Design, gravity: GravityAllowance | None, inertia: HandleInertia | None = None) -> Limits:
    """Gathers the limits of a design's requirements, less the room for gravity, angles rounded to the strict side.

    Args:
        design: The design.
        gravity: How gravity is counted in; None leaves it out.
        inertia: What moves, where it is known.

    Returns:
        Reach, assembly mode and torque always; the others where they are stated.

    Raises:
        GravityError: Gravity takes all the torque.
        GeometryError: A number that the proof does not take, or one that needs the masses, which are not known.
    """
    limits = Limits.stated(values_of(design, inertia))
    return limits if gravity is None else gravity.limits(limits)


def verify(certificate: Certificate, design: Design | None = None, *, progress: Progress | None = None) -> Replay:
    """Checks a certificate without trusting it.

    Args:
        certificate: The certificate.
        design: The design it should be about; None checks it for itself alone.
        progress: Called with the boxes examined and the share of the leaves that is done.

    Raises:
        CertificateError: It is about another design, or asks less than the design does; it leaves less room for gravity
            than it says; its conditions are not those of its limits; its boxes do not tile the cube; a condition cannot
            be proved again over a box; or a point does not break the condition it should.
    """
    c = certificate
    fault = c.gravity.fault(c.limits) if c.gravity is not None else None
    if fault is not None:
        raise CertificateError(f"torque: {fault}")
    if design is not None:
        _same_design(c, design)
    names = tuple(finding.condition for finding in c.findings)
    if names != c.limits.names:
        raise CertificateError(f"its findings are {', '.join(names)}; its limits ask {', '.join(c.limits.names)}")
    for finding in c.findings:
        if finding.limit != c.limits[finding.condition].thresholds():
            raise CertificateError(f"{finding.condition}: the limit of its finding is not the one proved")
    sorted_ = {v: tuple(f.condition for f in c.findings if f.verdict == v) for v in ("proved", "refuted", "undecided")}
    for finding in c.findings:
        _check_figures(c, finding)
    boxes = _prove_again(c, sorted_["proved"], progress) if sorted_["proved"] else 0
    return Replay(sorted_["proved"], sorted_["refuted"], sorted_["undecided"], len(c.leaves), boxes)


def _same_design(c: Certificate, design: Design) -> None:
    if c.geometry != design.geometry or c.cube != design.workspace:
        raise CertificateError(f'it is about other dimensions than those of design "{design.name}"')
    if c.design != design.name:
        raise CertificateError(f'it is about a design called "{c.design}", not "{design.name}"')
    if c.design_hash != design_hash(design):
        own = design_hash(design)
        raise CertificateError(f"it is about the design of hash {c.design_hash[:12]}, not {own[:12]}")
    r, share = design.requirements, c.gravity
    if share is not None and (share.force, share.torque) != (r.force_N, r.joint_torque_N_m):
        raise CertificateError("torque: gravity is taken off another force or torque than the design's")
    masses, (x, y, z) = None if share is None else share.masses, r.gravity_m_s2
    if masses is not None and (masses.gravity_x, masses.gravity_y, masses.gravity_z) != (x, abs(y), z):
        raise CertificateError("torque: gravity is another than the design's gravity_m_s2")
    mass = c.limits.get(EffectiveMass)
    if mass is None and r.effective_mass_max_kg is not None:
        lax = EffectiveMass.name
    else:  # with the masses that the certificate is about; `verify` compares them with those of a build
        lax = c.limits.less_strict_than(limits_of(design, share, None if mass is None else mass.inertia))
    if lax is not None:
        raise CertificateError(f'{lax}: design "{design.name}" asks for more than the certificate is about')


def _check_figures(c: Certificate, finding: Finding) -> None:
    """Refuses figures that do not belong to a finding's verdict, and figures that are wrong."""
    name, verdict = finding.condition, finding.verdict
    own = {"proved": (), "refuted": ("point", "value"), "undecided": ("box",)}[verdict]
    for figure in ("point", "value", "box"):
        if figure not in own and getattr(finding, figure) is not None:
            raise CertificateError(f"{name}: it is {verdict}, but has a {figure}, which says nothing of it")
    if verdict == "refuted":
        _check_point(c, finding)
    if verdict == "undecided" and (finding.box is None or not _is_part(c.cube, finding.box)):
        raise CertificateError(f"{name}: it is undecided, but not in a box that halving the cube makes")


def _is_part(cube: Cube, box: tuple[tuple[float, float, float], tuple[float, float, float]]) -> bool:
    """Whether a box is one of the subdivision of the half y >= 0, to the rounding of its corners."""
    low, high = (np.array(corner) for corner in box)
    origin, edges = half_of(cube)
    if not (high > low).all():
        return False
    halvings = np.round(np.log2(edges / (high - low)))
    if (halvings < 0.0).any() or (halvings > DEEPEST).any():
        return False
    size = edges / 2.0**halvings
    at = np.round((low - origin) / size)
    inside = (at >= 0.0).all() and (at < 2.0**halvings).all()
    return bool(inside and (low == origin + at * size).all() and (high == origin + (at + 1.0) * size).all())


def _check_point(c: Certificate, finding: Finding) -> None:
    name, point = finding.condition, finding.point
    if point is None:
        raise CertificateError(f"{name}: it is refuted, but without a point")
    if not (np.array(point) >= c.cube.lower).all() or not (np.array(point) <= c.cube.upper).all():
        raise CertificateError(f"{name}: the point {_mm(point)} lies outside the cube")
    if not breaks(c.geometry, c.limits[name], np.array(point)):
        raise CertificateError(f"{name}: the point {_mm(point)} does not break it")
    value = c.limits[name].broken(c.geometry, np.array(point))
    reported = math.nan if finding.value is None else finding.value
    if (math.isfinite(reported) or math.isfinite(value)) and not math.isclose(reported, value, rel_tol=_SAME):
        raise CertificateError(f"{name}: the value at {_mm(point)} is {value:.9g}, not {reported:.9g}")


def _prove_again(c: Certificate, conditions: tuple[str, ...], progress: Progress | None) -> int:
    cells: list[Cell] = [(a, b, d, e, f, g) for a, b, d, e, f, g in c.leaves.tolist()]
    try:
        check_tiling(cells)
    except TilingError as error:
        raise CertificateError(str(error)) from None
    lower, upper = _boxes(c.cube, cells)
    again = [c.limits[name] for name in conditions]
    boxes, failed = replay(c.geometry, again, lower, upper, tolerance=c.tolerance, progress=progress)
    if failed is not None:
        where = f"{_mm(failed.lower)} to {_mm(failed.upper)}"
        raise CertificateError(f"{failed.condition}: it could not be proved again in the box {where}")
    return boxes


def _boxes(cube: Cube, cells: list[Cell]) -> tuple[np.ndarray, np.ndarray]:
    """Computes (n, 3) lower and upper corners in doubles, rounded outwards from the exact ones of the half y >= 0."""
    low, high = cube.lower.tolist(), cube.upper.tolist()
    bottom = [Fraction(low[0]), Fraction(0), Fraction(low[2])]
    top = [Fraction(x) for x in high]
    exact = [corners(cell, bottom, top) for cell in cells]
    below = [[math.nextafter(float(x), -math.inf) for x in pair[0]] for pair in exact]
    above = [[math.nextafter(float(x), math.inf) for x in pair[1]] for pair in exact]
    return np.array(below), np.array(above)


def _mm(p: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{x * MM_PER_M:.4f}" for x in p) + ") mm"
