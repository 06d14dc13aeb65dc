"""`run`: drives a device with a scene and shows it live."""

from __future__ import annotations

import argparse
import time
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, ProgressLine, print_result, refuse
from delta_cad.common.options import CALIBRATION, JSON, MOST_PORT, Option, number, whole
from haptics.commands.device import DEVICE_OPTIONS

if TYPE_CHECKING:
    from haptics.devices.device import Device, Reading
    from haptics.devices.host import Host
    from haptics.model.machine import MachineModel

NAME = "run"
TEXT = "drive a simulated, recorded or real device with a scene; shows force, position and faults live"
_SCHEMA = "haptics-run/1"
SCENES = ("none", "spring", "wall", "resistance", "home")
_DEVICES = ("simulated", "socket", "recorded")
_LOOK_S = 0.1  # between two looks of the line
# The simulated person goes round in the cube: share of its half side, and turns a second about x, y and z.
_PATH_SHARE, _PATH_Hz = 0.5, (0.21, 0.33, -0.13)  # down at first, onto the wall
OPTIONS = (
    *DEVICE_OPTIONS,
    Option(
        "--device",
        choices=_DEVICES,
        default="simulated",
        help="device to drive; default: simulated, with all that `simulate` gives it",
    ),
    Option(
        "--scene",
        choices=SCENES,
        default="spring",
        help="what the handle feels; none: only its weight is held; default: spring",
    ),
    Option("--host", default="127.0.0.1", metavar="ADDRESS", help="numeric address of the board; default: 127.0.0.1"),
    Option("--port", type=whole(0, MOST_PORT), default=0, metavar="N", help="port of the board, as `board` prints it"),
    Option(
        "--allow-remote", action="store_true", help="accept a board on another machine; the connection has no password"
    ),
    Option(
        "--timeout",
        type=number(0.01, 60.0, "s"),
        default=0.1,
        metavar="S",
        help="time without a reading after which the board is lost, s; default: 0.1",
    ),
    Option("--recording", type=Path, metavar="FILE", help="recording to replay, .csv or .npz"),
    CALIBRATION,
    Option(
        "--rate",
        type=number(100.0, 1e4, "Hz"),
        default=1000.0,
        metavar="HZ",
        help="rate of a simulated device, Hz; default: 1000",
    ),
    Option(
        "--seconds",
        type=number(0.01, 1e6, "s"),
        metavar="S",
        help="duration by the clock of the device, s; default: until Ctrl-C",
    ),
    Option("--fast", action="store_true", help="run a simulated device faster than real time"),
    Option("--record", type=Path, metavar="FILE", help="record what is read and written, .csv or .npz"),
    JSON,
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from haptics.calibration.record import CalibrationError
    from haptics.devices.api import opened_device
    from haptics.devices.device import DeviceError
    from haptics.devices.recording import RecordingError
    from haptics.loop.choice import chosen_loop
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.mass_properties, given.catalogue)
    if given.record is not None:
        from delta_cad.common.files import require_room

        if given.record.suffix not in (".csv", ".npz"):
            return refuse(f"--record {given.record}: a recording ends in .csv or .npz", BAD_INPUT)
        require_room(given.record, folder=False)
    laws_of(
        machine, given.scene, chosen_loop(machine.design, given.rate)
    )  # compiled and looked up before a board waits for it
    try:
        device = opened_device(
            machine, given.device, host=given.host, port=given.port, recording=given.recording,
            calibration=given.calibration, rate_Hz=given.rate, timeout=given.timeout,
            allow_remote=given.allow_remote,
        )  # fmt: skip
    except (CalibrationError, RecordingError) as error:
        return refuse(str(error), BAD_INPUT)
    except (ValueError, DeviceError) as error:
        return refuse(f"--device {given.device}: {error}", BAD_INPUT)
    try:
        facts = _driven(machine, device, given)
    except ValueError as error:  # another period or torque limit than the design's
        return refuse(f"--device {given.device}: {error}", BAD_INPUT)
    print_result(given, facts, lambda: _print(facts))
    return DONE if facts["passed"] else NOT_MET


