"""The pages as they are read: built once, and a browser."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.committed import ROOT, Shared
from tests.delta_cad.report.conftest import headless

NOWHERE = dict.fromkeys(("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY"), "http://127.0.0.1:9")


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """A browser that draws no picture in three dimensions: the pages have none."""
    with headless("--disable-gpu") as browser:
        yield browser


@pytest.fixture(scope="session")
def site(shared: Shared) -> Path:
    """The pages, built as `make docs` does, warnings as errors and no way to the network."""
    folder = shared.folder / "site"

    def build() -> tuple[int, str]:
        words = ["-W", "--keep-going", "-q", "-b", "html", str(ROOT / "docs"), str(folder)]
        command = [sys.executable, "-m", "sphinx", "-d", str(shared.folder / "doctrees"), *words]
        run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env=os.environ | NOWHERE)
        return run.returncode, run.stdout + run.stderr

    code, reported = shared.once("site", build)
    assert (code, reported) == (0, "")
    return folder
