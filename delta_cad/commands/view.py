"""`view`: the machine live in a browser: drag the handle, change the lengths, see what follows."""

from __future__ import annotations

import argparse
import io
import threading
from contextlib import closing, redirect_stdout
from typing import TYPE_CHECKING

from delta_cad.commands.machine import geometry_errors, refuse_design, refuse_hardware
from delta_cad.common.console import BAD_INPUT, DONE, NOT_BUILT, Interrupt, ProgressLine, refuse
from delta_cad.common.options import CATALOGUE, DESIGN, OUT_FOLDER
from delta_cad.common.refusal import not_installed
from delta_cad.report.live.door import address_fault, address_options

if TYPE_CHECKING:
    import numpy as np
    from viser import ViserServer

    from delta_cad.design import Design
    from delta_cad.report.live.guard import Guard
    from delta_cad.report.live.page import LivePage

NAME = "view"
TEXT = "live page in the browser: drag the handle, change lengths; Ctrl-C stops it"

OPTIONS = (
    DESIGN,
    CATALOGUE,
    OUT_FOLDER.but(help="folder of builds, of which the last one's solids are shown first; default: out"),
    *address_options(8080),
)


def run(given: argparse.Namespace) -> int:
    """Serves the page until Ctrl-C; returns the exit code."""
    from delta_cad.design import DesignError, load_design
    from delta_cad.mechanism import MechanismError

    try:
        design = load_design(given.design, given.catalogue)
        if (code := refuse_hardware(given, design)) is not None:
            return code
    except DesignError as error:
        return refuse_design(given, error)
    except MechanismError as error:
        return refuse(f"{given.design.name}: cube: {error}", BAD_INPUT)
    try:
        from delta_cad.report.live.guard import Guard, guarded_server
    except ModuleNotFoundError as error:
        return refuse(not_installed(str(error.name), "view"), BAD_INPUT)
    if fault := address_fault(given.host, given.port, given.allow_remote):
        return refuse(fault, BAD_INPUT)
    guard = Guard(given.host, given.port, lambda line: refuse(line, DONE))
    server = guarded_server(guard, design.name)
    try:
        with Interrupt():  # of its own: what was heard does not come again while the server stops
            return _serve(server, guard, design, given)
    except KeyboardInterrupt:  # how it is meant to end
        return DONE
    finally:
        guard.end()
        with redirect_stdout(io.StringIO()):
            server.stop()


def _serve(server: ViserServer, guard: Guard, design: Design, given: argparse.Namespace) -> int:
    """Shows the skeleton at once and the solids when they are made; goes on until it is interrupted."""
    from delta_cad.report.live.page import HANDLE, LivePage

    with closing(LivePage(server, design)) as page:
        guard.begin(page.ranges(), HANDLE, page.nearest_m)
        print(f"{guard.url}  Ctrl-C ends it", flush=True)
        try:
            _solids(page, design, given)
        except KeyboardInterrupt:  # the next clause would load the CAD kernel, again where that was interrupted
            raise
        except geometry_errors() as error:
            return refuse(f"{given.design.name}: {error}", NOT_BUILT)
        threading.Event().wait()
    return DONE


def _solids(page: LivePage, design: Design, given: argparse.Namespace) -> None:
    """Makes the solids and gives them to the page; until then it shows those of the last build, and says so."""
    # stdout: a kernel whose loading Ctrl-C interrupts says there that a library were missing
    with ProgressLine() as line, redirect_stdout(io.StringIO()):
        from delta_cad.report.live.earlier import earlier_machine

        shown = "the mechanism is shown as lines"
        page.say(f"The solids are being made, which takes about a minute; until then {shown}.")
        if (earlier := earlier_machine(design, given.out / design.name, given.catalogue)) is not None:
            page.show_earlier(earlier)
            shown = "those of the last build are shown"
            shown += "" if earlier.same else f", which is of another design, faint, and {design.name} as lines"

        def doing(words: str) -> None:
            line.show(words)
            page.say(f"The solids are being made, which takes about a minute ({words}); until then {shown}.")

        doing("loading the CAD kernel")
        import numpy as np

        from delta_cad.checks.range.holding import holding_torque, moving_bodies
        from delta_cad.commands.pipeline import check_limits, make_machine
        from delta_cad.drive import drive_torque
        from delta_cad.drive.masses import masses_from_dict
        from delta_cad.report.live.nearest import Neighbours

        machine = make_machine(design, doing)
    masses = masses_from_dict(machine.masses, design.geometry.forearm_length, drive_torque(design))
    bodies, gravity = moving_bodies(machine.masses), np.array(design.requirements.gravity_m_s2)

    def weight(p_mm: np.ndarray) -> np.ndarray:
        return holding_torque(machine.assembly, bodies, p_mm, gravity)

    neighbours = Neighbours(machine.assembly, check_limits(machine.dimensions, machine.masses), machine.meshes)
    page.solids(machine.assembly, machine.meshes, masses.handle_inertia, weight, neighbours)
    page.say("")
