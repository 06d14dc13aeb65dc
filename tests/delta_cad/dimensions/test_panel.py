"""Panel: the opening against points of the stem all over the cube, heights against those of the platform, refusals."""

from __future__ import annotations

from itertools import product
from math import hypot, pi
from typing import Any

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.design import DesignError, design_from_dict, design_hash, design_to_dict
from delta_cad.dimensions import DimensionError, Dimensions, dimensions
from delta_cad.dimensions.panel import CLOTH_MM, LIP_MM, PanelDimensions
from tests.committed import changed
from tests.delta_cad.dimensions.paneled import of_panel, with_panel

STEP_RAD = 2 * pi / 720


def panel(d: Dimensions) -> PanelDimensions:
    assert d.panel is not None
    return d.panel


def inside_mm(points: np.ndarray, half_mm: float, corner_mm: float) -> np.ndarray:
    """How far points lie inside a square with round corners: its radius less their distance from the inner square."""
    beyond = np.maximum(np.abs(points) - half_mm, 0.0)
    return corner_mm - np.hypot(beyond[..., 0], beyond[..., 1])


@pytest.mark.parametrize("half", [22.0, 25.0, 32.0])
def test_the_opening_is_what_the_stem_sweeps_and_the_same_gap_all_around(half: float) -> None:
    d = of_panel(cube__half_side_mm=half, cube__bottom_height_mm=80.0)
    p = panel(d)
    angle = np.arange(0.0, 2 * pi, STEP_RAD)
    rim = p.stem_radius_mm * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    side = np.linspace(-half, half, 41)
    places = np.array(list(product(side, side)))
    swept = (places[:, None] + rim).reshape(-1, 2)
    # the nearest that any point of the stem comes to the bezel's edge is the limit and the cloth, no less, no more
    gap = inside_mm(swept, p.half_mm, p.edge_mm)
    assert gap.min() == pytest.approx(p.limit_mm + CLOTH_MM, abs=1e-9)
    # and every place of the edge has a stem that comes so near: from each of its points the nearest place of the cube
    turn = np.linspace(0.0, pi / 2, 91)
    edge = np.concatenate(
        [half + p.edge_mm * np.stack([np.cos(turn), np.sin(turn)], -1), [[half + p.edge_mm, y] for y in side]]
    )
    nearest = np.clip(edge, -half, half)
    assert np.hypot(*(edge - nearest).T) == pytest.approx(p.stem_radius_mm + p.limit_mm + CLOTH_MM, abs=1e-9)
    assert p.opening_mm == pytest.approx(p.edge_mm + LIP_MM)


def test_areas_are_those_of_the_outlines() -> None:
    p = panel(of_panel())
    points = np.random.default_rng(7).uniform(-60.0, 60.0, (400_000, 2))
    share = float((inside_mm(points, p.half_mm, p.rim_mm) > 0.0).mean())
    assert p.area_mm2(p.rim_mm) == pytest.approx(share * 120.0**2, rel=0.005)


@pytest.mark.parametrize("thickness", [1.0, 2.0, 3.0, 5.0, 10.0])
def test_the_platform_stays_below_the_screws_and_the_collar_above_the_bezel(thickness: float) -> None:
    d = of_panel(panel__thickness_mm=thickness)
    p, clear, cube = panel(d), d.design.requirements.clearance_min_mm, d.design.cube
    screw = catalogue.screw("M3")
    top = cube.bottom_height_mm + 2 * cube.half_side_mm + d.platform.boss_diameter_mm / 2
    assert p.under_mm - screw.head_height_mm - top >= clear
    assert cube.bottom_height_mm + p.collar_mm - p.top_mm >= clear
    # collar and knob stand on the stem one over the other
    assert p.collar_mm + 8.0 + 1.0 == d.platform.boss_diameter_mm / 2 + d.platform.stem_length_mm
    engaged = p.screw_mm - thickness - CLOTH_MM
    assert screw.diameter_mm <= engaged < p.thread_mm < p.bezel_mm
    assert p.screw_mm in screw.lengths_mm


