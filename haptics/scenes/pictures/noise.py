"""Picture of noise: force that encoders command, and what it moves the handle by, over frequency."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from delta_cad.common.picture_style import BLUE, GREEN, VERMILLION, styled
from haptics.scenes.record import Scene

COLOURS = {"coarse": VERMILLION, "own": BLUE, "exact": GREEN}
SHOWN_S = 0.1
LAWS = {"spring": "held spring", "wall": "wall leant on"}
SEGMENT = 4096  # Samples of a segment of the spectrum, half overlapping: 2 Hz at 8 kHz


@styled
def picture(scene: Scene, name: str) -> Figure:
    """Draws force against time and the handle's motion over frequency.

    Args:
        scene: Scene made by `noise`.
        name: Name of the design.

    Returns:
        The figure, 12 x 7 inches.
    """
    figure = Figure(figsize=(12.0, 7.0), layout="constrained")
    period = scene.facts["assumptions"]["period_s"]
    figure.suptitle(f"What encoders' noise does: {name}, {1e-3 / period:g} kHz", fontsize=12)
    axes = figure.subplots(2, 2)
    for row, (law, title) in enumerate(LAWS.items()):
        left, right = axes[row]
        for run in scene.runs:
            if run.facts["law"] != law:
                continue
            colour = COLOURS[run.facts["encoder"]]
            time = run.series["time_s"]
            shown = time >= time[-1] - SHOWN_S
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

    at, power = welch(series - series.mean(), 1.0 / period, nperseg=min(SEGMENT, len(series)))
    return at[2:], np.sqrt(np.maximum(power[2:], 1e-40))
