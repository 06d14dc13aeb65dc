"""A seeded sample of the damaged files that `make endurance` makes many of."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from tests.endurance.disks import TRIALS
from tests.endurance.readers import Reader, fault, readers
from tests.endurance.sockets import MOST, strained

SAMPLE = 25  # files a reader: four seconds for all of them


def test_no_damaged_file_gets_more_than_one_line_out_of_its_reader(tmp_path: Path) -> None:
    faults = {}
    for reader in readers(tmp_path):
        made = {reader.make(Random(f"{reader.name} {number}")) for number in range(SAMPLE)}
        assert len(made) > SAMPLE / 2, reader.name
        for number in range(SAMPLE):
            if (found := fault(reader, number, tmp_path)) is not None:
                faults[reader.name, number] = found
    assert faults == {}


@pytest.mark.slow
@pytest.mark.parametrize("trial", ["places that cannot be written", "no extras"])
def test_what_can_be_tried_in_a_minute_is(trial: str, tmp_path: Path) -> None:
    """That `make endurance` comes to its end, too: the others of its trials build, and are left to it."""
    assert TRIALS[trial](tmp_path) == []


@pytest.mark.slow
def test_a_board_outlives_its_hosts() -> None:
    """Fifteen seconds of a link that slows, tears and repeats, hosts killed at random, old sessions sent again."""
    found, wording = strained(15.0, seed=2)
    assert found == []
    assert wording["hosts killed"] + wording["left before"] >= 3
    assert wording["most ticks of force after a command"] <= MOST
    assert wording["dropped"]["FOREIGN"] > 100


@pytest.mark.parametrize(
    ("error", "wording"),
    [
        (KeyError("a"), "KeyError"),
        (ValueError("two\nlines"), "not one printable line"),
        (ValueError("\x1b[2J"), "not one printable line"),
        (ValueError("x" * 10_000), "10000 characters"),
        (ValueError(""), "not one printable line"),
        (ValueError("fine"), ""),
    ],
    ids=str,
)
def test_a_fault_is_found(error: Exception, wording: str, tmp_path: Path) -> None:
    def read(_: Path) -> None:
        raise error

    found = fault(Reader("a", "a.json", lambda _: b"", read, (ValueError,)), 0, tmp_path)
    assert (found is None) == (wording == "")
    assert wording in (found or "")
