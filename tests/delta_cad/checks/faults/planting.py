"""Faults over the assembly of the committed design, made by rule: every kind for every kind of part it can apply to."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cache

import cadquery as cq
import numpy as np

from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.machine import Assembly
from delta_cad.design import Design, design_from_dict, load_design
from delta_cad.dimensions import dimensions
from delta_cad.solids.part import Occurrence, Part, location_of
from tests.committed import ROOT, changed
from tests.delta_cad.checks.faults.shapes import AXES, SHIFT_MM, differs, made_wrong
from tests.delta_cad.dimensions.paneled import with_panel as with_example


def quarter(k: int) -> np.ndarray:
    """(4, 4) quarter of a turn about the axis with a number."""
    turn = np.eye(4)
    i, j = (k + 1) % 3, (k + 2) % 3
    turn[i, i] = turn[j, j] = 0.0
    turn[j, i], turn[i, j] = 1.0, -1.0
    return turn


OTHERS: dict[str, dict[str, object]] = {
    "a smaller pinion": {"hardware__capstan_ratio": 6.0, "mechanism__base_radius_mm": 31.5},
    "a larger pinion": {"hardware__capstan_ratio": 4.73},
    "a smaller sector": {"hardware__sector_radius_mm": 36.0},
    "another cable": {"hardware__cable": "steel-0.45-7x7"},
    "another bearing": {"hardware__bearing": "618-8"},
    "another ball": {"hardware__ball_diameter_mm": 5.0},
    "another knob": {"hardware__knob": "din319-32"},
    "another foot": {"hardware__foot": "foot-m4-hole-16x8"},
    "a thicker arm": {"hardware__arm_thickness_mm": 12.0, "mechanism__base_radius_mm": 36.0},
    "a thicker base": {"hardware__base_plate_thickness_mm": 12.0},
    "another cube": {"cube__half_side_mm": 28.0, "cube__bottom_height_mm": 80.0},
    "longer arms": {"mechanism__upper_arm_length_mm": 93.0, "hardware__platform_thickness_mm": 10.5},
    "shorter forearms": {"mechanism__forearm_length_mm": 142.0},
    "a wider parallelogram": {"mechanism__parallelogram_width_mm": 56.0},
    "a wider platform": {"mechanism__platform_radius_mm": 26.0},
}
"""Designs whose parts are put in the place of those of the same name: wrong drawings, wrong orders."""


def paneled() -> Design:
    """The example that has a panel over it, in an outline that has some room."""
    return with_example(hardware__leads="bent", requirements__envelope_depth_mm=230.0)


@dataclass(frozen=True)
class Fault:
    """One fault: what it is done to, what is done, and the machine with it."""

    part: str
    kind: str
    assembly: Assembly

    @property
    def name(self) -> str:
        """Part and kind."""
        return f"{self.part}: {self.kind}"


@cache
def sound() -> Assembly:
    """The committed design's assembly."""
    return assemble(dimensions(design_from_dict(changed())))


def encoded() -> Design:
    """The committed design with motors that have an encoder of their own, and their leads, for which it is wider."""
    outline = {"requirements__envelope_width_mm": 330.0, "requirements__envelope_depth_mm": 330.0}
    outline |= {"mechanism__base_radius_mm": 47.0, "mechanism__platform_radius_mm": 40.0}
    motor = {"hardware__motor": "maxon-re30-310009-500", "hardware__encoder_at": "motor", "hardware__leads": "bent"}
    return design_from_dict(changed(**outline, **motor))


def direct() -> Design:
    """The design of the gallery whose motors turn the arms without a cable."""
    return load_design(ROOT / "docs/gallery/direct-83.json")


ALONE = ("shoulder_shaft", "upper_arm")
"""Numbers of what a direct drive has in a shape of its own."""


def machines() -> Iterator[tuple[Assembly, Design, tuple[str, ...]]]:
    """Yields sound machines and their designs, each with the numbers of the parts that those before it have not."""
    known: set[str] = set()
    for make in (lambda: design_from_dict(changed()), paneled, encoded, direct):
        design = make()
        whole = assemble(dimensions(design)) if known else sound()
        numbers = [p.number for p in whole.parts if p.number not in known]
        known.update(numbers)
        yield whole, design, (*numbers, *(ALONE if make is direct else ()))


@cache
def of_other(name: str) -> Assembly:
    """Assembly of one of `OTHERS`."""
    return assemble(dimensions(design_from_dict(changed(**OTHERS[name]))))


