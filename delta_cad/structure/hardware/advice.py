"""All reasons at once, and values that mend them together: what each asks for is followed until none is left."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from time import process_time

from pydantic import ValidationError

from delta_cad.design import Design, design_to_dict
from delta_cad.design.sums import Contradiction, impossible_sums
from delta_cad.dimensions import Reason
from delta_cad.dimensions.neighbours import SWING_FIELD
from delta_cad.dimensions.rules import down, up
from delta_cad.mechanism import MechanismError
from delta_cad.passing.folding import ELBOW_FIELD
from delta_cad.structure.hardware.refusals import SURE, refusals

ROUNDS = 9  # of following: what goes round in circles has done so by then
SECONDS = 25.0  # of the processor after which nothing more is followed: many reasons take eight to ten
DESIGN = "design"  # in place of a part: numbers that cannot go together
AGAIN = 1.005  # times a value that is asked for once more: what follows of each other closes in slowly
BEYOND = 1e-6  # of a bound that must not be met
OF_LENGTHS = ELBOW_FIELD, SWING_FIELD  # limits that mend nothing themselves: other lengths keep them
LESS = "requirements."  # gives way downwards where nothing else does

PEAKS = ("peak_force_N", "force_N"), ("peak_torque_N_m", "joint_torque_N_m")  # of a moment, for ever

Values = dict[str, float | str]


@dataclass(frozen=True)
class Advice:
    """Why a design's hardware cannot do, and what would.

    Attributes:
        reasons: Those of the design as it is.
        then: Those that come once the first are mended as they ask, each once.
        together: Field -> value, with which no reason is left; empty where following them led to none.
    """

    reasons: tuple[Reason, ...]
    then: tuple[Reason, ...] = ()
    together: Mapping[str, float | str] | None = None


def advice(design: Design, tell: Callable[[tuple[Reason, ...]], None] | None = None) -> Advice:
    """Gives every reason why a design's hardware cannot do, in closed form, and values that mend all of them.

    Where values do that, what they mend is held to more than is necessary, as long as there is time, so that solids
    pass, too; what needs no mending is not.

    Args:
        design: A design; numbers that cannot go together are the first reasons.
        tell: Is called with the first reasons, if any, before what they ask for is followed.

    Raises:
        UnreachableError: A point of the cube is out of reach.
    """
    start, first = process_time(), (*_faults(design), *refusals(design))
    if first and tell is not None:
        tell(first)
    told, reasons, values = {_key(one): one for one in first}, first, Values()
    enough = Values()
    ways: dict[str, bool] = {}  # field -> whether it was asked to be larger
    for _ in range(ROUNDS):
        moved = _mending(reasons, values, ways)
        if not moved or process_time() - start > SECONDS:
            break
        values |= moved
        values |= _for_ever(design, values)
        try:
            changed = _changed(design, values)
            reasons = _reasons(changed)
            if not reasons:
                enough = dict(values)
                reasons = tuple(one for one in refusals(changed, SURE) if _key(one) in told)
        except (MechanismError, ValidationError, ValueError, ArithmeticError):
            break
        told = {_key(one): one for one in reasons} | told
        if not reasons:
            break
    return Advice(first, _later(told.values(), first), enough)


def _reasons(design: Design) -> tuple[Reason, ...]:
    """Gives what is wrong with a design on the way to one that does: of numbers that cannot go together those alone."""
    faults = _faults(design)
    try:
        return (*faults, *refusals(design))
    except (MechanismError, ValueError, ArithmeticError):
        if not faults:
            raise
        return faults


def _key(reason: Reason) -> tuple[str, str]:
    return reason.part, reason.feature


def _faults(design: Design) -> tuple[Reason, ...]:
    """Gives why a design's numbers cannot go together, as its file would be refused."""
    return tuple(
        Reason(DESIGN, one.field, f"{one.field} = {one.value:g} {one.allowed}", one.field, one.value, _beyond(one))
        for one in impossible_sums(design)
    )


def _beyond(fault: Contradiction) -> float:
    """A bound, and a little more: some must not be met."""
    return fault.bound * (1.0 + BEYOND if fault.bound > fault.value else 1.0 - BEYOND)


def _later(told: Iterable[Reason], first: tuple[Reason, ...]) -> tuple[Reason, ...]:
    return tuple(one for one in told if one not in first)


def _for_ever(design: Design, values: Values) -> Values:
    """Gives what lasts no more than what a moment bears: a peak that is lowered takes what is held for ever with it."""
    given, lowered = design.requirements, Values()
    for peak, lasting in PEAKS:
        most = values.get(f"requirements.{peak}")
        held = values.get(f"requirements.{lasting}", getattr(given, lasting))
        if isinstance(most, float) and isinstance(held, float) and held > most:
            lowered[f"requirements.{lasting}"] = most
    return lowered


def _mending(reasons: tuple[Reason, ...], values: Values, ways: dict[str, bool]) -> Values:
    """Gives fields and the values that reasons ask for, which they do not have yet.

    Args:
        reasons: What is wrong.
        values: What was asked for before.
        ways: Field -> whether it was asked to be larger; what is asked now is added. A field that was moved the other
            way keeps its value where another does instead, else it is moved back: what moved it asks once more, and
            takes another.
    """
    asked: Values = {}
    for one in reasons:
        for field, value, larger in _asked(one, ways):
            if isinstance(value, float) and field in values and ways.get(field) == larger:
                value = float(up(value * AGAIN)) if larger else float(down(value / AGAIN))
            held = asked.get(field)
            if not isinstance(held, float) or not isinstance(value, float) or (value > held) == larger:
                asked[field] = value
                ways[field] = larger
    return {field: value for field, value in asked.items() if values.get(field) != value}


def _asked(reason: Reason, ways: dict[str, bool]) -> Iterator[tuple[str, float | str, bool]]:
    """Gives the fields that a reason asks for, each with its value and whether that is a least one.

    What is to be had instead is asked for where the field was moved the other way, and where no row has the bound.
    """
    turned = False
    other = None if reason.instead is not None and reason.instead[0] in OF_LENGTHS else reason.instead
    if isinstance(reason.bound, float) and isinstance(reason.value, float | int):
        field, bound, larger = reason.field, reason.bound, reason.bound > reason.value
        turned = ways.get(field, larger) != larger and other is not None
        if not turned:
            yield field, float(up(bound) if larger else down(bound)), larger
    elif not reason.beside:
        turned = other is not None
    if turned and other is not None:
        field, bound = other
        larger = not field.startswith(LESS)
        yield field, float(up(bound) if larger else down(bound)), larger
    for field, value in reason.beside:
        yield field, value if isinstance(value, str) else float(up(value)), True


def _changed(design: Design, values: Values) -> Design:
    """The design with some fields changed, its own parts kept.

    Raises:
        ValidationError: A value is out of its field's bounds.
    """
    rooms: dict[str, Values] = {}
    for field, value in values.items():
        room, _, name = field.partition(".")
        rooms.setdefault(room, {})[name] = value
    changed = design.model_copy(
        update={room: getattr(design, room).model_copy(update=given) for room, given in rooms.items()}
    )
    Design.model_validate(design_to_dict(changed))
    return changed
