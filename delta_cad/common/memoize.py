"""Memoizes results: of an object by its identity, of content by its digest, of a record by what was read of it.

The latter two are kept on disk, and found again only while nothing differs that they were made by: the key holds every
source and table of `delta_cad`, Python's version and that of each installed package. An entry is written beside its
place and renamed, so that processes may share the folder; one that is damaged, or that cannot be read, is computed
anew. Of the folder `MOST_BYTES` stay, those that were used last.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import secrets
import sys
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from functools import cache, wraps
from pathlib import Path
from typing import Any, TypeVar
from weakref import ref

import numpy as np

from delta_cad.common.jit import STARTED_S
from delta_cad.common.options import CACHE_OFF
from delta_cad.common.versions import installed

T = TypeVar("T")
PACKAGE = Path(__file__).parents[1]
FOLDER = "delta-haptics-results"
MOST_BYTES, _LEFT = 512 * 1024**2, 0.7  # of the folder, and the share that stays when it is full
_RECENT = 512  # results that this process keeps in memory as well
_SUM = hashlib.sha256().digest_size


def memoize(find: Callable[[Any], T]) -> Callable[[Any], T]:
    """Makes a function of one object that nobody changes, such as a solid, remember what it found.

    Objects are told apart by identity: the kernel's own equality does not see which way out a shape is turned. The
    result is shared, so nobody may change it either, and must not hold the object.
    """
    known: dict[int, tuple[ref[Any], T]] = {}

    @wraps(find)
    def found(of: Any) -> T:
        key = id(of)
        if key not in known:  # one that died took its entry along, before its identity could be another's
            known[key] = (ref(of, lambda _: known.pop(key, None)), find(of))
        return known[key][1]

    return found


def digest(*values: object) -> str:
    """Computes the SHA-256 of content: numbers to the last bit, text, arrays, and records of them.

    Raises:
        TypeError: A value is nothing of these.
    """
    whole = hashlib.sha256()
    for piece in _pieces(values):
        whole.update(len(piece).to_bytes(8) + piece)
    return whole.hexdigest()


def _pieces(value: object) -> Iterator[bytes]:
    if isinstance(value, Traced):
        value = value.__of__()
    if value is None or isinstance(value, bool | int | float | str | bytes):
        yield type(value).__name__.encode() + b" " + (value if isinstance(value, bytes) else repr(value).encode())
    elif isinstance(value, np.ndarray | np.generic) and value.dtype.hasobject is False:
        yield f"{value.dtype.str} {value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif isinstance(value, Mapping):
        yield from _pieces([type(value).__name__, *((key, value[key]) for key in sorted(value, key=repr))])
    elif isinstance(value, tuple | list | frozenset | set | range):
        inner = sorted(value, key=repr) if isinstance(value, frozenset | set) else value
        yield f"{type(value).__name__} {len(value)}".encode()
        for one in inner:
            yield from _pieces(one)
    elif isinstance(value, Path):
        yield from _pieces(str(value))
    elif (names := _fields_of(value)) is not None:
        yield from _pieces([type(value).__qualname__, *((name, getattr(value, name)) for name in names)])
    else:
        raise TypeError(f"{type(value).__name__} has no digest")


def _fields_of(value: object) -> Iterable[str] | None:
    """Names of the fields of a record, a dataclass or a model; None where it is none."""
    if is_dataclass(value) and not isinstance(value, type):
        return [one.name for one in fields(value)]
    return getattr(type(value), "model_fields", None)


@cache
def _state() -> str | None:
    """Digest of all that results are made by; None where a source was written since this process began."""
    if not _as_started():
        return None
    contents = [(path.relative_to(PACKAGE).as_posix(), path.read_bytes()) for path in _sources()]
    return digest(sys.version, sorted(installed().items()), contents)


@cache
def _sources() -> tuple[Path, ...]:
    made = {"__pycache__"}
    found = []
    for folder, inner, names in os.walk(PACKAGE):
        inner[:] = sorted(set(inner) - made)
        found += [Path(folder, name) for name in sorted(names) if name.endswith((".py", ".csv", ".toml"))]
    return tuple(found)


def _as_started() -> bool:
    """Whether no source was written since this process began: it may run what stood there before."""
    with suppress(OSError):
        return all(path.stat().st_ctime < STARTED_S for path in _sources())
    return False


class Store:
    """Entries of a folder by their digests.

    Args:
        folder: The folder; it is made with the first entry.
        most_bytes: What it holds at most.
    """

    def __init__(self, folder: Path, most_bytes: int = MOST_BYTES) -> None:
        self.folder, self.most_bytes = folder, most_bytes
        self._unseen = most_bytes  # bytes that were written since the folder was looked at
        self._looked_s = time.monotonic()

    def _path(self, key: str) -> Path:
        return self.folder / key[:2] / key[2:]

    def read(self, key: str) -> Any:
        """Gives what an entry holds, in a tuple; None where there is none, or a damaged one, which is removed."""
        path = self._path(key)
        try:
            content = path.read_bytes()
            os.utime(path)
        except OSError:
            return None
        body = memoryview(content)[_SUM:]
        if hashlib.sha256(body).digest() == content[:_SUM]:
            with suppress(Exception):  # whatever a class of another release makes of it
                return (pickle.loads(body),)
        with suppress(OSError):
            path.unlink()
        return None

    def write(self, key: str, body: bytes) -> None:
        """Keeps an entry; where the disk does not take it, nothing is kept."""
        if time.monotonic() > self._looked_s + 1.0:
            self._looked_s = time.monotonic()
            if not _as_started():  # code that is loaded from now on is not what the keys stand for
                return
        path = self._path(key)
        part = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            part.write_bytes(hashlib.sha256(body).digest() + body)
            part.replace(path)
        except OSError:
            with suppress(OSError):
                part.unlink()
            return
        self._unseen += len(body)
        if self._unseen > self.most_bytes * (1.0 - _LEFT) / 2.0:
            self._unseen = 0
            self.shrink()

    def shrink(self) -> None:
        """Removes what was used longest ago where the folder holds too much."""
        found = list[tuple[float, int, str]]()
        for folder, _, names in os.walk(self.folder):
            for name in names:
                with suppress(OSError):  # gone meanwhile
                    kept = os.stat(path := os.path.join(folder, name))
                    found.append((kept.st_mtime, kept.st_size, path))
        total = sum(size for _, size, _ in found)
        if total <= self.most_bytes:
            return
        for _, size, path in sorted(found):
            with suppress(OSError):
                os.unlink(path)
            total -= size
            if total <= _LEFT * self.most_bytes:
                return


def _store() -> Store | None:
    """The folder below XDG_CACHE_HOME or HOME/.cache; None where neither is set, or results are not to be kept."""
    if os.environ.get(CACHE_OFF) or _state() is None:
        return None
    users, home = os.environ.get("XDG_CACHE_HOME", ""), os.environ.get("HOME", "")
    parent = users or (home and os.path.join(home, ".cache"))
    return _store_in(os.path.join(parent, FOLDER)) if os.path.isabs(parent) else None


@cache
def _store_in(folder: str) -> Store:
    return Store(Path(folder))


_recent: OrderedDict[str, Any] = OrderedDict()


def cached(kind: str, of: object, compute: Callable[[], T]) -> T:
    """Gives a result by content: from memory or disk where it is there, else computed.

    Computed or found, it is what pickling leaves of it, the same to the last bit. It is shared: nobody may change it.

    Args:
        kind: What is computed.
        of: All that it is computed from, as `digest` takes it.
        compute: The computation.
    """
    if (store := _store()) is None:
        return pickle.loads(pickle.dumps(compute()))
    key = digest(_state(), kind, of)
    if (found := _known(store, key)) is None:
        found = (_kept(store, key, compute()),)
    return found[0]


def _known(store: Store, key: str) -> tuple[Any] | None:
    """A result that is in memory or on disk, in a tuple."""
    if key in _recent:
        _recent.move_to_end(key)
        return (_recent[key],)
    if (found := store.read(key)) is not None:
        _remember(key, found[0])
    return found


def _kept(store: Store, key: str, result: object) -> Any:
    body = pickle.dumps(result)
    store.write(key, body)
    _remember(key, found := pickle.loads(body))
    return found


def _remember(key: str, result: object) -> None:
    _recent[key] = result
    while len(_recent) > _RECENT:
        _recent.popitem(last=False)


_Path = tuple[object, ...]
"""Steps from a record to a value: a field's name, a number of a tuple, a method's arguments, `len` or `_kind`."""


class Traced:
    """A record that notes what is read of it, and of the records in it: all that a function of it depends on.

    It passes for the record. Who reads it other than by fields, items and methods depends on the whole of it.
    """

    __slots__ = ("__weakref__", "_of", "_path", "_reads")

    def __init__(self, of: object, reads: dict[_Path, str], path: _Path = ()) -> None:
        self._of, self._reads, self._path = of, reads, path

    def __of__(self) -> Any:
        """Gives the record itself, on whose whole content the result then depends."""
        self._reads[self._path] = digest(self._of)
        return self._of

    @property
    def __class__(self) -> Any:  # pyright: ignore[reportIncompatibleMethodOverride]
        return type(self._of)

    def __getattr__(self, name: str) -> Any:
        return self._noted(name, getattr(self._of, name))

    def _noted(self, step: object, value: Any) -> Any:
        path = (*self._path, step)
        if callable(value):
            if getattr(value, "__self__", None) is not self._of:
                return value

            def call(*arguments: Any) -> Any:
                given = tuple(one.__of__() if isinstance(one, Traced) else one for one in arguments)
                return Traced(self._of, self._reads, path)._noted(given, value(*given))

            return call
        if _fields_of(value) is not None:
            self._reads[(*path, _kind)] = digest(_kind(value))
            return Traced(value, self._reads, path)
        if isinstance(value, tuple) and any(_fields_of(one) is not None for one in value):
            self._reads[(*path, len)] = digest(len(value))
            return tuple(Traced(self._of, self._reads, path)._noted(k, one) for k, one in enumerate(value))
        self._reads[path] = digest(value)
        return value

    def __eq__(self, other: object) -> bool:
        return bool(self.__of__() == (other.__of__() if isinstance(other, Traced) else other))

    def __hash__(self) -> int:
        return hash(self.__of__())

    def __reduce_ex__(self, protocol: Any) -> Any:
        return self.__of__().__reduce_ex__(protocol)


def _kind(of: object) -> str:
    return type(of).__qualname__


def _worded(paths: Iterable[_Path]) -> str:
    return repr([[step.__name__ if callable(step) else step for step in path] for path in paths])


def _read(of: Any, path: _Path) -> Any:
    """The value that a path leads to."""
    for step in path:
        if callable(step):
            of = step(of)
        elif isinstance(step, tuple):
            of = of(*step)
        else:
            of = getattr(of, step) if isinstance(step, str) else of[step]
    return of


def cached_by_reads(make: Callable[..., T], of: Any, *others: object) -> T:
    """Gives what a function makes of a record; made before of another one, of which it read the same, it is that.

    Args:
        make: A function of these alone: what it reads next follows from what it has read.
        of: The record, a dataclass.
        others: More arguments, as `digest` takes them.
    """
    if (store := _store()) is None:
        return pickle.loads(pickle.dumps(make(of, *others)))
    name = f"{make.__module__}.{make.__qualname__}{others}"
    if not (traces := _traces.setdefault(name, [])) and (known := store.read(digest(_state(), "reads", name))):
        traces += known[0]
    for paths in traces:
        try:
            seen = [digest(_read(of, path)) for path in paths]
        except (AttributeError, IndexError, TypeError):  # of a machine that has no such part
            continue
        if (found := _known(store, digest(_state(), name, _worded(paths), seen))) is not None:
            return found[0]
    reads: dict[_Path, str] = {}
    result = make(Traced(of, reads), *others)
    if (paths := tuple(reads)) not in traces:
        traces.append(paths)
        store.write(digest(_state(), "reads", name), pickle.dumps(traces))
    return _kept(store, digest(_state(), name, _worded(paths), list(reads.values())), result)


_traces: dict[str, list[tuple[_Path, ...]]] = {}
"""Function -> what it was seen to read, in turn, of one record or another."""
