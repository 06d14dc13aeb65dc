"""A subject of simple solids, the committed design's page, and a browser."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.dimensions import Dimensions
from delta_cad.export.views.views import Stage
from delta_cad.report.subject import Subject
from tests.committed import Built
from tests.delta_cad.export.machine import make_assembly, make_parts
from tests.delta_cad.report.reading import Page

GRAPHICS = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")  # WebGL, on the processor
FLAGS = (
    "--no-sandbox",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
LEAN = CheckResult("lean", True, 24.0, 28.0, "deg", (1.0, -2.0, 90.0), ("rod_0_0",), "largest of 9 positions")


@pytest.fixture(scope="session")
def subject(best_dimensions: Dimensions) -> Subject:
    """A small machine on the committed design's sums: what stands in a page, not whether it is right."""
    from delta_cad.assembly.tessellation import MeshLibrary
    from delta_cad.export.mass_properties import mass_report

    assembly = make_assembly(make_parts())
    return Subject(
        dimensions=best_dimensions,
        assembly=assembly,
        meshes=MeshLibrary(assembly.parts, 0.2, 0.5),
        masses=mass_report(assembly),
        limits=CheckLimits(80.0, 20.0, 270.0, 220.0, grid=3, random_poses=0),
        results=(LEAN,),
        stage=Stage((270.0, 220.0), (0.0, 0.0), 80.0, 20.0),
        reach_mm=None,
    )


@pytest.fixture(scope="session")
def page(built: Built) -> Page:
    """The page of the committed design's build."""
    return Page((built.folder / "report.html").read_text(encoding="utf-8"))


@contextmanager
def headless(*flags: str) -> Iterator[Any]:
    """A browser without a screen, which `make test` installs."""
    from playwright import sync_api

    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    assert found is not None, f"the page is tested in a browser: none of {', '.join(BROWSERS)} is on the path"
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=[*FLAGS, *flags])
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """A browser that draws in three dimensions. Its loop must not outlive the module."""
    with headless(*GRAPHICS) as browser:
        yield browser


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the two files that a page is made of."""
    (tmp_path / "assembly.glb").write_bytes(b"glTF of nothing")
    (tmp_path / "bom.json").write_text('{"items": []}', encoding="utf-8")
    return tmp_path
