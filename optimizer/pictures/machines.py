"""Picture of the front of machines: the cube against effective mass, friction, stiffness and outline."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from delta_cad.common.picture_style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILLION, styled
from optimizer.codesign.variants.front import MachinePoint, hardware_of
from optimizer.pictures.style import pretty

COLOURS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)
PANELS = (
    ("effective_mass", "effective mass, heaviest direction (kg)", lambda f: f.effective_mass_kg),
    ("friction", "friction at the handle (N)", lambda f: f.friction_N),
    ("stiffness", "stiffness at the knob, softest direction (N/mm)", lambda f: f.stiffness_N_mm),
    ("outline", "outline, width (mm)", lambda f: f.outline_mm[0]),
)


@styled
def machines(points: Sequence[MachinePoint], title: str) -> Figure:
    """Draws the cube of every point over what it costs, hardware by colour, points on the front filled.

    Args:
        points: The front.
        title: Name of the requirements.

    Returns:
        The figure, 11 x 8 inches.
    """
    figure = Figure(figsize=(11.0, 8.4), layout="constrained")
    figure.suptitle(pretty(f"{title}: machines of the same task, at the worst place of their cubes"), fontsize=12)
    choices = hardware_of(points)
    for ax, (name, label, value) in zip(figure.subplots(2, 2, sharey=True).flat, PANELS, strict=True):
        for choice, colour in zip(choices, COLOURS, strict=False):
            own = [point for point in points if point.choice == choice]
            line = sorted((p for p in own if p.axis in (name, "asked")), key=lambda p: value(p.figures))
            ax.plot(
                [value(p.figures) for p in line], [p.figures.cube_side_mm for p in line], color=colour, linewidth=1.4
            )
            for point in own:
                ax.plot(
                    value(point.figures),
                    point.figures.cube_side_mm,
                    "*" if point.axis == "asked" else "o",
                    color=colour,
                    markersize=11 if point.axis == "asked" else 4.5,
                    markerfacecolor=colour if point.on_front else "white",
                )
            ax.plot([], [], color=colour, label=pretty(f"{choice.motor}, {choice.drive} {choice.ratio:g}:1"))
        ax.set(xlabel=label)
        ax.grid(visible=True)
    for ax in figure.axes[::2]:
        ax.set_ylabel("side of the cube (mm)")
    figure.axes[0].legend(loc="lower right")
    return figure
