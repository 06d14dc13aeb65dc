"""What the other core looks at once a setting rests: better lengths, what parts ask for, fronts, other hardware."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from optimizer.codesign.candidate import first_corrections
from optimizer.codesign.hardware import Selection
from optimizer.codesign.lengths import CONVERGED
from optimizer.studio import background, knobs, model, records
from optimizer.studio.background import Parts
from optimizer.studio.knobs import FRICTION, MASS, Knob
from optimizer.studio.setting import Solved, Task

_SHARES = (0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.4)  # of a limit, at which its front is looked at
_NEAR_SHARES = (0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.15)  # of an outline, which is worth more


class View(Protocol):
    """What is needed of a session; see there."""

    task: Task
    knobs: tuple[Knob, ...]
    hardware: list[Selection]

    @property
    def held(self) -> bool: ...  # noqa: D102
    def compute(self, piece: Any, *arguments: Any) -> Any: ...  # noqa: D102
    def doing(self, text: str) -> None: ...  # noqa: D102
    def tell(self, message: dict[str, Any]) -> None: ...  # noqa: D102
    def corrections(self, task: Task) -> Any: ...  # noqa: D102
    def adopt(self, found: Solved | None, learnt: Parts | None = None) -> None: ...  # noqa: D102
    def passed(self) -> None: ...  # noqa: D102


def look(view: View, found: Solved | None) -> None:
    """Looks at all of it, one piece after the other.

    Raises:
        AbandonedError: The setting changed meanwhile.
    """
    if found is None:
        _relief(view)
        return
    if not view.held:
        view.tell({"type": "parts", "state": "", "text": ""})
    view.doing("looking for better lengths from other starts")
    other = view.compute(background.cold, found.task, found.corrections)
    if other is not None and model.is_better(other, found):
        view.adopt(other)
        return
    if not view.held:
        view.doing("closed forms of the parts")
        view.tell({"type": "parts", "state": "looking", "text": ""})
        learnt: Parts = view.compute(background.parts, found)
        if learnt.lengths_mm is None:
            view.tell({"type": "parts", "state": "refused", "text": learnt.why})
        elif _changes(learnt, found):
            view.tell({"type": "parts", "state": "changed", "text": ""})
            view.adopt(replace(found, lengths_mm=learnt.lengths_mm), learnt)
            return
        else:
            view.passed()
    if view.held:
        view.tell({"type": "parts", "state": "passed", "text": ""})
    _fronts(view, found)
    _hardware(view, found)


def _changes(learnt: Parts, found: Solved) -> bool:
    """Whether parts ask for other hardware, or for lengths that differ by more than these are found to."""
    assert learnt.lengths_mm is not None
    moved = np.abs(np.subtract(learnt.lengths_mm, found.lengths_mm)) / np.maximum(np.abs(found.lengths_mm), 1.0)
    return learnt.choice != found.task.choice or bool(moved.max() > CONVERGED)


def _fronts(view: View, found: Solved) -> None:
    """The largest cube against the limits on mass, friction and outline, about the present ones, nearest first."""
    figures = model.figures_of(found)
    brief = found.brief
    axes: list[tuple[str, str, str, dict[str, float], tuple[float, ...]]] = []
    if brief.outline_mm is not None:
        width, depth = brief.outline_mm
        words = f"outline width, its depth {depth / width:.2f} of it"
        axes.append(("outline", words, "mm", {knobs.WIDTH: width, knobs.DEPTH: depth}, _NEAR_SHARES))
    elif (reach := brief.value("limits.outline_radius_max_mm")) is not None:
        own = {"limits.outline_radius_max_mm": reach}
        axes.append(("outline", "outline width", "mm", own, _NEAR_SHARES))
    for name, words, unit, field in (
        ("effective_mass", "effective mass limit", "kg", MASS),
        ("friction", "friction limit", "N", FRICTION),
    ):
        value = brief.value(field) or figures.get(name, (None, ""))[0]
        if value:
            axes.append((name, words, unit, {field: value}, _SHARES))
    for name, words, unit, own, shares in axes:
        view.doing(f"front: cube against {words}")
        points: list[list[float]] = []
        for share in sorted(shares, key=lambda one: abs(one - 1.0)):
            at = view.compute(background.point, found, {field: value * share for field, value in own.items()})
            if at is not None:
                # of a free outline what the lengths take, else the limit that was set
                x = (
                    at.outline_mm[0]
                    if name == "outline" and brief.outline_mm is None
                    else share * next(iter(own.values()))
                )
                points.append([round(x, 4), round(at.side_mm, 2)])
            here = found.outline_mm[0] if name == "outline" else next(iter(own.values()))
            front = {"type": "front", "name": name, "words": words, "unit": unit, "points": sorted(points)}
            view.tell(front | {"here": [round(here, 4), round(found.side_mm, 2)], "done": len(points) == len(shares)})


def _hardware(view: View, found: Solved) -> None:
    """What each motor and drive comes to, at its best of a few ratios and widths: cube or size, and price.

    The present motor's rows keep what its parts asked for; those of others are estimates before a look at their parts.
    """
    present = found.task.choice
    best = {(present.motor, present.drive): _row(found)}
    for choice in [replace(one, placed=present.placed) for one in view.hardware]:
        view.doing(f"other hardware: {choice.motor} at {choice.ratio:g}:1")
        task = replace(found.task, choice=choice)
        known = found.corrections if task.key == found.task.key else None
        begun = known or first_corrections(task.brief, task.choice)
        at = view.compute(background.cold, task, begun)
        if at is not None:
            row = _row(at) | {"estimated": known is None}
            key = choice.motor, choice.drive
            if key not in best or row["score"] > best[key]["score"]:
                best[key] = row
        view.tell(
            {"type": "hardware", "rows": sorted(best.values(), key=lambda row: -row["score"]), "here": _row(found)}
        )


def _row(at: Solved) -> dict[str, Any]:
    score = at.side_mm if at.size is None else -float(at.size)
    return {
        **records.hardware(at.task.choice),
        "score": round(score, 3),
        "side_mm": round(at.side_mm, 2),
        "outline_mm": [round(one, 1) for one in at.outline_mm],
        "price_EUR": round(model.price_of(at), -1),
    }


def _relief(view: View) -> None:
    """Which limits, each alone, have to give how far for lengths to exist."""
    found: list[dict[str, Any]] = []
    for knob in view.knobs:
        if view.task.brief.value(knob.field) is None:
            continue
        view.doing(f"no lengths: how far would {knob.words} have to give?")
        value = view.compute(background.relief, view.task, knob.field, knob.eases, view.corrections(view.task))
        if value is not None:
            found.append({"field": knob.field, "words": knob.words, "unit": knob.unit, "value": float(f"{value:.3g}")})
            view.tell({"type": "relief", "rows": found})
    view.tell({"type": "relief", "rows": found, "done": True})
