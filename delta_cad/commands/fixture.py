"""`fixture`: a plate with seats that a made device is calibrated against."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from delta_cad.commands.drawings import DrawnOutcome, tell
from delta_cad.commands.machine import MACHINE_OPTIONS, made

if TYPE_CHECKING:
    from delta_cad.design import Design

NAME = "fixture"
TEXT = "calibration plate with columns: STEP files, drawings and poses.csv, in OUT/NAME-fixture"
OPTIONS = MACHINE_OPTIONS


def run(given: argparse.Namespace) -> int:
    """Writes the fixture and returns the exit code."""
    return made(given, _made, _place, folder=True, tell=tell)


def _place(design: Design, given: argparse.Namespace) -> Path:
    return given.out / f"{design.name}-fixture"


def _made(design: Design, given: argparse.Namespace, progress: Callable[[str], None]) -> DrawnOutcome:
    from delta_cad.common.files import whole_folder
    from delta_cad.dimensions import dimensions
    from delta_cad.export.shop.fixture import write_fixture

    progress("fixture")
    with whole_folder(_place(design, given)) as folder:
        drawn = write_fixture(dimensions(design), folder)
    return DrawnOutcome(design.name, drawn, _place(design, given))
