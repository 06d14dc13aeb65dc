"""How far each refusal of a candidate moves the search: one threshold, found on the closed form itself.

Nothing here knows what a reason is about: it changes the fields that the reason names until the forms no longer give
it, as `delta_cad.structure.hardware.thresholds` does for who reads a refusal, but no finer than a search needs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import degrees, floor, log10

from delta_cad.design import Design
from delta_cad.dimensions import Reason
from delta_cad.dimensions.rules import ARM, BASE, BOTTOM, FOREARM, HEIGHT, PLATFORM, WIDTH, Way
from delta_cad.mechanism import MechanismError, cube_extremes
from delta_cad.structure.hardware.refusals import LEARNT, MODE, PARTS
from delta_cad.structure.hardware.thresholds import (
    DIGITS,
    Values,
    Variants,
    along,
    by_row,
    changed,
    least,
    rows_of,
    value_of,
)

LENGTHS = {
    BASE: "base_radius",
    PLATFORM: "platform_radius",
    FOREARM: "forearm_length",
    ARM: "upper_arm_length",
    BOTTOM: "bottom_height",
}
"""Field of a design that a refusal names -> the length that is bounded from below."""
SIZES = (
    "sector_radius_mm",
    "base_plate_thickness_mm",
    "arm_thickness_mm",
    "platform_thickness_mm",
    "ball_diameter_mm",
)
ENVELOPE = ("envelope_width_mm", "envelope_depth_mm")
HEIGHT_ENTRY = HEIGHT.rpartition(".")[2]
_SEARCHED = {
    *LENGTHS,
    WIDTH,
    *(f"hardware.{name}" for name in SIZES),
    *(f"requirements.{name}" for name in ENVELOPE),
    HEIGHT,
}
"""Fields of which a search looks for a number."""
ELBOW_FIELD, SWING_FIELD = "requirements.elbow_angle_min_deg", "requirements.shoulder_min_deg"
_ANGLES = {("rod_tube", "beside the drive"): ELBOW_FIELD, ("upper_arm", "beside its cheeks"): SWING_FIELD}
"""Reason -> the angle that ends it, whichever lengths give it."""
_DECIMALS = 1  # of a threshold: the search goes on in tenths of a millimetre
_WITH = (PARTS, "cable plane", "cable travel")  # forms, of a millisecond each, that an estimate may break none of


@dataclass(frozen=True)
class Estimate:
    """A reason against a candidate with the value of one field that ends it.

    Attributes:
        reason: Why closed forms refuse the candidate.
        field: Dotted path; "" where no change of what the reason names ends it.
        value: Its value.
        bound: The value nearest to it that ends the reason; None of a field that a search looks for no number of.
        angle: Field of an angle and its least value in degrees, which other lengths may give as well.
    """

    reason: Reason
    field: str = ""
    value: float | str | None = None
    bound: float | None = None
    angle: tuple[str, float] | None = None

    @property
    def part(self) -> str:
        """What is refused."""
        return self.reason.part

    def __str__(self) -> str:
        return str(self.reason)


def estimates(design: Design) -> tuple[Estimate, ...]:
    """Gives every reason why closed forms refuse a candidate, what parts weigh left out, each with its estimate.

    Raises:
        UnreachableError: A point of the cube is out of reach.
    """
    variants = Variants(design, LEARNT)
    judged = variants.judged({})
    assert judged is not None
    forms = dict(judged.forms())
    found = list[Estimate]()
    for form in sorted(forms, key=lambda form: form != PARTS):  # what has no dimensions is listed first
        for reason in forms[form]:
            found.append(_estimate(variants, form, reason, found))
    return tuple(found)


def _estimate(variants: Variants, form: str, reason: Reason, known: Sequence[Estimate]) -> Estimate:
    """The nearest threshold of the first field that has one; a field of which no number is sought ends the search.

    What the largest value that another reason asks for ends as well is not looked at more closely.
    """
    design, leads = variants.design, dict[str, list[Way]]()
    for way in sorted(reason.ways, key=lambda way: way.fields[0].rpartition(".")[2] not in (*ENVELOPE, HEIGHT_ENTRY)):
        leads.setdefault(way.fields[0], []).append(way)
    for field, ways in leads.items():
        own = value_of(design, field)
        if field not in _SEARCHED:
            return Estimate(reason, field, own)
        farthest = max((one.bound for one in known if one.field == field in LENGTHS and one.bound), default=None)
        if farthest and reason.key not in _ANGLES and _gone(variants, form, reason)(along(design, ways[0], farthest)):
            return Estimate(reason, field, own, farthest)
        found = [(value, way) for way in ways for value in _thresholds(variants, form, reason, way)]
        if found:
            value, way = min(found, key=lambda one: abs(one[0] - float(own)))
            name = _ANGLES.get(reason.key)
            angle = None if name is None else (name, _angle_deg(variants, form, reason, way, value))
            return Estimate(reason, field, own, value, angle)
    return Estimate(reason)


def _thresholds(variants: Variants, form: str, reason: Reason, way: Way) -> list[float]:
    """Values of a way's first field, to a tenth of its unit, that end a reason."""
    design, lead, gone = variants.design, way.fields[0], _gone(variants, form, reason)
    if by_row(lead):
        return [float(row) for row in rows_of(design, lead) if gone({lead: row})]
    own = float(value_of(design, lead))
    digits = min(floor(log10(own)) + 1 + _DECIMALS, DIGITS)
    senses = (True, False) if way.larger is None else (way.larger,)
    ends = (least(lambda first: gone(along(design, way, first)), own, larger, digits) for larger in senses)
    return [value for value in ends if value is not None]


def _gone(variants: Variants, form: str, reason: Reason) -> Callable[[Values], bool | None]:
    """Values -> whether a reason is gone and none is there that was not; None where it cannot be judged."""
    forms = dict.fromkeys((form,) if form == MODE else (form, *_WITH))

    def given(values: Values, name: str) -> tuple[Reason, ...] | None:
        judged = variants.judged(values)
        return None if judged is None else judged.of(name)

    before = {one.key for name in forms for one in given({}, name) or ()}

    def gone(values: Values) -> bool | None:
        try:
            found = {name: given(values, name) for name in forms}
        except (MechanismError, ValueError, ArithmeticError):
            return None
        keys = {one.key for some in found.values() for one in some or ()}
        return None if found[form] is None else reason.key not in keys and keys <= before

    return gone


def _angle_deg(variants: Variants, form: str, reason: Reason, way: Way, value: float) -> float:
    """The angle that a reason is about where a higher cube ends it, or else where the change that was found does."""
    for higher in reason.ways:
        if higher.fields == (BOTTOM,) and (found := _thresholds(variants, form, reason, higher)):
            way, value = higher, found[0]
    made = changed(variants.design, along(variants.design, way, value))
    assert made is not None
    extremes = cube_extremes(made.geometry, made.workspace, made.requirements.force_N)
    if _ANGLES[reason.key] == SWING_FIELD:
        return degrees(extremes.shoulder_min.value)
    return 180.0 - degrees(extremes.forearm_angle_max.value)
