"""A law as a function of many states at once: arrays are checked, broadcast, and handed to a compiled loop."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.jit import unrolled_dispatch
from haptics.rendering.law import ForceLaw, Law, LawError

AT_REST = (0.0, 0.0, 0.0)  # No velocity, m/s
_CALLED = """

Called with states, and the attributes by name:

Args:
    p: (..., 3) position in the base frame, m.
    v: (..., 3) velocity, m/s; p and v are broadcast.
    **parameters: Attributes of the law.

Returns:
    (..., 3) N on the handle in the base frame, before saturation.

Raises:
    LawError: A parameter is out of its bounds, or p or v does not end in an axis of 3 or is not finite.
"""


def force_function(law: Law, parameters: Callable[..., ForceLaw]) -> Callable[..., np.ndarray]:
    """The force of a law over states and parameters, documented by the law's own text.

    Args:
        law: The law.
        parameters: The dataclass of its parameters.
    """

    def force(p: ArrayLike, v: ArrayLike = AT_REST, **given: Any) -> np.ndarray:
        row = np.concatenate([[0.0, 1.0], parameters(**given).values()])
        return forces(_over_states(law.force), row[None], p, v)

    force.__doc__ = inspect.cleandoc(parameters.__doc__ or "") + _CALLED
    return force


def forces(loop: Callable[..., None], table: np.ndarray, p: ArrayLike, v: ArrayLike) -> np.ndarray:
    """Runs a compiled loop that fills forces, (..., 3), over states that are checked and broadcast."""
    at, moving = np.broadcast_arrays(vectors("p", p), vectors("v", v))
    out = np.empty(at.shape)
    loop(table, flat(at), flat(moving), out.reshape(-1, 3))
    return out


def vectors(field: str, value: ArrayLike) -> np.ndarray:
    """An array (..., 3) of finite doubles.

    Raises:
        LawError: It does not end in an axis of 3 or is not finite.
    """
    array = np.asarray(value, dtype=float)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise LawError(f"{field} has the shape {array.shape}; its last axis must be 3")
    if not np.isfinite(array).all():
        raise LawError(f"{field} holds {array[~np.isfinite(array)][0]!r}; it must be finite")
    return array


def flat(array: np.ndarray) -> np.ndarray:
    """The vectors one after the other, (n, 3); a copy, because broadcast arrays are another type to compiled code."""
    return np.array(array, order="C").reshape(-1, 3)


@cache
def _over_states(force: Any) -> Any:
    one = "out[j, 0], out[j, 1], out[j, 2] = {0}(table, 0, p[j, 0], p[j, 1], p[j, 2], v[j, 0], v[j, 1], v[j, 2])"
    return unrolled_dispatch("table, p, v, out", [(force,)], f"for j in range(p.shape[0]): {one}")
