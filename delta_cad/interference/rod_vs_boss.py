"""Clearance of rod ends, free to rotate about the rod axis, to the bosses of their cross-bars at elbow and wrist."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, degrees

import numpy as np

from delta_cad.dimensions import Dimensions, Reason
from delta_cad.dimensions.forearm import ForearmDimensions
from delta_cad.dimensions.platform import BOSS_BEVEL_MM
from delta_cad.dimensions.rules import FOREARM, WIDTH, larger
from delta_cad.interference.shapes import Bar, Block, Shape, union_distance

RIM_POINTS = 48  # around a boss's end
LEANS, TURNS = 7, 9  # between none and the largest lean, and from one end of a turn to the other
LONG_MM = 40.0  # of a tube that is looked at: farther out no boss comes near


def rod_end(f: ForearmDimensions) -> list[Shape]:
    """Lists the square stem of a rod's end and the tube behind it, in the rod's frame."""
    rod, x = f.tube_outer_mm / 2, np.array([1.0, 0.0, 0.0])
    stem = Block(np.eye(3), (0.0, 0.0, 0.0), (f.stem_mm, -rod, -rod), (f.shoulder_mm, rod, rod))
    return [stem, Bar(rod, LONG_MM, f.shoulder_mm * x, x)]


def _rims(radius_mm: float, half_mm: float) -> np.ndarray:
    """(n, 3) both edges of a boss's bevelled end, its axis along y."""
    turns = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS, endpoint=False)
    rims = (radius_mm - BOSS_BEVEL_MM, half_mm), (radius_mm, half_mm - BOSS_BEVEL_MM)
    return np.concatenate([np.stack([r * np.cos(turns), 0.0 * turns + y, r * np.sin(turns)], axis=1) for r, y in rims])


def boss_clearance_mm(f: ForearmDimensions, radius_mm: float, length_mm: float, lean_rad: float) -> float:
    """Computes how near a rod's end comes to the end of its cross-bar's boss at leans up to one, mm.

    It leans towards the boss and is turned about itself as far as its joints let it.

    Args:
        f: The rods.
        radius_mm: Of the boss.
        length_mm: Of the boss.
        lean_rad: The largest lean.
    """
    rims = _rims(radius_mm, length_mm / 2) - np.array([0.0, f.width_mm / 2, 0.0])
    seen = []
    for lean in np.linspace(0.0, min(lean_rad, f.tilt_limit_rad), LEANS):
        free = float(np.arccos(np.clip(cos(f.tilt_limit_rad) / cos(lean), -1.0, 1.0)))
        along = np.array([np.cos(lean), -np.sin(lean), 0.0])
        aside, up_ = np.array([np.sin(lean), np.cos(lean), 0.0]), np.array([0.0, 0.0, 1.0])
        for turn in np.linspace(-free, free, TURNS):
            y, z = np.cos(turn) * aside + np.sin(turn) * up_, np.cos(turn) * up_ - np.sin(turn) * aside
            seen.append(rims @ np.stack([along, y, z], axis=1))
    return float(union_distance(rod_end(f), np.concatenate(seen)).min())


def rod_boss_interference(d: Dimensions, least_mm: float) -> Iterator[Reason]:
    """Gives the reason why rods that lean and turn come too near to the elbow's boss.

    The wrist's boss follows from the same, see `delta_cad.dimensions.platform`.

    Args:
        d: The machine.
        least_mm: Least distance between them.
    """
    f, (low, high), lean = d.forearm, d.layers.elbow_boss_mm, d.travel.lean_max.value
    near = boss_clearance_mm(f, d.arm.boss_radius_mm, high - low, lean)
    if near >= least_mm:
        return
    message = (
        f"rods that lean by {degrees(lean):.1f} deg come within {near:.2f} mm of the arm's boss; at least "
        f"{least_mm:.2f}"
    )
    yield Reason("rod_cup", "beside its boss", message, (larger(WIDTH), larger(FOREARM)))
