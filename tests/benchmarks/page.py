"""The figures as a page and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tests.benchmarks.figure import Figure
from tests.benchmarks.later import ELSEWHERE, LATER

VERDICTS = {True: "yes", False: "**no**", None: "-"}


def page(
    figures: Sequence[Figure], failed: Sequence[str], before: dict[str, Any], after: dict[str, Any], seconds: float
) -> str:
    """Markdown of all figures.

    Args:
        figures: What was measured.
        failed: What could not be measured and why.
        before: The machine when it began.
        after: The machine when it ended.
        seconds: How long it took.
    """
    load = ", ".join(f"{value:g}" for value in before["load"])
    load_after = ", ".join(f"{value:g}" for value in after["load"])
    held = [f for f in figures if f.reached is not None]
    versions = ", ".join(f"{name} {number}" for name, number in before["versions"].items() if number)
    lines = [
        "# What it costs",
        "",
        f"{before['cpu_model']}, {before['cores']} cores; load {load} at the start, {load_after} at the end; "
        f"{seconds:.0f} s. Python {before['python']}, {versions}.",
        "",
        f"{sum(bool(f.reached) for f in held)} of {len(held)} figures with a target reach it. Ratios are formed inside "
        "one run, round by round; others are medians with least and largest. A log-log slope of 1: cost in proportion.",
    ]
    lines += [f"\n**Not measured: {text}**" for text in failed]
    for subject in dict.fromkeys(f.subject for f in figures):
        lines += ["", f"## {subject[:1].upper()}{subject[1:]}", ""]
        lines += ["| what | figure | least to largest | to reach | reached | how |", "|---|---:|---|---|---|---|"]
        lines += [_row(f) for f in figures if f.subject == subject]
    lines += [
        "",
        "## Not measured yet: belongs to what is still to come",
        "",
        "| with | what | to reach |",
        "|---|---|---|",
    ]
    lines += [f"| {' | '.join(entry)} |" for entry in LATER]
    lines += [
        "",
        "Measured elsewhere: " + "; ".join(f"{what}, {target} ({how})" for what, target, how in ELSEWHERE) + ".",
    ]
    return "\n".join(lines) + "\n"


def record(
    figures: Sequence[Figure], failed: Sequence[str], before: dict[str, Any], after: dict[str, Any], seconds: float
) -> dict[str, Any]:
    """The same as JSON types; arguments as `page`."""
    return {
        "schema": "delta-bench/1",
        "machine": before,
        "load_after": after["load"],
        "duration_s": round(seconds, 1),
        "figures": [f.to_json() for f in figures],
        "failed": list(failed),
        "not_measured_yet": [dict(zip(("with", "what", "target"), entry, strict=True)) for entry in LATER],
    }


def _row(f: Figure) -> str:
    """A row of the table."""
    target = "-" if f.target is None else f"{'<=' if f.at_most else '>='} {_number(f.target)} {f.unit}".strip()
    spread = "-" if f.spread is None else f"{_number(f.spread[0])} to {_number(f.spread[1])}"
    value = f"{_number(f.value)} {f.unit}".strip()
    return f"| {f.name} | {value} | {spread} | {target} | {VERDICTS[f.reached]} | {f.note} |"


def _number(value: float) -> str:
    """Three digits that count, thousands apart."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
