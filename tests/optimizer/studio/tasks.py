"""Tasks of the studio's tests, and a session whose messages are kept."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from optimizer.codesign.hardware import Selection
from optimizer.studio.document import Document
from optimizer.studio.session import Session
from optimizer.studio.setting import Task
from tests.committed import ROOT
from tests.terminal import HANGS_S

JOYSTICK = ROOT / "joystick.toml"
HARDWARE = Selection("maxon-re30-310007", "capstan", 4.85, 50.0)
POCKET = """
name = "pocket"
[requirements]
cube_side_mm = 40
force_N = 3
[feel]
kappa_max = 2.5
friction_max_N = 0.72
effective_mass_max_kg = 0.4
[hardware]
motor = "maxon-re30-310007"
[goal]
minimize = "outline"
"""


def joystick(placed: bool = False, **values: float) -> Task:
    """The dashboard's task with other values of some fields, dots written as two underscores."""
    given = {name.replace("__", "."): value for name, value in values.items()}
    return Task(Document.read(JOYSTICK).brief(given), HARDWARE.with_(placed=placed))


def pocket(**values: float) -> Task:
    """A least machine's task likewise."""
    given = {name.replace("__", "."): value for name, value in values.items()}
    return Task(Document(POCKET, "pocket.toml", Path()).brief(given), HARDWARE.with_(ratio=4.24, width_mm=36.0))


def until(holds: Callable[[], Any]) -> Any:
    """Waits until something holds, and gives it; fails where it never does."""
    end = time.monotonic() + HANGS_S
    while not (found := holds()):
        assert time.monotonic() < end, "it never came"
        time.sleep(0.02)
    return found


class Kept(list[dict[str, Any]]):
    """Messages that a session sent."""

    def of(self, kind: str, /, **fields: Any) -> list[dict[str, Any]]:
        """Those of a kind with some fields."""
        found = [one for one in list(self) if one["type"] == kind]
        return [one for one in found if all(one.get(name) == value for name, value in fields.items())]


@contextmanager
def session(folder: Path, text: str | None = None) -> Iterator[tuple[Session, Kept]]:
    """A session on a copy of the dashboard's requirements, or another text, in a folder; not begun."""
    path = folder / "req.toml"
    path.write_text(JOYSTICK.read_text(encoding="utf-8") if text is None else text, encoding="utf-8")
    kept = Kept()
    one = Session(Document.read(path), path, folder / "out", kept.append)
    try:
        yield one, kept
    finally:
        one.close()
