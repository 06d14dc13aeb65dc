"""Unobservable parameters: combinations with the same effect, and those for which the poses are too close together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from haptics.calibration.fit import Fit
from haptics.calibration.unknowns import NAMES

NEVER = 1e-6  # singular value below which no noise is small enough: roundings leave 1e-12, the weakest true one 1e-2
DRAWN = 1.0  # below it the drawing tells more of a combination than the poses do
SHARE = 0.1  # of a parameter that has to lie in what is not told for it to be named


@dataclass(frozen=True)
class Unobservable:
    """Parameters of which some combinations are not told.

    Attributes:
        names: Such as "base_radius_0".
        combinations: How many.
        never: Whether no poses, however exact, would tell them.
        moves: Of a single combination the parts that move together, in units of what each may be off; else empty.
    """

    names: tuple[str, ...]
    combinations: int
    never: bool
    moves: tuple[float, ...] = ()

    def __str__(self) -> str:
        if self.never and len(self.names) == 2:
            which = "difference" if self.moves[0] * self.moves[1] > 0.0 else "sum"
            return f"{' and '.join(self.names)} cannot be told apart: only their {which} acts"
        listed, several = ", ".join(self.names), f"{self.combinations} combination{'s' * (self.combinations > 1)}"
        if len(self.names) == 1:
            return f"{listed}: these poses do not tell it better than the drawing: more poses, farther apart, would"
        if self.never:
            return f"{several} of {listed} cannot be told by any poses in this frame"
        return (
            f"{several} of {listed} these poses do not tell better than the drawing: more poses, farther apart, would"
        )


def unobservable(found: Fit) -> list[Unobservable]:
    """Finds the parameters that the poses do not determine.

    Returns:
        Groups of parameters that hang together, those that no poses would tell first.
    """
    told, rows = found.singular_values, found.directions
    missing = np.linalg.svd(rows)[2][len(told) :]  # where there are fewer equations than parameters
    never = np.vstack([rows[told < NEVER], missing])
    weak = rows[(told >= NEVER) & (told < DRAWN)]
    return [*_groups(never, True), *_groups(weak, False)]


def _groups(rows: np.ndarray, never: bool) -> Iterator[Unobservable]:
    """Groups of parameters that a space of directions (k, 33) ties together."""
    shared = rows.T @ rows
    left = [k for k in range(len(shared)) if shared[k, k] > SHARE]
    names = [f"{name}_{i}" for i in range(3) for name in NAMES]
    while left:
        group, work = {left[0]}, [left[0]]
        while work:
            k = work.pop()
            for other in left:
                if other not in group and abs(shared[k, other]) > SHARE:
                    group.add(other)
                    work.append(other)
        left = [k for k in left if k not in group]
        members = sorted(group)
        values, vectors = np.linalg.eigh(shared[np.ix_(members, members)])
        count = max(1, round(float(values.sum())))
        moves = tuple(float(v) for v in vectors[:, -1]) if count == 1 else ()
        yield Unobservable(tuple(names[k] for k in members), count, never, moves)
