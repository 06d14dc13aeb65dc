"""The whole machine: every part placed on its link, and where each link is at any handle position."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from delta_cad.assembly.order.record import Unit
from delta_cad.mechanism.placement import LinkPlacement
from delta_cad.solids.part import (
    Contact,
    Fit,
    Joint,
    Occurrence,
    Part,
    Reach,
    Removal,
    Stop,
    Supply,
)


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
    supplies: tuple[Supply, ...] = ()
    reached: tuple[Reach, ...] = ()
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
