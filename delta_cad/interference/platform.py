"""The platform with wrists and the handle's stem, as shapes and as points within them, in the platform's frame."""

from __future__ import annotations

import numpy as np

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.platform import BOSS_BEVEL_MM, STEM_FLATS_MM, STEM_FLATS_Z_MM
from delta_cad.interference.shapes import Block, Placed, Points, Prism, Round, Shape, Windowed
from delta_cad.mechanism.placement import CHAINS, chain_turn

_STEP_MM = 3.0  # between points of an axis
_NOSE_POINTS = 24  # around a boss's end
_UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])  # axes whose y is the platform's z


def platform_shapes(d: Dimensions) -> list[Shape]:
    """Lists bosses, plate with its windows, hub and stem."""
    p, g = d.platform, d.design.geometry
    half, top = p.boss_length_mm / 2 - BOSS_BEVEL_MM, p.boss_diameter_mm / 2
    under = top - p.plate_mm
    web: Shape = Prism(p.web_mm, (under, top))
    if p.window_mm:
        web = Windowed(Prism(p.web_mm, (under, top)), Prism(p.window_mm, (under, top)))
    flats = top + STEM_FLATS_Z_MM[1]  # up to there a spanner's flats are taken all the way round
    uprights = (
        Round(p.hub_radius_mm, (-top, top)),
        Round(STEM_FLATS_MM / 2, (top, flats)),
        Round(p.stem_diameter_mm / 2, (flats, top + p.stem_length_mm)),
    )
    found: list[Shape] = [Placed(_UPRIGHT, one) for one in uprights]
    for i in CHAINS:
        turned = chain_turn(g, i)[:3, :3]
        boss = Round(top, (-half, half), (p.radius_mm, 0.0))
        found += [Placed(turned, boss), Placed(turned @ _UPRIGHT, web)]
        if under > 0.0:  # an upright flank of the boss
            found.append(Block(turned, (0.0, 0.0, 0.0), (p.radius_mm - top, -half, 0.0), (p.radius_mm, half, under)))
    return found


def platform_points(d: Dimensions) -> Points:
    """Gives the platform's wrists as balls in its frame: bosses with their ends, cross-bars, balls of the joints."""
    p, f = d.platform, d.forearm
    boss, half, wide = p.boss_diameter_mm / 2, p.boss_length_mm / 2, f.width_mm / 2
    inside = max(half - boss, 0.0)  # so far out a ball as wide as the boss lies in it
    y = np.linspace(-inside, inside, int(2 * inside / _STEP_MM) + 2)
    beyond = f.bar_length_mm / 2 - f.cone_mm - f.bar_diameter_mm / 2  # a ball as wide as the bar lies in it up to there
    bar = np.concatenate([sign * np.arange(half, beyond, _STEP_MM) for sign in (-1.0, 1.0)])
    turns = np.linspace(0.0, 2.0 * np.pi, _NOSE_POINTS, endpoint=False)
    around = np.stack([np.cos(turns), 0.0 * turns, np.sin(turns)], axis=1)
    rings = (boss - BOSS_BEVEL_MM, half), (boss, half - BOSS_BEVEL_MM)  # both edges of a boss's end
    edges = [radius * around + [0.0, sign * y, 0.0] for radius, y in rings for sign in (-1.0, 1.0)]
    middles = np.concatenate([y, bar, [-wide, wide]])[:, None] * np.array([0.0, 1.0, 0.0])
    local = np.concatenate([middles, *edges]) + np.array([p.radius_mm, 0.0, 0.0])
    radii = [min(boss, half)] * len(y) + [f.bar_diameter_mm / 2] * len(bar) + [f.ball_diameter_mm / 2] * 2
    radii += [0.0] * (len(local) - len(radii))
    return np.concatenate([local @ d.turn(i)[:3, :3].T for i in CHAINS]), np.tile(radii, 3)
