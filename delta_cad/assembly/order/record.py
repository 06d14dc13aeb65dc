"""The records of the order of assembly: units made on the bench, their steps, what each step brings in and tightens."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf


@dataclass(frozen=True)
class Leg:
    """A straight piece of the way of a part to its seat.

    Attributes:
        along: Unit vector of the motion, in the frame that `Bring` names.
        length_mm: How long it goes on so; infinite for the first leg, which begins outside.
    """

    along: tuple[float, float, float]
    length_mm: float = inf


@dataclass(frozen=True)
class Bring:
    """What comes in together, and how.

    Attributes:
        names: Names of the occurrences.
        legs: The way, the leg that ends in the seat last; none for the first part of a unit, and for what is laid.
        frame: Occurrence in whose frame the legs are stated; "" for the first of `names`.
        units: Names of units, finished before, which come in whole beside `names`.
        is_laid: Whether it is flexible, a cable or a spring, and is laid or hooked in by hand.
    """

    names: tuple[str, ...] = ()
    legs: tuple[Leg, ...] = ()
    frame: str = ""
    units: tuple[str, ...] = ()
    is_laid: bool = False


@dataclass(frozen=True)
class Step:
    """One step, with one picture.

    Attributes:
        title: A few words.
        words: What is done, sentence by sentence.
        brings: What comes in, in this order.
        tightened: Names of the screws that a hexagon key tightens at its end.
        torque_N_m: What they are tightened to where it is not usual for their size; None: as usual.
        tools: What else is needed.
        supplies: Numbers of the adhesives, cords and greases that are used.
        checks: What is looked at before the next step.
        shown: Names of what is there already and is worked upon: a picture colours it.
        unseen: Names of what is there and hides that: a picture leaves it out.
    """

    title: str
    words: tuple[str, ...]
    brings: tuple[Bring, ...] = ()
    tightened: tuple[str, ...] = ()
    torque_N_m: float | None = None
    tools: tuple[str, ...] = ()
    supplies: tuple[str, ...] = ()
    checks: tuple[str, ...] = ()
    shown: tuple[str, ...] = ()
    unseen: tuple[str, ...] = ()


@dataclass(frozen=True)
class Unit:
    """What is put together by itself; the last one is the machine.

    Attributes:
        name: Unique, such as "arm 0".
        kind: What its likes share, such as "arm": the steps of one are told for all.
        title: Heading.
        steps: In their order.
    """

    name: str
    kind: str
    title: str
    steps: tuple[Step, ...]
