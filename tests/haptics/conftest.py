"""The device that most tests of the haptics take: the tests' machine with the masses of its build."""

from __future__ import annotations

import pytest

from delta_cad.design import Design
from haptics.model.machine import MachineModel
from tests.haptics.scene_machine import scene_machine


@pytest.fixture(scope="session")
def machine(best: Design) -> MachineModel:
    return scene_machine(best)
