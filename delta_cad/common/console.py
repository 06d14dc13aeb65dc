"""The common part of all commands: exit codes, one-line errors, Ctrl-C, a line of progress; loads nothing heavy."""

from __future__ import annotations

import argparse
import math
import os
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout, suppress
from functools import partial
from importlib import import_module
from importlib.machinery import ExtensionFileLoader
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any, ClassVar, NoReturn, TextIO

from delta_cad.common.arguments import Completion, Version, hint
from delta_cad.common.refusal import not_installed, printable
from delta_cad.common.versions import difference

DONE, NOT_MET, BAD_INPUT = 0, 1, 2
CUT_SHORT = 4  # a search ended before it knew: its time was over, or it was stopped
LAST_STREAM = 2  # descriptor of standard error, after those of input and output
INTERRUPTED = 130  # 128 + SIGINT, as shells have it
NO_MEMORY = "the memory that this process may have is not enough"
NOTHING_WRITTEN = "interrupted; nothing was written"
# s from Ctrl-C until whoever does not look is interrupted, and again after that: together less than the 2 s in which a
# command is to end.
GRACE_S, AGAIN_S = 1.0, 0.5
LATER_S = 0.02  # s until it is tried again where it cannot be at once
# What of the interpreter runs while a module in C or C++ begins: tables of its functions and classes are being made.
BEGINS = (ExtensionFileLoader.create_module.__code__, ExtensionFileLoader.exec_module.__code__)
FIRST_S = 0.8  # s until the first line of progress where nobody watches: what ends sooner says nothing
TELL_S = 4.0  # s between two lines of progress there, as in a log


class Parser(argparse.ArgumentParser):
    """Usage errors in one line, as all other errors."""

    def error(self, message: str) -> Any:
        """Ends the program with one line."""
        what = f"{message}{hint(message, self)}".removesuffix("?")
        raise SystemExit(refuse(f"{self.prog}: {what}; see {self.prog} --help", BAD_INPUT))


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
    top.add_argument("--version", action=Version)
    script = program.removeprefix("python -m ").replace("_", "-").removeprefix("delta-")
    whole = partial(command_parser, f"delta-{script}", description, epilog, commands)
    top.add_argument("--completion", action=Completion, make=whole)
    below = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in commands:
        command = below.add_parser(module.NAME, help=module.TEXT, description=module.TEXT, epilog=epilog)
        command.add_argument("--version", action=Version)
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
    _open_streams()
    try:
        with redirect_stdout(_Output(sys.stdout)) as out:  # type: ignore[type-var]
            try:
                given = parser.parse_args(with_negatives(sys.argv[1:] if arguments is None else arguments))
                if note := difference():
                    print(note, file=sys.stderr)
                getattr(given, "settle", _as_given)(given)
                with Interrupt(), Line(until_heard=True) as line:
                    line.show("loading")
                    code = given.run(given)
            finally:
                out.flush()
    except KeyboardInterrupt:
        return refuse(NOTHING_WRITTEN, INTERRUPTED)
    except OSError as error:
        return refuse(told(error), BAD_INPUT)
    except ModuleNotFoundError as error:
        return refuse(not_installed(str(error.name), extra), BAD_INPUT)
    except ImportError as error:  # its own words name the library of the system that is missing or finds no memory
        return refuse(f"a library cannot be loaded: {error}", BAD_INPUT)
    except MemoryError:
        return refuse(NO_MEMORY, BAD_INPUT)
    return code


def _as_given(_: argparse.Namespace) -> None:
    """Leaves what was typed as it is."""


def run_program(commands: str) -> NoReturn:
    """Runs commands as a process; Ctrl-C also while they load is one line, and none once they are done.

    Args:
        commands: Module with `main() -> exit code`.
    """
    _open_streams()
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C
    try:
        code = import_module(commands).main()
    except KeyboardInterrupt:
        code = refuse(NOTHING_WRITTEN, INTERRUPTED)
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


def _open_streams() -> None:
    """Opens those of the three streams that the process was started without: what goes to them goes nowhere.

    Their numbers too, or the next file that is opened would get one, and what a library prints would go into it.
    """
    if None not in (sys.stdin, sys.stdout, sys.stderr):
        return
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= LAST_STREAM:
        pass
    os.close(descriptor)
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115  (as long as the process)


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
        Line.give_way()
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


def catalogue_option(command: argparse.ArgumentParser, names: str = "the design file") -> None:
    """Adds the folder of the user's own parts, `catalogue`; None where it is not given.

    Args:
        command: The command.
        names: Which of its files may name a folder, too.
    """
    command.add_argument(
        "--catalogue",
        type=Path,
        metavar="DIR",
        help=f"folder of your own parts (motor.csv, cable.csv, ...); default: the one named in {names}",
    )


def proof_minutes(command: argparse.ArgumentParser, what: str) -> None:
    """Adds the time that proofs may take, `proof_minutes`; infinite where it is not given.

    Args:
        command: The command.
        what: Which of its proofs together end with it.
    """
    command.add_argument(
        "--proof-minutes",
        type=_positive,
        default=math.inf,
        metavar="M",
        help=f"time limit {what}, minutes; the result so far is kept; default: none",
    )


def _positive(text: str) -> float:
    value = float(text)
    if not 0.0 < value < math.inf:
        raise ValueError(text)
    return value


_positive.__name__ = "number of minutes > 0"  # as argparse names it


