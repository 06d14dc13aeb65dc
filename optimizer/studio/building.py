"""A build from the page: `design` in a process of its own, its progress line by line, and what it ends with."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from threading import Thread
from time import monotonic
from typing import Any

from delta_cad.common.console import BAD_INPUT, DONE
from delta_cad.common.files import write_whole

KEPT = 12  # lines of what was found that a page shows
_KILL_S = 5.0  # from Ctrl-C until the process is killed
_STEP = "step", "of", "name", "done", "total", "best", "left_s"  # of an event of progress
DOWNLOADS = {
    "report.html": "report",
    "assembly.step": "STEP",
    "quotation.zip": "quotation",
    "bom.csv": "parts list",
    "drawings/assembly.pdf": "assembly drawing",
    "manual/manual.html": "manual",
    "design.json": "design file",
}
"""File of a machine's folder -> what the page calls it."""


@dataclass
class Progress:
    """Where a build is.

    Attributes:
        state: "idle", "running", "stopping", "built", "infeasible", "not found in time", "stopped" or "failed".
        began: When it began, s of the monotonic clock.
        ended: When it ended; None while it runs.
        now: What is being done.
        at: Step of the work, as `design --progress json` states it; {} before the first.
        verdict: The search's, as soon as it is known; "" before.
        lines: What was found and said, the last ones.
        facts: What `design --json` printed; {} before its end.
        error: What is wrong where it failed.
    """

    state: str = "idle"
    began: float = 0.0
    ended: float | None = None
    now: str = ""
    at: dict[str, Any] = field(default_factory=dict)
    verdict: str = ""
    lines: deque[str] = field(default_factory=lambda: deque(maxlen=KEPT))
    facts: dict[str, Any] = field(default_factory=dict)
    error: str = ""

    def record(self) -> dict[str, Any]:
        """The progress as JSON types."""
        took = (monotonic() if self.ended is None else self.ended) - self.began if self.began else 0.0
        facts = {key: self.facts[key] for key in _SHOWN if key in self.facts}
        return {
            "state": self.state,
            "took_s": round(took, 1),
            "now": self.now,
            "at": self.at,
            "verdict": self.verdict,
            "lines": list(self.lines),
            "facts": facts,
            "error": self.error,
        }

    def hear(self, line: str) -> None:
        """Takes a line of `design --progress json`; one that is no event comes from a library."""
        event: Mapping[str, Any] = {"text": line.strip()}
        with suppress(ValueError):
            event = found if isinstance(found := json.loads(line), dict) else event
        self.at = {key: event[key] for key in _STEP if key in event} or self.at
        text = event.get("text", "")
        if event.get("event") == "verdict":
            self.verdict = text
        elif text and text != self.verdict:  # which a message repeats
            self.lines.append(text)
        self.now = event.get("doing") or text or self.now


_SHOWN = "cube_side_mm", "motor", "ratio"


class Build:
    """One `design` at a time.

    Args:
        out: Folder of the folders of machines.
        said: Called after each change of `progress`.
        ended: Called with the folder of the machine that passes, when one stands.
    """

    def __init__(self, out: Path, said: Callable[[], object], ended: Callable[[Path], object]) -> None:
        self.out, self._said, self._ended = out, said, ended
        self.progress = Progress()
        self._process: subprocess.Popen[str] | None = None
        self._threads: list[Thread] = []
        self._journal = out
        self._cut = ""  # text of the requirements of a run that did not come to its end

    @property
    def running(self) -> bool:
        """Whether one goes on."""
        return self.progress.state in ("running", "stopping")

    def begin(self, text: str, name: str, own_parts: Path | None) -> None:
        """Starts `design`; goes on with the last one where it was cut short and nothing changed since.

        Args:
            text: The requirements file.
            name: Of the design.
            own_parts: Folder of own parts, if there is one.

        Raises:
            OSError: The requirements file cannot be written.
        """
        assert not self.running
        file, self._journal = self.out / f"{name}.studio.toml", self.out / f"{name}.design.jsonl"
        write_whole(file, text)
        command = [sys.executable, "-m", "optimizer", "design", str(file), "--out", str(self.out)]
        command += ["--json", "--progress", "json"]
        command += [] if own_parts is None else ["--catalogue", str(own_parts)]
        command += ["--resume"] if self._cut == text else []
        self._cut = text
        self.progress = Progress("running", monotonic(), now="starting design")
        environment = os.environ | {"PYTHONUNBUFFERED": "1"}
        pipe = subprocess.PIPE
        # a session of its own: Ctrl-C comes to it from here alone
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, text=True, errors="replace", env=environment,
            start_new_session=True,
        )  # fmt: skip
        self._process = process
        out: list[str] = []
        reading = Thread(target=lambda: out.extend(process.stdout or ()), daemon=True)
        watching = Thread(target=self._watch, args=(process, self.progress, reading, out, text), daemon=True)
        self._threads = [reading, watching]
        for thread in self._threads:
            thread.start()
        self._said()

    def _watch(
        self, process: subprocess.Popen[str], progress: Progress, reading: Thread, out: list[str], text: str
    ) -> None:
        for line in process.stderr or ():
            progress.hear(line)
            self._said()
        code = process.wait()
        reading.join()
        for pipe in (process.stdout, process.stderr):
            if pipe is not None:
                pipe.close()
        with suppress(ValueError):
            printed = "".join(out)
            progress.facts = json.loads(printed[printed.index("{") :])
        progress.ended = monotonic()
        # design removes the journal at its own end; it may refuse one of other requirements
        self._cut = text if code != BAD_INPUT and self._journal.is_file() else ""
        folder = progress.facts.get("folder")
        verdict = str(progress.facts.get("verdict", ""))
        if not verdict:
            stopped = progress.state == "stopping"
            progress.error = "" if stopped else progress.now or f"design ended with exit code {code}"
        progress.state = verdict or ("stopped" if progress.state == "stopping" else "failed")
        if code == DONE and folder:
            self._ended(Path(folder))
        self._said()

    def stop(self) -> None:
        """Interrupts it, as Ctrl-C does: what stands is whole, and the next begin goes on where it was."""
        if self.running and self._process is not None:
            self.progress.state = "stopping"
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGINT)
            self._said()

    def close(self) -> None:
        """Ends it and waits: by an interrupt, and by force where that does not end it."""
        if self._process is None:
            return
        self.stop()
        try:
            self._process.wait(_KILL_S)
        except subprocess.TimeoutExpired:
            with suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        for thread in self._threads:
            thread.join(_KILL_S)


def downloads(folder: Path) -> list[dict[str, Any]]:
    """Lists the files of a machine that the page offers: name, words, size in bytes."""
    found = ((folder / name, name, words) for name, words in DOWNLOADS.items())
    return [
        {"name": name, "words": words, "bytes": path.stat().st_size} for path, name, words in found if path.is_file()
    ]
