"""The front as files: a table of all points, the facts as JSON, and a short page with the points that tell most."""

from __future__ import annotations

import csv
import importlib.metadata
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from optimizer.front.convergence import Trace
from optimizer.front.front import Curve, Point
from optimizer.front.limits import BEYOND
from optimizer.front.published import Published
from optimizer.front.trade import Trade
from optimizer.problem.evaluator import VARIABLES
from optimizer.problem.requirements import requirements_hash

COLUMNS = (
    "curve",
    "cube_side_mm",
    "half_side_mm",
    "max_kappa",
    "proven_bound",
    "max_torque_N_m",
    "outline_radius_mm",
    "outline_width_mm",
    "outline_depth_mm",
    *(f"{name}_mm" for name in VARIABLES[:5]),
    "active",
)
"""Of `front.csv`; `active` is joined by "; "."""
TABLE = ("what", "side mm", "kappa", "torque N m", "L_A", "L_B", "R", "r", "H mm", "binds")


def row(curve: str, point: Point) -> dict[str, Any]:
    """One point under the names of `COLUMNS`, `active` as a list."""
    width, depth = point.outline
    return {
        "curve": curve,
        "cube_side_mm": 2.0 * point.half_side,
        "half_side_mm": point.half_side,
        "max_kappa": point.kappa,
        "proven_bound": point.bound,
        "max_torque_N_m": point.torque,
        "outline_radius_mm": point.reach,
        "outline_width_mm": width,
        "outline_depth_mm": depth,
        **{f"{name}_mm": value for name, value in zip(VARIABLES[:5], point.result.design_mm, strict=False)},
        "active": list(point.active),
    }


def telling(trade: Trade) -> list[tuple[str, Point]]:
    """The points of the front as required that tell most: ends, knee, the requirements' cube, changes of what binds."""
    points, wanted = trade.main.points, trade.main.given.step_3.half_side_mm
    found: list[tuple[str, Point]] = []
    for k, point in enumerate(points):
        words = []
        if k == 0:
            words.append("smallest")
        elif set(point.active) != set(points[k - 1].active):
            words.append("other limits bind from here")
        if point is trade.knee:
            words.append("knee")
        if point.half_side == wanted:
            words.append("the requirements' cube")
        if k == len(points) - 1:
            words.append("largest")
        if words:
            found.append((", ".join(words), point))
    return found


def record(trade: Trade, seed: int, published: Sequence[Published], traces: Sequence[Trace]) -> dict[str, Any]:
    """All facts as plain data for JSON."""
    given = trade.main.given
    return {
        "name": given.name,
        "requirements_sha256": requirements_hash(given),
        "version": importlib.metadata.version("delta-haptics"),
        "seed": seed,
        "status": "finished" if trade.finished else "interrupted",
        "torque_needed_N_m": _finite(trade.torque_needed),
        "torque_available_N_m": given.requirements.joint_torque_N_m - given.limits.gravity_torque_N_m,
        "curves": [_curve(curve) for curve in trade.curves],
        "telling": [{"what": what, "half_side_mm": point.half_side} for what, point in telling(trade)],
        "published": [
            {
                "table": found.table,
                "row": found.row,
                "method": found.method,
                **{f"{name}_mm": value for name, value in zip(VARIABLES, found.design_mm, strict=True)},
                "max_kappa": _finite(found.kappa),
                "max_torque_N_m": _finite(found.torque),
                "misses": list(found.misses),
            }
            for found in published
        ],
        "convergence": [
            {
                "method": trace.method,
                "seed": trace.seed,
                "evaluations": list(trace.evaluations),
                "max_kappa": [_finite(value) for value in trace.best],
            }
            for trace in traces
        ],
    }


