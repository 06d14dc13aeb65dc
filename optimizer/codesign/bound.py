"""Proofs over hardware: a bound on every machine of a family, and requirements that no machine meets.

For the bound motors, drives, ratios and arms stand in intervals, each of them proved; what cannot be is shown with the
best of all hardware at once, before any is searched.

In an interval all that helps is taken at its best: the torque and the encoder's step of the largest ratio, the rotor
and the friction of the least, the inertia of the shortest arm, rods without tubes. What no machine of the family has
beside the rest, none of the interval has; the optimum of the lengths is then proved by `optimizer.globalopt`.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise, repeat

import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions import CLEARANCE_MOST_MM
from delta_cad.dimensions.joint import force_most_N
from delta_cad.mechanism.limits import HandleInertia, Outline
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.corrections import (
    KAPPA_MAX,
    LEAN_DEG,
    ROD_SHARE,
    SHOULDER_DEG,
    Corrections,
    MassEstimate,
    reference,
)
from optimizer.codesign.hardware import (
    PINION_MM,
    SECTOR,
    SECTOR_ROOM_MM,
    SECTORS_MM,
    Selection,
    drives,
    motor_of,
    ratios_of,
)
from optimizer.codesign.lengths import WIDE_MM, continuous_torque_N_m, to_requirements
from optimizer.globalopt.optimum import none_feasible
from optimizer.problem.brief import DesignBrief
from optimizer.problem.step import Problem, step_problem
from optimizer.problem.variables import SIDE, VARIABLES
from optimizer.search import sqp

GAP = 5e-3  # share of the cube beyond the machine at which the bound is as close as it is looked for
CLOSE = 1e-2  # the same where enough time was spent on it
_LEAF_BOXES = 20_000  # of designs, in which a cube is shown to be too large for an interval, or its halves have to
_LEAF_GAP = 1e-3  # to which that cube is found for a narrow one
_WIDE_GAP = 0.03  # of one that is wide, whose halves follow anyway, for a factor e between its ends
LIGHT = 0.99  # share of the parts' masses and of gravity's torque below which no machine of the family comes
MARGIN_MM = 0.2  # of the outline beyond eq. (1), likewise
_RATIOS = 3  # intervals of the ratio to begin with
STARTS = 1  # of SQP in one interval
_PLACED_STARTS = 4  # of SQP for chains placed otherwise, where no three-fold symmetric machine can be
_OUTLINE_SHARE = 1.5  # of R + L_A in the shorter side of an outline, eq. (1)
_NARROW = 1.002  # factor between the ends of an interval
_CORES = 2
_LOSSES = (
    "room that this machine keeps of its limits",
    "parts, friction, outline and pinion at the best of the family",
    "other ratios and motors, and what was left open when the search for the bound ended",
)
BOXES = 8_000  # of designs in one proof, a second at most
HALVINGS = 3  # of the interval between a value that is excluded and one that is not
_WIDER = 1.5  # factor by which an outline that is too small is widened at most
_LEAST_SIDE_MM = 10.0  # of a cube, where none is asked
_NEXT_TO_NONE_KG = 1e-6
ARM = VARIABLES.index("upper_arm_length")
SHIFT = VARIABLES.index("side_shift")


@dataclass(frozen=True, order=True)
class Interval:
    """Machines of one motor and drive, between two ratios and two lengths of the upper arm.

    Attributes:
        motor: Id in the catalogue.
        drive: "capstan" or "direct".
        ratios: Least and largest.
        arms_mm: Shortest and longest.
    """

    motor: str
    drive: str
    ratios: tuple[float, float]
    arms_mm: tuple[float, float]

    @property
    def width(self) -> float:
        """The larger factor between its ends."""
        return max(self.ratios[1] / self.ratios[0], self.arms_mm[1] / self.arms_mm[0])

    @property
    def narrow(self) -> bool:
        """Whether halves would have nearly the same bound."""
        return self.width <= _NARROW

    def halves(self) -> tuple[Interval, Interval]:
        """Cuts it in two, across what is wider."""
        (low, high), (short, long) = self.ratios, self.arms_mm
        if high / low > long / short:
            middle = math.sqrt(low * high)
            return replace(self, ratios=(low, middle)), replace(self, ratios=(middle, high))
        middle = math.sqrt(short * long)
        return replace(self, arms_mm=(short, middle)), replace(self, arms_mm=(middle, long))


@dataclass(frozen=True)
class Kind:
    """Machines that a bound holds for; every sentence that states the bound names them by `words`.

    Attributes:
        width_mm: Width of their parallelograms.
        drives: Motors, drives and ratios, in words.
        limits: Limits that they keep, in words.
        wider: Whether the parallelograms may be wider.
        radius_mm: Least base radius, as hardware was found to need it; 0 for none.
        overhead_mm: Least outline beyond eq. (1), along y and along x.
    """

    width_mm: float
    drives: str
    limits: str
    wider: bool = False
    radius_mm: float = 0.0
    overhead_mm: tuple[float, float] = (0.0, 0.0)

    @property
    def words(self) -> str:
        """Names them, for a sentence that says what none of them has."""
        along, across = self.overhead_mm
        parts = (
            "three equal chains at 120 degrees, the cube on their axis",
            f"parallelograms {'at least ' if self.wider else ''}{self.width_mm:g} mm wide",
            f"a base radius of at least {self.radius_mm:.2f} mm" if self.radius_mm > 0.0 else "",
            f"at least {along:.1f} and {across:.1f} mm of outline beyond eq. (1)" if max(along, across) > 0.0 else "",
            self.limits,
            f"driven by {self.drives}",
        )
        return ", ".join(part for part in parts if part)


def _allowed_drives(brief: DesignBrief) -> str:
    """Names the motors, drives and ratios that may be used."""
    low, high = ratios_of(brief)
    ratios = f" of {low:g}:1" + (f" to {high:g}:1" if high > low else "")
    named = {"capstan": f"a capstan{ratios}", "direct": "a direct drive"}
    every = f"any motor of the catalogue{' or of own parts' if brief.own_parts else ''}"
    motors = " or ".join(brief.choices["motor"]) if "motor" in brief.hardware else every
    return f"{motors} with {' or '.join(named[drive] for drive in brief.choices['drive'])}"


def _kept_limits(brief: DesignBrief) -> str:
    """Names the limits on the mechanism that every candidate keeps: the set limits, or else those of the search."""
    limits = brief.limits
    low, high = limits.shoulder_deg or SHOULDER_DEG
    return (
        f"a rotational stiffness index of at least {brief.couple_index_min:g}, kappa of at most "
        f"{brief.feel.kappa_max or KAPPA_MAX:g}, rods that lean by at most {limits.lean_max_deg or LEAN_DEG:g} deg, "
        f"shoulder angles from {low:g} to {high:g} deg"
    )


@dataclass(frozen=True)
class Bound:
    """What is proved of a family.

    Attributes:
        side_mm: No cube is larger.
        gap: Share by which that exceeds the cube of the machine.
        intervals: How many were looked at.
        kind: Which machines.
        family: What else they have in common, a line each.
        losses: What lies between the machine's cube and that, mm each.
        placed_mm: Side of the cube of the machine where it is none of the family, for its chains are placed for the
            outline: the bound is none for it.
    """

    side_mm: float
    gap: float
    intervals: int
    kind: Kind
    family: tuple[str, ...]
    losses: tuple[tuple[str, float], ...] = ()
    placed_mm: float | None = None

    @property
    def statement(self) -> str:
        """States the bound, with the machines that it holds for."""
        none = f"It is proved that no machine with {self.kind.words} has a cube of more than {self.side_mm:.2f} mm"
        if self.placed_mm is None:
            return f"{none}, {100.0 * self.gap:.2g} % more than this one's."
        larger = "" if self.side_mm > self.placed_mm * (1.0 + 1e-9) else "; none is larger than this one"
        placed = f"This one, with {self.placed_mm:.2f} mm, has its chains placed otherwise: it has no bound."
        return f"{none}{larger}. {placed}"


class Family:
    """Machines like one that was made: bounds that hold for all of them, in an interval of hardware.

    Args:
        brief: What the customer asks.
        machine: One that was made; where its chains are placed, the family is that of the three-fold symmetric ones
            with its hardware, and the machine none of it.
        corrections: Of each motor and drive that was looked at: its base and platform radius are no smaller.
    """

    def __init__(self, brief: DesignBrief, machine: Candidate, corrections: dict[tuple[str, str], Corrections]) -> None:
        self._brief, self._machine, self._corrections = brief, machine, dict(corrections)
        key = machine.choice.motor, machine.choice.drive
        own = corrections[key] if machine.choice.placed else _with(machine, corrections[key])
        self._corrections[key] = own
        longer, shorter = (max(over - MARGIN_MM, 0.0) for over in own.overhead_mm)
        self._overhead = longer, shorter
        self._least = {
            length: min(one.least(length) for one in self._corrections.values())
            for length in ("base_radius", "platform_radius")
        }
        width = machine.choice.width_mm
        self._interferences = min(self._corrections.values(), key=lambda one: one.least_radius_mm(width)).interferences
        self._proved: dict[tuple[object, ...], float] = {}
        self._balls = tuple(LIGHT * force for force in own.ball_friction_N)

    @property
    def kind(self) -> Kind:
        """The machines, as a bound names them."""
        return Kind(
            self._machine.choice.width_mm,
            _allowed_drives(self._brief),
            _kept_limits(self._brief),
            radius_mm=self._radius_mm(),
            overhead_mm=self._overhead,
        )

    def described(self) -> tuple[str, ...]:
        """Says what the machines have in common beyond their kind."""
        radii = "base and platform radii" if self._radius_mm() > 0.0 else "platform radii"
        return (
            f"parts and gravity's torque at least {100 * LIGHT:g} % of this machine's, rotors those of the motors",
            f"{radii} no smaller than this machine's hardware needs: other ratios and lengths may need less",
            f"sectors that pass one another: of R >= {SECTOR_ROOM_MM:g} mm and half their radius",
            f"shafts of motors that bear at most {100 / LIGHT - 100:.0f} % more of a cable than was found",
        )

    def _radius_mm(self) -> float:
        """The smallest base radius of a machine with this motor, apart from the requirement of the sectors."""
        choice = self._machine.choice
        return self._corrections[choice.motor, choice.drive].least_radius_mm(choice.width_mm)

    def intervals(self) -> Iterator[Interval]:
        """Gives one for each motor and drive."""
        low, high = self._brief.bounds_mm.upper_arm_length or WIDE_MM["upper_arm_length"]
        if self._brief.outline_mm:
            high = min(high, min(self._brief.outline_mm) / _OUTLINE_SHARE)
        least, most = ratios_of(self._brief)
        steps = np.geomspace(least, most, _RATIOS + 1).tolist() if most > least else [least, most]
        for motor, drive in drives(self._brief):
            for ratios in pairwise(steps if drive == "capstan" else (1.0, 1.0)):
                yield Interval(motor, drive, ratios, (low, high))

    def best_of(self, one: Interval, least_mm: float, most_mm: float, stop: Callable[[], bool]) -> float:
        """Bounds the side of the cubes of an interval.

        Args:
            one: The interval.
            least_mm: Cubes that are no larger are not looked for.
            most_mm: No cube is larger, as is known.
            stop: True ends it with what is proved.

        Returns:
            What none exceeds, mm: between both.
        """
        choice, far, corrections = self._relaxed(one)
        if corrections.held_torque_N_m >= continuous_torque_N_m(self._brief, far, corrections):
            return least_mm  # the weight takes all of it
        inertia = self._inertia(self._lightest(one), one)
        problem = step_problem(to_requirements(self._brief, choice, corrections, inertia, far=far), 2)
        lower, upper = list(problem.lower), list(problem.upper)
        lower[ARM], upper[ARM] = one.arms_mm
        problem = replace(problem, lower=tuple(lower), upper=tuple(upper))
        key = problem.requirements.model_dump_json(exclude={"name"}), problem.lower, problem.upper, least_mm
        if key not in self._proved:  # windings and encoders of one motor may pose the same
            self._proved[key] = self._largest(problem, one, least_mm, most_mm, stop)
        return min(self._proved[key], most_mm)

    def _relaxed(self, one: Interval) -> tuple[Selection, Selection, Corrections]:
        """The hardware of an interval at its least and at its largest, and what holds of all its machines."""
        chosen = self._machine.choice
        choice = Selection(one.motor, one.drive, one.ratios[0], chosen.width_mm, chosen.entries)
        known = self._corrections.get((one.motor, one.drive))
        weighed = self._lightest(one)
        corrections = Corrections(
            replace(weighed, gravity_torque_N_m=LIGHT * weighed.gravity_torque_N_m),
            known.least_mm if known else self._least,
            known.interferences if known else self._interferences,
            self._overhead,
            mass_share=1.0,
            friction_share=1.0,
            step_share=1.0,
            ball_friction_N=(self._balls[0], self._balls[1]),
            torque_margin_N_m=0.0,
            pull_N=known.pull_N / LIGHT if known else math.inf,
        )
        return choice, self._strongest(one), corrections

    def losses(self, side_mm: float, bound_mm: float) -> tuple[tuple[str, float], ...]:
        """Tells what lies between a machine's cube and a bound, mm each: what it keeps, the parts, the rest."""
        machine, known = self._machine, self._corrections[self._machine.choice.motor, self._machine.choice.drive]
        choice, lengths = machine.choice, machine.lengths_mm
        one = Interval(choice.motor, choice.drive, (choice.ratio, choice.ratio), (lengths[0], lengths[0]))
        near, far, relaxed = self._relaxed(one)
        exact = replace(known, mass_share=1.0, friction_share=1.0, step_share=1.0, torque_margin_N_m=0.0)
        inertia = machine.corrections.mass_estimate.inertia(lengths[0], lengths[1], choice.ratio)
        found = [side_mm]
        for posed_as in (
            to_requirements(self._brief, choice, exact, inertia, far=choice),
            to_requirements(self._brief, near, relaxed, self._inertia(self._lightest(one), one), far=far),
        ):
            problem = step_problem(posed_as, 2)
            best = sqp.search(problem, problem.scaled(lengths)[None]).best
            found.append(found[-1] if best is None else 2.0 * problem.lengths_mm(best.x)[SIDE])
        steps = pairwise(np.clip([*found, bound_mm], side_mm, bound_mm).tolist())
        return tuple(zip(_LOSSES, (after - before for before, after in steps), strict=True))

    @staticmethod
    def _largest(problem: Problem, one: Interval, least_mm: float, most_mm: float, stop: Callable[[], bool]) -> float:
        """What no cube of a problem exceeds, between both."""
        lower, upper = list(problem.lower), list(problem.upper)

        def none_above(side_mm: float) -> bool:
            lower[SIDE] = max(problem.lower[SIDE], side_mm / 2.0)
            larger = replace(problem, lower=tuple(lower))
            return lower[SIDE] >= upper[SIDE] or none_feasible(larger, _LEAF_BOXES, stop)

        if none_above(least_mm):
            return least_mm
        found = sqp.search(problem, sqp.start_points(problem, 0, STARTS)).best
        side = 0.0 if found is None else 2.0 * problem.lengths_mm(found.x)[SIDE]
        gap = max(_LEAF_GAP, _WIDE_GAP * math.log(one.width))
        while side < most_mm and not stop():
            side = max(least_mm, side) * (1.0 + gap)
            if none_above(side):
                return min(side, most_mm)
        return most_mm

    def _strongest(self, one: Interval) -> Selection:
        """The hardware of an interval: its largest ratio, and the largest sector in the outline next to its arms."""
        chosen, most = self._machine.choice, SECTORS_MM[1]
        entries = {name: value for name, value in chosen.entries.items() if name != SECTOR}
        if self._brief.outline_mm is not None:
            reach = Outline(*self._brief.outline_mm, chosen.width_mm, self._overhead).reach_max_mm
            most = min(most, 2.0 * (reach - one.arms_mm[0] - SECTOR_ROOM_MM))
        wider = max(most / one.ratios[1] - PINION_MM, 0.0)
        return Selection(one.motor, one.drive, one.ratios[1], chosen.width_mm, entries, wider)

    def _lightest(self, one: Interval) -> MassEstimate:
        """The machine's own weights, with the rotor of another motor at the least ratio of an interval."""
        weighed, row = self._machine.corrections.mass_estimate, motor_of(self._brief, one.motor)
        rotor = row.rotor_inertia_kg_m2 * one.ratios[0] ** 2
        return replace(weighed, masses=replace(weighed.masses, rotor_inertia=rotor), ratio=one.ratios[0])

    @staticmethod
    def _inertia(weighed: MassEstimate, one: Interval) -> HandleInertia:
        """The least inertia at the handle of an interval: of its shortest arm, and of rods that have no length."""
        m = replace(weighed.masses, rotor_inertia=0.0)
        bare = replace(weighed, masses=m).inertia(one.arms_mm[0], weighed.forearm_mm, one.ratios[0])
        ends = 1.0 - ROD_SHARE
        return HandleInertia(
            LIGHT * (m.platform + 3.0 * m.rod_wrist * ends),
            LIGHT * m.rod_elbow * ends,
            LIGHT * m.rod_cross * ends,
            LIGHT * bare.joint_inertia + weighed.masses.rotor_inertia,
        )


