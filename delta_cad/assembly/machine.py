"""The records of a machine: every part on its link, where each link is at any position, how it is put together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf

import numpy as np

from delta_cad.mechanism.placement import LinkPlacement
from delta_cad.solids.part import (
    Consumable,
    Contact,
    Fit,
    Joint,
    Occurrence,
    Part,
    Removal,
    Stop,
    ToolAccess,
)


@dataclass(frozen=True)
class PathSegment:
    """A straight piece of the way of a part to its seat.

    Attributes:
        along: Unit vector of the motion, in the frame that `Insertion` names.
        length_mm: How long it goes on so; infinite for the first one, which begins outside.
    """

    along: tuple[float, float, float]
    length_mm: float = inf


@dataclass(frozen=True)
class Insertion:
    """What comes in together, and how.

    Attributes:
        names: Names of the occurrences.
        path: The one that ends in the seat last; none for the first part of a unit, and for what is flexible.
        frame: Occurrence in whose frame the path is stated; "" for the first of `names`.
        units: Names of units, finished before, which come in whole beside `names`.
        is_flexible: Whether it is flexible, a cable or a spring, and is laid or hooked in by hand.
    """

    names: tuple[str, ...] = ()
    path: tuple[PathSegment, ...] = ()
    frame: str = ""
    units: tuple[str, ...] = ()
    is_flexible: bool = False


@dataclass(frozen=True)
class Step:
    """One step, with one picture.

    Attributes:
        title: A few words.
        words: What is done, sentence by sentence.
        insertions: What comes in, in this order.
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
    insertions: tuple[Insertion, ...] = ()
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


@dataclass(frozen=True)
class Assembly:
    """Parts placed on links, and the closed-form motion of the links.

    Attributes:
        name: Name of the design.
        occurrences: All placed parts; parts are shared between occurrences.
        joints: The moving joints.
        fits: Pairs that are meant to be closer than the general clearance.
        placement: Handle position -> link frames.
        home_mm: (3,) handle position in which the assembly is exported, mm.
        contacts: Pairs of which one holds, guides or carries the other.
        stops: Both ends of every joint that a stop holds.
        supplies: What is bought beside the parts.
        reached: Screws that a key must reach in the finished machine.
        removals: Parts that come off it, each in a straight line.
        order: In which it is put together, unit by unit, the machine last.
        dashboard: Names of what hangs on the dashboard over the machine, not on its base; both stand still.
    """

    name: str
    occurrences: tuple[Occurrence, ...]
    joints: tuple[Joint, ...]
    fits: tuple[Fit, ...]
    placement: LinkPlacement
    home_mm: np.ndarray
    contacts: tuple[Contact, ...] = ()
    stops: tuple[Stop, ...] = ()
    supplies: tuple[Consumable, ...] = ()
    reached: tuple[ToolAccess, ...] = ()
    removals: tuple[Removal, ...] = ()
    order: tuple[Unit, ...] = ()
    dashboard: tuple[str, ...] = ()

    @property
    def parts(self) -> tuple[Part, ...]:
        """Each part once, in order of first use."""
        return tuple({occurrence.part.number: occurrence.part for occurrence in self.occurrences}.values())

    def without_solids(self) -> Assembly:
        """Gives the same machine without the kernel's solids, as another process can take it."""
        bare = {part.number: replace(part, solid=None) for part in self.parts}  # type: ignore[arg-type]
        return replace(self, occurrences=tuple(replace(o, part=bare[o.part.number]) for o in self.occurrences))

    def poses(self, p_mm: np.ndarray) -> Mapping[str, np.ndarray]:
        """Computes the transforms of all occurrences at handle positions.

        Args:
            p_mm: (..., 3) platform centre in the base frame, mm.

        Returns:
            Occurrence name -> (..., 4, 4) part frame to base frame, mm.
        """
        links = self.placement(p_mm)
        return {o.name: links[o.link] @ o.placement for o in self.occurrences}
