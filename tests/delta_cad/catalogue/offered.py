"""`python -m tests.delta_cad.catalogue.offered [WORD ...]`: every row offered for a drive, in a machine that passes.

Each is the committed design with the row in it and what goes with it, and all checks are run. Exit code 1 if one fails.
"""

from __future__ import annotations

import sys
from time import perf_counter
from typing import Any

from delta_cad import catalogue
from delta_cad.commands.pipeline import check
from delta_cad.design import Design, design_from_dict
from tests.committed import changed

Changes = dict[str, Any]
# What else a row asks for. What is wider along the shoulder's axis wants a wider base: base and platform grow alike, so
# that every length that the mechanism's mathematics knows, and every limit of the committed design, stays. What is
# heavier wants more torque; a thin shaft a larger sector; a heavier knob and smaller balls bear a lower peak.


def wider(mm: float) -> Changes:
    """The committed design with base and platform larger by a length, torque for the weight, and room."""
    return {
        "mechanism__base_radius_mm": 31.0 + mm,
        "mechanism__platform_radius_mm": 24.0 + mm,
        "requirements__envelope_width_mm": 270.0 + 2.0 * mm,
        "requirements__envelope_depth_mm": 220.0 + 3.0 * mm,
        "requirements__joint_torque_N_m": 0.42,
        "hardware__capstan_ratio": 5.2,
    }


DESK: Changes = {  # what `optimizer synthesize` makes of tests/references/sizes/desk-150.toml
    "mechanism__base_radius_mm": 60.0,
    "mechanism__platform_radius_mm": 42.0,
    "mechanism__upper_arm_length_mm": 162.0,
    "mechanism__forearm_length_mm": 257.438,
    "mechanism__parallelogram_width_mm": 94.0,
    "cube__bottom_height_mm": 119.621,
    "cube__half_side_mm": 75.0,
    "requirements__envelope_width_mm": 560.0,
    "requirements__envelope_depth_mm": 520.0,
    "requirements__force_N": 10.0,
    "requirements__peak_force_N": None,
    "requirements__joint_torque_N_m": 2.9,
    "requirements__peak_torque_N_m": None,
    "requirements__kappa_max": 2.3,
    "hardware__capstan_ratio": 7.6,
    "hardware__sector_radius_mm": 68.0,
    "hardware__cable": "steel-0.8-7x19",
    "hardware__ball_diameter_mm": 8.0,
    "hardware__base_plate_thickness_mm": 10.0,
    "hardware__platform_thickness_mm": 16.0,
}
WITH: dict[str, Changes] = {
    "faulhaber-3257g024cr": wider(2.0) | {"hardware__capstan_ratio": 6.3, "hardware__sector_radius_mm": 44.0},
    "maxon-re30-310009-500": wider(16.0)  # 21 mm longer; rods farther apart hold the larger platform
    | {"hardware__encoder_at": "motor", "mechanism__parallelogram_width_mm": 60.0},
    "maxon-re50-370354": DESK,
    "steel-0.8-7x19": wider(3.0),
    "cfrp-6x4": wider(1.0),  # heavier rods
    "619-8": wider(1.0),
    "608": wider(4.0),
    "din319-32": wider(1.0) | {"requirements__peak_force_N": 5.9},
    "5": {"requirements__peak_force_N": 5.6},
    "8": wider(1.0),
    "10": wider(1.0),
}


def offered() -> dict[str, Changes]:
    """Gives every row of the drives' catalogue, by family and id, and the changes that put it into the machine."""
    found: dict[str, Changes] = {}
    for key, row in catalogue.motor.rows.items():
        if "capstan" in row.drives:
            found[f"motor {key}"] = {"hardware__motor": key} | WITH.get(key, {})
    for family in ("cable", "bearing", "tube", "encoder", "magnet", "knob", "foot"):
        for key in catalogue.family(family):
            found[f"{family} {key}"] = {f"hardware__{family}": key} | WITH.get(key, {})
    for size in sorted({row.diameter_mm for row in catalogue.ball.rows.values()}):
        found[f"ball {size:g}"] = {"hardware__ball_diameter_mm": size} | WITH.get(f"{size:g}", {})
    return found


def machine(changes: Changes) -> Design:
    """The committed design with some of its numbers changed."""
    return design_from_dict(changed(**changes))


def main(words: list[str]) -> int:
    """Checks the machines that have one of the words in their name, or all."""
    failed = 0
    for name, changes in offered().items():
        if words and not any(word in name for word in words):
            continue
        start = perf_counter()
        try:
            bad = [r.name for r in check(machine(changes)).results if not r.passed]
        except ValueError as error:
            bad = [str(error)]
        failed += bool(bad)
        print(f"{name}: {'; '.join(bad) or 'passes'} ({perf_counter() - start:.0f} s)", flush=True)
    print(f"{failed} fail")
    return 1 if failed else 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
