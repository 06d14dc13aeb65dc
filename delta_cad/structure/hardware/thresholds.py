"""Threshold of a field that removes a refusal, found by a search on the refusal itself."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import floor, log10
from typing import Any

from pydantic import ValidationError

from delta_cad import catalogue
from delta_cad.design import Design, design_to_dict
from delta_cad.design.cross_field_rules import contradictions
from delta_cad.design.record import HARDWARE_FAMILIES
from delta_cad.dimensions import Reason
from delta_cad.dimensions.rules import BASE, Way
from delta_cad.interference.reasons import INTERFERENCE_FORMS
from delta_cad.mechanism import MechanismError
from delta_cad.structure.hardware.refusals import NECESSARY, Held, Judged

DIGITS = 4  # of a value that is looked for: what is read and typed is what was judged
SIGNED = ("cube.centre_x_mm",)  # fields that may be negative; left out they are 0
_SHARES = 0.01, 0.03, 0.1, 0.3, 1.0, 2.0  # by which a field is changed until the reason is gone; then bisection
_STEPS = tuple(k / 4 for k in range(1, 65))  # of the scale of a field of either sign, which may be right in a band
_NAMED = 4  # rows of the catalogue that a message names at most
_CHOICES = {"leads": ("none", "bent"), "mounting": ("screws", "both", "plate", "feet")}
"""Entries of the hardware that are words."""
LENGTHS = "mechanism."  # fields that move together by the same length; others by the same share
_FIRST = "base_radius_mm"  # of chain 0
_EACH = "mechanism.base_radii_mm"  # of all chains
REQUIRED = "requirements.", "panel.", "cube.half_side"  # fields that say what is asked

Values = Mapping[str, float | str]
_Gone = Callable[[float], bool | None]


def least(gone: _Gone, value: float, larger: bool, digits: int = DIGITS, scale: float | None = None) -> float | None:
    """Finds the value nearest to a field's own at which something no longer holds, in some digits.

    Steps of growing width on one side, then bisection within the last, down to one unit of the last digit.

    Args:
        gone: Value -> True: it is gone; False: it is there; None: it cannot be judged.
        value: The field's own value, at which it is there.
        larger: Which side is looked at.
        digits: How many.
        scale: What the steps are shares of, for a field of either sign; None: of the value itself.

    Returns:
        The value; one unit nearer to the field's own it is there. None where it is gone nowhere on that side, or what
        lies before cannot be judged.
    """
    unit = 10.0 ** (floor(log10(scale or abs(value))) - digits + 1)
    places = max(0, -round(log10(unit)))

    def at(count: int) -> float:
        return round(count * unit, places)

    own = floor(value / unit) if larger else -floor(-value / unit)
    near, there = own, True
    for share in _SHARES if scale is None else _STEPS:
        if scale is not None:
            far = round(own + (share if larger else -share) * scale / unit)
        else:
            far = round(own * (1.0 + share) if larger else own / (1.0 + share))
        state = gone(at(far))
        if state:
            break
        near, there = far, state is False
    else:
        return None
    while abs(far - near) > 1:
        middle = (near + far) // 2
        if state := gone(at(middle)):
            far = middle
        else:
            near, there = middle, state is False
    return at(far) if there else None


def value_of(design: Design, field: str) -> float | str:
    """Gives the value of a field, by its dotted path; "" where it was left out."""
    section, _, name = field.partition(".")
    value = getattr(getattr(design, section), name)
    return (0.0 if field in SIGNED else "") if value is None else value


def changed(design: Design, values: Values) -> Design | None:
    """Gives a design with some fields changed, its own parts kept; None where a value is out of its field's bounds."""
    sections: dict[str, dict[str, Any]] = {}
    for field, value in values.items():
        section, _, name = field.partition(".")
        sections.setdefault(section, {})[name] = value
    if (radii := design.mechanism.base_radii_mm) is not None and (first := sections.get("mechanism", {}).get(_FIRST)):
        side = rounded(radii[1] + first - radii[0])  # all chains go out by the same
        sections["mechanism"]["base_radii_mm"] = (first, side, side)
    made = design.model_copy(
        update={name: getattr(design, name).model_copy(update=given) for name, given in sections.items()}
    )
    try:
        Design.model_validate(design_to_dict(made))
    except ValidationError:
        return None
    return made


