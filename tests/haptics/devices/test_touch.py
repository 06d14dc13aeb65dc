"""Whether a wall is touched goes from the tick to whatever drives the joints, and ends on a board that trips."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.design.record import Loop
from haptics.control.controller import Controller
from haptics.control.filters import low_pass
from haptics.control.pose import model
from haptics.devices.api import loop_of
from haptics.devices.board import Board
from haptics.devices.device import Reading
from haptics.devices.host import Host
from haptics.devices.protocol import decode, encode
from haptics.devices.simulated import SimulatedDevice
from haptics.loop.choice import DAMPED, at_rate
from haptics.loop.walls import computed_wall
from haptics.model.plant import Hand
from haptics.rendering.laws.virtual_wall import axis_wall
from tests.haptics.control.supervisor.rig import DESIGN, GEOMETRY, HOME, LIMITS, MASSES, PLANT
from tests.haptics.devices.fake import FakeDevice
from tests.haptics.devices.test_remote import Wire, remote
from tests.haptics.scene_machine import scene_machine

FACE, TICKS, BEGINS = 0.5e-3, 1600, 900  # m from HOME; ticks, and from which on the hand leads
PAR = PLANT._replace(contact_damping=0.05)
SMOOTH = PAR._replace(coulomb=0.0, gravity_x=0.0, gravity_y=0.0, gravity_z=0.0)


class Watched(SimulatedDevice):
    """The simulated device, led into a wall and out of it; it keeps what it was told, and where it was."""

    def __init__(self) -> None:
        super().__init__(PAR, HOME, hand=Hand(mass=0.1, damping=5.0, stiffness=300.0))
        self.wording: list[bool] = []
        self.depth: list[float] = []

    def touch(self, touched: bool) -> None:
        super().touch(touched)
        self.wording.append(touched)

    def read(self) -> Reading:
        led = 3e-3 * np.sin(0.03 * max(len(self.depth) - BEGINS, 0))
        self.anchor = HOME + np.array([led, 0.0, 0.0])
        sample = super().read()
        self.depth.append(self.state[0] - HOME[0] - FACE)
        return sample


def host() -> Host:
    known = model(GEOMETRY, MASSES, DESIGN.requirements.gravity_m_s2)
    controller = Controller(known, low_pass(1e-3, 100.0), LIMITS, np.inf)
    own = Host(controller, axis_wall("+x", HOME[0] + FACE, stiffness=500.0, damping=1.0))
    own.enable()
    return own


def crossings(wording: Any) -> int:
    return int(np.count_nonzero(np.diff(np.asarray(wording, dtype=int))))


def test_the_simulated_device_is_reported_of_each_tick() -> None:
    device = Watched()
    host().drive(device, ticks=TICKS)
    inside = np.array(device.depth) > 0.0
    assert crossings(inside) > 3
    assert device.wording[:TICKS] == inside[:TICKS].tolist()
    assert not device.wording[-1] or inside[-1]


def test_a_board_tells_its_drives_a_tick_later() -> None:
    device = Watched()
    wire = Wire(Board(device, 1e-3, 0.8, 16384))
    host().drive(remote(wire), ticks=TICKS)
    inside = np.array(device.depth) > 0.0
    assert crossings(inside) > 3
    # a session begins without; a tick with what the COMMAND for the reading before it says
    assert device.wording[:2] == [False, False]
    assert device.wording[2:TICKS] == inside[: TICKS - 2].tolist()
    wire.board.tick()
    assert not device.wording[-1]  # without a session


@pytest.mark.parametrize("how", ["watchdog", "stop", "bye"])
def test_where_a_board_cuts_the_torque_its_drives_do_not_damp_as_at_a_wall(how: str) -> None:
    device = Watched()
    wire = Wire(Board(device, 1e-3, 0.8, 16384))
    far = remote(wire)
    far.read()
    far.touch(True)
    far.write(np.zeros(3))
    wire.board.tick()
    assert device.wording[-1]
    if how == "stop":
        wire.board.stop = True
        wire.board.tick()
    elif how == "bye":
        far.close()  # at once, with the torque, not in the next tick
    else:
        for _ in range(22):  # 20 ms without a COMMAND
            wire.board.tick()
        assert wire.board.tripped
    assert not device.wording[-1]


def test_a_board_says_whether_its_drives_damp_at_walls_and_walls_are_held_to_that(best: Design) -> None:
    def silent(_: int, data: bytes) -> list[bytes]:  # as boards were before they could say so
        return [encode(decode(data)._replace(flags=0))]

    says, without = remote(Wire(Board(Watched(), 1e-3, 0.8, 16384))), remote(Wire(Board(FakeDevice([]), 1e-3, 0.8, 64)))
    old = remote(Wire(Board(Watched(), 1e-3, 0.8, 16384), down=silent))
    assert [far.damps_at_walls for far in (says, without, old)] == [True, False, False]
    design = best.model_copy(update={"loop": Loop(drive_damping=0.62)})
    near = at_rate(1000.0, DAMPED)
    loops = [loop_of(design, device, 1e-3) for device in (Watched(), FakeDevice([]), says, without, old)]
    # a board applies a torque at the tick after its reading, a whole period late, where one at hand takes it at once
    assert loops == [near, near.untouched, near.linked, near.linked.untouched, near.linked.untouched]
    assert near.linked.delays[1] == 1.0
    machine = scene_machine(best)
    limits = [computed_wall(machine, machine.centre, (1.0, 0.0, 0.0), loop) for loop in loops]
    assert limits[0] > limits[2] > limits[3]
    assert limits[0] > limits[1] > limits[3]


def test_the_simulated_drives_damp_more_while_a_wall_is_touched() -> None:
    """A handle that is pushed on and on drifts as its drives let it: b more at the joints, less way."""
    ways = []
    for touched in (False, True):
        device = SimulatedDevice(SMOOTH, HOME)
        device.force[0] = 0.05
        device.touch(touched)
        for _ in range(60):
            device.read()
        ways.append(device.state[0] - HOME[0])
    assert 0.0 < ways[1] < 0.9 * ways[0]
