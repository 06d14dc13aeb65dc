"""The list of holes: one row for each bore of each made part, with position and machining."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from delta_cad.assembly.machine import Assembly
from delta_cad.export.bom import write_csv
from delta_cad.solids.part import Bore, Hole

_DECIMALS = 3  # a micrometre: what a bore is measured to
_UNIT_DECIMALS = 6  # of a direction


@dataclass(frozen=True)
class HoleRow:
    """One bore or slot of one part, in the part's frame as its STEP file has it; None where there is nothing to say.

    Attributes:
        part: Part number.
        hole: Number of its group of equal diameter and number within it, such as "#3.2"; of slots the group's. No
            drawing's tag looks like it: a drawing has letters, in an order of its own, and finds a bore by its place.
        x_mm: Where its axis, of a pin's slot its middle, enters what is bored, as `y_mm` and `z_mm`.
        direction_x: Unit vector along the axis into the material, as `direction_y` and `direction_z`.
        diameter_mm: Of the bore, a thread's drill; of a slot its width.
        depth_mm: Of the full diameter, without a tip.
        end: "through", "flat", or the angle of the drill's tip, deg.
        thread: Such as "M4".
        thread_depth_mm: Usable depth of the thread.
        fit: ISO 286 class.
        lower_um: Lower deviation of the diameter; where there is none the general tolerance holds.
        upper_um: Upper deviation.
        surface_ra_um: Roughness of the wall.
        callout: What the drawing says.
    """

    part: str
    hole: str
    x_mm: float | None = None
    y_mm: float | None = None
    z_mm: float | None = None
    direction_x: float | None = None
    direction_y: float | None = None
    direction_z: float | None = None
    diameter_mm: float = 0.0
    depth_mm: float | None = None
    end: str = ""
    thread: str = ""
    thread_depth_mm: float | None = None
    fit: str = ""
    lower_um: float | None = None
    upper_um: float | None = None
    surface_ra_um: float | None = None
    callout: str = ""


def hole_list(assembly: Assembly) -> list[HoleRow]:
    """Lists every declared bore and slot of every part that is made, in order of first use."""
    groups = ((part, k, hole) for part in assembly.parts for k, hole in enumerate(part.holes, 1))
    stated = ((part, k, hole) for part, k, hole in groups if part.make or (part.to_drawing and hole.bores))
    return [row for part, k, hole in stated for row in _rows(part.number, f"#{k}", hole)]


def write_holes(rows: list[HoleRow], path: Path) -> None:
    """Writes the list of holes as CSV."""
    write_csv(path, HoleRow, rows)


def _rows(part: str, group: str, hole: Hole) -> Iterator[HoleRow]:
    if not (hole.bores or hole.slots):
        yield HoleRow(part, group, diameter_mm=round(hole.diameter_mm, _DECIMALS), callout=hole.callout)
    for number, slot in enumerate(hole.slots, start=1):
        as_bore = Bore(slot.start_mm, slot.direction, slot.width_mm, slot.depth_mm, callout=hole.callout)
        yield _row(part, f"{group}.{number}", replace(as_bore, fit=slot.fit, deviations_um=slot.deviations_um))
    for number, bore in enumerate(hole.bores, start=1):
        yield _row(part, f"{group}.{number}", bore)


def _row(part: str, name: str, bore: Bore) -> HoleRow:
    """The row of a bore, without a negative zero."""
    x, y, z = (round(v, _DECIMALS) + 0.0 for v in bore.start_mm)
    u, v, w = (round(v, _UNIT_DECIMALS) + 0.0 for v in bore.direction)
    lower, upper = bore.deviations_um or (None, None)
    return HoleRow(
        part=part,
        hole=name,
        x_mm=x,
        y_mm=y,
        z_mm=z,
        direction_x=u,
        direction_y=v,
        direction_z=w,
        diameter_mm=round(bore.diameter_mm, _DECIMALS),
        depth_mm=round(bore.depth_mm, _DECIMALS),
        end="through" if bore.through else f"{bore.tip_deg:g}" if bore.tip_deg else "flat",
        thread=bore.thread,
        thread_depth_mm=round(bore.thread_mm, _DECIMALS) if bore.thread else None,
        fit=bore.fit,
        lower_um=lower,
        upper_um=upper,
        surface_ra_um=bore.surface_um,
        callout=bore.callout,
    )
