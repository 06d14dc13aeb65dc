"""The pages in a browser: they ask nothing of any other place, fit screen and phone, and every link leads somewhere."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from lxml import html

from tests.committed import ROOT

WIDTHS = (1440, 390)  # a screen, a phone
MADE = {"genindex.html", "search.html", "py-modindex.html"}  # by Sphinx


def pages(site: Path) -> list[Path]:
    return [page for page in sorted(site.rglob("*.html")) if "_modules" not in page.parts]


def test_every_page_of_the_folder_is_there(site: Path) -> None:
    written = {path.relative_to(ROOT / "docs").with_suffix(".html") for path in (ROOT / "docs").rglob("*.md")}
    included = {Path("gallery/figures.html"), Path("reproduce.html")}
    assert {page.relative_to(site) for page in pages(site)} - {Path(name) for name in MADE} == written - included


def test_no_page_asks_anything_of_another_place_and_each_fits_its_screen(site: Path, chromium: Any) -> None:
    wrong: list[str] = []
    seen: list[str] = []
    view = chromium.new_page()
    view.on("request", lambda request: seen.append(request.url))
    view.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
    view.on("pageerror", lambda error: wrong.append(str(error)))
    for page in pages(site):
        for width in WIDTHS:
            view.set_viewport_size({"width": width, "height": 900})
            if width == WIDTHS[0]:
                view.goto(page.as_uri(), wait_until="load")
            wide = view.evaluate("document.documentElement.scrollWidth")
            if wide > width:
                wrong.append(f"{page.relative_to(site)}: {wide} px wide on {width} px")
        if page.name not in MADE:
            assert view.locator("article h1").first.inner_text().strip()
        broken = "[...document.images].filter(one => !one.naturalWidth).map(one => one.src)"
        wrong += view.evaluate(broken)
    view.close()
    assert wrong == []
    assert [url for url in seen if not url.startswith(("file://", "data:"))] == []
    assert len(seen) > len(pages(site))


def test_every_link_inside_leads_somewhere(site: Path) -> None:
    trees = {page: html.parse(str(page)).getroot() for page in sorted(site.rglob("*.html"))}
    ids = {page: {one.get("id") for one in tree.iter() if one.get("id")} for page, tree in trees.items()}
    lost = []
    for page in pages(site):
        for link in trees[page].iter("a"):
            there = urlsplit(link.get("href") or "")
            if there.scheme or not (there.path or there.fragment):
                continue
            target = (page.parent / unquote(there.path)).resolve() if there.path else page
            known = ids.get(target)
            if not target.exists() or (there.fragment and known is not None and unquote(there.fragment) not in known):
                lost.append(f"{page.relative_to(site)}: {link.get('href')}")
    assert lost == []


def test_the_reference_has_what_a_user_calls(site: Path) -> None:
    named = {
        "reference/mechanism.html": (
            "delta_cad.mechanism.geometry.DeltaGeometry",
            "delta_cad.mechanism.inverse.closure_margin",
            "delta_cad.mechanism.inverse.inverse_kinematics",
            "delta_cad.mechanism.forward.forward_kinematics",
            "delta_cad.mechanism.jacobian.jacobian",
        ),
        "reference/haptics.html": (
            "haptics.devices.host.Host",
            "haptics.gravity.torque.gravity_torque",
            "haptics.rendering.laws.operating_resistance.operating_resistance",
            "haptics.rendering.laws.virtual_wall.virtual_wall",
        ),
        "reference/design.html": ("delta_cad.catalogue.family", "delta_cad.design.file.load_design"),
    }
    for page, names in named.items():
        tree = html.parse(str(site / page)).getroot()
        assert [name for name in names if tree.get_element_by_id(name, None) is None] == []
    commands = (site / "reference" / "commands.html").read_text(encoding="utf-8")
    for command in ("delta-cad-build", "optimizer-design", "haptics-simulate"):
        assert f'id="{command}"' in commands
    assert "--mass-properties" in commands


def test_the_reference_needs_no_cad_kernel() -> None:
    modules = "delta_cad.mechanism, delta_cad.design, delta_cad.drive.masses, haptics.devices.host"
    kernel = "sys.modules.update(dict.fromkeys(('cadquery', 'OCP', 'vtkmodules')))"  # an import of any fails
    code = f"import sys; {kernel}; import {modules}, haptics.model.machine"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT).returncode == 0
