"""The common part of all commands: exit codes, one-line errors, Ctrl-C, a line of progress; loads nothing heavy."""

from __future__ import annotations

import argparse
import os
import re
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout, suppress
from types import FrameType, ModuleType
from typing import Any, TextIO

from delta_cad.common.refusal import printable

DONE, NOT_MET, BAD_INPUT = 0, 1, 2
INTERRUPTED = 130  # 128 + SIGINT, as shells have it


class Parser(argparse.ArgumentParser):
    """Usage errors in one line, as all other errors."""

    def error(self, message: str) -> Any:
        """Ends the program with one line."""
        raise SystemExit(refuse(f"{self.prog}: {message}; see {self.prog} --help", BAD_INPUT))


def command_parser(program: str, description: str, epilog: str, commands: Sequence[ModuleType]) -> Parser:
    """Makes the parser of all commands.

    Args:
        program: As the help names it.
        description: What the program does.
        epilog: Exit codes, under every help.
        commands: Modules, each with `NAME`, `TEXT`, `arguments(parser)` and `run(given) -> exit code`.

    Returns:
        The parser; what it parses has the command's function as `run`.
    """
    top = Parser(prog=program, description=description, epilog=epilog)
    below = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in commands:
        command = below.add_parser(module.NAME, help=module.TEXT, description=module.TEXT, epilog=epilog)
        module.arguments(command)
        command.set_defaults(run=module.run)
    return top


def run_command(parser: Parser, arguments: Sequence[str] | None, extra: str) -> int:
    """Runs one command and returns its exit code; a reader that goes away early is no error and does not change it.

    Args:
        parser: What `command_parser` made.
        arguments: As typed; None for those of the process.
        extra: Extra of the package that installs what is missing, if a module is.
    """
    try:
        with redirect_stdout(_Output(sys.stdout)) as out:  # type: ignore[type-var]
            try:
                given = parser.parse_args(with_negatives(sys.argv[1:] if arguments is None else arguments))
                code = given.run(given)
            finally:
                out.flush()
    except KeyboardInterrupt:
        return refuse("interrupted; nothing was written", INTERRUPTED)
    except OSError as error:
        return refuse(told(error), BAD_INPUT)
    except ModuleNotFoundError as error:
        return refuse(f"{error.name} is not installed: pip install 'delta-haptics[{extra}]'", BAD_INPUT)
    return code


def told(error: OSError) -> str:
    """Says what the system refused: the path, if it is known, and why."""
    why = error.strerror or str(error) or type(error).__name__
    return why if error.filename is None else f"{os.fsdecode(error.filename)}: {why}"


class _Output:
    """A text stream whose reader may go away: what is left to write then goes nowhere.

    So it does after any other failure, which is an error of standard output, and at every flush again: who wrote may
    have kept silent about it, as argparse does. What the stream's encoding has not, as the bytes of a file name that
    are no text, is escaped.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._failure: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Writes text, or drops it."""
        try:
            self._stream.write(text)
        except UnicodeEncodeError as error:
            self._stream.write(text.encode(error.encoding, "backslashreplace").decode(error.encoding))
        except OSError as error:
            self._drop(error)
        return len(text)

    def flush(self) -> None:
        """Writes what is held back, or drops it."""
        try:
            self._stream.flush()
        except OSError as error:
            self._drop(error)
        if self._failure is not None:
            raise self._failure

    def _drop(self, error: OSError) -> None:
        _to_nowhere(self._stream)
        if not isinstance(error, BrokenPipeError):
            self._failure = OSError(error.errno, error.strerror, "standard output")
            raise self._failure from None


def _to_nowhere(stream: TextIO) -> None:
    """Lets what a stream still holds, and what comes, go nowhere, so that Python's end does not fail on it."""
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def with_negatives(arguments: Sequence[str]) -> list[str]:
    """Joins a value such as `-10,5,90` to its option, `--at=-10,5,90`, instead of its being taken for one."""
    joined: list[str] = []
    for argument in arguments:
        if joined and joined[-1].startswith("--") and "=" not in joined[-1] and re.match(r"-[\d.]+,", argument):
            joined[-1] += "=" + argument
        else:
            joined.append(argument)
    return joined


def natural(text: str) -> int:
    """A whole number of the command line, for argparse."""
    value = int(text)
    if value < 0:
        raise ValueError(text)
    return value


natural.__name__ = "whole number"  # as argparse names it


def refuse(message: str, code: int) -> int:
    """Tells what is wrong in one printable line on stderr, if that can be written, and returns the exit code."""
    try:
        print(printable(message), file=sys.stderr, flush=True)
    except OSError:
        _to_nowhere(sys.stderr)
    return code


class Interrupt:
    """Whether Ctrl-C was pressed; a second one interrupts at once."""

    def __init__(self) -> None:
        self._asked = False
        self._before: Any = None

    def __enter__(self) -> Callable[[], bool]:
        self._before = signal.signal(signal.SIGINT, self._take)
        return lambda: self._asked

    def __exit__(self, *_: object) -> None:
        signal.signal(signal.SIGINT, self._before)

    def _take(self, _number: int, _frame: FrameType | None) -> None:
        if self._asked:
            raise KeyboardInterrupt
        self._asked = True


class Line:
    """One line of progress on stderr, on a terminal only."""

    def __init__(self) -> None:
        self._wanted = sys.stderr.isatty()

    def __enter__(self) -> Line:
        return self

    def __exit__(self, *_: object) -> None:
        if self._wanted:
            print("\r\033[K", end="", file=sys.stderr, flush=True)

    def show(self, text: str) -> None:
        """Replaces what the line said."""
        if self._wanted:
            print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)
