"""What the manual tells of each step: parts with their colours, tools, torques, adhesives, checks, and its picture."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly, Insertion, Step, Unit
from delta_cad.dimensions.platform import MOUNT_SCREW
from delta_cad.export.bom import BomRow
from delta_cad.structure.strength import tightening_N_m

_Colour = tuple[float, float, float]
_PER_UNIT = {1: "Make one", 2: "Make two", 3: "Make three", 6: "Make six"}


@dataclass(frozen=True)
class _Line:
    """A part or a supply of a step: its colour in the picture as CSS has it, or "", and the row of the bill."""

    colour: str
    item: int
    number: str
    description: str
    quantity: int


@dataclass(frozen=True)
class _StepView:
    """A step as it is told.

    Attributes:
        number: Counted through the manual.
        title: As the step's.
        words: Its sentences.
        parts: What comes in.
        units: What comes in whole: its title and how many.
        tools: Tools, keys included.
        torques: What is tightened, and to what.
        supplies: Adhesives and the like.
        checks: What is looked at.
        picture: Name of its file.
        is_open: Whether the picture leaves out what hides the work.
    """

    number: int
    title: str
    words: tuple[str, ...]
    parts: tuple[_Line, ...]
    units: tuple[tuple[str, str, int], ...]
    tools: tuple[str, ...]
    torques: tuple[str, ...]
    supplies: tuple[_Line, ...]
    checks: tuple[str, ...]
    picture: str
    is_open: bool


@dataclass
class Chapter:
    """Units of one kind, told once.

    Attributes:
        kind: As theirs.
        title: Heading.
        made: How many are made, in words.
        steps: The steps of the first.
    """

    kind: str
    title: str
    made: str
    steps: list[_StepView] = field(default_factory=list)


@dataclass(frozen=True)
class _Scene:
    """A step to be drawn: what it brings in, what is there, and the file's name."""

    step: Step
    coming: tuple[tuple[Insertion, tuple[str, ...]], ...]
    there: tuple[str, ...]
    picture: str


def scenes(order: Sequence[Unit]) -> Iterator[tuple[Unit, list[_Scene]]]:
    """Goes through the first unit of each kind, step by step.

    Yields:
        The unit and its steps, each with what is there before it.
    """
    made: dict[str, tuple[str, ...]] = {}
    kinds: set[str] = set()
    for unit in order:
        there: list[str] = []
        found = []
        for k, step in enumerate(unit.steps):
            coming = tuple(
                (insertion, (*insertion.names, *(name for part in insertion.units for name in made[part])))
                for insertion in step.insertions
            )
            found.append(_Scene(step, coming, tuple(there), f"{unit.kind.replace(' ', '-')}-{k + 1}.png"))
            there += [name for _, names in coming for name in names]
        made[unit.name] = tuple(there)
        if unit.kind not in kinds:
            kinds.add(unit.kind)
            yield unit, found


def chapters(assembly: Assembly, rows: Sequence[BomRow], drawn: Mapping[str, Mapping[str, _Colour]]) -> list[Chapter]:
    """Tells the whole order.

    Args:
        assembly: The machine with its order.
        rows: Its bill of materials.
        drawn: Picture -> part number -> colour.
    """
    by_number = {row.part_number: row for row in rows}
    part = {o.name: o.part for o in assembly.occurrences}
    counts, titles = Counter(unit.kind for unit in assembly.order), {unit.name: unit for unit in assembly.order}
    found, number = [], 0
    for unit, reported in scenes(assembly.order):
        count = counts[unit.kind]
        chapter = Chapter(unit.kind, unit.title, _PER_UNIT.get(count, f"Make {count}") if count > 1 else "")
        for scene in reported:
            number += 1
            colours, step = drawn.get(scene.picture, {}), scene.step
            amounts: Counter[str] = Counter()
            colour_of: dict[str, str] = {}
            for insertion, _ in scene.coming:
                for name in insertion.names:
                    ordered = part[name].piece_of or part[name].number
                    amounts[ordered] += 0 if part[name].piece_of else 1
                    colour_of.setdefault(ordered, _css(colours.get(ordered)))
            units = Counter(titles[name].kind for insertion, _ in scene.coming for name in insertion.units)
            heads = {titles[name].kind: titles[name].title for insertion, _ in scene.coming for name in insertion.units}
            chapter.steps.append(
                _StepView(
                    number=number,
                    title=step.title,
                    words=step.words,
                    parts=tuple(_line(by_number[n], amounts[n], colour_of[n]) for n in amounts),
                    units=tuple((_css(colours.get(kind)), heads[kind], n) for kind, n in units.items()),
                    tools=(*_keys_of(step, part), *step.tools),
                    torques=tuple(_torques_of(step, part)),
                    supplies=tuple(_line(by_number[n], 0, "") for n in step.supplies),
                    checks=step.checks,
                    picture=scene.picture,
                    is_open=bool(step.unseen),
                )
            )
        found.append(chapter)
    return found


def _line(row: BomRow, amount: int, colour: str) -> _Line:
    return _Line(colour, row.item, row.part_number, row.description, amount)


def _css(colour: _Colour | None) -> str:
    return "" if colour is None else "#" + "".join(f"{round(255 * one):02x}" for one in colour)


def _row(number: str) -> catalogue.Screw | catalogue.SetScrew | None:
    """Row of the catalogue of a screw's part number; None of another part."""
    found = re.fullmatch(r"(set_screw|tension_screw|screw)_((low-)?M[\d.]+)x[\d.]+", number)
    if found is None:
        return None
    family = catalogue.set_screw if found[1] == "set_screw" else catalogue.low_screw if found[3] else catalogue.screw
    return family(found[2])


def _keys_of(step: Step, part: Mapping[str, object]) -> tuple[str, ...]:
    """Gives the hexagon keys that a step's screws take."""
    found: dict[str, None] = {}
    for name in step.tightened:
        row = _row(getattr(part[name], "number", ""))
        if row is not None:
            found[f"hexagon key {row.socket_mm:g}"] = None
    if found:
        found["torque key"] = None
    return tuple(found)


def _torques_of(step: Step, part: Mapping[str, object]) -> Iterator[str]:
    """Tells to what a step's screws are tightened, one line a size."""
    numbers = Counter(getattr(part[name], "number", "") for name in step.tightened)
    for number, count in numbers.items():
        row, torque = _row(number), step.torque_N_m
        if torque is None and isinstance(row, catalogue.Screw):
            torque = tightening_N_m(row)
        if row is not None and torque is not None:
            yield f"{count} × {number.replace('_', ' ')}: {torque:.1f} N m"
    if "mount_screw" in step.supplies:
        yield f"screws {MOUNT_SCREW} of the base: {tightening_N_m(catalogue.screw(MOUNT_SCREW)):.1f} N m"
