"""What the studio computes for one setting of its sliders: lengths from where the last ones were, what binds, a proof.

The lengths are those of `best_lengths`. Of a task that asks for the least machine the largest cube of one size of it is
sought, and the size follows by a step of Newton's for each answer, whose slope is the multiplier of that limit.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.limits import Limits
from delta_cad.mechanism.proof.extremes import worst_figures
from delta_cad.mechanism.proof.prove import prove
from optimizer.codesign.candidate import first_corrections
from optimizer.codesign.corrections import Corrections
from optimizer.codesign.hardware import Selection, drives, first_ratios, price_EUR, unlikely, widths_of
from optimizer.codesign.lengths import ENOUGH, ROUNDS, best_lengths
from optimizer.problem.brief import DesignBrief
from optimizer.problem.validation import RequirementsError
from optimizer.problem.variables import COSINE, LENGTHS, PER_SI, SIDE, completed, mechanism_of, named
from optimizer.studio.sensitivity import sensitivity
from optimizer.studio.setting import Key, Solved, Task, of_size

_HALF_MM, _HALF_DEG = 5e-4, 5e-5  # of the last digit of lengths and azimuth
_HELD = 1e-6  # share of a limit to which a search keeps it
_STEPS = 8  # of Newton's until a cube that is set has its size of machine
_CLOSE = 5e-4  # share of a score below which two are the same

_STEP = 1.6  # factor by which a step of Newton's changes the size at most


@dataclass(frozen=True)
class Proved:
    """What `prove` and the closed forms come to for lengths.

    Attributes:
        holds: Whether every limit is proved over the cube, and every closed form holds.
        open: Names of the limits that are not.
        boxes: Boxes that the proof took.
    """

    holds: bool
    open: tuple[str, ...]
    boxes: int


class Solver:
    """Finds lengths, one task after the other, each from those of the last.

    Attributes:
        known: Motor, drive and placement -> what closed forms of the parts require.
        last: The last lengths that were found.
    """

    def __init__(self) -> None:
        self.known: dict[Key, Corrections] = {}
        self.last: Solved | None = None

    def corrections(self, task: Task) -> Corrections:
        """Gives what is known of the hardware of a task."""
        return self.known.get(task.key) or first_corrections(task.brief, task.choice)

    def move(self, task: Task, tick: Callable[[], None] = lambda: None) -> Solved | None:
        """Finds lengths while sliders move: from the last ones, with the masses of those.

        Args:
            task: The task.
            tick: Called now and then; what it raises ends the search.

        Returns:
            The lengths; None where there are none near the last, or no last ones.
        """
        return None if self.last is None else self._found(task, self.last, 1, tick)

    def settle(self, task: Task, tick: Callable[[], None] = lambda: None) -> Solved | None:
        """Finds lengths as exactly as `best_lengths` does, from the last ones or, where these fail, from nothing."""
        found = None if self.last is None else self._found(task, self.last, ROUNDS, tick)
        return found or self._found(task, None, ROUNDS, tick)

    def _found(self, task: Task, last: Solved | None, rounds: int, tick: Callable[[], None]) -> Solved | None:
        find = self._least if task.least else self._largest
        found = find(task, last, rounds, tick)
        self.last = found or self.last
        return found

    def _least(self, task: Task, last: Solved | None, rounds: int, tick: Callable[[], None]) -> Solved | None:
        """The least machine with the cube required: one step of Newton's, or as many as it takes."""
        side, now = task.brief.requirements.cube_side_mm or 0.0, last
        if now is None or now.size is None or now.task.brief.objective != task.brief.objective:
            return cold(task, self.corrections(task), tick)
        size, tried = now.size, list[tuple[float, float]]()
        for _ in range(1 if rounds == 1 else _STEPS):
            at = self._largest(task, now, rounds, tick, size)
            if at is None:
                return None
            now = at
            tried.append((size, at.side_mm))
            if side <= at.side_mm <= side * (1.0 + ENOUGH):
                break
            slope = self._slope(at, tried)
            if not slope > 0.0:
                return None
            step = (side * (1.0 + ENOUGH / 2.0) - at.side_mm) / slope
            size = min(max(size + step, size / _STEP), size * _STEP)
        if rounds == 1:  # the lengths follow in the next answer; the size is known to first order now
            return replace(now, size=size)
        if not side <= now.side_mm <= side * (1.0 + 2.0 * ENOUGH):
            return None
        return replace(now, lengths_mm=tuple(side / 2.0 if k == SIDE else v for k, v in enumerate(now.lengths_mm)))

    def _largest(
        self, task: Task, last: Solved | None, rounds: int, tick: Callable[[], None], size: float | None = None
    ) -> Solved | None:
        """The largest cube; while sliders move the last lengths, where they are its optimum still."""
        known = self.corrections(task)
        if rounds == 1 and last is not None and (last.task.key, last.size) == (task.key, size):
            same = replace(last, task=task, corrections=known)
            with suppress(RequirementsError):
                if sensitivity(same).is_optimum:
                    return same
        start = None if last is None else last.lengths_mm
        found = best_lengths(of_size(task.brief, size), task.choice, known, start, rounds=rounds, tick=tick)
        return None if found is None else Solved(task, known, found.lengths_mm, size, found.side_mm)

    @staticmethod
    def _slope(at: Solved, tried: list[tuple[float, float]]) -> float:
        """How the cube's side grows with the size: by the last two, or by the limit's multiplier."""
        if len(tried) > 1 and tried[-1][0] != tried[-2][0]:
            return (tried[-1][1] - tried[-2][1]) / (tried[-1][0] - tried[-2][0])
        name = "feel.effective_mass_max_kg" if at.task.brief.objective == "effective_mass" else None
        return sensitivity(at).price(name or "limits.outline_radius_max_mm") or 0.0


