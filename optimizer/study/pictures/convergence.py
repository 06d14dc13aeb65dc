"""Picture of how GA and SQP converge over the seeds."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from delta_cad.common.picture_style import BLACK, BLUE, VERMILLION, styled
from optimizer.study.convergence import Trace, band
from optimizer.study.pictures.style import pretty

METHODS = (
    ("ga", "GA, the paper's parameters", BLUE, "-"),
    ("sqp", "SQP, starts one after the other", VERMILLION, (0, (5, 1.5))),
)
TALL = 0.25  # height of the left picture at most, as a part of the optimum
ZOOM = 0.005  # height of the right picture over the optimum, as a part of the optimum
ROOM = 0.08  # below the lowest line, as a part of the picture's height
POINTS = 400
FAR = 100.0  # this many times the optimum stands for infinite, outside the picture


@styled
def convergence(traces: list[Trace], optimum: float, title: str) -> Figure:
    """Draws the median and the range over the seeds of the best objective so far.

    Args:
        traces: Runs of both methods from the same seeds.
        optimum: Worst kappa of the front at this cube.
        title: Which problem.

    Returns:
        The figure, 11 x 4.6 inches.
    """
    figure = Figure(figsize=(11.0, 4.8), layout="constrained")
    figure.suptitle(pretty(title), fontsize=12)
    wide, near = figure.subplots(1, 2)
    first = min(trace.evaluations[0] for trace in traces if trace.evaluations)
    last = max(trace.evaluations[-1] for trace in traces if trace.evaluations)
    at = np.unique(
        np.concatenate([np.geomspace(first, last, POINTS).round(), [n for t in traces for n in t.evaluations]])
    )
    lowest = highest = optimum
    for method, label, colour, line in METHODS:
        seeds = sum(trace.method == method for trace in traces)
        if not seeds:
            continue
        until = max(trace.evaluations[-1] for trace in traces if trace.method == method)
        mine = at[at <= until]
        least, median, largest = band(traces, method, mine)
        highest = max(highest, *(float(line[np.isfinite(line)].max(initial=optimum)) for line in (median, largest)))
        lowest = min(lowest, float(least.min()))
        least, largest = (np.minimum(line, FAR * optimum) for line in (least, largest))
        for ax in (wide, near):
            ax.fill_between(mine, least, largest, step="post", color=colour, alpha=0.22, linewidth=0.0)
            ax.step(mine, median, where="post", color=colour, linestyle=line, linewidth=1.8, label=label)
    for ax in (wide, near):
        ax.axhline(optimum, color=BLACK, linewidth=0.9, linestyle=(0, (1, 1.5)), label=f"the front: {optimum:.4f}")
        ax.set_xscale("log")
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
        ax.xaxis.set_minor_formatter(NullFormatter())
        ax.set(xlabel="designs evaluated", ylabel="smallest worst condition number so far")
    highest = min(highest, (1.0 + TALL) * optimum)
    room = ROOM * (highest - optimum) or ROOM * ZOOM * optimum
    wide.set_ylim(optimum - room, highest + room)
    wide.set_title(f"median and range of {len({trace.seed for trace in traces})} seeds")
    near.set_ylim(max(lowest, optimum * (1.0 - ZOOM)) - ROOM * ZOOM * optimum, optimum * (1.0 + ZOOM))
    near.set_title(f"the same within {100.0 * ZOOM:g} % of the front")
    wide.legend(loc="upper right")
    figure.supxlabel(
        "Band open above: not every seed has a feasible design yet. Below the front: the GA's sample of the cube's "
        "surface misses the worst point.",
        fontsize=8.5,
    )
    return figure
