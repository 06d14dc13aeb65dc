"""An atlas of machines: a brief a set, its machine a row with hardware, figures, lengths and a design file."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from delta_cad.design import design_from_dict, load_design
from optimizer.codesign.hardware import Selection
from optimizer.codesign.search import Search
from optimizer.study import atlas as module
from optimizer.study.atlas import atlas_files, page
from optimizer.study.cluster import solve
from optimizer.study.grid import MACHINES, Grid, grid_from_dict
from optimizer.study.machines import Figures, MachinePoint
from optimizer.study.pictures import atlas_map, cells, png
from tests.committed import BEST

MOTOR = "maxon-re30-310007"
TASK: dict[str, Any] = {"name": "b", "requirements": {"envelope_width_mm": 270, "envelope_depth_mm": 220}}
FRICTION, FORCE = "feel.friction_max_N", "requirements.force_N"


def grid(**axes: list[float]) -> Grid:
    named = axes or {FRICTION: [0.5, 0.8], FORCE: [2, 3]}
    return grid_from_dict({"base": TASK, "axes": named, "method": MACHINES}, "g.toml")


def paper(search: Search) -> MachinePoint | None:
    """A machine the larger the less is asked; none at 0.5 N of friction and 3 N."""
    friction, force = search.brief.feel.friction_max_N, search.brief.requirements.force_N
    if (friction, force) == (0.5, 3.0):
        search.log.no_progress[f"{MOTOR} capstan"] = (
            "no lengths meet the limits with its torque, masses and rods' springs"
        )
        return None
    side = 60.0 + 20.0 * friction - force
    figures = Figures(side, (250.0, 220.0), 0.3, friction, 20.0, 2.2)
    return MachinePoint("asked", None, Selection(MOTOR, "capstan", 5.0, 50.0), load_design(BEST), figures)


def test_each_set_becomes_a_row_and_a_design_file_that_can_be_built(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "best_machine", paper)
    found = grid()
    rows = [json.loads(json.dumps(solve(asdict(one)))) for one in found.sets]
    assert [row["feasible"] for row in rows] == [True, False, True, True]
    files = {
        str(path): text
        for path, text in atlas_files(found, rows, Path("d"), lambda: png(atlas_map(found, rows))).items()
    }
    assert sorted(files) == [
        *(f"d/atlas.{end}" for end in ("csv", "json", "md", "png")), *(f"d/designs/set-{k}.json" for k in (0, 2, 3)),
    ]  # fmt: skip
    made = design_from_dict(json.loads(files["d/designs/set-2.json"]))
    assert made.name == "b-set-2"
    assert made.geometry == load_design(BEST).geometry
    head, *lines = str(files["d/atlas.csv"]).splitlines()
    assert {"motor", "ratio", "effective_mass_kg", "stiffness_N_mm", "base_radius_mm"} <= set(head.split(","))
    assert len(lines) == 4
    sides = cells(found, rows, "step_design_cube_side_mm")
    assert sides[1].tolist() == [74.0, 73.0]
    assert bytes(files["d/atlas.png"]).startswith(b"\x89PNG")
    text = page(found, rows, None, "out/atlas/b")
    why = "no lengths meet the limits with its torque, masses and rods' springs"
    assert f"set 1 has none: maxon-re30-310007 capstan: {why}" in text
    assert "python -m delta_cad build --design out/atlas/b/designs/set-N.json" in text


@pytest.mark.slow
def test_a_set_is_the_machine_that_closed_forms_leave_its_hardware() -> None:
    """Of one motor at one ratio, weighed by its solids: it keeps what is asked, and less force leaves more cube."""
    fixed = {"hardware": {"motor": MOTOR, "drive": "capstan", "capstan_ratio": 5.0}}
    task = TASK | fixed | {"limits": {"parallelogram_width_mm": 50.0}, "feel": {"kappa_max": 2.3}}
    found = grid_from_dict({"base": task, "axes": {FORCE: [3.0, 4.0]}, "method": MACHINES}, "g.toml")
    less, more = (solve(asdict(one))["machine"] for one in found.sets)
    assert less["cube_side_mm"] > more["cube_side_mm"] > 60.0
    for one in (less, more):
        assert (one["width_mm"], one["depth_mm"], one["ratio"]) == (270.0, 220.0, 5.0)
        assert one["kappa"] <= 2.3