def cold(task: Task, known: Corrections, tick: Callable[[], None] = lambda: None) -> Solved | None:
    """Finds the lengths of a task from nothing, by `best_lengths`."""
    found = best_lengths(task.brief, task.choice, known, tick=tick)
    if found is None:
        return None
    size = None
    if task.least:
        size = -found.score if task.brief.objective == "effective_mass" else found.lengths_mm[0] + found.lengths_mm[2]
    return Solved(task, known, found.lengths_mm, size, found.side_mm)


def is_better(found: Solved, now: Solved) -> bool:
    """Decides whether lengths are better than others of the same task by more than they are found to."""
    if found.size is not None and now.size is not None:
        return found.size < now.size * (1.0 - 2.0 * ENOUGH)
    return found.side_mm > now.side_mm * (1.0 + _CLOSE)


def certify(found: Solved) -> Proved:
    """Proves every limit of the task over the whole cube, and measures every figure.

    The limits are those of the task, without the room that the search leaves; masses are estimated from the lengths,
    and a closed form holds within what the rounding of each length changes of it at most.
    """
    problem = found.problem(exact=True)
    g, cube = mechanism_of(found.lengths_mm)
    proof = prove(g, cube, problem.pose_limits())
    left = [one.condition for one in proof.findings if one.verdict != "proved"]
    lengths = completed(found.lengths_mm)
    steps = np.full(len(lengths), _HALF_MM)
    steps[COSINE] = math.radians(_HALF_DEG) * math.sqrt(1.0 - lengths[COSINE] ** 2)
    if problem.symmetric:  # whose placement is exact
        steps[len(LENGTHS) :] = 0.0
    rounded = np.vstack([lengths, lengths + np.diag(steps), lengths - np.diag(steps)])
    for name, (own, *others) in problem.design_margins(rounded / PER_SI).items():
        changes = np.abs(np.reshape(others, (2, -1)) - own).max(axis=0)
        left += [name] if own < -changes.sum() - _HELD else []
    return Proved(not left, tuple(dict.fromkeys(left)), proof.boxes)


def figures_of(found: Solved) -> dict[str, tuple[float, str]]:
    """Measures every figure of a machine at its worst over the cube.

    Returns:
        Name of the figure -> value in people's unit, and that unit; masses and friction are estimates.
    """
    values = found.problem(exact=True).requirements.values
    g, cube = mechanism_of(found.lengths_mm)
    measured = worst_figures(g, cube, Limits.measured(values))
    return {one.figure.name: (one.value * one.figure.scale, one.figure.unit) for one in measured if one.figure.name}


def price_of(found: Solved) -> float:
    """Estimates the price of one machine, EUR."""
    return price_EUR(found.task.brief, found.task.choice, found.lengths_mm)


def hardware_of(brief: DesignBrief) -> list[Selection]:
    """Lists the hardware that is looked at: of each motor and drive some ratios and widths of the parallelograms."""
    found: list[tuple[int, Selection]] = []
    # of a cube that is set the strongest has lengths, if any has
    judged = brief.with_values({"feel.effective_mass_max_kg": None}) if brief.objective != "cube_side" else brief
    for motor, drive in sorted(drives(brief), key=lambda one: unlikely(judged, one)):
        ratios = first_ratios(brief, drive)
        middle = sorted(ratios, key=lambda ratio: abs(ratio - ratios[len(ratios) // 2]))
        choices = [(width, ratio) for width in widths_of(brief) for ratio in middle]
        found += [
            (k, Selection(motor, drive, ratio, width, placed=brief.placeable))
            for k, (width, ratio) in enumerate(choices)
        ]
    return [choice for _, choice in sorted(found, key=lambda one: one[0])]  # a middle ratio of each motor is first


def lengths_of(found: Solved) -> dict[str, float]:
    """Names the lengths as a design file does, mm and degrees."""
    return {name: round(value, 3) for name, value in named(found.lengths_mm).items()}


def geometry_of(found: Solved) -> dict[str, object]:
    """Gives what the page moves the mechanism with, as `assets/kinematics.js` of the report takes it."""
    g, cube = mechanism_of(found.lengths_mm)
    return {
        "base_radius_mm": g.base_radius * MM_PER_M,
        "outs_mm": ((g.base_radii - g.base_radius) * MM_PER_M).tolist(),
        "radial": g.radial.tolist(),
        "tangential": g.tangential.tolist(),
        "platform_radius_mm": g.platform_radius * MM_PER_M,
        "upper_arm_mm": g.upper_arm_length * MM_PER_M,
        "forearm_mm": g.forearm_length * MM_PER_M,
        "width_mm": found.task.choice.width_mm,
        "ratio": found.task.choice.ratio,
        "cube": {
            "bottom_mm": cube.bottom_height * MM_PER_M,
            "half_mm": cube.half_side * MM_PER_M,
            "centre_x_mm": cube.centre_x * MM_PER_M,
        },
    }
