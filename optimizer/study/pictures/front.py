"""The front: worst condition number and joint torque against the size of the cube, published designs beside it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from delta_cad.common.picture_style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION, YELLOW, styled
from optimizer.study.front import Curve, FrontPoint
from optimizer.study.pictures.style import kappa_scale, pretty
from optimizer.study.published import PublishedDesign

# Table of the paper -> how its designs are drawn: later tables repeat earlier designs, and are smaller on top.
MARKERS = {7: ("s", ORANGE, 8), 8: ("^", GREEN, 14), 10: ("D", PURPLE, 8), 11: ("v", SKY, 12), 12: ("P", VERMILLION, 6)}
BINDING = (SKY, ORANGE, GREEN, PURPLE, YELLOW, VERMILLION, GREY, BLUE)
# Around the design that the other pictures show.
RING: Any = {"marker": "o", "linestyle": "none", "markeredgecolor": BLACK, "markersize": 10}
NEAR_LIMIT = 1.5  # a limit up to so many times the largest value is drawn as a line, a farther one is written


@styled
def front(curve: Curve, published: Sequence[PublishedDesign], chosen: FrontPoint | None, title: str) -> Figure:
    """Draws it.

    Args:
        curve: The front.
        published: Designs to set beside it.
        chosen: The point that the other pictures show; None for another design.
        title: Name of the requirements.

    Returns:
        The figure, 9.6 x 8 inches.
    """
    figure = Figure(figsize=(9.6, 8.0), layout="constrained")
    figure.suptitle(pretty(title), fontsize=12)
    quality, binding, torque = figure.subplots(3, 1, sharex=True, height_ratios=(1.0, 0.09, 0.5))
    sides = [2.0 * point.half_side for point in curve.points]
    for ax, name in ((quality, "kappa"), (torque, "torque")):
        ax.plot(
            sides, [getattr(p, name) for p in curve.points], "-o", color=BLUE, markersize=3.2, linewidth=1.4, zorder=3
        )
        if chosen is not None:
            ax.plot(
                [2.0 * chosen.half_side], [getattr(chosen, name)], color="none", **RING, markeredgewidth=1.4, zorder=4
            )
        for design in published:
            _published(ax, design, name)
    kappa_scale(quality, [point.kappa for point in curve.points])
    limits, task = curve.given.limits, curve.given.requirements
    _limit(quality, limits.kappa_max, "limits.kappa_max = {:g}")
    _limit(torque, task.joint_torque_N_m - limits.gravity_torque_N_m, "{:g} N m are left beside gravity's share")
    _impossible(quality, curve)
    _binding(binding, curve.points)
    quality.set(ylabel="worst condition number in the cube")
    torque.set(ylabel=f"worst joint torque\nfor {task.force_N:g} N (N m)", xlabel="side of the cube, 2 L (mm)")
    # above the axes: a front may pass through any corner of them
    handles = _legend(curve, published, chosen)
    quality.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.01), ncols=3)
    return figure


def _published(ax: Axes, design: PublishedDesign, name: str) -> None:
    mark, colour, size = MARKERS[design.run.table]
    face, edge, width = ("white", colour, 1.4) if design.active else (colour, BLACK, 0.6)
    style = {"color": face, "markeredgecolor": edge, "markeredgewidth": width, "markersize": size}
    ax.plot([2.0 * design.half_side], [getattr(design, name)], mark, **style, zorder=5)


def _impossible(ax: Axes, curve: Curve) -> None:
    """Shades what is proved to be impossible; a bound holds for all larger cubes, as each holds every smaller one."""
    sides, bounds = [], []
    for point in curve.points:
        if point.bound is not None:
            sides.append(2.0 * point.half_side)
            bounds.append(max(point.bound, bounds[-1] if bounds else 0.0))
    if not sides:
        return
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    end = right if curve.largest_bound is None else min(right, 2.0 * curve.largest_bound)
    ax.fill_between([*sides, end], low, [*bounds, bounds[-1]], step="post", color=GREY, alpha=0.16, linewidth=0.0)
    if end < right:
        ax.axvspan(end, right, color=GREY, alpha=0.16, linewidth=0.0)
    ax.set(xlim=(left, right), ylim=(low, high))


def _limit(ax: Axes, limit: float | None, form: str) -> None:
    """Draws a limit as a line if it is near, and writes it if it is far above."""
    if limit is None:
        return
    low, high = ax.get_ylim()
    text = form.format(limit)
    if limit <= NEAR_LIMIT * high:
        ax.axhline(limit, color=BLACK, linewidth=1.0, linestyle=(0, (5, 2)))
        ax.set_ylim(low, max(high, limit + 0.05 * (limit - low)))
        beside = {"xycoords": ("axes fraction", "data"), "xytext": (0, -3), "textcoords": "offset points"}
        ax.annotate(text, (0.01, limit), **beside, va="top", fontsize=8.5)
    else:
        text = f"{text}: far above the picture"
        ax.text(0.995, 0.05, text, transform=ax.transAxes, ha="right", va="bottom", fontsize=8.5)


def _binding(ax: Axes, points: Sequence[FrontPoint]) -> None:
    """Draws a strip of the constraints that bind; what binds everywhere is left out."""
    always = set.intersection(*(set(p.active) for p in points)) if points else set()
    sets = [tuple(name for name in p.active if name not in always) for p in points]
    kinds = [kind for kind in dict.fromkeys(sets) if kind]
    sides = np.array([2.0 * p.half_side for p in points])
    edges = np.concatenate([sides[:1], (sides[1:] + sides[:-1]) / 2.0, sides[-1:]])
    for k, kind in enumerate(sets):
        if kind:
            ax.axvspan(edges[k], edges[k + 1], color=BINDING[kinds.index(kind) % len(BINDING)], linewidth=0.0)
    ax.set(yticks=[], ylim=(0.0, 1.0))
    ax.grid(False)
    ax.spines["left"].set_visible(False)
    ax.set_ylabel("binds", rotation=0, ha="right", va="center")
    handles = [Patch(color=c, label=pretty(" + ".join(kind))) for c, kind in zip(BINDING, kinds, strict=False)]
    if always:
        handles.append(Patch(color="none", label=pretty("everywhere: " + ", ".join(sorted(always)))))
    if handles:
        ax.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.25), ncols=2, handlelength=1.2)


def _legend(curve: Curve, published: Sequence[PublishedDesign], chosen: FrontPoint | None) -> list[Any]:
    label = f"front, {len(curve.points)} designs"
    handles: list[Any] = [Line2D([], [], color=BLUE, marker="o", markersize=3.2, linewidth=1.4, label=label)]
    gaps = [1.0 - point.bound / point.kappa for point in curve.points if point.bound is not None]
    if gaps:
        label = f"proved impossible; front within {100.0 * max(gaps):.2g} %"
        handles.append(Patch(color=GREY, alpha=0.16, linewidth=0.0, label=label))
    if chosen is not None:
        handles.append(Line2D([], [], color="none", **RING, label="design of the other pictures"))
    for table in sorted({design.run.table for design in published}):
        mark, colour, _ = MARKERS[table]
        methods = ", ".join(dict.fromkeys(design.run.method for design in published if design.run.table == table))
        label = f"published, table {table} ({methods})"
        style = {"markeredgecolor": BLACK, "markeredgewidth": 0.6, "linestyle": "none"}
        handles.append(Line2D([], [], color=colour, marker=mark, markersize=7.5, **style, label=label))
    if any(design.active for design in published):
        label = "white: misses a limit of the requirements"
        style = {"markeredgecolor": GREY, "markeredgewidth": 1.4, "linestyle": "none"}
        handles.append(Line2D([], [], color="white", marker="s", markersize=7.5, **style, label=label))
    return handles
