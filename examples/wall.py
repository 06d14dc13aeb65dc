"""A wall rendered on the simulated device at 1 kHz: `python examples/wall.py [mass_properties.json]`.

The masses are those of the solids: run `make build` first, or name the file of another build. The loop is the plain one
of a textbook; the controller with its supervisor is `haptics.devices.host.Host`.
"""

import sys
from pathlib import Path

import numpy as np

from delta_cad.mechanism import forward_kinematics, jacobian
from haptics.devices.device import Reading, run
from haptics.devices.simulated import SimulatedDevice
from haptics.gravity import gravity_torque
from haptics.model.machine import load_machine
from haptics.model.plant import plant
from haptics.rendering import virtual_wall

STIFFNESS, DAMPING, PUSH = 1000.0, 10.0, 2.0  # N/m, N s/m, N
GRAVITY = (0.0, 0.0, -9.81)

machine = load_machine(Path("best.json"), Path(sys.argv[1]) if len(sys.argv) > 1 else None)
centre = machine.design.workspace.centre  # of the cube, m
wall = centre + np.array([0.0, 0.0, 0.005])  # 5 mm above the handle; free below
device = SimulatedDevice(plant(machine.geometry, machine.masses, GRAVITY), centre)
device.force = np.array([0.0, 0.0, PUSH])  # a finger that pushes upwards
path = [centre]


def tick(sample: Reading) -> np.ndarray:
    """Joint torques of one period: the wall's force through the Jacobian, and the machine's own weight."""
    p = forward_kinematics(machine.geometry, sample.angles)
    v = (p - path[-1]) / device.period
    path.append(p)
    force = virtual_wall(p, v, stiffness=STIFFNESS, damping=DAMPING, point=wall, normal=[0.0, 0.0, -1.0])
    return jacobian(machine.geometry, p).T @ force + gravity_torque(machine.geometry, machine.masses, p, GRAVITY)


run(device, tick, ticks=1000)
depth = (np.array(path)[:, 2] - wall[2]) * 1000

# Expect the handle to touch within 0.1 s, dive to more than twice the depth of rest, and stay at push over stiffness.
print(f"touches after   {np.argmax(depth > 0) * device.period * 1000:.0f} ms")
print(f"deepest         {depth.max():.3f} mm")
print(f"after 1 s       {depth[-1]:.3f} mm; push over stiffness is {PUSH / STIFFNESS * 1000:.3f} mm")
