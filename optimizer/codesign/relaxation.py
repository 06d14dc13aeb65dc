"""Relaxation of limits: how much one or several together must change for a machine, and the cost of each set limit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from math import sqrt

from delta_cad.dimensions import CLEARANCE_MOST_MM
from optimizer.codesign.candidate import Candidate, Start
from optimizer.codesign.corrections import Corrections
from optimizer.codesign.hardware import WIDTHS, Selection, drives, motor_of, ratios_of
from optimizer.codesign.lengths import CONVERGED, ENOUGH, best_lengths
from optimizer.codesign.search import Search
from optimizer.codesign.search_log import RELAXATIONS, SearchLog
from optimizer.problem.brief import DesignBrief
from optimizer.search.clock import OutOfTimeError

_OUTLINE = "requirements.envelope_width_mm", "requirements.envelope_depth_mm"
_LEAN = ("limits.lean_max_deg",)
_CLEARANCE = "requirements.clearance_min_mm"
_EASED: Mapping[tuple[str, ...], bool] = {  # in the order in which they are spared where several must give
    _OUTLINE: True,
    ("requirements.height_max_mm",): True,
    ("requirements.force_N",): False,
    ("requirements.peak_force_N",): False,
    ("requirements.cube_side_mm",): False,
    ("feel.kappa_max",): True,
    ("feel.couple_index_min",): False,
    ("feel.effective_mass_max_kg",): True,
    ("feel.friction_max_N",): True,
    ("feel.position_step_max_mm",): True,
    ("feel.stiffness_min_N_mm",): False,
    (_CLEARANCE,): False,
    _LEAN: True,
    ("limits.outline_radius_max_mm",): True,
}
"""Fields that give together -> whether a larger value is easier to keep."""
MOST = 10.0  # times a limit is eased at most
_FIRST_FACTORS = 1.5, 2.25, 3.4  # times, tried before that: the largest cube of a huge outline asks too much of a motor
FINE = 1.05  # factor to which it is found how much is enough
_COSTED = {
    # table and field -> factor, and what is added
    "requirements.envelope_width_mm": (1.0, 5.0),
    "requirements.envelope_depth_mm": (1.0, 5.0),
    "requirements.height_max_mm": (1.0, 5.0),
    "requirements.force_N": (0.9, 0.0),
    "requirements.cube_side_mm": (0.95, 0.0),
    "feel.kappa_max": (1.05, 0.0),
    "feel.effective_mass_max_kg": (1.25, 0.0),
    "feel.friction_max_N": (1.1, 0.0),
    "feel.position_step_max_mm": (1.1, 0.0),
    "feel.couple_index_min": (0.9, 0.0),
    "limits.lean_max_deg": (1.0, 2.0),
    "limits.outline_radius_max_mm": (1.0, 2.0),
}
RESOLUTION = max(ENOUGH, CONVERGED)  # share of a score to which lengths are found


@dataclass(frozen=True)
class Relaxation:
    """One limit, or those of one outline, that would be enough to give.

    Attributes:
        fields: Table and field of each.
        requested: Values asked for.
        enough: Values at which closed forms have a machine.
        brief: The task with these.
        start: That machine, from which one that is built may begin.
    """

    fields: tuple[str, ...]
    requested: tuple[float, ...]
    enough: tuple[float, ...]
    brief: DesignBrief
    start: Start

    def __str__(self) -> str:
        return ", ".join(
            f"{name} = {enough:.4g} instead of {requested:g}"
            for name, enough, requested in zip(self.fields, self.enough, self.requested, strict=True)
        )

    def further(self, factor: float) -> Relaxation:
        """The same with limits eased by another factor: closed forms do not see all."""
        task = _eased(self.brief, self.fields, self.enough, factor)
        return replace(self, brief=task, enough=tuple(task.value(name) or 0.0 for name in self.fields))

    @property
    def share(self) -> float:
        """By which factor it gives."""
        return max(max(a / b, b / a) for a, b in zip(self.enough, self.requested, strict=True))


def minimal_relaxations(search: Search) -> list[Relaxation]:
    """Finds the limits of which each alone would be enough to give, with how much, the least change first.

    Closed forms have a machine with any one of them given up. Where no limit alone is enough within `MOST`, some that
    give by one factor together, none of which can be left out. Where the time is over, those that were found.

    Args:
        search: One that found no machine; its time and its reports are used.
    """
    hardware = list(strongest(search.brief))
    groups = [fields for fields in _EASED if all(_gives(search.brief, name) for name in fields)]
    beyond = search.brief.requirements.clearance_min_mm > CLEARANCE_MOST_MM  # which no other limit makes up for
    only = [(_CLEARANCE,)] if beyond else groups
    found: list[Relaxation] = []
    with suppress(OutOfTimeError):
        for number, fields in enumerate(only):
            search.phase = RELAXATIONS._replace(done=number, total=len(only))
            found += [one for one in (_relaxation(search, fields, hardware),) if one is not None]
        if not found and len(groups) > 1:
            found += [one for one in (_together(search, groups, hardware),) if one is not None]
    return sorted(found, key=lambda one: one.share)


def _together(search: Search, groups: list[tuple[str, ...]], hardware: list[Selection]) -> Relaxation | None:
    """Limits that are enough where they give together, none of which can be left out; None where all are not."""

    def fields(of: list[tuple[str, ...]]) -> tuple[str, ...]:
        return tuple(name for group in of for name in group)

    def able(of: list[tuple[str, ...]]) -> list[Selection]:
        """The hardware from the first on that does."""
        task = _eased(search.brief, fields(of), _required(search, fields(of)), MOST)
        first = next((k for k, choice in enumerate(hardware) if _possible(search, task, choice) is not None), None)
        return [] if first is None else hardware[first:]

    if not (left := able(groups)):
        return None
    for group in list(groups):  # what is not needed is left out; of two both are, since none alone is enough
        if len(groups) > 2 and (does := able(rest := [one for one in groups if one != group])):
            groups, left = rest, does
    return _relaxation(search, fields(groups), left)


def _relaxation(search: Search, fields: tuple[str, ...], hardware: list[Selection]) -> Relaxation | None:
    """Finds how much is enough of limits that give together, of the hardware that needs least; None: more than MOST."""
    search.begin(f"how far {' and '.join(fields)} must change")
    requested = _required(search, fields)
    relaxation: Relaxation | None = None

    def feasible(choice: Selection, factor: float, near: Start | None = None) -> bool:
        nonlocal relaxation
        task = _eased(search.brief, fields, requested, factor)
        if (found := _possible(search, task, choice, near)) is not None:
            enough = tuple(float(task.value(name) or 0.0) for name in fields)
            relaxation = Relaxation(fields, requested, enough, task, found)
        return found is not None

    high, steps = MOST, _FIRST_FACTORS if fields in (_OUTLINE, _LEAN) else ()
    with suppress(OutOfTimeError):
        for choice in hardware:
            least = high if relaxation is None else high / FINE  # of another hardware: only what needs less
            low = 1.0
            for factor in (*(step for step in steps if step < least), least):
                if factor > 1.0 and feasible(choice, factor):
                    break
                low = factor
            else:
                continue
            high = factor
            while high / low > FINE:
                middle = sqrt(low * high)
                low, high = (
                    (low, middle) if feasible(choice, middle, relaxation and relaxation.start) else (middle, high)
                )
    return relaxation


def strongest(brief: DesignBrief) -> Iterator[Selection]:
    """Gives the hardware that represents all permitted: with the most torque, and with the lightest rotor."""
    low, high = ratios_of(brief)
    width = brief.limits.parallelogram_width_mm or WIDTHS[0]
    middle = round(sqrt(low * high), 2)
    for drive, ratio in (("direct", 1.0), ("capstan", middle)):
        motors = [motor for motor, able in drives(brief) if able == drive]
        if motors:
            most = max(motors, key=lambda name: motor_of(brief, name).nominal_torque_N_m)
            lightest = min(motors, key=lambda name: motor_of(brief, name).rotor_inertia_kg_m2)
            yield from (Selection(motor, drive, ratio, width) for motor in dict.fromkeys((most, lightest)))


def _gives(brief: DesignBrief, name: str) -> bool:
    """Whether a limit may give: one that is asked, of the clearance what is more than usual."""
    value = brief.value(name)
    return value is not None and (name != _CLEARANCE or value > _usual_clearance_mm(brief))


def _usual_clearance_mm(brief: DesignBrief) -> float:
    usual: float = type(brief.requirements).model_fields[_CLEARANCE.partition(".")[2]].default
    return usual


def _required(search: Search, fields: tuple[str, ...]) -> tuple[float, ...]:
    return tuple(float(search.brief.value(name) or 0.0) for name in fields)


def _eased(brief: DesignBrief, fields: tuple[str, ...], requested: tuple[float, ...], factor: float) -> DesignBrief:
    """The same task with limits that give by a factor."""
    grows = {name: more for names, more in _EASED.items() for name in names}
    eased = {name: a * factor if grows[name] else a / factor for name, a in zip(fields, requested, strict=True)}
    if _CLEARANCE in eased:
        eased[_CLEARANCE] = max(eased[_CLEARANCE], _usual_clearance_mm(brief))
    return brief.with_values(eased)


def of_task(search: Search, brief: DesignBrief, known: dict[tuple[str, str], Corrections]) -> Search:
    """Gives the search of another task with what is known of hardware; nothing was tried in it."""
    return replace(search, brief=brief, log=SearchLog(), corrections=known, built_candidate=None)


def _possible(search: Search, brief: DesignBrief, choice: Selection, near: Start | None = None) -> Start | None:
    """A machine of a task in closed forms, of the hardware as they change it; None where there is none.

    Args:
        search: The search.
        brief: The task.
        choice: Hardware.
        near: One of an easier task, from which it begins: that most often lacks what this one lacks.
    """
    known = {} if near is None else {(choice.motor, choice.drive): near.corrections}

    def compute() -> Start | None:
        found = of_task(search, brief, known).fixed_point(choice, near and near.lengths_mm, weighing=False)
        return None if found is None else Start(found.choice, found.lengths_mm, found.corrections)

    return search.memoize("possible", (brief, choice, near), compute, Start | None)


@dataclass(frozen=True)
class Cost:
    """What a limit costs.

    Attributes:
        field: Table and field of the requirements.
        requested: Its value.
        wider: Another, which is easier to keep.
        gain: By which what is sought would be better then; mm or kg.
    """

    field: str
    requested: float
    wider: float
    gain: float


def costs(brief: DesignBrief, candidate: Candidate, corrections: Corrections) -> list[Cost]:
    """Estimates what each stated limit costs, with the hardware of a machine and what was learnt of it.

    Returns:
        The limits that cost more than the search resolves, the dearest first.
    """
    start = candidate.lengths_mm
    now = best_lengths(brief, candidate.choice, corrections, start)
    found: list[Cost] = []
    for field, (factor, added) in _COSTED.items():
        requested = brief.value(field)
        if now is None or requested is None:
            continue
        wider = requested * factor + added
        better = best_lengths(brief.with_values({field: wider}), candidate.choice, corrections, start)
        if better is not None and better.score - now.score > RESOLUTION * abs(now.score):
            found.append(Cost(field, requested, wider, better.score - now.score))
    return sorted(found, key=lambda cost: -cost.gain)
