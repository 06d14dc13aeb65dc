"""Pictures of studies and designs: data in, figure out. Importing this module loads matplotlib."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.ticker import FuncFormatter, MultipleLocator, NullFormatter
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from delta_cad.common.picture_style import (
    BLACK,
    BLUE,
    DPI,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RC,
    SKY,
    VERMILLION,
    YELLOW,
    styled,
)
from delta_cad.common.units import MM_PER_M as MM
from delta_cad.mechanism import DeltaGeometry, closure_margin
from delta_cad.mechanism.statics import direct_margin
from delta_cad.mechanism.workspace import Cube
from optimizer.study.atlas import objective_column
from optimizer.study.convergence import Trace, band
from optimizer.study.front import Curve, FrontPoint, PublishedDesign
from optimizer.study.grid import AtlasRow, Axis, Grid
from optimizer.study.maps import Slice
from optimizer.study.reachable import contours_at_height, contours_in_mirror_plane, shell
from optimizer.study.trade import Trade

_WIDE = 10.0
# Table of the paper -> how its designs are drawn: later tables repeat earlier designs, and are smaller on top.
_MARKERS = {
    7: ("s", ORANGE, 8),
    8: ("^", GREEN, 14),
    10: ("D", PURPLE, 8),
    11: ("v", SKY, 12),
    12: ("P", VERMILLION, 6),
}
_BINDING = (SKY, ORANGE, GREEN, PURPLE, YELLOW, VERMILLION, GREY, BLUE)
# Around the design that the other pictures show.
_RING: Any = {"marker": "o", "linestyle": "none", "markeredgecolor": BLACK, "markersize": 10}
_NEAR_LIMIT = 1.5  # a limit up to so many times the largest value is drawn as a line, a farther one is written
_STYLES = ((GREEN, (0, (1, 1)), "s"), (VERMILLION, (0, (5, 1.5)), "D"))
_METHODS = (
    ("ga", "GA, the paper's parameters", BLUE, "-"),
    ("sqp", "SQP, starts one after the other", VERMILLION, (0, (5, 1.5))),
)
_TALL = 0.25  # height of the left picture at most, as a part of the optimum
_ZOOM = 0.005  # height of the right picture over the optimum, as a part of the optimum
_ROOM = 0.08  # below the lowest line, as a part of the picture's height
_POINTS = 400
_FAR = 100.0  # this many times the optimum stands for infinite, outside the picture
_VIEW = (22.0, -62.0)  # elevation and azimuth of the eye, degrees
_CUT_AWAY = 75.0  # half the angle of the sector that is left out towards the eye, degrees
GRID = 401  # points along an edge of the section's raster, for its fill and the singular line
_SHELL_ALPHA = 0.28
_SAME = 1e-6  # part by which two worst values may differ and still both be the worst of all: an optimum has several
_LEVELS = 9  # contour lines inside the range
_CELLS_MAX = 150  # cells up to which each shows its number
_TITLES = {
    "half_side": "largest half side, mm",
    "kappa": "smallest worst condition number",
    "cube_side": "largest cube, mm",
    "outline": "least width of the outline, mm",
    "effective_mass": "least effective mass, kg",
    "cost": "least price, EUR by estimate",
}
_LARGE = "half_side_mm", "cube_side_mm"  # what is the better the larger it is: ends of columns
_COLOURS = ("viridis_r", "viridis")  # bright is good: a large cube, a small condition number
_SPAN_MIN = 1e-3  # share of a value by which the colours of a map differ at least: roundings are not painted
TICKS = 12  # labels of an axis at most


def pretty(text: str) -> str:
    """Sets text with the paper's indices and signs as they are set in print."""
    return (
        text.replace("L_A", "$L_A$")
        .replace("L_B", "$L_B$")
        .replace(">=", "\N{GREATER-THAN OR EQUAL TO}")
        .replace("<=", "\N{LESS-THAN OR EQUAL TO}")
    )


def _figure(width: float, height: float, title: str) -> Figure:
    """Begins a figure of a size in inches."""
    figure = Figure(figsize=(width, height), layout="constrained")
    figure.suptitle(pretty(title), fontsize=12)
    return figure


