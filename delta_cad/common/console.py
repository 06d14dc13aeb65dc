"""The common part of all commands: exit codes, one-line errors, Ctrl-C, a line of progress; loads nothing heavy."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from importlib.machinery import ExtensionFileLoader
from pathlib import Path
from types import FrameType
from typing import Any, ClassVar, TextIO

from delta_cad.common.refusal import printable

# Exit codes of all commands.
DONE = 0
NOT_MET = 1  # done, but a check or a promise fails
BAD_INPUT = 2
NOT_BUILT = 3  # the geometry could not be built
CUT_SHORT = 4  # a search ended before it knew: its time was over, or it was stopped
INTERRUPTED = 130  # 128 + SIGINT, as shells have it
_LAST_STREAM = 2  # descriptor of standard error, after those of input and output
# s from Ctrl-C until whoever does not look is interrupted, and again after that: together less than the 2 s in which a
# command is to end.
GRACE_S, _AGAIN_S = 1.0, 0.5
_LATER_S = 0.02  # s until it is tried again where it cannot be at once
# What of the interpreter runs while a module in C or C++ begins: tables of its functions and classes are being made.
_BEGINS = (ExtensionFileLoader.create_module.__code__, ExtensionFileLoader.exec_module.__code__)
_HAS_ALARM = hasattr(signal, "setitimer")  # not on Windows
FIRST_S = 0.8  # s until the first line of progress where nobody watches: what ends sooner says nothing
TELL_S = 4.0  # s between two lines of progress there, as in a log


def open_streams() -> None:
    """Opens those of the three streams that the process was started without: what goes to them goes nowhere.

    Their numbers too, or the next file that is opened would get one, and what a library prints would go into it.
    """
    if None not in (sys.stdin, sys.stdout, sys.stderr):
        return
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= _LAST_STREAM:
        pass
    os.close(descriptor)
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115  (as long as the process)


def os_error_text(error: OSError) -> str:
    """Says what the system refused: the path, if it is known, and why."""
    why = error.strerror or str(error) or type(error).__name__
    return why if error.filename is None else f"{os.fsdecode(error.filename)}: {why}"


class StandardOutput:
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
        ProgressLine.give_way()
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


def refuse(message: str, code: int) -> int:
    """Tells what is wrong in one printable line on stderr, if that can be written, and returns the exit code."""
    ProgressLine.give_way()
    try:
        print(printable(message), file=sys.stderr, flush=True)
    except OSError:
        _to_nowhere(sys.stderr)
    return code


def print_result(given: Any, facts: Mapping[str, Any], tell: Callable[[], None]) -> None:
    """Prints what a command found: with `--json` its facts as JSON, else what a person reads.

    Args:
        given: What was typed.
        facts: The facts, as JSON types.
        tell: Prints them for a person.
    """
    if given.json:
        print(json.dumps(facts, indent=1))
    else:
        tell()


def refuse_folder(out: Path, error: OSError) -> int:
    """Tells that a folder of results cannot be written, or replaced, and returns the exit code.

    Args:
        out: As it was typed.
        error: What the system, or `common.ours`, says of it or of a place below it.
    """
    from delta_cad.common.files import ForeignFilesError

    at = "" if error.filename in (None, str(out)) else f"{error.filename}: "
    more = "" if isinstance(error, ForeignFilesError) else "; must be a folder that can be written"
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
        self._required = False
        self._before: dict[int, Any] = {}
        self._hook = sys.unraisablehook

    def __enter__(self) -> Callable[[], bool]:
        self._hook, sys.unraisablehook = sys.unraisablehook, self._lost
        handlers: dict[int, Any] = {signal.SIGINT: self._take, signal.SIGTERM: self._take}
        if _HAS_ALARM:
            handlers[signal.SIGALRM] = _interrupt
        self._before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
        return lambda: self._required

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        _come_again(0.0)
        for number, handler in self._before.items():
            signal.signal(number, handler)
        sys.unraisablehook = self._hook
        if self._required and isinstance(error, Exception):
            raise KeyboardInterrupt from error

    def _lost(self, found: sys.UnraisableHookArgs) -> None:
        if not isinstance(found.exc_value, KeyboardInterrupt):
            self._hook(found)

    def _take(self, number: int, frame: FrameType | None) -> None:
        first, self._required, Interrupt.heard = not self._required, True, True
        _come_again(GRACE_S)
        if not (first and self.GRACE):
            _interrupt(number, frame)


class Request(Interrupt):
    """The same, but the first Ctrl-C only asks: who looks within `GRACE_S` ends by itself with what it has."""

    GRACE = True


def _come_again(after_s: float) -> None:
    """Has the interrupt come after a time, and again after that; 0: no more. Without SIGALRM a thread sends SIGINT."""
    if _HAS_ALARM:
        signal.setitimer(signal.ITIMER_REAL, after_s, _AGAIN_S if after_s else 0.0)
        return
    while _timers:
        _timers.pop().cancel()
    if after_s:
        _timers.append(timer := threading.Timer(after_s, signal.raise_signal, [signal.SIGINT]))
        timer.daemon = True
        timer.start()


_timers: list[threading.Timer] = []
"""The one that is set where the system has no alarm."""


def _interrupt(_number: int, frame: FrameType | None) -> None:
    """Interrupts, or asks again a little later where a module in C begins."""
    while frame is not None:
        if frame.f_code in _BEGINS:
            _come_again(_LATER_S)
            return
        frame = frame.f_back
    raise KeyboardInterrupt


class ProgressLine:
    """What a long step is doing, on stderr: one line that lives on a terminal that can, elsewhere a line each `TELL_S`.

    The first comes there after `FIRST_S`. Each starts with the seconds since the work began, and is told by a thread of
    its own, so that it also comes while one call takes long.

    Args:
        until_heard: It only bridges the time until something else is said, by another line or as the command's answer.
    """

    _now: ClassVar[ProgressLine | None] = None

    def __init__(self, until_heard: bool = False) -> None:
        self._until_heard, self._reported = until_heard, False
        self._live = sys.stderr.isatty() and os.environ.get("TERM") != "dumb"  # which erases no line
        self._text, self._start = "", time.monotonic()
        self._done, self._lock = threading.Event(), threading.Lock()
        self._clock = threading.Thread(target=self._tick, daemon=True)

    def __enter__(self) -> ProgressLine:
        ProgressLine.give_way()
        ProgressLine._now = self
        self._clock.start()
        return self

    def __exit__(self, *_: object) -> None:
        if ProgressLine._now is self:
            ProgressLine._now = None
        if not self._done.is_set():
            self._done.set()
            self._clock.join()
            self._erase()

    @staticmethod
    def give_way() -> None:
        """Lets something else be said: a line that bridges ends, one that lives leaves its place on the screen."""
        if (line := ProgressLine._now) is None:
            return
        if line._until_heard:
            line.__exit__()
        else:
            line._erase()

    def _erase(self) -> None:
        if self._live and (self._reported or not self._until_heard):
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
            self._reported = True
            line = f"{time.monotonic() - self._start:5.0f} s  {' '.join(self._text.split())}"
            self._put(f"\r\033[K{line}" if self._live else f"{line}\n")

    def _put(self, text: str) -> None:
        with self._lock, suppress(OSError, ValueError):  # a reader that went away
            print(text, end="", file=sys.stderr, flush=True)
