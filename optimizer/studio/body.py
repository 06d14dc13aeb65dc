"""The machine's body in closed form: plates, motors, arms, sectors, rods and platform as prisms and spheres, no solids.

Sizes are the dimensions of the design that the lengths give, where these exist; else those of a usual machine. The page
places each link by the mechanism's own kinematics.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.design import DesignError
from delta_cad.dimensions import DimensionError, Dimensions, dimensions
from delta_cad.interference.static_obstacles import cheeks, foot, motor
from delta_cad.mechanism import MechanismError
from delta_cad.mechanism.placement import CHAINS
from optimizer.codesign.candidate import design_for
from optimizer.problem.variables import mechanism_of
from optimizer.studio.setting import Solved

Circle = tuple[float, float, float]
_AROUND, _ARC = 28, 24  # corners of a circle, and of a sector's rim
GRAPHITE, ALUMINIUM, ORANGE, CARBON, STEEL, BLACK = 0x3F464F, 0xB9C0C8, 0xE06C1E, 0x24272B, 0x8D949C, 0x17191C


@dataclass(frozen=True)
class Sizes:
    """What a body takes beside the lengths, mm; places are in the shoulder's frame: outwards, along its axis, up.

    Attributes:
        cheeks: Circles (x, z, radius) whose hull a plate is, and where it begins and ends along the axis.
        motor: Radius, ends along the axis, and (x, z) of its axis.
        foot: Lower and upper corner of a chain's foot block.
        pinion: Radius, ends and (x, z); None of a direct drive.
        rim: Radius of the sector, ends, and angles of its rim, rad; None of a direct drive.
        arm: Radii at the shoulder and at the elbow, and ends along the axis.
        bar_mm: Radius of the cross-bars.
        tube_mm: Radius of the rods.
        ball_mm: Radius of the joints with their cups.
        base: Circles whose hull the base plate is, in the base frame, and its lower and upper face.
        hub: Radius of the platform's hub and of its stem, thickness and stem's length.
        knob: Radius, and height of its middle over the wrists.
    """

    cheeks: tuple[tuple[tuple[Circle, ...], tuple[float, float]], ...]
    motor: tuple[float, tuple[float, float], tuple[float, float]]
    foot: tuple[tuple[float, float, float], tuple[float, float, float]]
    pinion: tuple[float, tuple[float, float], tuple[float, float]] | None
    rim: tuple[float, tuple[float, float], tuple[float, float]] | None
    arm: tuple[float, float, tuple[float, float]]
    bar_mm: float
    tube_mm: float
    ball_mm: float
    base: tuple[tuple[Circle, ...], tuple[float, float]]
    hub: tuple[float, float, float, float]
    knob: tuple[float, float]


USUAL = Sizes(
    cheeks=(
        (((0.0, 0.0, 13.0), (-20.0, -42.0, 17.0), (-6.0, -80.0, 3.0), (30.0, -80.0, 3.0)), (13.8, 19.8)),
        (((0.0, 0.0, 13.0), (-6.0, -80.0, 3.0), (30.0, -80.0, 3.0)), (-10.0, -4.0)),
    ),
    motor=(15.0, (17.7, 85.7), (-20.0, -42.0)),
    foot=((-8.5, -4.0, -83.7), (33.5, 13.8, -70.0)),
    pinion=(7.8, (4.0, 14.0), (-20.0, -42.0)),
    rim=(38.0, (7.0, 12.8), (-2.7, -1.0)),
    arm=(11.5, 7.0, (-3.0, 3.0)),
    bar_mm=4.0,
    tube_mm=2.5,
    ball_mm=4.9,
    base=(((0.0, 0.0, 72.0),), (-91.7, -83.7)),
    hub=(9.0, 5.0, 8.0, 30.0),
    knob=(12.5, 48.0),
)


def sizes(found: Solved) -> Sizes | None:
    """Derives the sizes from the dimensions of the machine of lengths; None where its parts have none."""
    task = found.task
    try:
        known = found.corrections.at_arm_length(found.lengths_mm[0])
        return _of(dimensions(design_for(task.brief, task.choice, found.lengths_mm, known)))
    except (DesignError, DimensionError, MechanismError, ValueError, ArithmeticError):
        return None


def _of(d: Dimensions) -> Sizes:
    body, block, c, p, f = motor(d), foot(d), d.capstan, d.platform, d.forearm
    top = p.boss_diameter_mm / 2
    pinion = rim = None
    if c is not None:
        pinion = c.pinion_radius_mm, c.pinion_y_mm, c.pinion_axis_mm
        rim = c.rim_radius_mm, d.layers.sector_mm, c.rim_angles_rad
    plates: list[Any] = [*cheeks(d)]
    plate = tuple(d.base.rim_mm) or ((0.0, 0.0, float(d.base.radius_mm)),)
    return Sizes(
        cheeks=tuple((tuple(map(tuple, one.circles)), one.y_mm) for one in plates),
        motor=(body.radius_mm, body.y_mm, body.at_mm),
        foot=(block.low_mm, block.high_mm),
        pinion=pinion,
        rim=rim,
        arm=(d.arm.flange_radius_mm, d.arm.boss_radius_mm, d.layers.arm_mm),
        bar_mm=f.bar_diameter_mm / 2,
        tube_mm=float(d.tube.outer_mm) / 2,
        ball_mm=f.cup_radius_mm,
        base=(plate, (d.base.top_mm - d.base.thickness_mm, d.base.top_mm)),
        hub=(p.hub_radius_mm, p.stem_diameter_mm / 2, p.boss_diameter_mm, p.stem_length_mm),
        knob=(float(d.knob.diameter_mm) / 2, top + p.stem_length_mm + float(d.knob.height_mm - d.knob.diameter_mm / 2)),
    )


def body(found: Solved, of: Sizes) -> list[dict[str, Any]]:
    """Makes the body of a machine.

    Returns:
        Prisms and spheres, each with the link in whose frame it is, as `kinematics.js` names them, and its colour: a
        prism has the corners of its outline, convex or star-shaped about their middle, its axis, both ends along it,
        and its own frame in the link's if that is another, 16 numbers row by row; a sphere has a place and a radius.
    """
    g, _ = mechanism_of(found.lengths_mm)
    arm_mm, rod_mm = found.lengths_mm[0], found.lengths_mm[1]
    half, made = found.task.choice.width_mm / 2, list[dict[str, Any]]()

    def prism(link: str, outline: np.ndarray, ends: Sequence[float], axis: str, colour: int, at: Any = None) -> None:
        own = {} if at is None else {"at": np.round(at, 4).ravel().tolist()}
        corners = np.round(outline, 2).tolist()
        made.append({"link": link, "outline": corners, "ends": list(ends), "axis": axis, "colour": colour, **own})

    def sphere(link: str, place: Sequence[float], radius: float, colour: int) -> None:
        made.append({"link": link, "place": list(place), "radius": radius, "colour": colour})

    (plate, levels), (hub, stem, thick, long) = of.base, of.hub
    prism("base", hull(plate), levels, "z", GRAPHITE)
    for i in CHAINS:
        u, t = g.radial[i], g.tangential[i]
        stand = np.eye(4)
        stand[:3, :3], stand[:3, 3] = np.stack([u, t, [0.0, 0.0, 1.0]], axis=1), g.base_radii[i] * MM_PER_M * u
        for circles, ends in of.cheeks:
            prism("base", hull(circles), ends, "y", ALUMINIUM, stand)
        (x, y, z), (x2, y2, z2) = of.foot
        prism("base", np.array([(x, z), (x2, z), (x2, z2), (x, z2)]), (y, y2), "y", ALUMINIUM, stand)
        radius, ends, (x, z) = of.motor
        prism("base", circle(x, z, radius), ends, "y", BLACK, stand)
        if of.pinion is not None:
            radius, ends, (x, z) = of.pinion
            prism("base", circle(x, z, radius), ends, "y", STEEL, stand)
        arm = f"upper_arm_{i}"
        root, boss, ends = of.arm
        prism(arm, hull([(0.0, 0.0, root), (arm_mm, 0.0, boss)]), ends, "y", ORANGE)
        if of.rim is not None:
            radius, ends, (low, high) = of.rim
            turns = np.linspace(low, high, _ARC)
            rim = radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
            prism(arm, np.concatenate([rim, [[0.0, 0.0]]]), ends, "y", ORANGE)
            prism(arm, circle(0.0, 0.0, root), (of.arm[2][0], ends[1]), "y", ORANGE)
        prism(arm, circle(arm_mm, 0.0, of.bar_mm), (-half, half), "y", STEEL)
        for j in (0, 1):
            prism(f"rod_{i}_{j}", circle(0.0, 0.0, of.tube_mm), (0.0, rod_mm), "x", CARBON)
            for end in (0.0, rod_mm):
                sphere(f"rod_{i}_{j}", (end, 0.0, 0.0), of.ball_mm, STEEL)
        turn = np.eye(4)
        turn[:3, :3] = stand[:3, :3]
        wrist = g.platform_radius * MM_PER_M
        prism("platform", circle(wrist, 0.0, of.bar_mm), (-half, half), "y", STEEL, turn)
        prism("platform", circle(wrist, 0.0, thick / 2), (-half / 2, half / 2), "y", ALUMINIUM, turn)
        web = hull([(0.0, 0.0, hub), (wrist, half / 2 - 2.0, 2.0), (wrist, 2.0 - half / 2, 2.0)])
        prism("platform", web, (0.0, thick / 2), "z", ALUMINIUM, turn)
    prism("platform", circle(0.0, 0.0, hub), (-thick / 2, thick / 2), "z", ALUMINIUM)
    prism("platform", circle(0.0, 0.0, stem), (thick / 2, thick / 2 + long), "z", STEEL)
    sphere("platform", (0.0, 0.0, of.knob[1]), of.knob[0], BLACK)
    return made


def circle(x: float, z: float, radius: float) -> np.ndarray:
    """(n, 2) corners of a circle."""
    turns = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    return np.array([x, z]) + radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)


def hull(circles: Sequence[Circle]) -> np.ndarray:
    """(n, 2) corners of the hull of circles, counter-clockwise: the farthest point of all in each direction."""
    from scipy.spatial import ConvexHull

    points = np.concatenate([circle(*one) if one[2] > 0.0 else [one[:2]] for one in circles])
    return points[ConvexHull(points).vertices]
