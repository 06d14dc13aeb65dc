"""The code blocks of the pages, run as a reader would run them: in order, in a folder with what a checkout has."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

from tests.committed import ROOT
from tests.terminal import said

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
WRITTEN = {ROOT / "docs" / "gallery" / "figures.md", ROOT / "docs" / "reproduce.md"}  # by commands
BLOCK = re.compile(r"(?:^<!-- ([\w ]+) -->\n)?^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMAND = re.compile(
    r"(?:\.venv/bin/)?python -m (delta_cad|optimizer|haptics) ([^|<>;&$`*?]*)"
)  # without a shell's signs
HANGS_S = 1800.0  # after which a line of a page is taken to hang: a search may take ten minutes, and longer when busy


@dataclass(frozen=True)
class Block:
    """A block of code.

    Attributes:
        language: sh, python, text (what the block before it prints), json, toml, ...
        code: Its lines.
        slow: Whether the default tier leaves it out.
        exit: Exit code of its last line.
        line: Line of the page, from 1.
    """

    language: str
    code: str
    slow: bool
    exit: int
    line: int


def blocks(page: Path) -> Iterator[Block]:
    """Every block of a page."""
    text = page.read_text(encoding="utf-8")
    for found in BLOCK.finditer(text):
        words = (found[1] or "").split()
        code = int(words[words.index("exit") + 1]) if "exit" in words else 0
        yield Block(found[2], found[3], "slow" in words, code, text[: found.start()].count("\n") + 1)


def shell(line: str) -> list[str] | None:
    """The words of one command of a page for this Python; None for one that sets up what stands here already."""
    line = re.sub(r"(?:^|\s+)#.*", "", line)
    if line in ("", ". .venv/bin/activate"):
        return None
    if line.startswith("make "):  # that it is there: to run it is CI's affair
        return ["grep", "-qE", f"^{line.removeprefix('make ').strip()}:", str(ROOT / "Makefile")]
    line = re.sub(r"^(?:\.venv/bin/)?python ", f"{shlex.quote(sys.executable)} ", line)
    return ["bash", "-c", line]


def run(page: Path, folder: Path, slow: bool) -> list[str]:
    """Runs the blocks of a page in a folder.

    Args:
        page: The page.
        folder: A checkout's files stand there, see `checkout`.
        slow: Whether to run the slow ones, too.

    Returns:
        What of it did not come out as the page says, with the line.
    """
    wrong: list[str] = []
    names: dict[str, Any] = {}
    printed: str | None = ""  # None: by a block that was left out
    for block in blocks(page):
        at = f"{page.relative_to(ROOT)}:{block.line}"
        if block.slow and not slow:
            printed = None
            continue
        if block.language == "sh":
            printed, code, reported = _run_lines(block, folder)
            if code != block.exit:
                wrong.append(f"{at}: exit code {code}, not {block.exit}: {reported[-500:]}")
        elif block.language == "python":
            out = StringIO()
            with redirect_stdout(out):
                exec(compile(block.code, at, "exec"), names)
            printed = out.getvalue()
        elif block.language == "text" and printed is not None:
            wrong += [f"{at}: {line!r} is not what is printed:\n{printed}" for line in _missing(block.code, printed)]
    return wrong


def _run_lines(block: Block, folder: Path) -> tuple[str, int, str]:
    printed, code, reported = "", 0, ""
    for line in block.code.splitlines():
        words = shell(line)
        if words is None:
            continue
        if (own := COMMAND.fullmatch(re.sub(r"\s+#.*", "", line))) is not None:
            out, code, reported = _run_here(own[1], shlex.split(own[2]), folder)
            printed += out
            if code:
                break
            continue
        room = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])}
        ended = subprocess.run(words, cwd=folder, capture_output=True, text=True, env=room, timeout=HANGS_S)
        printed, code = printed + ended.stdout, ended.returncode
        reported = said(ended.stderr) or ended.stdout
        if code:
            break
    return printed, code, reported


def _run_here(package: str, words: list[str], folder: Path) -> tuple[str, int, str]:
    """Runs one of these commands in this process, which has loaded by now what each would load again."""
    out, err = StringIO(), StringIO()
    with chdir(folder), redirect_stdout(out), redirect_stderr(err):
        try:
            code = import_module(f"{package}.commands.cli").main(words)
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
    return out.getvalue(), code, said(err.getvalue()) or out.getvalue()


def _missing(expected: str, printed: str) -> list[str]:
    """Lines that a page shows and a command does not print, in their order; `...` stands for any lines."""
    rest, missing = [" ".join(line.split()) for line in printed.splitlines()], list[str]()
    for line in (" ".join(line.split()) for line in expected.splitlines()):
        if line in rest:
            rest = rest[rest.index(line) + 1 :]
        elif line != "...":
            missing.append(line)
    return missing


def checkout(folder: Path, built: Path) -> None:
    """Makes a folder look like a checkout in which `make build` was run.

    Args:
        folder: An empty folder.
        built: The build of the committed design.
    """
    for name in ("best.json", "joystick.toml"):
        shutil.copy(ROOT / name, folder)
    for name in ("examples", "docs/gallery"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("*.png", "__pycache__"))
    (folder / "out").mkdir()
    shutil.copytree(built, folder / "out" / built.name)  # a page may build into it
