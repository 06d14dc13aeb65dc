"""`studio`: requirements as sliders in a browser, what they come to while they move, and a build from there."""

from __future__ import annotations

import argparse
import threading
from contextlib import ExitStack
from pathlib import Path

from delta_cad.common.console import BAD_INPUT, DONE, Interrupt, ProgressLine, refuse, refuse_all, refuse_folder
from delta_cad.common.options import OUT_FOLDER, REQUIREMENTS, REQUIREMENTS_CATALOGUE
from delta_cad.common.refusal import not_installed
from delta_cad.report.live.door import Door, address_fault, address_options
from optimizer.commands.init import preset_text

NAME = "studio"
TEXT = "live page: requirements as sliders, the largest cube and what binds, a build from the page; Ctrl-C stops it"
_PRESET = "dashboard"

OPTIONS = (
    REQUIREMENTS.but(nargs="?", help=f"requirements file; default: that of `init {_PRESET}`, written when it is saved"),
    OUT_FOLDER,
    REQUIREMENTS_CATALOGUE,
    *address_options(8090),
)


def run(given: argparse.Namespace) -> int:
    """Serves the page until Ctrl-C; returns the exit code."""
    with ProgressLine(until_heard=True) as line:
        line.show("loading")
        try:
            from optimizer.studio.document import Document
            from optimizer.studio.server import PROTOCOL, StudioServer
            from optimizer.studio.session import Session
        except ModuleNotFoundError as error:
            return refuse(not_installed(str(error.name), "view"), BAD_INPUT)
        from delta_cad.common.files import require_room
        from optimizer.problem.validation import RequirementsError

        if fault := address_fault(given.host, given.port, given.allow_remote):
            return refuse(fault, BAD_INPUT)
        path = given.requirements or Path(f"{_PRESET}.toml")
        try:
            if given.requirements is None:
                document = Document(preset_text(_PRESET), path.name, path.parent, given.catalogue)
            else:
                document = Document.read(path, given.catalogue)
            brief = document.brief()
        except RequirementsError as error:
            return refuse_all(error.lines, BAD_INPUT)
        try:
            require_room(given.out / brief.name, folder=True)
        except OSError as error:
            return refuse_folder(given.out, error)
    with ExitStack() as ends:  # outside of what hears Ctrl-C: that would come again while all of it ends
        door = Door(given.host, given.port, lambda words: refuse(words, DONE), PROTOCOL)
        server = StudioServer(
            door,
            lambda: given.out / session.brief.name,
            lambda: session.hello(),
            lambda message, viewer: session.receive(message, viewer),
        )
        session = Session(document, path, given.out, server.send, saved=given.requirements is not None)
        ends.callback(session.close)
        ends.callback(server.close)
        try:
            with Interrupt():
                server.begin()
                session.begin()
                print(f"{door.url}  Ctrl-C ends it", flush=True)
                threading.Event().wait()
        except KeyboardInterrupt:  # how it is meant to end
            return DONE
        except OSError as error:
            return refuse(f"--host {given.host} --port {given.port}: {error.strerror or error}", BAD_INPUT)
    return DONE
