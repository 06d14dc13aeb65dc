"""The three steps of [RCIM2018] table 1 as problems: variables, bounds, scaling, objective and constraint margins.

Every margin is continuous, without unit, and met where it is >= 0. Step 1 asks for reach and outline alone, as the
paper does; the torque and all of `[limits]` join from step 2 on. What a step reaches bounds the half side of the next
in the search, not in the proof.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism.limits import (
    LIMITS,
    AssemblyMode,
    Kappa,
    Limit,
    Limits,
    Outline,
    PoseLimit,
    WristClearance,
)
from delta_cad.mechanism.limits.limit import Values
from optimizer.problem.evaluator import Figures, figures
from optimizer.problem.requirements import Requirements
from optimizer.problem.variables import PER_SI, PLATFORM, SIDE, VARIABLES, completed, is_symmetric

# All constraints, in the order in which reports name them.
CONSTRAINTS = (*(limit.name for limit in LIMITS), "half_side")
TINY_MM = 1e-3  # a half side below this is no cube: lengths are given in whole micrometres


class ProblemError(ValueError):
    """A step that cannot be posed; the message says what is missing."""


@dataclass(frozen=True)
class Problem:
    """One step.

    Attributes:
        requirements: What the customer gave.
        step: 1, 2 or 3.
        lower: (9,) lower bounds in the order of `VARIABLES`, mm; of the cosine without unit.
        upper: (9,) upper bounds, likewise.
        constraints: Names of the constraints, in the order of `CONSTRAINTS`.
    """

    requirements: Requirements
    step: int
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    constraints: tuple[str, ...]

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the variables whose bounds differ."""
        return tuple(VARIABLES[k] for k in self.free_index)

    @property
    def free_index(self) -> tuple[int, ...]:
        """Places of the free variables among the nine."""
        return tuple(k for k in range(len(VARIABLES)) if self.lower[k] < self.upper[k])

    @property
    def symmetric(self) -> bool:
        """Whether every design within the bounds is placed as a three-fold symmetric machine."""
        return is_symmetric(self.lower) and is_symmetric(self.upper)

    @property
    def objective_name(self) -> str:
        """`half_side` (largest) in steps 1 and 2, `kappa` (smallest) in step 3."""
        return "kappa" if self.step == 3 else "half_side"

    @cached_property
    def limits(self) -> tuple[Limit, ...]:
        """The limits among the constraints, with their thresholds."""
        values = self.requirements.values
        stated = (limit.stated(values) for limit in LIMITS if limit.name in self.constraints)
        return tuple(limit for limit in stated if limit is not None)

    def pose_limits(self, kappa: float = math.inf) -> Limits:
        """Gathers the limits on every position of the cube that a proof takes.

        Args:
            kappa: Largest condition number to ask for beside the limit.

        Returns:
            The limits; the assembly mode, too, wherever one of them grows without bound towards its end.

        Raises:
            GeometryError: A number that the proof does not take.
        """
        found = [limit for limit in self.limits if isinstance(limit, PoseLimit) and limit.enclosure.cut is not None]
        known = [limit.kappa_max for limit in found if isinstance(limit, Kappa)]
        if kappa < math.inf:
            found.append(Kappa(min([kappa, *known])))
        singular = any(limit.infinite_at_singularity for limit in found)
        return Limits.of(*found, AssemblyMode() if singular else None)

    @cached_property
    def _bounds(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """All lower bounds, the lower and the upper of the free variables, mm, and which these are."""
        lower, upper, index = np.array(self.lower), np.array(self.upper), np.array(self.free_index, dtype=int)
        return lower, lower[index], upper[index], index

    @cached_property
    def _in_points(self) -> tuple[tuple[PoseLimit, ...], frozenset[str]]:
        """The limits that hold in a point of the cube, and what all limits evaluate."""
        held = tuple(limit for limit in self.limits if isinstance(limit, PoseLimit) and limit.enclosure.cut is not None)
        return held, frozenset(name for limit in self.limits for name in limit.evaluates)

    @property
    def torque_for_force(self) -> float:
        """Joint torque that remains after the gravity allowance, N m."""
        return self.requirements.requirements.joint_torque_N_m - self.requirements.limits.gravity_torque_N_m

    def designs(self, x: np.ndarray) -> np.ndarray:
        """Computes designs from scaled variables.

        Args:
            x: (D, number of free variables), 0 at the lower bound and 1 at the upper.

        Returns:
            (D, 9) in the order of `VARIABLES`, SI units.
        """
        fixed, lower, upper, index = self._bounds
        full = np.empty((len(x), len(fixed)))
        full[:] = fixed
        # the bound itself, not a rounding beside it
        full[:, index] = np.where(x == 1.0, upper, lower + x * (upper - lower))
        return full / PER_SI

    def lengths_mm(self, x: ArrayLike) -> tuple[float, ...]:
        """Computes the variables of one design from the scaled ones, within the bounds to the last bit.

        Args:
            x: (number of free variables) scaled.

        Returns:
            (9) in the order of `VARIABLES`, mm; the cosine without unit.
        """
        mm = self.designs(np.asarray(x)[None])[0] * PER_SI  # metres and back may leave a bound by a rounding
        return tuple(float(v) for v in np.clip(mm, self.lower, self.upper))

    def scaled(self, design_mm: ArrayLike) -> np.ndarray:
        """Scales the free variables of a design to 0 to 1; what is out of bounds is moved to the nearer bound.

        Args:
            design_mm: (9,) in the order of `VARIABLES`, mm; or (6,), three-fold symmetric.

        Returns:
            (number of free variables,).
        """
        lower, upper = np.array(self.lower), np.array(self.upper)
        index = list(self.free_index)
        return np.clip((completed(design_mm)[index] - lower[index]) / (upper - lower)[index], 0.0, 1.0)

    def figures(self, designs: np.ndarray, points: np.ndarray) -> Figures:
        """Computes the figures that this step needs; `quality` and the angles only where a limit evaluates them."""
        _, evaluated = self._in_points
        return figures(designs, points, self.step == 3 or "quality" in evaluated, "angles" in evaluated)

    def point_margins(self, f: Figures) -> dict[str, np.ndarray]:
        """Computes the margins that hold in a point of the cube.

        Args:
            f: Figures of D designs at K points.

        Returns:
            Name of the constraint -> (D, K); those that hold for the cube in closed form are left out.
        """
        return {limit.name: limit.margin(f) for limit in self._in_points[0]}

    def design_margins(self, designs: np.ndarray) -> dict[str, np.ndarray]:
        """Computes the margins in closed form, the same in the whole cube.

        Args:
            designs: (D, 9) in the order of `VARIABLES`, SI units; or (D, 6), three-fold symmetric.

        Returns:
            Name of the constraint -> (D,).
        """
        rows = completed(designs).T * PER_SI[:, None]
        found = {limit.name: limit.design_margin(rows) for limit in self.limits}
        return {name: margin for name, margin in found.items() if margin is not None}

    def smooth_design_margins(self, designs: np.ndarray) -> list[np.ndarray]:
        """Computes what `design_margins` does for a descent: where the placement is free in smooth parts.

        Args:
            designs: (D, 9) in the order of `VARIABLES`, SI units.

        Returns:
            (D,) margins, one or several a limit.
        """
        if self.symmetric:
            return list(self.design_margins(designs).values())
        rows = designs.T * PER_SI[:, None]
        parts = (limit.smooth_margins(rows) for limit in self.limits)
        return [margin for found in parts if found is not None for margin in found]

    def describe(self, name: str) -> str:
        """Describes a constraint, with the field of the requirements file that states it."""
        if name == "half_side":
            half = self.requirements.step_3.half_side_mm
            if self.step == 3:
                return "half side that step 2 reached" if half is None else f"step_3.half_side_mm = {half:g} mm"
            return f"bounds_mm.half_side >= {self.requirements.bounds_mm.half_side[0]:g} mm"
        values = self.requirements.values
        limit = next(limit for limit in LIMITS if limit.name == name).stated(values)
        return limit.describe(values) if limit is not None else name


def outline_of(given: Requirements) -> Outline:
    """Gives the outline that requirements allow."""
    return Outline.stated(given.values)


def step_problem(
    given: Requirements, step: int, reached_mm: float | None = None, without: frozenset[str] = frozenset()
) -> Problem:
    """Poses one of the three steps.

    Args:
        given: What the customer gave.
        step: 1 or 2 (largest half side), or 3 (smallest worst condition number at a half side that is fixed).
        reached_mm: Half side that the step before reached: at most this in step 2; in step 3 exactly this, unless
            `step_3.half_side_mm` is given. None where no step came before. A proof of step 2 takes what step 1 is
            proved not to exceed instead: what a search reached bounds no design.
        without: Names of constraints to leave out, of `CONSTRAINTS`.

    Raises:
        ProblemError: There is no such step or constraint, or step 3 has no half side, or one of 0.
    """
    if step not in (1, 2, 3):
        raise ProblemError(f"step is {step!r}; it must be 1, 2 or 3")
    unknown = sorted(set(without) - set(CONSTRAINTS))
    if unknown:
        raise ProblemError(f"there is no constraint {unknown[0]!r}; known: {', '.join(CONSTRAINTS)}")
    bounds = list(given.ranges)
    low, high = bounds[SIDE]
    if step == 3:
        side = given.step_3.half_side_mm if given.step_3.half_side_mm is not None else reached_mm
        if side is None:
            raise ProblemError("step 3 needs step_3.half_side_mm or what step 2 reached")
        if side <= 0.0:
            raise ProblemError(f"step 3 needs a cube; its half side is {side:g} mm")
        low = high = side
    elif reached_mm is not None:
        high = min(high, max(low, reached_mm))
    bounds[SIDE] = (0.0 if "half_side" in without else low, high)
    values = given.values
    stated = {"half_side": step == 3 or low > 0.0}
    for limit in LIMITS:
        required = limit.stated(values) if step > 1 or limit.first_step else None
        stated[limit.name] = required is not None and not (
            limit.of_every_design and _implied(required, bounds, step, values)
        )
    names = tuple(name for name in CONSTRAINTS if stated.get(name) and name not in without)
    return Problem(given, step, tuple(b[0] for b in bounds), tuple(b[1] for b in bounds), names)


def _implied(limit: Limit, bounds: list[tuple[float, float]], step: int, values: Values) -> bool:
    """Tells whether the bounds, or a clearance limit, already imply a limit that holds for every design."""
    room = WristClearance.stated(values) if step > 1 else None
    least = 0.0 if room is None else room.design_bounds().platform_radius_min_mm
    ends = [(max(b[0], least), max(b[1], least)) if k == PLATFORM else b for k, b in enumerate(bounds)]
    margins = limit.design_margin(np.array(list(product(*(dict.fromkeys(b) for b in ends)))).T)
    return margins is not None and bool((margins >= 0.0).all())
