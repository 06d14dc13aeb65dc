"""`init`: a requirements file with every field that may stand in it, most of them commented out."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

from delta_cad.common.console import BAD_INPUT, DONE, refuse
from delta_cad.common.options import Option

NAME = "init"
TEXT = "write a commented requirements file to start from"
PRESETS = {
    "dashboard": "the largest cube within 270 x 220 mm, 3 N",
    "desktop": "a cube of 150 mm, 10 N",
    "pocket": "a cube of 40 mm, 3 N",
    "large": "a cube of 250 mm, 3 N",
    "maker": "a cube of 60 mm, 2 N, printed, with gimbal motors, as cheap as it can be",
}
FOLDER = Path(__file__).with_name("presets")
_NAME_FIELD = "name"
_WIDTH = 34  # column in which sentences begin, unless what they follow is longer
_FIELD = re.compile(r"(?:# )?(\w+) = (.+?)(?:  # (.+))?")
OPTIONS = (
    Option(
        "preset",
        nargs="?",
        choices=tuple(PRESETS),
        default="dashboard",
        help="; ".join(f"{name}: {what}" for name, what in PRESETS.items()) + "; default: dashboard",
    ),
    Option(
        "--out",
        type=Path,
        metavar="REQ.toml",
        help="file to write, whose name becomes the name of the design; default: PRESET.toml",
    ),
    Option("--force", action="store_true", help="overwrite an existing file"),
)


def run(given: argparse.Namespace) -> int:
    """Writes the file and says so."""
    from delta_cad.common.files import write_whole

    out = given.out or Path(f"{given.preset}.toml")
    if not given.force and (out.exists() or out.is_symlink()):
        return refuse(f"{out}: is there already; to replace it give --force, to leave it another --out", BAD_INPUT)
    write_whole(out, preset_text(given.preset, out.stem))
    then = f"python -m optimizer design {shlex.quote(str(out))}"
    print(f"{out}: {PRESETS[given.preset]}; edit it, then: {then}")
    return DONE


def preset_text(preset: str, name: str | None = None) -> str:
    """Writes a requirements file: what a preset states, the default limits of feel, all other fields commented out.

    Args:
        preset: A key of `PRESETS`.
        name: Of the design; None, or what no design may be called, for the preset's.
    """
    from delta_cad.design import NAME_PATTERN
    from delta_cad.design.feel_defaults import feel_defaults

    title, *own = (FOLDER / f"{preset}.toml").read_text(encoding="utf-8").splitlines()
    stated = {(table, found[1]): found for table, found in _fields(own) if isinstance(found, re.Match)}
    force = float(stated["requirements", "force_N"][2])
    feel = {field: f"{value:g}" for field, value in feel_defaults(force).items() if ("feel", field) not in stated}
    lines = [title]
    for table, found in _fields((FOLDER / "fields.toml").read_text(encoding="utf-8").splitlines()):
        if isinstance(found, str):
            lines.append(found)
            continue
        field, value, reported = found.groups()
        chosen = stated.get((table, field))
        if chosen is not None:
            value, reported = chosen[2], chosen[3] or reported
        elif table == "feel" and field in feel:
            value = feel[field]
            reported += "" if "default" in reported else "; the default for this force"
        if field == _NAME_FIELD and name is not None and re.fullmatch(NAME_PATTERN, name):
            value = f'"{name}"'
        inert = "" if chosen or (table == "feel" and field in feel) else "# "
        lines.append(f"{f'{inert}{field} = {value}':{_WIDTH}} # {reported}")
    return "\n".join(lines) + "\n"


def _fields(lines: list[str]) -> Iterator[tuple[str, re.Match[str] | str]]:
    """Goes through lines of TOML: the table each stands in, and field, value and sentence of it, or the line."""
    table = ""
    for line in lines:
        if line.startswith("["):
            table = line[1 : line.index("]")]
        yield table, _FIELD.fullmatch(line) or line
