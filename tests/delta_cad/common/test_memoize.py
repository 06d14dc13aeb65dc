"""What is found once is found again: with the object, by content, or by what was read of a record; and never stale."""

import gc
import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

from delta_cad.common import memoize as module
from delta_cad.common.memoize import Store, Traced, cached, cached_by_reads, digest, memoize
from delta_cad.common.options import CACHE_OFF


class Thing:
    """Equal to all of its kind, as shapes of the CAD kernel are."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Thing)

    def __hash__(self) -> int:
        return 1


def test_each_object_is_required_once_by_identity_and_forgotten_with_it() -> None:
    required: list[int] = []

    @memoize
    def find(of: Thing) -> int:
        required.append(id(of))
        return len(required)

    one, other = Thing(), Thing()
    assert [find(one), find(other), find(one), find(other)] == [1, 2, 1, 2]
    del one
    gc.collect()
    for count in range(20):  # one of these takes the place of the first in memory
        assert find(Thing()) == 3 + count


@dataclass(frozen=True)
class Wheel:
    radius: float
    spokes: int = 8


@dataclass(frozen=True)
class Cart:
    """A record with all that dimensions have: records, tuples of them, properties, methods, what may be missing."""

    length: float
    wheel: Wheel
    extra: Wheel | None = None
    wheels: tuple[Wheel, ...] = ()
    axes: np.ndarray = field(default_factory=lambda: np.eye(2))

    @property
    def double(self) -> float:
        return 2.0 * self.length

    def farther(self, by: float) -> float:
        return self.length + by


@pytest.fixture(autouse=True)
def empty(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """Nothing in memory, and a folder of its own on disk."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv(CACHE_OFF, raising=False)
    _forget()
    yield tmp_path / module.FOLDER
    _forget()


def _forget() -> None:
    module._recent.clear()
    module._traces.clear()


def _entries(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.is_file()]


def test_the_digest_tells_all_content_apart_and_nothing_else() -> None:
    alike = [(Cart(1.0, Wheel(2.0)), 0.1 + 0.2), (Cart(1.0, Wheel(2.0)), 0.30000000000000004)]
    assert digest(alike[0]) == digest(alike[1])
    cart = Cart(1.0, Wheel(2.0), None, (Wheel(1.0),), np.arange(4.0))
    others = [
        (1, 2), (12,), ("1", "2"), (1.0, 2), ((1, 2),), (None,), (True,), (b"1",),
        ({"a": 1},), ({"a": 2},), ({"b": 1},),
        (np.zeros(4),), (np.zeros((2, 2)),), (np.zeros(4, dtype=np.float32),), (0.1 + 0.2,), (0.3,),
        *((replace(cart, **change),) for change in (
            {}, {"length": np.nextafter(1.0, 2.0)}, {"wheel": Wheel(2.0, 9)}, {"extra": Wheel(2.0)}, {"wheels": ()},
            {"axes": np.arange(4.0)[::-1]},
        )),
    ]  # fmt: skip
    assert len({digest(*one) for one in others}) == len(others)
    with pytest.raises(TypeError, match="Thing has no digest"):
        digest(Thing())


def test_a_result_is_computed_once_for_all_processes_and_none_of_another_content(empty: Path) -> None:
    made: list[float] = []

    def compute(value: float) -> list[float]:
        made.append(value)
        return [value]

    def of(value: float) -> list[float]:
        return cached("square", (value,), lambda: compute(value))

    assert [of(1.0), of(2.0), of(1.0)] == [[1.0], [2.0], [1.0]]
    assert made == [1.0, 2.0]
    _forget()  # as another process
    assert of(2.0) == [2.0]
    assert made == [1.0, 2.0]
    assert cached("cube", (2.0,), lambda: compute(8.0)) == [8.0]  # another kind
    assert len(_entries(empty)) == 3


def test_nothing_is_found_again_after_an_edit_or_another_release(
    monkeypatch: pytest.MonkeyPatch, empty: Path, tmp_path: Path
) -> None:
    package = tmp_path / "package"
    package.mkdir()
    source = package / "code.py"
    source.write_text("one = 1\n")
    (package / "rows.csv").write_text("a\n")
    monkeypatch.setattr(module, "PACKAGE", package)
    monkeypatch.setattr(module, "STARTED_S", float("inf"))
    made: list[int] = []

    def compute() -> int:
        made.append(1)
        return len(made)

    def found() -> int:
        module._state.cache_clear()
        module._sources.cache_clear()
        _forget()
        return cached("thing", (), compute)

    assert [found(), found()] == [1, 1]
    source.write_text("one = 2\n")
    assert [found(), found()] == [2, 2]
    (package / "rows.csv").write_text("b\n")
    assert found() == 3
    monkeypatch.setattr(module, "installed", lambda: {"numpy": "0"})
    assert found() == 4
    source.write_text("one = 1\n")
    monkeypatch.setattr(module, "STARTED_S", 0.0)  # the source is newer than what this process runs
    before = len(_entries(empty))
    assert [found(), found()] == [5, 6]
    assert len(_entries(empty)) == before
    monkeypatch.undo()
    module._state.cache_clear()
    module._sources.cache_clear()