def _kappa_scale(ax: Axes, kappas: Sequence[float]) -> None:
    """Sets a logarithmic scale with plain numbers where condition numbers differ by more than `_WIDE`."""
    if max(kappas) > _WIDE * min(kappas):
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter("{x:g}")


def png(figure: Figure) -> bytes:
    """Gives a figure as PNG at 150 dpi."""
    picture = io.BytesIO()
    with rc_context(RC):
        figure.savefig(picture, format="png", dpi=DPI, metadata={"Software": None})
    return picture.getvalue()


def save(figure: Figure, folder: Path, name: str) -> None:
    """Writes a figure as PNG and as SVG, under a name without ending."""
    (folder / f"{name}.png").write_bytes(png(figure))
    with rc_context(RC):
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None, "Creator": None})


@styled
def front(curve: Curve, published: Sequence[PublishedDesign], chosen: FrontPoint | None, title: str) -> Figure:
    """Draws a front, designs beside it, and the chosen point, which the other pictures show; None for another design.

    Returns:
        The figure, 9.6 x 8 inches.
    """
    figure = _figure(9.6, 8.0, title)
    quality, binding, torque = figure.subplots(3, 1, sharex=True, height_ratios=(1.0, 0.09, 0.5))
    sides = [2.0 * point.half_side for point in curve.points]
    for ax, name in ((quality, "kappa"), (torque, "torque")):
        ax.plot(
            sides, [getattr(p, name) for p in curve.points], "-o", color=BLUE, markersize=3.2, linewidth=1.4, zorder=3
        )
        if chosen is not None:
            ax.plot(
                [2.0 * chosen.half_side], [getattr(chosen, name)], color="none", **_RING, markeredgewidth=1.4, zorder=4
            )
        for design in published:
            _published(ax, design, name)
    _kappa_scale(quality, [point.kappa for point in curve.points])
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
    mark, colour, size = _MARKERS[design.run.table]
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
    if limit <= _NEAR_LIMIT * high:
        ax.axhline(limit, color=BLACK, linewidth=1.0, linestyle=(0, (5, 2)))
        ax.set_ylim(low, max(high, limit + 0.05 * (limit - low)))
        adjacent = {"xycoords": ("axes fraction", "data"), "xytext": (0, -3), "textcoords": "offset points"}
        ax.annotate(text, (0.01, limit), **adjacent, va="top", fontsize=8.5)
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
            ax.axvspan(edges[k], edges[k + 1], color=_BINDING[kinds.index(kind) % len(_BINDING)], linewidth=0.0)
    ax.set(yticks=[], ylim=(0.0, 1.0))
    ax.grid(False)
    ax.spines["left"].set_visible(False)
    ax.set_ylabel("binds", rotation=0, ha="right", va="center")
    handles = [Patch(color=c, label=pretty(" + ".join(kind))) for c, kind in zip(_BINDING, kinds, strict=False)]
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
        handles.append(Line2D([], [], color="none", **_RING, label="design of the other pictures"))
    for table in sorted({design.run.table for design in published}):
        mark, colour, _ = _MARKERS[table]
        methods = ", ".join(dict.fromkeys(design.run.method for design in published if design.run.table == table))
        label = f"published, table {table} ({methods})"
        style = {"markeredgecolor": BLACK, "markeredgewidth": 0.6, "linestyle": "none"}
        handles.append(Line2D([], [], color=colour, marker=mark, markersize=7.5, **style, label=label))
    if any(design.active for design in published):
        label = "white: misses a limit of the requirements"
        style = {"markeredgecolor": GREY, "markeredgewidth": 1.4, "linestyle": "none"}
        handles.append(Line2D([], [], color="white", marker="s", markersize=7.5, **style, label=label))
    return handles


@styled
def trade(fronts: Trade, title: str) -> Figure:
    """Draws both families over the front as required, one picture each.

    Returns:
        The figure, 11 x 5 inches.
    """
    figure = _figure(11.0, 5.4, title)
    left, right = figure.subplots(1, 2, sharey=True)
    width, depth = fronts.main.points[-1].outline
    reach = fronts.main.points[-1].reach
    _family(
        left, fronts.main, fronts.outlines, f"as required: R + L_A {reach:.4g} mm, outline {width:.0f} x {depth:.0f} mm"
    )
    left.set(title="other outlines", ylabel="worst condition number in the cube")
    _family(right, fronts.main, fronts.torques, f"as required; it needs up to {fronts.torque_needed:.3f} N m")
    right.set(title="less torque for the force")
    _kappa_scale(left, [point.kappa for curve in fronts.curves for point in curve.points])
    return figure


