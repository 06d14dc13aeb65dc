"""The haptic simulation and the controller's tick: speed, growth, memory, and MuJoCo's step on the twin beside ours."""

# pyright: reportAttributeAccessIssue=false
# The engine's binding declares its functions at run time.

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter_ns, process_time
from typing import Any

import numpy as np

from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import interleaved, python, ratios, slope, succeeded
from tests.committed import BEST

SUBJECT = "haptics"
PEER = "haptics beside MuJoCo"
REAL_TIME, TICK_US, MEMORY_MB = 20.0, 20.0, 400.0
ROUNDS, TICKS = 9, 4000
LENGTHS, SUBSTEPS = (2_000, 4_000, 8_000, 16_000), (5, 10, 20, 40)
STEP_S, STEPS = 1e-4, 10_000
ERROR_S = 0.06
"""Time over which errors are compared, s: the handle moves by some millimetres."""
PUSH = (0.02, -0.05, 0.06)
"""Torques under which it does, N m."""


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    say(f"loop, tick and growth, {ROUNDS} rounds in a process of its own")
    figures = _own(_child("measured"))
    say("memory of the scene with the longest series, with its picture")
    child = succeeded(python("-c", "from tests.benchmarks.haptics.simulation import led; led()"))
    note = "`simulate --scene resistance --plot`, 16 runs of 9.3 s; the design file read, no CAD"
    figures.append(
        Figure(SUBJECT, "peak memory of simulate", child.largest_bytes / 1e6, "MB", MEMORY_MB, note=note),
    )
    say("memory of the feel sheet, with its maps")
    child = succeeded(python("-c", "from tests.benchmarks.haptics.simulation import felt; felt()"))
    figures.append(
        Figure(
            SUBJECT, "peak memory of feel", child.largest_bytes / 1e6, "MB", MEMORY_MB, note="walls and maps; no CAD"
        ),
    )
    say("the twin, and MuJoCo's step beside ours")
    with TemporaryDirectory() as folder:
        succeeded(python("-c", "from tests.benchmarks.haptics.simulation import twin; twin()", folder))
        return figures + _adjacent(_child("adjacent", folder))


def _child(function: str, *arguments: str) -> dict[str, Any]:
    code = f"from tests.benchmarks.haptics import simulation as here; here.{function}()"
    return json.loads(succeeded(python("-c", code, *arguments)).stdout)


def _own(found: dict[str, Any]) -> list[Figure]:
    lengths, substeps = found["lengths"], found["substeps"]
    tick = "called from Python: FK, J, velocity, a wall, gravity, saturation, supervisor; by the clock on the wall"
    return [
        of_repeats(
            SUBJECT,
            "simulation, 1 kHz with 10 substeps",
            found["real_time"],
            "x real time",
            REAL_TIME,
            False,
            note=f"{TICKS / 1000:g} s of a hand on a wall, controller and supervisor included; processor time",
        ),
        of_repeats(
            SUBJECT,
            "simulation with all states, 8 kHz with 2 substeps",
            found["real_time_all"],
            "x real time",
            REAL_TIME,
            False,
            note="cable, structure, grasp, stops, ripple and noise of a hand on a wall; processor time",
        ),
        of_repeats(SUBJECT, "controller tick, Python, median", found["tick_median"], "us", TICK_US, note=tick),
        of_repeats(SUBJECT, "controller tick, Python, 99th percentile", found["tick_p99"], "us", note=tick),
        of_repeats(
            SUBJECT,
            "controller tick inside the compiled loop",
            found["tick_inside"],
            "us",
            note="slope of the loop's time over its substeps, at none",
        ),
        Figure(
            SUBJECT, "growth: simulation against ticks, log-log slope", slope(*lengths), "", note=_reported(lengths)
        ),
        Figure(
            SUBJECT,
            "growth: simulation against substeps, log-log slope",
            slope(*substeps),
            "",
            note=_reported(substeps),
        ),
    ]


def _adjacent(found: dict[str, Any]) -> list[Figure]:
    project_own, theirs = found["ours"], found["theirs"]
    errors = (
        f"after {ERROR_S:g} s off the exact motion by {found['our_error_m']:.1e} m and {found['their_error_m']:.1e} m"
    )
    return [
        of_repeats(
            PEER, "our Runge-Kutta step", [t / STEPS * 1e6 for t in project_own], "us", note="in minimal coordinates"
        ),
        of_repeats(
            PEER,
            "MuJoCo's step on twin.xml",
            [t / STEPS * 1e6 for t in theirs],
            "us",
            note=f"{found['version']}, {found['dof']} coordinates and 6 closures, many steps in one call",
        ),
        of_repeats(
            PEER,
            "speed against MuJoCo, the same time step",
            ratios(theirs, project_own),
            "x",
            note=f"{STEP_S * 1e3:g} ms, no friction; {errors}. MuJoCo wins in generality: stops, contacts, any "
            "other machine from a file, without a derivation",
        ),
    ]


