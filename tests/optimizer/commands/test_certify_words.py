"""What `certify` and `verify` say and exit with, command by command, as the files in certify/words have it."""

from __future__ import annotations

import re
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from delta_cad.design import load_design
from tests.committed import BEST
from tests.optimizer.certify.designs import call, changed, masses

WORDS = Path(__file__).parents[1] / "certify" / "words"
CASES = tomllib.loads((WORDS / "cases.toml").read_text(encoding="utf-8"))["case"]


def settled(text: str) -> str:
    """Four digits of each number; no roundings, counts of boxes, digests, nor which of equal points was found."""
    text = re.sub(r"\b[0-9a-f]{12}\b", "DIGEST", text)
    text = re.sub(r"\(-?[\d.]+, -?[\d.]+, -?[\d.]+\) mm", "POINT", text)
    text = re.sub(r"\b\d+( boxes of| examined| kept| boxes examined)", r"N\1", text)
    text = re.sub(r"-?\d+\.\d+(?:e[+-]?\d+)?", lambda found: f"{round(float(found[0]), 9):.4g}", text)
    return re.sub(r" {2,}", "  ", text)


@pytest.mark.parametrize("case", CASES, ids=[case["title"] for case in CASES])
def test_words_and_exit_codes(
    case: dict[str, Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    golden: Callable[[Path, list[str]], None],
) -> None:
    monkeypatch.chdir(tmp_path)
    if case.get("committed"):
        shutil.copy(BEST, "design.json")
    else:
        changed(tmp_path, case.get("cube"), case.get("mechanism"), **case.get("requirements", {}))
    masses(tmp_path, load_design("design.json"), turning=2e-6)
    files = {"D": ["--design", "design.json"], "M": ["--mass-properties", "mass_properties.json"]}
    lines = []
    for words in case["commands"]:
        name, *more = [part for word in words.split() for part in files.get(word, [word])]
        start = [*files["D"], "--out", "c.json"] if name == "certify" else ["c.json"]
        lines += [f"$ {words}", f"exit {call(name, *start, *more)}"]
        lines += [line for text in capsys.readouterr() for line in settled(text).splitlines()]
    golden(WORDS / f"{case['title']}.txt", lines)
