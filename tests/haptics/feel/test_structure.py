"""Structure as built, and the force on a held handle: against a chain of two masses in closed form and in time."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from delta_cad.design import Design, design_hash
from haptics.feel.structure import BuiltStructure, built_structure, force_bandwidth, held_force
from haptics.model.machine import MachineModel
from haptics.simulation.hardware import STIFFER, compliance, real_plant
from haptics.simulation.loops import BOARD
from haptics.stability.linear import linearise
from tests.haptics.scene_machine import scene_machine

Z = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def machine(best: Design) -> MachineModel:
    return scene_machine(best)


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
    assert held_force(machine, par, Z, f) == pytest.approx(structure * moved * hold, rel=3e-3)
    # at 900 Hz the knob's mass moves what holds it by 0.2 %


def test_bandwidth_is_where_the_response_leaves_3_dB(machine: MachineModel) -> None:
    soft, stiff = force_bandwidth(machine, Z)
    assert soft.within < soft.less < stiff.less
    assert soft.within < stiff.within
    par = real_plant(machine)
    level = np.abs(held_force(machine, par, Z, np.array([0.97 * soft.within, 1.03 * soft.within, 1.05 * soft.less])))
    assert level[0] < 10.0**0.15 < level[1]
    assert level[2] < 10.0**-0.15
    assert STIFFER[0] == 1.0
    assert par.structure_stiffness == compliance(machine).structure


def test_the_build_s_structure_is_read_or_left_out(best: Design, tmp_path: Path) -> None:
    places = {
        "centre": {"softest_N_mm": 64.8, "first_mode_Hz": 139.0},
        "softest": {"softest_N_mm": 29.3},
        "slowest": {"first_mode_Hz": 96.0},
    }
    good = {"schema": "delta-structure/1", "input_sha256": design_hash(best), **places}
    assert built_structure(tmp_path, best) is None
    file = tmp_path / "structure.json"
    file.write_text(json.dumps(good))
    assert built_structure(tmp_path, best) == BuiltStructure(64.8e3, 29.3e3, 139.0, 96.0)
    for other in (
        {"input_sha256": "0"},
        {"schema": "delta-structure/2"},
        {"centre": []},
        {"softest": {"softest_N_mm": -1}},
    ):
        file.write_text(json.dumps(good | other))
        assert built_structure(tmp_path, best) is None
    file.write_text("{")
    assert built_structure(tmp_path, best) is None
