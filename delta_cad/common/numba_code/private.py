"""numba's compiler with two habits changed, which together were half of its time here.

numba optimizes a function anew within each of its callers, up to the last, and makes machine code at every step, though
only functions that Python calls are ever entered: a proof has three of these and seventy below them. Here what lies
below stays LLVM's intermediate code until a function that Python calls takes it in. And numba goes through all that it
knows of `+` at each `+`; here each operator remembers what it makes of which types.

The code that comes out rounds as before: LLVM keeps each operation's rounding at whatever level it optimizes.

These classes are private to numba: only releases of `SERIES` in this package's `__init__` come here.
"""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Callable
from contextlib import suppress
from typing import Any, ClassVar

from numba import njit  # noqa: TID251 - one of two places
from numba.core import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, InTreeCacheLocator
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.errors import TypingError

from delta_cad.common.numba_code.kept import all_known, as_started, folder, not_kept, throw_away_old

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


class _Locator(InTreeCacheLocator):
    """Gives each folder of sources one below `folder`, so that copies of the packages share nothing."""

    def __init__(self, function: Callable[..., Any], file: str) -> None:
        super().__init__(function, file)
        self._cache_path = os.path.join(str(folder()), self.get_suitable_cache_subpath(file))

    def ensure_cache_path(self) -> None:
        """Makes nothing: what was kept once is used from a disk that cannot be written, too."""


class _InnerLocator(_Locator):
    """Keeps functions without a way in from Python apart from those that have one."""

    def __init__(self, function: Callable[..., Any], file: str) -> None:
        super().__init__(function, file)
        self._cache_path = os.path.join(self._cache_path, "inner")


class _Kept(CompileResultCacheImpl):
    _locator_classes: ClassVar = [_Locator]


class _KeptInner(CompileResultCacheImpl):
    _locator_classes: ClassVar = [_InnerLocator]

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        """Reads a function as intermediate code."""
        return super().rebuild(inner_target(target_context), payload)


class _Cache(FunctionCache):
    """numba's cache of one function, which never stops a run: what it cannot read or write is compiled."""

    _impl_class = _Kept

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Reads a function; None, so that it is compiled, whatever is wrong with the file."""
        if not as_started():
            return None
        try:
            return super().load_overload(sig, target_context)
        except OSError:
            return None
        except Exception:  # unpickling a damaged file raises anything
            with suppress(OSError):
                self.flush()  # or keeping the function anew would read the file again
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keeps a function if that can be; the lock, since numba gives two processes at once the same file name."""
        from delta_cad.common.files import lock  # compiled code comes from nothing that it imports

        place = folder()
        assert place is not None
        if not as_started():
            return
        try:
            if not place.exists():
                place.mkdir(parents=True, exist_ok=True)
                throw_away_old(place)
            os.makedirs(self.cache_path, exist_ok=True)
            with open(place / "lock", "w") as file:
                lock(file.fileno(), wait=True)
                super().save_overload(sig, data)
        except OSError as error:
            not_kept(f"{place}: {error.strerror}")


class _InnerCache(_Cache):
    _impl_class = _KeptInner


def private_dispatcher(function: Callable[..., Any], inner: bool, **options: Any) -> Any:
    """Makes numba's dispatcher of a function, as `dispatcher_of`, with the compilers and the cache of this module."""
    if inner:
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    compiler = InnerCompiler if inner else OuterCompiler
    dispatcher: Any = njit(error_model="numpy", pipeline_class=compiler, **options)(function)
    typed = dispatcher.get_call_template

    def without_literals(args: Any, kws: Any) -> Any:
        """Types a call of `f(3)` as one of `f(k)`: numba would compile f anew for each number that is written out."""
        return typed([types.unliteral(arg) for arg in args], {key: types.unliteral(arg) for key, arg in kws.items()})

    dispatcher.get_call_template = without_literals
    if all_known(function) and folder() is not None:
        dispatcher._cache = _InnerCache(function) if inner else _Cache(function)
    return dispatcher
