"""Solids made wrong: mirrored, scaled, cut short, drawn out, bored wider or narrower."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import cadquery as cq
import numpy as np

from delta_cad.checks.contact.features import Cylinder, features
from delta_cad.checks.solidity import solid_faults

AXES = "xyz"
SHARE = 0.25  # of its length that a part is too short
LONGER_MM = 1.5
BORED = 0.06  # share of its diameter that a bore is too wide or too narrow: 0.5 mm on 8 mm
SCALES = (0.97, 1.03)
SAME_MM3 = 0.05  # symmetric difference of solids that are the same but for noise
SHIFT_MM = 0.5
LEAST_TURN_RAD = 4.5  # of a bore's faces together: a split one has 6.0, the end of a pocket 3.3


def made_wrong(solid: cq.Solid) -> Iterator[tuple[str, cq.Solid]]:
    """Yields what is wrong and the solid in the part's own frame; what is no solid or nothing new is left out."""
    for name, make in _ways(solid):
        shape = make()
        pieces = shape.Solids()
        if len(pieces) == 1 and not solid_faults(pieces[0]) and differs(solid, pieces[0]):
            yield name, pieces[0]


def differs(solid: cq.Shape, other: cq.Shape) -> bool:
    """Decides whether two solids in one frame differ by more than the kernel's noise."""
    if abs(solid.Volume() - other.Volume()) > SAME_MM3:
        return True
    return solid.cut(other).Volume() + other.cut(solid).Volume() > SAME_MM3


def _ways(solid: cq.Solid) -> Iterator[tuple[str, Callable[[], cq.Shape]]]:
    box = solid.BoundingBox()
    low, high = np.array([box.xmin, box.ymin, box.zmin]), np.array([box.xmax, box.ymax, box.zmax])
    middle = cq.Vector(*((low + high) / 2.0))
    for axis, plane in zip(AXES, ("YZ", "XZ", "XY"), strict=True):
        yield f"mirrored along {axis}", lambda plane=plane: solid.mirror(plane, middle)
    for factor in SCALES:
        yield f"scaled by {factor:g}", lambda f=factor: solid.translate(-middle).scale(f).translate(middle)
    k = int(np.argmax(high - low))
    along = np.eye(3)[k]
    for end, sense in (("+", 1.0), ("-", -1.0)):
        first, last = low - 1.0, high + 1.0
        if sense > 0.0:
            first[k] = high[k] - SHARE * (high - low)[k]
        else:
            last[k] = low[k] + SHARE * (high - low)[k]
        block = cq.Solid.makeBox(*(last - first), pnt=cq.Vector(*first))
        yield f"too short at {end}{AXES[k]}", lambda block=block: solid.cut(block)
        moved = cq.Vector(*(sense * LONGER_MM * along))
        yield f"too long at {end}{AXES[k]}", lambda moved=moved: solid.fuse(solid.translate(moved))
    for diameter, bores in bores_of(solid).items():
        yield f"bored {diameter:g} too wide", lambda b=bores: solid.cut(*(_bar(c, 1.0 + BORED) for c in b))
        yield (
            f"bored {diameter:g} too narrow",
            lambda b=bores: solid.fuse(*(_bar(c, 1.0).cut(_bar(c, 1.0 - BORED)) for c in b)),
        )


def bores_of(solid: cq.Solid) -> dict[float, list[Cylinder]]:
    """Bores of a solid by their diameter, mm, split ones too; fillets and the ends of pockets are none."""
    axes: dict[tuple[float, ...], list[Cylinder]] = {}
    for c in features(solid).cylinders:
        if c.is_bore:
            foot = c.point - (c.point @ c.direction) * c.direction
            axis = (*foot.round(3), *np.abs(c.direction).round(3))
            axes.setdefault((round(2.0 * c.radius_mm, 3), *(float(v) + 0.0 for v in axis)), []).append(c)
    bores: dict[float, list[Cylinder]] = {}
    for (diameter, *_), faces in axes.items():
        if sum(c.turn_rad for c in faces) > LEAST_TURN_RAD:
            bores.setdefault(diameter, []).extend(faces)
    return bores


def _bar(bore: Cylinder, factor: float) -> cq.Solid:
    """A bar as long as a bore and `factor` times as thick."""
    start = cq.Vector(*(bore.point + bore.start_mm * bore.direction))
    length = bore.end_mm - bore.start_mm
    return cq.Solid.makeCylinder(factor * bore.radius_mm, length, start, cq.Vector(*bore.direction))