def _reported(grown: tuple[list[int], list[float]]) -> str:
    return ", ".join(f"{size}: {seconds * 1e3:.0f} ms" for size, seconds in zip(*grown, strict=True))


def _machine() -> Any:
    from delta_cad.design import load_design
    from tests.haptics.scene_machine import scene_machine

    return scene_machine(load_design(BEST))


def measured() -> None:
    """Measures loop and tick in this process and prints the times as JSON."""
    from delta_cad.mechanism import inverse_kinematics
    from haptics.control.controller import fresh, tick
    from haptics.control.supervisor.memory import ENABLE, REQUEST
    from haptics.control.supervisor.supervisor import ALL_FRESH
    from haptics.loop.assumptions import default_controller, encoder_count, nominal_plant
    from haptics.loop.choice import BOARD
    from haptics.loop.hardware import board_controller, reading_age, real_plant, sensor_errors
    from haptics.loop.simulation import simulate, timing
    from haptics.loop.wall_trial import LOOP_SUBSTEPS
    from haptics.model.hands import HANDS
    from haptics.rendering import law_table
    from haptics.rendering.laws.virtual_wall import axis_wall

    machine = _machine()
    par, controller, middle = nominal_plant(machine), default_controller(machine), machine.centre
    laws = law_table(axis_wall("+x", 0.0, stiffness=2000.0, damping=5.0))
    way = np.array([0.02, 0.0, 0.0])  # the hand wanders in and out of the wall

    def loop(ticks: int, substeps: int = 10) -> Any:
        aim = middle + np.sin(np.arange(ticks) * 4e-3)[:, None] * way
        more = {"hand": HANDS["medium"], "anchor": aim, "push": np.zeros((ticks, 3)), "count": encoder_count(machine)}
        return simulate(par, controller, laws, timing(1e-3, 0.5e-3, substeps), middle, **more)

    real, fast, errors = real_plant(machine), board_controller(machine), sensor_errors(machine)

    def loop_of_all(ticks: int) -> Any:
        aim = middle + np.sin(np.arange(ticks) * 5e-4)[:, None] * way
        more = {"hand": HANDS["medium"], "anchor": aim, "push": np.zeros((ticks, 3)), "count": encoder_count(machine)}
        clock = timing(BOARD.period, BOARD.delay + reading_age(machine), LOOP_SUBSTEPS)
        return simulate(real, fast, laws, clock, middle, errors=errors, **more)

    whole = interleaved({"": lambda: loop_of_all(TICKS)}, ROUNDS, process_time)[""]
    times = interleaved({"": lambda: loop(TICKS)}, ROUNDS, process_time)[""]
    lengths = [median(interleaved({"": lambda n=n: loop(n)}, 3, process_time)[""]) for n in LENGTHS]
    turns = interleaved({str(n): lambda n=n: loop(TICKS, n) for n in SUBSTEPS}, ROUNDS, process_time)
    inside = [np.polyfit(SUBSTEPS, column, 1)[1] / TICKS * 1e6 for column in zip(*turns.values(), strict=True)]

    thetas = inverse_kinematics(machine.geometry, loop(TICKS).measured)
    medians: list[float] = []
    tails: list[float] = []
    for _ in range(ROUNDS):
        memory, out = fresh(controller), np.zeros(3)
        memory.supervisor[REQUEST] = ENABLE
        took = np.empty(TICKS)
        for k in range(TICKS):
            start = perf_counter_ns()
            tick(controller, memory, laws, k * 1e-3, thetas[k], thetas[k], ALL_FRESH, out)
            took[k] = perf_counter_ns() - start
        medians.append(float(np.median(took)) / 1e3)
        tails.append(float(np.percentile(took, 99.0)) / 1e3)
    print(
        json.dumps(
            {
                "real_time": [TICKS * 1e-3 / seconds for seconds in times],
                "real_time_all": [TICKS * BOARD.period / seconds for seconds in whole],
                "tick_median": medians,
                "tick_p99": tails,
                "tick_inside": inside,
                "lengths": [LENGTHS, lengths],
                "substeps": [SUBSTEPS, [median(turns[str(n)]) for n in SUBSTEPS]],
            }
        )
    )