def rows_of(design: Design, field: str) -> list[float | str]:
    """Lists what else a field that is no length may be: rows of its family that suit the drive, sizes, words."""
    name, h = field.partition(".")[2], design.hardware
    if name == "ball_diameter_mm":
        found: list[float | str] = [*sorted({row.diameter_mm for row in catalogue.ball.rows.values()})]
    elif name in HARDWARE_FAMILIES:
        found = [*catalogue.family(name, h.own_parts)]
    else:
        found = [*_CHOICES.get(name, ())]
    if name == "motor":
        motors = catalogue.family("motor", h.own_parts)
        sensed = h.encoder_at == "motor"
        found = [
            key
            for key, row in motors.items()
            if isinstance(row, catalogue.Motor)
            and h.drive in row.drives
            and not (sensed and row.encoder_counts_per_turn is None)
        ]
    return [row for row in found if row != value_of(design, field)]


def by_row(field: str) -> bool:
    """Whether a field takes rows, sizes in stock or words, not any number."""
    section, _, name = field.partition(".")
    return section == "hardware" and (name in HARDWARE_FAMILIES or name in _CHOICES or name == "ball_diameter_mm")


def along(design: Design, way: Way, first: float) -> dict[str, float | str]:
    """Gives the values of a way's fields where its first has one: lengths by as much, others by the same share."""
    lead, *rest = way.fields
    own = float(value_of(design, lead))
    values: dict[str, float | str] = {lead: first}
    for field in rest:
        held = float(value_of(design, field))
        both = lead.startswith(LENGTHS) and field.startswith(LENGTHS)
        values[field] = rounded(held + first - own if both else held * first / own)
    return values


def rounded(value: float) -> float:
    """Rounds a value that follows from another to one digit more than is looked for."""
    return float(f"{value:.{DIGITS + 1}g}")


def by_chain(design: Design, values: Values) -> dict[str, Any]:
    """Names the base radius as the file states it: where it states those of all chains, each of these."""
    radii, first = design.mechanism.base_radii_mm, values.get(BASE)
    if radii is None or first is None:
        return dict(values)
    out = float(first) - radii[0]
    each = {f"{_EACH}[{i}]": rounded(radius + out) if out else radius for i, radius in enumerate(radii)}
    return {**each, **{field: value for field, value in values.items() if field != BASE}}


class Variants:
    """A design with its fields varied, and what closed forms say of each variant, computed once.

    Args:
        design: The design.
        held: What every variant is held to.
    """

    def __init__(self, design: Design, held: Held = NECESSARY) -> None:
        self.design, self.held = design, held
        self._faults = {fault.field for fault in contradictions(design)}
        self._judged: dict[frozenset[tuple[str, float | str]], Judged | None] = {}

    @property
    def count(self) -> int:
        """Number of evaluated variants."""
        return len(self._judged)

    def judged(self, values: Values) -> Judged | None:
        """Gives what closed forms say; None where numbers cannot go together that could before."""
        key = frozenset(values.items())
        if key not in self._judged:
            made = changed(self.design, values)
            impossible = made is None or any(one.field not in self._faults for one in contradictions(made))
            self._judged[key] = None if made is None or impossible else Judged(made, self.held)
        return self._judged[key]

    def gone(self, values: Values, form: str, key: tuple[str, str]) -> bool | None:
        """Whether a reason of a form is gone; None where the form cannot be judged."""
        try:
            found = None if (judged := self.judged(values)) is None else judged.of(form)
        except (MechanismError, ValueError, ArithmeticError):
            return None
        return None if found is None else all(one.key != key for one in found)


@dataclass(frozen=True)
class Threshold:
    """A change that ends one reason.

    Attributes:
        own: Field -> its value.
        enough: Field -> the value nearest to it at which the reason is gone; of rows all, up to four.
    """

    own: Mapping[str, float | str]
    enough: Mapping[str, float | tuple[float | str, ...]]

    def record(self) -> dict[str, Any]:
        """Gives the same as JSON types."""
        return {"was": dict(self.own), "enough": dict(self.enough), "requirement": self.required}

    @property
    def required(self) -> bool:
        """Whether it changes a requirement."""
        return any(field.startswith(REQUIRED) for field in self.enough)

    def includes(self, other: Threshold) -> bool:
        """Whether it changes all that another changes, and none of it less."""
        return all(
            field in self.enough and _as_far(self.own[field], self.enough[field], value)
            for field, value in other.enough.items()
        )

    def __str__(self) -> str:
        lines = [self._radii()] if f"{_EACH}[0]" in self.enough else []
        for field, value in self.enough.items():
            own, must = self.own[field], "" if lines else " must be"
            if isinstance(value, tuple):
                lines.append(f"{field} = {own}{must} {' or '.join(f'{row}' for row in value)}")
            elif not field.startswith(_EACH):
                sense = "at least" if value > float(own) else "at most"
                lines.append(f"{field} = {own:g}{must} {sense} {value:.{DIGITS + 1}g}")
        return " with ".join(lines)

    def _radii(self) -> str:
        """States the base radii of all chains, which go out or in by the same, as one change."""
        own, new = ([one for f, one in values.items() if f.startswith(_EACH)] for values in (self.own, self.enough))
        by = float(f"{new[0]}") - float(f"{own[0]}")
        sense, longer = ("at least", "longer") if by > 0.0 else ("at most", "shorter")
        was, must = (", ".join(f"{one:.{DIGITS + 1}g}" for one in radii) for radii in (own, new))
        return f"{_EACH} = [{was}] must be {sense} [{must}], each {abs(by):.{DIGITS}g} mm {longer}"