def _with(machine: Candidate, known: Corrections) -> Corrections:
    """What was learnt of a machine's hardware, as far as the machine keeps it: it is one of its family."""
    own: dict[str, float] = dict(zip(VARIABLES, machine.lengths_mm, strict=False))
    width = machine.choice.width_mm
    kept = replace(known, least_mm={name: min(least, own[name]) for name, least in known.least_mm.items()})
    radius = own["base_radius"]
    return kept if kept.least_radius_mm(width) <= radius else kept.with_chains_apart(width, radius, 0.0, "it passes")


def bounded(
    family: Family,
    side_mm: float,
    stop: Callable[[], bool],
    report: Callable[[str], None] = lambda _: None,
    enough: Callable[[], bool] = lambda: False,
) -> Bound:
    """Proves how much larger than a machine's cube that of any of its family can be.

    The interval with the largest bound is halved, until none is left above `GAP`, it is narrow, or the time is over.

    Args:
        family: The family.
        side_mm: Cube of the machine, mm.
        stop: True ends it with what is proved.
        report: Told what is being done.
        enough: True ends it likewise, where nothing is left above `CLOSE`.
    """
    target = side_mm * (1.0 + GAP)
    open_: list[tuple[float, Interval]] = []
    count, largest = 0, math.inf

    def ended() -> bool:
        return stop() or (largest <= side_mm * (1.0 + CLOSE) and enough())

    def bound_of(above: float, one: Interval) -> float:
        return above if ended() else family.best_of(one, target, above, ended)

    def look_at(above: float, intervals: Sequence[Interval]) -> None:
        nonlocal count
        # half of them by this thread itself, whose waiting for a processor is what the clock of a search leaves out
        others = threads.map(bound_of, repeat(above), intervals[1::2])
        own = [bound_of(above, one) for one in intervals[::2]]
        for one, value in zip([*intervals[::2], *intervals[1::2]], [*own, *others], strict=True):
            count += 1
            report(f"bound: {one.motor}, {count} intervals, {max([value, *(-v for v, _ in open_)]):.2f} mm")
            if value > target:
                heapq.heappush(open_, (-value, one))

    with ThreadPoolExecutor(_CORES - 1) as threads:
        look_at(2.0 * WIDE_MM["half_side"][1], list(family.intervals()))
        while open_ and not open_[0][1].narrow:
            largest = -open_[0][0]
            if ended():
                break
            value, one = heapq.heappop(open_)
            look_at(-value, one.halves())
    side = max([target, *(-value for value, _ in open_)])
    return Bound(side, side / side_mm - 1.0, count, family.kind, family.described(), family.losses(side_mm, side))


