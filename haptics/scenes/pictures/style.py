"""What the pictures of haptics share beside their style: labels that keep apart, and the file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from delta_cad.common.picture_style import DPI, RC


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


def save(figure: Figure, path: Path) -> None:
    """Writes a figure as PNG at 150 dpi; the same figure gives the same bytes.

    Args:
        figure: The figure.
        path: File to write.
    """
    with rc_context(RC):
        figure.savefig(path, dpi=DPI, metadata={"Software": None})
