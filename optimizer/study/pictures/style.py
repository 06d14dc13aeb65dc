"""What the pictures of the optimiser share beside their style: signs as in print, a scale, the files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from delta_cad.common.picture_style import DPI, RC

WIDE = 10.0


def pretty(text: str) -> str:
    """Sets text with the paper's indices and signs as they are set in print."""
    return (
        text.replace("L_A", "$L_A$")
        .replace("L_B", "$L_B$")
        .replace(">=", "\N{GREATER-THAN OR EQUAL TO}")
        .replace("<=", "\N{LESS-THAN OR EQUAL TO}")
    )


def kappa_scale(ax: Axes, kappas: Sequence[float]) -> None:
    """Sets a logarithmic scale with plain numbers where condition numbers differ by more than `WIDE`."""
    if max(kappas) > WIDE * min(kappas):
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter("{x:g}")


def save(figure: Figure, folder: Path, name: str) -> None:
    """Writes a figure as PNG at 150 dpi and as SVG, under a name without ending."""
    with rc_context(RC):
        figure.savefig(folder / f"{name}.png", dpi=DPI, metadata={"Software": None})
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None, "Creator": None})
