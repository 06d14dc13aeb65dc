"""Picture of how the front moves with the outline and with the joints' torque."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from delta_cad.common.picture_style import BLUE, GREEN, GREY, VERMILLION, styled
from optimizer.study.front import Curve
from optimizer.study.pictures.style import kappa_scale, pretty
from optimizer.study.trade import Trade

STYLES = ((GREEN, (0, (1, 1)), "s"), (VERMILLION, (0, (5, 1.5)), "D"))


@styled
def trade(fronts: Trade, title: str) -> Figure:
    """Draws both families over the front as required, one picture each.

    Args:
        fronts: The fronts.
        title: Name of the requirements.

    Returns:
        The figure, 11 x 5 inches.
    """
    figure = Figure(figsize=(11.0, 5.4), layout="constrained")
    figure.suptitle(pretty(title), fontsize=12)
    left, right = figure.subplots(1, 2, sharey=True)
    width, depth = fronts.main.points[-1].outline
    reach = fronts.main.points[-1].reach
    _family(
        left, fronts.main, fronts.outlines, f"as required: R + L_A {reach:.4g} mm, outline {width:.0f} x {depth:.0f} mm"
    )
    left.set(title="other outlines", ylabel="worst condition number in the cube")
    _family(right, fronts.main, fronts.torques, f"as required; it needs up to {fronts.torque_needed:.3f} N m")
    right.set(title="less torque for the force")
    kappa_scale(left, [point.kappa for curve in fronts.curves for point in curve.points])
    return figure


def _family(ax: Axes, main: Curve, others: Sequence[Curve], label: str) -> None:
    _line(ax, main, label, BLUE, "-", "o")
    for curve, (colour, line, mark) in zip(others, STYLES, strict=False):
        if curve.points:
            _line(ax, curve, _label(curve), colour, line, mark)
        else:
            ax.plot([], [], color=GREY, label=pretty(f"{curve.words}: no design"))
    ax.set_xlabel("side of the cube, 2 L (mm)")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13))


def _line(ax: Axes, curve: Curve, label: str, colour: str, line: object, mark: str) -> None:
    sides = [2.0 * point.half_side for point in curve.points]
    kappas = [point.kappa for point in curve.points]
    ax.plot(
        sides, kappas, color=colour, linestyle=line, linewidth=1.6, marker=mark, markersize=3.5, label=pretty(label)
    )


def _label(curve: Curve) -> str:
    last = curve.points[-1]
    if curve.name.startswith("outline"):
        width, depth = last.outline
        return f"R + L_A {last.reach:.4g} mm, outline {width:.0f} x {depth:.0f} mm"
    starts = next((2.0 * point.half_side for point in curve.points if "torque" in point.active), None)
    return curve.words + ("" if starts is None else f": binds from {starts:.0f} mm on")
