"""Picture of the way home: distance against time for several dampings, and what an uncapped one does."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from delta_cad.common.picture_style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION, styled
from delta_cad.common.units import MM_PER_M
from haptics.scenes.pictures.style import label_ends
from haptics.scenes.record import Scene

COLOURS = (SKY, GREEN, BLUE, PURPLE, BLACK, GREY)
BEYOND = (ORANGE, VERMILLION)
SHORT_S, LAST_S = 0.6, 0.1


@styled
def picture(scene: Scene, name: str) -> Figure:
    """Draws the first moments, all the time, and the last tenth of a second of the force.

    Args:
        scene: Scene made by `home`.
        name: Name of the design.

    Returns:
        The figure, 11 x 7.2 inches.
    """
    figure = Figure(figsize=(11.0, 7.2), layout="constrained")
    figure.suptitle(
        f"Way home of {name}: let go {scene.facts['distance_at_start_mm']:.1f} mm from the origin, "
        f"k = {scene.facts['stiffness_N_per_m'] / MM_PER_M:g} N/mm",
        fontsize=12,
    )
    grid = figure.add_gridspec(2, 2)
    first, entire, force = (
        figure.add_subplot(grid[0, 0]),
        figure.add_subplot(grid[0, 1]),
        figure.add_subplot(grid[1, :]),
    )
    capped = [run for run in scene.runs if run.facts["capped"]]
    beyond = [run for run in scene.runs if not run.facts["capped"]]
    colours = {run.name: colour for run, colour in zip(capped, COLOURS, strict=False)}
    colours |= {run.name: colour for run, colour in zip(beyond, BEYOND, strict=False)}
    start = scene.facts["distance_at_start_mm"]
    radius = scene.facts["home_radius_mm"]

    for ax in (first, entire):
        ax.axhspan(0.0, radius, color=GREY, alpha=0.13, linewidth=0.0)
        ax.set(ylim=(0.0, 1.05 * start), xlabel="time, s", ylabel="distance from the origin, mm")
    ends = []
    for run in capped:
        time, distance = run.series["time_s"], run.series["distance_mm"]
        near = (time >= 0.0) & (time <= SHORT_S)
        first.plot(time[near], distance[near], color=colours[run.name], linewidth=1.6)
        text = f"{run.facts['damping_applied_N_s_per_m']:.3g} N s/m"
        ends.append((float(distance[near][-1]), text, colours[run.name]))
    first.set(xlim=(0.0, SHORT_S), title="damping as far as the loop bears it")
    label_ends(first, ends, gap=0.053)

    time_end = float(scene.runs[0].series["time_s"][-1])
    ends = []
    for run in [*capped[-1:], *beyond]:
        time, distance = run.series["time_s"], run.series["distance_mm"]
        now = time >= 0.0
        entire.plot(time[now], distance[now], color=colours[run.name], linewidth=1.6)
        text = f"{run.facts['damping_applied_N_s_per_m']:.3g} N s/m" + ("" if run.facts["capped"] else ",\nas asked")
        ends.append((float(distance[-1]), text, colours[run.name]))
    entire.text(0.5 * time_end, 0.35 * radius, "home: friction holds the handle", color=GREY, ha="center", fontsize=8.5)
    entire.set(xlim=(0.0, time_end), title="the paper's damping as it asks for it, and capped")
    label_ends(entire, ends, gap=0.115)

    shown = [run for run in (*capped[-1:], *beyond[-1:]) if not run.facts["supervisor_fault"]]
    half = 1.12 * max(scene.facts["force_limit_N"], 1.0)
    for run in shown[::-1]:
        tail = run.series["time_s"] > time_end - LAST_S
        pull = _main(run.series)[tail]
        force.step(
            1000.0 * (run.series["time_s"][tail] - time_end + LAST_S), pull, color=colours[run.name], where="post"
        )
    for side in (-1.0, 1.0):
        force.axhline(side * scene.facts["force_limit_N"], color=GREY, linewidth=1.0, linestyle=(0, (4, 2)))
    force.text(0.3, scene.facts["force_limit_N"] + 0.06, "force limit", color=GREY, va="bottom", fontsize=8.5)
    force.set(
        xlim=(0.0, 1000.0 * LAST_S), ylim=(-half, 1.1 * half), xlabel="time in the last tenth of a second, ms",
        ylabel="force asked for in its main direction, N",
    )  # fmt: skip
    legend = "; ".join(f"{run.facts['damping_applied_N_s_per_m']:.3g} N s/m: {_settling(run.facts)}" for run in shown)
    force.set_title(legend or "the supervisor took the force away")
    last = [(float(np.mean(_main(run.series)[-100:])), f"{run.facts['damping_applied_N_s_per_m']:.3g} N s/m",
             colours[run.name]) for run in shown]  # fmt: skip
    label_ends(force, last, gap=0.09)
    return figure


def _main(series: dict[str, np.ndarray]) -> np.ndarray:
    """(n,) rendered force along the direction in which it swings most in the last half second, N."""
    force = np.column_stack([series[f"force_asked_{a}_N"] for a in "xyz"])
    last = force[-500:] - force[-500:].mean(axis=0)
    direction = np.linalg.svd(last, full_matrices=False)[2][0]
    return force @ direction * (1.0 if force[-500:].mean(axis=0) @ direction >= 0.0 else -1.0)


def _settling(facts: dict) -> str:
    if facts["supervisor_fault"]:
        return str(facts["verdict"])
    if facts["limit_cycle"]:
        return f"limit cycle, {facts['frequency_Hz']:.0f} Hz, {facts['force_swing_N']:.1f} N peak to peak"
    if facts["chatters"]:
        return f"single counts make {facts['force_swing_N']:.1f} N peak to peak"
    if facts["rings"]:
        return f"moves by {facts['swing_um']:.0f} um at {facts['frequency_Hz']:.0f} Hz"
    return "quiet"