def _family(ax: Axes, main: Curve, others: Sequence[Curve], label: str) -> None:
    _line(ax, main, label, BLUE, "-", "o")
    for curve, (colour, line, mark) in zip(others, _STYLES, strict=False):
        if curve.points:
            _line(ax, curve, _label(curve), colour, line, mark)
        else:
            ax.plot([], [], color=GREY, label=pretty(f"{curve.words}: no design"))
    ax.set_xlabel("side of the cube, 2 L (mm)")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13))


def _line(ax: Axes, curve: Curve, label: str, colour: str, line: object, mark: str) -> None:
    sides = [2.0 * point.half_side for point in curve.points]
    kappas = [point.kappa for point in curve.points]
    ax.plot(
        sides, kappas, color=colour, linestyle=line, linewidth=1.6, marker=mark, markersize=3.5, label=pretty(label)
    )


def _label(curve: Curve) -> str:
    last = curve.points[-1]
    if curve.name.startswith("outline"):
        width, depth = last.outline
        return f"R + L_A {last.reach:.4g} mm, outline {width:.0f} x {depth:.0f} mm"
    starts = next((2.0 * point.half_side for point in curve.points if "torque" in point.active), None)
    return curve.words + ("" if starts is None else f": binds from {starts:.0f} mm on")


@styled
def convergence(traces: list[Trace], optimum: float, title: str) -> Figure:
    """Draws the median and the range over the seeds of the best objective so far.

    Returns:
        The figure, 11 x 4.6 inches.
    """
    figure = _figure(11.0, 4.8, title)
    wide, near = figure.subplots(1, 2)
    first = min(trace.evaluations[0] for trace in traces if trace.evaluations)
    last = max(trace.evaluations[-1] for trace in traces if trace.evaluations)
    at = np.unique(
        np.concatenate([np.geomspace(first, last, _POINTS).round(), [n for t in traces for n in t.evaluations]])
    )
    lowest = highest = optimum
    for method, label, colour, line in _METHODS:
        seeds = sum(trace.method == method for trace in traces)
        if not seeds:
            continue
        until = max(trace.evaluations[-1] for trace in traces if trace.method == method)
        mine = at[at <= until]
        least, median, largest = band(traces, method, mine)
        highest = max(highest, *(float(line[np.isfinite(line)].max(initial=optimum)) for line in (median, largest)))
        lowest = min(lowest, float(least.min()))
        least, largest = (np.minimum(line, _FAR * optimum) for line in (least, largest))
        for ax in (wide, near):
            ax.fill_between(mine, least, largest, step="post", color=colour, alpha=0.22, linewidth=0.0)
            ax.step(mine, median, where="post", color=colour, linestyle=line, linewidth=1.8, label=label)
    for ax in (wide, near):
        ax.axhline(optimum, color=BLACK, linewidth=0.9, linestyle=(0, (1, 1.5)), label=f"the front: {optimum:.4f}")
        ax.set_xscale("log")
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.set(xlabel="designs evaluated", ylabel="smallest worst condition number so far")
    highest = min(highest, (1.0 + _TALL) * optimum)
    room = _ROOM * (highest - optimum) or _ROOM * _ZOOM * optimum
    wide.set_ylim(optimum - room, highest + room)
    wide.set_title(f"median and range of {len({trace.seed for trace in traces})} seeds")
    near.set_ylim(max(lowest, optimum * (1.0 - _ZOOM)) - _ROOM * _ZOOM * optimum, optimum * (1.0 + _ZOOM))
    near.set_title(f"the same within {100.0 * _ZOOM:g} % of the front")
    wide.legend(loc="upper right")
    figure.supxlabel(
        "Band open above: not every seed has a feasible design yet. Below the front: the GA's sample of the cube's "
        "surface misses the worst point.",
        fontsize=8.5,
    )
    return figure


