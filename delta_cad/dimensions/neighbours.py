"""A motor beside the encoder's board of the next chain, in closed form: rectangles at the motor's widest height."""

from __future__ import annotations

from math import sqrt

import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions.layers import Layers
from delta_cad.dimensions.rules import require
from delta_cad.mechanism.placement import CHAINS, chain_frame

BESIDE_MM = 0.5  # of the board's screws, its plug and edges from the neighbour's motor, which is drawn off past them
BOARD_SCREW = "M2.5"
PLUG_MM = (5.0, 4.0, 5.0)  # half width, height over the board and length of the plug at its lower end
HALVINGS = 30  # of the range in which the base's radius lies


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
        DimensionError: It does; the message names the base radius on which it does not.
    """

    def room(radius_mm: float) -> float:
        u, face, radius = motor_axis_mm[0] + radius_mm - base_radius_mm, stack.motor_cheek_mm[1], motor.diameter_mm / 2
        least = np.inf
        for wide, y, z in _board_boxes(stack, encoder):
            off = max(z[0] - motor_axis_mm[1], motor_axis_mm[1] - z[1], 0.0)  # where in its height the motor is widest
            if off < radius:
                half = sqrt(radius**2 - off**2)
                body = (u - half, u + half), (face, face + 2 * motor.length_mm)  # and its way off
                least = min(least, _apart_mm(body, ((radius_mm - wide, radius_mm + wide), y)))
        return float(least)

    found = room(base_radius_mm)
    low, high = base_radius_mm, base_radius_mm + motor.diameter_mm + encoder.board_width_mm
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if room(middle) >= BESIDE_MM else (middle, high)
    require(
        found >= BESIDE_MM,
        "encoder_board",
        "beside the neighbour's motor",
        f"mechanism.base_radius_mm = {base_radius_mm:g} must be at least {high:.2f} mm, or the motors meet the "
        f"encoders' boards of the chains beside them: {found:.2f} mm apart, at least {BESIDE_MM:g}",
        "mechanism.base_radius_mm",
        base_radius_mm,
        high,
    )


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
