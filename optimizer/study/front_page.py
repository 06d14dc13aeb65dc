"""The front as files: the record as JSON, a table of all points, and a short page with the points that tell most."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from optimizer.paper.page import markdown_table
from optimizer.problem.requirements import requirements_hash
from optimizer.problem.variables import LENGTHS, PLACEMENT, named
from optimizer.search.result import finite
from optimizer.study.convergence import Trace
from optimizer.study.front import FrontPoint, PublishedDesign
from optimizer.study.table import csv_text, json_text
from optimizer.study.trade import Trade

_LENGTHS = tuple(f"{name}_mm" for name in LENGTHS[:5])
# Columns of `front.csv`, and names of a point's numbers in `front.json`.
COLUMNS = (
    *("curve", "cube_side_mm", "half_side_mm", "max_kappa", "proven_bound", "max_torque_N_m"),
    *("outline_radius_mm", "outline_width_mm", "outline_depth_mm", *_LENGTHS, "active"),
)
_SHOWN = ("cube_side_mm", "max_kappa", "max_torque_N_m", *_LENGTHS)
_TABLE = ("what", "side mm", "kappa", "torque N m", "L_A", "L_B", "R", "r", "H mm", "binds")
_FRONTS = (
    *("front", "what changes", "points", "largest side mm", "proved: none above mm", "kappa there"),
    *("kappa proved within", "torque N m", "outline mm", "torque binds from mm", "too much together 1 % beyond"),
)
_PUBLISHED = ("table, row", "method", "side mm", "kappa", "front's kappa", "torque N m", "misses")
_Row = Mapping[str, Any]


def row(curve: str, point: FrontPoint) -> dict[str, Any]:
    """Gathers one point as plain data under the names of `COLUMNS`."""
    sides, sizes = (2.0 * point.half_side, point.half_side), (point.reach, *point.outline)
    worst = (point.kappa, point.bound, point.torque)
    variables = named(point.result.design_mm)
    numbers = (*sides, *worst, *sizes, *(variables[name] for name in _LENGTHS))
    placed = {name: variables[name] for name in PLACEMENT if name in variables}
    return dict(zip(COLUMNS, (curve, *numbers, list(point.active)), strict=True)) | placed


def notable_points(trade: Trade) -> list[tuple[str, FrontPoint]]:
    """Selects the points that say most: ends, knee, the requirements' cube, changes of what binds."""
    points, wanted = trade.main.points, trade.main.given.step_3.half_side_mm
    chosen: list[tuple[str, FrontPoint]] = []
    for k, point in enumerate(points):
        reasons = {
            "smallest": k == 0,
            "other limits bind from here": k > 0 and set(point.active) != set(points[k - 1].active),
            "knee": point is trade.knee,
            "the requirements' cube": point.half_side == wanted,
            "largest": k == len(points) - 1,
        }
        if reason := ", ".join(what for what, holds in reasons.items() if holds):
            chosen.append((reason, point))
    return chosen


def record(trade: Trade, seed: int, published: Sequence[PublishedDesign], traces: Sequence[Trace]) -> dict[str, Any]:
    """Gathers all facts as plain data for JSON."""
    given = trade.main.given
    return {
        "name": given.name,
        "requirements_sha256": requirements_hash(given),
        "version": importlib.metadata.version("delta-haptics"),
        "seed": seed,
        "status": "finished" if trade.finished else "interrupted",
        "torque_needed_N_m": finite(trade.torque_needed),
        "torque_available_N_m": given.requirements.joint_torque_N_m - given.limits.gravity_torque_N_m,
        "curves": [
            {
                "name": curve.name,
                "words": curve.words,
                "largest_half_side_mm": finite(curve.largest),
                "proven_half_side_mm": curve.largest_bound,
                "beyond": list(curve.beyond),
                "finished": curve.finished,
                "points": [row(curve.name, point) for point in curve.points],
            }
            for curve in trade.curves
        ],
        "telling": [{"what": what, "half_side_mm": point.half_side} for what, point in notable_points(trade)],
        "published": [
            {
                **{name: getattr(design.run, name) for name in ("table", "row", "method")},
                **named(design.result.design_mm),
                "max_kappa": finite(design.kappa),
                "max_torque_N_m": finite(design.torque),
                "misses": list(design.active),
            }
            for design in published
        ],
        "convergence": [
            {
                "method": trace.method,
                "seed": trace.seed,
                "evaluations": list(trace.evaluations),
                "max_kappa": [finite(value) for value in trace.best],
            }
            for trace in traces
        ],
    }


