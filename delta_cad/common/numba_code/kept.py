"""Where machine code is kept: it is found again only while no source it came from has changed.

numba keeps a function's machine code by that function's own file, callees and constants of other files melted in. Here
all of it lies in a folder named by a hash of every source that can be melted into any of it, of the compiler and of
Python: after an edit or an update the folder has another name, and nothing that is found is stale.

Importing this package loads numba; `jit` does so when something is compiled.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import sys
import time
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba

from delta_cad.common.jit import STARTED_S

ROOT = Path(__file__).parents[3]
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


def as_started() -> bool:
    """Decides whether no source was written since this process began: it may run what stood there before."""
    with suppress(OSError):
        return all(os.stat(ROOT / path).st_ctime < STARTED_S for path in sources())
    return False


def all_known(function: Any) -> bool:
    """Decides whether the folder's name tells all the code of a function, that of what it calls in turn, too."""
    path = os.path.relpath(function.__code__.co_filename, ROOT)
    return path in sources() and all(all_known(called.py_func) for called in getattr(function, "calls", ()))


@cache
def folder() -> Path | None:
    """Finds the folder of what is compiled from the sources as they are; it is made when there is something to keep.

    Returns:
        A folder below NUMBA_CACHE_DIR, XDG_CACHE_HOME or HOME/.cache, the first that is set; None if none is.
    """
    required, users, home = (os.environ.get(name, "") for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"))
    parents = (required and os.path.abspath(required), users, home and os.path.join(home, ".cache"))
    parent = next((place for place in parents if os.path.isabs(place)), None)
    if parent is None:
        not_kept("there is no HOME")
        return None
    digest = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__} {sys.version}".encode())
    for path, text in sources().items():
        digest.update(f"\n{path} {len(text)}\n".encode() + text)
    place = Path(parent, "delta-haptics", digest.hexdigest()[:32])
    with suppress(OSError):  # not there yet, or on a disk that cannot be written
        os.utime(place)  # says that it is in use
    return place


_reported: list[str] = []
"""Why nothing is kept, once it was said: one line a process."""


def not_kept(why: str) -> None:
    """Says on stderr why nothing is kept, once a process."""
    if not _reported:
        _reported.append(why)
        print(
            f"note: compiled code is not kept, so each run compiles anew: {why}; "
            "set NUMBA_CACHE_DIR to a folder that can be written",
            file=sys.stderr,
        )


def throw_away_old(place: Path) -> None:
    """Removes the folders beside one that nobody has used for long; who still runs from one compiles anew."""
    for other in place.parent.iterdir():
        with suppress(OSError):  # gone meanwhile, or another user's
            if other != place and time.time() - other.stat().st_mtime > UNUSED_MAX_S:
                shutil.rmtree(other)
