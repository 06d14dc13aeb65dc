"""The front as files: a table of all points, the facts as JSON, and a short page with the points that tell most."""

from __future__ import annotations

import csv
import importlib.metadata
import io
import json
from collections.abc import Sequence
from typing import Any

from optimizer.paper.page import markdown_table
from optimizer.problem.evaluator import VARIABLES
from optimizer.problem.requirements import requirements_hash
from optimizer.search.result import finite
from optimizer.study.convergence import Trace
from optimizer.study.front import Curve, FrontPoint
from optimizer.study.published import PublishedDesign
from optimizer.study.trade import Trade

# Columns of `front.csv`, and names of a point's numbers in `front.json`.
COLUMNS = (
    *("curve", "cube_side_mm", "half_side_mm", "max_kappa", "proven_bound", "max_torque_N_m"),
    *("outline_radius_mm", "outline_width_mm", "outline_depth_mm"),
    *(f"{name}_mm" for name in VARIABLES[:5]),
    "active",
)
TABLE = ("what", "side mm", "kappa", "torque N m", "L_A", "L_B", "R", "r", "H mm", "binds")
FRONTS = (
    *("front", "what changes", "points", "largest side mm", "proved: none above mm", "kappa there"),
    *("kappa proved within", "torque N m", "outline mm", "torque binds from mm", "too much together 1 % beyond"),
)
PUBLISHED = ("table, row", "method", "side mm", "kappa", "front's kappa", "torque N m", "misses")


def row(curve: str, point: FrontPoint) -> dict[str, Any]:
    """Gathers one point as plain data under the names of `COLUMNS`."""
    sides, sizes = (2.0 * point.half_side, point.half_side), (point.reach, *point.outline)
    worst = (point.kappa, point.bound, point.torque)
    numbers = (*sides, *worst, *sizes, *point.result.design_mm[:5])
    return dict(zip(COLUMNS, (curve, *numbers, list(point.active)), strict=True))


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
                **{f"{name}_mm": value for name, value in zip(VARIABLES, design.result.design_mm, strict=True)},
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


def files(facts: dict[str, Any], text: str) -> dict[str, str]:
    """Writes the files of a front without its pictures: name -> content.

    Args:
        facts: What `record` gives.
        text: The page.
    """
    lines = [point | {"active": "; ".join(point["active"])} for curve in facts["curves"] for point in curve["points"]]
    table = io.StringIO()
    writer = csv.DictWriter(table, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    json_text = json.dumps(facts, indent=1, allow_nan=False) + "\n"
    return {"front.csv": table.getvalue(), "front.json": json_text, "front.md": text}


def page(trade: Trade, published: Sequence[PublishedDesign], pictures: Sequence[tuple[str, str]]) -> str:
    """Writes the page as Markdown.

    Args:
        trade: The fronts.
        published: Designs beside them.
        pictures: Name of each picture's file and what it shows.
    """
    main, given = trade.main, trade.main.given
    parts = [f"# {given.name}: cube, conditioning, torque, outline"]
    if not trade.finished:
        parts.append("**Interrupted: what follows is as far as the run came.**")
    task, limits = given.requirements, given.limits
    left = task.joint_torque_N_m - limits.gravity_torque_N_m
    parts += [
        f"No design has a larger cube and a smaller kappa than one of a front. {left:.4g} N m of each joint are there "
        f"for {task.force_N:g} N; gravity's share is taken off.",
        markdown_table(FRONTS, [_front(curve) for curve in trade.curves]),
        markdown_table(TABLE, [_cells(what, point) for what, point in notable_points(trade)]),
    ]
    if published:
        table = markdown_table(PUBLISHED, [_beside(main, design) for design in published])
        parts += ["## Published designs by our equations", table]
    return "\n\n".join([*parts, *(f"![{what}]({name})" for name, what in pictures)]) + "\n"


def _cells(what: str, point: FrontPoint) -> list[str]:
    numbers = (2.0 * point.half_side, point.kappa, point.torque, *point.result.design_mm[:5])
    return [what, *(f"{value:.4g}" for value in numbers), ", ".join(point.active) or "nothing"]


def _front(curve: Curve) -> list[str]:
    """Lists what a front comes to; what is not known, or not proved, is left empty."""
    beyond, points = " and ".join(curve.beyond), curve.points
    if not points:
        return [curve.name, curve.words, "0", *[""] * 7, beyond]
    last = points[-1]
    width, depth = last.outline
    most = "" if curve.largest_bound is None else f"{2.0 * curve.largest_bound:.6g}"
    gap = max((1.0 - point.bound / point.kappa for point in points if point.bound is not None), default=None)
    binds = next((f"{2.0 * point.half_side:.4g}" for point in points if "torque" in point.active), "")
    return [
        *(curve.name, curve.words, str(len(points)), f"{2.0 * last.half_side:.4g}", most, f"{last.kappa:.4g}"),
        *("" if gap is None else f"{100.0 * gap:.2g} %", f"{last.torque:.4g}", f"{width:.0f} x {depth:.0f}"),
        *(binds, beyond),
    ]


def _beside(main: Curve, design: PublishedDesign) -> list[str]:
    own = main.kappa_at(design.half_side)
    return [
        f"{design.run.table}, {design.run.row}",
        design.run.method,
        f"{2 * design.half_side:.4g}",
        f"{design.kappa:.4g}",
        "beyond the front" if own is None else f"{own:.4g}",
        f"{design.torque:.4g}",
        ", ".join(design.active) or "nothing",
    ]
