"""The same force everywhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.jit import compiled
from haptics.rendering.law import ForceLaw, Law, columns, vector
from haptics.rendering.states import AT_REST, force_function


@dataclass(frozen=True)
class ConstantForce(ForceLaw):
    """The same force everywhere.

    Attributes:
        force: (3,) on the handle, base frame, N.

    Raises:
        LawError: The force is not three finite numbers.
    """

    force: Annotated[ArrayLike, vector("N")]


(FORCE,) = columns(ConstantForce)


@compiled
def force(laws, i, px, py, pz, vx, vy, vz):  # noqa: ARG001
    """Force of a constant force."""
    return laws[i, FORCE], laws[i, FORCE + 1], laws[i, FORCE + 2]


@compiled
def energy(laws, i, px, py, pz):
    """Energy of a constant force; 0 at the base's centre."""
    return -(laws[i, FORCE] * px + laws[i, FORCE + 1] * py + laws[i, FORCE + 2] * pz)


LAW = Law(ConstantForce, force, energy)
_constant = force_function(LAW, ConstantForce)


def constant_force(p: ArrayLike, constant: ArrayLike) -> np.ndarray:
    """The same force everywhere.

    Args:
        p: (..., 3) position in the base frame, m; only its shape counts.
        constant: (3,) N on the handle.

    Returns:
        (..., 3) N on the handle.

    Raises:
        LawError: The force is not three finite numbers, or p does not end in an axis of 3 or is not finite.
    """
    return _constant(p, AT_REST, force=constant)
