"""The tables of `docs/reference/faults.md`; `python -m tests.haptics.loop.faults.table` writes them."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from haptics.control.supervisor.faults import TABLE, Severity
from haptics.gravity import gravity_torque
from tests.committed import ROOT
from tests.haptics.loop.faults.matrix import CASES, FORCES_N, MOTIONS, Outcome, device, judged, machine

PAGE = ROOT / "docs" / "reference" / "faults.md"
BEGIN, END = "<!-- computed: {} -->", "<!-- end: {} -->"
SECONDS = 1.0  # Looked on after a fault begins


def rows(seconds: float = SECONDS) -> list[str]:
    """The matrix, a row a fault: what sees it, when the force is off, and what follows where it is not."""
    lines = [
        "| fault | detected by | off in | force off, ms | travel, mm | speed, mm/s "
        "| if not off: force, N | travel, mm | energy, mJ |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for case in CASES:
        found = [judged(case, force, motion, seconds) for force in FORCES_N for motion in MOTIONS]
        off = [one for one in found if np.isfinite(one.off)]
        on = [one for one in found if not np.isfinite(one.off)]
        first = sorted({one.codes[0].name for one in found if one.codes})
        cells = [
            case.name,
            ", ".join(first) or "nothing",
            f"{len(off)} of {len(found)}",
            *_most(off, ("off", "travel", "speed"), "{:.2f}", "{:.2f}", "{:.0f}"),
            *_most(on, ("force", "travel", "energy"), "{:.1f}", "{:.1f}", "{:.0f}"),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def _most(found: list[Outcome], fields: tuple[str, ...], *formats: str) -> list[str]:
    """The largest of some figures, in milli of their SI unit but the force; empty cells where there is none."""
    if not found:
        return [""] * len(fields)
    scale = {name: 1.0 if name == "force" else 1e3 for name in fields}
    most = [max(getattr(one, name) for one in found) * scale[name] for name in fields]
    return [text.format(value) for text, value in zip(formats, most, strict=True)]


def reactions() -> list[str]:
    """Each fault of the supervisor: when the scene's force is off, what becomes of the weight and within which time."""
    limits = device()[1].limits
    half = 0.999 * machine().half_side
    grid = np.stack(np.meshgrid(*[np.linspace(-half, half, 7)] * 3), axis=-1).reshape(-1, 3)
    held = gravity_torque(
        machine().geometry, machine().masses, machine().centre + grid, machine().design.requirements.gravity_m_s2
    )
    force = 1e3 * np.ceil(limits.torque / (limits.slew * limits.period)) * limits.period
    gone = f"released within {1e3 * np.abs(held).max() / limits.gravity_slew:.0f} ms"
    weight = {
        "LOWER": f"let down within {limits.lowering:g} s",
        "DAMP": f"let down within {limits.lowering:g} s, the handle damped until then",
        "BRAKE": f"{gone}, the handle damped for {limits.lowering:g} s",
        "OFF": gone,
    }
    lines = ["| fault | finding | force off within, ms | weight |", "|---|---|---:|---|"]
    for code, about in TABLE.items():
        if about.severity is Severity.FAULT:
            row = (f"{int(code)} {code.name}", about.text, f"{force:.2f}", weight[about.reaction.name])
            lines.append("| " + " | ".join(row) + " |")
    return lines


def limits_text() -> list[str]:
    """The limits of readings as the board loop of the committed design has them."""
    known = device()[1].limits
    return [
        "| limit | value |",
        "|---|---:|",
        f"| consecutive readings that one encoder may repeat | {known.repeats:g} ticks |",
        f"| consecutive readings that all three may repeat together | {known.all_repeat:g} ticks |",
        f"| consecutive ticks skipped without a fresh reading | {known.unread:g} |",
        f"| speed gain of a joint in a tick, as an angle per tick | {1e3 * known.kink:.2f} mrad |",
    ]


PARTS = {"limits": limits_text, "reactions": reactions, "matrix": rows}


def with_part(page: str, name: str, lines: list[str]) -> str:
    """A page with a part computed anew."""
    begin, end = BEGIN.format(name), END.format(name)
    before, rest = page.split(begin)
    return before + begin + "\n" + "\n".join(lines) + "\n" + end + rest.split(end)[1]


def computed(page: str, *names: str) -> str:
    """A page with some of its parts computed anew; all unless named."""
    for name in names or PARTS:
        page = with_part(page, name, PARTS[name]())
    return page


def main(place: Path = PAGE) -> int:
    """Writes the page."""
    place.write_text(computed(place.read_text(encoding="utf-8")), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