def led() -> None:
    """Does what `simulate --scene resistance --plot` does, in a folder that goes away."""
    from haptics.scenes.pictures import PICTURES, save
    from haptics.scenes.record import write_csv, write_parquet
    from haptics.scenes.resistance import resistance

    machine = _machine()
    scene = resistance(machine)
    with TemporaryDirectory() as folder:
        for taken in scene.runs:
            write_csv(Path(folder) / f"{taken.name}.csv", taken.series)
            write_parquet(Path(folder) / f"{taken.name}.parquet", taken.series)
        save(PICTURES["resistance"](scene, machine.design.name), Path(folder) / "resistance.png")


def felt() -> None:
    """Does what `feel` does, in a folder that goes away."""
    import haptics.model.machine
    from haptics.commands.cli import main

    with TemporaryDirectory() as folder:
        haptics.model.machine.load_machine = lambda *_: _machine()  # the design and the masses of the benchmarks
        if main(["feel", "--design", str(BEST), "--out", folder]) == 2:
            raise RuntimeError("the feel sheet was refused")


def twin() -> None:
    """Writes twin.xml and mass_properties.json, as a build does, into the folder of the command line."""
    from delta_cad.assembly.assemble import assemble
    from delta_cad.design import load_design
    from delta_cad.dimensions import dimensions
    from delta_cad.drive import drive_torque
    from delta_cad.export.mass_properties import mass_report
    from delta_cad.export.robot import Robot, mjcf

    folder, design = Path(sys.argv[1]), load_design(BEST)
    sizes = dimensions(design)
    assembly = assemble(sizes)
    masses = mass_report(assembly)
    robot = Robot(assembly, masses["bodies"], drive_torque(design), sizes.stops_rad)
    (folder / "twin.xml").write_text(mjcf(robot, design.requirements.gravity_m_s2))
    (folder / "mass_properties.json").write_text(json.dumps(masses))


def adjacent() -> None:
    """Times MuJoCo's step and ours on the machine in the folder of the command line; prints JSON."""
    import mujoco

    from delta_cad.design import load_design
    from delta_cad.drive import drive_torque
    from delta_cad.drive.masses import masses_from_dict
    from haptics.model.plant import FREE, STATES, advance, plant

    folder, machine, design = Path(sys.argv[1]), _machine(), load_design(BEST)
    masses = json.loads((folder / "mass_properties.json").read_text())
    known = masses_from_dict(masses, design.geometry.forearm_length, drive_torque(design))
    par = plant(design.geometry, known, design.requirements.gravity_m_s2)
    model = mujoco.MjModel.from_xml_path(str(folder / "twin.xml"))
    model.opt.timestep, model.eq_solref[:] = STEP_S, [2.0 * STEP_S, 1.0]
    torque, zero, home = np.array(PUSH), np.zeros(3), machine.centre

    def project_own(steps: int, seconds: float) -> np.ndarray:
        state = np.zeros(STATES)
        state[:3] = home
        advance(par, FREE, zero, zero, torque, seconds, steps, state, np.zeros((13, STATES)))
        return state[:3]

    def theirs(steps: int) -> np.ndarray:
        data = mujoco.MjData(model)
        data.ctrl[:] = torque
        mujoco.mj_step(model, data, steps)
        return data.qpos[-3:] + home

    few, moved = round(ERROR_S / STEP_S), project_own(200_000, ERROR_S)
    # over the whole second in pieces, each from home, so that both stay inside their workspace
    pieces = STEPS // few
    times = interleaved(
        {
            "ours": lambda: [project_own(few, ERROR_S) for _ in range(pieces)],
            "theirs": lambda: [theirs(few) for _ in range(pieces)],
        },
        ROUNDS,
        process_time,
    )
    whole = STEPS / (few * pieces)
    print(
        json.dumps(
            {
                "ours": [t * whole for t in times["ours"]],
                "theirs": [t * whole for t in times["theirs"]],
                "our_error_m": float(np.linalg.norm(project_own(few, ERROR_S) - moved)),
                "their_error_m": float(np.linalg.norm(theirs(few) - moved)),
                "version": f"MuJoCo {mujoco.__version__}",
                "dof": model.nv,
            }
        )
    )
