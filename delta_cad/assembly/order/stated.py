"""The order in which a design is put together: units on the bench, then the machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import degrees

from delta_cad.assembly.leads import lead_steps
from delta_cad.assembly.order.drive import drive_unit, encoder_cheek_unit, shaft_unit
from delta_cad.assembly.order.panel import mounting_steps, panel_steps
from delta_cad.assembly.order.record import Bring, Leg, Step, Unit
from delta_cad.assembly.order.rods import pair_step, platform_unit, rod_unit
from delta_cad.assembly.order.shoulder import arm_unit, cheek_unit, named, pinion_unit, sector_unit
from delta_cad.assembly.supplies import supplies
from delta_cad.dimensions import Dimensions
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids.brackets import base_pin_mm
from delta_cad.solids.part import Occurrence


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


def _kept(d: Dimensions) -> tuple[str, ...]:
    """What is said of the keys that stay with a machine."""
    if d.capstan is None:
        return ()
    return (
        "Keep the cut key and the long one with the machine: they reach the motors' and the pinions' screws when a "
        "motor is exchanged, the rest of the machine as it stands.",
    )


def _supplied(unit: Unit, known: set[str]) -> Unit:
    """A unit whose steps name only those supplies that the design has: not every one needs keys of its own."""
    steps = (replace(step, supplies=tuple(one for one in step.supplies if one in known)) for step in unit.steps)
    return replace(unit, steps=tuple(steps))


def _machine(d: Dimensions, names: tuple[str, ...]) -> Unit:
    feet = tuple(name for name in names if name.startswith("foot_") and name.removeprefix("foot_").isdigit())
    foot_screws = tuple(name for name in names if name.startswith("foot_screw_"))
    down, up = (Leg((0.0, 0.0, -1.0)),), (Leg((0.0, 0.0, 1.0)),)
    inwards = (Leg((-1.0, 0.0, 0.0)),)
    under = d.base.thickness_mm - base_pin_mm(d)[0]
    own_screws = d.foot.stud_length_mm is None
    steps = [
        Step(
            "Base plate",
            ("Lay the plate on two blocks, high enough to reach under it, its counterbores below.",),
            (Bring(("base_plate",)),),
            checks=("Its upper side is clean and without burrs.",),
        )
    ]
    for i in CHAINS:
        screws, pins = named(names, f"base_screw_{i}_"), named(names, f"base_dowel_{i}_")
        steps.append(
            Step(
                f"Drive {i} on the plate",
                (
                    "Slide the drive in on the plate from outside, along its own radius: its neighbour's head reaches "
                    "over it, so that it cannot come down from above.",
                    f"Tap both pins through the plate into the foot block from below, until they stand {under:.1f} mm "
                    "deep in the plate, and screw it down from below.",
                ),
                (
                    Bring((), inwards, f"foot_block_{i}", (f"drive {i}",)),
                    *(Bring((pin,), up) for pin in pins),
                    *(Bring((screw,), (Leg((0.0, 0.0, -1.0)),)) for screw in screws),
                ),
                screws,
                tools=("drift 3 mm and a light hammer", "feeler gauge 0.05 mm"),
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
        *lead_steps(d),
        *panel_steps(d, names),
        Step(
            "The whole machine",
            ("Connect motors and sensors; let all wires hang free of what moves.", *_kept(d)),
            supplies=("motor_key", "pinion_key"),
            checks=(
                "The handle goes to every corner of the cube without a catch.",
                "At each shoulder the angle shown is that of the drawing where the handle stands in the cube's middle: "
                f"{degrees(d.home_rad):.2f} deg, all three within 0.5 deg.",
            ),
        ),
    ]
    return Unit("machine", "machine", "The machine", tuple(steps))