def _driven(machine: MachineModel, device: Device, given: argparse.Namespace) -> dict[str, Any]:
    from haptics.devices.api import loop_of
    from haptics.devices.device import DeviceLostError
    from haptics.devices.host import Host
    from haptics.devices.recording import Forgetful, Recorder, save_recording
    from haptics.loop.hardware import board_controller
    from haptics.loop.walls import proven_cap

    period = _period(device, given)
    loop = loop_of(machine.design, device, period)
    controller = board_controller(machine, loop)._replace(walls=proven_cap(machine, loop))
    host = Host(controller, laws_of(machine, given.scene, loop))
    host.enable()
    recorder, lost, stopped = (Forgetful if given.record is None else Recorder)(), "", False
    with ProgressLine() as line:
        watch = _Watch(machine, host, device, given, line)
        try:
            host.drive(device, ticks=None, until=watch, recorder=recorder)
        except DeviceLostError as error:
            lost = str(error)
        except KeyboardInterrupt:  # the usual way to end it; the torque is zero by now
            stopped = True
    if given.record is not None:
        save_recording(recorder.recording(), given.record)
    return watch.facts() | {"period_s": period, "lost": lost or None, "interrupted": stopped} | {
        "passed": not lost and not watch.latched, "recording": None if given.record is None else str(given.record)
    }  # fmt: skip


def _period(device: Device, given: argparse.Namespace) -> float:
    """Period of the device's tick, s: a recording's is the middle one of its steps."""
    import numpy as np

    own = getattr(device, "period", None)
    if own is None and (recording := getattr(device, "recording", None)) is not None and len(recording.time) > 1:
        own = float(np.median(np.diff(recording.time)))
    return 1.0 / given.rate if own is None else own


def laws_of(machine: MachineModel, scene: str, loop: Any) -> Any:
    """Makes the law of a scene about the middle of the cube, no harder than the loop bears.

    Args:
        machine: The device.
        scene: One of `SCENES`.
        loop: The loop, a `LoopChoice`.
    """
    from haptics.loop.walls import capped, centre_and_corners, computed_wall
    from haptics.rendering.laws.constant_force import ConstantForce
    from haptics.rendering.laws.home import Home
    from haptics.rendering.laws.operating_resistance import OperatingResistance
    from haptics.rendering.laws.spring import SpringDamper
    from haptics.rendering.laws.virtual_wall import AXES, VirtualWall

    middle = machine.centre
    if scene == "none":
        return ConstantForce((0.0, 0.0, 0.0))
    wall = capped(machine, VirtualWall(5000.0, middle, (0.0, 0.0, 1.0)), middle, loop)
    if scene == "wall":
        return wall
    # a spring is felt everywhere, and no drive damps more for it
    tried = product(centre_and_corners(machine), AXES.values())
    bears = min(computed_wall(machine, p, axis, loop.untouched) for p, axis in tried)
    stiffness, damping = min(300.0, 0.5 * bears), min(2.0, loop.damping)
    if scene == "spring":
        return SpringDamper(stiffness, damping, middle)
    if scene == "home":
        return Home(stiffness, 10.0 * damping, 0.1, middle)
    return OperatingResistance(stiffness, damping, 0.005, 0.015, middle)