def excluded(brief: DesignBrief, stop: Callable[[], bool] = bool) -> str:
    """Finds out whether the cube and the outline that are required exclude one another, with a bound on the cube, or
    else on the outline: by proof for three-fold symmetric machines, by a search for those with placed chains.

    Args:
        brief: The requirements.
        stop: True ends a proof without a result.

    Returns:
        Fields, values, the bound and the machines that it holds for; "" where nothing is excluded, or the outline is
        free.
    """
    if brief.outline_mm is None or not _none(brief, stop):
        return ""
    task = brief.requirements

    def widened(factor: float) -> DesignBrief:
        width, depth = (factor * side for side in brief.outline_mm or ())
        return _requiring(brief, envelope_width_mm=width, envelope_depth_mm=depth)

    none = f"with less, it is proved, there is no machine with {kind(brief).words}"
    if brief.placeable:
        none += "; a search with chains 1 and 2 at other azimuths, at least as far out as chain 0, finds none: no proof"
    if (side := task.cube_side_mm) is not None and (found := _largest_mm(brief)) > 0.0:
        bound = _edge(side, found, lambda cube: _none(_requiring(brief, cube_side_mm=cube), stop))
        none = none.replace("less", "more", 1)
        return f"requirements.cube_side_mm = {side:g}: must be < {bound:.4g} mm in this outline: {none}"
    factor = _edge(1.0, _WIDER, lambda factor: _none(widened(factor), stop))
    required, least = (" and ".join(f"{one:.4g}" for one in widened(by).outline_mm or ()) for by in (1.0, factor))
    return f"requirements.envelope_width_mm and envelope_depth_mm = {required}: must be > {least} mm: {none}"


