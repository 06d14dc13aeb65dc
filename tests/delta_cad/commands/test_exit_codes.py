"""The help of every command line tells every exit code, 130 of Ctrl-C too."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable

import pytest

from delta_cad.commands import cli as delta_cad
from delta_cad.common.console import CUT_SHORT, INTERRUPTED
from haptics.commands import cli as haptics
from optimizer.commands import cli as optimizer

PARSERS = [
    (delta_cad.parser, {0, 1, 2, 3, INTERRUPTED}),
    (optimizer.parser, {0, 1, 2, CUT_SHORT, INTERRUPTED}),
    (haptics.parser, {0, 1, 2, INTERRUPTED}),
]


@pytest.mark.parametrize(("parser", "codes"), PARSERS, ids=["delta_cad", "optimizer", "haptics"])
def test_help_ends_with_all_exit_codes(parser: Callable[[], argparse.ArgumentParser], codes: set[int]) -> None:
    told = " ".join(parser().format_help().split()).split("exit codes: ")[1]
    assert {int(code) for code in re.findall(r"(?:^|; )(\d+) ", told)} == codes
    assert told.endswith("130 interrupted by Ctrl-C")
