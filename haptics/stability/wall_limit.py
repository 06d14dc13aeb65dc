"""Largest stable wall by the paper's protocol and a bisection, for any answer to whether a wall stands."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

# The paper's protocol, N/m: K_e starts at 1.1 N/mm and grows by 0.2 N/mm until the user feels oscillation.
START, STEP = 1100.0, 200.0

Predicate = Callable[[float], bool]  # Stiffness (N/m) -> whether the wall is stable


@dataclass(frozen=True)
class WallSearch:
    """Largest stable stiffness of a wall (the Z-width of one axis), as a search brackets it.

    Attributes:
        protocol: Last stable stiffness of the paper's steps, N/m; None if the first one oscillates.
        bisection: Largest stable stiffness to the tolerance, N/m.
        history: Each stiffness tried (N/m) with its answer, in order.
        ceiling_reached: It never oscillated up to the ceiling; both values are then lower bounds.
    """

    protocol: float | None
    bisection: float
    history: tuple[tuple[float, bool], ...]
    ceiling_reached: bool


def search(
    stable: Predicate, *, start: float = START, step: float = STEP, ceiling: float = 20e3, tolerance: float = 10.0
) -> WallSearch:
    """Largest stable stiffness by the paper's protocol, then by bisection within its last step.

    Args:
        stable: Called once for each stiffness, N/m.
        start: First stiffness, N/m.
        step: N/m.
        ceiling: Stiffness at which the search ends, N/m.
        tolerance: Tolerance of the bisection, N/m.

    Returns:
        Both values and the history. If the first stiffness oscillates already, the bisection is between 0 and it.

    Raises:
        ValueError: A parameter is not positive, or the ceiling lies below the start.
    """
    for name, value in (("start", start), ("step", step), ("tolerance", tolerance)):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} is {value!r} N/m; it must be finite and positive")
    if not (math.isfinite(ceiling) and ceiling >= start):
        raise ValueError(f"ceiling is {ceiling!r} N/m; it must be finite and at least the start, {start:g} N/m")
    history: list[tuple[float, bool]] = []

    def ask(stiffness: float) -> bool:
        answer = bool(stable(stiffness))
        history.append((stiffness, answer))
        return answer

    protocol: float | None = None
    for i in range(math.floor((ceiling - start) / step + 1e-9) + 1):  # the ceiling itself belongs to it
        stiffness = start + i * step
        if not ask(stiffness):
            break
        protocol = stiffness
    else:
        assert protocol is not None
        return WallSearch(protocol, protocol, tuple(history), ceiling_reached=True)
    low, high = protocol or 0.0, stiffness
    while high - low > tolerance:
        middle = (low + high) / 2.0
        low, high = (middle, high) if ask(middle) else (low, middle)
    return WallSearch(protocol, low, tuple(history), ceiling_reached=False)
