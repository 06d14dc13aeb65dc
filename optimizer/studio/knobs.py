"""The sliders of the studio: which field of a requirements file each moves, over which range."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from delta_cad.design.feel_defaults import COUPLE_INDEX
from optimizer.codesign.corrections import KAPPA_MAX
from optimizer.problem.brief import DesignBrief

WIDTH, DEPTH = "requirements.envelope_width_mm", "requirements.envelope_depth_mm"
CUBE, FORCE, PEAK = "requirements.cube_side_mm", "requirements.force_N", "requirements.peak_force_N"
KAPPA, MASS, FRICTION = "feel.kappa_max", "feel.effective_mass_max_kg", "feel.friction_max_N"
STIFFNESS, COUPLE = "feel.stiffness_min_N_mm", "feel.couple_index_min"
HEIGHT, CLEARANCE = "requirements.height_max_mm", "requirements.clearance_min_mm"
RATIO = "hardware.capstan_ratio"


@dataclass(frozen=True)
class Knob:
    """A slider.

    Attributes:
        field: Table and field of a requirements file.
        words: What the page calls it.
        unit: Its unit; "" for none.
        low: Least value.
        high: Largest value.
        step: Of the slider.
        start: Value that a limit begins with that was not stated.
        eases: 1 where a larger value is easier to meet, -1 where a smaller one is.
        optional: Whether it may be left out of the file.
        without: What holds where it is left out.
    """

    field: str
    words: str
    unit: str
    low: float
    high: float
    step: float
    start: float
    eases: int
    optional: bool = True
    without: str = "not limited"

    def holding(self, value: float | None) -> Knob:
        """Gives the same slider with a range that holds a value."""
        if value is None or self.low <= value <= self.high:
            return self
        return replace(self, low=min(self.low, value), high=max(self.high, 1.5 * value))


_DEFAULT = "{:g}, the default".format

KNOBS = (
    Knob(WIDTH, "outline width", "mm", 120.0, 600.0, 1.0, 270.0, 1, optional=False),
    Knob(DEPTH, "outline depth", "mm", 120.0, 600.0, 1.0, 220.0, 1, optional=False),
    Knob(CUBE, "cube side, at least", "mm", 10.0, 300.0, 1.0, 75.0, -1),
    Knob(HEIGHT, "height, at most", "mm", 80.0, 900.0, 1.0, 300.0, 1),
    Knob(FORCE, "continuous force", "N", 0.5, 20.0, 0.1, 3.0, -1, optional=False),
    Knob(PEAK, "peak force", "N", 1.0, 60.0, 0.1, 8.0, -1),
    Knob(KAPPA, "condition number κ, at most", "", 1.2, 4.0, 0.01, 2.27, 1, without=_DEFAULT(KAPPA_MAX)),
    Knob(MASS, "effective mass, at most", "kg", 0.1, 2.0, 0.005, 0.4, 1),
    Knob(FRICTION, "friction, at most", "N", 0.1, 4.0, 0.01, 0.8, 1),
    Knob(STIFFNESS, "stiffness, at least", "N/mm", 1.0, 60.0, 0.5, 15.0, -1),
    Knob(COUPLE, "rotational stiffness index, at least", "", 0.05, 0.75, 0.01, 0.4, -1, without=_DEFAULT(COUPLE_INDEX)),
)
_SHOWN = (FORCE, PEAK, KAPPA, MASS, FRICTION, STIFFNESS, COUPLE)  # of every task; the others where they are stated


def knobs_of(brief: DesignBrief) -> tuple[Knob, ...]:
    """Lists the sliders of a task: an outline or a cube as it has them, all limits on feel, a height where stated."""
    shown = {*_SHOWN, *((WIDTH, DEPTH) if brief.outline_mm else ())}
    shown |= {name for name in (CUBE, HEIGHT) if brief.value(name) is not None}
    needed = {CUBE} if brief.goal.minimize else set()  # the least machine without a cube is none
    return tuple(
        replace(one, optional=one.optional and one.field not in needed).holding(brief.value(one.field))
        for one in KNOBS
        if one.field in shown
    )


def values_of(brief: DesignBrief, knobs: tuple[Knob, ...]) -> dict[str, float | None]:
    """Reads the values of sliders from a task: field -> value; None where it is not limited."""
    return {one.field: brief.value(one.field) for one in knobs}


def legal(knobs: tuple[Knob, ...], values: Mapping[str, Any]) -> dict[str, float | None]:
    """Gives values within the ranges of their sliders.

    Raises:
        ValueError: There is no such slider, or a value is no number, or missing where one is needed.
    """
    known, found = {one.field: one for one in knobs}, dict[str, float | None]()
    for field, value in values.items():
        if (knob := known.get(field)) is None:
            raise ValueError(f"{field}: is no slider of this page")
        if value is None and knob.optional:
            found[field] = None
        elif isinstance(value, bool) or not isinstance(value, int | float) or not -1e9 < value < 1e9:
            raise ValueError(
                f"{knob.words}: must be a number between {knob.low:g} and {knob.high:g} {knob.unit}".strip()
            )
        else:
            found[field] = round(min(max(float(value), knob.low), knob.high), 6)
    return found
