"""Tables of the page: what is asked beside what was reached, the feel, the drive, what binds, every check."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from delta_cad.checks.registry import CHECKS
from delta_cad.checks.report import CheckResult, closeness, grouped
from delta_cad.common.units import G_PER_KG
from delta_cad.drive import drive_torque
from delta_cad.report.fields import Field
from delta_cad.report.subject import Subject

_KINDS = {check.name: check.label for check in CHECKS if check.family}
"""First word of a check's name -> what it is about."""
REQUIREMENTS = {
    "reach": "Reach: distance to a stretched or folded arm",
    "envelope width": "Swept outline, width",
    "envelope depth": "Swept outline, depth",
    "height": "Height, knob at the cube's top",
    "clearance": "Clearance of moving bodies",
    "torque with gravity": "Joint torque, force and weight together",
    "drive torque": "Drive torque, continuous",
    "drive peak torque": "Drive torque, peak",
    "kappa": "Conditioning, worst in the cube",
    "couple index": "Rotational stiffness index: resistance of the platform to turning",
    "effective mass": "Effective mass, worst in the cube",
    "friction": "Friction at the handle, worst in the cube",
    "position step": "Position step, worst in the cube",
    "structure stiffness at the knob": "Stiffness at the knob, worst in the cube",
    "lean": "Lean of the rods",
    "shoulder min": "Shoulder, lowest",
    "shoulder max": "Shoulder, highest",
    "cable bend ratio": "Drum to cable diameter",
}
"""Checks that hold a design's requirements, by name, as a customer reads them."""
_BINDING = 8  # checks that are told to be closest to their limit
CLOSE = 0.5  # room to the limit, as a share of it, above which none is told to be close
_FIGURES = 4  # significant digits
LEAST, MOST = 1e-6, 1e9  # between them a number is told without a power of ten


@dataclass(frozen=True)
class _Line:
    """One line of a table of checks, as text.

    Attributes:
        words: What was checked.
        value: The figure with its unit, "" for none.
        limit: What it is held against, with its sense.
        margin: Room to the limit, or what is missing, with its unit and as a share of the limit.
        passed: Whether it holds; None where nothing is asked.
        where: The parts that decide.
        pose_mm: (3,) handle position that decides; None for none.
        detail: How it was found.
    """

    words: str
    value: str
    limit: str
    margin: str
    passed: bool | None
    where: str = ""
    pose_mm: tuple[float, float, float] | None = None
    detail: str = ""


def with_unit(value: float | None, unit: str = "", digits: int = _FIGURES) -> str:
    """Gives a number with its unit; "" for None."""
    if value is None:
        return ""
    return f"{_plain(value, digits)} {unit.replace('^2', '²').replace('^3', '³')}".strip()


def _plain(value: float, digits: int) -> str:
    """A number to so many significant digits; a power of ten only where it saves more than six places."""
    text = f"{value:.{digits}g}"
    if "e" not in text or not LEAST <= abs(value) < MOST:
        return text
    places = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{float(text):.{places}f}".rstrip("0").rstrip(".") if places else f"{float(text):.0f}"


def line(result: CheckResult, words: str = "") -> _Line:
    """Gives the result of a check as text; the sense of its limit follows from value and verdict."""
    value, limit, unit = result.value, result.limit, result.unit
    sense, margin = "", ""
    if value is not None and limit is not None:
        sense = "=" if value == limit else "≤" if (value < limit) == result.passed else "≥"
        room = abs(value - limit)
        share = f" ({with_unit(100.0 * room / abs(limit), '%', 3)})" if limit else ""
        margin = f"{'+' if result.passed else '−'}{with_unit(room, unit, 3)}{share}" if room else ""
    demand = value is None or limit is not None or not result.passed
    where, pose = " / ".join(result.worst_pair or ()), result.worst_pose_mm
    limit_reported = f"{sense} {with_unit(limit, unit)}" if limit is not None else ""
    passed = result.passed if demand else None
    return _Line(
        words or result.name, with_unit(value, unit), limit_reported, margin, passed, where, pose, result.detail
    )


