"""A small machine of simple solids on the real link placement: every volume has a closed form."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.export.mass_properties import part_mass_properties
from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.placement import LinkPlacement, chain_turn
from delta_cad.solids.part import Hole, Material, Occurrence, Part

if TYPE_CHECKING:
    import cadquery as cq

HOME_MM = np.array([0.0, 0.0, 94.6])
ARM_MM, ROD_MM, WIDTH_MM = 82.0, 112.079, 54.0
ALUMINIUM = Material("EN AW-7075 T6", 2810.0, (0.85, 0.42, 0.12))
STEEL = Material("steel 1.4301", 7900.0, (0.70, 0.72, 0.75))
CARBON = Material("carbon tube", 1600.0, (0.10, 0.10, 0.11))
BLACK = Material("motor", 4000.0, (0.15, 0.16, 0.18))


def translation(x: float, y: float, z: float) -> np.ndarray:
    frame = np.eye(4)
    frame[:3, 3] = x, y, z
    return frame


def one_solid(workplane: cq.Workplane) -> cq.Solid:
    (solid,) = workplane.solids().vals()
    return solid  # type: ignore[return-value]


def along_x(length: float, radius: float, bore: float = 0.0) -> cq.Solid:
    import cadquery as cq

    ring = cq.Workplane("YZ").circle(radius)
    return one_solid((ring.circle(bore) if bore else ring).extrude(length))


def make_parts(arm_hole_mm: float = 6.0) -> dict[str, Part]:
    import cadquery as cq

    plate = cq.Workplane().circle(88.0).extrude(8.0).faces(">Z").workplane().polarArray(80.0, 0, 360, 6).hole(4.5)
    arm = cq.Workplane("XZ").rect(ARM_MM, 14.0).extrude(4.0, both=True).translate((ARM_MM / 2, 0, 0))
    arm = arm.faces("<Y").workplane(origin=(ARM_MM / 2, 0, 0)).hole(arm_hole_mm)
    platform = cq.Workplane().polygon(6, 60.0).extrude(5.0, both=True)
    motor = cq.Workplane("XZ").circle(15.0).extrude(68.0)
    parts = (
        Part("base_plate", "Base plate", one_solid(plate), ALUMINIUM, True, (Hole(4.5, 6, "4.5 through"),)),
        Part("upper_arm", "Upper arm", one_solid(arm), ALUMINIUM, True, (Hole(arm_hole_mm, 1, "6 H7 through"),)),
        Part("rod_tube", "Forearm tube 5x3", along_x(ROD_MM, 2.5, 1.5), CARBON, True),
        Part("platform", "Moving platform", one_solid(platform), STEEL, True),
        Part("ball_8", "Ball 8 mm", cq.Solid.makeSphere(4.0, angleDegrees1=-90), STEEL, False, (), 2.05, "DIN 5401",
             "K-8", "datasheet"),
        Part("motor_30x68", "Motor 30 x 68, 60 W", one_solid(motor), BLACK, False, (), 240.0, "", "M-30", "datasheet"),
    )  # fmt: skip
    return {part.number: part for part in parts}


def make_assembly(parts: dict[str, Part] | None = None, name: str = "test-joystick") -> Assembly:
    parts = parts or make_parts()
    geometry = DeltaGeometry(0.040, 0.030, ARM_MM / 1000, ROD_MM / 1000)
    placed = [
        Occurrence("base_plate", parts["base_plate"], "base", translation(0, 0, -64)),
        Occurrence("platform", parts["platform"], "platform", np.eye(4)),
    ]
    for i in range(3):
        motor = chain_turn(geometry, i) @ translation(35.0, -3.0, -21.0)
        placed.append(Occurrence(f"motor_{i}", parts["motor_30x68"], "base", motor))
        placed.append(Occurrence(f"upper_arm_{i}", parts["upper_arm"], f"upper_arm_{i}", np.eye(4)))
        for j in range(2):
            placed.append(Occurrence(f"rod_tube_{i}_{j}", parts["rod_tube"], f"rod_{i}_{j}", np.eye(4)))
            elbow = translation(ARM_MM, (j - 0.5) * WIDTH_MM, 0.0)
            placed.append(Occurrence(f"ball_{i}_{j}_elbow", parts["ball_8"], f"upper_arm_{i}", elbow))
    placement = LinkPlacement(geometry, WIDTH_MM, (20.0, -40.0), 9.0)
    return Assembly(name, tuple(placed), (), (), placement, HOME_MM)


VOLUMES_MM3 = {
    "base_plate": math.pi * 8.0 * (88.0**2 - 6 * 2.25**2),
    "upper_arm": 8.0 * (ARM_MM * 14.0 - math.pi * 9.0),
    "rod_tube": math.pi * ROD_MM * (2.5**2 - 1.5**2),
    "platform": 10.0 * 1.5 * math.sqrt(3.0) * 30.0**2,
    "ball_8": 4.0 / 3.0 * math.pi * 64.0,
    "motor_30x68": math.pi * 225.0 * 68.0,
}


def unit_masses(machine: Assembly) -> dict[str, float]:
    """Part number -> mass of one, kg, integrated from its solid."""
    return {part.number: part_mass_properties(part).mass_kg for part in machine.parts}
