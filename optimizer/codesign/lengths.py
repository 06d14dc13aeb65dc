"""Lengths of a candidate: the largest cube or the smallest machine for its hardware and model corrections.

Where its chains may be placed for the outline, azimuths, base radii and the cube's place are looked for with them. How
scores compare follows from the resolution to which lengths are found.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions.forearm import wrist_radius_min_mm
from delta_cad.dimensions.joint import force_most_N
from delta_cad.drive.friction import coulomb_N_m
from delta_cad.mechanism.geometry import AZIMUTH_MAX_DEG, AZIMUTH_MIN_DEG, azimuth_cosine
from delta_cad.mechanism.limits import HandleInertia, Outline
from optimizer.codesign.candidate import PEAK_MARGIN, Candidate, effective_mass_kg
from optimizer.codesign.corrections import (
    COUPLE_MOST,
    KAPPA_MAX,
    KNOB_MM,
    LEAN_DEG,
    REAR_PAIR,
    SECTORS,
    SHOULDER_DEG,
    SIDE_PAIR,
    ChainReach,
    Corrections,
    as_symmetric,
    placed_sides,
)
from optimizer.codesign.hardware import Selection, motor_of, price_EUR
from optimizer.problem.brief import DesignBrief
from optimizer.problem.requirements import Requirements, requirements_from_dict
from optimizer.problem.step import Problem, outline_of, step_problem
from optimizer.problem.validation import RequirementsError
from optimizer.problem.variables import (
    COSINE,
    LENGTHS,
    PER_SI,
    SIDE,
    VARIABLES,
    azimuth_deg,
    completed,
    design_fields,
    is_symmetric,
    variables_mm,
)
from optimizer.search import sqp
from optimizer.search.result import Result

WIDE_MM = {
    "upper_arm_length": (30.0, 400.0),
    "forearm_length": (40.0, 800.0),
    "base_radius": (15.0, 200.0),
    "platform_radius": (12.0, 150.0),
    "bottom_height": (5.0, 800.0),
    "half_side": (0.0, 300.0),
}
"""Where lengths are looked for that the brief leaves open."""
_PLACED_MM = {"side_shift": (-100.0, 100.0), "centre_x": (-100.0, 100.0)}
"""The same of a placed machine."""
_NEARER = 0.75  # of a symmetric base radius: no chain is looked for nearer than that
_NEAREST_MM = 1.0  # of a shoulder to the base's axis, whatever else is known
_PLATFORM_SHARE = (
    0.3  # of the shorter side of an outline, in a platform's radius: beyond, no elbow is outside its wrist
)
_INSIDE = 0.9  # of R + L_A likewise, where an outline is free
_FREE_OUTLINE_MM = 2000.0
_CUP_MM = 1.9  # of a cup beyond its ball, with what a rod that leans and turns brings it closer to the next
_CUPS_APART_MM = 0.1  # of cups of neighbouring chains, beyond the clearance: a proof at it does not end
# Left of the mechanism's limits: lengths are rounded to a micrometre, and a proof right at a limit takes long.
_AZIMUTH_DECIMALS = 4  # of degrees: less than a micrometre half a metre out
_ROOM, _ROOM_DEG = 2e-4, 0.005
ROUNDS = 3  # of lengths and the inertia estimated for them
CONVERGED = 2e-3  # share of the side that the last round changed
STARTS, _MORE_STARTS = 3, 2  # of SQP, where no lengths are known, and where those that are lead nowhere
_FAR = 0.02  # margin that stays open near known lengths, from which on no other start is tried
_OBJECTIVE_TRIES = 12  # values that are tried of what is to be least
ENOUGH, ROUGHLY = 2e-3, 2e-2  # share of the cube by which that may be larger than asked, or of the value
_GAIN = 5e-4  # share below which a change is none
_LIGHTER = 1e-2  # share of the effective mass by which one of two machines as good as one another is lighter
_PAYS = 0.01  # share of a score that placed chains have to give: the base plate is another, and so is the platform
_LITTLE = 0.02  # share by which the cube has to grow with the value, to go on
_REACH_SHARE = 1.5  # of the side: R + L_A of the first
_SMALL_MM = 200.0  # R + L_A up to which parts alone, and no torque, may leave no cube at all
_BASE, _SHIFT = VARIABLES.index("base_radius"), VARIABLES.index("side_shift")
_LEVERS = 7  # couple indices that are tried behind a panel
_LEVERED_MM = 5.0  # of a cube behind one, that is looked at
_FIRST_MASS_KG, _MOST_MASS_KG = 0.4, 50.0


@dataclass(frozen=True)
class Found:
    """Lengths that were found.

    Attributes:
        lengths_mm: (9) in the order of `VARIABLES`, to whole micrometres, an azimuth to what a design file has.
        score: What is sought, larger is better: the cube's side, or the least width and depth together, effective
            mass or price with its sign changed; mm, kg or EUR.
        reach_mm: R + L_A, where the outline is free.
    """

    lengths_mm: tuple[float, ...]
    score: float
    reach_mm: float | None = None

    @property
    def side_mm(self) -> float:
        """Side of the cube."""
        return 2.0 * self.lengths_mm[SIDE]


def to_requirements(
    brief: DesignBrief,
    choice: Selection,
    corrections: Corrections,
    inertia: HandleInertia,
    target: float | None = None,
    far: Selection | None = None,
) -> Requirements:
    """Poses the lengths of a candidate as requirements of the first edition, whose second step finds the largest cube.

    Args:
        brief: What the customer asks.
        choice: Hardware.
        corrections: What is known of it.
        inertia: Of the machine, estimated.
        target: What is to be least, at this value; None where the cube is to be largest.
        far: The same hardware at a larger ratio, where all between stand for one: torque and encoder are then its, and
            no room is left of any limit.
    """
    task, limits = brief.requirements, brief.limits
    best, room, room_deg = far or choice, 0.0 if far else _ROOM, 0.0 if far else _ROOM_DEG
    outline = brief.outline_mm or (_FREE_OUTLINE_MM, _FREE_OUTLINE_MM)
    overhead = corrections.overhead_mm if brief.outline_mm else (0.0, 0.0)
    bounds = {}
    ball = float(choice.stated(brief, "ball_diameter_mm"))
    by_parts = {
        "platform_radius": wrist_radius_min_mm(
            ball / 2 + _CUP_MM, choice.width_mm, task.clearance_min_mm + _CUPS_APART_MM
        ),
        "base_radius": (_NEARER if choice.placed else 1.0) * _least_base_mm(choice, corrections),
    }
    for name in LENGTHS:
        low, high = getattr(brief.bounds_mm, name) or WIDE_MM[name]
        if name == "platform_radius" and getattr(brief.bounds_mm, name) is None and brief.outline_mm:
            high = max(low, min(high, _PLATFORM_SHARE * min(brief.outline_mm)))
        elif name == "platform_radius" and target is not None and brief.objective != "effective_mass":
            high = max(low, min(high, _INSIDE * target))
        least = max(0.0 if name == "base_radius" else corrections.least(name), by_parts.get(name, 0.0))
        bounds[name] = [max(low, min(least, high)), high]
    if choice.placed:
        bounds |= {name: list(getattr(brief.bounds_mm, name) or wide) for name, wide in _PLACED_MM.items()}
        (low, high), (least, most) = bounds["base_radius"], bounds["side_shift"]
        bounds["side_shift"] = [max(least, low - high, _NEAREST_MM - low), min(most, high - low)]
    bounds["half_side"][1] = min(bounds["half_side"][1], corrections.side_most_mm / 2.0)
    if target is None and task.cube_side_mm is not None:
        bounds["half_side"][0] = task.cube_side_mm / 2.0
    low_deg, high_deg = limits.shoulder_deg or SHOULDER_DEG
    required: dict[str, Any] = {
        "parallelogram_width_mm": choice.width_mm,
        "outline_overhead_mm": list(overhead),
        "kappa_max": (brief.feel.kappa_max or KAPPA_MAX) * (1.0 - room),
        "couple_index_min": max(brief.couple_index_min, corrections.couple_index_min) * (1.0 + room),
        "lean_max_deg": (limits.lean_max_deg or LEAN_DEG) - room_deg,
        "shoulder_deg": [max(low_deg, corrections.shoulder_low_deg) + room_deg, high_deg - room_deg],
        "gravity_torque_N_m": corrections.held_torque_N_m,
    }
    if elbow_deg := max(limits.elbow_angle_min_deg or 0.0, corrections.elbow_angle_deg):
        required["elbow_angle_min_deg"] = elbow_deg + room_deg
    if limits.outline_radius_max_mm is not None:
        required["outline_radius_max_mm"] = limits.outline_radius_max_mm
    most = brief.feel.effective_mass_max_kg
    if target is not None and brief.objective == "effective_mass":
        most = target
    elif target is not None:
        required["outline_radius_max_mm"] = target
    if most is not None:
        required["effective_mass_max_kg"] = most * corrections.mass_share
    if brief.feel.friction_max_N is not None:
        required["friction_max_N"] = brief.feel.friction_max_N * corrections.friction_share
    if brief.feel.position_step_max_mm is not None:
        required["position_step_max_mm"] = brief.feel.position_step_max_mm * corrections.step_share
    motor, (upright, level) = motor_of(brief, choice.motor), corrections.ball_friction_N
    if task.height_max_mm is not None:
        required["height_beyond_mm"] = corrections.height_beyond_mm
    data: dict[str, Any] = {
        "name": brief.name,
        "requirements": {
            "envelope_width_mm": outline[0],
            "envelope_depth_mm": outline[1],
            "height_max_mm": task.height_max_mm,
            "force_N": task.force_N,
            "joint_torque_N_m": continuous_torque_N_m(brief, best, corrections),
        },
        "bounds_mm": bounds,
        "limits": required,
        "hardware": {"ball_diameter_mm": ball},
        "bounds_deg": _azimuths(brief) if choice.placed else None,
        "inertia": {
            "carried_mass_kg": inertia.carried_mass,
            "elbow_mass_kg": inertia.elbow_mass,
            "cross_mass_kg": inertia.cross_mass,
            "joint_inertia_kg_m2": inertia.joint_inertia,
        },
    }
    data["joints"] = {
        "friction_N_m": coulomb_N_m(motor, choice.ratio)[1],
        "ball_upright_N": upright,
        "ball_level_N": level,
        "encoder_count_deg": best.count_deg(brief),
    }
    return requirements_from_dict(data, f"{brief.name} with {choice.motor}")


def _azimuths(brief: DesignBrief) -> dict[str, Any]:
    stated = None if brief.bounds_deg is None else brief.bounds_deg.azimuth
    return {"azimuth": list(stated or (AZIMUTH_MIN_DEG, AZIMUTH_MAX_DEG))}


@dataclass(frozen=True)
class PlacedProblem(Problem):
    """Lengths and placement, with the room that chains and wrists have in a three-fold symmetric machine.

    Attributes:
        least_mm: What `as_symmetric` tells -> the least of it.
        reach: Of a chain, as `placed_sides` takes it.
    """

    least_mm: tuple[tuple[str, float], ...] = ()
    reach: ChainReach | None = None

    @cached_property
    def _outline(self) -> tuple[float, np.ndarray, np.ndarray]:
        """L_c, then what is allowed along y and x and what the machine takes beyond its chains there, (2, 1, 1), mm."""
        outline = outline_of(self.requirements)
        beyond = outline.overhead_mm if self.reach is None else self.reach.beyond_mm
        allowed, over = (np.reshape(pair, (2, 1, 1)) for pair in ((outline.width_mm, outline.depth_mm), beyond))
        return outline.parallelogram_width_mm, allowed, over

    def _rooms(self, designs: np.ndarray) -> list[np.ndarray]:
        """Room in the outline, of shoulders, of neighbours and their wrists, and of the largest base radius."""
        rows = completed(designs).T * PER_SI[:, None]
        width, allowed, beyond = self._outline
        taken = placed_sides(rows, width, self.reach) + beyond
        ways = [(1.0 - taken / most).reshape(-1, rows.shape[1]) for most in (allowed, allowed[::-1])]
        first, turned = (way.min(axis=0) for way in ways)
        found = as_symmetric(rows, width)
        rooms = [one / least - 1.0 for name, least in self.least_mm for one in found[name]]
        rooms.append(1.0 - (rows[_BASE] + rows[_SHIFT]) / self.upper[_BASE])
        return [*np.where(turned > first, ways[1], ways[0]), *rooms]

    def design_margins(self, designs: np.ndarray) -> dict[str, np.ndarray]:
        """Computes the margins in closed form; that of the outline is the least of all rooms."""
        return super().design_margins(designs) | {Outline.name: np.min(self._rooms(designs), axis=0)}

    def smooth_design_margins(self, designs: np.ndarray) -> list[np.ndarray]:
        """Computes the same in smooth parts."""
        rows = completed(designs).T * PER_SI[:, None]
        parts = (limit.smooth_margins(rows) for limit in self.limits if limit.name != Outline.name)
        return [*self._rooms(designs), *(one for found in parts if found is not None for one in found)]


def _least_base_mm(choice: Selection, corrections: Corrections) -> float:
    """Gives the least base radius that a choice lets pass, of a placed machine as `as_symmetric` tells it, mm."""
    return max(choice.base_radius_mm, corrections.least_radius_mm(choice.width_mm))


def lengths_problem(posed: Requirements, choice: Selection, corrections: Corrections) -> Problem:
    """Poses the largest cube of requirements, with what a placed machine keeps of a symmetric one.

    Args:
        posed: The requirements.
        choice: Hardware.
        corrections: What is known of it. What `as_symmetric` tells is no less than a symmetric machine's least.
    """
    problem = step_problem(posed, 2)
    if not choice.placed or problem.symmetric:
        return problem
    radius = _least_base_mm(choice, corrections)
    least = {
        "shoulders": max(_NEARER * radius, corrections.least("base_radius")),
        "wrists": problem.lower[VARIABLES.index("platform_radius")],
    }
    least |= {pair: max(radius, corrections.least(pair)) for pair in (SECTORS, SIDE_PAIR, REAR_PAIR)}
    own = {one.name: getattr(problem, one.name) for one in fields(problem)}
    bounded = tuple((name, value) for name, value in least.items() if value > 0.0)
    return PlacedProblem(**own, least_mm=bounded, reach=corrections.reach)


def _in_rectangle(brief: DesignBrief, start_mm: Sequence[float]) -> list[tuple[float, ...]]:
    """Places to begin from: a given one, or of a symmetric machine one for the outline either way round.

    Elbows at equal distance from the base's centre take `2 sin phi` along y and `1 - cos phi` along x: phi is that of
    the outline's ratio of sides.
    """
    assert brief.outline_mm is not None
    width, depth = brief.outline_mm
    if not is_symmetric(start_mm):
        return [tuple(start_mm)]
    low, high = (azimuth_cosine(one) for one in (AZIMUTH_MAX_DEG, AZIMUTH_MIN_DEG))
    tangents = dict.fromkeys((2.0 * depth / width, 2.0 * width / depth))  # of phi / 2
    cosines = (min(max((1.0 - tangent**2) / (1.0 + tangent**2), low), high) for tangent in tangents)
    return [(*start_mm[: len(LENGTHS)], 0.0, cosine, 0.0) for cosine in cosines]


def continuous_torque_N_m(brief: DesignBrief, choice: Selection, corrections: Corrections) -> float:
    """Computes the torque of a joint for the lasting force beside the weight, N m: what is for ever, and no more than
    what leaves enough for the peak force, which goes with it.
    """
    required, row = brief.requirements, motor_of(brief, choice.motor)
    lasting = min(choice.torque_N_m(row), required.joint_torque_N_m or math.inf)
    if required.peak_force_N is None:
        return lasting
    stated = min(choice.peak_torque_N_m(row), required.peak_torque_N_m or math.inf) / PEAK_MARGIN
    pulled = choice.sector_mm(brief) / MM_PER_M * corrections.pull_N if corrections.pull_N < math.inf else math.inf
    most, held = min(stated, pulled), corrections.held_torque_N_m
    return min(lasting, held + (most - held) * required.force_N / required.peak_force_N)


def best_lengths(
    brief: DesignBrief,
    choice: Selection,
    corrections: Corrections,
    start_mm: Sequence[float] | None = None,
    seed: int = 0,
    rounds: int = ROUNDS,
    beats: float | None = None,
    tick: Callable[[], None] = lambda: None,
) -> Found | None:
    """Finds the lengths of the largest cube, or of the smallest machine with the required cube.

    With given hardware the least machine is the cheapest, too: what is bought stays, what is made grows with it.
    The largest cube grows with what is allowed, so that the least that is enough for the cube asked is a root.

    Args:
        brief: What the customer asks.
        choice: Hardware.
        corrections: What is known of it.
        start_mm: (9) lengths to begin from, in the order of `VARIABLES`; None: points of a hypercube, of a placed
            machine the symmetric one.
        seed: Of these.
        rounds: Of lengths and the inertia estimated for them; one, and no score to beat, is a rough estimate.
        beats: A score: lengths that are no better need not be found.
        tick: Called after each start of SQP; what it raises ends the search.

    Returns:
        The lengths; None where there are none, or none that beat the score.
    """
    required = brief.requirements
    if corrections.held_torque_N_m >= continuous_torque_N_m(brief, choice, corrections):
        return None  # the weight takes all of it
    if max(required.force_N, required.peak_force_N or 0.0) > force_most_N():
        return None  # no spring holds rods on their balls
    side = required.cube_side_mm
    if choice.placed and start_mm is None:
        symmetric = best_lengths(brief, choice.with_(placed=False), corrections, None, seed, rounds, None, tick)
        start_mm = None if symmetric is None else symmetric.lengths_mm
    if brief.objective == "cube_side" or side is None:
        result = _largest(brief, choice, corrections, start_mm, seed, rounds, None, tick)
        if result is None or result.tiny:
            return None
        lengths = _rounded(result)
        return Found(lengths, 2.0 * lengths[SIDE])
    by_mass = brief.objective == "effective_mass"
    enough = ENOUGH if rounds > 1 or beats is not None else ROUGHLY
    low, high = (0.0, _MOST_MASS_KG) if by_mass else (0.5 * side, _FREE_OUTLINE_MM)
    target = _FIRST_MASS_KG if by_mass else _REACH_SHARE * side
    if beats is not None:
        target = high = -beats if by_mass else _reach_mm(choice, corrections, -beats)
    first = target
    best: tuple[float, Result] | None = None
    known: list[tuple[float, float]] = []
    for _ in range(_OBJECTIVE_TRIES):
        result = _largest(brief, choice, corrections, start_mm, seed, rounds, target, tick)
        reached = 0.0 if result is None else 2.0 * result.design_mm[SIDE]
        if result is not None and reached >= side:
            best, start_mm, high = (target, result), result.design_mm, target
            if reached <= side * (1.0 + enough):
                break
        else:
            if beats is not None and target == first:
                return None
            larger = known and target > known[-1][0] and (reached > 0.0 or by_mass or target > _SMALL_MM)
            if best is None and larger and reached <= known[-1][1] * (1.0 + _LITTLE):
                return None  # more of it buys nothing: something else is in the way
            low = target
        known.append((target, reached))
        target = _between(known[-2:], side, low, high)
        if high - low <= enough * high:
            break
    if best is None:
        return None
    target, result = best
    lengths = tuple(side / 2.0 if k == SIDE else length for k, length in enumerate(_rounded(result)))
    reach = lengths[0] + lengths[2]
    searched = {"cost": price_EUR(brief, choice, lengths), "outline": sum(taken_mm(choice, corrections, reach))}
    return Found(lengths, -searched.get(brief.objective, target), None if brief.outline_mm else reach)


def taken_mm(choice: Selection, corrections: Corrections, reach_mm: float) -> tuple[float, float]:
    """Computes width and depth of a machine, motors and leads included: eq. (1) and what its hardware takes beyond.

    Args:
        choice: Hardware.
        corrections: What is known of it.
        reach_mm: R + L_A.
    """
    width, depth = Outline(0.0, 0.0, choice.width_mm, corrections.overhead_mm).size_mm(np.array(reach_mm))
    return float(width), float(depth)


def _reach_mm(choice: Selection, corrections: Corrections, sides_mm: float) -> float:
    """R + L_A of a machine whose width and depth have a sum, which is linear in it beyond a bar's own size."""
    far, double = (sum(taken_mm(choice, corrections, reach)) for reach in (_FREE_OUTLINE_MM, 2.0 * _FREE_OUTLINE_MM))
    return _FREE_OUTLINE_MM * (1.0 + (sides_mm - far) / (double - far))


