"""The front as files: a table of all points, the facts as JSON, and a short page with the points that tell most."""

from __future__ import annotations

import csv
import importlib.metadata
import io
import json
from collections.abc import Sequence
from typing import Any

from optimizer.front.convergence import Trace
from optimizer.front.front import Curve, FrontPoint
from optimizer.front.limits import BEYOND
from optimizer.front.published import PublishedDesign
from optimizer.front.trade import Trade
from optimizer.paper.page import markdown_table
from optimizer.problem.evaluator import VARIABLES
from optimizer.problem.requirements import requirements_hash
from optimizer.search.result import finite

# Columns of `front.csv`, and names of a point's numbers in `front.json`.
COLUMNS = (
    *("curve", "cube_side_mm", "half_side_mm", "max_kappa", "proven_bound", "max_torque_N_m"),
    *("outline_radius_mm", "outline_width_mm", "outline_depth_mm"),
    *(f"{name}_mm" for name in VARIABLES[:5]),
    "active",
)
TABLE = ("what", "side mm", "kappa", "torque N m", "L_A", "L_B", "R", "r", "H mm", "binds")
FURTHER = ("front", "what changes", "largest side mm", "kappa there", "torque N m", "outline mm", "torque binds")
PUBLISHED = ("table, row", "method", "side mm", "kappa", "front's kappa", "torque N m", "misses")


def row(curve: str, point: FrontPoint) -> dict[str, Any]:
    """Gathers one point as plain data under the names of `COLUMNS`."""
    sides, sizes = (2.0 * point.half_side, point.half_side), (point.reach, *point.outline)
    worst = (point.kappa, point.bound, point.torque)
    numbers = (*sides, *worst, *sizes, *point.result.design_mm[:5])
    return dict(zip(COLUMNS, (curve, *numbers, list(point.active)), strict=True))


def telling(trade: Trade) -> list[tuple[str, FrontPoint]]:
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
        "telling": [{"what": what, "half_side_mm": point.half_side} for what, point in telling(trade)],
        "published": [
            {
                "table": design.table,
                "row": design.row,
                "method": design.method,
                **{f"{name}_mm": value for name, value in zip(VARIABLES, design.design_mm, strict=True)},
                "max_kappa": finite(design.kappa),
                "max_torque_N_m": finite(design.torque),
                "misses": list(design.misses),
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
    if main.points:
        low, high = main.points[0], main.points[-1]
        left = given.requirements.joint_torque_N_m - given.limits.gravity_torque_N_m
        parts += [
            f"{len(main.points)} designs from a cube of {2 * low.half_side:.4g} mm with worst kappa {low.kappa:.4g} "
            f"to one of {2 * high.half_side:.4g} mm with {high.kappa:.4g}. None has a larger cube and a smaller kappa.",
            _beyond(main),
            f"Torque for {given.requirements.force_N:g} N: at most {trade.torque_needed:.4g} N m on the front, "
            f"{left:.4g} N m are left beside gravity's share; the limit binds {_binding(main, 'torque')}.",
            markdown_table(TABLE, [_cells(what, point) for what, point in telling(trade)]),
        ]
    if further := trade.curves[1:]:
        parts += ["## With other requirements", markdown_table(FURTHER, [_further(curve) for curve in further])]
    if gaps := [1.0 - point.bound / point.kappa for point in main.points if point.bound is not None]:
        parts += ["## Proven", _proven(main, gaps)]
    if published:
        table = markdown_table(PUBLISHED, [_beside(main, design) for design in published])
        parts += ["## Published designs by our equations", table]
    return "\n\n".join([*parts, *(f"![{what}]({name})" for name, what in pictures)]) + "\n"


def _proven(curve: Curve, gaps: list[float]) -> str:
    largest, median = (f"{100.0 * gap:.2g} %" for gap in (max(gaps), sorted(gaps)[len(gaps) // 2]))
    text = (
        f"For {len(gaps)} of the {len(curve.points)} points it is proved, over every design within the requirements "
        f"and not by sampling, how much smaller a worst kappa could be with the same cube: {largest} at most, {median} "
        "in the median."
    )
    if curve.largest_bound is not None:
        more = 100.0 * (curve.largest_bound / curve.largest - 1.0)
        text += (
            f" No cube has a side above {2.0 * curve.largest_bound:.6g} mm, {more:.2g} % more than the largest here."
        )
    return text


def _beyond(curve: Curve) -> str:
    if not curve.beyond:
        return "What limits the cube was not found: no set of constraints was shown to contradict a cube 1 % larger."
    proved = curve.largest_bound is not None and curve.largest_bound < (1.0 + BEYOND) * curve.largest
    return (
        f"At the largest cube bind: {', '.join(curve.points[-1].active) or 'nothing'}. For a cube {100.0 * BEYOND:g} % "
        f"larger these are already too much together{' by search' if len(curve.beyond) > 1 else ''}: "
        f"{'; '.join(curve.beyond)}. What binds and is not among them gives less than that, even if it is left out"
        + ("; that no design within all requirements has such a cube is proved." if proved else ".")
    )


def _binding(curve: Curve, name: str) -> str:
    sides = [2.0 * point.half_side for point in curve.points if name in point.active]
    return f"from {sides[0]:.4g} to {sides[-1]:.4g} mm" if sides else "nowhere"


def _cells(what: str, point: FrontPoint) -> list[str]:
    numbers = (2.0 * point.half_side, point.kappa, point.torque, *point.result.design_mm[:5])
    return [what, *(f"{value:.4g}" for value in numbers), ", ".join(point.active) or "nothing"]


def _further(curve: Curve) -> list[str]:
    if not curve.points:
        return [curve.name, curve.words, "none", f"impossible: {' and '.join(curve.beyond)}", "", "", ""]
    last = curve.points[-1]
    numbers = [f"{value:.4g}" for value in (2.0 * last.half_side, last.kappa, last.torque)]
    width, depth = last.outline
    return [curve.name, curve.words, *numbers, f"{width:.0f} x {depth:.0f}", _binding(curve, "torque")]


def _beside(main: Curve, design: PublishedDesign) -> list[str]:
    own = main.kappa_at(design.half_side)
    return [
        f"{design.table}, {design.row}",
        design.method,
        f"{2 * design.half_side:.4g}",
        f"{design.kappa:.4g}",
        "beyond the front" if own is None else f"{own:.4g}",
        f"{design.torque:.4g}",
        ", ".join(design.misses) or "nothing",
    ]
