"""Sections from loads and stiffness: closed forms by which what is made grows with forces and lengths.

The least sizes hold 26 N/mm at the knob with arms of 91 mm (`examples/synthesized.json`), and serve for 15 N/mm with
arms of up to 95 mm: the rest is for what else gives. Another machine is to be held by k N/mm with lengths L: what is
asked of the design, or what keeps the handle's give under the whole force within a share of the upper arm's length. A
bar of length L and second moment I gives `L^3 / (3 E I)`: each section keeps the share of the whole give that it has
there where `I ~ k L^3`. A flat plate's thickness, whose width is given, goes with the cube root of that, a round bar's
diameter with the fourth root.
"""

from __future__ import annotations

from math import ceil

from delta_cad.design import Design
from delta_cad.design.process import softer
from delta_cad.design.record import DesignRequirements

_STIFFNESS_N_MM, _ARM_MM = 15.0, 95.0  # for which the least sizes are enough: see above
_GIVE = 0.005  # of the upper arm's length: the handle's give under its lasting force, where no stiffness is asked
_STEP_MM = 0.5  # of what is milled or turned to size
_STEMS_MM = (10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 25.0, 30.0)  # round bars in stock
_ROUNDING = 1e-9


def largest_force_N(required: DesignRequirements) -> float:
    """Gives the largest force at the handle that a design asks for, of the lasting one and the peak, N."""
    return max(required.force_N, required.peak_force_N or 0.0)


def _stiffness_wanted_N_mm(design: Design) -> float:
    """Stiffness at the knob for which sections are made, N/mm: the required one, or `_GIVE` under the force."""
    required = design.requirements
    by_force = required.force_N / (_GIVE * design.mechanism.upper_arm_length_mm)
    return by_force if required.stiffness_min_N_mm is None else max(by_force, required.stiffness_min_N_mm)


def growth(design: Design, number: str = "") -> float:
    """Computes by how much second moments grow over those of the least sizes: `k L^3` over the reference's, at least 1.

    The length is the upper arm's: others grow with it. A printed part grows as much more as its material is softer.

    Args:
        design: The design.
        number: Number of a part that may be printed; "": of one that is cut.
    """
    length = design.mechanism.upper_arm_length_mm / _ARM_MM
    times = softer(design.hardware, number) if number else 1.0
    return max(_stiffness_wanted_N_mm(design) / _STIFFNESS_N_MM * length**3 * times, 1.0)


def plate_mm(least_mm: float, grown: float) -> float:
    """Gives a plate's thickness whose second moment has grown, its width kept, mm.

    Args:
        least_mm: Of the reference.
        grown: Result of `growth`.
    """
    return _stepped(least_mm, least_mm * grown ** (1.0 / 3.0))


def bar_mm(least_mm: float, grown: float) -> float:
    """Gives a round bar's diameter whose second moment has grown, mm; arguments as of `plate_mm`."""
    return _stepped(least_mm, least_mm * grown**0.25)


def stem_mm(grown: float) -> float:
    """Gives the handle's stem, the thinnest bar in stock that is stiff enough, mm; the largest where none is."""
    needed = _STEMS_MM[0] * grown**0.25 - _ROUNDING
    return next((size for size in _STEMS_MM if size >= needed), _STEMS_MM[-1])


def _stepped(least_mm: float, needed_mm: float) -> float:
    """Rounds a size up to the next step above its least."""
    return least_mm + _STEP_MM * ceil((needed_mm - least_mm) / _STEP_MM - _ROUNDING)
