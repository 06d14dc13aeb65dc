"""What binds lengths that were found, and what each limit costs there: multipliers, read off the problem they solve.

At the largest cube the gradient of its half side is a sum of the gradients of the margins that are used up, with
multipliers that are not negative (Karush, Kuhn, Tucker). A limit that gives a little moves the margins, and the side by
the sum of the multipliers times that: the envelope theorem, to first order what another solve would find.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from delta_cad.mechanism.limits import Outline
from optimizer.codesign.corrections import REAR_PAIR, SECTORS, SIDE_PAIR, as_symmetric
from optimizer.codesign.lengths import PlacedProblem
from optimizer.problem.extremes import design_worst
from optimizer.problem.step import Problem, outline_of
from optimizer.problem.validation import RequirementsError
from optimizer.problem.variables import PER_SI, SIDE, VARIABLES, completed
from optimizer.studio.setting import Solved

_USED = 4e-3  # margin below which one may bind: the search leaves 2e-4 to the limits, and merges near points
_GRID = 9  # points along an edge where worst points are looked for, before they are polished
_DIFFERENCE = 1e-5  # of scaled variables
_SHARE = 1e-3  # of a value by which a limit is moved
_LEAST = 1e-3  # share of the largest multiplier below which nothing binds
_MET, _EXACT, _ROOM_MM = 1e-5, 0.02, 0.02  # margin, share of the gradient, and side, that lengths of an optimum leave
_LEFT = 0.25  # of the gradient that no multipliers explain, beyond which they mean nothing

WORDS = {
    "reach": "reach",
    "assembly_mode": "assembly mode",
    "torque": "motor torque",
    "kappa": "condition number",
    "lean": "lean of the rods",
    "shoulder": "shoulder angle",
    "elbow_angle": "elbow angle",
    "effective_mass": "effective mass",
    "friction": "friction",
    "position_step": "position step",
    "couple_index": "rotational stiffness index",
    "outline": "outline",
    "height": "height",
    "elbow_outside": "elbow outside its wrist",
    "balls": "room of the ball joints",
    "shoulders": "room of the shoulders",
    "wrists": "room of the wrists",
    SECTORS: "room between the sectors",
    SIDE_PAIR: "room between neighbouring chains",
    REAR_PAIR: "room between neighbouring chains",
    "upper_arm_length": "upper arm length",
    "forearm_length": "forearm length",
    "base_radius": "base radius: room of the drives",
    "platform_radius": "platform radius: room of the ball joints",
    "bottom_height": "height of the cube's floor",
    "half_side": "largest cube that the parts allow",
    "side_shift": "shift of chains 1 and 2",
    "side_cosine": "azimuth of chains 1 and 2",
    "centre_x": "place of the cube",
}
"""Name of a limit, or of a length at the end of its range -> what the page calls it."""


@dataclass(frozen=True)
class Binding:
    """A limit that is used up: its name, and what 1 % of it is worth in mm of the cube's side."""

    name: str
    gain_mm: float

    @property
    def words(self) -> str:
        """What a page calls it."""
        return WORDS.get(self.name, self.name.replace("_", " "))


@dataclass(frozen=True)
class Sensitivity:
    """Multipliers of lengths.

    Attributes:
        binding: What is used up, the dearest first.
        left: Share of the gradient that no multipliers explain.
        room_mm: Side that the margins of what binds would still give, to first order.
        margin: The least margin of all.
    """

    binding: tuple[Binding, ...]
    left: float
    room_mm: float
    margin: float
    _found: Solved
    _rates: Callable[[Problem], float]

    @property
    def explained(self) -> bool:
        """Whether multipliers explain the gradient: else lengths are no optimum, and nothing has a price."""
        return self.left < _LEFT

    @property
    def is_optimum(self) -> bool:
        """Whether the lengths meet every limit, and none that gives less than a search resolves is left to be used."""
        return self.margin >= -_MET and self.left < _EXACT and self.room_mm < _ROOM_MM

    def price(self, name: str) -> float | None:
        """Computes by how much the cube's side grows with a field of the requirements.

        Args:
            name: Table and field, or `hardware.capstan_ratio`.

        Returns:
            mm of side for each unit; None where multipliers do not explain the lengths or the field has no value.
        """
        found, ratio = self._found, self._found.task.choice.ratio
        own = ratio if name == "hardware.capstan_ratio" else found.brief.value(name)
        if own is None or not self.explained:
            return None
        step = _SHARE * abs(own)
        rates = []
        for sign in (1.0, -1.0):
            value = own + sign * step
            try:
                if name == "hardware.capstan_ratio":
                    problem = found.problem(choice=found.task.choice.with_(ratio=value))
                else:
                    problem = found.problem(brief=found.brief.with_values({name: value}))
            except RequirementsError:  # at the end of its field's range
                return None
            rates.append(self._rates(problem))
        return (rates[0] - rates[1]) / (2.0 * step)


