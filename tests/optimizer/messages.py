"""What tests check of a message: its field and value, options and numbers, not its English."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

FACT = re.compile(r"--[a-z-]+|[A-Za-z]\w*(?:[._]\w+)+(?:\[\d+\])*|-?\d+(?:,\d{3})*(?:\.\d+)?(?:e[+-]?\d+)?")
"""An option, a dotted or underscored name, or a number."""


def holds(text: str, wanted: str) -> bool:
    """Tells whether a text has all names and numbers of another, and what stands before its first colon.

    Raises:
        AssertionError: There is neither in the other: any text would do.
    """
    head, colon, _ = wanted.partition(": ")
    facts, numbers = FACT.findall(wanted), set(FACT.findall(text))
    assert colon or facts, f"{wanted!r} has no name, number or colon, so that every text holds it"
    return (not colon or head in text) and all(
        fact in numbers or (fact[0].isalpha() and fact in text) for fact in facts
    )


@contextmanager
def refuses(kind: type[Exception], *wanted: str) -> Iterator[pytest.ExceptionInfo[Exception]]:
    """Checks that an error of a kind is raised whose message holds these names and numbers."""
    with pytest.raises(kind) as caught:
        yield caught
    assert all(holds(str(caught.value), one) for one in wanted), str(caught.value)