def _as_far(own: float | str, value: float | tuple[float | str, ...], other: float | tuple[float | str, ...]) -> bool:
    """Whether a value lies on the same side of a field's own as another, and no nearer; of rows, the same ones."""
    if isinstance(value, tuple) or isinstance(other, tuple):
        return value == other
    return (other - float(own)) * (value - other) >= 0.0


def _needed(found: list[Threshold]) -> Iterator[Threshold]:
    """Leaves out each change that includes another, which does alone; of equal ones the first stays."""
    for place, one in enumerate(found):
        others = (other for k, other in enumerate(found) if k < place or (k > place and not other.includes(one)))
        if not any(one.includes(other) for other in others):
            yield one


@dataclass(frozen=True)
class Refused:
    """A reason with the changes that end it, each by itself."""

    reason: Reason
    thresholds: tuple[Threshold, ...]

    def record(self) -> dict[str, Any]:
        """Gives the same as JSON types: part, feature, what was computed, and the changes that end it."""
        one = self.reason
        changes = [threshold.record() for threshold in self.thresholds]
        return {"part": one.part, "feature": one.feature, "message": one.message, "changes": changes}

    def __str__(self) -> str:
        demand = [f"{one}" for one in self.thresholds if one.required]
        enough = "; or ".join(f"{one}" for one in self.thresholds if not one.required)
        if not enough:
            tried = ", ".join(dict.fromkeys(field for way in self.reason.ways for field in way.fields))
            enough = f"no value of {tried} alone ends this" if tried and not demand else ""
        loosened = f"where the requirement may change, {' or '.join(demand)}" if demand else ""
        return ": ".join([f"{self.reason}", *filter(None, ["; or, ".join(filter(None, [enough, loosened]))])])


def refused(design: Design) -> Iterator[Refused]:
    """Gives every reason why a design is refused, each with the changes that end it, found one after the other.

    Args:
        design: A design, each field within its own bounds.

    Raises:
        UnreachableError: A point of the cube is out of reach.
    """
    variants = Variants(design)
    forms = dict(Judged(design).forms())
    order = sorted(forms, key=lambda form: form != "dimensions")  # what has no dimensions is listed first
    for form in order:
        for reason in forms[form]:
            found = list[Threshold]()
            for way in reason.ways:
                if (
                    form in INTERFERENCE_FORMS and found
                ):  # what is sampled takes a tenth of a second a value: one change of it
                    break
                found += _threshold(variants, form, reason, way)
            yield Refused(reason, tuple(sorted(_needed(found), key=lambda one: one.required)))


def _threshold(variants: Variants, form: str, reason: Reason, way: Way) -> Iterator[Threshold]:
    """Gives what ends a reason along one way, either way where it names none; nothing where nothing does."""
    design, lead = variants.design, way.fields[0]
    own = {field: value_of(design, field) for field in way.fields}
    if "" in own.values() and not by_row(lead):
        return
    if by_row(lead):
        rows = [row for row in rows_of(design, lead) if variants.gone({lead: row}, form, reason.key)]
        if rows:
            yield Threshold(own, {lead: tuple(rows[:_NAMED])})
        return
    for larger in (True, False) if way.larger is None else (way.larger,):
        found = least(
            lambda first: variants.gone(along(design, way, first), form, reason.key),
            float(own[lead]),
            larger,
            scale=design.cube.half_side_mm if lead in SIGNED else None,
        )
        if found is not None:
            enough = {field: float(value) for field, value in along(design, way, found).items()}
            yield Threshold(*(by_chain(design, values) for values in (own, enough)))