def refuse(message: str, code: int) -> int:
    """Tells what is wrong in one printable line on stderr, if that can be written, and returns the exit code."""
    Line.give_way()
    try:
        print(printable(message), file=sys.stderr, flush=True)
    except OSError:
        _to_nowhere(sys.stderr)
    return code


def refuse_folder(out: Path, error: OSError) -> int:
    """Tells that a folder of results cannot be written, or replaced, and returns the exit code.

    Args:
        out: As it was typed.
        error: What the system, or `common.ours`, says of it or of a place below it.
    """
    from delta_cad.common.ours import NotOursError

    at = "" if error.filename in (None, str(out)) else f"{error.filename}: "
    more = "" if isinstance(error, NotOursError) else "; must be a folder that can be written"
    return refuse(f"--out {out}: {at}{error.strerror or error}{more}", BAD_INPUT)


def refuse_all(messages: Sequence[str], code: int) -> int:
    """Tells everything that is wrong, one printable line each, as `refuse` does."""
    for message in messages:
        refuse(message, code)
    return code


class Interrupt:
    """Hears Ctrl-C and SIGTERM: a `KeyboardInterrupt`, which comes again for as long as the block goes on.

    One that strikes in a callback from C is lost, and who called, such as a compiler, fails for what it did not get:
    an error after Ctrl-C is taken for its consequence. One that would strike while a module in C or C++ begins comes
    right after that: of the kernel's half of its classes would be left, and the process end by a fault in memory.

    Attributes:
        heard: Whether Ctrl-C was heard in this process.
    """

    GRACE = False
    heard = False

    def __init__(self) -> None:
        self._asked = False
        self._before: dict[int, Any] = {}
        self._hook = sys.unraisablehook

    def __enter__(self) -> Callable[[], bool]:
        self._hook, sys.unraisablehook = sys.unraisablehook, self._lost
        handlers = {signal.SIGALRM: _interrupt, signal.SIGINT: self._take, signal.SIGTERM: self._take}
        self._before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
        return lambda: self._asked

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        for number, handler in self._before.items():
            signal.signal(number, handler)
        sys.unraisablehook = self._hook
        if self._asked and isinstance(error, Exception):
            raise KeyboardInterrupt from error

    def _lost(self, found: sys.UnraisableHookArgs) -> None:
        if not isinstance(found.exc_value, KeyboardInterrupt):
            self._hook(found)

    def _take(self, number: int, frame: FrameType | None) -> None:
        first, self._asked, Interrupt.heard = not self._asked, True, True
        signal.setitimer(signal.ITIMER_REAL, GRACE_S, AGAIN_S)
        if not (first and self.GRACE):
            _interrupt(number, frame)


class Request(Interrupt):
    """The same, but the first Ctrl-C only asks: who looks within `GRACE_S` ends by itself with what it has."""

    GRACE = True


def _interrupt(_number: int, frame: FrameType | None) -> None:
    """Interrupts, or asks again a little later where a module in C begins."""
    while frame is not None:
        if frame.f_code in BEGINS:
            signal.setitimer(signal.ITIMER_REAL, LATER_S, AGAIN_S)
            return
        frame = frame.f_back
    raise KeyboardInterrupt


class Line:
    """What a long step is doing, on stderr: one line that lives on a terminal that can, elsewhere a line each `TELL_S`.

    The first comes there after `FIRST_S`. Each starts with the seconds since the work began, and is told by a thread of
    its own, so that it also comes while one call takes long.

    Args:
        until_heard: It only bridges the time until something else is said, by another line or as the command's answer.
    """

    _now: ClassVar[Line | None] = None

    def __init__(self, until_heard: bool = False) -> None:
        self._until_heard, self._told = until_heard, False
        self._live = sys.stderr.isatty() and os.environ.get("TERM") != "dumb"  # which erases no line
        self._text, self._start = "", time.monotonic()
        self._done, self._lock = threading.Event(), threading.Lock()
        self._clock = threading.Thread(target=self._tick, daemon=True)

    def __enter__(self) -> Line:
        Line.give_way()
        Line._now = self
        self._clock.start()
        return self

    def __exit__(self, *_: object) -> None:
        if Line._now is self:
            Line._now = None
        if not self._done.is_set():
            self._done.set()
            self._clock.join()
            self._erase()

    @staticmethod
    def give_way() -> None:
        """Lets something else be said: a line that bridges ends, one that lives leaves its place on the screen."""
        if (line := Line._now) is None:
            return
        if line._until_heard:
            line.__exit__()
        else:
            line._erase()

    def _erase(self) -> None:
        if self._live and (self._told or not self._until_heard):
            self._put("\r\033[K")

    def show(self, text: str) -> None:
        """Replaces what the line says."""
        self._text = text
        if self._live and not self._until_heard:
            self._tell()

    def keep(self, text: str) -> None:
        """Tells something that stays, on a line of its own."""
        line = f"{time.monotonic() - self._start:5.0f} s  {' '.join(text.split())}\n"
        self._put(f"\r\033[K{line}" if self._live else line)

    def _tick(self) -> None:
        wait = 1.0 if self._live and not self._until_heard else min(FIRST_S, TELL_S)
        while not self._done.wait(wait):
            self._tell()
            wait = 1.0 if self._live else TELL_S

    def _tell(self) -> None:
        if self._text:
            self._told = True
            line = f"{time.monotonic() - self._start:5.0f} s  {' '.join(self._text.split())}"
            self._put(f"\r\033[K{line}" if self._live else f"{line}\n")

    def _put(self, text: str) -> None:
        with self._lock, suppress(OSError, ValueError):  # a reader that went away
            print(text, end="", file=sys.stderr, flush=True)
