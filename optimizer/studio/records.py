"""What the studio sends to its page, as JSON types."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import datetime
from math import floor, log10
from pathlib import Path
from typing import Any

from optimizer.codesign.hardware import Selection, drives, motor_of
from optimizer.codesign.lengths import taken_mm
from optimizer.problem.brief import DesignBrief
from optimizer.studio.body import USUAL, Sizes, body, sizes
from optimizer.studio.building import downloads
from optimizer.studio.knobs import RATIO, STIFFNESS, Knob
from optimizer.studio.model import Proved, figures_of, geometry_of, lengths_of, price_of
from optimizer.studio.sensitivity import WORDS, sensitivity
from optimizer.studio.setting import Setting, Solved

_DATA = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.DOTALL)
_SCENE = ("mechanism", "occurrences", "home_mm", "cube", "outline")
_FIGURES = {
    "kappa": "condition number",
    "effective_mass": "effective mass",
    "friction": "friction",
    "couple_index": "rotational stiffness index",
    "torque": "joint torque",
    "lean": "lean of the rods",
}
_TENTH = 0.1  # of a value, about, in which its price is stated


class Drawer:
    """Draws the body of machines, with the sizes of the last one whose dimensions were derived."""

    def __init__(self) -> None:
        self._sizes: Sizes = USUAL

    def body(self, found: Solved) -> list[dict[str, Any]]:
        """Makes the body of a machine."""
        return body(found, self._sizes)

    def measure(self, found: Solved) -> bool:
        """Derives the sizes of a machine; returns whether they have changed."""
        before, found_sizes = self._sizes, sizes(found)
        self._sizes = found_sizes or before
        return self._sizes != before


def motors(brief: DesignBrief) -> list[dict[str, str]]:
    """Lists motor and drive of all hardware that a task allows."""
    return [
        {"motor": motor, "drive": drive, "words": f"{motor}, {drive}: {motor_of(brief, motor).description}"}
        for motor, drive in drives(brief)
    ]


def hardware(choice: Selection) -> dict[str, Any]:
    """Describes hardware."""
    return {
        "motor": choice.motor,
        "drive": choice.drive,
        "ratio": choice.ratio,
        "width_mm": choice.width_mm,
        "placed": choice.placed,
    }


def answer(
    found: Solved, setting: Setting, drawer: Drawer, state: str, took_s: float, proved: Proved | None = None
) -> dict[str, Any]:
    """Describes lengths: what they come to, what binds, and how the machine looks.

    Args:
        found: The lengths.
        setting: Which they answer.
        drawer: Draws the body.
        state: "about" while sliders move, "proved", or "open" where a limit is not proved.
        took_s: From the setting to here.
        proved: What was proved.
    """
    felt, size = sensitivity(found), found.size
    return {
        "type": "answer",
        "by": list(setting.by),
        "state": state,
        "took_ms": round(1e3 * took_s, 1),
        "side_mm": round(found.side_mm if size is None else found.task.brief.requirements.cube_side_mm or 0.0, 2),
        "size": None if size is None else round(float(size), 4),
        "outline_mm": [round(one, 1) for one in found.outline_mm],
        "lengths": lengths_of(found),
        "price_EUR": round(price_of(found), -1),
        "binding": [{"words": one.words, "gain_mm": round(one.gain_mm, 3)} for one in felt.binding],
        "explained": felt.explained,
        "open": [] if proved is None else [WORDS.get(name, name) for name in proved.open],
        "boxes": None if proved is None else proved.boxes,
        "geometry": geometry_of(found),
        "body": drawer.body(found),
    }


def nothing(setting: Setting, state: str, took_s: float) -> dict[str, Any]:
    """Describes a setting without lengths: "about" where there are none near the last, "none" where none were found."""
    return {"type": "nothing", "by": list(setting.by), "state": state, "took_ms": round(1e3 * took_s, 1)}


def details(found: Solved, setting: Setting, knobs: Sequence[Knob]) -> dict[str, Any]:
    """Describes what a machine measures at its worst, and what each limit costs.

    Prices are what is sought, better for larger values: mm of cube, of outline less, or kg less, for each `step` by
    which the limit is eased; None where the field does not enter, or what it enters is known to the parts alone.
    """
    figures = figures_of(found)
    rows = [(words, *figures[name]) for name, words in _FIGURES.items() if name in figures]
    return {
        "type": "details",
        "by": list(setting.by),
        "figures": [{"words": words, "value": float(f"{value:.4g}"), "unit": unit} for words, value, unit in rows],
        "prices": prices(found, knobs),
    }


def prices(found: Solved, knobs: Sequence[Knob]) -> dict[str, dict[str, Any] | None]:
    """Computes what each limit costs; see `details`."""
    felt = sensitivity(found)
    fields = {one.field: one.eases for one in knobs} | ({RATIO: 1} if found.task.choice.drive == "capstan" else {})
    scale, unit = 1.0, "mm of cube"
    if found.size is not None:
        by_mass = found.task.brief.objective == "effective_mass"
        slope = felt.price("feel.effective_mass_max_kg" if by_mass else "limits.outline_radius_max_mm")
        unit = "kg of mass" if by_mass else "mm of width"
        if not slope:
            return dict.fromkeys(fields)
        scale = (1.0 if by_mass else _width_per_reach(found)) / slope
    priced: dict[str, dict[str, Any] | None] = {}
    for field, eases in fields.items():
        own = found.task.choice.ratio if field == RATIO else found.task.brief.value(field)
        rate = -1.0 if field == "requirements.cube_side_mm" and found.size is not None else felt.price(field)
        if own is None or rate is None or field == STIFFNESS:
            priced[field] = None
            continue
        step = 10.0 ** floor(log10(_TENTH * abs(own)))
        priced[field] = {"step": eases * step, "gain": float(f"{eases * step * float(rate) * scale:.3g}"), "unit": unit}
    return priced


def _width_per_reach(found: Solved) -> float:
    reach = found.lengths_mm[0] + found.lengths_mm[2]
    near, far = (taken_mm(found.task.choice, found.corrections, one)[0] for one in (reach, reach + 1.0))
    return far - near


def solids(folder: Path) -> dict[str, Any] | None:
    """Describes the machine that stands in a folder: how its parts move, when it was built, files to download.

    Returns:
        The description; None where the folder holds no machine with a report.
    """
    with suppress(OSError, ValueError, KeyError):
        found = _DATA.search((folder / "report.html").read_text(encoding="utf-8"))
        if found is None or not (folder / "assembly.glb").is_file():
            return None
        scene: Mapping[str, Any] = json.loads(found[1])
        at = datetime.fromtimestamp((folder / "assembly.glb").stat().st_mtime).astimezone()
        return {
            "scene": {name: scene[name] for name in _SCENE},
            "built": at.strftime("%Y-%m-%d %H:%M"),
            "stamp": int((folder / "assembly.glb").stat().st_mtime_ns),
            "files": downloads(folder),
        }
    return None
