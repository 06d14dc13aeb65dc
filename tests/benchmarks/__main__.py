"""`python -m tests.benchmarks`: measures, shows its progress, writes `out/bench.md` and `out/bench.json`."""

from __future__ import annotations

import json
import sys
from importlib import import_module
from importlib.util import find_spec
from time import perf_counter

from tests.benchmarks.figure import Figure
from tests.benchmarks.machine import machine
from tests.benchmarks.page import page, record
from tests.benchmarks.timing import ROOT

SUBJECTS = (
    "start_time",
    "delta_cad.mechanism_time",
    "delta_cad.build_time",
    "delta_cad.clearance_sweep",
    "delta_cad.clearance_growth",
    "delta_cad.kernel",
    "optimizer.certificates",
    "optimizer.synthesis",
    "optimizer.proven",
    "optimizer.seeds",
    "optimizer.atlas",
    "optimizer.front",
    "haptics.wall",
    "haptics.simulation",
    "haptics.firmware",
)


def _subject(name: str) -> str:
    """A module as its subject is told."""
    return name.rsplit(".", 1)[-1].replace("_", " ")


def main() -> int:
    """Measures every subject; a target that is missed is told, a subject that could not be measured is exit code 1."""
    before, start = machine(), perf_counter()

    def say(text: str) -> None:
        print(f"{perf_counter() - start:6.1f} s  {text}", file=sys.stderr, flush=True)

    figures: list[Figure] = []
    subjects = [name for name in SUBJECTS if find_spec(f"tests.benchmarks.{name}")]
    failed: list[str] = []
    for name in set(SUBJECTS) - set(subjects):
        failed.append(f"{_subject(name)}: there is no such benchmark")
    for number, name in enumerate(subjects, 1):
        say(f"[{number}/{len(subjects)}] {_subject(name)}")
        try:
            found = import_module(f"tests.benchmarks.{name}").run(lambda text: say(f"      {text}"))
        except RuntimeError as error:
            failed.append(f"{_subject(name)}: {error}")
            say(f"      not measured: {error}")
            continue
        for f in found:
            say(f"      {f.name}: {f.value:.4g} {f.unit}")
        figures += found
    after, seconds = machine(), perf_counter() - start
    out = ROOT / "out"
    out.mkdir(exist_ok=True)
    text = page(figures, failed, before, after, seconds)
    (out / "bench.md").write_text(text, encoding="utf-8")
    (out / "bench.json").write_text(
        json.dumps(record(figures, failed, before, after, seconds), indent=1) + "\n", encoding="utf-8"
    )
    print(text)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
