"""`view`: the machine live in a browser: drag the handle, change the lengths, see what follows."""

from __future__ import annotations

import argparse
import io
import socket
import threading
from contextlib import closing, redirect_stdout
from typing import TYPE_CHECKING

from delta_cad.commands.machine import geometry_errors, refuse_design, refuse_hardware
from delta_cad.common.arguments import design_option
from delta_cad.common.console import BAD_INPUT, DONE, Interrupt, Line, catalogue_option, refuse
from delta_cad.common.refusal import not_installed

if TYPE_CHECKING:
    import numpy as np
    from viser import ViserServer

    from delta_cad.design import Design
    from delta_cad.report.live.page import LivePage

NAME = "view"
TEXT = "live page in the browser: drag the handle, change lengths; Ctrl-C stops it"
LOOPBACK = "127.0.0.1"
PORT, MOST_PORT = 8080, 65535
NOT_BUILT = 3


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    design_option(command)
    catalogue_option(command)
    command.set_defaults(json=False)
    command.add_argument("--port", type=int, default=PORT, metavar="N", help=f"port of the page; default: {PORT}")
    command.add_argument(
        "--host",
        default=LOOPBACK,
        metavar="ADDRESS",
        help="address to listen on; default: 127.0.0.1, this machine only",
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
        import viser
    except ModuleNotFoundError as error:
        return refuse(not_installed(str(error.name), "view"), BAD_INPUT)
    if not 0 < given.port <= MOST_PORT:
        return refuse(f"--port {given.port}: must be from 1 to {MOST_PORT}", BAD_INPUT)
    try:  # viser would take the next one that is free
        with socket.create_server((given.host, given.port)):
            pass
    except OSError as error:
        told = f"--host {given.host} --port {given.port}: {error.strerror or error}"
        return refuse(f"{told}; must be an address of this machine and a free port", BAD_INPUT)
    with redirect_stdout(io.StringIO()):  # which would tell the address in a frame
        server = viser.ViserServer(host=given.host, port=given.port, label=design.name, verbose=False)
    try:
        with Interrupt():  # of its own: what was heard does not come again while the server stops
            return _serve(server, design, given)
    except KeyboardInterrupt:  # how it is meant to end
        return DONE
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


def _serve(server: ViserServer, design: Design, given: argparse.Namespace) -> int:
    """Shows the skeleton at once and the solids when they are made; goes on until it is interrupted."""
    from delta_cad.report.live.page import LivePage

    with closing(LivePage(server, design)) as page:
        print(f"http://{given.host}:{given.port}  Ctrl-C ends it", flush=True)
        try:
            _solids(page, design)
        except KeyboardInterrupt:  # the next clause would load the CAD kernel, again where that was interrupted
            raise
        except geometry_errors() as error:
            return refuse(f"{given.design.name}: {error}", NOT_BUILT)
        threading.Event().wait()
    return DONE


def _solids(page: LivePage, design: Design) -> None:
    """Makes the solids and gives them to the page."""
    # stdout: a kernel whose loading Ctrl-C interrupts says there that a library were missing
    with Line() as line, redirect_stdout(io.StringIO()):
        line.show("loading the CAD kernel")
        import numpy as np

        from delta_cad.checks.range.holding import holding_torque, moving_bodies
        from delta_cad.commands.pipeline import check_limits, make_machine
        from delta_cad.drive import drive_torque
        from delta_cad.drive.masses import masses_from_dict
        from delta_cad.report.live.nearest import Neighbours

        machine = make_machine(design, line.show)
    masses = masses_from_dict(machine.masses, design.geometry.forearm_length, drive_torque(design))
    bodies, gravity = moving_bodies(machine.masses), np.array(design.requirements.gravity_m_s2)

    def weight(p_mm: np.ndarray) -> np.ndarray:
        return holding_torque(machine.assembly, bodies, p_mm, gravity)

    neighbours = Neighbours(machine.assembly, check_limits(machine.dimensions, machine.masses), machine.meshes)
    page.solids(machine.assembly, machine.meshes, masses.handle_inertia, weight, neighbours)
