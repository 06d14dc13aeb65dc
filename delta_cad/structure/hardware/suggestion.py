"""The smallest change of what a design leaves free that every closed form passes, as found along some directions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, floor, log, log10

from delta_cad.design import Design
from delta_cad.design.sums import Contradiction, impossible_sums
from delta_cad.dimensions import Reason
from delta_cad.dimensions.joint import limit_values
from delta_cad.dimensions.rules import ARM, BASE, BOTTOM, FOREARM, PLATFORM, SECTOR, WIDTH, Way, larger, smaller
from delta_cad.mechanism import MechanismError
from delta_cad.mechanism.limits import POSE_LIMITS, Limits
from delta_cad.mechanism.proof.prove import prove
from delta_cad.structure.hardware.refusals import ALONE, FORMS, MODE, PARTS, SURE
from delta_cad.structure.hardware.thresholds import (
    DIGITS,
    REQUIRED,
    Values,
    Variants,
    along,
    by_row,
    changed,
    rounded,
    rows_of,
    value_of,
)

ROUNDS = 8  # reasons that are followed, one after the other
MOST_VARIANTS = 120  # that are judged before a search ends: a tenth of a second each, or two
THRESHOLDS = 10  # along one way
STEPS = 0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64  # shares by which a field is changed until a reason is gone
HALVINGS = 5  # of what was changed, while everything still passes
MOST_BOXES = 20_000  # of a proof: what is not decided by then is not taken
ROW = 0.5  # what another row of the catalogue counts, as a share of a length
FREE = ARM, FOREARM, WIDTH, BOTTOM, SECTOR
ANY = (larger(BASE, PLATFORM), *map(larger, FREE), *map(smaller, FREE))
"""Where no way that a reason names goes on."""


@dataclass(frozen=True)
class Suggestion:
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


def suggestion(design: Design) -> Suggestion | None:
    """Searches the smallest change of free fields with which closed forms refuse nothing.

    Reason after reason the change that leaves fewest is taken; what was changed is then taken back as far as all
    closed forms still pass, together and field by field. Requirements, panel and the cube's side stay.

    Args:
        design: A design, each field within its own bounds.

    Returns:
        The smallest that was found along these directions: with margins for the solids, else without; None where none
        was found.
    """
    for margin in (True, False):
        if (values := _Search(design, margin).found()) is not None and (made := changed(design, values)) is not None:
            return Suggestion(made, values, {field: value_of(design, field) for field in values}, margin)
    return None


class _Search:
    """A search of one design.

    Attributes:
        mended: Reasons that came up; with margins they are held to more than is necessary, so that solids pass, too.
        given: Reasons whose margin is not kept where the search has arrived, and is not asked for; None: only what came
            up is to keep its margin.
    """

    def __init__(self, design: Design, margin: bool) -> None:
        self.design, self.mended = design, set[tuple[str, str]]()
        self.given: set[tuple[str, str]] | None = None
        self.necessary = Variants(design)
        self.sure = Variants(design, SURE) if margin else self.necessary
        self._limits: dict[frozenset[tuple[str, float | str]], list[Reason]] = {}

    def own(self, field: str) -> float | str:
        """A field's value in the design that was refused."""
        return value_of(self.design, field)

    def found(self) -> dict[str, float | str] | None:
        """Looks along single directions, then follows reason after reason; gives what was changed, taken back."""
        if not (there := self.reasons({})):
            return {}
        if (values := self._straight(there) or self._followed()) is None:
            return None
        self.given = {one.key for form in FORMS for one in self._sure(values, form)}
        return self._taken_back(values)

    def reasons(self, values: Values, first: bool = False) -> list[tuple[str, Reason]]:
        """Gives the reasons of a variant with their forms; of the first form that refuses it alone, where asked."""
        if (made := changed(self.design, values)) is None:
            return [(BOUNDS, Reason("design", BOUNDS, ""))]
        if faults := impossible_sums(made):
            return [(SUMS, _contradicted(one)) for one in faults]
        try:
            found = ([(form, one) for one in self._of(values, form)] for form in QUICKEST)
            return next(filter(None, found), []) if first else [one for some in found for one in some]
        except (MechanismError, ValueError, ArithmeticError) as error:
            return [(REACH, Reason("cube", REACH, str(error), ways=UNREACHED))]

    def _sure(self, values: Values, form: str) -> tuple[Reason, ...]:
        return ((judged := self.sure.judged(values)) and judged.of(form)) or ()

    def _of(self, values: Values, form: str) -> list[Reason]:
        """Reasons of a form, with margins as far as they are asked for."""
        if form == LIMITS:
            key = frozenset(values.items())
            if key not in self._limits:
                made = changed(self.design, values)
                self._limits[key] = [] if made is None else _broken(made)
            return self._limits[key]
        if not (found := self._sure(values, form)):
            return []
        necessary = self.necessary.judged(values)
        needed = {one.key for one in (necessary and necessary.of(form)) or ()}
        return [one for one in found if one.key in needed or self._keeps(one.key)]

    def _keeps(self, key: tuple[str, str]) -> bool:
        return key in self.mended if self.given is None else key not in self.given

    def _straight(self, there: list[tuple[str, Reason]]) -> dict[str, float | str] | None:
        """The smallest change along a single way of a reason, or of all chains farther out, that passes; or None."""
        ways = dict.fromkeys([larger(BASE, PLATFORM), *(way for _, one in there for way in _free(one))])
        passing = [values for way in ways if (values := self._marched(way)) is not None]
        return min(passing, key=self._size, default=None)

    def _marched(self, way: Way) -> dict[str, float | str] | None:
        """Goes along a way from threshold to threshold, until nothing refuses it; None where it does not end."""
        self.mended.clear()
        if by_row(lead := way.fields[0]):
            return next((one for one in self._along({}, way) if not self.reasons(one, first=True)), None)
        own, gone_at = float(self.own(lead) or 0.0), 0.0
        sense = -1.0 if way.larger is False else 1.0

        def at(share: float) -> dict[str, float | str]:
            return along(self.design, way, own * (1.0 + sense * share)) if share else {}

        for _ in range(THRESHOLDS if own else 0):
            if self.sure.count > MOST_VARIANTS:
                return None
            if not (there := self.reasons(at(gone_at), first=True)):
                return at(gone_at)
            self.mended |= {one.key for _, one in there}

            def gone(share: float, there: list[tuple[str, Reason]] = there) -> bool:
                return all(self._gone(at(share), form, one.key) for form, one in there)

            ahead = (gone_at + step for step in STEPS)
            low, high = gone_at, next((share for share in ahead if share < 1.0 and gone(share)), 0.0)
            if not high:
                return None
            for _ in range(HALVINGS):
                middle = (low + high) / 2.0
                low, high = (low, middle) if gone(middle) else (middle, high)
            gone_at = high
        return None

    def _followed(self) -> dict[str, float | str] | None:
        """Takes, for reason after reason, the change that leaves the fewest."""
        values, seen = dict[str, float | str](), set[frozenset[tuple[str, float | str]]]()
        self.mended.clear()
        for _ in range(ROUNDS):
            if self.sure.count > MOST_VARIANTS:
                return None
            if not (there := self.reasons(values)):
                return values
            seen.add(frozenset(values.items()))
            self.mended |= {one.key for _, one in there}
            nexts: list[dict[str, float | str]] = []
            for form, reason in there:
                nexts = [one for one in self._mended(values, form, reason) if frozenset(one.items()) not in seen]
                if nexts:
                    break
            if not nexts:
                return None
            values = min(nexts, key=lambda one: (*self._rank(one), self._size(one)))
        return None

    def _rank(self, values: Values) -> tuple[int, int]:
        there = self.reasons(values)
        return max((RANKS.get(form, 1) for form, _ in there), default=0), len(there)

    def _size(self, values: Values) -> float:
        """Relative change, summed over fields."""
        own = {field: self.own(field) for field in values}
        return sum(
            ROW if by_row(field) else abs(log(float(value) / float(own[field]))) for field, value in values.items()
        )

    def _mended(self, values: Values, form: str, reason: Reason) -> Iterator[dict[str, float | str]]:
        """Gives variants in which a reason is gone, one for each way that is free, or for any length where none is."""
        anywhere = False
        for ways in (_free(reason), ANY):
            for way in ways:
                if self.sure.count > MOST_VARIANTS:
                    return
                for one in self._along(values, way):
                    if self._gone(one, form, reason.key):
                        anywhere = True
                        yield one
                        if not by_row(way.fields[0]):
                            break
            if anywhere:
                return

    def _along(self, values: Values, way: Way) -> Iterator[dict[str, float | str]]:
        """Gives variants farther and farther along a way, or one for each row."""
        made = changed(self.design, values)
        assert made is not None
        lead = way.fields[0]
        if by_row(lead):
            yield from ({**values, lead: row} for row in rows_of(made, lead))
            return
        now = value_of(made, lead)
        for share in STEPS if now else ():
            for grows in (True, False) if way.larger is None else (way.larger,):
                first = float(now) * (1.0 + share if grows else 1.0 / (1.0 + share))
                yield {**values, **along(made, way, first)}

    def _gone(self, values: Values, form: str, key: tuple[str, str]) -> bool:
        if form == LIMITS:
            return key not in {one.key for one in self._of(values, form)}
        if form in (SUMS, REACH):
            return key not in {one.key for _, one in self.reasons(values, first=True)}
        return bool(self.sure.gone(values, form, key))

    def _refusing(self, values: Values) -> Iterator[tuple[str, str]]:
        """Gives what refuses a variant; the forms that cost least are asked first."""
        if (made := changed(self.design, values)) is None or impossible_sums(made):
            yield "design", BOUNDS
            return
        try:
            for form in QUICKEST:
                yield from (one.key for one in self._of(values, form))
        except (MechanismError, ValueError, ArithmeticError):
            yield "cube", REACH

    def _passes(self, values: Values) -> bool:
        return next(self._refusing(values), None) is None

    def _taken_back(self, values: dict[str, float | str]) -> dict[str, float | str]:
        """Takes changes back as far as everything passes: rows, all lengths together, then one after the other."""
        for field in [field for field in values if by_row(field)]:
            rest = {name: value for name, value in values.items() if name != field}
            if self._passes(rest):
                values = rest
        fields = [field for field in values if not by_row(field)]
        own, start = {field: float(self.own(field)) for field in fields}, dict(values)

        def back(share: float) -> dict[str, float | str]:
            return start | {f: rounded(own[f] + share * (float(start[f]) - own[f])) for f in fields}

        low, high = 0.0, 1.0
        for _ in range(HALVINGS if len(fields) > 1 else 0):
            middle = (low + high) / 2.0
            low, high = (low, middle) if self._passes(back(middle)) else (middle, high)
        values = back(high) if high < 1.0 else values
        for field in sorted(fields, key=lambda one: -self._size({one: values[one]})):
            values = self._nearest(values, field, own[field])
        return values

    def _nearest(self, values: dict[str, float | str], field: str, own: float) -> dict[str, float | str]:
        """Brings one field as near to its own value as everything passes, in four digits."""
        rest = {name: value for name, value in values.items() if name != field}
        if self._passes(rest):
            return rest
        now = float(values[field])
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