@styled
def workspace(g: DeltaGeometry, cube: Cube, title: str) -> Figure:
    """Draws the workspace of a mechanism with its cube.

    Returns:
        The figure, 12 x 5.6 inches.
    """
    figure = Figure(figsize=(12.0, 5.4))  # no layout engine: it does not see the labels of 3D axes
    figure.suptitle(pretty(title), fontsize=12, y=0.97)
    _shell(figure.add_axes((0.0, 0.03, 0.345, 0.84), projection="3d"), g, cube)
    _from_above(figure.add_axes((0.455, 0.27, 0.23, 0.56)), g, cube)
    _mirror_plane(figure.add_axes((0.75, 0.27, 0.235, 0.56)), g, cube)
    return figure


def _shell(ax: Any, g: DeltaGeometry, cube: Cube) -> None:
    s = shell(g)
    azimuth = np.degrees(np.arctan2(s.y[:, -1], s.x[:, -1]))
    towards = (azimuth - _VIEW[1] + 180.0) % 360.0 - 180.0
    back = np.flatnonzero(np.abs(towards) >= _CUT_AWAY)
    start = int(np.argmax(np.diff(back, append=back[0] + len(azimuth)) > 1)) + 1  # the fan without its gap
    order = np.roll(back, -start) if start < len(back) else back
    x, y = s.x[order] * MM, s.y[order] * MM
    for z in (s.bottom[order] * MM, s.top[order] * MM):
        ax.plot_surface(
            x, y, z, rstride=6, cstride=4, color=SKY, alpha=_SHELL_ALPHA, edgecolor=BLUE, linewidth=0.25, shade=False
        )
    rim = np.stack([s.x[:, -1], s.y[:, -1], s.top[:, -1]], axis=-1) * MM
    ax.plot(*rim.T, color=BLUE, linewidth=0.9)
    corners = np.array(list(product(*zip(cube.lower, cube.upper, strict=True)))) * MM
    faces = [
        corners[[a, b, d, c]]
        for a, b, c, d in ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 4, 5), (2, 3, 6, 7), (0, 2, 4, 6), (1, 3, 5, 7))
    ]
    ax.add_collection3d(Poly3DCollection(faces, facecolor=VERMILLION, alpha=0.35))
    edges = [corners[[i, j]] for i in range(8) for j in range(i) if bin(i ^ j).count("1") == 1]
    ax.add_collection3d(Line3DCollection(edges, colors=VERMILLION, linewidths=1.8))
    shoulders = (g.base_radii[:, None] * g.radial * MM)[[0, 1, 2, 0]]
    ax.plot(*shoulders.T, color=BLACK, linewidth=1.2, marker="o", markersize=4)
    ax.set(xlabel="x (mm)", ylabel="y (mm)", zlabel="z (mm)", title="limit of reach, cut open towards the eye")
    ax.view_init(*_VIEW)
    ax.set_aspect("equal")
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(MultipleLocator(100.0))
    ax.tick_params(pad=0)


def _from_above(ax: Axes, g: DeltaGeometry, cube: Cube) -> None:
    low, high = float(cube.lower[2]), float(cube.upper[2])
    levels = (
        (low, "bottom of the cube", GREEN, (0, (1, 1))),
        ((low + high) / 2.0, "middle", BLUE, "-"),
        (high, "top", ORANGE, (0, (5, 2))),
    )
    for z, name, colour, line in levels:
        for k, arc in enumerate(contours_at_height(g, z)):
            label = f"{name}, z = {z * MM:.1f} mm" if k == 0 else None
            ax.plot(*arc[:, :2].T * MM, color=colour, linestyle=line, linewidth=1.4, label=label)
    ax.add_patch(_square(*cube.lower[:2] * MM, *cube.upper[:2] * MM))
    base = g.base_radii[:, None] * g.radial * MM
    ax.plot(*base[:, :2].T, "^", color=BLACK, markersize=6, label="shoulders")
    ax.set(xlabel="x (mm)", ylabel="y (mm)", title="limits of reach at three heights,\nfrom above")
    ax.set_aspect("equal")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=2, columnspacing=1.0)


