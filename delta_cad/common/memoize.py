"""Memoizes a function of one object, by its identity, for as long as the object lives."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar
from weakref import ref

T = TypeVar("T")


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
