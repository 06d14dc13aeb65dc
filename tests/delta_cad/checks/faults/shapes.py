"""Solids made wrong: mirrored, scaled, cut short, drawn out, bored wider, narrower or once more, sawn, hollow."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import cadquery as cq
import numpy as np

from delta_cad.assembly.faces import SolidFace
from delta_cad.checks.contact.features import features
from delta_cad.checks.solidity import solid_faults

AXES = "xyz"
SHARE = 0.25  # of its length that a part is too short
LONGER_MM = 1.5
BORED = 0.06  # share of its diameter that a bore is too wide or too narrow: 0.5 mm on 8 mm
SCALES = (0.97, 1.03)
SAME_MM3 = 0.05  # symmetric difference of solids that are the same but for noise
SHIFT_MM = 0.5
SAW_MM = 1.0
SAWN_AT = (0.3, 0.5, 0.7)  # of a part's length: half through
DRILL_MM = 2.2  # no hole of the design
VOID_MM = 1.0
POINTS = 60  # at which a solid is sounded for its thickest place
LEAST_TURN_RAD = 4.5  # of a bore's faces together: a split one has 6.0, the end of a pocket 3.3


def made_wrong(solid: cq.Solid, project_own: bool = True) -> Iterator[tuple[str, cq.Solid]]:
    """Yields what is wrong and the solid in the part's own frame; what is no solid or nothing new is left out.

    A part that we make (`project_own`) may be sawn into; one that is bought comes whole.
    """
    for name, make in _ways(solid):
        if name.startswith("sawn") and not project_own:
            continue
        pieces = make().Solids()
        if len(pieces) != 1 or not differs(solid, pieces[0]):
            continue
        if name.startswith("hollow") or not solid_faults(pieces[0]):
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
    yield from _cut_away(solid, low, high, k)
    for diameter, bores in bores_of(solid).items():
        yield f"bored {diameter:g} too wide", lambda b=bores: solid.cut(*(_bar(c, 1.0 + BORED) for c in b))
        yield (
            f"bored {diameter:g} too narrow",
            lambda b=bores: solid.fuse(*(_bar(c, 1.0).cut(_bar(c, 1.0 - BORED)) for c in b)),
        )


def _cut_away(
    solid: cq.Solid, low: np.ndarray, high: np.ndarray, k: int
) -> Iterator[tuple[str, Callable[[], cq.Shape]]]:
    """Sawn half through across its longest way, drilled where it is thick, and hollow there."""
    j = int(np.argsort(high - low)[1])
    for share in SAWN_AT:
        first, last = low - 1.0, high + 1.0
        first[k] = low[k] + share * (high - low)[k]
        last[k] = first[k] + SAW_MM
        middle = np.array(cq.Shape.centerOfMass(_slice(solid, first, last)).toTuple())
        if np.isfinite(middle).all():
            first[j] = middle[j]
            block = cq.Solid.makeBox(*(last - first), pnt=cq.Vector(*first))
            yield f"sawn half through at {share:g} of {AXES[k]}", lambda block=block: solid.cut(block)
    at = _inside(solid, low, high)
    if at is not None:
        along = cq.Vector(*np.eye(3)[int(np.argmin(high - low))])
        start = cq.Vector(*at) - along * float((high - low).max())
        drill = cq.Solid.makeCylinder(DRILL_MM / 2.0, 2.0 * float((high - low).max()), start, along)
        yield f"drilled {DRILL_MM:g} once more", lambda: solid.cut(drill)
        hollow = cq.Solid.makeSphere(VOID_MM / 2.0, cq.Vector(*at), angleDegrees1=-90, angleDegrees2=90)
        yield f"hollow by {VOID_MM:g} mm", lambda: solid.cut(hollow)


def _slice(solid: cq.Solid, first: np.ndarray, last: np.ndarray) -> cq.Shape:
    """What of a solid lies in a box."""
    return solid.intersect(cq.Solid.makeBox(*(last - first), pnt=cq.Vector(*first)))


def _inside(solid: cq.Solid, low: np.ndarray, high: np.ndarray) -> np.ndarray | None:
    """(3,) the point of a grid that lies deepest in a solid, where a drill leaves metal around itself."""
    best, deepest = None, 0.75 * DRILL_MM
    surface = cq.Compound.makeCompound(solid.Faces())
    for share in np.random.default_rng(1).uniform(0.05, 0.95, (POINTS, 3)):
        at = low + share * (high - low)
        point = cq.Vertex.makeVertex(*at)
        if (deep := surface.distance(point)) > deepest and solid.distance(point) == 0.0:
            best, deepest = at, deep
    return best


def bores_of(solid: cq.Solid) -> dict[float, list[SolidFace]]:
    """Bores of a solid by their diameter, mm, split ones too; fillets and the ends of pockets are none."""
    axes: dict[tuple[float, ...], list[SolidFace]] = {}
    for c in features(solid).cylinders:
        if c.is_hollow:
            foot = c.point - (c.point @ c.direction) * c.direction
            axis = (*foot.round(3), *np.abs(c.direction).round(3))
            axes.setdefault((round(2.0 * c.radius_mm, 3), *(float(v) + 0.0 for v in axis)), []).append(c)
    bores: dict[float, list[SolidFace]] = {}
    for (diameter, *_), faces in axes.items():
        if sum(c.turn_rad for c in faces) > LEAST_TURN_RAD:
            bores.setdefault(diameter, []).extend(faces)
    return bores


def _bar(bore: SolidFace, factor: float) -> cq.Solid:
    """A bar as long as a bore and `factor` times as thick."""
    start = cq.Vector(*(bore.point + bore.start_mm * bore.direction))
    length = bore.end_mm - bore.start_mm
    return cq.Solid.makeCylinder(factor * bore.radius_mm, length, start, cq.Vector(*bore.direction))
