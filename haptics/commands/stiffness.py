"""`stiffness`: the largest stable wall along each axis, with its range and the passivity verdict."""

from __future__ import annotations

import argparse
import json

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, ProgressLine, refuse
from delta_cad.common.options import JSON, OUT_FOLDER, Option, number
from haptics.commands.device import DEVICE_OPTIONS, LOOP_OPTIONS

NAME = "stiffness"
TEXT = "largest stable wall per axis, N/mm: simulated and linear, with ranges and passivity"
OPTIONS = (
    *DEVICE_OPTIONS,
    *LOOP_OPTIONS,
    Option(
        "--period",
        type=number(0.05, 10.0, "ms"),
        default=1.0,
        metavar="MS",
        help="period of the paper loop, ms; default: 1",
    ),
    Option(
        "--delay",
        type=number(0.0, unit="ms"),
        metavar="MS",
        help="delay of the paper loop from reading to torque, ms; default: from 0 to one period",
    ),
    OUT_FOLDER,
    JSON,
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.common.files import require_room, write_whole
    from haptics.loop.choice import chosen_loop, other_drives
    from haptics.loop.page import FOUR_TEXT, stiffness_facts, stiffness_text, walls_facts, walls_text
    from haptics.loop.stiffness import largest_walls
    from haptics.loop.walls import WallStability
    from haptics.model.machine import load_machine
    from haptics.rendering.laws.virtual_wall import AXES

    delay = None if given.delay is None else given.delay / 1e3
    if delay is not None and given.delay > 20.0 * given.period:
        return refuse(f"--delay {given.delay:g} ms: must be at most 20 periods of {given.period:g} ms", BAD_INPUT)
    machine = load_machine(given.design, given.mass_properties, given.catalogue)
    name = machine.design.name
    chosen = chosen_loop(machine.design, given.rate, given.damping, given.drive_damping)
    place = given.out / f"{name}-stiffness.json"
    require_room(place)
    try:
        with ProgressLine() as line:
            four = []
            for loop in (chosen, other_drives(chosen)):
                line.show(f"walls of the {loop.name} loop")
                four.append((loop, {a: WallStability(machine, loop, normal=n).walls() for a, n in AXES.items()}))
            walls = largest_walls(
                machine,
                damping=given.damping or 0.0,
                period=given.period / 1e3,
                delay=delay,
                say=lambda axis: line.show(f"wall across {axis}"),
            )
    except ValueError as error:
        return refuse(f"{given.design}: {error}", BAD_INPUT)
    facts = stiffness_facts(name, walls) | {"loops": [walls_facts(loop, found) for loop, found in four]}
    written = json.dumps(facts, indent=1)
    write_whole(place, written + "\n")
    tables = [line for loop, found in four for line in ("", *walls_text(loop, found))]
    print(written if given.json else "\n".join([stiffness_text(name, walls), *tables, FOUR_TEXT]))
    if not walls.unstable_cases:
        return DONE
    says = ", ".join(f"{axis} with the {hand} hand" for axis, hand in walls.unstable_cases)
    return refuse(f"the default wall oscillates: {says}", NOT_MET)
