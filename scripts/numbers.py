"""Every number that the commands print for best.json and the synthesized example, as JSON; and two such files compared.

    python scripts/numbers.py take before.json     # in the folder of a checkout
    python scripts/numbers.py compare before.json after.json

Times, versions, hashes of files that hold times, and folders are left out: what is compared is what was computed.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

CHANGING = re.compile(r"seconds|elapsed|_s$|created|version|sha256|folder|path|python|platform|bytes|command")
"""Keys that may differ between two runs of the same code."""
NUMBER = re.compile(r"(?<![\w.])-?(?:0x)?\d[\w.+-]*")
"""In C: names of functions may change, numbers may not."""
KEPT = re.compile(r"time_constant|_N_s|stale_s|settling|rise|period|delay|requirements_sha256")
"""Keys that look so and are results."""


def command(package: str, *words: str) -> list[str]:
    """The words of one command in this Python."""
    return [sys.executable, "-m", package, *words]


def runs(room: Path) -> Iterator[tuple[str, list[str]]]:
    """Name and words of every command, in an order in which each finds what it reads."""
    out, design = str(room / "out"), ["--design", "best.json"]
    masses = str(room / "out" / "dashboard-joystick" / "mass_properties.json")
    certificate = str(room / "certificate.json")
    yield "inspect", command("delta_cad", "inspect", *design, "--json")
    yield "build", command("delta_cad", "build", *design, "--out", out, "--json")
    for method in ("ga", "sqp", "ga+sqp", "proven"):
        file = str(room / f"{method}.json")
        words = ["examples/synthesized.toml", "--method", method, "--seed", "1", "--out", file, "--json"]
        yield f"synthesize {method}", command("optimizer", "synthesize", *words)
    certify = [*design, "--mass-properties", masses, "--out", certificate, "--json"]
    yield "certify", command("optimizer", "certify", *certify)
    yield "verify", command("optimizer", "verify", certificate, *design, "--mass-properties", masses, "--json")
    yield "front", command("optimizer", "front", "examples/synthesized.toml", "--points", "5", "--out", out, "--json")
    yield "reproduce", command("optimizer", "reproduce", "--out", out, "--json")
    held = ["--mass-properties", masses, "--json"]
    yield "gravity", command("haptics", "gravity", *design, "--at", "10,20,90", *held)
    yield "published", command("haptics", "gravity", "--published", "--json")
    for scene in ("resistance", "home", "wall"):
        yield scene, command("haptics", "simulate", *design, "--scene", scene, "--out", out, *held)
    yield "stiffness", command("haptics", "stiffness", *design, "--out", out, *held)
    yield "feel", command("haptics", "feel", *design, "--out", out, *held)
    yield "firmware", command("haptics", "firmware", *design, "--out", str(room / "firmware"), *held)


def plain(value: Any, key: str = "") -> Any:
    """A result without what may differ between two runs."""
    if isinstance(value, dict):
        return {k: plain(v, k) for k, v in value.items() if KEPT.search(k) or not CHANGING.search(k)}
    if isinstance(value, list):
        return [plain(v, key) for v in value]
    return value


def take(target: Path) -> None:
    """Runs every command and writes its numbers."""
    found: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as name:
        room = Path(name)
        for label, words in runs(room):
            run = subprocess.run(words, capture_output=True, text=True)
            said = run.stdout.replace(name, "ROOM")
            found[label] = {"exit": run.returncode, "json": plain(json.loads(said)) if said.strip() else run.stderr}
            print(label, run.returncode, flush=True)
        built = room / "out" / "dashboard-joystick"
        for file in ("checks.json", "mass_properties.json", "bom.json"):
            found[file] = plain(json.loads((built / file).read_text()))
        for file in ("holes.csv", "twin.xml"):
            found[file] = (built / file).read_text().splitlines()
        found["step"] = json.loads((built / "manifest.json").read_text()).get("step_fingerprint")
        for file in sorted((room / "firmware").rglob("*.[ch]")):
            found[f"firmware {file.name}"] = NUMBER.findall(file.read_text())
        for method in ("ga", "sqp", "ga+sqp", "proven"):
            if (room / f"{method}.json").exists():  # a run that ends without a design leaves none
                found[f"{method}.json"] = plain(json.loads((room / f"{method}.json").read_text()))
    target.write_text(json.dumps(found, indent=1, sort_keys=True) + "\n")


def differences(a: Any, b: Any, path: str = "") -> Iterator[str]:
    """Every place at which two results differ."""
    if isinstance(a, dict) and isinstance(b, dict):
        for key in sorted(a.keys() | b.keys()):
            if key not in a or key not in b:
                yield f"{path}/{key}: only {'after' if key in b else 'before'}"
            else:
                yield from differences(a[key], b[key], f"{path}/{key}")
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for k, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from differences(x, y, f"{path}[{k}]")
    elif a != b:
        yield f"{path}: {str(a)[:120]} -> {str(b)[:120]}"


def main() -> int:
    """Exit code: 0 where nothing differs."""
    if sys.argv[1:2] == ["take"] and len(sys.argv) == 3:
        take(Path(sys.argv[2]))
        return 0
    if sys.argv[1:2] == ["compare"] and len(sys.argv) == 4:
        before, after = (json.loads(Path(name).read_text()) for name in sys.argv[2:])
        found = list(differences(before, after))
        print("\n".join(found) or "no number differs")
        return 1 if found else 0
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
