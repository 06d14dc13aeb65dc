"""The front of machines: what more or less of one limit makes of all else, each point a design that parts allow.

For each hardware worth building, weighed by solids of its own, the customer's limits are eased and tightened one after
the other; what closed forms pass becomes a design file with all its figures, which `delta_cad build` makes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from delta_cad.design import NAME_LONGEST, Design
from delta_cad.dimensions import dimensions
from delta_cad.drive.friction import drive_friction_N_m
from delta_cad.mechanism.limits import EffectiveMass, Friction, Kappa
from delta_cad.mechanism.proof.extremes import worst_of
from delta_cad.mechanism.workspace import CubeSearch
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.hardware import Selection
from optimizer.codesign.relaxation import of_task
from optimizer.codesign.search import MOTORS, Lengths, Search
from optimizer.problem.brief import DesignBrief

ANY = 2.0  # limit that figures are asked for with: their values do not depend on it


@dataclass(frozen=True)
class Axis:
    """A limit that is moved.

    Attributes:
        name: Of the axis, and of its files.
        fields: Table and field of the limits that move together.
        figure: Field of `Figures` from which it begins where nothing is asked.
        factors: By which it is multiplied, from the easiest; the first at which there is no machine ends it.
    """

    name: str
    fields: tuple[str, ...]
    figure: str | None
    factors: tuple[float, ...]


AXES = (
    Axis("effective_mass", ("feel.effective_mass_max_kg",), "effective_mass_kg", (0.9, 0.75, 0.6, 0.5, 0.4, 0.3)),
    Axis("friction", ("feel.friction_max_N",), "friction_N", (0.9, 0.8, 0.7, 0.6, 0.5)),
    Axis("stiffness", ("feel.stiffness_min_N_mm",), "stiffness_N_mm", (1.15, 1.3, 1.5, 1.75, 2.0)),
    Axis("outline", ("requirements.envelope_width_mm", "requirements.envelope_depth_mm"), None, (1.2, 1.1, 0.9, 0.8)),
    Axis("cube", ("requirements.cube_side_mm",), None, (0.7, 0.85, 1.15, 1.3)),
)


@dataclass(frozen=True)
class Figures:
    """What a machine is like: at the worst place of its cube, with the masses of its hardware.

    Attributes:
        cube_side_mm: Side of the cube.
        outline_mm: Width and depth that the design states.
        effective_mass_kg: In the heaviest direction.
        friction_N: In the direction of most, nominal coefficients.
        stiffness_N_mm: At the knob, in the softest direction, actuators held.
        kappa: Condition number.
    """

    cube_side_mm: float
    outline_mm: tuple[float, float]
    effective_mass_kg: float
    friction_N: float
    stiffness_N_mm: float
    kappa: float

    @property
    def merits(self) -> tuple[float, ...]:
        """All of them, larger is better."""
        width, depth = self.outline_mm
        less = width * depth, self.effective_mass_kg, self.friction_N, self.kappa
        return self.cube_side_mm, self.stiffness_N_mm, *(-value for value in less)


@dataclass(frozen=True)
class MachinePoint:
    """One machine of the front.

    Attributes:
        axis: The limit that was moved; "asked" for what the customer asks.
        limit: Its value; None for that.
        choice: Hardware.
        design: The machine.
        figures: What it is like.
        on_front: Whether no other point is better in one figure and no worse in the others.
    """

    axis: str
    limit: float | None
    choice: Selection
    design: Design
    figures: Figures
    on_front: bool = True

    @property
    def name(self) -> str:
        """Of its design file, without ending."""
        return _name(self.choice, self.axis, self.limit)


def front(search: Search, points: list[MachinePoint]) -> None:
    """Traces the front of a task.

    Args:
        search: One of the task; its reports and its journal are used.
        points: Takes the points as they come, hardware after hardware; `marked` tells which of them are on the front.

    Raises:
        OutOfTimeError: The time of the search is over; `points` has those so far.
    """
    for number, (_, choice) in enumerate(search.ranked()):
        if number >= MOTORS and points:
            break
        candidate = search.refined(choice)
        search.log.ended(f"{choice.motor} {choice.drive}")
        if candidate is None:
            continue
        points.append(_point(search, "asked", None, candidate, search.brief))
        for axis in AXES:
            for point in _along(search, axis, points, candidate):
                points.append(point)


def best_machine(search: Search) -> MachinePoint | None:
    """Finds the machine of a task that closed forms pass, of the best hardware; nothing is built.

    Args:
        search: One of the task; its reports and its journal are used.
    """
    best: Candidate | None = None
    for number, (score, choice) in enumerate(search.ranked()):
        if best is not None and (number >= MOTORS or score <= best.score):
            break
        found = search.refined(choice)
        search.log.ended(f"{choice.motor} {choice.drive}")
        if found is not None and (best is None or found.score > best.score):
            best = found
    return None if best is None else _point(search, "asked", None, best, search.brief)


def hardware_of(points: Iterable[MachinePoint]) -> list[Selection]:
    """Gives the different hardware of points, in their order."""
    found: list[Selection] = []
    for point in points:
        found += [point.choice] if point.choice not in found else []
    return found


def _along(search: Search, axis: Axis, points: list[MachinePoint], candidate: Candidate) -> Iterator[MachinePoint]:
    """The points of one hardware along one axis."""
    (asked,) = (p for p in points if p.axis == "asked" and p.choice == candidate.choice)
    values = [search.brief.value(name) for name in axis.fields]
    if axis.figure is not None:
        values = [getattr(asked.figures, axis.figure)]
    if any(value is None for value in values):
        return
    start: Lengths | None = candidate.lengths_mm
    for factor in axis.factors:
        moved = [float(value) * factor for value in values if value is not None]
        brief = search.brief.with_values(dict(zip(axis.fields, moved, strict=True)))
        search.begin(f"{candidate.choice.motor}, {axis.name} {moved[0]:.4g}")
        trial = of_task(search, brief, dict(search.corrections))
        found = trial.fixed_point(candidate.choice, start, weighing=False)
        if found is None and axis.figure is not None:
            return
        if found is not None:
            start = found.lengths_mm
            yield _point(trial, axis.name, moved[0], replace(found, choice=candidate.choice), brief)


def _name(choice: Selection, axis: str, limit: float | None) -> str:
    size = "" if limit is None else f"-{limit:.4g}"
    return f"{choice.motor}-{choice.drive}-{axis}{size}".replace(".", "_")


def _point(search: Search, axis: str, limit: float | None, candidate: Candidate, brief: DesignBrief) -> MachinePoint:
    known = search.corrections[candidate.choice.motor, candidate.choice.drive]
    own = _name(candidate.choice, axis, limit)
    name = f"{brief.name[: NAME_LONGEST - 1 - len(own)]}-{own}"  # of its folder when it is built
    design = candidate.design.model_copy(update={"name": name})
    return MachinePoint(axis, limit, candidate.choice, design, figures_of(design, candidate, known.ball_friction_N))


def figures_of(design: Design, candidate: Candidate, ball_friction_N: tuple[float, float]) -> Figures:
    """Computes what a machine is like, with the masses of the last machine of its hardware that was weighed.

    Args:
        design: The machine.
        candidate: What it was made from.
        ball_friction_N: What its ball joints rub with at the knob: along z, and square to it.
    """
    from delta_cad.structure.report import stiffness

    choice, lengths = candidate.choice, candidate.lengths_mm
    inertia = candidate.corrections.mass_estimate.inertia(lengths[0], lengths[1], choice.ratio)
    limits = EffectiveMass(ANY, inertia), Friction(ANY, drive_friction_N_m(design)[1], *ball_friction_N), Kappa(ANY)
    search, g = CubeSearch(design.workspace), design.geometry
    mass, friction, kappa = (worst_of(search, g, limit, limit.figures[0]).value for limit in limits)
    outline = design.requirements.envelope_width_mm, design.requirements.envelope_depth_mm
    softest = float(stiffness(dimensions(design)).softest.stiffness_N_mm.min())
    return Figures(2.0 * design.cube.half_side_mm, outline, mass, friction, softest, kappa)


def marked(points: list[MachinePoint]) -> list[MachinePoint]:
    """Tells which points no other beats."""
    merits = np.array([point.figures.merits for point in points])
    told = []
    for point, own in zip(points, merits, strict=True):
        beaten = (merits >= own).all(axis=1) & (merits > own).any(axis=1)
        told.append(replace(point, on_front=not beaten.any()))
    return told
