"""Where machine code is kept: it is found again only while no source it came from has changed.

numba keeps a function's machine code by that function's own file, callees and constants of other files melted in. Here
all of it lies in a folder named by a hash of every source that can be melted into any of it, of the compiler and of
Python: after an edit or an update the folder has another name, and nothing that is found is stale.

Importing this module loads numba; `jit` does so when something is compiled.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import re
import shutil
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import llvmlite
import numba
from numba import njit  # noqa: TID251 - the only place
from numba.core import config, types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, InTreeCacheLocator
from numba.extending import typeof_impl

from delta_cad.common.compiler import InnerCompiler, OuterCompiler, inner_target
from delta_cad.common.jit import STARTED_S, Compiled

ROOT = Path(__file__).parents[2]
"""Where the packages lie."""
PACKAGES = ("delta_cad", "optimizer", "haptics")
UNUSED_MAX_S = 7 * 86400.0
"""s; a folder that no process has used for so long goes when a new one is made: an edit of a compiled source leaves
some 6 MB behind, and going back to a version of last month costs half a minute."""
_IMPORT = re.compile(rb"^[ \t]*(?:from ([\w.]+) import (\([^)]*\)|.*)|import ([\w.]+))", re.MULTILINE)
_NO_GLOBALS = re.compile(rb"^(?:(?:async )?def |class |if TYPE_CHECKING:).*\n(?:(?:[ \t)].*)?\n)*", re.MULTILINE)
"""What is imported inside a function or for its types alone is not a global of compiled code."""


@cache
def sources() -> dict[str, bytes]:
    """Finds the sources that compiled code can come from: those that name this room, and all that they import.

    Returns:
        Path from `ROOT` -> content, sorted.
    """
    texts = {}
    for package in PACKAGES:
        for folder, _, names in os.walk(ROOT / package):
            for name in names:
                if name.endswith(".py"):
                    path = os.path.join(folder, name)
                    with open(path, "rb") as file:
                        texts[os.path.relpath(path, ROOT)] = file.read()
    open_ends = [path for path, text in texts.items() if b"delta_cad.common.jit" in text]
    found = {}
    while open_ends:
        path = open_ends.pop()
        if path not in texts or path in found:
            continue
        found[path] = texts[path]
        for module, names, plain in _IMPORT.findall(_NO_GLOBALS.sub(b"", texts[path])):
            base = (module or plain).decode().replace(".", "/")
            open_ends += [f"{base}.py", f"{base}/__init__.py"]
            open_ends += [f"{base}/{name.decode()}.py" for name in re.findall(rb"\w+", names)]
    return dict(sorted(found.items()))


def _as_started() -> bool:
    """Decides whether no source was written since this process began: it may run what stood there before."""
    with suppress(OSError):
        return all(os.stat(ROOT / path).st_ctime < STARTED_S for path in sources())
    return False


def _all_known(function: Any) -> bool:
    """Decides whether the folder's name tells all the code of a function, that of what it calls in turn, too."""
    path = os.path.relpath(function.__code__.co_filename, ROOT)
    return path in sources() and all(_all_known(called.py_func) for called in getattr(function, "calls", ()))


@cache
def folder() -> Path | None:
    """Finds the folder of what is compiled from the sources as they are; it is made when there is something to keep.

    Returns:
        A folder below NUMBA_CACHE_DIR, XDG_CACHE_HOME or HOME/.cache, the first that is set; None if none is.
    """
    asked, users, home = (os.environ.get(name, "") for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"))
    parents = (asked and os.path.abspath(asked), users, home and os.path.join(home, ".cache"))
    parent = next((place for place in parents if os.path.isabs(place)), None)
    if parent is None:
        _not_kept("there is no HOME")
        return None
    digest = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__} {sys.version}".encode())
    for path, text in sources().items():
        digest.update(f"\n{path} {len(text)}\n".encode() + text)
    place = Path(parent, "delta-haptics", digest.hexdigest()[:32])
    with suppress(OSError):  # not there yet, or on a disk that cannot be written
        os.utime(place)  # says that it is in use
    return place


_told: list[str] = []
"""Why nothing is kept, once it was said: one line a process."""


def _not_kept(why: str) -> None:
    if not _told:
        _told.append(why)
        print(
            f"note: compiled code is not kept, so each run compiles anew: {why}; "
            "set NUMBA_CACHE_DIR to a folder that can be written",
            file=sys.stderr,
        )


def _throw_away_old(place: Path) -> None:
    """Removes the folders beside one that nobody has used for long; who still runs from one compiles anew."""
    for other in place.parent.iterdir():
        with suppress(OSError):  # gone meanwhile, or another user's
            if other != place and time.time() - other.stat().st_mtime > UNUSED_MAX_S:
                shutil.rmtree(other)


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
        if not _as_started():
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
        place = folder()
        assert place is not None
        if not _as_started():
            return
        try:
            if not place.exists():
                place.mkdir(parents=True, exist_ok=True)
                _throw_away_old(place)
            os.makedirs(self.cache_path, exist_ok=True)
            with open(place / "lock", "w") as lock:
                with suppress(OSError):  # a file system without locks
                    fcntl.flock(lock, fcntl.LOCK_EX)
                super().save_overload(sig, data)
        except OSError as error:
            _not_kept(f"{place}: {error.strerror}")


class _InnerCache(_Cache):
    _impl_class = _KeptInner


def dispatcher_of(function: Callable[..., Any], inner: bool, **options: Any) -> Any:
    """Makes numba's dispatcher of a function.

    Args:
        function: The function.
        inner: Whether only compiled code calls it: the way in from Python takes a sixth of the compiler's time.
        options: Of numba's compiler.

    Returns:
        The dispatcher, whose code is kept where the packages alone make it; the function where numba is switched off.

    Raises:
        ImportError: Its file does not name the room, so that an edit of it would not change the folder.
    """
    if config.DISABLE_JIT:  # pyright: ignore[reportAttributeAccessIssue]
        return function
    if inner:
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    compiler = InnerCompiler if inner else OuterCompiler
    dispatcher: Any = njit(error_model="numpy", pipeline_class=compiler, **options)(function)
    typed = dispatcher.get_call_template

    def without_literals(args: Any, kws: Any) -> Any:
        """Types a call of `f(3)` as one of `f(k)`: numba would compile f anew for each number that is written out."""
        return typed([types.unliteral(arg) for arg in args], {key: types.unliteral(arg) for key, arg in kws.items()})

    dispatcher.get_call_template = without_literals
    path = os.path.relpath(function.__code__.co_filename, ROOT)
    if path.startswith(PACKAGES) and path not in sources():
        raise ImportError(f"{path} is to import its decorator from delta_cad.common.jit, or its code may grow stale")
    if _all_known(function) and folder() is not None:
        dispatcher._cache = _InnerCache(function) if inner else _Cache(function)
    return dispatcher


@typeof_impl.register(Compiled)
def _type_of(value: Compiled, _context: Any) -> types.Dispatcher:
    """Types a compiled function that compiled code names: as numba's own, without the way in from Python."""
    return types.Dispatcher(value.inner)
