"""design.html: what `design` tried, what binds and what each limit costs, as a page like report.html beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.checks.range.feel import poor_verdict
from delta_cad.report.page import ASSETS, FILE_NAME, page_policy
from optimizer.codesign.costs import Cost
from optimizer.codesign.figures import FIGURES, binding
from optimizer.codesign.plot import Scale
from optimizer.codesign.search_log import SearchLog, Trial

if TYPE_CHECKING:
    from optimizer.codesign.bound import Bound
    from optimizer.problem.brief import DesignBrief

WIDTH, LEFT, ROW, TOP = 960, 250, 26, 34
STYLE = """
.tried { max-width: none; vertical-align: middle; }
.tried text { font-size: 12px; fill: var(--ink); }
.tried .grid { stroke: var(--line); }
.tried line.proved { stroke: var(--accent); stroke-dasharray: 5 3; }
.tried text.proved { fill: var(--accent); }
.tried .posed { fill: none; stroke: var(--soft); }
.tried .failed { fill: var(--bad); fill-opacity: 0.8; }
.tried .passed { fill: var(--good); stroke: var(--paper); }
#tried table { max-width: 900px; }
meter { width: 12rem; }
"""


def design_page(
    brief: DesignBrief,
    told: dict[str, Any],
    log: SearchLog,
    why: Sequence[str],
    notes: Sequence[str],
    costs: Sequence[Cost],
    bound: Bound | None,
    unit: str,
) -> str:
    """Writes the page.

    Args:
        brief: The requirements.
        told: The facts of the run.
        log: What the search went through, this machine last.
        why: What was learnt of its hardware.
        notes: Of the requirements.
        costs: What each limit costs.
        bound: What is proved of the family; None where it was not sought.
        unit: Of what is sought.
    """
    return rendered(
        "design.html",
        STYLE,
        told=told,
        cards=_cards(told),
        plot=_plot(log.trials, bound, unit),
        stuck=log.no_progress,
        bound=bound,
        binding=binding(brief, told),
        poor=poor_verdict(told["poor"]),
        costs=costs,
        dearest=max((one.gain for one in costs), default=1.0),
        unit=unit,
        why=why,
        notes=notes,
        report=FILE_NAME,
    )


def rendered(template: str, own_style: str, **given: Any) -> str:
    """Fills one of the templates in `pages/` in; the style is that of report.html and what the page adds.

    Args:
        template: Name of the file.
        own_style: What the page adds.
        given: What its fields are filled with.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    style = (ASSETS / "page.css").read_text(encoding="utf-8") + own_style
    tidy = {"trim_blocks": True, "lstrip_blocks": True, "undefined": StrictUndefined}
    environment = Environment(loader=FileSystemLoader(Path(__file__).parent / "pages"), autoescape=True, **tidy)
    return environment.get_template(template).render(**given, policy=page_policy((), style), style=Markup(style))


def _cards(told: dict[str, Any]) -> list[tuple[str, str, str, str]]:
    """The figures that the page begins with: label, value, unit, what stands below."""
    width, depth = told["outline_mm"]
    cards = [
        ("Cube", f"{told['cube_side_mm']:.2f}", "mm", ""),
        ("Drive", f"{told['ratio']:g}", ": 1", told["motor"]),
        ("Swept outline", f"{width:.1f} × {depth:.1f}", "mm", "as built"),
        *(
            (f"{one.words[:1].upper()}{one.words[1:]}", f"{told[one.key]:.3g}", one.unit, "")
            for one in FIGURES
            if one.head and told[one.key] is not None
        ),
    ]
    if told["bound_mm"] is not None:
        cards.insert(1, ("Proved bound", f"{told['bound_mm']:.2f}", "mm", f"{100.0 * told['gap']:.2g} % more"))
    if told["cost_EUR"] is not None:
        cards.append(("Cost of one", f"{told['cost_EUR']:.0f}", "EUR", "by estimate, see cost.json"))
    return cards


def _plot(trials: Sequence[Trial], bound: Bound | None, unit: str) -> dict[str, Any]:
    """Sets out the candidates, a row a motor, those first that come farthest."""
    best: dict[str, float] = {}
    for one in trials:
        name = f"{one.choice.motor} {one.choice.drive}"
        best[name] = max(one.score, best.get(name, -math.inf))
    rows = {name: TOP + ROW * k for k, name in enumerate(sorted(best, key=lambda name: -best[name]))}
    values = [abs(one.score) for one in trials] + ([] if bound is None else [bound.side_mm])
    across = Scale(values, LEFT, WIDTH - 20)
    dots = []
    for one in sorted(trials, key=lambda one: (one.failed is not None, one.failed == ())):  # what passes on top
        kind = "posed" if one.failed is None else "failed" if one.failed else "passed"
        hardware = f"{one.choice.motor} {one.choice.drive}"
        words = f"{hardware} at {one.choice.ratio:g}:1, {one.choice.width_mm:g} mm wide: {abs(one.score):.4g} {unit}"
        words += "" if kind != "failed" else f"; fails {', '.join(one.failed or ())}"
        dots.append(
            {
                "kind": kind,
                "x": across.at(abs(one.score)),
                "y": rows[hardware],
                "r": 3.5 if kind == "posed" else 6,
                "words": words,
            }
        )
    floor = TOP + ROW * len(rows)
    return {
        "unit": unit,
        "width": WIDTH,
        "height": floor + 44,
        "floor": floor,
        "rows": [(y, name) for name, y in rows.items()],
        "ticks": across.ticks(),
        "bound": None if bound is None else across.at(bound.side_mm),
        "dots": dots,
    }
