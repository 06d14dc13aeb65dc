"""Direction of the pinion, and of the motor with it, from the shoulder in the chain's plane."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from math import acos, asin, atan2, hypot, inf, radians

import numpy as np

from delta_cad import catalogue
from delta_cad.design.stands import EVEN, Gap, other_stands
from delta_cad.dimensions.arm import ArmDimensions
from delta_cad.dimensions.bracket import BracketDimensions
from delta_cad.dimensions.cable_run import CableRun
from delta_cad.dimensions.capstan import (
    CARRIAGE_FROM_MM,
    CARRIAGE_MM,
    CRIMP_MM,
    SLEEVE_OVER_MM,
    CapstanDimensions,
    rim_reach_rad,
)
from delta_cad.dimensions.layers import Layers

_WAYS, _WAY_HALVINGS = 13, 10  # directions that are tried; the first that has room is made finer
INMOST_RAD, _OUTMOST_RAD = radians(-130.0), radians(-100.0)  # of the pinion from the shoulder, down and inwards
SLEEVE_OFF_MM = -0.5  # that a sleeve leaves the arm on its way: the arm's edges are broken
_TURNED_IN_RAD = radians(5.0)  # for it, at most; a sector that would take more is refused where it is
_ROUNDING_RAD = 1e-6

_Rectangle = tuple[float, tuple[float, float]]
"""Half of what it takes about the motor's axis, out from the base's centre, and both ends across, mm."""


def sleeve_direction_rad(run: CableRun, shoulder_rad: tuple[float, float], arm: ArmDimensions, layers: Layers) -> float:
    """Gives the direction of the pinion at which the cable's outer sleeve just passes the arm; inf where any does.

    The rim's end follows the pinion, the carriage stands on it: the sleeve passes over that, beside the arm's plate or
    beside its edge, a line that leans as the arm grows thinner. The sleeve's end is nearest to it, at its seat.

    Args:
        run: The cable.
        shoulder_rad: Smallest and largest shoulder angle over the cube.
        arm: The upper arm.
        layers: Stack along the shoulder's axis.
    """
    radius = CRIMP_MM[0] / 2 + SLEEVE_OFF_MM
    passed = sum(layers.sector_mm) / 2 - run.made_lug_mm - SLEEVE_OVER_MM
    if passed - radius >= layers.arm_mm[1]:
        return inf
    end = CARRIAGE_FROM_MM + CARRIAGE_MM[0]
    off = hypot(run.sector_mm, end)
    leans = asin((arm.beam_root_radius_mm - arm.boss_radius_mm) / arm.length_mm)
    most = leans - atan2(end, run.sector_mm) - asin(min((arm.beam_root_radius_mm + radius) / off, 1.0))
    return most - rim_reach_rad(run, shoulder_rad, 0.0)[1][1] - _ROUNDING_RAD


def pinion_direction_rad(
    run: CableRun,
    base_radius_mm: float,
    behind_mm: float,
    motor: catalogue.Motor,
    motor_face_mm: float,
    most_rad: float,
    gap: Gap = EVEN[0],
) -> float:
    """Chooses the direction of the pinion from the shoulder: as far out as the motor stays within the arms' outline.

    And a little farther in where the cable's outer sleeve needs its way between sector and arm.

    The motor of chain 1 lies square to its plane; its far end, the motor's radius beyond its axis, reaches behind the
    base by `end sin(a) - (u + radius) cos(a)`, u being its axis' distance from the base's centre along its chain. Where
    chain 1 itself does not stand behind, a motor farther out reaches less.

    Args:
        run: The cable.
        base_radius_mm: Base centre to shoulder axis of chain 0.
        behind_mm: How far the arms of chains 1 and 2 reach behind the base's centre, opposite to chain 0.
        motor: Row of the catalogue.
        motor_face_mm: Its mounting face along the shoulder's axis.
        most_rad: See `sleeve_direction_rad`.
        gap: That of chains 0 and 1, a its angle.
    """
    end = motor_face_mm + motor.length_mm
    out = inf
    if gap.cosine < 0.0:
        out = (behind_mm - gap.sine * end) / -gap.cosine - motor.diameter_mm / 2
    cosine = (out - (base_radius_mm + gap.next_out_mm)) / run.centre_distance_mm
    wanted = -acos(min(max(cosine, -1.0), 1.0))
    wanted = min(max(wanted, INMOST_RAD), _OUTMOST_RAD)
    return most_rad if wanted - _TURNED_IN_RAD <= most_rad <= wanted else wanted


def farther_out_rad(direction_rad: float, has_room: Callable[[float], bool]) -> float:
    """Turns a pinion farther out, outside the arms' outline, until what stands beside the motors has room.

    Chains that stand unevenly leave some neighbours less room than others; the outline is checked of the whole machine.

    Args:
        direction_rad: As far out as the motor stays within the arms' outline.
        has_room: Whether there is room in a direction.

    Returns:
        The least direction that has it; the first one where none has.
    """
    ways = np.linspace(direction_rad, _OUTMOST_RAD, _WAYS).tolist()
    first = next((k for k, way in enumerate(ways) if has_room(way)), 0)
    if not first:
        return direction_rad
    low, high = ways[first - 1], ways[first]
    for _ in range(_WAY_HALVINGS):
        middle = (low + high) / 2.0
        low, high = (low, middle) if has_room(middle) else (middle, high)
    return high


def pinion_room_mm(c: CapstanDimensions, b: BracketDimensions, stack: Layers, gaps: Sequence[Gap]) -> float:
    """Computes how far a pinion and its collar stay off a neighbour's motor cheek, seen from above, mm; 0: they meet.

    At the height of their axes, where all of them are widest: the corners of one rectangle from the other.

    Args:
        c: The capstan.
        b: Bracket of a chain.
        stack: Stack of a chain along the shoulder's axis.
        gaps: Of the chains.
    """
    u = b.motor_axis_mm[0]
    pad = b.motor_pad_radius_mm, stack.motor_cheek_mm
    found = []
    for radius, across in ((c.pinion_radius_mm, c.groove_y_mm), (c.collar_radius_mm, c.collar_y_mm)):
        for stand in other_stands(gaps):
            for one, other in product(((radius, across), pad), repeat=2):
                if one is not other:
                    found.append(_from_corners_mm(u, one, other, stand))
    return min(found)


def _from_corners_mm(u: float, one: _Rectangle, other: _Rectangle, stand: np.ndarray) -> float:
    """Least distance of a rectangle's corners, seen from another chain, from that one's rectangle about the same u."""
    (radius, across), (half, along) = one, other
    corners = np.array([[u + side * radius, t] for side in (-1.0, 1.0) for t in across])
    there = corners @ stand[:2, :2].T + stand[:2, 3]
    out = np.maximum(np.abs(there[:, 0] - u) - half, 0.0)
    aside = np.maximum(np.maximum(along[0] - there[:, 1], there[:, 1] - along[1]), 0.0)
    return float(np.hypot(out, aside).min())
