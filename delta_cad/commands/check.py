"""`check`: the checks of a design, and no other file than their result."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from delta_cad.commands.machine import ALL, MACHINE_OPTIONS, SUGGEST, made

if TYPE_CHECKING:
    from delta_cad.commands.pipeline import Outcome
    from delta_cad.design import Design

NAME = "check"
TEXT = "run the checks only; writes nothing but OUT/NAME.checks.json"
OPTIONS = (*MACHINE_OPTIONS, SUGGEST, ALL)


def run(given: argparse.Namespace) -> int:
    """Checks the design and returns the exit code."""
    return made(given, _checked, _place, folder=False)


def _checked(design: Design, given: argparse.Namespace, progress: Callable[[str], None]) -> Outcome:
    from delta_cad.commands.pipeline import check
    from delta_cad.common.files import write_whole

    outcome = check(design, progress)
    write_whole(_place(design, given), json.dumps(outcome.record(), indent=1) + "\n")
    return outcome


def _place(design: Design, given: argparse.Namespace) -> Path:
    return given.out / f"{design.name}.checks.json"