def _mirror_plane(ax: Axes, g: DeltaGeometry, cube: Cube) -> None:
    arcs = [arc * MM for arc in contours_in_mirror_plane(g)]
    every = np.concatenate(arcs)
    x = np.linspace(every[:, 0].min(), every[:, 0].max(), GRID)
    z = np.linspace(0.0, every[:, 2].max(), GRID)
    p = np.stack(np.broadcast_arrays(x[None, :], 0.0, z[:, None]), axis=-1) / MM
    inside = closure_margin(g, p).min(axis=-1)
    ax.contourf(x, z, inside, levels=[0.0, np.inf], colors=[SKY], alpha=_SHELL_ALPHA)
    for k, arc in enumerate(arcs):
        ax.plot(arc[:, 0], arc[:, 2], color=BLUE, linewidth=1.4, label="limit of reach, h = 0" if k == 0 else None)
    with np.errstate(invalid="ignore"):
        determinant = np.ma.masked_invalid(np.where(inside >= 0.0, direct_margin(g, p), np.nan))
    if determinant.min() < 0.0 < determinant.max():
        ax.contour(x, z, determinant, levels=[0.0], colors=[GREY], linestyles=[(0, (4, 2))], linewidths=1.2)
        ax.plot([], [], color=GREY, linestyle=(0, (4, 2)), linewidth=1.2, label="singular: not held")
    ax.add_patch(_square(*cube.lower[[0, 2]] * MM, *cube.upper[[0, 2]] * MM))
    ax.plot([g.base_radius * MM], [0.0], "^", color=BLACK, markersize=6, clip_on=False, zorder=5, label="shoulder")
    ax.set(xlabel="x (mm)", ylabel="z (mm)", title="section in the mirror plane\ny = 0")
    ax.set_ylim(bottom=0.0)
    ax.set_aspect("equal")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.25), ncols=2, columnspacing=1.0)


def _square(left: float, lower: float, right: float, upper: float) -> Rectangle:
    style = {"facecolor": VERMILLION, "edgecolor": VERMILLION, "alpha": 0.55, "linewidth": 1.6, "label": "cube"}
    return Rectangle((left, lower), right - left, upper - lower, **style)


@styled
def maps(slices: list[Slice], force: float, title: str) -> Figure:
    """Draws both figures of merit over every slice, a row each, with one scale a row.

    Returns:
        The figure, 12.4 x 7 inches.
    """
    figure = _figure(12.4, 7.0, title)
    axes = figure.subplots(2, len(slices), squeeze=False)
    rows = (
        ("kappa", "condition number", "viridis", "{:.3f}"),
        ("torque", f"worst joint torque for {force:g} N (N m)", "cividis", "{:.4f} N m"),
    )
    for row, (name, label, colours, form) in zip(axes, rows, strict=True):
        values = [getattr(plane, name) for plane in slices]
        inside = np.concatenate([v[s.inside] for v, s in zip(values, slices, strict=True)])
        low, high = float(np.nanmin(inside)), float(np.nanmax(inside))
        worst = max(s.worst(v)[0] for v, s in zip(values, slices, strict=True))
        picture: Any = None
        for ax, plane, value in zip(row, slices, values, strict=True):
            picture = _map(ax, plane, value, (low, high), colours)
            _marks(ax, plane, value, form, worst)
        figure.colorbar(picture, ax=list(row), label=label, extend="max", fraction=0.02, pad=0.01)
    return figure


def _map(ax: Axes, plane: Slice, value: np.ndarray, limits: tuple[float, float], colours: str) -> Any:
    across, up = plane.across * MM, plane.up * MM
    shown, (low, high) = np.ma.masked_invalid(value), limits
    style = {"cmap": colours, "vmin": low, "vmax": high, "shading": "nearest", "rasterized": True}
    picture = ax.pcolormesh(across, up, shown, **style)
    levels = np.linspace(low, high, _LEVELS + 2)[1:-1]
    if high > low:
        ax.contour(across, up, shown, levels=levels, colors="white", linewidths=0.5, alpha=0.7)
    return picture


