"""Fits and tolerances of lengths that the machine's dimensions ask of single parts, beyond those of their holes."""

from __future__ import annotations

from dataclasses import dataclass

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances import LENGTH_MM

SAME_MM = 1e-3
CORE_MM = 0.1  # by which an outer thread is drawn thinner than its tap drill, at most


@dataclass(frozen=True)
class Length:
    """A toleranced length of a part along one of its axes: between two coordinates, mm, and by how much either way."""

    axis: int
    start_mm: float
    end_mm: float
    tolerance_mm: float


@dataclass(frozen=True)
class Controlled:
    """What of a part is held closer than the general tolerance.

    Attributes:
        lengths: Toleranced lengths; coordinates along their axes count from their starts.
        fits: Diameter of an outer face, mm, and its fit.
        threads: Tap drill of an outer thread, mm, which it is drawn a little thinner than, and the thread.
    """

    lengths: tuple[Length, ...] = ()
    fits: tuple[tuple[float, str], ...] = ()
    threads: tuple[tuple[float, str], ...] = ()

    def datum(self, axis: int) -> float | None:
        """Gives where coordinates along an axis count from, mm; None: not stated."""
        return next((length.start_mm for length in self.lengths if length.axis == axis), None)

    def fit(self, diameter_mm: float) -> str:
        """Gives the fit of an outer diameter, "" where none is asked."""
        return next((fit for size, fit in self.fits if abs(size - diameter_mm) < SAME_MM), "")

    def thread(self, diameter_mm: float) -> str:
        """Gives the thread that an outer diameter stands for, "" where it is none."""
        return next((thread for drill, thread in self.threads if 0.0 <= drill - diameter_mm < CORE_MM), "")

    def tolerance(self, axis: int, value_mm: float) -> float | None:
        """Gives the tolerance of the length from the datum to a coordinate, mm; None: the general one."""
        ends = (n for n in self.lengths if n.axis == axis and abs(n.end_mm - value_mm) < SAME_MM)
        return next((length.tolerance_mm for length in ends), None)


def controlled(d: Dimensions) -> dict[str, Controlled]:
    """Gives by part number what is held closer than the general tolerance; parts that are not named have nothing."""
    layers, stem = d.layers, d.platform.stem_thread
    found = {
        "foot_block": Controlled((Length(1, layers.encoder_cheek_mm[1], layers.motor_cheek_mm[0], LENGTH_MM),)),
        "shoulder_shaft": Controlled(fits=((d.shaft.diameter_mm, "h6"),)),
        "handle_stem": Controlled(threads=((catalogue.screw(stem).tap_drill_mm, stem),)),
        "cross_bar": Controlled(_shoulders(d), ((d.forearm.bar_diameter_mm, "h6"),)),
    }
    if d.capstan is not None:
        found["upper_arm"] = Controlled((Length(1, layers.bearings_mm[0][1], layers.arm_mm[1], LENGTH_MM),))
        found["sector"] = Controlled((Length(1, layers.arm_mm[1], layers.bearings_mm[1][0], LENGTH_MM),))
    return found


def _shoulders(d: Dimensions) -> tuple[Length, ...]:
    """Distance of the shoulders on which the balls of a cross-bar sit."""
    from delta_cad.solids.forearm import rim_mm  # loads the CAD kernel

    half = d.forearm.width_mm / 2 - rim_mm(d.forearm)
    return (Length(1, -half, half, LENGTH_MM),)