class _Watch:
    """Looks at each tick: the line, the simulated person, the clock, the end."""

    def __init__(
        self, machine: MachineModel, host: Host, device: Device, given: argparse.Namespace, line: ProgressLine
    ) -> None:
        from haptics.model.hands import HANDS

        self._machine, self._host, self._device, self._line = machine, host, device, line
        self._seconds, self._name, self._scene, self._kind = (
            given.seconds,
            machine.design.name,
            given.scene,
            given.device,
        )
        plant = getattr(device, "device", device)
        self._hand: Any = plant if given.device == "simulated" else None
        if self._hand is not None:
            self._hand.hand = HANDS["medium"]
        self._paced = self._hand is not None and not given.fast
        self._begin: float | None = None
        self._wall = self._looked = time.monotonic()
        self._ticks, self._largest, self.latched, self._seen, self._last = 0, 0.0, 0, 0, 0.0
        self._sum: Any = 0.0

    def __call__(self, sample: Reading) -> bool:
        """After a tick; true ends it."""
        import numpy as np

        from haptics.control.controller import FORCE
        from haptics.control.supervisor.faults import LATCHING

        if self._begin is None:
            self._begin, self._wall = sample.time, time.monotonic()
        self._last = sample.time - self._begin
        self._ticks += 1
        work = self._host.memory.work
        force = float(np.linalg.norm(work[FORCE]))
        self._largest = max(self._largest, force) if force == force else self._largest
        self._seen |= self._host.bits
        self.latched |= self._host.bits & LATCHING
        self._sum = self._sum + np.asarray(sample.angles, dtype=float)
        if self._hand is not None:
            turn = 2.0 * np.pi * np.array(_PATH_Hz) * self._last
            self._hand.anchor = self._machine.centre + _PATH_SHARE * self._machine.half_side * np.sin(turn)
        now = time.monotonic()
        if now - self._looked > _LOOK_S:
            self._looked = now
            self._line.show(self._reported())
        if self._paced and (ahead := self._last - (now - self._wall)) > 0.0:
            time.sleep(ahead)
        return self._seconds is not None and self._last >= self._seconds

    def _reported(self) -> str:
        from delta_cad.common.units import MM_PER_M
        from haptics.control.controller import FORCE
        from haptics.control.pose import POSITION
        from haptics.control.supervisor.faults import findings

        work = self._host.memory.work
        x, y, z = MM_PER_M * work[POSITION]
        fx, fy, fz = work[FORCE]
        found = " ".join(f.name for f in findings(self._host.bits)) or "no findings"
        state = self._host.supervisor.state.name
        return f"at {x:7.2f} {y:7.2f} {z:7.2f} mm  force {fx:6.2f} {fy:6.2f} {fz:6.2f} N  {state}  {found}"

    def facts(self) -> dict[str, Any]:
        """What came of it."""
        import numpy as np

        from delta_cad.common.units import MM_PER_M
        from haptics.control.pose import POSITION
        from haptics.control.supervisor.faults import LATCHING, findings
        from haptics.devices.api import finite

        work = self._host.memory.work
        mean = np.degrees(self._sum / self._ticks) if self._ticks else np.full(3, np.nan)
        return {
            "schema": _SCHEMA,
            "name": self._name,
            "device": self._kind,
            "scene": self._scene,
            "ticks": self._ticks,
            "seconds": self._last,
            "position_mm": finite(MM_PER_M * work[POSITION]),
            "mean_angles_deg": finite(mean),
            "largest_force_N": self._largest,
            "findings": [f.name for f in findings(self._seen & ~LATCHING)],
            "faults": [f.name for f in findings(self.latched)],
            "dropped": dict(getattr(self._device, "counts", {})) if self._kind == "socket" else {},
        }


def _print(facts: dict[str, Any]) -> None:
    where = "unknown" if None in facts["position_mm"] else " ".join(f"{v:.2f}" for v in facts["position_mm"]) + " mm"
    print(f"{facts['name']}, {facts['device']}, {facts['scene']}: {facts['ticks']} ticks, {facts['seconds']:.1f} s"
          f"{', ended by Ctrl-C' if facts['interrupted'] else ''}; force zero")  # fmt: skip
    angles = "unknown" if None in facts["mean_angles_deg"] else " ".join(f"{v:.4f}" for v in facts["mean_angles_deg"])
    print(f"at {where}; mean angles {angles} deg; largest force {facts['largest_force_N']:.2f} N")
    print(f"findings: {', '.join(facts['findings']) or 'none'}")
    for name in facts["faults"]:
        print(f"FAULT  {name}")
    if facts["lost"]:
        print(f"LOST  {facts['lost']}")
    if facts["recording"]:
        print(f"recorded in {facts['recording']}")
