"""Options that the commands share: the design with the masses of its build, and the loop of its controller."""

from __future__ import annotations

import argparse
from pathlib import Path

from delta_cad.common.options import CATALOGUE, DESIGN, MASS_PROPERTIES, OUT_FOLDER, Option, number

HERTZ = number(100.0, 1e5, "Hz")
_OF_FILE = "default: loop.{0} of the design file, else {1}"
DEVICE_OPTIONS = (
    DESIGN,
    CATALOGUE,
    MASS_PROPERTIES,
    Option(
        "--masses", dest="mass_properties", type=Path, default=argparse.SUPPRESS, help=argparse.SUPPRESS
    ),  # formerly
)
FILES_FOLDER = OUT_FOLDER.but(required=True, default=None, help="folder of the files; one that a run wrote is replaced")
# The loop whose walls are computed; each goes before the `loop` of the design file.
LOOP_OPTIONS = (
    Option("--rate", type=HERTZ, metavar="HZ", help=f"rate of the loop, Hz; {_OF_FILE.format('rate_Hz', 8000)}"),
    Option(
        "--damping",
        type=number(0.0, 100.0, "N s/m"),
        metavar="B",
        help=f"damping of the walls, N s/m; {_OF_FILE.format('damping_N_s_m', '2, with drives that damp 0.17')}",
    ),
    Option(
        "--drive-damping",
        type=number(0.0, 1.0),
        metavar="SHARE",
        help="share of the motors' short-circuit damping that the drives add at a wall, without delay; "
        + _OF_FILE.format("drive_damping", "0: none"),
    ),
)


def loop_given(given: argparse.Namespace) -> bool:
    """Decides whether an option of `LOOP_OPTIONS` is there."""
    return (given.rate, given.damping, given.drive_damping) != (None, None, None)