def test_the_boot_reaches_wherever_the_bezel_lets_the_handle_go() -> None:
    d = of_panel()
    p, cube = panel(d), d.design.cube
    reach = cube.half_side_mm + p.limit_mm
    rim_z, turn = p.under_mm + p.thickness_mm, np.linspace(0.0, 2 * pi, 361)
    corners = [(sx * p.half_mm, sy * p.half_mm) for sx, sy in product((-1, 1), (-1, 1))]
    edge = np.concatenate([np.array(c) + p.edge_mm * np.stack([np.cos(turn), np.sin(turn)], -1) for c in corners])
    edge = edge[inside_mm(edge, p.half_mm, p.edge_mm) < 1e-9]
    longest = 0.0
    for x, y, z in product((-reach, 0.0, reach), (-reach, 0.0, reach), (0.0, cube.half_side_mm, 2 * cube.half_side_mm)):
        across = np.hypot(*(edge - (x, y)).T).max() - p.collar_radius_mm
        longest = max(longest, hypot(across, cube.bottom_height_mm + z + p.collar_mm - rim_z))
    assert longest <= p.cloth_mm <= 1.05 * longest
    assert 0.0 < p.carried_g < p.boot_g / 2


def test_screws_stand_between_opening_and_rim_and_not_too_far_apart() -> None:
    for half in (25.0, 32.0):
        p = panel(of_panel(cube__half_side_mm=half, cube__bottom_height_mm=80.0))
        places = np.array(p.screw_places())
        assert len(places) == (4 if half == 25.0 else 8)
        inside = inside_mm(places, p.half_mm, p.rim_mm)
        assert (inside > 5.0).all()
        assert (inside_mm(places, p.half_mm, p.opening_mm) < -5.0).all()
        order = places[np.argsort(np.arctan2(places[:, 1], places[:, 0]))]
        assert np.hypot(*(order - np.roll(order, 1, axis=0)).T).max() <= 80.0


def test_the_arms_stop_outside_all_that_the_bezel_leaves() -> None:
    d, bare = of_panel(), of_panel(panel=None)
    assert d.travel.shoulder_max.value > d.extremes.shoulder_max.value
    assert d.stops_rad[0] < bare.stops_rad[0]
    assert d.stops_rad[1] > bare.stops_rad[1]
    assert bare.travel == bare.extremes


def test_a_design_without_a_panel_is_as_it_was() -> None:
    design = design_from_dict(changed())
    d = dimensions(design)
    assert (d.panel, d.sleeve_mm, d.has_feet, d.platform.stem_length_mm) == (None, 0.0, False, 25.0)
    reported = design_to_dict(design)
    assert "panel" not in reported
    assert "mounting" not in reported["hardware"]
    assert design_hash(design) == design_hash(design_from_dict(reported))


def test_a_panel_is_reported_and_read_again() -> None:
    design = with_panel()
    assert design_from_dict(design_to_dict(design)) == design
    assert design_hash(design) != design_hash(with_panel(panel__limit_mm=4.0))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"panel__limit_mm": 2.0}, "panel.limit_mm = 2.0: must be > clearance_min_mm = 2 mm"),
        ({"panel__limit_mm": 0.5}, "panel.limit_mm = 0.5: must be >= 1 and <= 10 mm"),
        ({"panel__thickness_mm": 11}, "panel.thickness_mm = 11: must be >= 1 and <= 10 mm"),
        ({"panel__thickness_mm": "2"}, 'panel.thickness_mm = "2": must be a number >= 1 and <= 10 mm'),
        ({"panel__height_mm": 3}, "panel.height_mm"),
        ({"panel": 3}, "panel = 3: must be an object"),
        ({"hardware__mounting": "glue"}, 'hardware.mounting = "glue": must be "screws", "both", "plate" or "feet"'),
        ({"cube__bottom_height_mm": 9.0, "panel__limit_mm": 9.5}, "panel.limit_mm = 9.5: must be < bottom_height_mm"),
    ],
)
def test_what_cannot_be_is_refused(values: dict[str, Any], words: str) -> None:
    with pytest.raises(DesignError) as refused:
        with_panel(**values)
    assert any(words in line for line in (str(refused.value), *refused.value.more))


def test_a_limit_that_the_arms_do_not_reach_is_refused_by_its_field() -> None:
    # the cube's upper edges are within reach, those 10 mm farther out are not
    values: dict[str, Any] = {"cube": {"bottom_height_mm": 140.0, "half_side_mm": 40.0}}
    with pytest.raises(DimensionError) as refused:
        of_panel(**values, panel__limit_mm=10.0)
    assert "panel.limit_mm" in {reason.field for reason in refused.value.reasons}


def test_sleeves_are_as_high_as_feet_that_give_way() -> None:
    assert of_panel().sleeve_mm == catalogue.foot("foot-m4-stud-15x8").height_mm - 0.5
    screws = of_panel(hardware__mounting="screws")
    assert (screws.sleeve_mm, screws.has_feet) == (0.0, False)
    assert of_panel(hardware__mounting="feet").has_feet
