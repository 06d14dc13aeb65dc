"""Adjacent parts: exact solids moved, equal relative positions, and bounds on the distance of a pair."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from delta_cad.checks.clearance.bodies import CollisionBody, boxes_gap
from delta_cad.checks.clearance.pairing import EQUAL_MM
from delta_cad.solids.part import location_of

Key = tuple[object, ...]


def relative_key(a: str, b: str, b_in_a: np.ndarray) -> Key:
    """Gives what two pairs of parts share if they are equal and stand equally to each other, (4, 4) in mm."""
    return a, b, *np.round(b_in_a[:3] / EQUAL_MM).astype(np.int64).ravel().tolist()


def frame_of_key(frame: np.ndarray) -> np.ndarray:
    """Rounds a (4, 4) frame in mm off the last bits that a machine placed otherwise has: 1e-9 mm, 1e-12 rad."""
    found = np.round(frame, 12)
    found[:3, 3] = np.round(found[:3, 3], 9)
    return found + 0.0  # no -0.0


def gaps_on_one_link(pairs: Sequence[tuple[CollisionBody, CollisionBody]]) -> np.ndarray:
    """Bounds the distances of bodies on one link from below by their boxes, (n,) mm."""
    return boxes_gap(
        np.array([b.centre - a.centre for a, b in pairs]),
        np.array([a.axes for a, _ in pairs]),
        np.array([a.half for a, _ in pairs]),
        np.array([b.axes for _, b in pairs]),
        np.array([b.half for _, b in pairs]),
    )


def located(solid: Any, frame: np.ndarray) -> Any:
    """Gives the kernel's shape of a `cadquery.Shape`, moved by a (4, 4) frame in mm without copying its geometry."""
    return solid.wrapped.Moved(location_of(frame))
