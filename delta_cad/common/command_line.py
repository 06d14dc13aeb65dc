"""A command line: its commands, version, completion, hints and exit codes; loads what a command needs when it runs."""

from __future__ import annotations

import argparse
import os
import re
import signal
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from delta_cad.common.console import (
    BAD_INPUT,
    DONE,
    INTERRUPTED,
    Interrupt,
    ProgressLine,
    StandardOutput,
    open_streams,
    os_error_text,
    refuse,
    refuse_all,
)
from delta_cad.common.options import Option, add_options
from delta_cad.common.refusal import RefusedError, meant, not_installed
from delta_cad.common.versions import difference

_SHELLS = ("bash", "zsh", "tcsh")
_DISTRIBUTION = "delta-haptics"
_NO_MEMORY = "the memory that this process may have is not enough"
_NOTHING_WRITTEN = "interrupted; nothing was written"
# Exit codes of every command line.
_EXIT_CODES = {DONE: "done", BAD_INPUT: "the input or the usage is wrong", INTERRUPTED: "interrupted by Ctrl-C"}


class Parser(argparse.ArgumentParser):
    """Usage errors in one line, as all other errors."""

    def error(self, message: str) -> Any:
        """Ends the program with one line."""
        what = f"{message}{hint(message, self)}".removesuffix("?")
        raise SystemExit(refuse(f"{self.prog}: {what}; see {self.prog} --help", BAD_INPUT))


@dataclass(frozen=True)
class Program:
    """A command line.

    Attributes:
        package: Package that `python -m` runs.
        description: What the program does.
        commands: Modules, each with `NAME`, `TEXT`, `OPTIONS` and `run(given) -> exit code`.
        exit_codes: What exit codes mean besides those of `_EXIT_CODES`, or in place of them.
        extra: Extra of the distribution that installs what is missing, if a module is.
    """

    package: str
    description: str
    commands: Sequence[ModuleType]
    exit_codes: Mapping[int, str]
    extra: str

    def parser(self, program: str = "") -> Parser:
        """Makes the parser of all commands; what it parses has the command's function as `run`.

        Args:
            program: As the help names it; by default as it is run from a checkout.
        """
        codes = sorted((_EXIT_CODES | dict(self.exit_codes)).items())
        epilog = f"exit codes: {'; '.join(f'{code} {meaning}' for code, meaning in codes)}"
        top = Parser(prog=program or f"python -m {self.package}", description=self.description, epilog=epilog)
        version = Option("--version", action=_Version)
        add_options(top, [version, Option("--completion", action=_Completion, program=self)])
        below = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
        for module in self.commands:
            command = below.add_parser(module.NAME, help=module.TEXT, description=module.TEXT, epilog=epilog)
            add_options(command, [version, *module.OPTIONS])
            command.set_defaults(run=module.run)
        return top

    def main(self, arguments: Sequence[str] | None = None) -> int:
        """Runs one command and returns its exit code; a reader that goes away early is no error and does not change it.

        Args:
            arguments: As typed; None for those of the process.
        """
        open_streams()
        try:
            with redirect_stdout(StandardOutput(sys.stdout)) as out:  # type: ignore[type-var]
                try:
                    given = self.parser().parse_args(with_negatives(sys.argv[1:] if arguments is None else arguments))
                    if note := difference():
                        print(note, file=sys.stderr)
                    getattr(given, "settle", lambda _: None)(given)
                    ProgressLine.as_json = getattr(given, "progress", "") == "json"
                    with Interrupt(), ProgressLine(until_heard=True) as line:
                        line.show("loading")
                        return given.run(given)
                finally:
                    out.flush()
        except KeyboardInterrupt:
            return refuse(_NOTHING_WRITTEN, INTERRUPTED)
        except RefusedError as error:
            return refuse_all(error.lines, BAD_INPUT)
        except OSError as error:
            return refuse(os_error_text(error), BAD_INPUT)
        except ModuleNotFoundError as error:
            return refuse(not_installed(str(error.name), self.extra), BAD_INPUT)
        except ImportError as error:  # its own words name the library of the system that is missing or finds no memory
            return refuse(f"a library cannot be loaded: {error}", BAD_INPUT)
        except MemoryError:
            return refuse(_NO_MEMORY, BAD_INPUT)


def run_program(commands: str) -> NoReturn:
    """Runs commands as a process; Ctrl-C also while they load is one line, and none once they are done.

    Args:
        commands: Module with `main() -> exit code`.
    """
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: threads only wait for each other
    open_streams()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C
    try:
        code = import_module(commands).main()
    except KeyboardInterrupt:
        code = refuse(_NOTHING_WRITTEN, INTERRUPTED)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    # At once: threads and other processes may be busy for long, and none writes a file. So what Ctrl-C ended well:
    # if it struck in text that is executed, the interpreter would end by the signal, though it was caught.
    if code == INTERRUPTED or Interrupt.heard:
        with suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)
    sys.exit(code)


class _Version(argparse.Action):
    """Prints the version and ends."""

    def __init__(self, option_strings: list[str], dest: str, **_: Any) -> None:
        text = "print the version and exit"
        super().__init__(option_strings, dest, nargs=0, default=argparse.SUPPRESS, help=text)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        """Prints it."""
        from importlib.metadata import version

        print(f"{_DISTRIBUTION} {version(_DISTRIBUTION)}")
        parser.exit()


class _Completion(argparse.Action):
    """Prints the script with which a shell completes the commands of the installed program, and ends."""

    def __init__(self, option_strings: list[str], dest: str, program: Program) -> None:
        text = "print the completion script of the installed command for a shell and exit"
        super().__init__(option_strings, dest, default=argparse.SUPPRESS, choices=_SHELLS, help=text)
        self.program = program

    def __call__(self, parser: argparse.ArgumentParser, _space: Any, shell: Any, _option: Any = None) -> None:
        """Prints it."""
        import shtab

        whole = self.program.parser(f"delta-{self.program.package.removeprefix('delta_')}")
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


def with_negatives(arguments: Sequence[str]) -> list[str]:
    """Joins a value such as `-10,5,90` to its option, `--at=-10,5,90`, instead of its being taken for one."""
    joined: list[str] = []
    for argument in arguments:
        if joined and joined[-1].startswith("--") and "=" not in joined[-1] and re.match(r"-[\d.]+,", argument):
            joined[-1] += "=" + argument
        else:
            joined.append(argument)
    return joined
