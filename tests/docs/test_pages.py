"""Every command and code block of README and docs/ runs and gives what the page says.

30 s of processor: the commands of every page run as a reader would run them.
"""

from __future__ import annotations

import json
import subprocess
import tomllib
from pathlib import Path

import pytest

from tests.committed import ROOT, Built
from tests.docs.pages import PAGES, WRITTEN, blocks, checkout, run, shell

RUN = [page for page in PAGES if page not in WRITTEN and any(b.language in ("sh", "python") for b in blocks(page))]
SLOW = [page for page in RUN if any(block.slow for block in blocks(page))]
SPOKEN = {"sh", "python", "text", "json", "toml", "diff"}


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.fixture
def folder(tmp_path: Path, committed: Built, monkeypatch: pytest.MonkeyPatch) -> Path:
    checkout(tmp_path, committed.folder)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("page", RUN, ids=name)
def test_blocks_of_a_page_run(page: Path, folder: Path) -> None:
    assert run(page, folder, slow=False) == []


@pytest.mark.slow
@pytest.mark.parametrize("page", SLOW, ids=name)
def test_slow_blocks_of_a_page_run(page: Path, folder: Path) -> None:
    assert run(page, folder, slow=True) == []


@pytest.mark.parametrize("page", [page for page in PAGES if page not in WRITTEN], ids=name)
def test_blocks_are_of_a_language_that_is_tested(page: Path) -> None:
    for block in blocks(page):
        assert block.language in SPOKEN, f"{page}:{block.line}"
        if block.language == "json":
            json.loads(block.code if block.code.lstrip().startswith("{") else f"{{{block.code}}}")
        if block.language == "toml":
            tomllib.loads(block.code)
    assert page.read_text(encoding="utf-8").count("```") % 2 == 0


def test_what_a_page_shows_and_no_command_prints_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.docs.pages.ROOT", tmp_path)
    page = tmp_path / "page.md"
    command = """python -c "print('1 of 11 limits FAIL'); raise SystemExit(1)\""""
    for shown, code, wrong in (("1 of 11", 1, ""), ("3 of 11", 1, "3 of 11"), ("1 of 11", 0, "exit code 1, not 0")):
        page.write_text(f"<!-- exit {code} -->\n```sh\n{command}\n```\n\n```text\n{shown} limits FAIL\n```\n")
        found = run(page, tmp_path, slow=False)
        assert len(found) == bool(wrong)
        assert wrong in "".join(found)


@pytest.mark.parametrize(("line", "code"), [("make build  # once", 0), ("make docs", 0), ("make tea", 1)])
def test_a_target_of_make_is_there(line: str, code: int) -> None:
    words = shell(line)
    assert words is not None
    assert subprocess.run(words).returncode == code


def test_what_a_test_needs_no_more_is_not_run() -> None:
    assert shell(". .venv/bin/activate") is None
    assert shell("# only a remark") is None
