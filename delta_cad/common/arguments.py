"""What the commands' arguments share: the design that stands in the folder, version, completion, hints; loads late."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from delta_cad.common.refusal import meant

OUT = Path("out")
STANDING = Path("best.json")  # the design that is taken where none is given
SHELLS = ("bash", "zsh", "tcsh")
DISTRIBUTION = "delta-haptics"


def design_option(
    command: argparse.ArgumentParser, text: str = "design file, delta-design/1", unless: str = ""
) -> None:
    """Adds `--design FILE`; left out, `settle` takes the one that stands in the folder.

    Args:
        command: The command.
        text: What the file is for.
        unless: Option with which no design is needed.
    """
    help_text = f"{text}; default: {STANDING} of the current folder"
    command.add_argument("--design", type=Path, metavar="FILE", help=help_text)

    def settle(given: argparse.Namespace) -> None:
        if given.design is not None or (unless and getattr(given, unless)):
            return
        if not STANDING.is_file():
            command.error(f"--design FILE is needed: there is no {STANDING} in this folder")
        given.design = STANDING
        with suppress(OSError, AttributeError):  # nobody reads
            print(f"--design {STANDING}: taken, as none was given", file=sys.stderr, flush=True)

    command.set_defaults(settle=settle)


def json_option(command: argparse.ArgumentParser) -> None:
    """Adds `--json`, which every command with facts to tell has."""
    command.add_argument("--json", action="store_true", help="print the results as JSON on stdout")


def out_option(command: argparse.ArgumentParser) -> None:
    """Adds `--out DIR`, the folder in which a command makes folders and files of its own names."""
    command.add_argument(
        "--out", type=Path, default=OUT, metavar="DIR", help=f"parent folder of results; default: {OUT}"
    )


class Version(argparse.Action):
    """Prints the version and ends."""

    def __init__(self, option_strings: list[str], dest: str, **_: Any) -> None:
        text = "print the version and exit"
        super().__init__(option_strings, dest, nargs=0, default=argparse.SUPPRESS, help=text)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        """Prints it."""
        from importlib.metadata import version

        print(f"{DISTRIBUTION} {version(DISTRIBUTION)}")
        parser.exit()


class Completion(argparse.Action):
    """Prints the script with which a shell completes the commands, and ends."""

    def __init__(self, option_strings: list[str], dest: str, make: Callable[[], argparse.ArgumentParser]) -> None:
        text = "print the completion script of the installed command for a shell and exit"
        super().__init__(option_strings, dest, default=argparse.SUPPRESS, choices=SHELLS, help=text)
        self.make = make

    def __call__(self, parser: argparse.ArgumentParser, _space: Any, shell: Any, _option: Any = None) -> None:
        """Prints it."""
        import shtab

        whole = self.make()
        for action in actions(whole):
            if action.type is Path:
                action.complete = shtab.DIRECTORY if action.metavar == "DIR" else shtab.FILE  # type: ignore[attr-defined]
        print(shtab.complete(whole, shell=shell))
        parser.exit()


def actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Lists all arguments of a parser and of its commands."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in dict.fromkeys(action.choices.values()):
                yield from actions(command)


def hint(message: str, parser: argparse.ArgumentParser) -> str:
    """Says what a wrong word of the command line was probably meant to be.

    Args:
        message: What argparse says of it.
        parser: The parser of all commands, or of one.

    Returns:
        "", "; did you mean WORD?", or that other commands have the option.
    """
    if found := re.search(r"unrecognized arguments: (--[\w-]+)", message):
        options = {name for action in actions(parser) for name in action.option_strings}
        return "; other commands have it, this one has not" if found[1] in options else _hint(found[1], sorted(options))
    if found := re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message):
        return _hint(found[1], re.findall(r"[\w+.-]+", found[2]))
    return ""


def _hint(word: str, known: Iterable[str]) -> str:
    found = meant(word, known)
    return f"; did you mean {found}?" if found else ""
