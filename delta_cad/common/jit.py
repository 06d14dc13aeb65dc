"""The one room that compiles functions; numba is loaded when the first of them is called.

No fast-math and no fused operations, so that each rounding is the IEEE one; a division by zero gives infinity or NaN.
What is compiled is kept on disk, see `numba_code`.
"""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable, Sequence
from functools import update_wrapper
from types import CodeType, FunctionType
from typing import Any

STARTED_S = time.time()
"""When this process began to import what it compiles: a source that is written later may not be what it runs."""


class Compiled:
    """A function that is compiled at its first call with arguments of a type; compiled code may call it, too.

    Args:
        function: The function.
        options: Of numba's compiler.
    """

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        self.py_func, self.options = function, options
        update_wrapper(self, function)

    def __getattr__(self, name: str) -> Any:
        """Gives what numba's dispatcher has; `dispatcher`, and `inner` for compiled callers, are made when needed."""
        if name in ("dispatcher", "inner"):
            from delta_cad.common.numba_code import dispatcher_of

            made = dispatcher_of(self.py_func, name == "inner", **self.options)
            return self.__dict__.setdefault(name, made)  # of two threads at once both make one and share the first
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.dispatcher, name)

    def __call__(self, *arguments: Any) -> Any:
        """Calls the machine code."""
        return self.dispatcher(*arguments)


def compiled(function: Callable[..., Any]) -> Any:
    """Compiles a function at its first call with arguments of a type, and keeps the code."""
    return Compiled(function)


def free(function: Callable[..., Any]) -> Any:
    """As `compiled`; other threads run while it does: for what takes a tenth of a second and owns its data."""
    return Compiled(function, nogil=True)


def inlined(function: Callable[..., Any]) -> Any:
    """As `compiled`; the machine code of the function is put into that of its callers, where it costs no call.

    It makes no array and returns none, so that nothing counts who holds the arrays it is given: an atomic operation at
    each row that is passed on was a sixth of the simulation's time.
    """
    return Compiled(function, forceinline=True, _nrt=False)


def unrolled_dispatch(
    arguments: str, calls: Sequence[tuple[Any, ...]], line: str, last: str = "return", **others: Any
) -> Any:
    """Compiles a function that makes one call after the other: how compiled code goes through a registry.

    A loop over functions is no compiled code; so the function is written here, a line a call, as if by hand. Its text
    is kept as its attribute `source`, for whoever translates it.

    Args:
        arguments: Names of the function's arguments, such as "pose, out".
        calls: For each call the compiled function and numbers.
        line: Template of a line: {0} is the function, {1} and on are the numbers.
        last: The function's last line.
        others: Compiled functions that lines call by name.

    Returns:
        The compiled function.
    """
    functions = {f"call_{n}": one[0] for n, one in enumerate(calls)} | others
    lines = [line.format(f"call_{n}", *one[1:]) for n, one in enumerate(calls)]
    caller = sys._getframe(1).f_globals
    body = "\n    ".join([*lines, last])
    code = f"def turn({arguments}):\n    {body}\n"
    scope = dict(functions, __name__=caller["__name__"])
    exec(compile(code, caller["__file__"], "exec"), scope)
    function = scope["turn"]
    called = [f"{f.py_func.__module__}.{f.py_func.__qualname__}" for f in functions.values()]
    digest = hashlib.sha256(repr((code, called)).encode())
    function.source = code  # pyright: ignore[reportFunctionMemberAccess]
    function.calls = tuple(functions.values())  # pyright: ignore[reportFunctionMemberAccess]
    function.__qualname__ = f"turn_{digest.hexdigest()[:12]}"
    return Compiled(function)


def renamed(function: Compiled, other: Callable[[str, Any], Any], suffix: str) -> Compiled:
    """Makes a second function of the same text, in which global names stand for something else.

    Args:
        function: The function.
        other: (name, value) -> value: what each global name that the function uses is to stand for.
        suffix: Sets the name of the second apart.
    """
    first = function.py_func
    scope = first.__globals__
    own = {name: other(name, scope[name]) for name in _names(first.__code__) if name in scope}
    own |= {name: scope[name] for name in ("__builtins__", "__name__", "__file__") if name in scope}
    second = FunctionType(first.__code__, own, first.__name__, first.__defaults__, first.__closure__)
    second.__qualname__, second.__module__ = f"{first.__qualname__}_{suffix}", first.__module__
    if hasattr(first, "calls"):
        second.calls = tuple(other("", one) for one in first.calls)  # pyright: ignore[reportFunctionMemberAccess]
    return Compiled(second, **function.options)


def _names(code: CodeType) -> set[str]:
    """Finds the names that code, and what is defined in it, uses."""
    inner = (one for one in code.co_consts if isinstance(one, CodeType))
    return set(code.co_names).union(*map(_names, inner))