def write_csv(trade: Trade, path: Path) -> None:
    """Every point of every front, a line each, numbers with all their digits."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        for curve in trade.curves:
            for point in curve.points:
                line = row(curve.name, point)
                writer.writerow(line | {"active": "; ".join(line["active"])})


def write_facts(facts: dict[str, Any], path: Path) -> None:
    """The facts as JSON."""
    path.write_text(json.dumps(facts, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def page(trade: Trade, published: Sequence[Published], pictures: Sequence[tuple[str, str]]) -> str:
    """The page as Markdown.

    Args:
        trade: The fronts.
        published: Designs beside them.
        pictures: Name of each picture's file and what it shows.
    """
    main, given = trade.main, trade.main.given
    force = given.requirements.force_N
    left = given.requirements.joint_torque_N_m - given.limits.gravity_torque_N_m
    lines = [f"# {given.name}: cube, conditioning, torque, outline", ""]
    if not trade.finished:
        lines += ["**Interrupted: what follows is as far as the run came.**", ""]
    if main.points:
        low, high = main.points[0], main.points[-1]
        lines += [
            f"{len(main.points)} designs from a cube of {2 * low.half_side:.4g} mm with worst kappa {low.kappa:.4g} "
            f"to one of {2 * high.half_side:.4g} mm with {high.kappa:.4g}. None has a larger cube and a smaller kappa.",
            "",
            _beyond(main),
            f"Torque for {force:g} N: at most {trade.torque_needed:.4g} N m on the front, {left:.4g} N m are left "
            f"beside gravity's share; the limit binds {_binding(main, 'torque')}.",
            "",
            *_table(TABLE, [_cells(what, point) for what, point in telling(trade)]),
            "",
        ]
    further = [*trade.outlines, *trade.torques]
    if further:
        lines += ["## With other requirements", ""]
        lines += _table(
            ("front", "what changes", "largest side mm", "kappa there", "torque N m", "outline mm", "torque binds"),
            [_further(curve) for curve in further],
        )
        lines += [""]
    lines += _proofs(main)
    if published:
        lines += ["## Published designs by our equations", ""]
        lines += _table(
            ("table, row", "method", "side mm", "kappa", "front's kappa", "torque N m", "misses"),
            [_beside(main, found) for found in published],
        )
        lines += [""]
    lines += [f"![{what}]({name})\n" for name, what in pictures]
    return "\n".join(lines).rstrip() + "\n"


def _proofs(curve: Curve) -> list[str]:
    """What was proved, as a paragraph."""
    gaps = [1.0 - point.bound / point.kappa for point in curve.points if point.bound is not None]
    if not gaps:
        return []
    lines = [
        "## Proven",
        "",
        f"For {len(gaps)} of the {len(curve.points)} points it is proved, over every design within the requirements "
        f"and not by sampling, how much smaller a worst kappa could be with the same cube: {_percent(max(gaps))} at "
        f"most, {_percent(sorted(gaps)[len(gaps) // 2])} in the median.",
    ]
    if curve.largest_bound is not None:
        more = _percent(curve.largest_bound / curve.largest - 1.0)
        lines[-1] += f" No cube has a side above {2.0 * curve.largest_bound:.6g} mm, {more} more than the largest here."
    return [*lines, ""]


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"


def _curve(curve: Curve) -> dict[str, Any]:
    return {
        "name": curve.name,
        "words": curve.words,
        "largest_half_side_mm": _finite(curve.largest),
        "proven_half_side_mm": curve.largest_bound,
        "beyond": list(curve.beyond),
        "finished": curve.finished,
        "points": [row(curve.name, point) for point in curve.points],
    }


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


def _cells(what: str, point: Point) -> tuple[str, ...]:
    L_A, L_B, R, r, H = point.result.design_mm[:5]
    lengths = (f"{value:.4g}" for value in (L_A, L_B, R, r, H))
    binds = ", ".join(point.active) or "nothing"
    return (what, f"{2 * point.half_side:.4g}", f"{point.kappa:.4g}", f"{point.torque:.4g}", *lengths, binds)


def _further(curve: Curve) -> tuple[str, ...]:
    if not curve.points:
        return (curve.name, curve.words, "none", f"impossible: {' and '.join(curve.beyond)}", "", "", "")
    last = curve.points[-1]
    width, depth = last.outline
    return (
        curve.name,
        curve.words,
        f"{2 * last.half_side:.4g}",
        f"{last.kappa:.4g}",
        f"{last.torque:.4g}",
        f"{width:.0f} x {depth:.0f}",
        _binding(curve, "torque"),
    )


def _beside(main: Curve, found: Published) -> tuple[str, ...]:
    own = main.kappa_at(found.half_side)
    return (
        f"{found.table}, {found.row}",
        found.method,
        f"{2 * found.half_side:.4g}",
        f"{found.kappa:.4g}",
        "beyond the front" if own is None else f"{own:.4g}",
        f"{found.torque:.4g}",
        ", ".join(found.misses) or "nothing",
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows)]


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
