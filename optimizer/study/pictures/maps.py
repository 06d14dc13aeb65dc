"""Maps of the condition number and of the worst joint torque over slices of the cube."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Rectangle
from matplotlib.path import Path

from delta_cad.common.picture_style import VERMILLION, styled
from delta_cad.common.units import MM_PER_M as MM
from optimizer.study.maps import Slice
from optimizer.study.pictures.style import pretty

SAME = 1e-6  # part by which two worst values may differ and still both be the worst of all: an optimum has several
LEVELS = 9  # contour lines inside the range


@styled
def maps(slices: list[Slice], force: float, title: str) -> Figure:
    """Draws both figures of merit over every slice, a row each, with one scale a row.

    Args:
        slices: The maps.
        force: That the torque is for, N.
        title: Name of the design.

    Returns:
        The figure, 12.4 x 7 inches.
    """
    figure = Figure(figsize=(12.4, 7.0), layout="constrained")
    figure.suptitle(pretty(title), fontsize=12)
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
    levels = np.linspace(low, high, LEVELS + 2)[1:-1]
    if high > low:
        ax.contour(across, up, shown, levels=levels, colors="white", linewidths=0.5, alpha=0.7)
    return picture


def _marks(ax: Axes, plane: Slice, value: np.ndarray, form: str, worst: float) -> None:
    left, right, lower, upper = (MM * side for side in plane.outline)
    edge = (plane.across[0] * MM, plane.across[-1] * MM, plane.up[0] * MM, plane.up[-1] * MM)
    # what is not in the cube is veiled
    hole = [(left, lower), (left, upper), (right, upper), (right, lower)]  # turns the other way: it stays open
    frame = [(edge[0], edge[2]), (edge[1], edge[2]), (edge[1], edge[3]), (edge[0], edge[3])]
    veil = Path([*frame, frame[0], *hole, hole[0]], [Path.MOVETO, *[Path.LINETO] * 3, Path.CLOSEPOLY] * 2)
    ax.add_patch(PathPatch(veil, facecolor="white", alpha=0.45, linewidth=0.0))
    ax.add_patch(Rectangle((left, lower), right - left, upper - lower, fill=False, edgecolor="black", linewidth=1.6))
    largest, x, y = plane.worst(value)
    star = largest >= worst * (1.0 - SAME)
    style = {"marker": "*", "markersize": 15} if star else {"marker": "X", "markersize": 8}
    style |= {"color": VERMILLION, "markeredgecolor": "white", "markeredgewidth": 1.0, "clip_on": False, "zorder": 5}
    ax.plot([x * MM], [y * MM], **style)
    ax.set_title(f"{plane.title}\nworst " + form.format(largest) + (" (of all)" if star else ""))
    ax.set(xlabel=f"{plane.axes[0]} (mm)", ylabel=f"{plane.axes[1]} (mm)", xlim=edge[:2], ylim=edge[2:])
    ax.set_aspect("equal")
    ax.grid(False)
