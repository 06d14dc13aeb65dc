"""The machine from above: what is swept lies within its proved bound, what stands still where it stands."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.report.outline import outline
from delta_cad.report.subject import Subject
from tests.committed import Built
from tests.delta_cad.report.reading import Page

ROUNDED_MM = 0.01  # five digits


def polygons(page: Page, kind: str) -> list[np.ndarray]:
    found = page.all("polygon", **{"class": kind})
    return [np.array([pair.split(",") for pair in e.attributes["points"].split()], dtype=float) for e in found]


def rectangle(page: Page, kind: str) -> tuple[np.ndarray, np.ndarray]:
    (rect,) = page.all("rect", **{"class": kind})
    x, y, w, h = (float(rect.attributes[name]) for name in ("x", "y", "width", "height"))
    return np.array([x, y]), np.array([w, h])


def test_the_sweep_is_within_its_bound_and_that_within_the_rectangle(page: Page, built: Built) -> None:
    checks = {c["name"]: c["value"] for c in built.record["checks"]}
    corner, size = rectangle(page, "bound")
    assert sorted(size) == pytest.approx(sorted(checks[f"envelope {side}"] for side in ("width", "depth")), abs=0.06)
    swept = np.concatenate(polygons(page, "swept"))
    assert (swept >= corner - ROUNDED_MM).all()
    assert (swept <= corner + size + ROUNDED_MM).all()
    low, high = swept.min(axis=0), swept.max(axis=0)
    assert high - low == pytest.approx(size, abs=1.5)  # corners of the cube are among the positions
    allowed, room = rectangle(page, "allowed")
    assert (allowed <= corner + ROUNDED_MM).all()
    assert (allowed + room >= corner + size - ROUNDED_MM).all()
    assert sorted(room) == [220.0, 270.0]


def test_at_rest_it_lies_within_what_it_sweeps(page: Page) -> None:
    swept, rest = (np.concatenate(polygons(page, kind)) for kind in ("swept", "home"))
    assert (rest.min(axis=0) >= swept.min(axis=0) - ROUNDED_MM).all()
    assert (rest.max(axis=0) <= swept.max(axis=0) + ROUNDED_MM).all()


def test_a_round_plate_is_round_and_a_turned_motor_where_its_chain_is(subject: Subject) -> None:
    found = outline(replace(subject, results=()))
    plate = max((np.array(p) for p in found["home"]), key=lambda p: np.ptp(p[:, 0]))
    assert np.hypot(*plate.T) == pytest.approx(88.0, abs=0.01)
    swept = np.concatenate([np.array(p) for p in found["bodies"]])
    turned = swept @ np.array([[-0.5, -np.sqrt(0.75)], [np.sqrt(0.75), -0.5]]).T
    # the machine is alike in its three chains, the cube is not: only about
    assert np.hypot(*turned.T).max() == pytest.approx(np.hypot(*swept.T).max())
    assert found["bound"] is None
    x, y, w, h = found["frame"]
    assert (swept >= [x, y]).all()
    assert (swept <= [x + w, y + h]).all()


def test_the_caption_tells_the_bound(page: Page) -> None:
    _, size = rectangle(page, "bound")
    (caption,) = (e.text for e in page.all("figcaption"))
    w, h = re.findall(r"(\d+\.\d) × (\d+\.\d) mm", caption)[0]
    assert (float(w), float(h)) == pytest.approx(size.tolist(), abs=0.051)


def test_the_cube_is_drawn_where_it_stands(subject: Subject) -> None:
    aside = replace(subject, limits=replace(subject.limits, centre_x_mm=11.0))
    assert outline(aside)["cube"] == pytest.approx([11.0 - 20.0, -20.0, 40.0, 40.0])
    assert outline(subject)["cube"] == pytest.approx([-20.0, -20.0, 40.0, 40.0])
