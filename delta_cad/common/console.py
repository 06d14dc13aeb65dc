"""The common part of all commands: exit codes, one-line errors, Ctrl-C, a line of progress; loads nothing heavy."""

from __future__ import annotations

import argparse
import errno
import os
import re
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from types import FrameType, ModuleType
from typing import Any, TextIO

DONE, NOT_MET, BAD_INPUT = 0, 1, 2
INTERRUPTED = 130  # 128 + SIGINT, as shells have it


class Parser(argparse.ArgumentParser):
    """Usage errors in one line, as all other errors."""

    def error(self, message: str) -> Any:
        """Ends the program with one line."""
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


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
        given = parser.parse_args(with_negatives(sys.argv[1:] if arguments is None else arguments))
        with redirect_stdout(_Output(sys.stdout)) as out:  # type: ignore[type-var]
            code = given.run(given)
            out.flush()
    except KeyboardInterrupt:
        return refuse("interrupted; nothing was written", INTERRUPTED)
    except OSError as error:
        if error.errno != errno.ENOSPC:
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return refuse(f"the output could not be written: {error.strerror}", NOT_MET)
    except ModuleNotFoundError as error:
        return refuse(f"{error.name} is not installed: pip install 'delta-haptics[{extra}]'", BAD_INPUT)
    return code


class _Output:
    """A text stream whose reader may go away: what is left to write then goes nowhere."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Writes text, or drops it."""
        try:
            return self._stream.write(text)
        except BrokenPipeError:
            return self._drop(len(text))

    def flush(self) -> None:
        """Writes what is held back, or drops it."""
        try:
            self._stream.flush()
        except BrokenPipeError:
            self._drop(0)

    def _drop(self, count: int) -> int:
        os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())
        return count


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
    """Tells what is wrong in one line on stderr and returns the exit code."""
    print(" ".join(message.split()), file=sys.stderr)
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
