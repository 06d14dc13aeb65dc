"""What viewers set, the task that follows from it, and the lengths that were found for one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from optimizer.codesign.corrections import Corrections
from optimizer.codesign.hardware import Selection
from optimizer.codesign.lengths import lengths_problem, taken_mm, to_requirements
from optimizer.problem.brief import DesignBrief, Goal
from optimizer.problem.step import Problem

_OPEN_MM = 2.0  # of a platform radius and of R + L_A, between bounds that leave a range to search
_INSIDE = 0.9  # of R + L_A, in a platform's radius, as `best_lengths` bounds it
_SHARES = "mass_share", "friction_share", "step_share"
_SHARE_ROOM = 0.998  # of these at first, which is a room that the search leaves

Key = tuple[str, str, bool]
"""Motor, drive, and whether chains are placed for the outline: what is learnt of one is not of another."""


@dataclass(frozen=True)
class Task:
    """One setting: the requirements, and the hardware that is looked at."""

    brief: DesignBrief
    choice: Selection

    @property
    def key(self) -> Key:
        """What corrections are kept under."""
        return self.choice.motor, self.choice.drive, self.choice.placed

    @property
    def least(self) -> bool:
        """Whether the least machine is sought, and not the largest cube."""
        return self.brief.objective != "cube_side"


@dataclass(frozen=True)
class Solved:
    """Lengths for a task.

    Attributes:
        task: The task.
        corrections: What was known of its hardware.
        lengths_mm: (9) in the order of `VARIABLES`.
        size: Of a least machine: R + L_A in mm, or effective mass in kg, at which its cube was sought; else None.
        side_mm: Side of the cube that was found at that size.
    """

    task: Task
    corrections: Corrections
    lengths_mm: tuple[float, ...]
    size: float | None
    side_mm: float

    @property
    def brief(self) -> DesignBrief:
        """The task whose largest cube these lengths have."""
        return of_size(self.task.brief, self.size)

    def problem(
        self, exact: bool = False, brief: DesignBrief | None = None, choice: Selection | None = None
    ) -> Problem:
        """Poses the problem that these lengths solve.

        Args:
            exact: Whether limits are those of the task; else the search's, which leave room for roundings.
            brief: Another task.
            choice: Other hardware.
        """
        task, chosen, known = brief or self.brief, choice or self.task.choice, self.corrections
        arm, forearm, *_ = self.lengths_mm
        inertia = known.mass_estimate.inertia(arm, forearm, chosen.ratio)
        if exact:
            known = replace(known, **{name: getattr(known, name) / _SHARE_ROOM for name in _SHARES})
        posed = to_requirements(task, chosen, known.at_arm_length(arm), inertia, far=chosen if exact else None)
        return lengths_problem(posed, chosen, known)

    @property
    def outline_mm(self) -> tuple[float, float]:
        """Width and depth of the machine: eq. (1), or of placed chains the outline allowed, with what parts take."""
        if self.task.choice.placed and self.task.brief.outline_mm is not None:
            return self.task.brief.outline_mm
        return taken_mm(self.task.choice, self.corrections, self.lengths_mm[0] + self.lengths_mm[2])


def of_size(brief: DesignBrief, size: float | None) -> DesignBrief:
    """Gives the task of the largest cube in place of a least machine's, whose size is a limit; else the same.

    Args:
        brief: The task.
        size: See `Solved.size`; None for the task unchanged.
    """
    if size is None:
        return brief
    goal = Goal(maximize="cube_side")
    eased = brief.model_copy(
        update={"goal": goal, "requirements": brief.requirements.model_copy(update={"cube_side_mm": None})}
    )
    if brief.objective == "effective_mass":
        return eased.with_values({"feel.effective_mass_max_kg": size})
    low, high = brief.bounds_mm.platform_radius or (0.0, math.inf)
    high = max(low + _OPEN_MM, min(high, _INSIDE * size))
    bounds = brief.bounds_mm.model_copy(update={"platform_radius": (low, high)})
    return eased.model_copy(update={"bounds_mm": bounds}).with_values({"limits.outline_radius_max_mm": size})


@dataclass(frozen=True)
class Setting:
    """What viewers set.

    Attributes:
        values: Table and field -> value of its slider; None where there is no such limit.
        choice: Hardware.
        by: Viewer and number of its message; ("", 0) of the page itself.
        rest: Whether the slider was let go.
    """

    values: Mapping[str, float | None]
    choice: Selection
    by: tuple[str, int] = ("", 0)
    rest: bool = False

    @property
    def signature(self) -> tuple[Any, ...]:
        """What computed results depend on."""
        return tuple(sorted(self.values.items(), key=str)), repr(self.choice)