def sensitivity(found: Solved) -> Sensitivity:
    """Computes the multipliers of lengths from the margins of their problem.

    Args:
        found: Lengths that are an optimum, as far as a search resolves it.
    """
    problem = found.problem()
    # of a least machine the cube is the one required, a little less than the largest of its size
    mm = completed([found.side_mm / 2.0 if k == SIDE else v for k, v in enumerate(found.lengths_mm)])
    worst = design_worst(problem, mm / PER_SI, _GRID)
    rows = [(name, p) for name, one in worst.items() for p in _apart(one.points[one.values < _USED])]
    lower, upper = np.array(problem.lower), np.array(problem.upper)
    index, wide = list(problem.free_index), upper - lower

    def margins(of: Problem, designs_mm: np.ndarray) -> np.ndarray:
        """(D, rows) margins at the same points: those of poses, of the design, of both ends of each variable."""
        designs = designs_mm / PER_SI
        parts = []
        if rows:
            values = of.point_margins(of.figures(designs, np.array([p for _, p in rows])))
            parts.append(np.stack([values[name][:, k] for k, (name, _) in enumerate(rows)], axis=1))
        parts.append(np.stack(of.smooth_design_margins(designs), axis=1))
        for ends, sign in ((of.lower, 1.0), (of.upper, -1.0)):
            parts.append(sign * (designs_mm - np.array(ends))[:, index] / wide[index])
        return np.concatenate(parts, axis=1)

    names = [name for name, _ in rows] + _names(problem, mm)
    names += [VARIABLES[k] for k in index] * 2
    steps = np.zeros((2 * len(index), len(VARIABLES)))
    for row, k in enumerate(index):
        steps[row, k], steps[len(index) + row, k] = _DIFFERENCE * wide[k], -_DIFFERENCE * wide[k]
    table = margins(problem, np.concatenate([mm[None], mm + steps]))
    gradient = (table[1 : len(index) + 1] - table[len(index) + 1 :]) / (2.0 * _DIFFERENCE)  # (free, rows)
    used = np.flatnonzero(table[0] < _USED)
    goal = np.array([-1.0 if k == SIDE else 0.0 for k in index])
    if not len(used) or SIDE not in index:
        return Sensitivity((), np.inf, np.inf, float(table[0].min()), found, lambda _: 0.0)
    multipliers, left = nnls(gradient[:, used], goal)
    side = 2.0 * wide[SIDE]  # mm of side for each unit of the scaled half side
    room_mm = side * float(multipliers @ table[0, used].clip(min=0.0))

    def rates(of: Problem) -> float:
        return side * float(multipliers @ margins(of, mm[None])[0, used])

    gains: dict[str, float] = {}
    for k, multiplier in zip(used, multipliers, strict=True):
        if multiplier > _LEAST * multipliers.max():
            # an end of a range is one in mm: 1 % of the length itself
            own = abs(mm[VARIABLES.index(names[k])]) / wide[VARIABLES.index(names[k])] if names[k] in VARIABLES else 1.0
            gains[names[k]] = gains.get(names[k], 0.0) + 0.01 * side * multiplier * own
    binding = tuple(Binding(name, gain) for name, gain in sorted(gains.items(), key=lambda one: -one[1]))
    return Sensitivity(binding, float(left), room_mm, float(table[0].min()), found, rates)


def _names(problem: Problem, mm: np.ndarray) -> list[str]:
    """Names of the rows of `smooth_design_margins`: of placed chains the outline's, then the rooms of the parts."""
    rows, designs = mm[:, None], mm[None] / PER_SI
    if not isinstance(problem, PlacedProblem):
        return list(problem.design_margins(designs))
    found = as_symmetric(rows, outline_of(problem.requirements).parallelogram_width_mm)
    parts = [name for name, _ in problem.least_mm for _ in found[name]] + ["base_radius"]
    others: list[str] = []
    for limit in problem.limits:
        if limit.name != Outline.name and (smooth := limit.smooth_margins(rows)) is not None:
            others += [limit.name] * len(smooth)
    outline = len(problem.smooth_design_margins(designs)) - len(parts) - len(others)
    return [*([Outline.name] * outline), *parts, *others]


def _apart(points: np.ndarray) -> list[np.ndarray]:
    """Points of which none is another: of two on an edge of the cube one is left."""
    kept: list[np.ndarray] = []
    for point in points:
        if all(np.abs(point - one).max() > 1e-2 for one in kept):
            kept.append(point)
    return kept
