"""The three steps of [RCIM2018] table 1 as problems: variables, bounds, scaling, objective and constraint margins.

Every margin is continuous, without unit, and met where it is >= 0. Step 1 asks for reach and outline alone, as the
paper does; the torque and all of `[limits]` join from step 2 on. What a step reaches bounds the half side of the next
in the search, not in the proof.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from optimizer.problem.evaluator import VARIABLES, Figures, figures
from optimizer.problem.requirements import Requirements

MM_PER_M = 1000.0
LEAN_SHARE = (math.sqrt(3.0) + 1.0) / 2.0
"""Largest t over the cube is this times L, in a corner, for chains 1 and 2: `L sin 60 + L cos 60`."""
CONSTRAINTS = ("outline", "reach", "torque", "conditioning", "lean", "shoulder", "clearance", "half_side")
"""All there are, in the order in which reports name them."""
SIDE = VARIABLES.index("half_side")
TINY_MM = 1e-3
"""A half side below this is no cube: lengths are given in whole micrometres."""


class ProblemError(ValueError):
    """A step that cannot be posed; the message says what is missing."""


@dataclass(frozen=True)
class Problem:
    """One step.

    Attributes:
        requirements: What the customer gave.
        step: 1, 2 or 3.
        lower: (6,) lower bounds in the order of `VARIABLES`, mm.
        upper: (6,) upper bounds, mm.
        constraints: Names of the constraints that are asked, in the order of `CONSTRAINTS`.
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
        """Their places among the six."""
        return tuple(k for k in range(len(VARIABLES)) if self.lower[k] < self.upper[k])

    @property
    def objective_name(self) -> str:
        """`half_side` (largest) in steps 1 and 2, `kappa` (smallest) in step 3."""
        return "kappa" if self.step == 3 else "half_side"

    @property
    def needs_quality(self) -> bool:
        """Whether the condition number is asked for at all."""
        return self.step == 3 or "conditioning" in self.constraints

    @property
    def torque_for_force(self) -> float:
        """What is left of a joint's torque beside gravity's share, N m."""
        return self.requirements.requirements.joint_torque_N_m - self.requirements.limits.gravity_torque_N_m

    def designs(self, x: np.ndarray) -> np.ndarray:
        """Scaled variables to designs.

        Args:
            x: (D, number of free variables), 0 at the lower bound and 1 at the upper.

        Returns:
            (D, 6) lengths in the order of `VARIABLES`, m.
        """
        lower, upper = np.array(self.lower), np.array(self.upper)
        full = np.tile(lower, (len(x), 1))
        index = list(self.free_index)
        full[:, index] += x * (upper - lower)[index]
        # the bound itself, not a rounding beside it
        full[:, index] = np.where(x == 1.0, upper[index], full[:, index])
        return full / MM_PER_M

    def scaled(self, design_mm: np.ndarray) -> np.ndarray:
        """The free variables of a design between 0 and 1; what is out of bounds is moved to the nearer bound.

        Args:
            design_mm: (6,) lengths in the order of `VARIABLES`, mm.

        Returns:
            (number of free variables,).
        """
        lower, upper = np.array(self.lower), np.array(self.upper)
        index = list(self.free_index)
        return np.clip((np.asarray(design_mm)[index] - lower[index]) / (upper - lower)[index], 0.0, 1.0)

    def figures(self, designs: np.ndarray, points: np.ndarray) -> Figures:
        """The figures this step needs; `quality` and the angles are left out where nothing asks for them."""
        return figures(designs, points, self.needs_quality, "shoulder" in self.constraints)

    def point_margins(self, f: Figures) -> dict[str, np.ndarray]:
        """Margins that hold in a point of the cube.

        Args:
            f: Figures of D designs at K points.

        Returns:
            Name of the constraint -> (D, K).
        """
        limits, task = self.requirements.limits, self.requirements.requirements
        margins = {}
        if "reach" in self.constraints:
            margins["reach"] = f.closure
        if "torque" in self.constraints:  # det >= F moment / torque >= 0 also refuses every direct singularity
            margins["torque"] = f.determinant - task.force_N / self.torque_for_force * f.moment
        if "conditioning" in self.constraints and limits.kappa_max is not None:
            margins["conditioning"] = f.quality - 1.0 / limits.kappa_max
        if "shoulder" in self.constraints and limits.shoulder_deg is not None:
            low, high = np.radians(limits.shoulder_deg)
            margins["shoulder"] = np.minimum(f.shoulder_min - low, high - f.shoulder_max)
        return margins

    def design_margins(self, designs: np.ndarray) -> dict[str, np.ndarray]:
        """Margins in closed form, the same in the whole cube.

        Args:
            designs: (D, 6) lengths in the order of `VARIABLES`, m.

        Returns:
            Name of the constraint -> (D,).
        """
        limits = self.requirements.limits
        L_A, L_B, R, r, _, L = designs.T * MM_PER_M
        margins = {}
        if "outline" in self.constraints:
            margins["outline"] = outline_margin(self.requirements, R + L_A)[0]
        if "lean" in self.constraints and limits.lean_max_deg is not None:
            margins["lean"] = math.sin(math.radians(limits.lean_max_deg)) - LEAN_SHARE * L / L_B
        if "clearance" in self.constraints and limits.clearance_min_mm is not None:
            # nearest wrists of neighbouring chains are sqrt(3) r - L_c / 2 apart
            room = math.sqrt(3.0) * r - limits.parallelogram_width_mm / 2.0
            margins["clearance"] = (room - limits.joint_diameter_mm - limits.clearance_min_mm) / r
        return margins

    def describe(self, name: str) -> str:
        """A constraint in words, with the field of the requirements file that asks for it."""
        task, limits = self.requirements.requirements, self.requirements.limits
        if name == "outline":
            if limits.outline_radius_max_mm is not None:
                return f"R + L_A <= {limits.outline_radius_max_mm:g} mm (limits.outline_radius_max_mm)"
            return f"outline {task.envelope_width_mm:g} x {task.envelope_depth_mm:g} mm (requirements.envelope_*_mm)"
        low, high = limits.shoulder_deg or (-180.0, 180.0)
        half = self.requirements.step_3.half_side_mm
        side = f"bounds_mm.half_side >= {self.requirements.bounds_mm.half_side[0]:g} mm"
        if self.step == 3:
            side = "half side that step 2 reached" if half is None else f"step_3.half_side_mm = {half:g} mm"
        return {
            "reach": "reach of the whole cube",
            "torque": f"{self.torque_for_force:g} N m for {task.force_N:g} N (requirements.joint_torque_N_m)",
            "conditioning": f"limits.kappa_max = {limits.kappa_max} ",
            "lean": f"limits.lean_max_deg = {limits.lean_max_deg}",
            "shoulder": f"limits.shoulder_deg = [{low:g}, {high:g}]",
            "clearance": f"limits.clearance_min_mm = {limits.clearance_min_mm}",
            "half_side": side,
        }[name].strip()


