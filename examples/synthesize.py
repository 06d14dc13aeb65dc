"""Dimensions from requirements: the largest cube, with its proof: `python examples/synthesize.py`."""

import tomllib

from optimizer.problem.requirements import requirements_from_dict
from optimizer.synthesis.output import design_of
from optimizer.synthesis.three_step import Run

REQUIREMENTS = """
name = "small-joystick"
[requirements]
envelope_width_mm = 270
envelope_depth_mm = 220
force_N = 3
joint_torque_N_m = 0.8
[bounds_mm]                      # [lower, upper]; equal bounds fix a length
upper_arm_length = [82, 82]
forearm_length = [40, 130]
base_radius = [40, 40]
platform_radius = [20, 45]
bottom_height = [40, 100]
half_side = [0, 100]
[limits]
kappa_max = 2.5
"""

given = requirements_from_dict(tomllib.loads(REQUIREMENTS))
results = Run(given, method="sqp", seed=1, steps=(1, 2), prove=True).results()
design = design_of(given, results, "sqp", 1, "small-joystick.json")

# Expect a smaller cube in step 2, where torque and condition number are limits, and bounds just above both.
for result in results:
    bound = result.proof.bound if result.proof else None  # half a side, as the objective
    proved = f"none above {2 * bound:.3f} mm exists" if bound else "nothing proved"
    print(f"step {result.problem.step}: cube of {2 * result.objective:.3f} mm; {proved}")
print(f"forearm {design.mechanism.forearm_length_mm} mm, platform radius {design.mechanism.platform_radius_mm} mm")
