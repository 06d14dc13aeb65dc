"""Torques that hold the machine against its weight: `python examples/gravity.py [mass_properties.json]`.

The masses are those of the solids: run `make build` first, or name the file of another build.
"""

import sys
from pathlib import Path

import numpy as np

from haptics.gravity import gravity_torque
from haptics.model.machine import load_machine

machine = load_machine(Path("best.json"), Path(sys.argv[1]) if len(sys.argv) > 1 else None)
cube = machine.design.cube
heights = np.linspace(0, 2 * cube.half_side_mm, 3) + cube.bottom_height_mm  # floor, centre, ceiling
p = np.stack([[cube.centre_x_mm or 0.0, 0.0, height] for height in heights]) / 1000

level = gravity_torque(machine.geometry, machine.masses, p, [0.0, 0.0, -9.81])
tilt = np.radians(30.0)
tilted = gravity_torque(machine.geometry, machine.masses, p, [9.81 * np.sin(tilt), 0.0, -9.81 * np.cos(tilt)])

# Expect equal torques of three-fold symmetric chains, unequal ones in a dashboard that leans by 30 degrees.
for height, even, uneven in zip(heights, level, tilted, strict=True):
    print(f"z = {height:6.2f} mm: level {even.round(4)} N m, tilted {uneven.round(4)} N m")
