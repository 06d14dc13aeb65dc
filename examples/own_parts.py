"""A motor and a rope of one's own, from CSV files in a folder: `python examples/own_parts.py`, beside best.json."""

import json
import os
from pathlib import Path

from delta_cad import catalogue
from delta_cad.design import design_to_dict, load_design
from delta_cad.drive import drive_torque

folder = (
    Path(__file__).parent / "my-parts"
)  # motor.csv and cable.csv, with the columns that must be stated and a few more
own = catalogue.own_parts(folder)

data = design_to_dict(load_design("best.json"))
data["name"] = "own-parts"
data["hardware"] |= {"catalogue": os.path.relpath(folder), "motor": "example-30", "cable": "example-rope"}
Path("own.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")

# The file names the folder from where it stands, so every command takes it: build, check, inspect, certify, feel, ...
design = load_design("own.json")
before, after = drive_torque(load_design("best.json")), drive_torque(design)

print(f"own rows         {', '.join(f'{family} {key}' for family, rows in own.rows.items() for key in rows)}")
print(f"continuous torque{before.continuous_torque_N_m:.3f} -> {after.continuous_torque_N_m:.3f} N m")
print(f"peak torque      {before.peak_torque_N_m:.3f} -> {after.peak_torque_N_m:.3f} N m for {after.peak_time_s:g} s")
print(
    f"rotor's inertia  {before.reflected_inertia_kg_m2:.2e} -> {after.reflected_inertia_kg_m2:.2e} kg m2 at the joint"
)
