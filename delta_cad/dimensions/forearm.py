"""The parallelogram: cross-bars, ball studs, sockets and tubes."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, asin

from delta_cad import catalogue
from delta_cad.dimensions.rules import require

BALL_CLEARANCE_MM = 0.02  # radial, ball in its seat
TUBE_GLUE_MM = 0.05  # diametral, spigot in the tube
STUD_THREAD_MM = 6.0
CROSS_BAR_MM = 6.0
STUD_CORE_MM = 2.5  # M3


@dataclass(frozen=True)
class ForearmDimensions:
    """Two equal rods with ball joints between the elbow's cross-bar and the platform's boss."""

    length_mm: float
    width_mm: float
    ball_diameter_mm: float
    seat_diameter_mm: float
    neck_diameter_mm: float
    stand_off_mm: float
    collar_diameter_mm: float
    collar_length_mm: float
    stud_thread_length_mm: float
    bar_diameter_mm: float
    bar_length_mm: float
    bar_thread_depth_mm: float
    socket_outer_mm: float
    socket_width_mm: float
    socket_slit_mm: float
    shoulder_mm: float
    spigot_diameter_mm: float
    spigot_length_mm: float
    tube_outer_mm: float
    tube_bore_mm: float
    tube_length_mm: float
    tilt_limit_rad: float


def tilt_limit_rad(seat_radius_mm: float, socket_width_mm: float, neck_diameter_mm: float) -> float:
    """Computes the free tilt of a ball stud in a ring socket, rad.

    The lip of the ring lies on the seat at polar angle acos((width / 2) / radius) from the ring's axis; the neck leaves
    the ball at asin((diameter / 2) / radius) from the stud's axis; they meet when the tilt is the difference.
    """
    return acos(socket_width_mm / 2 / seat_radius_mm) - asin(neck_diameter_mm / 2 / seat_radius_mm)


def forearm_dimensions(
    length_mm: float, width_mm: float, ball_mm: float, boss_width_mm: float, tube: catalogue.Tube
) -> ForearmDimensions:
    """Dimensions a parallelogram of a length between ball centres and a width along the shoulder axis.

    Raises:
        DimensionError: Too narrow for the elbow boss that grips the cross-bar, or too short for the sockets.
    """
    stand_off = ball_mm / 2 + 3.0  # the tilted socket keeps 2 mm from bar and boss
    bar = width_mm - 2 * stand_off
    require(
        bar >= boss_width_mm + 2.0,
        "cross_bar",
        "length",
        f"parallelogram_width_mm = {width_mm:g} must be at least {boss_width_mm + 2.0 + 2 * stand_off:g} mm",
    )
    outer = ball_mm + 3.0
    shoulder = outer / 2 + 3.5
    tube_length = length_mm - 2 * shoulder
    require(
        tube_length >= 24.0,
        "rod_tube",
        "length",
        f"forearm_length_mm = {length_mm:g} must be at least {24.0 + 2 * shoulder:g} mm",
    )
    seat = ball_mm + 2 * BALL_CLEARANCE_MM
    require(
        0.425 * ball_mm >= STUD_CORE_MM,
        "ball_stud",
        "neck",
        f"hardware.ball_diameter_mm = {ball_mm:g} must be at least {STUD_CORE_MM / 0.425:.2f} mm: M3 behind the neck",
    )
    width, neck = 0.5625 * ball_mm, 0.425 * ball_mm  # 4.5 and 3.4 mm on 8 mm: 31 deg of free tilt
    return ForearmDimensions(
        length_mm=length_mm,
        width_mm=width_mm,
        ball_diameter_mm=ball_mm,
        seat_diameter_mm=seat,
        neck_diameter_mm=neck,
        stand_off_mm=stand_off,
        collar_diameter_mm=5.5,
        collar_length_mm=1.2,
        stud_thread_length_mm=STUD_THREAD_MM,
        bar_diameter_mm=CROSS_BAR_MM,
        bar_length_mm=bar,
        bar_thread_depth_mm=min(STUD_THREAD_MM + 2.0, bar / 2 - 1.0),
        socket_outer_mm=outer,
        socket_width_mm=width,
        socket_slit_mm=0.8,
        shoulder_mm=shoulder,
        spigot_diameter_mm=tube.inner_mm - TUBE_GLUE_MM,
        spigot_length_mm=8.0,
        tube_outer_mm=tube.outer_mm,
        tube_bore_mm=tube.inner_mm,
        tube_length_mm=tube_length,
        tilt_limit_rad=tilt_limit_rad(seat / 2, width, neck),
    )
