"""`python -m tests.endurance [MINUTES]`: damaged files through every reader, kills, full disks; prints what was found.

Two hands work at once: one reads damaged files, 100,000 of them, or as many as the minutes allow; the other kills
commands, takes disks away, and hosts from a board, in which the first helps it when all is read. What is found is named
by reader and number, and its file is kept in `out/endurance`. Exit code 1 if anything is found.
"""

from __future__ import annotations

import shutil
import sys
import warnings
from collections import Counter, deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic
from typing import TextIO

from tests.committed import ROOT
from tests.endurance.disks import TRIALS
from tests.endurance.kills import COMMANDS, faults
from tests.endurance.readers import fault, readers
from tests.endurance.sockets import strained

INPUTS = 100_000  # of all readers together
MINUTES = 30.0  # after which nothing new is begun
LINK_S = 600.0  # for hosts on a bad link
Work = Callable[[Path], list[str]]
KEPT = ROOT / "out" / "endurance"
SHOWN = 10  # findings of a reader that are printed


def read(folder: Path, until: float) -> int:
    """Reads damaged files, a few of each reader in turn, and prints each reader's count and seconds.

    Args:
        folder: For the files.
        until: Time of the clock after which it ends.

    Returns:
        How many files came to a fault.
    """
    known = readers(folder)
    counts, seconds, bad = Counter[str](), Counter[str](), Counter[str]()
    while counts.total() < INPUTS and monotonic() < until:
        for reader in known:
            begun = monotonic()
            for number in range(counts[reader.name], counts[reader.name] + 100):
                found = fault(reader, number, folder)
                if found is not None:
                    bad[reader.name] += 1
                    if bad[reader.name] <= SHOWN:
                        KEPT.mkdir(parents=True, exist_ok=True)
                        kept = KEPT / f"{reader.name.replace(' ', '-')}-{number}-{reader.file}"
                        shutil.copy(folder / reader.file, kept)
                        print(f"FOUND {reader.name} {number}: {found}; {kept}", flush=True)
            counts[reader.name] += 100
            seconds[reader.name] += monotonic() - begun  # type: ignore[assignment]
    for name, count in counts.items():
        print(f"{name}: {count} files in {seconds[name]:.1f} s, {bad[name]} found")
    return bad.total()


def suffer(works: deque[tuple[str, Work]], folder: Path, until: float, wording: TextIO) -> int:
    """Kills commands and takes disks away.

    Args:
        works: What is still to be done, by name; both hands take from it.
        folder: Where the commands write.
        until: Time of the clock after which nothing new is begun.
        wording: Where results are printed; standard output may be the subject of a trial.

    Returns:
        How many things were not as they should be.
    """
    found = 0
    while True:
        try:
            name, work = works.popleft()
        except IndexError:
            return found
        if monotonic() > until:
            print(f"{name}: not begun, the minutes are over", file=wording, flush=True)
            continue
        begun, place = monotonic(), folder / name.replace(" ", "-")
        if name in TRIALS:
            place.mkdir()
        wrong = work(place)
        print(f"{name}: {monotonic() - begun:.1f} s, {len(wrong)} found", file=wording, flush=True)
        for one in wrong:
            print(f"FOUND {name}: {one}", file=wording, flush=True)
        found += len(wrong)


def main(words: list[str]) -> int:
    """Runs all of it; returns the exit code."""
    begun = monotonic()
    until = begun + 60.0 * (float(words[0]) if words else MINUTES)
    warnings.simplefilter("error")
    kills: dict[str, Work] = {
        f"{one.kills} kills of {one.name}": lambda at, one=one: faults(one, at, lambda _: None) for one in COMMANDS
    }
    link: dict[str, Work] = {"hosts on a bad link": lambda _: strained(LINK_S)[0]}
    works = deque((link | TRIALS | kills).items())
    with TemporaryDirectory() as first, TemporaryDirectory() as second, ThreadPoolExecutor(1) as other:
        suffering = other.submit(suffer, works, Path(second), until, sys.stdout)
        found = read(Path(first), until) + suffer(works, Path(second), until, sys.stdout) + suffering.result()
    print(f"{found} found in {(monotonic() - begun) / 60.0:.1f} minutes")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