def _edge(excluded_at: float, able: float, none: Callable[[float], bool]) -> float:
    """Comes closer from a value that is excluded to one that is not, and gives the last that is excluded."""
    for _ in range(HALVINGS):
        middle = math.sqrt(excluded_at * able)
        excluded_at, able = (middle, able) if none(middle) else (excluded_at, middle)
    return excluded_at


def _requiring(brief: DesignBrief, **changed: float) -> DesignBrief:
    return brief.model_copy(update={"requirements": brief.requirements.model_copy(update=changed)})


def _largest_mm(brief: DesignBrief) -> float:
    """The largest cube that a search finds with the best of all hardware, mm; 0 where it finds none."""
    free = brief.model_copy(update={"requirements": brief.requirements.model_copy(update={"cube_side_mm": None})})
    return max(_found_mm(relaxed(free, placed), STARTS) for placed in {False, brief.placeable})


def _found_mm(problem: Problem, starts: int) -> float:
    best = sqp.search(problem, sqp.start_points(problem, 0, starts)).best
    return 0.0 if best is None else 2.0 * problem.lengths_mm(best.x)[SIDE]


def _none(brief: DesignBrief, stop: Callable[[], bool]) -> bool:
    if not none_feasible(relaxed(brief), BOXES, stop):
        return False
    if not brief.placeable:
        return True
    problem = relaxed(brief, placed=True)
    outwards = list(problem.lower)  # chains 1 and 2 at least as far out as chain 0, which has the least radius
    outwards[SHIFT] = max(outwards[SHIFT], 0.0)
    return _found_mm(replace(problem, lower=tuple(outwards)), _PLACED_STARTS) == 0.0


