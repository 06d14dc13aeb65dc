"""Requirements of the machine on single parts in addition to their holes: fits, lengths, and run-out."""

from __future__ import annotations

from dataclasses import dataclass, replace

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import PINION_TURNED_MM, RIM_TURNED_MM
from delta_cad.dimensions.forearm import LINER_GLUE_MM
from delta_cad.dimensions.joint import CLEARANCE_TOLERANCE_MM
from delta_cad.dimensions.tolerances import (
    CHIP_HEIGHT_MM,
    COAXIAL_MM,
    FITTED_RA_UM,
    LENGTH_MM,
    LINER_TURNED_MM,
    SPIGOT_TURNED_MM,
    TRUE_MM,
    TUBE_SHORTER_MM,
    deviations_um,
)
from delta_cad.dimensions.tolerances.edges import Edge, functional_edges
from delta_cad.dimensions.tolerances.machine import square_zones
from delta_cad.dimensions.tolerances.square import SHOULDER

SAME_MM = 1e-3
_SHOULDER_MM = 1.0  # of diameter, by which a head is wider than its journal where something stands on it
_LAPPING_MM = 0.015  # of a shell's seat: the usual 0.005 to 0.01 mm of a side, from memory; not measured
_CORE_MM = 0.1  # by which an outer thread is drawn thinner than its tap drill, at most


@dataclass(frozen=True)
class Length:
    """A toleranced length of a part along one of its axes: between two coordinates, mm.

    `tolerance_mm` is by how much it may be shorter, and longer where `upper_mm` does not say otherwise.
    """

    axis: int
    start_mm: float
    end_mm: float
    tolerance_mm: float
    upper_mm: float | None = None

    @property
    def deviations_mm(self) -> tuple[float, float]:
        """Lower and upper deviation."""
        return -self.tolerance_mm, self.tolerance_mm if self.upper_mm is None else self.upper_mm

    @property
    def text(self) -> str:
        """Both deviations as a drawing has them, such as "±0.02" or "0/-0.3"."""
        lower, upper = self.deviations_mm
        return f"±{upper:g}" if lower == -upper else f"{signed(upper)}/{signed(lower)}"


@dataclass(frozen=True)
class Round:
    """What is asked of a round face that is no bore.

    Attributes:
        diameter_mm: Nominal; of an outer thread its tap drill, which it is drawn a little thinner than.
        fit: ISO 286 class, or "".
        either_mm: By how much the diameter may be off, either way; 0: by its fit, or as the general tolerance has it.
        thread: Such as "M6", or "".
        surface_um: Roughness Ra; None: the general one.
        where: What is told beside the size: where, or when, it holds.
    """

    diameter_mm: float
    fit: str = ""
    either_mm: float = 0.0
    thread: str = ""
    surface_um: float | None = None
    where: str = ""

    @property
    def deviations_mm(self) -> tuple[float, float] | None:
        """Lower and upper deviation of the diameter; None: none of its own."""
        if self.fit:
            lower, upper = deviations_um(self.fit, self.diameter_mm)
            return lower / 1000.0, upper / 1000.0
        return (-self.either_mm, self.either_mm) if self.either_mm else None

    def is_of(self, diameter_mm: float) -> bool:
        """Decides whether a face of a diameter is what is meant."""
        off = self.diameter_mm - diameter_mm
        return 0.0 <= off < _CORE_MM if self.thread else abs(off) < SAME_MM


@dataclass(frozen=True)
class Controlled:
    """What of a part is held closer than the general tolerance.

    Attributes:
        lengths: Toleranced lengths; coordinates along their axes count from their starts.
        depths: Toleranced depths of bores, which their callouts tell.
        rounds: Of round faces that are no bores.
        coaxial: Diameters of what is on one axis with the fitted one, mm, each with the width of its zone.
        seat: Axis and coordinate, mm, of the plane that it is put on, datum A; None: the largest across its bores.
        shoulder: Where a plane of a turned part stands square to its axis, and its zone, mm; None: none has to.
        groove_mm: Diameters at the bottom of a helical groove, as which it is modelled, and over its lands; None: none.
        edges: Edges that have a function.
    """

    lengths: tuple[Length, ...] = ()
    depths: tuple[Length, ...] = ()
    rounds: tuple[Round, ...] = ()
    coaxial: tuple[tuple[float, float], ...] = ()
    seat: tuple[int, float] | None = None
    shoulder: tuple[float, float] | None = None
    groove_mm: tuple[float, float] | None = None
    edges: tuple[Edge, ...] = ()

    def datum(self, axis: int) -> float | None:
        """Gives where coordinates along an axis count from, mm; None: not stated."""
        return next((length.start_mm for length in self.lengths if length.axis == axis), None)

    def round_of(self, diameter_mm: float) -> Round | None:
        """Gives what is asked of an outer diameter; None: no more than of any."""
        return next((one for one in self.rounds if one.is_of(diameter_mm)), None)

    def length(self, axis: int, value_mm: float) -> Length | None:
        """Gives the length from the datum to a coordinate; None: the general tolerance holds for it."""
        return next((n for n in self.lengths if n.axis == axis and abs(n.end_mm - value_mm) < SAME_MM), None)