def outline_size(given: Requirements, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rectangle that a mechanism takes.

    Args:
        given: The requirements, for the parallelogram's width and the hardware's overhead.
        reach: (...) R + L_A, mm.

    Returns:
        (...) width and (...) depth, mm.

    Source:
        [RCIM2018] eq. (1), plus the overhead of the real hardware where it is given.
    """
    limits, reach = given.limits, np.asarray(reach)
    width = limits.parallelogram_width_mm * 0.5 + math.sqrt(3.0) * reach + limits.outline_overhead_mm[0]
    depth = limits.parallelogram_width_mm * math.sqrt(3.0) / 4.0 + 1.5 * reach + limits.outline_overhead_mm[1]
    return width, depth


def outline_margin(given: Requirements, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far the outline is inside what is allowed, as a share of it.

    Args:
        given: The requirements; `limits.outline_radius_max_mm` replaces the rectangle where it is given.
        reach: (...) R + L_A, mm.

    Returns:
        (...) margin; (...) whether the rectangle is turned: eq. (1)'s W along the requirements' depth.

    Source:
        [RCIM2018] eq. (1), by `outline_size`.
    """
    limits, task = given.limits, given.requirements
    width, depth = outline_size(given, reach)
    reach, W, D = np.asarray(reach), task.envelope_width_mm, task.envelope_depth_mm
    straight = np.minimum((W - width) / W, (D - depth) / D)
    turned = np.minimum((D - width) / D, (W - depth) / W)
    if limits.outline_radius_max_mm is not None:
        return (limits.outline_radius_max_mm - reach) / limits.outline_radius_max_mm, turned > straight
    return np.maximum(straight, turned), turned > straight


def step_problem(
    given: Requirements, step: int, reached_mm: float | None = None, without: frozenset[str] = frozenset()
) -> Problem:
    """One of the three steps.

    Args:
        given: What the customer gave.
        step: 1 or 2 (largest half side), or 3 (smallest worst condition number at a half side that is fixed).
        reached_mm: Half side that the step before reached: at most this in step 2; in step 3 exactly this, unless
            `step_3.half_side_mm` is given. None where no step came before. A proof of step 2 takes what step 1 is
            proved not to exceed instead: what a search reached bounds no design.
        without: Names of constraints to leave out, of `CONSTRAINTS`.

    Returns:
        The problem.

    Raises:
        ProblemError: There is no such step or constraint, or step 3 has no half side, or one of 0.
    """
    if step not in (1, 2, 3):
        raise ProblemError(f"step is {step!r}; it must be 1, 2 or 3")
    unknown = sorted(set(without) - set(CONSTRAINTS))
    if unknown:
        raise ProblemError(f"there is no constraint {unknown[0]!r}; known: {', '.join(CONSTRAINTS)}")
    bounds = [getattr(given.bounds_mm, name) for name in VARIABLES]
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
    limits = given.limits
    asked = {"outline": True, "reach": True, "half_side": step == 3 or low > 0.0}
    if step > 1:
        asked |= {
            "torque": True,
            "conditioning": limits.kappa_max is not None,
            "lean": limits.lean_max_deg is not None,
            "shoulder": limits.shoulder_deg is not None,
            "clearance": limits.clearance_min_mm is not None,
        }
    names = tuple(name for name in CONSTRAINTS if asked.get(name) and name not in without)
    return Problem(given, step, tuple(b[0] for b in bounds), tuple(b[1] for b in bounds), names)
