"""Ball bearings: how far they give, what they may bear, how long they live."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, radians, sin

from delta_cad import catalogue

_BALL_SHARE = 0.25  # ball diameter over (outer - bore): 2.0 mm of a 688, whose makers give 1.98; 4.0 to 3.97 of a 608
_FILL = 0.53  # share of the pitch circle that balls fill in a deep groove bearing, put in by the rings' offset
_CONTACT_RAD = radians(10.0)  # of a lightly preloaded deep groove bearing of clearance C3
LOADED = 5.0  # largest ball load over F / Z of a radial bearing with little clearance (4.37 with none, Stribeck)
_SECONDS_PER_HOUR = 3600.0


@dataclass(frozen=True)
class BallBearing:
    """A deep groove bearing as loads see it.

    Attributes:
        ball_mm: Diameter of its balls.
        balls: Their number.
        static_N: C0.
        dynamic_N: C.
    """

    ball_mm: float
    balls: int
    static_N: float
    dynamic_N: float


def ball_bearing(row: catalogue.Bearing) -> BallBearing:
    """Infers balls from the rings' diameters, for makers do not print them."""
    ball = _BALL_SHARE * (row.outer_mm - row.bore_mm)
    balls = int(_FILL * pi * (row.outer_mm + row.bore_mm) / 2.0 / ball)
    return BallBearing(ball, balls, row.static_load_N, row.dynamic_load_N)


def approach_mm(ball_N: float, ball_mm: float) -> float:
    """Computes how far a ball's two contacts give together, mm.

    Source:
        Palmgren, Ball and Roller Bearing Engineering, deep groove: `4.36e-4 (Q^2 / D)^(1/3)` in mm and N.
    """
    return 4.36e-4 * (ball_N**2 / ball_mm) ** (1.0 / 3.0)


def radial_stiffness_N_mm(bearing: BallBearing, load_N: float) -> float:
    """Computes the stiffness of a bearing across its axis for small changes about a radial load, N/mm.

    Source:
        Palmgren's approach under the most loaded ball `5 F / Z`; the load grows with its power 3/2, so the slope is
        3/2 of the quotient.
    """
    return 1.5 * load_N / approach_mm(LOADED * load_N / bearing.balls, bearing.ball_mm)


def axial_stiffness_N_mm(bearing: BallBearing, preload_N: float) -> float:
    """Computes the stiffness of a bearing along its axis for small changes about a preload, N/mm.

    Source:
        Harris and Kotzalas, Rolling Bearing Analysis: each ball bears `F / (Z sin a)` and gives Palmgren's approach
        along its contact; the contact angle a is taken as constant.
    """
    ball = preload_N / (bearing.balls * sin(_CONTACT_RAD))
    return bearing.balls * sin(_CONTACT_RAD) ** 2 * 1.5 * ball / approach_mm(ball, bearing.ball_mm)


def static_equivalent_N(radial_N: float, axial_N: float) -> float:
    """Computes the static equivalent load of a deep groove bearing, N.

    Source:
        ISO 76: `max(F_r, 0.6 F_r + 0.5 F_a)`.
    """
    return max(radial_N, 0.6 * radial_N + 0.5 * axial_N)


def dynamic_equivalent_N(radial_N: float, axial_N: float) -> float:
    """Computes a bound on the dynamic equivalent load of a deep groove bearing, N.

    Source:
        ISO 281: `max(F_r, 0.56 F_r + Y F_a)` with its largest Y, 2.30 of the lightest axial loads.
    """
    return max(radial_N, 0.56 * radial_N + 2.30 * axial_N)


def life_hours(bearing: BallBearing, equivalent_N: float, stroke_rad: float, strokes_per_s: float) -> float:
    """Computes the rating life of a bearing that swings, hours.

    Args:
        bearing: The bearing.
        equivalent_N: Dynamic equivalent load.
        stroke_rad: Angle from end to end of a stroke.
        strokes_per_s: Strokes there and back a second.

    Source:
        ISO 281: `L10 = (C / P)^3` million turns; of a swing the way there and back counts, the makers' rule for
        strokes above some 2 pi / Z (below, fretting ends it, and no rating holds).
    """
    turns = 1e6 * (bearing.dynamic_N / equivalent_N) ** 3
    return turns / (2.0 * stroke_rad / (2.0 * pi) * strokes_per_s) / _SECONDS_PER_HOUR
