"""`python -m tests.benchmarks [SUBJECT ...]`: measures subjects, shows its progress, writes a page.

Without a word it measures all but the long ones and writes `out/bench.md` and `out/bench.json`; `long` measures those
and writes `out/bench-long.*`; subjects that are named go into `out/bench-some.*`.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter

from delta_cad.common.options import CACHE_OFF
from tests.benchmarks.figure import Figure
from tests.benchmarks.machine import machine
from tests.benchmarks.page import page, record
from tests.benchmarks.subject import NotMeasuredError, measure
from tests.benchmarks.timing import ROOT

MINUTES = {
    "start_time": 5.0,
    "delta_cad.mechanism_time": 5.0,
    "delta_cad.build_time": 10.0,
    "delta_cad.drawing_time": 5.0,
    "delta_cad.clearance_sweep": 5.0,
    "delta_cad.clearance_growth": 10.0,
    "optimizer.certificates": 10.0,
    "optimizer.synthesis": 15.0,
    "optimizer.proven": 15.0,
    "optimizer.seeds": 30.0,
    "optimizer.atlas": 10.0,
    "optimizer.front": 15.0,
    "optimizer.studio": 10.0,
    "haptics.wall": 10.0,
    "haptics.simulation": 10.0,
    "haptics.firmware": 10.0,
}
"""Subjects and the time after which each is given up: a multiple of what it takes on a quiet two-core machine."""

LONG = "optimizer.synthesis", "optimizer.proven", "optimizer.seeds"
"""Subjects that compare with peers or over thirty seeds, of five minutes and more."""


def chosen(words: Sequence[str]) -> list[str]:
    """The subjects that words name, by full or last name, or "long"; without words all but the long ones.

    Raises:
        SystemExit: A word names none; exit code 2.
    """
    if not words:
        return [name for name in MINUTES if name not in LONG]
    if list(words) == ["long"]:
        return list(LONG)
    by_name = {short: name for name in MINUTES for short in (name, name.rsplit(".", 1)[-1])}
    unknown = [word for word in words if word not in by_name]
    if unknown:
        print(f"no such subject: {', '.join(unknown)}; there are long, {', '.join(MINUTES)}", file=sys.stderr)
        raise SystemExit(2)
    return [by_name[word] for word in words]


def run(modules: Mapping[str, float], out: Path, stem: str) -> int:
    """Measures subjects one after the other and writes their page.

    Args:
        modules: Full module name -> seconds after which it is given up.
        out: Folder of the page, made if it is missing.
        stem: Name of the page without suffix.

    Returns:
        1 if a subject could not be measured, else 0; a target that is missed is told only.
    """
    before, start = machine(), perf_counter()
    figures: list[Figure] = []
    failed: list[str] = []
    for number, (module, limit_s) in enumerate(modules.items(), 1):
        name = module.rsplit(".", 1)[-1].replace("_", " ")
        print(f"{perf_counter() - start:6.1f} s  [{number}/{len(modules)}] {name}", file=sys.stderr, flush=True)
        try:
            figures += measure(module, limit_s)
        except NotMeasuredError as error:
            failed.append(f"{name}: {error}")
            print(f"        not measured: {error}", file=sys.stderr, flush=True)
    result = (figures, failed, before, machine(), perf_counter() - start)
    text = page(*result)
    out.mkdir(exist_ok=True)
    (out / f"{stem}.md").write_text(text, encoding="utf-8")
    (out / f"{stem}.json").write_text(json.dumps(record(*result), indent=1) + "\n", encoding="utf-8")
    print(text)
    return 1 if failed else 0


def main(words: Sequence[str]) -> int:
    """Measures the subjects that words name, or all but the long ones."""
    os.environ[CACHE_OFF] = "1"  # what is computed is measured, not what an earlier run kept
    modules = {f"tests.benchmarks.{name}": 60.0 * MINUTES[name] for name in chosen(words)}
    stem = {(): "bench", ("long",): "bench-long"}.get(tuple(words), "bench-some")
    return run(modules, ROOT / "out", stem)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
