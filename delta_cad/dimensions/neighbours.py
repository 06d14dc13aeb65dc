"""What runs or stands beside a motor, in closed form: the next chain's encoder board, the own arm's end."""

from __future__ import annotations

from itertools import combinations
from math import acos, atan2, hypot, sqrt

import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions.arm import ArmDimensions
from delta_cad.dimensions.bracket import BracketDimensions, Circle
from delta_cad.dimensions.layers import Layers
from delta_cad.dimensions.rules import (
    ARM,
    BOTTOM,
    FARTHER_OUT,
    RUNNING_GAP_MM,
    STOP_MARGIN_RAD,
    another,
    larger,
    require,
)
from delta_cad.mechanism.placement import CHAINS, chain_frame

BESIDE_MM = 0.5  # of the board's screws, its plug and edges from the neighbour's motor, which is drawn off past them
BOARD_SCREW = "M2.5"
PLUG_MM = (5.0, 4.0, 5.0)  # half width, height over the board and length of the plug at its lower end
BOARD_EDGE_MM = 4.0  # of a direct drive's leg around its board's screws
DIRECTIONS, ANGLES = 1440, 181  # in which a hull is looked at, to 1e-4 mm; of an arm between its stops


def require_room_for_board(
    base_radius_mm: float,
    motor_axis_mm: tuple[float, float],
    stack: Layers,
    motor: catalogue.Motor,
    encoder: catalogue.Encoder,
) -> None:
    """Refuses a base on which a motor, or its way off its cheek, runs into the next chain's encoder board.

    Args:
        base_radius_mm: Base centre to shoulder axis.
        motor_axis_mm: (u, z) of the motor's axis in its chain's plane.
        stack: Stack of a chain along the shoulder axis.
        motor: Row of the catalogue.
        encoder: Row of the catalogue; its board stands upright.

    Raises:
        DimensionError: It does.
    """
    u, face, radius = motor_axis_mm[0], stack.motor_cheek_mm[1], motor.diameter_mm / 2
    found = np.inf
    for wide, y, z in _board_boxes(stack, encoder):
        off = max(z[0] - motor_axis_mm[1], motor_axis_mm[1] - z[1], 0.0)  # where in its height the motor is widest
        if off < radius:
            half = sqrt(radius**2 - off**2)
            body = (u - half, u + half), (face, face + 2 * motor.length_mm)  # and its way off
            found = min(found, _apart_mm(body, ((base_radius_mm - wide, base_radius_mm + wide), y)))
    require(
        found >= BESIDE_MM,
        "encoder_board",
        "beside the neighbour's motor",
        f"the motors come within {found:.2f} mm of the encoders' boards of the chains beside them; at least "
        f"{BESIDE_MM:g}",
        *FARTHER_OUT,
    )


def require_room_for_boss(
    arm: ArmDimensions, bracket: BracketDimensions, shoulder_rad: tuple[float, float], stack: Layers, board_mm: Circle
) -> None:
    """Refuses a direct drive whose arm's end, wider than the way between the cheeks, runs into one between its stops.

    Args:
        arm: Upper arm.
        bracket: Its chain's.
        shoulder_rad: Smallest and largest shoulder angle over the cube.
        stack: Stack of a chain along the shoulder axis.
        board_mm: Half distances (x, z) of the encoder board's screws, and their radius; 0 where there is no board.

    Raises:
        DimensionError: It does.
    """
    x, z, edge = board_mm
    corners = [(sx * x, sz * z, edge) for sx in (-1, 1) for sz in (-1, 1)]
    encoder_cheek = [(0.0, 0.0, bracket.head_radius_mm), *corners, *bracket.foot_circles_mm]
    cheeks = []
    if stack.elbow_boss_mm[1] > stack.motor_cheek_mm[0] - RUNNING_GAP_MM:
        cheeks.append(bracket.motor_cheek_circles_mm)
    if stack.elbow_boss_mm[0] < stack.encoder_cheek_mm[1] + RUNNING_GAP_MM:
        cheeks.append(encoder_cheek)
    angles = np.linspace(shoulder_rad[0] - STOP_MARGIN_RAD, shoulder_rad[1] + STOP_MARGIN_RAD, ANGLES)

    off = np.full(ANGLES, np.inf)
    for normals, supports in map(_hull, cheeks):
        outward = np.stack([np.cos(angles), np.sin(angles)], axis=-1) @ normals  # of an elbow, per mm of arm
        off = np.minimum(off, (arm.length_mm * outward - supports).max(axis=1) - arm.boss_radius_mm)
    found = off.min()
    require(
        found >= RUNNING_GAP_MM,
        "upper_arm",
        "beside its cheeks",
        f"the elbow's boss comes within {found:.2f} mm of a cheek; at least {RUNNING_GAP_MM:g}",
        larger(ARM),
        larger(BOTTOM),
        *another("motor"),
    )


def _hull(circles: list[Circle]) -> tuple[np.ndarray, np.ndarray]:
    """Directions (2, n) square to the sides of the hull of circles, and how far it reaches along each, (n,) mm."""
    turns = [*np.linspace(0.0, 2.0 * np.pi, DIRECTIONS, endpoint=False)]
    for (ax, az, a), (bx, bz, b) in combinations(circles, 2):  # and square to every edge
        apart = hypot(bx - ax, bz - az)
        if apart > abs(a - b):
            lean, along = acos((a - b) / apart), atan2(bz - az, bx - ax)
            turns += [along - lean, along + lean]
    normals, known = np.stack([np.cos(turns), np.sin(turns)]), np.array(circles)
    return normals, (known[:, :2] @ normals + known[:, 2:]).max(axis=0)


def _board_boxes(
    stack: Layers, encoder: catalogue.Encoder
) -> list[tuple[float, tuple[float, float], tuple[float, float]]]:
    """Half width, extents along the shoulder's axis and up, of the upright board, its two rows of screws, its plug."""
    screw, (back, front) = catalogue.screw(BOARD_SCREW), stack.encoder_board_mm
    half, head = encoder.board_length_mm / 2, screw.head_diameter_mm / 2
    along = back - screw.head_height_mm, stack.encoder_head_mm[0]
    wide, row = encoder.hole_spacing_width_mm / 2 + head, encoder.hole_spacing_length_mm / 2
    return [
        (encoder.board_width_mm / 2, (back, front), (-half, half)),
        (wide, along, (row - head, row + head)),
        (wide, along, (-row - head, head - row)),
        (PLUG_MM[0], (back - PLUG_MM[1], back), (-half, PLUG_MM[2] - half)),
    ]


def _apart_mm(one: tuple[tuple[float, float], ...], other: tuple[tuple[float, float], ...]) -> float:
    """Largest distance of two rectangles (u, t) of neighbouring chains along any of their sides; negative: they meet.

    Either chain may be the first's neighbour; of both the smaller.
    """
    found = []
    for chain in CHAINS[1:]:
        frames = chain_frame(0)[:2, :2], chain_frame(chain)[:2, :2]
        corners = [
            np.array([[u, t] for u in box[0] for t in box[1]]) @ frame.T
            for box, frame in zip((one, other), frames, strict=True)
        ]
        sides = np.concatenate([frame.T for frame in frames])
        first, second = (points @ sides.T for points in corners)
        found.append(
            max((second.min(axis=0) - first.max(axis=0)).max(), (first.min(axis=0) - second.max(axis=0)).max())
        )
    return float(min(found))
