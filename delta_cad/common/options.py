"""The options of all commands: those that several commands have, each described once, and the values that they take.

Imported on every `--help`, so it loads nothing heavy.
"""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

T = TypeVar("T")
OUT = Path("out")
_DEFAULT_DESIGN = Path("best.json")  # of the current folder
CACHE_OFF = "DELTA_CAD_NO_CACHE"
"""Environment variable that, where it is set, keeps results off the disk; worker processes inherit it."""
POSITIVE = math.nextafter(0.0, 1.0)
MOST_PORT = 65535


class Option:
    """An argument of a command, as `argparse` takes it.

    Args:
        names: `--name`, or the name of a positional argument.
        settle: Called with the command and what was typed, once that is read; it may fill in a default.
        settings: Of `ArgumentParser.add_argument`.
    """

    def __init__(
        self,
        *names: str,
        settle: Callable[[argparse.ArgumentParser, argparse.Namespace], None] | None = None,
        **settings: Any,
    ) -> None:
        self.names, self.settle, self.settings = names, settle, settings

    def but(self, **changes: Any) -> Option:
        """Gives the same option with other settings in a command where it means something else."""
        return Option(*self.names, **({"settle": self.settle} | self.settings | changes))


def add_options(command: argparse.ArgumentParser, options: Iterable[Option | tuple[Option, ...]]) -> None:
    """Adds options to a command.

    Args:
        command: The command.
        options: In the order of the help; of those in a tuple only one may be given.
    """
    for one in options:
        place = command.add_mutually_exclusive_group() if isinstance(one, tuple) else command
        for option in one if isinstance(one, tuple) else (one,):
            place.add_argument(*option.names, **option.settings)
            if option.settle is not None:
                settle = option.settle
                command.set_defaults(settle=lambda given, settle=settle: settle(command, given))


def reader(meaning: str, read: Callable[[str], T]) -> Callable[[str], T]:
    """Makes a reader of values for argparse, whose errors tell the value and what it must be.

    Args:
        meaning: What the value must be, such as "a whole number".
        read: Raises ValueError for what is none.
    """

    def checked(text: str) -> T:
        try:
            return read(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text}: must be {meaning}") from None

    return checked


def number(low: float, high: float = math.inf, unit: str = "", *, words: tuple[str, ...] = ()) -> Callable[[str], Any]:
    """Makes a reader of finite numbers between two bounds, both included; see `reader`.

    Args:
        low: Lower bound; `POSITIVE` for more than 0.
        high: Upper bound.
        unit: Of the number, for its errors.
        words: Words that may stand in its place, which are read as they are.
    """
    bounds = "> 0" if low == POSITIVE else f">= {low:g}"
    bounds += "" if high == math.inf else f" and <= {high:g}"

    def read(text: str) -> float | str:
        if text in words:
            return text
        value = float(text)
        if not (low <= value <= high and math.isfinite(value)):
            raise ValueError
        return value

    return reader(" or ".join([f"a number {bounds} {unit}".rstrip(), *words]), read)


def whole(low: int, high: int | None = None) -> Callable[[str], int]:
    """Makes a reader of whole numbers between two bounds, both included; see `reader`."""

    def read(text: str) -> int:
        value = int(text)
        if value < low or (high is not None and value > high):
            raise ValueError
        return value

    return reader(f"a whole number >= {low}" + ("" if high is None else f" and <= {high}"), read)


def settle_design(command: argparse.ArgumentParser, given: argparse.Namespace) -> None:
    """Takes the design of the current folder where none is given, and says so; ends the program where there is none."""
    if given.design is not None:
        return
    if not _DEFAULT_DESIGN.is_file():
        command.error(f"--design FILE is needed: there is no {_DEFAULT_DESIGN} in this folder")
    given.design = _DEFAULT_DESIGN
    with suppress(OSError, AttributeError):  # nobody reads
        print(f"--design {_DEFAULT_DESIGN}: taken, as none was given", file=sys.stderr, flush=True)


DESIGN = Option(
    "--design",
    type=Path,
    metavar="FILE",
    help=f"design file, delta-design/1; default: {_DEFAULT_DESIGN} of the current folder",
    settle=settle_design,
)
REQUIREMENTS = Option("requirements", type=Path, metavar="REQ.toml", help="requirements file")
_CATALOGUE = "folder of your own parts (motor.csv, cable.csv, ...); default: the one named in "
CATALOGUE = Option("--catalogue", type=Path, metavar="DIR", help=f"{_CATALOGUE}the design file")
REQUIREMENTS_CATALOGUE = CATALOGUE.but(help=f"{_CATALOGUE}the requirements file")
EITHER_CATALOGUE = CATALOGUE.but(help=f"{_CATALOGUE}the requirements file or the design")
MASS_PROPERTIES = Option(
    "--mass-properties",
    type=Path,
    metavar="FILE",
    help="mass_properties.json of a build of the design; default: out/NAME/mass_properties.json",
)
CALIBRATION = Option("--calibration", type=Path, metavar="FILE", help="calibration.json of this device")
JSON = Option("--json", action="store_true", help="print the results as JSON on stdout")
PROGRESS = Option(
    "--progress",
    choices=("text", "json"),
    default="text",
    help="form of progress on stderr: a line for people, or one JSON object a line; default: text",
)
OUT_FOLDER = Option("--out", type=Path, default=OUT, metavar="DIR", help=f"parent folder of results; default: {OUT}")


class _CacheOff(argparse.Action):
    """Keeps results off the disk in this process and in those that it starts."""

    def __call__(self, _parser: object, _given: object, _values: object, _option: object = None) -> None:
        os.environ[CACHE_OFF] = "1"


NO_CACHE = Option(
    "--no-cache",
    action=_CacheOff,
    nargs=0,
    help="neither read nor keep solids, meshes, common volumes, lines and STEP files on disk; results are the same",
)
SEED = Option("--seed", type=whole(0), default=0, metavar="N", help="random seed; default: 0")


def proof_minutes(what: str) -> Option:
    """Makes `--proof-minutes`, the time that proofs may take; infinite where it is not given.

    Args:
        what: Which of a command's proofs together end with it.
    """
    return Option(
        "--proof-minutes",
        type=number(POSITIVE, unit="min"),
        default=math.inf,
        metavar="M",
        help=f"time limit {what}, minutes; the result so far is kept; default: none",
    )