def test_a_damaged_entry_is_computed_anew(empty: Path) -> None:
    made: list[int] = []

    def compute() -> list[int]:
        made.append(1)
        return [len(made)]

    assert cached("thing", (), compute) == [1]
    (entry,) = _entries(empty)
    whole = entry.read_bytes()
    for damaged in (b"", whole[:40], whole[:-1], whole[:-1] + bytes([whole[-1] ^ 1]), b"x" * len(whole)):
        entry.write_bytes(damaged)
        _forget()
        assert cached("thing", (), compute) == [len(made)]
        assert entry.read_bytes() != damaged  # whole again
    assert len(made) == 6


def test_a_folder_that_cannot_be_written_keeps_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert cached("thing", (), lambda: 7) == 7
    _forget()
    assert cached("thing", (), lambda: 8) == 8


def test_off_keeps_nothing_and_reads_nothing(monkeypatch: pytest.MonkeyPatch, empty: Path) -> None:
    assert cached("thing", (), lambda: 1) == 1
    monkeypatch.setenv(CACHE_OFF, "1")
    _forget()
    assert cached("thing", (), lambda: 2) == 2
    assert cached_by_reads(lambda cart: cart.length, Cart(1.0, Wheel(1.0))) == 1.0
    assert len(_entries(empty)) == 1


def test_the_folder_is_bounded_and_what_was_used_last_stays(tmp_path: Path) -> None:
    store = Store(tmp_path / "kept", most_bytes=100_000)
    body = pickle.dumps(b"x" * 5_000)
    for n in range(40):
        store.write(f"{n:064d}", body)
        os.utime(store._path(f"{n:064d}"), (n, n))
        if n == 10:
            assert store.read(f"{3:064d}") is not None  # used, and so newer than all others
    store.shrink()
    left = {path.name for path in _entries(tmp_path)}
    assert sum(path.stat().st_size for path in _entries(tmp_path)) <= 100_000
    assert {f"{n:062d}" for n in (3, 39, 38)} <= left
    assert f"{5:062d}" not in left


def test_processes_that_write_at_once_leave_whole_entries(empty: Path) -> None:
    code = (
        "from delta_cad.common.memoize import cached\n"
        "for n in range(30):\n    assert cached('many', (n,), lambda: [n] * 20000) == [n] * 20000\n"
    )
    running = [subprocess.Popen([sys.executable, "-c", code]) for _ in range(3)]
    assert [one.wait() for one in running] == [0, 0, 0]
    entries = _entries(empty)
    assert len(entries) == 30  # no part is left beside them
    store = Store(empty)
    assert all(store.read(path.parent.name + path.name) is not None for path in entries)


CART = Cart(1.0, Wheel(2.0), None, (Wheel(3.0), Wheel(4.0)))
MADE = {  # function of a cart -> changes that it sees, changes that it does not
    "field": (lambda c: c.length, [{"length": 2.0}], [{"wheel": Wheel(5.0)}, {"extra": Wheel(1.0)}]),
    "inner": (lambda c: c.wheel.radius, [{"wheel": Wheel(3.0)}], [{"wheel": Wheel(2.0, 9)}, {"length": 2.0}]),
    "missing": (lambda c: c.extra is None, [{"extra": Wheel(1.0)}], [{"length": 2.0}]),
    "property": (lambda c: c.double, [{"length": 2.0}], [{"wheel": Wheel(5.0)}]),
    "method": (lambda c: c.farther(1.0), [{"length": 2.0}], [{"wheel": Wheel(5.0)}]),
    "array": (lambda c: float(c.axes.sum()), [{"axes": np.ones((2, 2))}], [{"length": 2.0}]),
    "tuple": (
        lambda c: [w.radius for w in c.wheels],
        [{"wheels": (Wheel(3.0),)}],
        [{"wheels": (Wheel(3.0, 9), Wheel(4.0))}],
    ),
    "whole": (lambda c: pickle.loads(pickle.dumps(c.wheel)).radius, [{"wheel": Wheel(2.0, 9)}], [{"length": 2.0}]),
    "equal": (lambda c: c.wheel == Wheel(2.0), [{"wheel": Wheel(2.0, 9)}], [{"length": 2.0}]),
    "branch": (
        lambda c: c.length if c.wheel.radius > 1.0 else c.wheel.spokes,
        [{"length": 2.0}, {"wheel": Wheel(1.0)}],
        [{"wheel": Wheel(2.0, 9)}],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MADE)
def test_what_is_made_of_a_record_is_made_anew_where_it_read_what_differs_and_not_else(name: str) -> None:
    make, seen, unseen = MADE[name]
    count: list[int] = []

    def counted(cart: Cart) -> object:
        count.append(1)
        return make(cart)

    assert cached_by_reads(counted, CART) == make(CART)
    for change in unseen:
        assert cached_by_reads(counted, replace(CART, **change)) == make(CART)
    assert len(count) == 1
    for n, change in enumerate(seen, 2):
        other = replace(CART, **change)
        assert cached_by_reads(counted, other) == make(other)
        assert len(count) == n
    _forget()  # as another process
    for change in ({}, *unseen, *seen):
        other = replace(CART, **change)
        assert cached_by_reads(counted, other) == make(other)
    assert len(count) == 1 + len(seen)


def test_a_traced_record_passes_for_the_record() -> None:
    traced = Traced(CART, {})
    assert isinstance(traced, Cart)
    assert isinstance(traced.wheel, Wheel)
    assert traced.wheel == Wheel(2.0)
    assert hash(traced.wheel) == hash(Wheel(2.0))
    with pytest.raises(AttributeError):
        _ = traced.height
