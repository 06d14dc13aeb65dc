"""All checks together: order, progress, early ends, and the form of the records."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks import background_sweep
from delta_cad.checks.background_sweep import Sweep
from delta_cad.checks.clearance.clearance import PROVING, MeshClearance
from delta_cad.checks.registry import CHECKS, CheckedMachine, run_checks
from delta_cad.checks.report import CheckResult, all_passed
from delta_cad.common.worker_process import WorkerProcess
from delta_cad.solids.part import Part
from tests.delta_cad.checks.machines import LIMITS, STEEL, box, machine
from tests.delta_cad.mechanism.stated_limits import limits as requested

MACHINE = machine()


def test_all_checks_of_a_good_machine_pass_and_report() -> None:
    reported: list[str] = []
    limits = replace(LIMITS, envelope_depth_mm=222.0, pose=requested(lean_max=np.radians(28.0), assembly_mode=False))
    results = run_checks(CheckedMachine(MACHINE, limits, MeshLibrary(MACHINE.parts), progress=reported.append))
    assert all_passed(results), [r for r in results if not r.passed]
    names = [r.name for r in results]
    assert len(names) == len(set(names))
    for expected in (
        "reach",
        "lean",
        "solid arm",
        "joint closure",
        "ball tilt",
        "overlap on one link",
        "envelope depth",
    ):
        assert expected in names
    assert names[-1] == "clearance proof"
    labels = [check.label for check in CHECKS if check.stage != "design"]
    assert [label for label in reported if label in labels] == labels
    read = json.loads(json.dumps([r.to_json() for r in results]))
    assert {r["name"]: r["value"] for r in read} == {r.name: r.value for r in results}
    assert isinstance(read[-1]["passed"], bool)


def test_checks_are_distinguished() -> None:
    for reported_by in ("name", "label"):
        assert len({getattr(check, reported_by) for check in CHECKS}) == len(CHECKS)


@pytest.mark.slow
def test_another_process_sweeps_to_the_same_results() -> None:
    meshes, reported = MeshLibrary(MACHINE.parts, 0.3, 0.8), list[str]()
    here = Sweep()
    with WorkerProcess(background_sweep.__name__) as adjacent:
        there = Sweep(adjacent)
        for sweep in (here, there):
            assert sweep.reach_mm is None
            sweep.begin(MACHINE, LIMITS, meshes, reported.append)
        assert reported == []
        np.testing.assert_array_equal(there.reach_mm, here.reach_mm)
        assert there.outline() == here.outline()
        found, expected = there.clearance(), here.clearance()
    assert found.results == expected.results
    assert [(s.names, s.distance_mm) for s in found.closest] == [(s.names, s.distance_mm) for s in expected.closest]
    assert reported.count(PROVING) == 2


def test_a_sweep_that_was_not_begun_has_no_clearance() -> None:
    with pytest.raises(RuntimeError, match="no sweep goes on"):
        Sweep().clearance()


def test_an_unreachable_cube_ends_the_checks() -> None:
    done: list[str] = []
    meshes = MeshLibrary(MACHINE.parts, 0.3, 0.8)
    far = replace(LIMITS, half_side_mm=80.0)
    results = run_checks(CheckedMachine(MACHINE, far, meshes), lambda: done.append("files"))
    assert done == ["files"]
    assert not all_passed(results)
    assert not any(r.name.startswith("clearance") for r in results)


def test_an_unsound_part_ends_the_checks() -> None:
    hollow = Part("screw", "screw", box((0, 0, 0), (1, 1, 1)).Shells()[0], STEEL, True)  # type: ignore[arg-type]
    screws = (replace(o, part=hollow) if o.part.number == "screw" else o for o in MACHINE.occurrences)
    bad = replace(MACHINE, occurrences=tuple(screws))
    sweep = Sweep()
    results = run_checks(CheckedMachine(bad, LIMITS, MeshLibrary(bad.parts, 0.3, 0.8), sweep=sweep))
    assert sweep.reach_mm is None  # it was begun before the solids were looked at
    assert [r.name for r in results if not r.passed] == ["solid screw"]
    assert not any(r.name.startswith("clearance") for r in results)


def test_records_hold_plain_numbers() -> None:
    record = CheckResult("x", np.True_, np.float64(1.0), np.float32(2.0), "mm", (1.0, 2.0, 3.0), ("a", "b"))  # type: ignore[arg-type]
    assert record.passed is True
    assert type(record.limit) is float
    assert record.to_json()["worst_pair"] == ["a", "b"]
    assert CheckResult("x", True, None, None, "").to_json()["worst_pose_mm"] is None


def test_importing_the_checks_loads_no_cad() -> None:
    code = (
        "import sys, delta_cad.checks.registry, delta_cad.assembly.tessellation;"
        "print([m for m in ('cadquery', 'OCP', 'fcl', 'trimesh', 'scipy') if m in sys.modules])"
    )
    reported = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert reported.stdout.strip() == "[]"


def test_a_clearance_that_is_known_is_not_computed_again() -> None:
    meshes = MeshLibrary(MACHINE.parts, 0.3, 0.8)
    known = MeshClearance([], [])
    sweep = Sweep(known=known)
    sweep.begin(MACHINE, LIMITS, meshes, lambda _: None)
    assert sweep.clearance() is known
    assert [r.name for r in sweep.outline()][-1] == "envelope depth"
