"""Pictures of what was simulated: data in, figure out. Importing this loads matplotlib."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from delta_cad.common.picture_style import BLACK, BLUE, DPI, GREEN, GREY, ORANGE, PURPLE, RC, SKY, VERMILLION, styled
from delta_cad.common.units import MM_PER_M
from haptics.scenes.record import Scene, SceneRun


def label_ends(ax: Axes, ends: Sequence[tuple[float, str, str]], gap: float = 0.06) -> None:
    """Writes labels to the right of the axes beside the ends of their lines, moved apart where they would overlap.

    Args:
        ax: Axes whose limits are set.
        ends: Height of the line's end in data, text and colour of each.
        gap: Least distance of two labels, share of the axes' height.
    """
    low, high = ax.get_ylim()
    ends = [end for end in ends if math.isfinite(end[0])]  # a line that has left the picture has no end
    order = sorted(range(len(ends)), key=lambda k: ends[k][0])
    places = [min(max((ends[k][0] - low) / (high - low), 0.0), 1.0) for k in order]
    for k in range(1, len(places)):
        places[k] = max(places[k], places[k - 1] + gap)
    over = places[-1] - (1.0 - gap / 2.0) if places else 0.0
    for k in range(len(places) - 1, -1, -1):
        if over <= 0.0:
            break
        places[k] -= over
        over = places[k - 1] + gap - places[k] if k else 0.0
    for k, place in zip(order, places, strict=True):
        ax.text(1.015, place, ends[k][1], color=ends[k][2], transform=ax.transAxes, va="center", fontsize=8.5)


def _titled(width: float, height: float, title: str) -> Figure:
    """An empty figure of a size in inches with its title."""
    figure = Figure(figsize=(width, height), layout="constrained")
    figure.suptitle(title, fontsize=12)
    return figure


def save(figure: Figure, path: Path) -> None:
    """Writes a figure as PNG at 150 dpi; the same figure gives the same bytes.

    Args:
        figure: The figure.
        path: File to write.
    """
    with rc_context(RC):
        figure.savefig(path, dpi=DPI, metadata={"Software": None})


_HOME_COLOURS = (SKY, GREEN, BLUE, PURPLE, BLACK, GREY)
_BEYOND = (ORANGE, VERMILLION)
_SHORT_S, _LAST_S = 0.6, 0.1


@styled
def home(scene: Scene, name: str) -> Figure:
    """Draws the first moments, all the time, and the last tenth of a second of the force."""
    figure = _titled(
        11.0,
        7.2,
        f"Way home of {name}: let go {scene.facts['distance_at_start_mm']:.1f} mm from the origin, "
        f"k = {scene.facts['stiffness_N_per_m'] / MM_PER_M:g} N/mm",
    )
    grid = figure.add_gridspec(2, 2)
    first, entire, force = (
        figure.add_subplot(grid[0, 0]),
        figure.add_subplot(grid[0, 1]),
        figure.add_subplot(grid[1, :]),
    )
    capped = [run for run in scene.runs if run.facts["capped"]]
    beyond = [run for run in scene.runs if not run.facts["capped"]]
    colours = {run.name: colour for run, colour in zip(capped, _HOME_COLOURS, strict=False)}
    colours |= {run.name: colour for run, colour in zip(beyond, _BEYOND, strict=False)}
    start = scene.facts["distance_at_start_mm"]
    radius = scene.facts["home_radius_mm"]

    for ax in (first, entire):
        ax.axhspan(0.0, radius, color=GREY, alpha=0.13, linewidth=0.0)
        ax.set(ylim=(0.0, 1.05 * start), xlabel="time, s", ylabel="distance from the origin, mm")
    ends = []
    for run in capped:
        time, distance = run.series["time_s"], run.series["distance_mm"]
        near = (time >= 0.0) & (time <= _SHORT_S)
        first.plot(time[near], distance[near], color=colours[run.name], linewidth=1.6)
        text = f"{run.facts['damping_applied_N_s_per_m']:.3g} N s/m"
        ends.append((float(distance[near][-1]), text, colours[run.name]))
    first.set(xlim=(0.0, _SHORT_S), title="damping as far as the loop bears it")
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
        tail = run.series["time_s"] > time_end - _LAST_S
        pull = _main(run.series)[tail]
        force.step(
            1000.0 * (run.series["time_s"][tail] - time_end + _LAST_S), pull, color=colours[run.name], where="post"
        )
    for side in (-1.0, 1.0):
        force.axhline(side * scene.facts["force_limit_N"], color=GREY, linewidth=1.0, linestyle=(0, (4, 2)))
    force.text(0.3, scene.facts["force_limit_N"] + 0.06, "force limit", color=GREY, va="bottom", fontsize=8.5)
    force.set(
        xlim=(0.0, 1000.0 * _LAST_S), ylim=(-half, 1.1 * half), xlabel="time in the last tenth of a second, ms",
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


_NOISE_COLOURS = {"coarse": VERMILLION, "own": BLUE, "exact": GREEN}
_SHOWN_S = 0.1
_LAWS = {"spring": "held spring", "wall": "wall leant on"}
_SEGMENT = 4096  # Samples of a segment of the spectrum, half overlapping: 2 Hz at 8 kHz


@styled
def noise(scene: Scene, name: str) -> Figure:
    """Draws force against time and the handle's motion over frequency."""
    figure = Figure(figsize=(12.0, 7.0), layout="constrained")
    period = scene.facts["assumptions"]["period_s"]
    figure.suptitle(f"What encoders' noise does: {name}, {1e-3 / period:g} kHz")
    axes = figure.subplots(2, 2)
    for row, (law, title) in enumerate(_LAWS.items()):
        left, right = axes[row]
        for run in scene.runs:
            if run.facts["law"] != law:
                continue
            colour = _NOISE_COLOURS[run.facts["encoder"]]
            time = run.series["time_s"]
            shown = time >= time[-1] - _SHOWN_S
            force = run.series["force_asked_x_N"]
            own = run.label.split(", ", 1)[1]
            label = f"{own}: {run.facts['force_N_rms']:.3f} N rms, {run.facts['motion_um_rms']:.3f} um rms in the band"
            if run.facts["supervisor_bits"]:
                label += ";\nthe supervisor holds its force back"
            left.plot(time[shown], force[shown] - force[shown].mean(), color=colour, linewidth=0.8, label=label)
            at, density = spectrum(run.recording.knob[:, 0], period)
            right.loglog(at, 1e6 * density, color=colour, linewidth=0.9)
        low, high = scene.facts["limits"]["band_Hz"]
        right.axvspan(low, high, color="black", alpha=0.07, linewidth=0.0)
        right.set(xlim=(10.0, 0.5 / period), xlabel="frequency, Hz", ylabel="handle along x, um / sqrt(Hz)")
        left.set(ylabel="force asked along x, less its mean, N", xlabel="time, s", title=title)
        right.set_title("motion of the handle; shaded: where skin feels most")
        right.set_ylim(bottom=max(right.get_ylim()[0], 1e-8))
        low_y, high_y = left.get_ylim()
        left.set_ylim(low_y, high_y + 0.45 * (high_y - low_y))
        left.legend(loc="upper left", fontsize=7.5, frameon=False)
    return figure