def kind(brief: DesignBrief) -> Kind:
    """Describes the machines that are excluded."""
    wider = brief.limits.parallelogram_width_mm is None
    return Kind(_width_mm(brief), _allowed_drives(brief), _kept_limits(brief), wider)


def _width_mm(brief: DesignBrief) -> float:
    """The least width of a parallelogram: a spring is between its rods."""
    stated = brief.limits.parallelogram_width_mm
    return stated or min(row.free_length_mm for row in catalogue.tension_spring.rows.values())


def relaxed(brief: DesignBrief, placed: bool = False) -> Problem:
    """Poses the lengths of a machine of the best of all hardware that may be used.

    Returns:
        Step 2 of a problem whose feasible lengths contain those of every machine that meets the requirements.
    """
    light = Corrections(
        replace(reference(), gravity_torque_N_m=0.0),
        overhead_mm=(0.0, 0.0),
        mass_share=1.0,
        friction_share=1.0,
        step_share=1.0,
        ball_friction_N=(0.0, 0.0),
        torque_margin_N_m=0.0,
    )
    each = []
    for motor, drive in drives(brief):
        low, high = ratios_of(brief) if drive == "capstan" else (1.0, 1.0)
        near, far = (Selection(motor, drive, ratio, _width_mm(brief), placed=placed) for ratio in (low, high))
        inertia = HandleInertia(_NEXT_TO_NONE_KG, 0.0, 0.0, motor_of(brief, motor).rotor_inertia_kg_m2 * low**2)
        each.append(to_requirements(brief, near, light, inertia, far=far))
    first = each[0]
    assert first.inertia is not None
    joints = [one.joints for one in each if one.joints is not None]
    least = {name: min(getattr(one, name) for one in joints) for name in ("friction_N_m", "encoder_count_deg")}
    rotor = min(one.inertia.joint_inertia_kg_m2 for one in each if one.inertia is not None)
    best = first.model_copy(
        update={
            "requirements": max((one.requirements for one in each), key=lambda task: task.joint_torque_N_m),
            "inertia": first.inertia.model_copy(update={"joint_inertia_kg_m2": rotor}),
            "joints": joints[0].model_copy(update=least),
            "bounds_mm": min((one.bounds_mm for one in each), key=lambda bounds: bounds.base_radius[0]),
        }
    )
    problem = step_problem(best, 2)
    side = max(problem.lower[SIDE], _LEAST_SIDE_MM / 2.0)
    lower = list(problem.lower)
    lower[SIDE] = min(side, problem.upper[SIDE])
    return replace(problem, lower=tuple(lower))


def impossible(brief: DesignBrief) -> Iterator[str]:
    """Gives the requirements that no hardware and no lengths meet, by closed forms alone."""
    required = brief.requirements
    if required.clearance_min_mm > CLEARANCE_MOST_MM:
        most = f"{CLEARANCE_MOST_MM:g} mm in any machine"
        yield f"requirements.clearance_min_mm = {required.clearance_min_mm:g} must be at most {most}"
    for name, force in (("force_N", required.force_N), ("peak_force_N", required.peak_force_N)):
        if force is not None and force > force_most_N():
            most = f"{force_most_N():.4g} N: no spring holds rods on their balls"
            yield f"requirements.{name} = {force:g} must be at most {most}"
