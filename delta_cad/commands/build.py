"""`build`: solids, assembly, checks and all files of a design."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from delta_cad.commands.machine import ALL, MACHINE_OPTIONS, SUGGEST, made
from delta_cad.common.options import Option

if TYPE_CHECKING:
    from delta_cad.commands.pipeline import Outcome
    from delta_cad.design import Design

NAME = "build"
TEXT = "build a design: solids, checks and all files in OUT/NAME, or OUT/NAME.rejected if a check fails"


OPTIONS = (
    *MACHINE_OPTIONS,
    SUGGEST,
    ALL,
    Option("--step-schema", choices=("AP242", "AP214"), default="AP242", help="STEP schema; default: AP242"),
    Option(
        "--no-drawings", action="store_true", help="skip drawings, manual and quotation.zip; the manifest records it"
    ),
    Option("--no-report", action="store_true", help="skip report.html and pictures; the manifest records it"),
)


def run(given: argparse.Namespace) -> int:
    """Builds the design and returns the exit code."""
    return made(given, _built, lambda design, given: given.out / design.name, folder=True)


def _built(design: Design, given: argparse.Namespace, progress: Callable[[str], None]) -> Outcome:
    from delta_cad.commands.pipeline import build

    drawings, report = not given.no_drawings, not given.no_report
    return build(design, given.out, progress, given.step_schema, drawings=drawings, report=report)