def _rounded(result: Result) -> tuple[float, ...]:
    """Lengths in whole micrometres, the half side rounded down: `_ROOM` is left for what that changes.

    The azimuth is what a design file has: what is proved is what is written.
    """
    lengths = [round(length, 3) for length in result.design_mm]
    lengths[SIDE] = math.floor(1e3 * result.design_mm[SIDE]) / 1e3
    lengths[COSINE] = azimuth_cosine(round(azimuth_deg(result.design_mm[COSINE]), _AZIMUTH_DECIMALS))
    return variables_mm(*design_fields(lengths))


def _between(known: Sequence[tuple[float, float]], side_mm: float, low: float, high: float) -> float:
    """The next value to try: by the secant of the last two, a little more than it says, or half-way."""
    if len(known) == 2 and known[0][1] != known[1][1] and min(known[0][1], known[1][1]) > 0.0:
        (a, at_a), (b, at_b) = known
        by_secant = a + (side_mm * (1.0 + ENOUGH / 2.0) - at_a) * (b - a) / (at_b - at_a)
        if low < by_secant < high:
            return by_secant
    (a, at_a) = known[-1]
    if at_a == 0.0 and len(known) == 1:
        return 2.0 * a
    by_share = a * side_mm * (1.0 + ENOUGH / 2.0) / at_a if at_a > 0.0 else 0.0
    return by_share if low < by_share < high else (low + min(high, 3.0 * max(low, a))) / 2.0


