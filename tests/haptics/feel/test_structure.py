"""Structure as built, and the force on a held handle: against a chain of two masses in closed form and in time."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import interpn

from delta_cad.design import Design, design_hash
from haptics.feel.loops import first_resonance, force_bandwidth, held_force
from haptics.loop.choice import BOARD
from haptics.loop.hardware import STIFFER, compliance, real_plant, structure_text
from haptics.loop.linear import linearise
from haptics.model.built import built_structure
from haptics.model.machine import MachineModel
from tests.haptics.loop.noise.built import with_structure

Z = np.array([0.0, 0.0, 1.0])


def test_the_force_on_a_held_handle_is_that_of_two_masses(machine: MachineModel) -> None:
    """Along z motions part at the centre: rotors, cable, arms and rods, structure, a handle that is held still."""
    par = real_plant(machine)
    here = linearise(par, machine.centre)
    q = float(np.square(here.jacobian.T @ Z).sum())  # |J^T n|^2: along the axis all three joints turn alike
    rotor, k, d = par.rotor_inertia / q, par.cable_stiffness / q, par.cable_damping / q
    arms, viscous = here.effective_mass(Z) - rotor - par.knob, par.viscous / q
    f = np.array([1.0, 20.0, 50.0, 80.0, 120.0, 300.0, 900.0])
    s = 2j * np.pi * f
    cable, structure = k + d * s, par.structure_stiffness + par.structure_damping * s
    matrix = np.moveaxis(
        np.array([[rotor * s**2 + viscous * s + cable, -cable], [-cable, arms * s**2 + cable + structure]]), -1, 0
    )
    moved = np.linalg.solve(matrix, np.broadcast_to(np.array([[1.0 + 0j], [0.0]]), (len(f), 2, 1)))[:, 1, 0]
    hold = np.sinc(f * BOARD.period) / (1.0 + s * BOARD.current_lag)
    assert held_force(machine, Z, f) == pytest.approx(structure * moved * hold, rel=3e-3)
    # at 900 Hz the knob's mass moves what holds it by 0.2 %


def test_bandwidth_is_where_the_response_leaves_3_dB(machine: MachineModel) -> None:
    soft, stiff = force_bandwidth(machine, Z)
    assert soft.within < soft.less < stiff.less
    assert soft.within < stiff.within
    level = np.abs(held_force(machine, Z, np.array([0.97 * soft.within, 1.03 * soft.within, 1.05 * soft.less])))
    assert level[0] < 10.0**0.15 < level[1]
    assert level[2] < 10.0**-0.15
    assert STIFFER[0] == 1.0
    assert real_plant(machine).structure_stiffness == compliance(machine).structure == 15e3


def test_a_structure_as_built_is_used_for_resonance_and_bandwidth(machine: MachineModel) -> None:
    """The build has 132 Hz by the masses of all parts where they are (`delta_cad.structure.modes`); finding T9."""
    built = with_structure(machine)
    assert first_resonance(machine) < 80.0  # on the 15 N/mm that the design requires
    assert first_resonance(built) == pytest.approx(132.0, rel=0.12)
    assert force_bandwidth(built, Z)[0].within > force_bandwidth(machine, Z)[0].within
    assert structure_text(built) == "Structure as built (structure.json)"
    assert structure_text(machine) == "Structure as required, 15 N/mm: no structure.json of a build is at hand"


def test_the_build_s_structure_is_read_or_left_out(best: Design, machine: MachineModel, tmp_path: Path) -> None:
    built = with_structure(machine)
    assert built.structure is not None
    grid = np.stack(np.meshgrid(*built.structure.places, indexing="ij"), axis=-1).reshape(-1, 3)
    matrices = np.linalg.inv(built.structure.flexibility).reshape(-1, 3, 3) / 1e3
    rows = [{"position_mm": (1e3 * p).tolist(), "matrix": k.tolist()} for p, k in zip(grid, matrices, strict=True)]
    places = {
        "centre": {"softest_N_mm": 64.8, "first_mode_Hz": 139.0},
        "softest": {"softest_N_mm": 29.3},
        "slowest": {"first_mode_Hz": 96.0},
        "stiffness_N_mm": rows,
    }
    good = {"schema": "delta-structure/1", "input_sha256": design_hash(best), **places}
    assert built_structure(tmp_path, best) is None
    file = tmp_path / "structure.json"
    file.write_text(json.dumps(good))
    found = built_structure(tmp_path, best)
    assert found is not None
    assert [found.centre, found.softest, found.mode, found.slowest] == pytest.approx([64.8e3, 29.3e3, 139.0, 96.0])
    between = machine.centre + 0.3 * machine.half_side * np.array([1.0, -1.0, 0.5])
    assert found.at(between) == pytest.approx(
        interpn(built.structure.places, built.structure.flexibility, between)[0], rel=1e-9, abs=1e-15
    )
    for other in (
        {"input_sha256": "0"},
        {"schema": "delta-structure/2"},
        {"centre": []},
        {"softest": {"softest_N_mm": -1}},
        {"stiffness_N_mm": rows[1:]},
        {"stiffness_N_mm": [{"position_mm": [0, 0, 0], "matrix": [[0.0] * 3] * 3}]},
        {"stiffness_N_mm": []},
    ):
        file.write_text(json.dumps(good | other))
        assert built_structure(tmp_path, best) is None, other
    file.write_text("{")
    assert built_structure(tmp_path, best) is None
