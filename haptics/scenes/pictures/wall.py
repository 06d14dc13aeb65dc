"""Picture of virtual walls: penetration and force against time across each axis."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from delta_cad.common.picture_style import BLUE, GREEN, VERMILLION, styled
from haptics.scenes.pictures.style import label_ends
from haptics.scenes.record import Scene

COLOURS = {"first": BLUE, "published": GREEN, "above": VERMILLION}
MEANINGS = {"first": "the paper's first wall", "published": "the paper's largest", "above": "1.3 times our own limit"}
TIME_S = (-0.05, 1.5)


@styled
def picture(scene: Scene, name: str) -> Figure:
    """Draws three walls across each axis.

    Args:
        scene: Scene made by `wall`.
        name: Name of the design.

    Returns:
        The figure, 12 x 6.4 inches.
    """
    figure = Figure(figsize=(12.0, 6.4), layout="constrained")
    hand = scene.facts["hand"]["name"]
    figure.suptitle(f"Virtual walls of {name}, pushed by a {hand} hand", fontsize=12)
    axes = figure.subplots(2, 3, sharex=True, sharey="row")
    for column, (axis, limit) in enumerate(scene.facts["limits"].items()):
        runs = [run for run in scene.runs if run.facts["axis"] == axis]
        top, bottom = axes[0, column], axes[1, column]
        more = "more than " if limit["never_oscillated"] else ""
        top.set_title(f"{axis}: up to {more}{limit['simulated_N_per_mm']:.1f} N/mm here, "
                      f"{limit['published_N_per_mm']:g} in the paper")  # fmt: skip
        for run in runs[::-1]:  # the calm ones on top
            time, role = run.series["time_s"], run.facts["role"]
            shown = (time >= TIME_S[0]) & (time <= TIME_S[1])
            for ax, key in ((top, "penetration_mm"), (bottom, "wall_force_N")):
                ax.plot(
                    time[shown], run.series[key][shown], color=COLOURS[role], linewidth=1.3 if role != "above" else 0.9
                )
        bottom.set_xlabel("time since the hand sets out, s")
    deepest = max(float(np.nanmax(run.series["penetration_mm"])) for run in scene.runs)
    axes[0, 0].set(ylabel="penetration, mm", ylim=(-0.35 * deepest, 1.15 * deepest), xlim=TIME_S)
    limit = scene.facts["force_limit_N"]
    axes[1, 0].set(ylabel="force of the wall, N", ylim=(-0.05 * limit, 1.08 * limit))
    for column, axis in enumerate(scene.facts["limits"]):
        ends = []
        for run in scene.runs:
            if run.facts["axis"] == axis:
                end = float(np.mean(run.series["penetration_mm"][-200:]))
                text = f"{run.facts['stiffness_N_per_mm']:.3g} N/mm\n{_short(run.facts['verdict'])}"
                ends.append((end, text, COLOURS[run.facts["role"]]))
        label_ends(axes[0, column], ends, gap=0.15)
    for role, meaning in MEANINGS.items():
        axes[1, 0].plot([], [], color=COLOURS[role], label=meaning)
    figure.legend(*axes[1, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    return figure


def _short(verdict: str) -> str:
    """Verdict without its explanation."""
    return verdict.split(":")[0].removeprefix("oscillates and ")