def _largest(
    brief: DesignBrief,
    choice: Selection,
    corrections: Corrections,
    start_mm: Sequence[float] | None,
    seed: int,
    rounds: int,
    target: float | None,
    tick: Callable[[], None],
) -> Result | None:
    """The largest cube of a choice, what is to be least having a value; None where there is none.

    Behind a panel the lever of the knob grows with the cube, and with it the hold against turning that is needed: of a
    couple index the cube is the least of what it holds and of what it leaves, and best where both are one.
    """
    if not corrections.couple_per_mm:
        return _largest_held(brief, choice, corrections, start_mm, seed, rounds, target, tick)
    required = (target is None and brief.requirements.cube_side_mm) or 0.0
    low, high = max(brief.couple_index_min, corrections.couple_index_min), COUPLE_MOST
    best: Result | None = None
    for _ in range(_LEVERS):
        index = (low + high) / 2.0
        held = index / corrections.couple_per_mm - KNOB_MM
        if held <= max(required, _LEVERED_MM):
            low = index
            continue
        known = replace(corrections, couple_index_min=index, side_most_mm=held)
        found = _largest_held(brief, choice, known, best.design_mm if best else start_mm, seed, rounds, target, tick)
        if found is None:
            high = index
            continue
        side = 2.0 * found.design_mm[SIDE]
        if best is None or side > 2.0 * best.design_mm[SIDE]:
            best = found
        low, high = (index, high) if side >= held * (1.0 - CONVERGED) else (low, index)
    return best