def requirements(results: Sequence[CheckResult]) -> list[_Line]:
    """Lists what is asked of the machine, in the order of `REQUIREMENTS`; what is not asked is left out."""
    found = {result.name: result for result in results}
    return [line(found[name], words) for name, words in REQUIREMENTS.items() if name in found]


def binding(results: Sequence[CheckResult]) -> list[_Line]:
    """Lists the checks that are closest to their limit as a share of it, one of a kind, those far from it left out."""
    able = [r for r in results if r.passed and r.value is not None and r.limit and r.value != r.limit]
    close = [(min(group, key=_room), name) for name, group in grouped(able).items()]
    close = sorted((one for one in close if _room(one[0]) < CLOSE), key=lambda one: _room(one[0]))
    return [line(result, plain(name)) for result, name in close[:_BINDING]]


def plain(name: str) -> str:
    """Gives the name of a check in the words of a reader who does not know it."""
    if name in REQUIREMENTS:
        return REQUIREMENTS[name]
    kind, _, of = name.partition(" ")
    return f"{_KINDS[kind]}: {of}" if kind in _KINDS else f"{name[:1].upper()}{name[1:]}"


def failures(results: Sequence[CheckResult]) -> list[_Line]:
    """Lists the checks that fail, each by itself."""
    return [line(result) for result in results if not result.passed]


@dataclass(frozen=True)
class _Kind:
    """The checks of one kind.

    Attributes:
        words: The kind.
        passed: How many hold.
        count: How many there are.
        closest: That which fails by most or, as a share of its limit, is closest to it; None where none has both.
        lines: All of them, those of the three chains that hold in one line.
    """

    words: str
    passed: int
    count: int
    closest: _Line | None
    lines: list[_Line]


def kinds(results: Sequence[CheckResult]) -> list[_Kind]:
    """Sums checks up by their kind, kinds with failures first."""
    groups: dict[str, list[CheckResult]] = {}
    for result in results:
        groups.setdefault(result.kind or "Others", []).append(result)
    found = [_kind(words, group) for words, group in groups.items()]
    return sorted(found, key=lambda kind: kind.passed == kind.count)


def _kind(words: str, results: Sequence[CheckResult]) -> _Kind:
    passed = [result for result in results if result.passed]
    lines = failures(results)
    for name, group in grouped(passed).items():
        lines.append(line(min(group, key=closeness), f"{name} ({len(group)}×)" if len(group) > 1 else name))
    bounded = [r for r in results if r.value is not None and r.limit and r.value != r.limit]
    closest = min(bounded, key=lambda r: (r.passed, _room(r) if r.passed else -_room(r)), default=None)
    return _Kind(words, len(passed), len(results), None if closest is None else line(closest), lines)


def _room(result: CheckResult) -> float:
    """Computes the room of a check to its limit, or what it lacks, as a share of the limit."""
    assert result.value is not None
    assert result.limit
    return abs(result.value - result.limit) / abs(result.limit)


@dataclass(frozen=True)
class _FeelLine:
    """One figure at the handle, as text: in the cube's centre, at its worst, and where that is."""

    words: str
    centre: str
    worst: str
    note: str
    pose_mm: tuple[float, float, float] | None = None


def feel(s: Subject, over: Sequence[Field]) -> list[_FeelLine]:
    """Lists the figures at the handle; without fields, those that are the same everywhere."""
    lines = []
    for field in over:
        value, (x, y, z) = field.worst()
        centre = float(field.values(s.limits.centre_mm[None, :])[0])
        pose = (float(x), float(y), float(z))
        middle, worst = (with_unit(figure, field.unit) for figure in (centre, value))
        lines.append(_FeelLine(field.words, middle, worst, field.note, pose))
    drive, required = drive_torque(s.design), s.design.requirements
    force = f"in every direction, everywhere in the cube; from {drive.motor} through {_ratio(drive.ratio)}"
    lines.append(_FeelLine("Force, continuous", "", with_unit(required.force_N, "N"), force))
    if required.peak_force_N is not None:
        note = f"for {drive.peak_time_s:g} s; the structure is held against it"
        lines.append(_FeelLine("Force, peak", "", with_unit(required.peak_force_N, "N"), note))
    moving = with_unit(G_PER_KG * s.masses["moving_mass_kg"], "g")
    lines.append(_FeelLine("Moving mass", "", moving, "arms, rods, platform and knob, from the solids"))
    return lines


