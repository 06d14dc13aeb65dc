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
# What else a row asks for. A motor's ratio gives its joint what the design asks for ever; a thicker arm is clamped on a
# motor's own shaft; larger balls want a wider platform.
WITH: dict[str, Changes] = {
    "faulhaber-3257g024cr": {"hardware__capstan_ratio": 5.85},
    "maxon-ec45flat-411812": {"hardware__capstan_ratio": 3.2, "hardware__sector_radius_mm": 30.0},
    "10": {"mechanism__platform_radius_mm": 26.0},
}


def offered() -> dict[str, Changes]:
    """Gives every row of the drives' catalogue, by family and id, and the changes that put it into the machine."""
    found: dict[str, Changes] = {}
    for key, row in catalogue.motor.rows.items():
        if "capstan" in row.drives:
            found[f"motor {key}"] = {"hardware__motor": key} | WITH.get(key, {})
    for family in ("cable", "bearing", "tube", "encoder", "magnet", "knob", "foot"):
        for key in catalogue.family(family):
            found[f"{family} {key}"] = {f"hardware__{family}": key}
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