def signed(value_mm: float) -> str:
    """Writes a deviation with its sign, 0 without."""
    return f"{value_mm:+g}" if value_mm else "0"


def controlled(d: Dimensions) -> dict[str, Controlled]:
    """Gives by part number what is held closer than the general tolerance; parts that are not named have nothing."""
    layers, stem, shaft, forearm = d.layers, d.platform.stem_thread, d.shaft, d.forearm
    journal = Round(shaft.diameter_mm, "h6", surface_um=FITTED_RA_UM[6])
    bar = Round(forearm.bar_diameter_mm, "h6", surface_um=FITTED_RA_UM[6])
    seat, gauged = forearm.seat_diameter_mm, 2 * CLEARANCE_TOLERANCE_MM
    liner, pin = 2 * forearm.liner_radius_mm, forearm.pin_diameter_mm
    lapped = f"lapped in its cup with its ball, at assembly; delivered SØ{seat - _LAPPING_MM:.3g} ±{gauged:g}"
    wide = Length(1, layers.encoder_cheek_mm[1], layers.motor_cheek_mm[0], LENGTH_MM)
    stands = d.capstan is not None and shaft.head_diameter_mm > shaft.diameter_mm + _SHOULDER_MM
    found = {
        "foot_block": Controlled(() if d.is_printed("foot_block") else (wide,), seat=(2, d.bracket.base_top_mm)),
        "shoulder_shaft": Controlled(
            rounds=(journal,),
            coaxial=((shaft.magnet_bore_mm, COAXIAL_MM),) if d.sensed_at_shoulder else (),
            shoulder=(shaft.head_to_y_mm, square_zones(d)[SHOULDER]) if stands else None,
        ),
        "handle_stem": Controlled(rounds=(Round(catalogue.screw(stem).tap_drill_mm, thread=stem),)),
        "cross_bar": Controlled(_shoulders(d), rounds=(bar, Round(pin, "h7")), coaxial=((pin, TRUE_MM),)),
        "rod_cup": Controlled(
            rounds=(
                Round(liner + 2 * LINER_GLUE_MM, either_mm=LINER_TURNED_MM),
                Round(forearm.spigot_diameter_mm, either_mm=SPIGOT_TURNED_MM),
            )
        ),
        "rod_tube": Controlled((Length(0, 0.0, forearm.tube_length_mm, TUBE_SHORTER_MM, 0.0),)),
        "cup_shell": Controlled(
            rounds=(Round(seat, either_mm=gauged, where=lapped), Round(liner, either_mm=LINER_TURNED_MM))
        ),
    }
    if d.encoder.to_drawing and d.sensed_at_shoulder:
        height = Length(1, 0.0, d.encoder.chip_height_mm, CHIP_HEIGHT_MM)
        found["encoder_board"] = Controlled((height,), seat=(1, 0.0))
    inside = layers.motor_cheek_mm[0]
    outside = layers.encoder_cheek_mm[1]  # the cheeks' inner faces lie on the foot block
    found["motor_cheek"] = Controlled(seat=(1, inside))
    found["encoder_cheek"] = Controlled(seat=(1, outside))
    if d.capstan is not None:
        c, (encoder, motor) = d.capstan, layers.bearings_mm
        spring = d.preload.work_height_mm if d.preload is not None else 0.0
        floor = encoder[0] - spring
        found["motor_cheek"] = Controlled(depths=(Length(1, inside, motor[1], LENGTH_MM),), seat=(1, inside))
        found["encoder_cheek"] = Controlled(depths=(Length(1, outside, floor, LENGTH_MM),), seat=(1, outside))
        found["upper_arm"] = Controlled((Length(1, encoder[1], layers.arm_mm[1], LENGTH_MM),))
        rim = Round(2 * c.rim_radius_mm, either_mm=2 * RIM_TURNED_MM)
        face = layers.arm_mm[1]
        found["sector"] = Controlled((Length(1, face, motor[0], LENGTH_MM),), rounds=(rim,), seat=(1, face))
        groove, crest = 2 * (c.run.pinion_mm - c.cable_diameter_mm / 2), 2 * c.pinion_radius_mm
        sizes = (groove, "at the groove's bottom"), (crest, "and over the lands between")
        turned = tuple(Round(diameter, either_mm=PINION_TURNED_MM, where=where) for diameter, where in sizes)
        found["pinion"] = Controlled(rounds=turned, coaxial=((groove, TRUE_MM),), groove_mm=(groove, crest))
    for number, edges in functional_edges(d).items():
        found[number] = replace(found.get(number, Controlled()), edges=edges)
    return found


def _shoulders(d: Dimensions) -> tuple[Length, ...]:
    """Distance of the shoulders on which the balls of a cross-bar sit."""
    from delta_cad.solids.forearm import rim_mm  # loads the CAD kernel

    half = d.forearm.width_mm / 2 - rim_mm(d.forearm)
    return (Length(1, -half, half, LENGTH_MM),)
