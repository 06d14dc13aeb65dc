"""Diagnosis of poses that do not fit: the fit repeated with common errors of units, columns, frame or labels reversed.

A hypothesis is a cause where the poses then fit as well as noise lets them, or ten times as well as before. Nothing is
corrected: the causes are named, for the person to correct the file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np

from delta_cad.common.units import MM_PER_M
from haptics.calibration.fit import Fit, FitError
from haptics.calibration.poses import Poses

MISFIT_MOST = 3.0  # what is left of the poses over what their noise explains; beyond it something else is wrong
UNLIKE_MOST = 8.0  # standard deviations of a length from its drawing; beyond it is no device that was made to it
_NOISE_ALONE = 1.5  # misfit that noise alone leaves, with a margin
_SPREAD, _SPREAD_RAD = (
    2e-3,
    math.radians(1.0),
)  # of the positions, m, and of the readings: the least that is a set of poses
_CLEAR = 10.0  # by which a hypothesis lowers the misfit
_SUSPECTS = 4  # poses, those with the largest residuals, of which one may have a wrong label, or two each other's
_POSITION_UNITS = (("metres", MM_PER_M), ("centimetres", 10.0), ("inches", 25.4))
_AXES, _READINGS = ("x_mm", "y_mm", "z_mm"), ("reading_0_deg", "reading_1_deg", "reading_2_deg")


@dataclass(frozen=True)
class Cause:
    """A hypothesis under which the poses fit.

    Attributes:
        kind: "unit", "sign", "columns", "frame" or "label" of a pose.
        text: What is wrong with the file, in words.
        misfit: Of the fit with that corrected.
    """

    kind: str
    text: str
    misfit: float


def fits(found: Fit) -> bool:
    """Decides whether poses are those of a device that was made to the drawing."""
    return found.misfit <= MISFIT_MOST and found.unlike[0] <= UNLIKE_MOST


def causes(
    refit: Callable[[Poses, bool], Fit],
    poses: Poses,
    own_frame: bool,
    failed: Fit | FitError,
    count: float,
    three_fold: bool = True,
) -> list[Cause]:
    """Finds the errors in a file of poses, one at a time, that explain why they do not fit.

    Args:
        refit: Fits poses; the second argument says whether their frame is sought. Raises FitError.
        poses: What was measured.
        own_frame: Whether their frame was sought.
        failed: Their fit, which is none that `fits`, or the reason why there is none.
        count: Angle of one count of the encoder, rad.
        three_fold: Whether the drawing is the same for all chains, so that a frame of its own hides which is which.

    Returns:
        The causes, the most likely first; empty where no hypothesis explains the poses.
    """
    most = min(MISFIT_MOST, max(_NOISE_ALONE, failed.misfit / _CLEAR)) if isinstance(failed, Fit) else MISFIT_MOST
    found = []
    all_alike = _of_all(poses, own_frame, count, three_fold)
    for kind, text, changed, own in (*all_alike, *_of_two(poses, own_frame, _suspects(failed))):
        if np.ptp(changed.positions, axis=0).max() < _SPREAD or np.ptp(changed.readings, axis=0).max() < _SPREAD_RAD:
            continue  # a single point, which fits anything
        with suppress(FitError):
            one = refit(changed, own)
            if one.misfit <= most and fits(one):
                found.append(Cause(kind, text, one.misfit))
    found += _of_one(refit, poses, own_frame, _suspects(failed))
    return sorted(found, key=lambda cause: (cause.kind == "frame", cause.misfit))  # a frame is free to explain most


def _of_all(poses: Poses, own_frame: bool, count: float, three_fold: bool) -> Iterator[tuple[str, str, Poses, bool]]:
    """Errors of all poses alike: kind, text, the poses without the error, whether their frame is sought."""
    for unit, factor in _POSITION_UNITS:
        text = f"the positions are in {unit}, not mm: multiply them by {factor:g}"
        yield "unit", text, replace(poses, positions=factor * poses.positions), own_frame
    for unit, factor in (("radians", math.degrees(1.0)), ("counts", math.degrees(count))):
        text = f"the readings are in {unit}, not degrees: multiply them by {factor:.9g}"
        yield "unit", text, replace(poses, readings=factor * poses.readings), own_frame
    text = "the readings fall where the arms' angles grow: change the sign of all three"
    yield "sign", text, replace(poses, readings=-poses.readings), own_frame
    mirrored = replace(poses, positions=poses.positions * [1.0, 1.0, -1.0])
    if own_frame:  # which takes up every rotation, so that mirror images differ in nothing
        text = "positions and readings are mirror images: two columns are swapped, or an axis has the wrong sign"
        yield "columns", text, mirrored, own_frame
        if three_fold:
            return
    else:
        text = "z_mm falls from the base to the platform, where it must grow: change its sign"
        yield "sign", text, mirrored, own_frame
    columns = ((_READINGS, "readings"), (_AXES, "positions"))[: 1 if own_frame else 2]
    for order in list(permutations(range(3)))[1:]:
        for names, field in columns:
            holds = ", ".join(f"{names[k]} holds {names[n]}" for k, n in enumerate(order) if k != n)
            changed = replace(poses, **{field: getattr(poses, field)[:, np.argsort(order)]})
            yield "columns", f"columns are swapped: {holds}", changed, own_frame
    if not own_frame:
        yield "frame", "the positions are not in the base frame: --frame own fits theirs", poses, True


def _of_two(poses: Poses, own_frame: bool, suspects: Sequence[int]) -> Iterator[tuple[str, str, Poses, bool]]:
    """Two poses with each other's position, as `_of_all`."""
    for i, j in combinations(sorted(suspects), 2):
        positions = poses.positions.copy()
        positions[[i, j]] = positions[[j, i]]
        text = f"poses {i + 1} and {j + 1} have each other's position"
        yield "label", text, replace(poses, positions=positions), own_frame


def _of_one(
    refit: Callable[[Poses, bool], Fit], poses: Poses, own_frame: bool, suspects: Sequence[int]
) -> Iterator[Cause]:
    """A single pose at another place than stated: the others fit, and its error is `_CLEAR` times theirs."""
    for k in suspects:
        others = np.arange(len(poses.positions)) != k
        with suppress(FitError):
            found = refit(Poses(poses.positions[others], poses.readings[others]), own_frame)
            one = Poses(poses.positions[k : k + 1], poses.readings[k : k + 1])
            off = float(np.linalg.norm(replace(found.problem, poses=one).apart(found.x)))
            if fits(found) and not off < _CLEAR * np.sqrt((found.after**2).mean()):
                where = "no position has its readings" if math.isnan(off) else f"and put it {MM_PER_M * off:.3g} mm off"
                yield Cause(
                    "label", f"pose {k + 1} has a wrong position or reading: the others fit, {where}", found.misfit
                )


def _suspects(failed: Fit | FitError) -> Sequence[int]:
    """Poses with the largest residuals, or at which the device cannot be; none where those are many."""
    if isinstance(failed, Fit):
        return [int(n) for n in np.argsort(failed.after)[::-1][:_SUSPECTS]]
    return failed.poses if len(failed.poses) <= _SUSPECTS else ()
