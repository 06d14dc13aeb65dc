"""`best.json` is what `optimizer design joystick.toml` writes, and meets the requirements of the joystick.

28 s of processor: stable walls and noise over the cube, for all hands and two kinds of drives.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from delta_cad.design import load_design
from delta_cad.mechanism import jacobian
from haptics.feel.loops import noisy_walls
from haptics.loop.choice import BOARD, DAMPED, LoopChoice
from haptics.loop.noise import BARELY, FORCE, NoisyLoop
from haptics.loop.walls import WallStability, proven_cap, rendered
from haptics.model.hands import CORNERS, HANDS
from haptics.model.machine import load_machine
from haptics.model.plant import FREE
from optimizer.problem.brief import brief_hash, load_brief
from tests.committed import COMMITTED, ROOT, Built
from tests.haptics.loop.noise.built import POSES, moved

TASK = ROOT / "joystick.toml"


def test_it_comes_from_the_committed_requirements() -> None:
    provenance = json.loads(COMMITTED.read_text())["provenance"]
    assert provenance["command"] == f"python -m optimizer design {TASK.name} --seed 0"
    assert provenance["requirements_sha256"] == brief_hash(load_brief(TASK))


def test_it_states_all_that_the_requirements_ask() -> None:
    required, stated = load_brief(TASK), load_design(COMMITTED).requirements
    for part in (required.requirements, required.feel):
        for name, value in part.model_dump(exclude_none=True).items():
            assert getattr(stated, name) == pytest.approx(value), name


def test_its_build_passes_and_keeps_what_is_required_of_the_hand(committed: Built) -> None:
    record = committed.record
    assert (committed.code, record["failed"]) == (0, [])
    found = {check["name"]: check["value"] for check in record["checks"]}
    assert found["effective mass"] <= 0.40
    assert found["friction"] <= 0.80
    assert found["structure stiffness at the knob"] >= 15.0
    assert found["structure first mode"] >= 40.0
    assert record["moving_mass_kg"] <= 0.400


@pytest.mark.parametrize(("loop", "centre", "everywhere"), [(BOARD, 4400.0, 3500.0), (DAMPED, 4500.0, 1950.0)])
def test_its_loop_bears_a_good_wall_quietly(
    committed: Built, loop: LoopChoice, centre: float, everywhere: float
) -> None:
    """Steady let go of and in every hand up to 5 N/mm at the centre, at most 0.05 N rms of noise; N/m rendered."""
    machine = load_machine(COMMITTED, committed.folder / "mass_properties.json")
    assert machine.structure is not None
    cap, edge = proven_cap(machine, loop), np.linspace(-machine.half_side, machine.half_side, 9)
    cube = machine.centre + np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), axis=-1).reshape(-1, 3)
    assert rendered(cap, jacobian(machine.geometry, machine.centre))[0] >= centre
    assert rendered(cap, jacobian(machine.geometry, cube))[0].min() >= everywhere
    for normal in np.eye(3):
        at = WallStability(machine, loop, normal=normal)
        assert all(at.stable(hand) > 5000.0 for hand in (FREE, *(HANDS | CORNERS).values()))
    for p in (machine.centre, cube[0], cube[-1]):
        for normal, stiffness, damping in noisy_walls(machine, cap, p):
            noisy = NoisyLoop(machine, loop, p=p, hand=BARELY, normal=normal)
            assert noisy.figures(stiffness, damping).force <= FORCE


def test_noise_is_unnoticed_in_its_walls_on_the_structure_as_it_is_built(committed: Built) -> None:
    """With drives that damp 0.05 N and 0.058 um rms at most, all over the cube, a fifth softer to a fifth stiffer: the
    limit of 0.05 um is missed half-way up towards the edges. Drives that add no damping move it farther at the centre.
    """
    machine = load_machine(COMMITTED, committed.folder / "mass_properties.json")
    found = [(place[2], moved(machine, place)) for place in POSES]
    assert all(one.steady and one.force <= FORCE and one.motion <= 5.85e-8 for _, one in found)
    assert {height for height, one in found if not one.quiet} == {0.0}
    assert not moved(machine, np.zeros(3), BOARD).quiet


def test_no_number_of_a_machine_stands_in_the_requirements() -> None:
    """A bound, a ratio or a size in them would be one that somebody had copied."""
    text = Path(TASK).read_text()
    assert "[bounds_mm]" not in text
    assert "capstan_ratio" not in text
    assert "_radius_mm" not in text
