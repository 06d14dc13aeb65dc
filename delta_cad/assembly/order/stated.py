"""The order in which a design is put together: units on the bench, then the machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import degrees

from delta_cad.assembly.order.drive import drive_unit, encoder_cheek_unit, shaft_unit
from delta_cad.assembly.order.panel import mounting_steps, panel_steps
from delta_cad.assembly.order.record import Bring, Leg, Step, Unit
from delta_cad.assembly.order.rods import pair_step, platform_unit, rod_unit
from delta_cad.assembly.order.shoulder import arm_unit, cheek_unit, pinion_unit, sector_unit
from delta_cad.assembly.supplies import supplies
from delta_cad.dimensions import Dimensions
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids.brackets import base_pin_mm
from delta_cad.solids.part import Occurrence

OVER_MM = 0.5  # by which a drive clears its own pins before it goes down


def order(d: Dimensions, occurrences: Sequence[Occurrence]) -> tuple[Unit, ...]:
    """States how a machine is put together.

    Args:
        d: Its dimensions.
        occurrences: All its parts; those of a pattern, such as screws, are found among them by their names.

    Returns:
        The units in the order in which they are made, the machine last.
    """
    names = tuple(o.name for o in occurrences)
    made = [arm_unit, cheek_unit, encoder_cheek_unit, drive_unit]
    if d.capstan is not None:
        made = [pinion_unit, sector_unit, *made]
        if d.sensed_at_shoulder:
            made.insert(-1, shaft_unit)
    units = [make(d, names, i) for make in made for i in CHAINS]
    units += [rod_unit(d, i, j) for i in CHAINS for j in SIDES]
    known = {supply.number for supply in supplies(d)}
    return tuple(_supplied(unit, known) for unit in (*units, platform_unit(d), _machine(d, names)))


def _supplied(unit: Unit, known: set[str]) -> Unit:
    """A unit whose steps name only those supplies that the design has: not every one needs keys of its own."""
    steps = (replace(step, supplies=tuple(one for one in step.supplies if one in known)) for step in unit.steps)
    return replace(unit, steps=tuple(steps))


def _machine(d: Dimensions, names: tuple[str, ...]) -> Unit:
    pins = tuple(name for name in names if name.startswith("base_dowel_"))
    feet = tuple(name for name in names if name.startswith("foot_") and name.removeprefix("foot_").isdigit())
    foot_screws = tuple(name for name in names if name.startswith("foot_screw_"))
    down, up = (Leg((0.0, 0.0, -1.0)),), (Leg((0.0, 0.0, 1.0)),)
    sunk, filled = base_pin_mm(d)
    over = (Leg((-1.0, 0.0, 0.0)), Leg((0.0, 0.0, -1.0), filled - sunk + OVER_MM))
    own_screws = d.foot.stud_length_mm is None
    steps = [
        Step(
            "Pins in the base plate",
            ("Press the pins into the plate from above until they stand flush with the bottom of their bores.",),
            (Bring(("base_plate",)), *(Bring((pin,), (Leg((0.0, 0.0, -1.0)),)) for pin in pins)),
            tools=("arbor press or vice with soft jaws",),
            checks=("Every pin stands upright and equally high.",),
        )
    ]
    for i in CHAINS:
        screws = tuple(name for name in names if name.startswith(f"base_screw_{i}_"))
        steps.append(
            Step(
                f"Drive {i} on the plate",
                (
                    "Bring the drive in from outside along its own radius, its foot block just over the pins, then let "
                    "it down: its neighbour's head reaches over it, so that it cannot come down from above.",
                    "Screw it down from below.",
                ),
                (
                    Bring((), over, f"foot_block_{i}", (f"drive {i}",)),
                    *(Bring((screw,), (Leg((0.0, 0.0, -1.0)),)) for screw in screws),
                ),
                screws,
                checks=("No light is seen under the foot block.",),
            )
        )
    if feet:
        steps.append(
            Step(
                "Feet",
                (
                    "Turn the machine on its back, on something soft, and screw the feet in by hand."
                    if not own_screws
                    else "Turn the machine on its back, on something soft, and screw the feet on.",
                ),
                (
                    *(Bring((foot,), up, "base_plate") for foot in feet),
                    *(Bring((screw,), (Leg((0.0, 0.0, -1.0)),)) for screw in foot_screws),
                ),
                foot_screws,
                checks=("The machine stands on a flat table and does not rock.",),
            )
        )
    steps += [
        Step(
            "Platform over the arms",
            (
                "Hold the platform over the arms at the height of the cube's middle, "
                f"{d.design.cube.bottom_height_mm + d.design.cube.half_side_mm:.0f} mm above the shoulders' axes, on a "
                "block or by a clamp on the knob.",
                "Wrist 0 is over arm 0.",
            ),
            (Bring((), down, "base_plate", ("platform",)),),
            tools=("a block or a stand that holds the platform",),
        ),
        *(pair_step(d, i) for i in CHAINS),
        *mounting_steps(d, names),
        *panel_steps(d, names),
        Step(
            "The whole machine",
            (
                "Keep the cut key and the long one with the machine: they reach the motors' and the pinions' screws "
                "when a motor is exchanged, the rest of the machine as it stands."
                if d.capstan is not None
                else "Connect motors and sensors; let all wires hang free of what moves.",
            ),
            supplies=("motor_key", "pinion_key"),
            checks=(
                "The handle goes to every corner of the cube without a catch.",
                "At each shoulder the angle shown is that of the drawing where the handle stands in the cube's middle: "
                f"{degrees(d.home_rad):.2f} deg, all three within 0.5 deg.",
            ),
        ),
    ]
    return Unit("machine", "machine", "The machine", tuple(steps))