def _contradicted(fault: Contradiction) -> Reason:
    ways = (Way((fault.field,), fault.bound > fault.value),)
    return Reason("design", fault.field, fault.allowed, ways)


def _free(reason: Reason) -> list[Way]:
    """Ways that change nothing that is asked."""
    return [way for way in reason.ways if not any(field.startswith(REQUIRED) for field in way.fields)]


def _broken(design: Design) -> list[Reason]:
    """Limits of the requirements that are not proved over the cube, as far as they need no masses."""
    values = limit_values(design)
    known = [kind.stated(values) for kind in POSE_LIMITS if not kind.needs or values.get(kind.needs) is not None]
    proof = prove(design.geometry, design.workspace, Limits.of(*known), max_boxes=MOST_BOXES)
    return [Reason("mechanism", one.condition, one.verdict) for one in proof.findings if one.verdict != "proved"]


BOUNDS, REACH, SUMS, LIMITS = "bounds", "reach", "sums", "limits"
UNREACHED = larger(FOREARM), larger(ARM), larger(BOTTOM), smaller(BOTTOM)
RANKS = {BOUNDS: 9, SUMS: 4, REACH: 3, MODE: 2, PARTS: 2}
"""How far a variant is from being judged as a whole, by the form that refuses it; 1: it is."""
SLOW = {"sector beside a neighbour's": 1, "motor_screw key": 2}
"""Forms that cost most, last."""
QUICKEST = (MODE, *ALONE, PARTS, LIMITS, *sorted(FORMS, key=lambda form: SLOW.get(form, 0)))
