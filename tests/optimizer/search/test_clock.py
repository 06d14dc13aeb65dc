"""The clock of a search, with readings made up."""

from __future__ import annotations

from pathlib import Path

import pytest

from optimizer.search.clock import LEAST, SearchClock, waited_s


def test_time_spent_waiting_for_a_processor_does_not_count() -> None:
    wall, waited = [100.0], [7.0]
    clock = SearchClock(lambda: wall[0], lambda: waited[0])
    assert clock() == 0.0
    wall[0], waited[0] = 160.0, 27.0
    assert clock() == 40.0
    wall[0] = 220.0  # idle again
    assert clock() == 100.0


def test_it_never_stands_still() -> None:
    wall, waited = [0.0], [0.0]
    clock = SearchClock(lambda: wall[0], lambda: waited[0])
    wall[0], waited[0] = 80.0, 79.0
    assert clock() == 80.0 * LEAST


@pytest.mark.parametrize("text", [None, "", "1", "a b c"])
def test_a_system_that_does_not_tell_leaves_the_clock_on_the_wall(tmp_path: Path, text: str | None) -> None:
    file = tmp_path / "schedstat"
    if text is not None:
        file.write_text(text, encoding="ascii")
    assert waited_s(file) == 0.0


def test_an_account_is_read_as_nanoseconds(tmp_path: Path) -> None:
    file = tmp_path / "schedstat"
    file.write_text("3000639988 13919321410 154\n", encoding="ascii")
    assert waited_s(file) == pytest.approx(13.91932141)
