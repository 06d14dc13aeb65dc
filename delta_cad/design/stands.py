"""Where the three equal chains of a machine stand: how neighbours lie to each other, and where their arms stand alike.

Every chain is turned alike about its own shoulder, so of two neighbours the first one's motor side (+t) faces the
other's encoder side: pairs are taken in the order of the azimuths, 0 and 1, 1 and 2, 2 and 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.geometry import SIN_60, DeltaGeometry
from delta_cad.mechanism.inverse import joint_angles
from delta_cad.mechanism.workspace import Cube

_HALVINGS = 60  # of the cube's side: to the last bit


@dataclass(frozen=True)
class Gap:
    """The angle between two neighbouring chains, and where they stand.

    Attributes:
        half_sine: Sine of half the angle.
        half_cosine: Its cosine, negative where the angle is more than 180 degrees.
        sine: Of the angle.
        cosine: Of the angle.
        out_mm: How much farther out than chain 0 the first of both stands.
        next_out_mm: The same of the other, next anticlockwise.
    """

    half_sine: float = SIN_60
    half_cosine: float = 0.5
    sine: float = SIN_60
    cosine: float = -0.5
    out_mm: float = 0.0
    next_out_mm: float = 0.0

    @property
    def next_stand(self) -> np.ndarray:
        """(4, 4) stand of the next chain as seen from the first one's, mm; see `chain_stand`."""
        c, s = self.cosine, self.sine
        frame = np.array([[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
        frame[:2, 3] = self.next_out_mm * c - self.out_mm, self.next_out_mm * s
        return frame


EVEN = (Gap(),)
"""Those of a three-fold symmetric machine, where each is as the others."""
EVEN_DEG = (0.0, 120.0, 240.0)
"""Its azimuths."""


def gaps_of(g: DeltaGeometry) -> tuple[Gap, ...]:
    """Gives the three gaps of a machine: between chains 0 and 1, 1 and 2, 2 and 0; `EVEN` where they are alike."""
    if g.three_fold:
        return EVEN
    c, s, out = g.side_cosine, g.side_sine, g.side_shift * MM_PER_M
    half = math.sqrt((1.0 - c) / 2.0), math.sqrt((1.0 + c) / 2.0)
    return (
        Gap(*half, s, c, 0.0, out),
        Gap(s, -c, -2.0 * s * c, 2.0 * c * c - 1.0, out, out),
        Gap(*half, s, c, out, 0.0),
    )


def narrowest_gap(gaps: Sequence[Gap]) -> Gap:
    """Gives the one of the smallest angle."""
    return max(gaps, key=lambda gap: gap.half_cosine)


def other_stands(gaps: Sequence[Gap]) -> list[np.ndarray]:
    """Gives the stand of each chain as seen from that of each other, (4, 4), mm: two for each gap."""
    return [frame for gap in gaps for frame in (gap.next_stand, np.linalg.inv(gap.next_stand))]


@lru_cache(maxsize=256)
def home_x(g: DeltaGeometry, cube: Cube) -> float:
    """Computes x of the handle position at which the three arms stand alike, so that equal chains are drawn alike.

    That position lies half-way up the cube in the plane of symmetry, all over which chains 1 and 2 stand alike. Where
    the three stand equally far out it is on the base's axis, whatever their azimuths; of a three-fold symmetric machine
    it is the cube's middle.

    Args:
        g: The mechanism.
        cube: The cube.

    Returns:
        x, m; that of the nearer face of the cube where the arms stand alike outside it only.
    """
    z = cube.bottom_height + cube.half_side
    low, high = cube.centre_x - cube.half_side, cube.centre_x + cube.half_side
    if g.side_shift == 0.0 and low <= 0.0 <= high:
        return 0.0

    def ahead(x: float) -> float:
        first, side, _ = joint_angles(g, np.array([x, 0.0, z]))
        return float(first - side)

    rising = ahead(high) > ahead(low)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2.0
        low, high = (low, middle) if (ahead(middle) > 0.0) == rising else (middle, high)
    return (low + high) / 2.0
