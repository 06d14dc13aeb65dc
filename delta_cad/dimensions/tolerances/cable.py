"""Chains of a cable capstan: the plane of the cable, the gap of sector and pinion, the carriage's travel."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.cable.run import CableRun
from delta_cad.dimensions.capstan import (
    PINION_TURNED_MM,
    RIM_TURNED_MM,
    STRETCH,
    TENSION_TRAVEL_MM,
    CapstanDimensions,
)
from delta_cad.dimensions.tolerances import PLACE_MM, SEATS_MM, SQUARE_MM, deviations_um, minutes
from delta_cad.dimensions.tolerances.chain import Chain, Link, either_way
from delta_cad.dimensions.tolerances.general import general_mm
from delta_cad.dimensions.tolerances.shoulder import FEELER_MM, RING_UM, tilt_chain

PILOT_UM = 18.0  # by which a motor's pilot may be smaller than nominal: h7 up to 18 mm
STEP_MM = 1e-4  # of the differences that give what a length of cable grows by


def cable_chains(d: Dimensions, general: str) -> list[Chain]:
    """Lists the chains of one capstan; none of a direct drive.

    Args:
        d: Dimensions of the machine.
        general: Class of the general tolerances, of ISO 2768-1.
    """
    if d.capstan is None:
        return []
    return [plane_chain(d, d.capstan, general), axes_chain(d, d.capstan), travel_chain(d, d.capstan, general)]


def plane_chain(d: Dimensions, c: CapstanDimensions, general: str) -> Chain:
    """How far a rim's end is off the strand's take-off along the axis, beside the groove's own climb."""
    rim, limit = d.layers.sector_mm[1], c.run.lug_tolerance_mm()
    by_end, by_groove = rim - min(c.end_y_mm), c.collar_y_mm[0] - c.middle_y_mm
    inside, outside = d.layers.motor_cheek_mm
    tilt = max(map(abs, tilt_chain(d)[0].worst)) / minutes(1.0) * c.run.sector_mm
    askew = SQUARE_MM / (outside - inside) * c.run.pinion_mm
    links = (
        either_way("sector", "place of a rim's end", "general", general_mm(by_end, general), 1.0, by_end),
        either_way("pinion", "groove from its collar", "general", general_mm(by_groove, general), 1.0, by_groove),
        either_way("pinion", "its collar set to the rim by a feeler", "set", FEELER_MM),
        either_way("sector", "tilt of the shoulder's shaft", "fit", tilt),
        either_way("motor_cheek", "pilot out of square", "place", askew),
    )
    why = "beyond, a strand leaves its plane by more than 2.5 deg and climbs out of the groove: set the pinion by it"
    return Chain("cable's plane", "mm", 0.0, links, -limit, limit, why, statistical=True)


def _between_axes(d: Dimensions, c: CapstanDimensions) -> tuple[Link, ...]:
    """What moves the axes of sector and pinion apart."""
    pilot, bore = d.motor.pilot_diameter_mm, c.pinion_bore_mm
    shaft_um = -deviations_um("h6", d.shaft.diameter_mm)[0]
    play_um = {
        ("motor", "pilot in its cheek"): deviations_um("H7", pilot)[1] + PILOT_UM,
        ("bearing", "in its seat"): 1000.0 * SEATS_MM[0] + RING_UM,
        ("shoulder_shaft", "in its bearing"): shaft_um,
        ("sector", "on its shaft"): deviations_um("G7", d.shaft.diameter_mm)[1] + shaft_um,
        ("pinion", "on the motor's shaft"): deviations_um("H7", bore)[1] - deviations_um("h6", bore)[0],
    }
    places = either_way("motor_cheek", "pilot from the bearing's seat", "place", PLACE_MM / 2.0)
    return places, *(either_way(part, what, "fit", um / 2000.0) for (part, what), um in play_um.items())


def axes_chain(d: Dimensions, c: CapstanDimensions) -> Chain:
    """The gap between rim and crest of the pinion, through which both strands pass."""
    links = (
        *_between_axes(d, c),
        either_way("sector", "radius of its rim", "stated", RIM_TURNED_MM, -1.0, c.rim_radius_mm),
        either_way("pinion", "diameter of its crest", "stated", PINION_TURNED_MM, -0.5, 2 * c.pinion_radius_mm),
    )
    gap = c.run.centre_distance_mm - c.rim_radius_mm - c.pinion_radius_mm
    why = "below, sector and pinion pinch the cable"
    return Chain("gap of sector and pinion", "mm", gap, links, c.cable_diameter_mm, inf, why)


def travel_chain(d: Dimensions, c: CapstanDimensions, general: str) -> Chain:
    """Where the carriage stands from its first place when the cable is tight."""
    length, tolerance = c.bench_mm
    run = c.run
    sector, pinion, apart = (
        (_path_mm(run, STEP_MM * axis) - _path_mm(run, -STEP_MM * axis)) / (2.0 * STEP_MM) for axis in np.eye(3)
    )
    nose = general_mm(c.nose_radius_mm, general)
    links = (
        either_way("capstan_cable", "length between its sleeves", "stated", tolerance, 1.0),
        either_way("sector", "radius of its rim", "stated", RIM_TURNED_MM, -sector, c.rim_radius_mm),
        either_way("sector", "radius of its nose", "general", nose, -c.turns_rad[0], c.nose_radius_mm),
        either_way("pinion", "diameter of its groove", "stated", PINION_TURNED_MM, -pinion / 2, 2 * run.pinion_mm),
        *(replace(link, share=-apart * link.share) for link in _between_axes(d, c)),
    )
    most = TENSION_TRAVEL_MM - STRETCH * c.cable_length_mm
    why = "below, the cable does not go on; above, it is not tight where the carriage's pocket ends: crimp another"
    return Chain("carriage's travel", "mm", length - c.cable_length_mm, links, 0.0, most, why, statistical=True)


def _path_mm(run: CableRun, off_mm: np.ndarray) -> float:
    """Length of the cable where both radii, of sector and pinion, and the axes' distance are off by (3,) these."""
    sector, pinion, apart = (float(v) for v in off_mm)
    radii = {"sector_mm": run.sector_mm + sector, "pinion_mm": run.pinion_mm + pinion}
    return replace(run, gap_mm=run.gap_mm + apart - sector - pinion, **radii).length_mm()
