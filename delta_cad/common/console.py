"""The common part of all commands: exit codes, one-line errors, Ctrl-C, a line of progress; loads nothing heavy."""

from __future__ import annotations

import json
import math
import os
import re
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
TELL_S = 10.0  # s between two lines of progress there, as in a log


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
        if not ProgressLine.event("message", text=printable(message)):
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


class Step(str):
    """What is being done, in words, and its place in the whole work; plain words that follow belong to the same step.

    Args:
        words: What is being done.
        name: Of the step.
        number: Which step it is, from 1.
        of: How many there are.
        done: How much of the step is done, in units of its own.
        total: How many units it has; 0: not known.
        best: The best result so far; "": none.
    """

    name: str
    number: int
    of: int
    done: int
    total: int
    best: str

    def __new__(
        cls, words: str, name: str, number: int, of: int, done: int = 0, total: int = 0, best: str = ""
    ) -> Step:
        """Makes it."""
        step = super().__new__(cls, words)
        step.name, step.number, step.of, step.done, step.total, step.best = name, number, of, done, total, best
        return step


class TimeLeft:
    """Time left, from the moments at which the last run of the same work on this machine began the same things.

    Without such a run, or beyond its time, from the units of a step that are done; else there is no estimate.

    Args:
        work: Name under which the moments are kept; "": nothing is kept.
    """

    def __init__(self, work: str) -> None:
        self._work, self._moments = work, dict[str, float]()
        self._last: dict[str, float] = {}
        with suppress(OSError, ValueError, AttributeError, LookupError, TypeError):
            kept = json.loads(_durations().read_text(encoding="utf-8"))[work] if work else {}
            self._last = {str(name): float(at) for name, at in kept.items()} if _END in kept else {}
        self._at: tuple[float, float] | None = None  # a moment of this run, and the last one's time left then
        self._units: tuple[str, float, int, int] = "", 0.0, 0, 0  # a step, when it began, units done and all

    def begins(self, what: str, now_s: float) -> None:
        """Notes that something begins for the first time in this run, s after its start."""
        if what in self._moments or _NUMBER.search(what):  # which the next run hardly has again
            return
        self._moments[what] = now_s
        if (then := self._last.get(what)) is not None:
            total, pace = self._last[_END], 1.0  # pace: of this run to that one
            if then > max(0.0, _SHARE * total):
                pace = min(max(now_s / then, 1 / _PACE), _PACE)
            self._at = now_s, pace * (total - then)

    def counts(self, step: str, done: int, total: int, now_s: float) -> None:
        """Notes how many units of a step are done, s after the run's start."""
        of, begun, *_ = self._units
        self._units = step, begun if of == step else now_s, done, total

    def left_s(self, now_s: float) -> float | None:
        """Estimates the time left of the whole work, s; None where nothing measured says it."""
        if self._at is not None and (left := self._at[0] + self._at[1] - now_s) > 0.0:
            return left
        return None

    def step_left_s(self, now_s: float) -> float | None:
        """Estimates the time left of the step, s, from its units; None before one is done."""
        _, begun, done, total = self._units
        return (now_s - begun) * (total - done) / done if 0 < done < total else None

    def forget(self) -> None:
        """Keeps nothing of this run: it was cut short, or continues another."""
        self._work = ""

    def keep(self, now_s: float) -> None:
        """Keeps the moments of a run that has ended; nothing where that cannot be."""
        if not self._work or not self._moments:
            return
        with suppress(OSError, ValueError, TypeError):
            place = _durations()
            place.parent.mkdir(parents=True, exist_ok=True)
            kept = json.loads(place.read_text(encoding="utf-8")) if place.exists() else {}
            kept.pop(self._work, None)
            kept[self._work] = {name: round(at, 2) for name, at in (self._moments | {_END: now_s}).items()}
            kept = dict(list(kept.items())[-_WORKS:])
            part = place.with_name(f".{place.name}.{os.getpid()}")
            part.write_text(json.dumps(kept), encoding="utf-8")
            part.replace(place)


_NUMBER = re.compile(r"\d")
_WORKS = 20  # whose moments are kept, the last ones
_END = ""  # name of a run's end among its moments
_SHARE, _PACE = 0.2, 4.0  # share of a run from which on its pace is measured, and by how much paces may differ


