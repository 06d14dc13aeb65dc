"""Map of the condition number over a slice of the workspace: `python examples/conditioning_map.py [picture.png]`."""

import sys

import matplotlib.pyplot as plt
import numpy as np

from delta_cad.design import load_design
from delta_cad.mechanism import closure_margin, conditioning

design = load_design("best.json")
bottom, half, middle = design.cube.bottom_height_mm, design.cube.half_side_mm, design.cube.centre_x_mm or 0.0
x, z = np.meshgrid(np.linspace(-2 * half, 2 * half, 241), np.linspace(bottom - 20, bottom + 2 * half + 40, 161))
x += middle
p = np.stack([x, np.zeros_like(x), z], axis=-1) / 1000  # (161, 241, 3) m, the plane y = 0

reached = closure_margin(design.geometry, p).min(axis=-1) > 0
kappa = np.full(x.shape, np.nan)
kappa[reached] = conditioning(design.geometry, p[reached])
inside = (abs(x - middle) <= half) & (z >= bottom) & (z <= bottom + 2 * half)

# Expect the worst of the slice below the limit of 2.27, at the cube's floor or ceiling, and better at its centre.
worst = np.nanargmax(np.where(inside, kappa, np.nan))
print(f"best in the cube's slice   {kappa[inside].min():.3f}")
print(f"worst in the cube's slice  {kappa.flat[worst]:.3f} at x = {x.flat[worst]:.1f} mm, z = {z.flat[worst]:.1f} mm")
print(f"within reach               {100 * reached.mean():.1f} % of the picture")

figure, axes = plt.subplots()
axes.add_patch(plt.Rectangle((middle - half, bottom), 2 * half, 2 * half, fill=False))
figure.colorbar(axes.contourf(x, z, kappa, levels=np.linspace(1, 5, 17), extend="max"), label="condition number")
axes.set(xlabel="x, mm", ylabel="z, mm", aspect="equal")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "out/conditioning.png")
plt.close(figure)