def _largest_held(
    brief: DesignBrief,
    choice: Selection,
    corrections: Corrections,
    start_mm: Sequence[float] | None,
    seed: int,
    rounds: int,
    target: float | None,
    tick: Callable[[], None],
) -> Result | None:
    """The same with one couple index for all sides of the cube."""
    at = start_mm or (corrections.mass_estimate.upper_arm_mm, corrections.mass_estimate.forearm_mm)
    start, previous = start_mm, 0.0
    result: Result | None = None

    def ticks(*_: object) -> None:
        tick()

    for _ in range(rounds):
        inertia = corrections.mass_estimate.inertia(at[0], at[1], choice.ratio)
        try:
            posed = to_requirements(brief, choice, corrections.at_arm_length(at[0]), inertia, target)
        except RequirementsError:  # so near the end of a field that none is left of it with what is learnt, or beyond
            return None
        problem, best = lengths_problem(posed, choice, corrections), None
        if start is not None:
            places = _in_rectangle(brief, start) if choice.placed else [start]
            near = sqp.search(problem, np.array([problem.scaled(one) for one in places]), ticks)
            best = near.best
            if best is None and result is None and max(one.level for one in near.endings) < -_FAR:
                return None
        if best is None:
            starts = sqp.start_points(problem, seed)[: STARTS if start is None else _MORE_STARTS]
            best = sqp.search(problem, starts, ticks).best
        if best is None:
            return result  # of the inertia before, if there was one
        result = Result(problem, "sqp", problem.lengths_mm(best.x), "converged")
        start = at = result.design_mm
        side = 2.0 * result.design_mm[SIDE]
        if abs(side - previous) <= CONVERGED * side:
            break
        previous = side
    return result