def _durations() -> Path:
    """File of the moments, beside the compiled code that is kept."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "delta-haptics" / "durations.json"


def _rounded(seconds: float) -> str:
    """Formats an estimated time: in steps of 5 s, from 90 s on in minutes."""
    return f"{max(5, 5 * round(seconds / 5))} s" if seconds < 90.0 else f"{round(seconds / 60)} min"


_BAR = 16  # characters of a bar


class ProgressLine:
    """What a long work is doing, on stderr: one line that lives on a terminal that can, elsewhere one each `TELL_S`.

    The first comes there after `FIRST_S`. Each starts with the seconds since the work began, and is told by a thread of
    its own, so that it also comes while one call takes long. With `--progress json` each event is a JSON object
    instead: `event` ("progress", "found", "message", "verdict", "end"), `s` since the work began, `doing`, of a work in
    steps `step`, `of`, `name`, `done`, `total`, `best`, and `left_s` where something measured says it.

    Args:
        until_heard: It only bridges the time until something else is said, by another line or as the command's answer.
        work: Name of the work, whose moments are kept for the estimate of the next one's time left; "": none.

    Attributes:
        as_json: Whether events are written as JSON.
        left: The estimate of the time left.
    """

    as_json: ClassVar[bool] = False
    _now: ClassVar[ProgressLine | None] = None
    _printed_s: ClassVar[float] = -math.inf  # when a line was last written to a pipe or file

    def __init__(self, until_heard: bool = False, work: str = "") -> None:
        self._until_heard, self._reported = until_heard, False
        self._live = sys.stderr.isatty() and os.environ.get("TERM") != "dumb"  # which erases no line
        self._text, self._found, self._start = "", "", time.monotonic()
        self._step: Step | None = None
        self.left, self._event_s = TimeLeft(work), -math.inf
        self._done, self._lock = threading.Event(), threading.Lock()
        self._clock = threading.Thread(target=self._tick, daemon=True)

    def __enter__(self) -> ProgressLine:
        ProgressLine.give_way()
        ProgressLine._now = self
        self._clock.start()
        return self

    def __exit__(self, kind: object = None, *_: object) -> None:
        if ProgressLine._now is self:
            ProgressLine._now = None
        if not self._done.is_set():
            self._done.set()
            if self._clock.is_alive():  # Ctrl-C may come before it has begun
                self._clock.join()
            self._erase()
            if kind is None:
                self.left.keep(self._seconds())

    @staticmethod
    def give_way() -> None:
        """Lets something else be said: a line that bridges ends, one that lives leaves its place on the screen."""
        if (line := ProgressLine._now) is None:
            return
        if line._until_heard:
            line.__exit__()
        else:
            line._erase()

    @staticmethod
    def event(kind: str, **facts: Any) -> bool:
        """Writes an event where events are written as JSON; returns whether they are."""
        if ProgressLine.as_json:
            with suppress(OSError, ValueError):
                print(json.dumps({"event": kind} | facts), file=sys.stderr, flush=True)
        return ProgressLine.as_json

    def _erase(self) -> None:
        if self._live and not self.as_json and (self._reported or not self._until_heard):
            self._put("\r\033[K")

    def _seconds(self) -> float:
        return time.monotonic() - self._start

    def show(self, text: str) -> None:
        """Replaces what the line says; a `Step` also says where in the work that is."""
        self._text, now = text, self._seconds()
        if isinstance(text, Step):
            self._step = text
            self.left.begins(text.name, now)
            self.left.counts(text.name, text.done, text.total, now)
        self.left.begins(str(text), now)
        if self.as_json:
            if now - self._event_s >= _EVENT_S or isinstance(text, Step):
                self._event_s = now
                self._send("progress", doing=text)
        elif self._live and not self._until_heard:
            self._tell()

    def keep(self, text: str) -> None:
        """Reports something that was found: on a terminal on a line that stays, elsewhere the newest with the next."""
        if self.as_json:
            self._send("found", text=text)
        elif self._live:
            self._put(f"\r\033[K{self._seconds():5.0f} s  {' '.join(text.split())}\n")
        else:
            self._found = text

    def _send(self, kind: str, **facts: Any) -> None:
        now, step = self._seconds(), self._step
        if step is not None:
            facts |= {name: getattr(step, name) for name in ("name", "of", "done", "total", "best")}
            facts["step"] = step.number
        if (left := self.left.left_s(now)) is not None:
            facts["left_s"] = round(left, 1)
        with self._lock:
            self.event(kind, s=round(now, 2), **facts)

    def _tick(self) -> None:
        while not self._done.wait(self._pause_s()):
            self._tell()

    def _pause_s(self) -> float:
        """Time until the line is written again, s."""
        if self._live and not self._until_heard:
            return 1.0
        since = time.monotonic() - ProgressLine._printed_s
        return 1.0 if self._live and self._reported else max(min(FIRST_S, TELL_S), TELL_S - since)

    def _tell(self) -> None:
        if (self._text or self._step) and not self.as_json:
            self._reported, now = True, self._seconds()
            line = f"{now:5.0f} s  {' '.join(self._words(now).split())}"
            self._found = ""
            if self._live:
                self._put(f"\r\033[K{_fitting(line)}")
            else:
                ProgressLine._printed_s = time.monotonic()
                self._put(f"{line}\n")

    def _words(self, now: float) -> str:
        """Step, bar, time left, best so far and what is being done, or was found since the last line."""
        step, parts = self._step, list[str]()
        if step is not None:
            at = f"step {step.number} of {step.of}, {step.name}"
            left = self.left.left_s(now)
            share = step.done / step.total if step.total else None if left is None else now / (now + left)
            if share is not None and self._live:
                filled = int(_BAR * share)
                at += f" [{'#' * filled}{'-' * (_BAR - filled)}]"
            parts.append(f"{at} {step.done} of {step.total}" if step.total else at)
        if (left := self.left.left_s(now)) is not None:
            parts.append(f"about {_rounded(left)} left")
        elif (left := self.left.step_left_s(now)) is not None:
            parts.append(f"about {_rounded(left)} left of this step")
        if step is not None and step.best:
            parts.append(f"best so far {step.best}")
        return "; ".join(filter(None, [*parts, self._found or self._text]))

    def _put(self, text: str) -> None:
        with self._lock, suppress(OSError, ValueError):  # a reader that went away
            print(text, end="", file=sys.stderr, flush=True)


_EVENT_S = 0.1  # s between two events of one step


def _fitting(line: str) -> str:
    """A line without what the terminal has no room for: it would go on in a second one, which is not erased."""
    with suppress(OSError, ValueError):
        columns = os.get_terminal_size(sys.stderr.fileno()).columns  # 0: unknown
        return line if not columns or len(line) < columns else f"{line[: max(0, columns - 4)]}..."
    return line
