"""Picture of the operating resistance: force against distance beside eq. (23)."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from delta_cad.common.picture_style import BLACK, BLUE, GREY, ORANGE, styled
from delta_cad.common.units import MM_PER_M
from haptics.scenes.record import Scene, SceneRun

BIN_MM = 0.5
ZOOM_MM = 14.0
STAY = (4.2, 4.5)  # While the handle stays at the corner, s


@styled
def picture(scene: Scene, name: str) -> Figure:
    """Draws both settings, over all the way and near the origin.

    Args:
        scene: Scene made by `resistance`.
        name: Name of the design.

    Returns:
        The figure, 11 x 7.4 inches.
    """
    figure = Figure(figsize=(11.0, 7.4), layout="constrained")
    figure.suptitle(f"Operating resistance of {name}: the handle led to the cube's 8 corners and back", fontsize=12)
    axes = figure.subplots(2, 2, sharey=True)
    limit = scene.facts["force_limit_N"]
    for column, (key, setting) in enumerate(scene.facts["settings"].items()):
        runs = [run for run in scene.runs if run.facts["setting"] == key]
        far = max(float(run.series["distance_mm"].max()) for run in runs)
        for ax, width in ((axes[0, column], far * 1.03), (axes[1, column], ZOOM_MM)):
            _draw(ax, runs, setting, limit, width, entire=ax is axes[0, column])
        axes[0, column].set_title(
            f"k = {setting['stiffness_N_per_m'] / MM_PER_M:g} N/mm, r1 = {setting['full_radius_mm']:g} mm; "
            f"b = {setting['damping_asked_N_s_per_m']:g} N s/m asked, "
            f"{setting['damping_applied_N_s_per_m']:.3g} applied"
        )
        axes[1, column].set_title("the same near the origin")
    figure.supxlabel(
        "Lines: median, bands: 90 % of the samples over all eight corners. Way out and way back differ by the damping; "
        "friction of the joints comes on top.",
        fontsize=8.5,
    )
    return figure


def _draw(ax: Axes, runs: list[SceneRun], setting: dict[str, Any], limit: float, width: float, *, entire: bool) -> None:
    r0, r1, beyond = setting["dead_radius_mm"], setting["full_radius_mm"], setting["force_beyond_N"]
    for way, colour, text in ((0, BLUE, "way out"), (1, ORANGE, "way back")):
        centre, low, middle, high = _bands(runs, way, width)
        ax.fill_between(centre, low, high, color=colour, alpha=0.25, linewidth=0.0)
        ax.plot(centre, middle, color=colour, linewidth=1.6)
        k = int(len(centre) * (0.5 if entire or way else 0.2))
        # beside a line that rises a word below it starts where it is, one above it ends there
        rises = not entire and high[k] < 0.9 * high.max()
        side = ("left" if way else "right") if rises else "center" if entire or way else "right"
        above = way == 0
        ax.annotate(
            text, (centre[k], high[k] if above else low[k]), xytext=(6 if rises and way else 0, 5 if above else -5),
            textcoords="offset points", color=colour, ha=side, va="bottom" if above else "top",
        )  # fmt: skip
    if beyond > limit:
        ax.plot([r0, r1, width], [0.0, beyond, beyond], color=GREY, linewidth=1.0, linestyle=(0, (4, 2)))
        ax.text(
            width * 0.985, beyond + 0.05, f"eq. (23) without limit: {beyond:.1f} N", color=GREY, ha="right", va="bottom"
        )
    x = np.linspace(0.0, width, 600)
    law = np.minimum(setting["stiffness_N_per_m"] / MM_PER_M * np.clip(x - r0, 0.0, r1 - r0), limit)
    ax.plot(x, law, color=BLACK, linewidth=1.4)
    thin = {"arrowstyle": "-", "color": BLACK, "linewidth": 0.7}
    if entire:
        rest = sorted(f"{run.facts['corner_force_N']:.2f}" for run in runs)
        at = [float(run.series["distance_mm"].max()) for run in runs]
        ax.plot(at, [run.facts["corner_force_N"] for run in runs], "o", color=BLACK, markersize=5)
        at_rest = f"at rest at the 8 corners:\n{rest[0]}" + (f" to {rest[-1]} N" if rest[-1] > rest[0] else " N")
        ax.annotate(
            at_rest, (at[0], float(rest[0])), xytext=(0.93 * width, 0.7), ha="right", va="center", arrowprops=thin
        )
    label = "eq. (23) at rest" + (f", cut at {limit:g} N" if beyond > limit else "")
    x_law, x_text, side = (0.3, 0.3, "center") if entire else (0.9, 0.985, "right")
    ax.annotate(
        label, (x_law * width, float(np.interp(x_law * width, x, law))), xytext=(x_text * width, 0.9), ha=side,
        va="center", arrowprops={**thin, "relpos": (0.5 if entire else 0.8, 1.0)},
    )  # fmt: skip
    ax.set(xlim=(0.0, width), ylim=(-0.8, 3.9), xlabel="distance from the origin, mm")
    if ax.get_subplotspec().is_first_col():  # type: ignore[union-attr]
        ax.set_ylabel("pull towards the origin by the motors, N")


def _bands(runs: list[SceneRun], way: int, width: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Centres of the bins (mm) and 5 %, 50 %, 95 % of the pull in them (N), on the way out (0) or back (1)."""
    distance, pull = [], []
    for run in runs:
        time = run.series["time_s"]
        chosen = (time > 0.0) & (time < STAY[0] - 0.2) if way == 0 else time > STAY[1]
        distance.append(run.series["distance_mm"][chosen])
        pull.append(run.series["pull_of_motors_N"][chosen])
    d, f = np.concatenate(distance), np.concatenate(pull)
    edges = np.arange(0.0, width + BIN_MM, BIN_MM)
    which = np.digitize(d, edges) - 1
    filled = [k for k in range(len(edges) - 1) if (which == k).any()]
    shares = np.array([np.percentile(f[which == k], [5.0, 50.0, 95.0]) for k in filled])
    return edges[filled] + BIN_MM / 2.0, shares[:, 0], shares[:, 1], shares[:, 2]