def spectrum(series: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """Amplitude spectral density of a series by Welch's mean of Hann segments.

    Args:
        series: (n,)
        period: s.

    Returns:
        Frequencies from the second line on, Hz, and density, unit / sqrt(Hz).
    """
    from scipy.signal import welch

    at, power = welch(series - series.mean(), 1.0 / period, nperseg=min(_SEGMENT, len(series)))
    return at[2:], np.sqrt(np.maximum(power[2:], 1e-40))


_BIN_MM = 0.5
_ZOOM_MM = 14.0
_STAY = (4.2, 4.5)  # While the handle stays at the corner, s


@styled
def resistance(scene: Scene, name: str) -> Figure:
    """Draws both settings, over all the way and near the origin."""
    figure = _titled(11.0, 7.4, f"Operating resistance of {name}: the handle led to the cube's 8 corners and back")
    axes = figure.subplots(2, 2, sharey=True)
    limit = scene.facts["force_limit_N"]
    for column, (key, setting) in enumerate(scene.facts["settings"].items()):
        runs = [run for run in scene.runs if run.facts["setting"] == key]
        far = max(float(run.series["distance_mm"].max()) for run in runs)
        for ax, width in ((axes[0, column], far * 1.03), (axes[1, column], _ZOOM_MM)):
            _draw_setting(ax, runs, setting, limit, width, entire=ax is axes[0, column])
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


def _draw_setting(
    ax: Axes, runs: list[SceneRun], setting: dict[str, Any], limit: float, width: float, *, entire: bool
) -> None:
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
        chosen = (time > 0.0) & (time < _STAY[0] - 0.2) if way == 0 else time > _STAY[1]
        distance.append(run.series["distance_mm"][chosen])
        pull.append(run.series["pull_of_motors_N"][chosen])
    d, f = np.concatenate(distance), np.concatenate(pull)
    edges = np.arange(0.0, width + _BIN_MM, _BIN_MM)
    which = np.digitize(d, edges) - 1
    filled = [k for k in range(len(edges) - 1) if (which == k).any()]
    shares = np.array([np.percentile(f[which == k], [5.0, 50.0, 95.0]) for k in filled])
    return edges[filled] + _BIN_MM / 2.0, shares[:, 0], shares[:, 1], shares[:, 2]


_WALL_COLOURS = {"first": BLUE, "published": GREEN, "above": VERMILLION}
_MEANINGS = {"first": "the paper's first wall", "published": "the paper's largest", "above": "1.3 times our own limit"}
_TIME_S = (-0.05, 1.5)


@styled
def wall(scene: Scene, name: str) -> Figure:
    """Draws three walls across each axis."""
    figure = Figure(figsize=(12.0, 6.4), layout="constrained")
    hand = scene.facts["hand"]["name"]
    figure.suptitle(f"Virtual walls of {name}, pushed by a {hand} hand")
    axes = figure.subplots(2, 3, sharex=True, sharey="row")
    for column, (axis, limit) in enumerate(scene.facts["limits"].items()):
        runs = [run for run in scene.runs if run.facts["axis"] == axis]
        top, bottom = axes[0, column], axes[1, column]
        more = "more than " if limit["never_oscillated"] else ""
        top.set_title(f"{axis}: up to {more}{limit['simulated_N_per_mm']:.1f} N/mm here, "
                      f"{limit['published_N_per_mm']:g} in the paper")  # fmt: skip
        for run in runs[::-1]:  # the calm ones on top
            time, role = run.series["time_s"], run.facts["role"]
            shown = (time >= _TIME_S[0]) & (time <= _TIME_S[1])
            for ax, key in ((top, "penetration_mm"), (bottom, "wall_force_N")):
                ax.plot(
                    time[shown],
                    run.series[key][shown],
                    color=_WALL_COLOURS[role],
                    linewidth=1.3 if role != "above" else 0.9,
                )
        bottom.set_xlabel("time since the hand sets out, s")
    deepest = max(float(np.nanmax(run.series["penetration_mm"])) for run in scene.runs)
    axes[0, 0].set(ylabel="penetration, mm", ylim=(-0.35 * deepest, 1.15 * deepest), xlim=_TIME_S)
    limit = scene.facts["force_limit_N"]
    axes[1, 0].set(ylabel="force of the wall, N", ylim=(-0.05 * limit, 1.08 * limit))
    for column, axis in enumerate(scene.facts["limits"]):
        ends = []
        for run in scene.runs:
            if run.facts["axis"] == axis:
                end = float(np.mean(run.series["penetration_mm"][-200:]))
                text = f"{run.facts['stiffness_N_per_mm']:.3g} N/mm\n{_short(run.facts['verdict'])}"
                ends.append((end, text, _WALL_COLOURS[run.facts["role"]]))
        label_ends(axes[0, column], ends, gap=0.15)
    for role, meaning in _MEANINGS.items():
        axes[1, 0].plot([], [], color=_WALL_COLOURS[role], label=meaning)
    figure.legend(*axes[1, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    return figure


def _short(verdict: str) -> str:
    """Verdict without its explanation."""
    return verdict.split(":")[0].removeprefix("oscillates and ")


PICTURES = {"home": home, "noise": noise, "resistance": resistance, "wall": wall}  # Of the scene of that name
