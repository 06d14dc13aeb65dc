"""The smallest change found of a design's free fields with which every closed form passes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heappop, heappush
from math import ceil, floor, log, log10

from delta_cad.design import Design
from delta_cad.design.cross_field_rules import contradictions
from delta_cad.dimensions import Reason
from delta_cad.dimensions.joint import known_joints
from delta_cad.dimensions.rules import ARM, BASE, BOTTOM, FOREARM, PLATFORM, RATIO, SECTOR, WIDTH, Way, larger, smaller
from delta_cad.mechanism import MechanismError
from delta_cad.mechanism.limits import POSE_LIMITS, Limits
from delta_cad.mechanism.proof.prove import prove
from delta_cad.structure.hardware.refusals import ALONE, FORMS, MODE, PARTS, SURE
from delta_cad.structure.hardware.thresholds import (
    DIGITS,
    REQUIRED,
    SIGNED,
    Values,
    Variants,
    along,
    by_chain,
    by_row,
    changed,
    least,
    rounded,
    rows_of,
    value_of,
)

_MOST_MS = 30_000.0  # of what is judged by the search with margins, and as much without: on the machine of `_COSTS_MS`
_MOST_BOXES = 20_000  # of a proof: what is not decided by then is not taken
_ROW = 0.5  # what another row of the catalogue counts, as a share of a length
_AHEAD = 0.1  # what each form counts that is still to be passed, and each reason of the first that is not
_SUMS, _REACH, LIMITS = "sums", "reach", "limits"
_UNREACHED = larger(FOREARM), larger(ARM), larger(BOTTOM), smaller(BOTTOM)
FREE = ARM, FOREARM, WIDTH, BOTTOM, SECTOR, RATIO, PLATFORM, BASE
_ANY = (larger(BASE, PLATFORM), *map(larger, FREE), *map(smaller, FREE))
"""Where a reason names nothing that is free."""
_COSTS_MS = {
    PARTS: 40.0,
    LIMITS: 180.0,
    "motor on its way in": 20.0,
    "cups": 27.0,
    "sector beside a neighbour's cheek": 29.0,
    "folded": 31.0,
    "overloads": 50.0,
    "sector beside a neighbour's": 90.0,
    "motor_screw key": 300.0,
}
"""Form -> processor time that it takes, of one core of 2026; of others `_QUICK_MS`. Those that cost most are last."""
_QUICK_MS = 2.0
_QUICK = len((_SUMS, _REACH, MODE, *ALONE, PARTS, LIMITS))
ORDER = (_SUMS, _REACH, MODE, *ALONE, PARTS, LIMITS, *sorted(FORMS, key=lambda form: _COSTS_MS.get(form, 0.0)))


@dataclass(frozen=True)
class _Suggestion:
    """A design that closed forms pass.

    Attributes:
        design: The design; its requirements are those of the one that was refused.
        values: Field -> its new value.
        own: Field -> its value in the design that was refused.
        with_margin: Whether it keeps the margins with which solids are expected to pass, too.
    """

    design: Design
    values: Values
    own: Values
    with_margin: bool

    def __str__(self) -> str:
        new = self.values.items()
        return ", ".join(f"{field} = {_word(value)} (was {_word(self.own[field])})" for field, value in new)


def _word(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


def suggestion(design: Design) -> _Suggestion | None:
    """Searches the smallest change of free fields with which closed forms refuse nothing.

    Each reason is ended by each change that it names, found by a threshold search; the variant that is least changed
    and has most forms behind it goes on. What was changed is then taken back as far as all closed forms still pass.
    Requirements, panel and the cube's side stay.

    Args:
        design: A design, each field within its own bounds.

    Returns:
        The smallest that was found along these directions: with margins for the solids, else without; None where none
        was found.
    """
    for margin in (True, False):
        if (values := _Search(design, margin).found()) is not None and (made := changed(design, values)) is not None:
            own = {field: value_of(design, field) for field in values}
            return _Suggestion(made, by_chain(design, values), by_chain(design, own), margin)
    return None


class _Search:
    """A search of one design.

    Attributes:
        mended: Reasons that came up; with margins they are held to more than is necessary, so that solids pass, too.
        spent_ms: What was judged has taken, by `_COSTS_MS`.
    """

    def __init__(self, design: Design, margin: bool) -> None:
        self.design, self.mended, self.spent_ms = design, set[tuple[str, str]](), 0.0
        self.necessary = Variants(design)
        self.sure = Variants(design, SURE) if margin else self.necessary
        self._known: dict[tuple[frozenset[tuple[str, float | str]], str], tuple[Reason, ...]] = {}

    def own(self, field: str) -> float | str:
        """A field's value in the design that was refused."""
        return value_of(self.design, field)

    def found(self) -> dict[str, float | str] | None:
        """Ends reason after reason, from the variant that promises most; gives what was changed, taken back."""
        waiting: list[tuple[float, int, dict[str, float | str]]] = [(0.0, 0, {})]
        seen = set[frozenset[tuple[str, float | str]]]()
        while waiting and self.spent_ms < _MOST_MS:
            _, _, values = heappop(waiting)
            form, there = self.reasons(values)
            if not there:
                return self._taken_back(values)
            self.mended |= {one.key for one in there}
            for reason in there:
                for one in self._ended(values, form, reason):
                    if (key := frozenset(one.items())) not in seen:
                        seen.add(key)
                        heappush(waiting, (self._promise(one), len(seen), one))
        return None

    def reasons(self, values: Values) -> tuple[str, tuple[Reason, ...]]:
        """Gives the first form that refuses a variant, in the order of their costs, and its reasons; or none."""
        return next(((form, some) for form in ORDER if (some := self._of(values, form))), ("", ()))

    def _of(self, values: Values, form: str) -> tuple[Reason, ...]:
        """Reasons of a form, with the requested margins; the forms before it refuse nothing."""
        key = frozenset(values.items()), form
        if key not in self._known:
            self.spent_ms += _COSTS_MS.get(form, _QUICK_MS)
            self._known[key] = self._judged(values, form)
        found = self._known[key]
        if (
            self.sure is self.necessary
            or form in (_SUMS, _REACH, LIMITS)
            or all(one.key in self.mended for one in found)
        ):
            return found
        judged = self.necessary.judged(values)
        needed = {one.key for one in (judged and judged.of(form)) or ()}
        return tuple(one for one in found if one.key in needed or one.key in self.mended)

    def _judged(self, values: Values, form: str) -> tuple[Reason, ...]:
        """Reasons of a form, computed; where others come before it that refuse, there may be none."""
        made, judged = changed(self.design, values), self.sure.judged(values)
        if form == _SUMS:
            faults = [] if made is None else contradictions(made)
            found = (Reason("design", f.field, f.allowed, (Way((f.field,), f.bound > f.value), *_ANY)) for f in faults)
            return tuple(found) if made is not None else (Reason("design", "bounds", "a value is out of its bounds"),)
        if made is None or judged is None:
            return ()
        try:
            return _broken(made) if form == LIMITS else judged.of(MODE if form == _REACH else form) or ()
        except (MechanismError, ValueError, ArithmeticError) as error:
            return (Reason("cube", _REACH, str(error), _UNREACHED),)

    def _ended(self, values: Values, form: str, reason: Reason) -> Iterator[dict[str, float | str]]:
        """Gives variants in which all that is quick to judge, or else the reason, is gone: of each way, of each row."""
        if (made := changed(self.design, values)) is None:
            return
        place = ORDER.index(form)
        first, stage = ORDER[: min(place, _QUICK)], ORDER[: max(place + 1, _QUICK)]

        def all_gone(new: Values) -> bool | None:
            return not any(self._of({**values, **new}, one) for one in stage)

        def gone(new: Values) -> bool | None:
            merged = {**values, **new}
            if any(self._of(merged, one) for one in first if one != LIMITS):
                return None
            return all(one.key != reason.key for one in self._of(merged, form))

        free = [way for way in reason.ways if not any(field.startswith(REQUIRED) for field in way.fields)]
        for way in free or _ANY:
            lead = way.fields[0]
            if by_row(lead):
                yield from ({**values, lead: row} for row in rows_of(made, lead) if gone({lead: row}))
            elif (now := value_of(made, lead)) != "":
                scale = made.cube.half_side_mm if lead in SIGNED else None
                for grows in (True, False) if way.larger is None else (way.larger,):
                    for ends in (all_gone, gone):
                        end = least(
                            lambda one, way=way, ends=ends: ends(along(made, way, one)), float(now), grows, scale=scale
                        )
                        if end is not None:
                            yield {**values, **along(made, way, end)}
                            break

    def _promise(self, values: Values) -> float:
        form, there = self.reasons(values)
        left = len(there) + len(ORDER) - ORDER.index(form) if there else 0
        return self._size(values) + _AHEAD * left

    def _size(self, values: Values) -> float:
        """Relative change, summed over fields."""
        own = {field: self.own(field) for field in values}
        return sum(
            _ROW if by_row(field) else abs(log(float(value) / float(own[field]))) for field, value in values.items()
        )

    def _passes(self, values: Values) -> bool:
        return not self.reasons(values)[1]

    def _taken_back(self, values: dict[str, float | str]) -> dict[str, float | str]:
        """Brings fields back to their own values as far as everything passes, what is changed most first."""
        for field in sorted(values, key=lambda one: -self._size({one: values[one]})):
            values = self._nearest(values, field)
        return values

    def _nearest(self, values: dict[str, float | str], field: str) -> dict[str, float | str]:
        """Brings one field as near to its own value as everything passes, in four digits."""
        rest = {name: value for name, value in values.items() if name != field}
        if self._passes(rest):
            return rest
        if by_row(field):
            return values
        now, own = float(values[field]), float(self.own(field))
        unit = 10.0 ** (floor(log10(abs(now))) - DIGITS + 1)
        outwards, inwards = (ceil, floor) if now > own else (floor, ceil)
        near, far = inwards(own / unit), outwards(round(now / unit, 6))

        def at(count: int) -> dict[str, float | str]:
            return {**rest, field: rounded(count * unit)}

        if not self._passes(at(far)):
            return values
        while abs(far - near) > 1:
            middle = (near + far) // 2
            near, far = (near, middle) if self._passes(at(middle)) else (middle, far)
        return at(far)


def _broken(design: Design) -> tuple[Reason, ...]:
    """Limits of the requirements that are not proved over the cube, as far as they need no masses; friction the last.

    What the ball joints rub is bounded by a proof of its own, which takes most of the time: only where all else holds.
    """
    values = design.requirements.model_dump()
    for friction in (False, True)[: 1 + (values["friction_max_N"] is not None)]:
        stated = values | known_joints(design, friction=friction)
        stated |= {} if friction else {"friction_max_N": None}
        known = [kind.stated(stated) for kind in POSE_LIMITS if not kind.needs or stated.get(kind.needs) is not None]
        proof = prove(design.geometry, design.workspace, Limits.of(*known), max_boxes=_MOST_BOXES)
        if left := [one for one in proof.findings if one.verdict != "proved"]:
            return tuple(Reason("mechanism", one.condition, one.verdict) for one in left)
    return ()
