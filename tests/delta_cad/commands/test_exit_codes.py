"""The help of every command line tells every exit code, 130 of Ctrl-C too; what Ctrl-C leaves behind is nothing."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from delta_cad.commands import cli as delta_cad
from delta_cad.commands import pipeline
from delta_cad.common.console import CUT_SHORT, INTERRUPTED
from delta_cad.design import Design
from haptics.commands import cli as haptics
from optimizer.commands import cli as optimizer
from tests.delta_cad.commands.test_build import Idle

PARSERS = [
    (delta_cad.parser, {0, 1, 2, 3, INTERRUPTED}),
    (optimizer.parser, {0, 1, 2, CUT_SHORT, INTERRUPTED}),
    (haptics.parser, {0, 1, 2, INTERRUPTED}),
]


@pytest.mark.parametrize(("parser", "codes"), PARSERS, ids=["delta_cad", "optimizer", "haptics"])
def test_help_ends_with_all_exit_codes(parser: Callable[[], argparse.ArgumentParser], codes: set[int]) -> None:
    reported = " ".join(parser().format_help().split()).split("exit codes: ")[1]
    assert {int(code) for code in re.findall(r"(?:^|; )(\d+) ", reported)} == codes
    assert reported.endswith("130 interrupted by Ctrl-C")


def test_who_fills_the_folder_ends_before_it_is_taken_away(
    best: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another process that still writes would leave the hidden folder behind."""
    left: list[int] = []

    class Watched(Idle):
        def __exit__(self, *_: object) -> None:
            left.append(len(list(tmp_path.glob(".*.part"))))

    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(pipeline, "WorkerProcess", Watched)
    monkeypatch.setattr(pipeline, "make_machine", stopped)
    with pytest.raises(KeyboardInterrupt):
        pipeline.build(best, tmp_path)
    assert left == [1] * 4
    assert list(tmp_path.iterdir()) == []
