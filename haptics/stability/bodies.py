"""Linear bodies between samples: device and hand, as masses with springs and dampers between them.

`M q'' + D q' + S q = P f`. A body grows by what is attached to a place `L q` of it: a mass behind a spring and damper,
or a spring and damper to ground. This module is light.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from haptics.model.plant import Hand


class SampledBody(NamedTuple):
    """Device and hand between samples.

    Attributes:
        mass: (n, n), kg or kg m^2.
        damping: (n, n), N s/m or N m s/rad.
        stiffness: (n, n), N/m or N m/rad.
    """

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray


class Ports(NamedTuple):
    """Where a loop touches a body.

    Attributes:
        push: (n, m) P, how its commands act on the coordinates.
        see: (m, n) C, what it reads of them.
    """

    push: np.ndarray
    see: np.ndarray


def axis(mass: float, friction: float = 0.0, hand: Hand | None = None) -> SampledBody:
    """One axis of a device in a hand.

    Args:
        mass: Effective mass of the device along the axis, kg.
        friction: Viscous friction, N s/m.
        hand: Who holds it; nobody if left out.

    Returns:
        The body; n = 1, or 2 with a hand behind its grasp.

    Raises:
        ValueError: A figure is not finite or negative, or there is no mass.
    """
    figures = (mass, friction) if hand is None else (mass, friction, *hand)
    if not all(math.isfinite(f) and f >= 0.0 for f in figures) or not mass > 0.0:
        raise ValueError(f"mass {mass!r} kg, friction {friction!r} N s/m, hand {hand}: must be finite, none negative")
    alone = SampledBody(np.array([[mass]]), np.array([[friction]]), np.zeros((1, 1)))
    return alone if hand is None else held(alone, np.eye(1), hand)


def loaded(
    body: SampledBody,
    place: np.ndarray,
    mass: float = 0.0,
    damping: float | np.ndarray = 0.0,
    stiffness: float | np.ndarray = 0.0,
) -> SampledBody:
    """The body with a mass at a place, and a spring and damper from there to ground.

    Args:
        body: n coordinates.
        place: (k, n) L.
        mass: kg, in each of the k directions.
        damping: N s/m, alike in all directions, or (k, k).
        stiffness: N/m, likewise.
    """

    def seen(figure: float | np.ndarray) -> np.ndarray:
        return place.T @ (figure * np.eye(len(place)) if np.ndim(figure) == 0 else figure) @ place

    return SampledBody(body.mass + seen(mass), body.damping + seen(damping), body.stiffness + seen(stiffness))


def attached(
    body: SampledBody, place: np.ndarray, mass: float, damping: float | np.ndarray, stiffness: float | np.ndarray
) -> tuple[SampledBody, np.ndarray]:
    """The body with a mass behind a spring and damper at a place.

    Args:
        body: n coordinates.
        place: (k, n) L.
        mass: kg; its k coordinates come last.
        damping: Between place and mass, N s/m, alike in all directions, or (k, k).
        stiffness: N/m, likewise.

    Returns:
        The body of n + k coordinates, and (k, n + k) the place of the mass.
    """
    n, k = body.mass.shape[0], len(place)
    between = np.hstack([-place, np.eye(k)])
    grown = SampledBody(*(np.pad(matrix, (0, k)) for matrix in body))
    grown = loaded(grown, between, damping=damping, stiffness=stiffness)
    own = np.hstack([np.zeros((k, n)), np.eye(k)])
    return loaded(grown, own, mass=mass), own


def held(body: SampledBody, place: np.ndarray, hand: Hand) -> SampledBody:
    """The body in a hand, alike in the k directions of the place (k, n) that it holds."""
    if hand.grasp_stiffness > 0.0:
        body, place = attached(body, place, hand.mass, hand.grasp_damping, hand.grasp_stiffness)
        return loaded(body, place, damping=hand.damping, stiffness=hand.stiffness)
    return loaded(body, place, hand.mass, hand.damping, hand.stiffness)


def continuous(body: SampledBody, push: np.ndarray, lag: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Rate of q, q' and, with a lag, of the motors' force (m), and how commands change it.

    Args:
        body: n coordinates.
        push: (n, m).
        lag: Time constant of the motors, s; 0 for none.

    Returns:
        (N, N), (N, m) with N = 2 n + m, or 2 n without a lag.
    """
    n, m = push.shape
    size = 2 * n + (m if lag > 0.0 else 0)
    rate, asked = np.zeros((size, size)), np.zeros((size, m))
    rate[:n, n : 2 * n] = np.eye(n)
    rate[n : 2 * n, :n] = -np.linalg.solve(body.mass, body.stiffness)
    rate[n : 2 * n, n : 2 * n] = -np.linalg.solve(body.mass, body.damping)
    acts = np.linalg.solve(body.mass, push)
    if lag > 0.0:
        rate[n : 2 * n, 2 * n :] = acts
        rate[2 * n :, 2 * n :] = -np.eye(m) / lag
        asked[2 * n :] = np.eye(m) / lag
    else:
        asked[n:] = acts
    return rate, asked