def tied_by_mass(brief: DesignBrief) -> bool:
    """Whether ties are broken by the effective mass: the cube is set, and no mass is sought."""
    return brief.objective in ("outline", "cost")


def as_good(brief: DesignBrief, score: float) -> float:
    """Gives the least score that is as good within the resolution of lengths, where ties are broken; else the score."""
    return score - ENOUGH * abs(score) if tied_by_mass(brief) else score


def is_better(brief: DesignBrief, found: Candidate, now: Candidate, peak: float) -> bool:
    """Decides whether a candidate is better: by its score, or of a cube that is set by its effective mass.

    Of two that are as good as the best of all, `peak`, within the resolution of lengths, the lighter one is: its mass
    falls with the square of the ratio, and with its arms.
    """
    if not tied_by_mass(brief):
        return found.score > now.score + _GAIN * abs(now.score)
    if not as_good(brief, peak) <= found.score <= peak + ENOUGH * abs(peak):
        return found.score > peak
    return effective_mass_kg(found) < (1.0 - _LIGHTER) * effective_mass_kg(now)


def worth_placing(brief: DesignBrief, symmetric: Candidate) -> float:
    """Gives the score beyond which placed chains are worth it; any is where the task asks for them."""
    return -math.inf if brief.placement else symmetric.score + _PAYS * abs(symmetric.score)
