"""How square bores and shoulders are to the planes they count from: the loosest zones that their chains bear.

A seat out of square tilts the ring in it, which gives way by its play; the shaft's shoulder tilts the inner ring.
Sector, arm and pinion out of square take the cable out of its plane, and an arm the elbow along the shoulder's axis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf

from delta_cad.dimensions.tolerances import RING_UM, SEATS_MM, minutes
from delta_cad.dimensions.tolerances.chain import Chain, Link, either_way

Feature = tuple[str, str]
"""Part, and the words of the link that has its zone."""
Zones = Mapping[Feature, float]
"""Feature -> width of its zone, mm."""

STEPS_MM = (0.01, 0.012, 0.015, 0.02, 0.025, 0.03, 0.04, 0.05, 0.1, 0.2)
"""Zones that a drawing states; beyond, ISO 2768-2 has the squareness of a short face."""
MOTOR_SEAT, ENCODER_SEAT = ("motor_cheek", "seat out of square"), ("encoder_cheek", "seat out of square")
SHOULDER = "shoulder_shaft", "shoulder out of square"
ARM, SECTOR = ("upper_arm", "bore out of square"), ("sector", "bore out of square")
FINEST: Zones = dict.fromkeys((MOTOR_SEAT, ENCODER_SEAT, SHOULDER, ARM, SECTOR), STEPS_MM[0])
"""The tightest zones that a drawing states."""
_PER_RAD = minutes(1.0)


def tilted(feature: Feature, zones: Zones, over_mm: float, share: float) -> Link:
    """Makes the link of a feature whose axis, or plane, tilts in its zone.

    Args:
        feature: The feature.
        zones: Of all.
        over_mm: Length of the axis, or width of the plane.
        share: By which the figure grows per rad.
    """
    part, what = feature
    return either_way(part, what, "place", zones[feature] / 2.0, 2.0 * share / over_mm)


def bearing_chains(
    shaft: Chain, zones: Zones, seats_mm: tuple[float, float], head_mm: float, wide_mm: float
) -> list[Chain]:
    """Lists how far the rings of a shoulder's bearings are askew, minutes of arc, motor's side and encoder's side.

    Args:
        shaft: The chain of the shaft's tilt, whose bound is that of a bearing.
        zones: Of the features.
        seats_mm: Depths of the seats, motor's side and encoder's side.
        head_mm: Diameter of the shaft's shoulder.
        wide_mm: Width of a bearing.
    """
    found = []
    for k, (side, seat) in enumerate((("motor", MOTOR_SEAT), ("encoder", ENCODER_SEAT))):
        play = SEATS_MM[k] + RING_UM / 1000.0
        links = [
            *shaft.links,
            tilted(seat, zones, seats_mm[k], _PER_RAD),
            Link("bearing", "turns in its seat by its play", "fit", 0.0, play, -_PER_RAD / wide_mm),
        ]
        if side == "encoder":
            links.append(tilted(SHOULDER, zones, head_mm, _PER_RAD))
        name, why = f"bearing's tilt, {side}'s side", "beyond, its races run askew: another cheek, or shaft"
        found.append(Chain(name, "arcmin", 0.0, tuple(links), -inf, shaft.high, why, statistical=True))
    return found


def loosest(features: Sequence[Feature], chains: Callable[[Zones], Iterable[Chain]]) -> dict[Feature, float]:
    """Finds the loosest zones with which every chain that has one of them holds: none can be a step looser.

    The tightest is loosened first; one whose chain does not hold with the first step stays there.

    Args:
        features: The features.
        chains: Gives the chains for zones.
    """
    steps = dict.fromkeys(features, 0)

    def holds(feature: Feature) -> bool:
        zones = {one: STEPS_MM[step] for one, step in steps.items()}
        own = (chain for chain in chains(zones) if any((x.part, x.what) == feature for x in chain.links))
        return all(chain.holds for chain in own)

    left = list(features)
    while left:
        feature = min(left, key=lambda one: steps[one])
        steps[feature] += 1
        if steps[feature] == len(STEPS_MM) or not holds(feature):
            steps[feature] -= 1
            left.remove(feature)
    return {one: STEPS_MM[step] for one, step in steps.items()}
