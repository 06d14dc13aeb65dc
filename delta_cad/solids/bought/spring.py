"""Tension spring across a pair of rods, with the cord inside it."""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, pi, sin

import cadquery as cq
import numpy as np

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import EYE_WALL_MM, LUG_MM, ForearmDimensions
from delta_cad.solids.making import bought_part, round_y
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import bore_y, feature, fuse

CORD_MM = 0.5
CORD_SLACK_MM = 1.0  # a ball leaves its cup at more than 2 mm: the cord keeps it in when a spring breaks, or at a blow
CORD_KNOTS_MM = 30.0
CORD_DENSITY_G_MM3 = 0.97e-3  # polyethylene
WIRE_DENSITY_G_MM3 = 7.85e-3
LOOPS = 2.0  # coils' worth of wire in both loops together
PIECES = 160, 12, 24  # of half a loop: around it, out from the middle of its wire, around that


def cord_mm(f: ForearmDimensions) -> tuple[float, float]:
    """Gives the length of a cord between the eyes and as it is cut, mm."""
    between = f.between_eyes_mm + CORD_SLACK_MM
    return between, between + CORD_KNOTS_MM


def spring_mass_g(f: ForearmDimensions) -> float:
    """Computes the mass of a spring with its cord, g; of the spring as its row gives it, else of its wire."""
    row = f.spring
    wire = pi**2 / 4 * row.wire_mm**2 * row.mean_diameter_mm * (row.active_coils + LOOPS) * WIRE_DENSITY_G_MM3
    return (wire if row.mass_g is None else row.mass_g) + pi / 4 * CORD_MM**2 * cord_mm(f)[1] * CORD_DENSITY_G_MM3


def loop_overlap_mm3(f: ForearmDimensions, lean_rad: float) -> float:
    """Computes what a loop, drawn stiff, shares with its eye's lug where the rods lean: sums of small pieces, mm^3.

    The spring turns on the way to level and is drawn as long as at no lean; the edges of the eye are rounded in truth.

    Args:
        f: Whose spring it is.
        lean_rad: Lean of the rods.
    """
    across, along = f.width_mm * sin(lean_rad), f.width_mm * cos(lean_rad) - 2 * f.eye_y_mm
    apart = hypot(across, along)
    mean, wire, hole = f.spring.mean_diameter_mm / 2, f.spring.wire_mm / 2, f.eye_diameter_mm / 2
    turn, out, around = np.meshgrid(*((np.arange(n) + 0.5) / n for n in PIECES), indexing="ij")
    turn, out, around = pi * (turn - 0.5), wire * out, 2 * pi * around
    radius = mean + out * np.cos(around)
    u = (f.between_eyes_mm - apart) / 2 - (mean - wire) + radius * np.cos(turn)  # along the spring, beyond its eye
    v = radius * np.sin(turn)
    x, y = (across * u + along * v) / apart, (along * u - across * v) / apart + f.eye_hole_y_mm - f.eye_y_mm
    off = np.hypot(y, out * np.sin(around))
    shared = (np.abs(x) < LUG_MM / 2) & (np.abs(y) < hole + EYE_WALL_MM) & (off > hole)
    return float((radius * out)[shared].sum()) * 2 * pi**2 * wire / turn.size


def make_rod_spring(d: Dimensions) -> Part:
    """Spring along y about the origin, as long as at no lean: its coils drawn as one cylinder, a ring for each loop.

    The rings lie in the plane of x and y: x runs through the eyes.
    """
    number, f = "rod_spring", d.forearm
    row, half = f.spring, f.between_eyes_mm / 2
    wire, mean = row.wire_mm / 2, row.mean_diameter_mm / 2
    body = (row.active_coils + 1.0) * row.wire_mm  # unloaded: the loops are what is left of the free length
    coils = half - min((row.free_length_mm - body) / 2, 2 * mean - wire)  # which the loops reach in any case

    def drawn() -> cq.Shape:
        centre = half - (mean - wire)
        loops = [
            cq.Solid.makeTorus(mean, wire, cq.Vector(0.0, side * centre, 0.0), cq.Vector(0.0, 0.0, 1.0))
            for side in (-1.0, 1.0)
        ]
        return fuse(bore_y(2 * (mean + wire), (0.0, 0.0), (-coils, coils)), *loops)

    solid = feature(number, "coils", "mechanism.parallelogram_width_mm", drawn)
    extent = round_y(mean + wire, (-half - 2 * wire, half + 2 * wire))
    made = bought_part(number, row, solid, "steel", extent, spring_mass_g(f))
    drawing = f"{f.joint.spring_N:.1f} N at {f.between_eyes_mm:g} mm between the eyes of two rods; mass with its cord"
    return replace(made, description=f"{row.description}: {drawing}")
