"""Common volume of two shapes by the kernel's booleans, accepted only if their results are consistent.

Coincident faces (a screw in its hole, a bearing in its seat) are what booleans get wrong, so a result counts only when
`size(A) - size(A cut B)` agrees with `size(A common B)`; otherwise fuzzy tolerances are tried one after another, and
volumes are taken again by adaptive integration: a fixed rule errs by 1e-5 beside a helix.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from delta_cad.checks.contact.placing import frame_of_key, located
from delta_cad.common.memoize import cached, memoize
from delta_cad.solids.part import solid_digest

_FUZZY_MM = (0.0, 1e-5, 1e-4, 1e-3)  # from exact to a tenth of a fit; the first that agrees counts
_AGREEMENT = 1e-6  # of the smaller size
_INTEGRATED = 1e-8  # of a volume, to which adaptive integration goes
NOISE_MM3 = 1e-3  # common volume that the kernel may see between faces that touch
SLIDING_MM3 = 0.05  # and between faces that slide upon one another


def common_size(
    shapes: tuple[Any, Any], sizes: tuple[float, float], size: Callable[[Any], float], noise: float
) -> float | None:
    """Computes the volume that two solids share, or the area that two faces of one plane share.

    Args:
        shapes: The kernel's shapes in one frame.
        sizes: Their volumes, mm^3, or areas, mm^2.
        size: `volume` or `area`.
        noise: By which common and cut may differ: what a fuzzy tolerance may move.

    Returns:
        The common size; None where common and cut contradict each other either way round at every fuzzy tolerance. The
        smaller shape is cut first: that is less work, and its size is not lost beside a large one.
    """
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut

    (smaller, one), (larger, other) = sorted(zip(sizes, shapes, strict=True), key=lambda pair: pair[0])
    for fuzzy in _FUZZY_MM:
        crossing = _crossing(one, other, fuzzy)
        common = _boolean(BRepAlgoAPI_Common, one, other, crossing, size)
        if common is None:
            continue
        for whole, cut, by in ((smaller, one, other), (larger, other, one)):
            rest = _boolean(BRepAlgoAPI_Cut, cut, by, crossing, size)
            if rest is not None and abs(whole - rest - common) <= max(_AGREEMENT * smaller, noise):
                return max(common, 0.0)
    if size is not volume:
        return None
    return common_size(shapes, (fine_volume(shapes[0]), fine_volume(shapes[1])), fine_volume, noise)


def common_volume(a: Any, b: Any, b_in_a: np.ndarray, noise_mm3: float = NOISE_MM3) -> float | None:
    """Computes the volume that two solids share.

    Args:
        a: One `cadquery.Solid`.
        b: The other.
        b_in_a: (4, 4) frame of b in the frame of a, mm.
        noise_mm3: As of `common_size`.

    Returns:
        Volume, mm^3; None where the kernel contradicts itself, see `common_size`.
    """
    placed = frame_of_key(b_in_a)
    of = solid_digest(a), solid_digest(b), placed, noise_mm3
    sizes = solid_volume(a), solid_volume(b)
    return cached("common volume", of, lambda: common_size((a.wrapped, located(b, placed)), sizes, volume, noise_mm3))


def runs_into(a: Any, b: Any, b_in_a: np.ndarray) -> bool:
    """Decides whether two solids share a volume; where the kernel contradicts itself they do."""
    common = common_volume(a, b, b_in_a, SLIDING_MM3)
    return common is None or common > SLIDING_MM3


@memoize
def solid_volume(solid: Any) -> float:
    """Volume of a `cadquery.Solid` by the kernel, mm^3."""
    return volume(solid.wrapped)


def _crossing(a: Any, b: Any, fuzzy_mm: float) -> Any:
    """Intersects the faces of two shapes: the costly half of a boolean, which common and cut share."""
    from OCP.BOPAlgo import BOPAlgo_PaveFiller
    from OCP.TopTools import TopTools_ListOfShape

    arguments = TopTools_ListOfShape()
    arguments.Append(a)
    arguments.Append(b)
    filler = BOPAlgo_PaveFiller()
    filler.SetArguments(arguments)
    filler.SetNonDestructive(True)
    filler.SetUseOBB(True)
    if fuzzy_mm:
        filler.SetFuzzyValue(fuzzy_mm)
    filler.Perform()
    return filler


def _boolean(operation: Any, a: Any, b: Any, crossing: Any, size: Callable[[Any], float]) -> float | None:
    """Size of a boolean's result; None where it fails."""
    done = operation(a, b, crossing)
    return size(done.Shape()) if done.IsDone() and done.Shape() is not None else None


def volume(shape: Any) -> float:
    """Volume of a shape, mm^3."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return float(properties.Mass())


def fine_volume(shape: Any) -> float:
    """Volume of a shape by adaptive integration, mm^3: ten times the work on curved faces."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, _INTEGRATED, False, False)
    return float(properties.Mass())


def area(shape: Any) -> float:
    """Area of a shape's faces, mm^2."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, properties)
    return float(properties.Mass())