def faults(numbers: Collection[str] = (), others: bool = True, whole: Assembly | None = None) -> Iterator[Fault]:
    """Yields all faults, part by part.

    Args:
        numbers: Of the parts; none: all.
        others: Whether parts of other designs are planted, too, which the committed design's alone can be.
        whole: The sound machine; None: that of the committed design.
    """
    whole = whole or sound()
    for part in (p for p in whole.parts if not numbers or p.number in numbers):
        yield from _of_occurrences(whole, part)
        yield from _of_making(whole, part)
        for kind, solid in made_wrong(part.solid, project_own=part.make):
            yield Fault(part.number, kind, _with_part(whole, part.number, replace(part, solid=solid)))
        if others:
            yield from _of_other_designs(whole, part)


def _of_occurrences(whole: Assembly, part: Part) -> Iterator[Fault]:
    """One occurrence, of the chain with the number 1 where there is one, missing, doubled, moved or turned."""
    every = whole.occurrences
    one = next((o for o in every if o.part is part and "_1" in o.name), next(o for o in every if o.part is part))
    rest = tuple(o for o in every if o is not one)
    yield Fault(one.name, "missing", _without_fits(whole, rest, one.name))
    yield Fault(one.name, "doubled", replace(whole, occurrences=(*every, replace(one, name=f"{one.name}_copy"))))
    swapped = {"1": "2", "2": "0", "0": "1"}
    other = "".join(swapped.get(c, c) for c in one.link)
    if other != one.link:
        yield Fault(one.name, f"on {other}", _put(whole, replace(one, link=other)))
    for k, axis in enumerate(AXES):
        moved = np.eye(4)
        moved[k, 3] = SHIFT_MM
        yield Fault(one.name, f"shifted by {SHIFT_MM:g} mm along {axis}", _put(whole, _moved(one, moved)))
        turned = _about_middle(part, quarter(k))
        if differs(part.solid, part.solid.moved(cq.Location(location_of(turned)))):
            yield Fault(one.name, f"turned a quarter about {axis}", _put(whole, _moved(one, turned)))
        half = -np.eye(4)
        half[k, k] = half[3, 3] = 1.0
        turned = _about_middle(part, half)
        if differs(part.solid, part.solid.moved(cq.Location(location_of(turned)))):
            yield Fault(one.name, f"turned half way about {axis}", _put(whole, _moved(one, turned)))


def _of_making(whole: Assembly, part: Part) -> Iterator[Fault]:
    """Right in shape, wrong in material, mass or order."""
    others = {p.material.name: p.material for p in whole.parts if p.material.name != part.material.name}
    other = max(others.values(), key=lambda m: m.density_kg_m3 * (m.density_kg_m3 != part.material.density_kg_m3))
    weight = part.mass_g or float(part.solid.Volume()) * part.material.density_kg_m3 / 1e6
    for kind, wrong in (
        (f"of {other.name}", replace(part, material=other)),
        ("ten times its mass", replace(part, mass_g=10.0 * weight)),
        ("of another order", replace(part, order_code=f"{part.order_code} of another")),
    ):
        yield Fault(part.number, kind, _with_part(whole, part.number, wrong))


def _of_other_designs(whole: Assembly, part: Part) -> Iterator[Fault]:
    for name in OTHERS:
        (other,) = [p for p in of_other(name).parts if p.number == part.number] or [None]
        if other is not None and differs(part.solid, other.solid):
            yield Fault(part.number, f"of {name}", _with_part(whole, part.number, replace(part, solid=other.solid)))


def _moved(o: Occurrence, by: np.ndarray) -> Occurrence:
    """An occurrence moved by a (4, 4) transform in its part's own frame."""
    return replace(o, placement=o.placement @ by)


def _about_middle(part: Part, turn: np.ndarray) -> np.ndarray:
    """(4, 4) turn about the middle of a part's box."""
    middle = np.array(part.solid.BoundingBox().center.toTuple())
    turned = turn.copy()
    turned[:3, 3] = middle - turn[:3, :3] @ middle
    return turned


def _put(whole: Assembly, changed_one: Occurrence) -> Assembly:
    every = tuple(changed_one if o.name == changed_one.name else o for o in whole.occurrences)
    return replace(whole, occurrences=every)


def _without_fits(whole: Assembly, occurrences: tuple[Occurrence, ...], name: str) -> Assembly:
    """A machine without one part and without what the assembly knows of its fits."""
    fits = tuple(f for f in whole.fits if name not in (f.a, f.b))
    return replace(whole, occurrences=occurrences, fits=fits)


def _with_part(whole: Assembly, number: str, wrong: Part) -> Assembly:
    """A machine in which all parts of a number are made wrong."""
    every = tuple(replace(o, part=wrong) if o.part.number == number else o for o in whole.occurrences)
    return replace(whole, occurrences=every)
