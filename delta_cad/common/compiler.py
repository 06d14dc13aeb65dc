"""numba's compiler with two habits changed, which together were half of its time here.

numba optimizes a function anew within each of its callers, up to the last, and makes machine code at every step, though
only functions that Python calls are ever entered: a proof has three of these and seventy below them. Here what lies
below stays LLVM's intermediate code until a function that Python calls takes it in. And numba goes through all that it
knows of `+` at each `+`; here each operator remembers what it makes of which types.

The code that comes out rounds as before: LLVM keeps each operation's rounding at whatever level it optimizes.
"""

from __future__ import annotations

import math
import operator
from contextlib import suppress
from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.errors import TypingError

OFTEN = (*(getattr(operator, name) for name in operator.__all__), abs, len, math.sqrt)
"""Built-in functions that compiled code calls often."""


class InnerLibrary(JITCodeLibrary):
    """Code of a function that only compiled code calls, as LLVM's intermediate code."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Tidies what is defined here; numba prepares to do so for all that is named."""
        ll_module.data_layout = self._codegen._data_layout
        for function in ll_module.functions:
            if not function.is_declaration:
                passes, builder = self._codegen._function_pass_manager()
                passes.run(function, builder)

    def _optimize_final_module(self) -> None:
        """Leaves that to the function that Python calls."""

    def _finalize_final_module(self) -> None:
        """Makes no machine code."""
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def serialize_using_object_code(self) -> Any:
        """Gives what is kept on disk."""
        return self.serialize_using_bitcode()


class _InnerCodegen:
    """numba's code generator, but for the libraries that it makes."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        """Gives what numba's has."""
        return getattr(self._codegen, name)

    def create_library(self, name: str) -> InnerLibrary:
        """Makes room for one function's code."""
        library: Any = InnerLibrary
        return library(self, name)

    def unserialize_library(self, serialized: Any) -> Any:
        """Reads what was kept on disk."""
        return InnerLibrary._unserialize(self, serialized)

    def set_env(self, name: str, env: Any) -> None:
        """Sets nothing, for there is no machine code that could read it."""


def inner_target(target: Any) -> Any:
    """Makes the target of functions that only compiled code calls.

    Args:
        target: numba's target.
    """
    return target.subtarget(_internal_codegen=_InnerCodegen(target.codegen()))


def _remember(function: Any) -> None:
    """Lets a built-in function remember the signatures that it found, and the types for which it has none."""
    ask, found, refused = function.get_call_type, {}, {}

    def get_call_type(context: Any, args: Any, kws: Any) -> Any:
        if kws:
            return ask(context, args, kws)
        if args in refused:
            raise TypingError(refused[args])
        if args not in found:
            try:
                found[args] = ask(context, args, kws)
            except TypingError as error:
                refused[args] = str(error)
                raise
        return found[args]

    function.get_call_type = get_call_type


class OuterCompiler(Compiler):
    """Compiles functions that Python calls."""

    def __init__(self, typing: Any, *others: Any) -> None:
        super().__init__(typing, *others)
        for each in OFTEN:
            with suppress(ValueError):  # numba knows nothing of it
                function = typing.resolve_value_type(each)  # another object once numba has learnt more of it
                if "get_call_type" not in vars(function):
                    _remember(function)


class InnerCompiler(OuterCompiler):
    """Compiles functions that only compiled code calls."""

    def __init__(self, typing: Any, target: Any, *others: Any) -> None:
        super().__init__(typing, inner_target(target), *others)
