"""What the commands share: the design and its masses as arguments, and the device that they name."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from functools import wraps
from pathlib import Path

from delta_cad.common.arguments import design_option
from delta_cad.common.console import BAD_INPUT, catalogue_option, refuse

Run = Callable[[argparse.Namespace], int]


def device_arguments(command: argparse.ArgumentParser, *, unless: str = "") -> None:
    """Adds the design file, the folder of own parts and the masses of a build to a command's arguments."""
    design_option(command, unless=unless)
    catalogue_option(command)
    text = "mass_properties.json of a build of the design; default: out/NAME/mass_properties.json"
    command.add_argument("--mass-properties", type=Path, dest="masses", metavar="FILE", help=text)
    command.add_argument("--masses", type=Path, default=argparse.SUPPRESS, help=argparse.SUPPRESS)  # its former name


def loop_options(command: argparse.ArgumentParser) -> None:
    """Adds what chooses the loop whose walls are computed; each goes before the `loop` of the design file."""
    rate, share = number("number from 100 to 100000 Hz", 100.0, 1e5), number("share from 0 to 1", 0.0, 1.0)
    damped = number("number from 0 to 100 N s/m", 0.0, 100.0)
    file = "default: loop.{0} of the design file, else {1}"
    command.add_argument(
        "--rate", type=rate, metavar="HZ", help=f"rate of the loop, Hz; {file.format('rate_Hz', 8000)}"
    )
    text = file.format("damping_N_s_m", "2, with drives that damp 0.17")
    command.add_argument("--damping", type=damped, metavar="B", help=f"damping of the walls, N s/m; {text}")
    text = "share of the motors' short-circuit damping that the drives add at a wall, without delay; "
    command.add_argument(
        "--drive-damping", type=share, metavar="SHARE", help=text + file.format("drive_damping", "0: none")
    )


def loop_given(given: argparse.Namespace) -> bool:
    """Whether an option of `loop_options` is there."""
    return (given.rate, given.damping, given.drive_damping) != (None, None, None)


def number(meaning: str, low: float, high: float = math.inf) -> Callable[[str], float]:
    """Reader of a finite number between two bounds, for argparse, whose messages name its meaning."""

    def read(text: str) -> float:
        value = float(text)
        if not (low <= value <= high and math.isfinite(value)):
            raise ValueError(text)
        return value

    read.__name__ = f"{meaning}:"
    return read


def refusing(run: Run) -> Run:
    """Lets a command refuse a design or masses that cannot be read, with one line and exit code 2."""

    @wraps(run)
    def wrapped(given: argparse.Namespace) -> int:
        try:
            return run(given)
        except ValueError as error:
            from delta_cad.design import DesignError  # only now: they load NumPy, whose threads a command may set first
            from delta_cad.drive.masses import MassError

            if isinstance(error, DesignError | MassError):
                return refuse(str(error), BAD_INPUT)
            raise

    return wrapped