def _ratio(ratio: float) -> str:
    return "a direct drive" if ratio == 1.0 else f"a cable capstan of {ratio:g}:1"


def headline(s: Subject, over: Sequence[Field]) -> list[dict[str, str]]:
    """Lists the figures that a page begins with: label, value, unit, what stands below."""
    cube = s.design.cube
    found = {result.name: result.value for result in s.results}
    outline = [found.get(f"envelope {side}") for side in ("width", "depth")]
    required = s.design.requirements
    cards: list[dict[str, str]] = [
        _card("Cube", f"{2.0 * cube.half_side_mm:.2f}", "mm", f"{cube.bottom_height_mm:g} mm over the base plane"),
        _card("Force, continuous", f"{required.force_N:g}", "N", "any direction, everywhere in the cube"),
    ]
    if None not in outline:
        width, depth = (float(v) for v in outline if v is not None)
        allowed = f"of {required.envelope_width_mm:g} × {required.envelope_depth_mm:g} mm"
        cards.insert(1, _card("Swept outline", f"{width:.1f} × {depth:.1f}", "mm", allowed))
    for field in over:
        if field.name in ("effective_mass", "friction", "stiffness"):
            worst = with_unit(field.worst()[0], field.unit, 3)
            centre = float(field.values(s.limits.centre_mm[None, :])[0])
            most = "at most, in the centre" if field.name == "friction" else "in the centre"  # ball joints' is bounded
            cards.append(_card(field.words, with_unit(centre, "", 3), field.unit, f"{most}; {worst} at worst"))
    weight = f"{G_PER_KG * s.masses['moving_mass_kg']:.0f} g of it moves"
    cards.append(_card("Mass", f"{s.masses['total_mass_kg']:.2f}", "kg", weight))
    return cards


def _card(label: str, value: str, unit: str, below: str) -> dict[str, str]:
    return {"label": label, "value": value, "unit": unit, "below": below}


def lengths(s: Subject) -> list[tuple[str, str]]:
    """Lists the lengths of the mechanism and what drives it, as text."""
    m, hardware, g = s.design.mechanism, s.design.hardware, s.design.geometry
    centre_x_mm = s.design.cube.centre_x_mm
    placed = (
        []
        if g.three_fold
        else [
            (
                "Base radius R of chains 1 and 2",
                with_unit(m.base_radii_mm[1] if m.base_radii_mm else m.base_radius_mm, "mm", 6),
            ),
            ("Azimuth of chains 1 and 2, either way", with_unit(s.design.azimuths_deg[1], "deg", 6)),
        ]
    )
    if centre_x_mm:
        placed.append(("Cube's middle off the axis, towards chain 0", with_unit(centre_x_mm, "mm", 6)))
    rows: list[tuple[str, Any]] = [
        ("Base radius R" if g.three_fold else "Base radius R of chain 0", with_unit(m.base_radius_mm, "mm", 6)),
        *placed,
        ("Platform radius r", with_unit(m.platform_radius_mm, "mm", 6)),
        ("Upper arm L_A", with_unit(m.upper_arm_length_mm, "mm", 6)),
        ("Forearm L_B", with_unit(m.forearm_length_mm, "mm", 6)),
        ("Parallelogram width", with_unit(m.parallelogram_width_mm, "mm", 6)),
        ("Motors", f"3 × {hardware.motor}"),
        ("Drive", _ratio(drive_torque(s.design).ratio)),
    ]
    return rows
