"""The workspace with the cube in it: the shell, a top view and the mirror plane; [RCIM2018] figures 5 and 6."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MultipleLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from delta_cad.common.picture_style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, VERMILLION, styled
from delta_cad.common.units import MM_PER_M as MM
from delta_cad.mechanism import DeltaGeometry, closure_margin
from delta_cad.mechanism.geometry import RADIAL
from delta_cad.mechanism.statics import direct_margin
from delta_cad.mechanism.workspace import Cube
from optimizer.study.pictures.style import pretty
from optimizer.study.reachable import contours_at_height, contours_in_mirror_plane, shell

VIEW = (22.0, -62.0)  # elevation and azimuth of the eye, degrees
CUT_AWAY = 75.0  # half the angle of the sector that is left out towards the eye, degrees
GRID = 401  # points along an edge of the section's raster, for its fill and the singular line
SHELL_ALPHA = 0.28


@styled
def workspace(g: DeltaGeometry, cube: Cube, title: str) -> Figure:
    """Draws it.

    Args:
        g: The mechanism.
        cube: Its cube.
        title: Name of the design.

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
    towards = (azimuth - VIEW[1] + 180.0) % 360.0 - 180.0
    back = np.flatnonzero(np.abs(towards) >= CUT_AWAY)
    start = int(np.argmax(np.diff(back, append=back[0] + len(azimuth)) > 1)) + 1  # the fan without its gap
    order = np.roll(back, -start) if start < len(back) else back
    x, y = s.x[order] * MM, s.y[order] * MM
    for z in (s.bottom[order] * MM, s.top[order] * MM):
        ax.plot_surface(
            x, y, z, rstride=6, cstride=4, color=SKY, alpha=SHELL_ALPHA, edgecolor=BLUE, linewidth=0.25, shade=False
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
    shoulders = np.append(RADIAL * g.base_radius * MM, RADIAL[:1] * g.base_radius * MM, axis=0)
    ax.plot(*shoulders.T, color=BLACK, linewidth=1.2, marker="o", markersize=4)
    ax.set(xlabel="x (mm)", ylabel="y (mm)", zlabel="z (mm)", title="limit of reach, cut open towards the eye")
    ax.view_init(*VIEW)
    ax.set_aspect("equal")
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(MultipleLocator(100.0))
    ax.tick_params(pad=0)


def _from_above(ax: Axes, g: DeltaGeometry, cube: Cube) -> None:
    L, low, high = cube.half_side * MM, float(cube.lower[2]), float(cube.upper[2])
    levels = (
        (low, "bottom of the cube", GREEN, (0, (1, 1))),
        ((low + high) / 2.0, "middle", BLUE, "-"),
        (high, "top", ORANGE, (0, (5, 2))),
    )
    for z, name, colour, line in levels:
        for k, arc in enumerate(contours_at_height(g, z)):
            label = f"{name}, z = {z * MM:.1f} mm" if k == 0 else None
            ax.plot(*arc[:, :2].T * MM, color=colour, linestyle=line, linewidth=1.4, label=label)
    ax.add_patch(_square(-L, -L, L, L))
    base = RADIAL * g.base_radius * MM
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
    ax.contourf(x, z, inside, levels=[0.0, np.inf], colors=[SKY], alpha=SHELL_ALPHA)
    for k, arc in enumerate(arcs):
        ax.plot(arc[:, 0], arc[:, 2], color=BLUE, linewidth=1.4, label="limit of reach, h = 0" if k == 0 else None)
    with np.errstate(invalid="ignore"):
        determinant = np.ma.masked_invalid(np.where(inside >= 0.0, direct_margin(g, p), np.nan))
    if determinant.min() < 0.0 < determinant.max():
        ax.contour(x, z, determinant, levels=[0.0], colors=[GREY], linestyles=[(0, (4, 2))], linewidths=1.2)
        ax.plot([], [], color=GREY, linestyle=(0, (4, 2)), linewidth=1.2, label="singular: not held")
    L, low, high = cube.half_side * MM, float(cube.lower[2]) * MM, float(cube.upper[2]) * MM
    ax.add_patch(_square(-L, low, L, high))
    ax.plot([g.base_radius * MM], [0.0], "^", color=BLACK, markersize=6, clip_on=False, zorder=5, label="shoulder")
    ax.set(xlabel="x (mm)", ylabel="z (mm)", title="section in the mirror plane\ny = 0")
    ax.set_ylim(bottom=0.0)
    ax.set_aspect("equal")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.25), ncols=2, columnspacing=1.0)


def _square(left: float, lower: float, right: float, upper: float) -> Rectangle:
    style = {"facecolor": VERMILLION, "edgecolor": VERMILLION, "alpha": 0.55, "linewidth": 1.6, "label": "cube"}
    return Rectangle((left, lower), right - left, upper - lower, **style)
