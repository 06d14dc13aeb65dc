"""How `jit` compiles: by numba, with its private classes where they are known, else by its public interface."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numba
from numba import njit  # noqa: TID251 - one of two places
from numba.core import config, types
from numba.extending import typeof_impl

from delta_cad.common.jit import Compiled
from delta_cad.common.numba_code.kept import PACKAGES, ROOT, all_known, as_started, folder, sources

SERIES = "0.68."
"""Releases of numba whose private classes are known; `private.py` compiles twice as fast with them."""


def dispatcher_of(function: Callable[..., Any], inner: bool, **options: Any) -> Any:
    """Makes numba's dispatcher of a function.

    Args:
        function: The function.
        inner: Whether only compiled code calls it: the way in from Python takes a sixth of the compiler's time.
        options: Of numba's compiler.

    Returns:
        The dispatcher, whose code is kept where the packages alone make it; the function where numba is switched off.

    Raises:
        ImportError: Its file does not name `jit`, so that an edit of it would not change the folder.
    """
    if config.DISABLE_JIT:  # pyright: ignore[reportAttributeAccessIssue]
        return function
    path = os.path.relpath(function.__code__.co_filename, ROOT)
    if path.startswith(PACKAGES) and path not in sources():
        raise ImportError(f"{path} is to import its decorator from delta_cad.common.jit, or its code may grow stale")
    if numba.__version__.startswith(SERIES):
        from delta_cad.common.numba_code.private import private_dispatcher

        return private_dispatcher(function, inner, **options)
    return public_dispatcher(function, **options)


def public_dispatcher(function: Callable[..., Any], **options: Any) -> Any:
    """Makes numba's dispatcher of a function by documented options alone; the folder of its cache is ours."""
    place = folder()
    keep = place is not None and as_started() and all_known(function)
    if keep:
        config.CACHE_DIR = str(place)  # pyright: ignore[reportAttributeAccessIssue]
    documented = {name: value for name, value in options.items() if not name.startswith("_")}
    return njit(error_model="numpy", cache=keep, **documented)(function)


@typeof_impl.register(Compiled)
def _type_of(value: Compiled, _context: Any) -> types.Dispatcher:
    """Types a compiled function that compiled code names: as numba's own, without the way in from Python."""
    return types.Dispatcher(value.inner)