def _marks(ax: Axes, plane: Slice, value: np.ndarray, form: str, worst: float) -> None:
    left, right, lower, upper = (MM * side for side in plane.outline)
    edge = (plane.across[0] * MM, plane.across[-1] * MM, plane.up[0] * MM, plane.up[-1] * MM)
    # what is not in the cube is veiled
    hole = [(left, lower), (left, upper), (right, upper), (right, lower)]  # turns the other way: it stays open
    frame = [(edge[0], edge[2]), (edge[1], edge[2]), (edge[1], edge[3]), (edge[0], edge[3])]
    veil = Outline([*frame, frame[0], *hole, hole[0]], [Outline.MOVETO, *[Outline.LINETO] * 3, Outline.CLOSEPOLY] * 2)
    ax.add_patch(PathPatch(veil, facecolor="white", alpha=0.45, linewidth=0.0))
    ax.add_patch(Rectangle((left, lower), right - left, upper - lower, fill=False, edgecolor="black", linewidth=1.6))
    largest, x, y = plane.worst(value)
    star = largest >= worst * (1.0 - _SAME)
    style = {"marker": "*", "markersize": 15} if star else {"marker": "X", "markersize": 8}
    style |= {"color": VERMILLION, "markeredgecolor": "white", "markeredgewidth": 1.0, "clip_on": False, "zorder": 5}
    ax.plot([x * MM], [y * MM], **style)
    ax.set_title(f"{plane.title}\nworst " + form.format(largest) + (" (of all)" if star else ""))
    ax.set(xlabel=f"{plane.axes[0]} (mm)", ylabel=f"{plane.axes[1]} (mm)", xlim=edge[:2], ylim=edge[2:])
    ax.set_aspect("equal")
    ax.grid(False)


@styled
def atlas_map(grid: Grid, rows: Sequence[AtlasRow]) -> Figure:
    """Draws the map: one panel a step, the first axis upwards.

    Returns:
        The figure, 4.2 inches high.
    """
    titles = {
        objective_column(s): f"step {s['step']}: {_TITLES[s['objective_name']]}" for r in rows for s in r["steps"]
    }
    titles = titles or {"": "no set can be met"}
    figure = _figure(1.6 + 4.6 * len(titles), 4.2, f"{grid.name} (hatched: cannot be met)")
    for ax, (column, title) in zip(figure.subplots(1, len(titles), squeeze=False)[0], titles.items(), strict=True):
        _panel(ax, cells(grid, rows, column), _COLOURS[column.endswith(_LARGE)])
        for axis, place in zip(grid.axes, (ax.yaxis, ax.xaxis), strict=True):
            _ticks(axis, place)
        ax.set_title(title)
        ax.grid(False)
    return figure


def cells(grid: Grid, rows: Sequence[AtlasRow], column: str) -> np.ndarray:
    """Finds the best objective of each pair of values, over the seeds.

    Returns:
        (values of the first axis, values of the second); NaN where no seed met the step.
    """
    first, second = grid.axes
    best = np.full((len(first.values), len(second.values)), np.nan)
    larger = column.endswith(_LARGE)
    for row in rows:
        objectives = [
            step["objective"] for step in row["steps"] if objective_column(step) == column and step["feasible"]
        ]
        if objectives and objectives[0] is not None:
            at = first.values.index(row["inputs"][first.field]), second.values.index(row["inputs"][second.field])
            best[at] = (np.fmax if larger else np.fmin)(best[at], objectives[0])
    return best


def _panel(ax: Axes, values: np.ndarray, colours: str) -> None:
    ax.set_facecolor("0.85")
    ax.patch.set_hatch("//")
    ax.patch.set_edgecolor("0.6")
    ax.set(xlim=(-0.5, values.shape[1] - 0.5), ylim=(-0.5, values.shape[0] - 0.5))
    if not np.isfinite(values).any():
        return
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = max(0.0, _SPAN_MIN * abs(high) - (high - low)) / 2.0
    shown: Any = ax.imshow(values, origin="lower", aspect="auto", cmap=colours, vmin=low - room, vmax=high + room)
    ax.figure.colorbar(shown, ax=ax)
    for (i, j), value in np.ndenumerate(values if values.size <= _CELLS_MAX else np.empty((0, 0))):
        if math.isfinite(value):
            red, green, blue, _ = shown.cmap(shown.norm(value))
            dark = 0.3 * red + 0.59 * green + 0.11 * blue < 0.5
            ax.text(j, i, f"{value:.4g}", ha="center", va="center", fontsize=7, color="white" if dark else "black")


def _ticks(axis: Axis, place: Any) -> None:
    at = range(0, len(axis.values), math.ceil(len(axis.values) / TICKS))
    place.set_ticks(list(at), [f"{axis.values[k]:.4g}" for k in at])
    place.set_label_text(axis.field)
