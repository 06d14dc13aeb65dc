"""Shared synthetic machine; CAD is loaded once a process."""

from __future__ import annotations

from pathlib import Path

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.export.step import write_assembly_step
from tests.delta_cad.export.machine import make_assembly


@pytest.fixture(scope="session")
def machine() -> Assembly:
    return make_assembly()


@pytest.fixture(scope="session")
def meshes(machine: Assembly) -> MeshLibrary:
    return MeshLibrary(machine.parts, 0.02, 0.2)


@pytest.fixture(scope="session")
def step_file(machine: Assembly, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("step") / "assembly.step"
    write_assembly_step(machine, path)
    return path
