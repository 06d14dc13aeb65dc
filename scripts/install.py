"""Makes a virtual environment with extras of this package, and says what it does every few seconds.

    python3 scripts/install.py .venv cad,optimize

Runs with any Python 3.11 or newer and nothing installed. What pip itself tells is shown only where it fails.
"""

from __future__ import annotations

import re
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OLDEST = (3, 11)
TELL_S = 3.0  # s between two signs of life
KEPT = 40  # last lines of a step that fails
BLOCK = re.compile(r"^# (.*)\n((?:[^#\n].*\n)+)", re.MULTILINE)
"""In constraints.txt: the extras that need a pin, and the pin with its hashes."""
SAID = re.compile(r"^\s*(Collecting|Downloading|Using cached|Building wheel for|Installing build) ?(\S*)")
ALL = re.compile(r"^Installing collected packages: (.*)")


def nothing(_: deque[str]) -> str:
    """Adds nothing to what a step is called."""
    return ""


def run(what: str, command: Sequence[str], more: Callable[[deque[str]], str] = nothing, tell_s: float = TELL_S) -> int:
    """Runs one step, tells what it is at once and every `tell_s` s how far it is.

    Args:
        what: What the step does.
        command: Its words.
        more: How far it is, from the lines that it wrote; "" for nothing to add.
        tell_s: s between two signs of life.

    Returns:
        The exit code; of a step that fails the last lines went to stderr.
    """
    begun, done = time.monotonic(), threading.Event()
    lines: deque[str] = deque(maxlen=10_000)

    def tell() -> None:
        while not done.wait(tell_s):
            at = more(lines)
            print(f"{time.monotonic() - begun:5.0f} s  {what}{': ' if at else ''}{at}", flush=True)

    print(f"{0:5.0f} s  {what}", flush=True)
    clock = threading.Thread(target=tell, daemon=True)
    clock.start()
    try:
        with subprocess.Popen(
            command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace"
        ) as step:
            assert step.stdout is not None
            lines.extend(line.rstrip() for line in step.stdout)
    except KeyboardInterrupt:
        print("interrupted; run again to go on", file=sys.stderr)
        return 130
    finally:
        done.set()
        clock.join()
    if step.returncode:
        print(*list(lines)[-KEPT:], f"{what}: failed with exit code {step.returncode}", sep="\n", file=sys.stderr)
    return step.returncode


def pip_at(lines: Sequence[str], folder: Path) -> str:
    """Says how far pip is, from what it wrote so far and what stands in the environment.

    Args:
        lines: What it wrote.
        folder: Where packages are put.
    """
    for line in reversed(list(lines)):
        if found := ALL.match(line):
            names = found[1].split(", ")
            there = len(list(folder.glob("*.dist-info"))) if folder.is_dir() else 0
            return f"unpacking {len(names)} packages, {there} are there"
        if found := SAID.match(line):
            return f"{found[1].lower()} {found[2].rsplit('/', 1)[-1]}".strip()
    return ""


def needed(constraints: str, extras: Collection[str]) -> str:
    """Chooses pins and their hashes.

    Args:
        constraints: Text of constraints.txt.
        extras: Of pyproject.toml; those of the package itself and of its build come with any.

    Returns:
        Text of a requirements file.

    Raises:
        KeyError: No pin names an extra.
    """
    blocks = [(set(users.split(", ")), pin) for users, pin in BLOCK.findall(constraints)]
    for extra in extras:
        if not any(extra in users for users, _ in blocks):
            raise KeyError(extra)
    wanted = {"core", "build", *extras}
    return "".join(pin for users, pin in blocks if users & wanted)


def main(words: Sequence[str]) -> int:
    """Installs; returns the exit code."""
    if len(words) != 2:
        print("usage: python3 scripts/install.py FOLDER EXTRA,EXTRA,...", file=sys.stderr)
        return 2
    if sys.version_info < OLDEST:
        print(f"Python 3.11 or newer is needed, not {sys.version.split()[0]}", file=sys.stderr)
        return 2
    place, extras = (ROOT / words[0]).resolve(), words[1].split(",")
    try:
        pins = needed((ROOT / "constraints.txt").read_text(encoding="utf-8"), extras)
    except KeyError as error:
        print(f"{error.args[0]} is no extra of pyproject.toml", file=sys.stderr)
        return 2
    python = place / "bin" / "python"
    tested = ["tests"] if "test" in extras else []
    if code := run("system libraries", ["sh", "scripts/system_libraries.sh", *tested]):
        return code
    if not python.exists() and (code := run("virtual environment", [sys.executable, "-m", "venv", str(place)])):
        return code
    pip = [str(python), "-m", "pip", "install", "--disable-pip-version-check", "--progress-bar", "off"]
    site = place / "lib" / f"python{sys.version_info[0]}.{sys.version_info[1]}" / "site-packages"
    chosen = place / "requirements.txt"
    chosen.write_text(pins, encoding="utf-8")
    # wheels alone: the hash of a source says nothing of what its build would fetch
    packages = [*pip, "--require-hashes", "--no-deps", "--only-binary", ":all:", "-r", str(chosen)]
    if code := run(f"packages for {words[1]}", packages, lambda lines: pip_at(lines, site)):
        return code
    own = [*pip, "--no-deps", "--no-build-isolation", "--no-index", "-e", "."]
    if code := run("this package", own) or run("versions fit together", [*pip[:3], "check"]):
        return code
    # from a disk that has just been written it takes long, and in a process that can say nothing meanwhile
    return run(
        "first start of the CAD kernel", [str(python), "-c", "import cadquery, numba, scipy.optimize, vtkmodules"]
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