def files(facts: _Row, text: str) -> dict[str, str]:
    """Writes the files of a front without its pictures: name -> content."""
    points = [point for curve in facts["curves"] for point in curve["points"]]
    columns = (*COLUMNS, *(name for name in PLACEMENT if any(name in point for point in points)))
    return {"front.csv": csv_text(columns, points), "front.json": json_text(facts), "front.md": text}


def page(facts: _Row, force_N: float, pictures: Sequence[tuple[str, str]]) -> str:
    """Writes the page as Markdown.

    Args:
        facts: What `record` gives.
        force_N: Force that the torques are for.
        pictures: Name of each picture's file and what it shows.
    """
    parts = [f"# {facts['name']}: cube, conditioning, torque, outline"]
    if facts["status"] == "interrupted":
        parts.append("**Interrupted: what follows is as far as the run came.**")
    parts += [
        f"No design has a larger cube and a smaller kappa than one of a front. {facts['torque_available_N_m']:.4g} N m "
        f"of each joint are there for {force_N:g} N; gravity's share is taken off.",
        markdown_table(_FRONTS, [_front_cells(curve) for curve in facts["curves"]]),
        markdown_table(_TABLE, [[what, *_cells(_SHOWN, point, "active")] for what, point in _notable(facts)]),
    ]
    if facts["published"]:
        cells = [_published_cells(facts["curves"][0]["points"], design) for design in facts["published"]]
        parts += ["## Published designs by our equations", markdown_table(_PUBLISHED, cells)]
    return "\n\n".join([*parts, *(f"![{what}]({name})" for name, what in pictures)]) + "\n"


def summary(facts: _Row) -> list[str]:
    """Gives the lines that a person reads in the terminal."""
    beyond = " and ".join(facts["curves"][0]["beyond"]) or "not found"
    lines = [f"{what}: {described(point)}" for what, point in _notable(facts)]
    return [*lines, f"1 % beyond the largest contradict each other: {beyond}"]


def described(point: _Row) -> str:
    """Describes a row of a front in one line."""
    binds = f"; binds: {', '.join(point['active'])}" if point["active"] else ""
    side, kappa, torque = (point[name] for name in _SHOWN[:3])
    return f"cube of {side:.4g} mm, worst kappa {kappa:.4g}, torque {torque:.4g} N m{binds}"


def _notable(facts: _Row) -> list[tuple[str, _Row]]:
    points = {point["half_side_mm"]: point for point in facts["curves"][0]["points"]}
    return [(one["what"], points[one["half_side_mm"]]) for one in facts["telling"]]


def _cells(names: Sequence[str], point: _Row, last: str) -> list[str]:
    return [*(f"{point[name]:.4g}" for name in names), ", ".join(point[last]) or "nothing"]


def _front_cells(curve: _Row) -> list[str]:
    """Lists what a front comes to; what is not known, or not proved, is left empty."""
    beyond, points = " and ".join(curve["beyond"]), curve["points"]
    if not points:
        return [curve["name"], curve["words"], "0", *[""] * 7, beyond]
    last, proven = points[-1], curve["proven_half_side_mm"]
    most = "" if proven is None else f"{2.0 * proven:.6g}"
    gap = max((1.0 - p["proven_bound"] / p["max_kappa"] for p in points if p["proven_bound"] is not None), default=None)
    binds = next((f"{point['cube_side_mm']:.4g}" for point in points if "torque" in point["active"]), "")
    side, kappa, torque = (f"{last[name]:.4g}" for name in _SHOWN[:3])
    return [
        *(curve["name"], curve["words"], str(len(points)), side, most, kappa),
        *("" if gap is None else f"{100.0 * gap:.2g} %", torque),
        *(f"{last['outline_width_mm']:.0f} x {last['outline_depth_mm']:.0f}", binds, beyond),
    ]


def _published_cells(points: Sequence[_Row], design: _Row) -> list[str]:
    """Lists a published design beside the front's kappa at its cube, on the line between two points."""
    side = design["half_side_mm"]
    sides, kappas = ([point[name] for point in points] for name in ("half_side_mm", "max_kappa"))
    on_front = bool(points) and sides[0] <= side <= sides[-1]
    own = f"{np.interp(side, sides, kappas):.4g}" if on_front else "beyond the front"
    worst = {
        "cube_side_mm": 2 * side,
        **{name: np.nan if design[name] is None else design[name] for name in _SHOWN[1:3]},
    }
    size, kappa, torque, misses = _cells(_SHOWN[:3], worst | {"misses": design["misses"]}, "misses")
    return [f"{design['table']}, {design['row']}", design["method"], size, kappa, own, torque, misses]
