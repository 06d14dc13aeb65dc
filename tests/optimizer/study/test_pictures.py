"""Pictures: of the right size, not blank, the same bytes again, and readable as what they are called."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import matplotlib
import matplotlib.image
import numpy as np
import pytest
from matplotlib.figure import Figure

from delta_cad.mechanism import Cube, DeltaGeometry
from optimizer.search.result import Result
from optimizer.study import pictures
from optimizer.study.convergence import Trace
from optimizer.study.front import Curve, FrontPoint, at_side, published_designs
from optimizer.study.maps import slices
from optimizer.study.pictures import pretty, save
from optimizer.study.trade import Trade
from tests.optimizer.front_tasks import joystick

G = DeltaGeometry(base_radius=0.040, platform_radius=0.030, upper_arm_length=0.082, forearm_length=0.112079)
CUBE = Cube(0.057112, 0.0375)
DESIGNS = (
    (82.0, 107.6, 40.0, 30.0, 46.4, 30.0),
    (82.0, 108.9, 40.0, 30.0, 41.6, 36.0),
    (82.0, 116.4, 40.0, 30.0, 43.2, 40.0),
)


def curve(name: str = "as required", bounds: bool = False, **limits: float | None) -> Curve:
    given = joystick(**limits)
    points = []
    for design in DESIGNS:
        result = Result(at_side(given, design[5]), "sqp", design, "converged")
        points.append(FrontPoint(result, ("outline", "lean"), 0.999 * result.max_kappa if bounds else None))
    return Curve(given, name, name, tuple(points), 40.0, ("lean",), largest_bound=40.1 if bounds else None)


@pytest.fixture(scope="module")
def traces() -> list[Trace]:
    return [
        Trace("ga", 0, (100, 200, 300), (math.nan, 2.2, 2.08)),
        Trace("ga", 1, (100, 200, 300), (2.6, 2.3, 2.071)),
        Trace("sqp", 0, (50, 80), (2.1, 2.075)),
        Trace("sqp", 1, (60, 90), (math.nan, 2.075)),
    ]


def drawings(traces: list[Trace]) -> dict[str, Callable[[], Figure]]:
    main = curve(bounds=True)
    empty = Curve(main.given, "outline 0.9", "R + L_A <= 100 mm", (), beyond=("lean",))
    torque = curve("torque 0.3 N m")
    torque = dataclasses.replace(
        torque, points=tuple(dataclasses.replace(p, active=("torque",)) for p in torque.points)
    )
    return {
        "workspace": lambda: pictures.workspace(G, CUBE, "a design"),
        "maps": lambda: pictures.maps(slices(G, CUBE, 3.0, 31), 3.0, "a design"),
        "convergence": lambda: pictures.convergence(traces, 2.075, "a problem"),
        "front": lambda: pictures.front(main, published_designs(main.given), main.points[-1], "a task"),
        "trade": lambda: pictures.trade(Trade(main, (empty, curve("outline 1.1")), (torque,)), "a task"),
    }


SIZES = {
    "workspace": (1800, 810),
    "maps": (1860, 1050),
    "convergence": (1650, 720),
    "front": (1440, 1200),
    "trade": (1650, 810),
}


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", SIZES)
def test_picture_is_written_whole_and_not_blank(name: str, traces: list[Trace], tmp_path: Path) -> None:
    before = dict(matplotlib.rcParams)
    save(drawings(traces)[name](), tmp_path, name)
    pixels = matplotlib.image.imread(tmp_path / f"{name}.png")
    assert pixels.shape[1::-1] == SIZES[name]
    tones = np.unique((pixels[..., :3] * 255).astype(int) @ [65536, 256, 1])
    assert len(tones) > 200
    ink = (pixels[..., :3].min(axis=-1) < 0.8).mean()
    assert 0.01 < ink < 0.7
    edge = np.concatenate([pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]])
    assert (edge[:, :3] == 1.0).all()  # nothing is cut off at the rim
    root = ElementTree.parse(tmp_path / f"{name}.svg").getroot()
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert len(list(root.iter())) > 50
    assert dict(matplotlib.rcParams) == before


def test_same_picture_has_the_same_bytes(traces: list[Trace], tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        save(drawings(traces)["convergence"](), tmp_path / folder, "x")
    for name in ("x.png", "x.svg"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def texts(figure: Figure) -> str:
    found = [text.get_text() for ax in figure.axes for text in [*ax.texts, ax.xaxis.label, ax.yaxis.label, ax.title]]
    for ax in figure.axes:
        legend = ax.get_legend()
        found += [text.get_text() for text in legend.get_texts()] if legend else []
    return "\n".join(found)


def test_every_axis_has_its_unit(traces: list[Trace]) -> None:
    for name, draw in drawings(traces).items():
        for ax in draw().axes:
            for label in (ax.get_xlabel(), ax.get_ylabel()):
                if any(word in label for word in ("side", "torque", "x", "y", "z")) and "condition" not in label:
                    assert "(mm)" in label or "(N m)" in label, (name, label)


def test_front_draws_points_published_designs_and_what_is_impossible() -> None:
    main = curve(bounds=True)
    found = pictures.front(main, published_designs(main.given), None, "a task")
    quality = found.axes[0]
    drawn = np.array(quality.lines[0].get_xydata())
    assert drawn == pytest.approx(np.array([[2 * p.half_side, p.kappa] for p in main.points]))
    marks = [tuple(np.array(line.get_xydata())[0]) for line in quality.lines if len(np.array(line.get_xdata())) == 1]
    for design in published_designs(main.given):
        assert (2 * design.half_side, design.kappa) in marks
    said = texts(found)
    assert "proved impossible; front within 0.1 %" in said
    assert "design of the other pictures" not in said
    assert "everywhere: lean, outline" in said
    assert "limits.kappa_max = 2.27" in said
    assert "0.69 N m are left beside gravity's share: far above the picture" in said


def test_legend_of_the_front_covers_nothing_of_it() -> None:
    main = curve(bounds=True)
    figure = pictures.front(main, published_designs(main.given), main.points[-1], "a task")
    figure.draw_without_rendering()
    for ax in figure.axes[:2]:
        legend = ax.get_legend()
        assert legend is not None
        box = legend.get_window_extent()
        assert not any(box.overlaps(other.get_window_extent()) for other in figure.axes)
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert box.y1 <= figure.bbox.y1


def test_front_without_limits_proofs_or_published_designs_has_no_word_of_them() -> None:
    said = texts(pictures.front(curve(kappa_max=None), [], None, "a task"))
    assert "kappa_max" not in said
    assert "proved" not in said
    assert "published" not in said


def test_trade_tells_where_the_torque_binds_and_what_is_impossible(traces: list[Trace]) -> None:
    said = texts(drawings(traces)["trade"]())
    assert "torque 0.3 N m: binds from 60 mm on" in said
    assert pretty("R + L_A <= 100 mm: no design") in said
    assert "R + $L_A$ 122 mm, outline 238 x 206 mm" in said


def test_convergence_of_one_method_alone_is_drawn(traces: list[Trace]) -> None:
    said = texts(pictures.convergence([t for t in traces if t.method == "sqp"], 2.075, "a problem"))
    assert "SQP" in said
    assert "the paper's parameters" not in said
    assert "of 2 seeds" in said


def test_published_designs_are_the_papers_by_our_equations() -> None:
    found = published_designs(joystick())
    assert {design.run.table for design in found} == {7, 8, 10, 11, 12}
    first = next(design for design in found if design.run.table == 7)
    assert first.result.design_mm[:6] == (82.0, 116.5, 40.0, 39.2, 54.0, 37.7)
    assert first.active == ("kappa",)
    narrow = next(design for design in found if design.run.table == 10)
    assert narrow.active == ("clearance", "platform_radius 19.6 mm")
    assert narrow.half_side == 39.2


def test_condition_numbers_far_apart_are_drawn_on_a_logarithmic_scale() -> None:
    near = pictures.front(curve(), [], None, "a task").axes[0]
    assert near.get_yscale() == "linear"
    main = curve(kappa_max=None)
    steep = Result(at_side(joystick(), 42.0), "sqp", (82.0, 122.0, 40.0, 30.0, 40.0, 42.0), "converged")
    assert 20.0 < steep.max_kappa < math.inf
    wide = dataclasses.replace(main, points=(*main.points, FrontPoint(steep, ())))
    assert pictures.front(wide, [], None, "a task").axes[0].get_yscale() == "log"
    assert pictures.trade(Trade(wide), "a task").axes[0].get_yscale() == "log"
