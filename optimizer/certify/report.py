"""The report of `certify`: one row a figure with its limit, its proved bound, its extreme and the room between them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from typing import Any

import numpy as np

from delta_cad.common.units import G_PER_KG
from delta_cad.common.units import MM_PER_M as MM
from delta_cad.mechanism import reach_excess
from delta_cad.mechanism.limits import POSE_LIMITS, FigureOfMerit, PoseLimit, Reach, Torque
from delta_cad.mechanism.proof.findings import Finding
from optimizer.certify.bounds import ProvedBound
from optimizer.certify.certificate import Certificate
from optimizer.certify.tolerance import LargestTolerance, Need

_DIGITS = 6
_Point = tuple[float, float, float]


@dataclass(frozen=True)
class _Row:
    """One figure over the cube, in the unit that people read.

    Attributes:
        condition: The condition that it belongs to.
        figure: Name of the figure.
        of: The figure; its unit is that of all numbers.
        verdict: Verdict on the condition; "not asked" if there is no limit.
        limit: What is allowed; None if nothing is.
        proved: No point of the cube is beyond this; None where nothing was proved.
        attained: The extreme found; None where a chain is open, or it is infinite.
        at_mm: Position of that extreme.
        point_mm: Point that breaks the limit for certain.
        value: The figure there.
        box_mm: Box in which the condition was not decided.
    """

    condition: str
    figure: str
    of: FigureOfMerit
    verdict: str
    limit: float | None
    proved: float | None
    attained: float | None
    at_mm: _Point | None
    point_mm: _Point | None
    value: float | None
    box_mm: tuple[_Point, _Point] | None

    @property
    def worst(self) -> tuple[float, _Point] | None:
        """The worse of the extreme found and the value at the point that breaks the limit."""
        known = [
            (value, at)
            for value, at in ((self.attained, self.at_mm), (self.value, self.point_mm))
            if value is not None and at is not None
        ]
        return (max if self.of.upper else min)(known, default=None, key=lambda pair: pair[0])

    @property
    def room(self) -> float | None:
        """How far the worst is within the limit; negative beyond it."""
        if self.limit is None or self.worst is None:
            return None
        room = self.limit - self.worst[0]
        return room if self.of.upper else -room

    def record(self) -> dict[str, Any]:
        """Gathers the row as plain data for JSON."""
        limit_is = "at most" if self.of.upper else "at least"
        numbers = {name: value for name, value in vars(self).items() if name != "of"}
        named = {"condition": self.condition, "figure": self.figure, "unit": self.of.unit}
        return named | numbers | {"limit_is": limit_is, "room": self.room}


def report_rows(c: Certificate, proved_bounds: tuple[ProvedBound, ...]) -> list[_Row]:
    """Makes the rows of a certificate.

    Args:
        c: The certificate, about what the requirements ask.
        proved_bounds: The bounds proved beside it, for the force without gravity's share; none where a chain is open.

    Returns:
        One for each figure, those without a limit too, unless nothing is known of them.
    """
    findings = {f.condition: f for f in c.findings}
    known = {one.figure.name: one for one in proved_bounds}
    rows = []
    for kind in POSE_LIMITS:
        limit, finding = c.limits.get(kind), findings.get(kind.name)
        for figure in kind.figures:
            bound = known.get(figure.name)
            if limit is not None or bound is not None or not kind.needs:
                rows.append(_row(c, kind, figure, limit, finding, bound))
    return rows


def _row(
    c: Certificate,
    kind: type[PoseLimit],
    figure: FigureOfMerit,
    limit: PoseLimit | None,
    finding: Finding | None,
    bound: ProvedBound | None,
) -> _Row:
    name, scale, added = figure.words, figure.scale, 0.0
    allowed = None if limit is None else limit.bound(figure) * scale
    if kind is Torque:
        name = "torque, no gravity"
        if c.gravity is not None and c.gravity.reserve is not None:  # against the whole torque
            name, allowed, added = "torque with gravity by hand", c.gravity.torque, c.gravity.reserve
    proved = None if bound is None or bound.proved is None else bound.proved * scale + added
    verdict = "not asked" if finding is None or allowed is None else finding.verdict
    if verdict == "refuted" and proved is not None and allowed is not None:  # of a pair of figures, the one in order
        verdict = "proved" if (proved <= allowed if figure.upper else proved >= allowed) else verdict
    if verdict == "proved" and proved is not None and allowed is not None:  # the limit itself is a proved bound
        proved = figure.stricter(proved, allowed)
    return _Row(
        kind.name,
        name,
        figure,
        verdict,
        allowed,
        proved,
        None if bound is None else bound.attained * scale + added,
        None if bound is None else _mm(bound.point),
        None if finding is None or finding.point is None else _mm(finding.point),
        _value(c, finding, limit, figure, scale, added),
        None if finding is None or finding.box is None else (_mm(finding.box[0]), _mm(finding.box[1])),
    )


def _value(
    c: Certificate,
    finding: Finding | None,
    limit: PoseLimit | None,
    figure: FigureOfMerit,
    scale: float,
    added: float,
) -> float | None:
    """Computes the figure at the point that breaks the limit; of a pair of figures, the one that is broken."""
    if finding is None or finding.point is None or limit is None:
        return None
    if isinstance(limit, Reach) and (finding.value is None or not math.isfinite(finding.value)):
        return -float(np.max(reach_excess(c.geometry, np.array(finding.point)))) * MM
    if finding.value is None or not math.isfinite(finding.value):
        return None
    edge = limit.bound(figure)
    if len(limit.figures) > 1 and (finding.value <= edge if figure.upper else finding.value >= edge):
        return None
    return finding.value * (1.0 if isinstance(limit, Torque) else scale) + added  # there for the raised force


def _mm(p: _Point) -> _Point:
    return (p[0] * MM, p[1] * MM, p[2] * MM)


def rounded(value: float, upwards: bool) -> str:
    """Writes a bound in `_DIGITS` digits, rounded to the side on which it still is true."""
    context = Context(prec=_DIGITS, rounding=ROUND_CEILING if upwards else ROUND_FLOOR)
    return f"{float(context.create_decimal(Decimal(repr(float(value))))):.{_DIGITS}g}"


def place(p: _Point) -> str:
    """Writes a position in mm."""
    return "(" + ", ".join(f"{x + 0.0:.3f}".replace("-0.000", "0.000") for x in p) + ") mm"


def shortfall(row: _Row) -> str:
    """Describes by how much and where a condition fails that was not proved."""
    unit = f" {row.of.unit}" if row.of.unit else ""
    if row.verdict == "undecided":
        where = "" if row.box_mm is None else f" in the box {place(row.box_mm[0])} to {place(row.box_mm[1])}"
        return f"{row.condition} is undecided{where}"
    if row.worst is None or row.limit is None:
        where = "" if row.point_mm is None else f" at {place(row.point_mm)}"
        return f"{row.condition} is refuted{where}"
    value, at = row.worst
    if row.condition == "reach" and value < 0.0:
        return f"reach is refuted: a chain is {-value:.{_DIGITS}g} mm out of reach at {place(at)}"
    beyond, side = abs(row.room or 0.0), "above" if row.of.upper else "below"
    return (
        f"{row.condition} is refuted: {row.figure} is {value:.{_DIGITS}g}{unit} at {place(at)}, "
        f"{beyond:.3g}{unit} {side} the limit of {row.limit:g}{unit}"
    )


def broken(rows: list[_Row]) -> list[_Row]:
    """Selects the rows that are refuted or undecided."""
    return [row for row in rows if row.verdict in ("refuted", "undecided")]


def table(rows: list[_Row]) -> str:
    """Lays the rows out as aligned text."""
    head = ("figure", "verdict", "limit", "proved", "extreme found", "at x, y, z", "room")
    lines = [head, *(_cells(row) for row in rows)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(head))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines
    )


def _cells(row: _Row) -> tuple[str, ...]:
    unit = f" {row.of.unit}" if row.of.unit else ""
    limit = "" if row.limit is None else f"{row.of.sense} {row.limit:.{_DIGITS}g}{unit}"
    proved = "" if row.proved is None else f"{row.of.sense} {rounded(row.proved, row.of.upper)}{unit}"
    worst = row.worst
    extreme = "" if worst is None else f"{worst[0]:.{_DIGITS}g}{unit}"
    at = "" if worst is None else place(worst[1])
    room = "" if row.room is None else f"{row.room:.3g}{unit}"
    return row.figure, row.verdict, limit, proved, extreme, at, room


def gravity_sentence(c: Certificate) -> str:
    """Describes how gravity is counted in."""
    share = c.gravity
    if share is None:
        return (
            "gravity is NOT taken off the torque: give --mass-properties (of a build) or --gravity-torque; `verify` "
            "exits 1 for it unless it is told --without-gravity"
        )
    if share.masses is None:
        return f"gravity is taken off: {share.reserve:g} N m of every joint's {share.torque:g} N m, as given by hand"
    m = share.masses
    return (
        f"gravity is counted in: {G_PER_KG * m.carried_mass:.4g} g at the wrists, {m.arm_moment:.4g} kg m of every "
        f"chain's arm and rods about its shoulder, and {G_PER_KG * m.loose_mass:.3g} g and {m.loose_moment:.3g} kg m "
        "in whatever direction is the worst"
    )


def mm(length: float) -> str:
    """Writes a length given in metres in mm."""
    return f"{length * MM:.{_DIGITS}g}"


def tolerance_sentence(c: Certificate, largest: LargestTolerance) -> str:
    """Describes the tolerance within which the limits are proved, the first to break, and what a larger one needs."""
    parts = []
    if c.tolerance > 0.0:
        parts.append(f"within {mm(c.tolerance)} mm of every length and offset the limits are {_proved(c)}")
    if largest.late == "largest":
        known = max(largest.tolerance, c.tolerance) if c.verdict == "proved" else largest.tolerance
        so_far = f"{mm(known)} mm is" if known > 0.0 else "none is"
        parts.append(f"{so_far} proved so far: the time was over before the largest was found: raise --proof-minutes")
    elif largest.tolerance == 0.0:
        parts.append(f"no tolerance is proved: {' and '.join(largest.first)} leave no room for any")
    elif largest.first:
        parts.append(f"the largest tolerance proved is {mm(largest.tolerance)} mm, {' and '.join(largest.first)} first")
    else:
        parts.append(f"{mm(largest.tolerance)} mm, the largest tolerance that can be asked, is proved")
    if largest.needs:
        needs = ", ".join(_need(need) for need in largest.needs)
        parts.append(f"{mm(largest.requested)} mm would need {needs}")
    if largest.late == "needs":
        late = "the time was over before it was found"
        parts.append(f"{late} what {mm(largest.requested)} mm would need: raise --proof-minutes")
    return "; ".join(parts)


def _proved(c: Certificate) -> str:
    open_ = [f.condition for f in c.findings if f.verdict != "proved"]
    return f"not all proved ({', '.join(open_)})" if open_ else "all proved"


def _need(need: Need) -> str:
    f = need.figure
    if need.bound is None:
        return f"another design for its {need.condition}"
    unit = f" {f.unit}" if f.unit else ""
    return f"{f.words} {f.sense} {rounded(need.bound * f.scale, f.upper)}{unit}"


def tolerance_facts(c: Certificate, largest: LargestTolerance | None) -> dict[str, Any] | None:
    """Gathers the same as plain data for JSON; None where no tolerance was asked."""
    if largest is None:
        return None
    return {
        "certified_mm": c.tolerance * MM,
        "proved": c.verdict == "proved",
        "largest_mm": largest.tolerance * MM,
        "time_was_over_for": largest.late or None,
        "first_to_break": list(largest.first),
        "needs_for_mm": largest.requested * MM,
        "needs": [
            {
                "condition": need.condition,
                "figure": need.figure.words,
                "unit": need.figure.unit,
                "limit": None if need.bound is None else need.bound * need.figure.scale,
            }
            for need in largest.needs
        ],
    }


def facts(c: Certificate, rows: list[_Row]) -> dict[str, Any]:
    """Gathers the report as plain data for JSON."""
    share = c.gravity
    masses = None if share is None else share.masses
    source = None if share is None else "given" if masses is None else "mass properties"
    return {
        "design": c.design,
        "design_hash": c.design_hash,
        "verdict": c.verdict,
        "conditions": [row.record() for row in rows],
        "gravity": {
            "counted_in": share is not None,
            "source": source,
            "reserve_N_m": None if share is None else share.reserve,
            "carried_mass_kg": None if masses is None else masses.carried_mass,
            "arm_moment_kg_m": None if masses is None else masses.arm_moment,
            "mass_properties_sha256": None if share is None else share.sha256,
        },
        "boxes": c.boxes,
        "leaves": len(c.leaves),
    }
