"""The page of two machines side by side: both models with one camera and one handle, figures, parts and cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from delta_cad.report.built import MODEL, Build, StaleBuildError
from delta_cad.report.figures import with_unit
from delta_cad.report.page import moving_page

_LEFT_OUT = "slices"  # of a scene
_MOST_DIGITS = 12  # with which two figures that differ are distinguished
_DIGITS = 5


@dataclass(frozen=True)
class Shown:
    """A machine in 3D.

    Attributes:
        scene: As `page.scene`; None where it is not shown.
        model: The GLB file.
        why: Why it is not shown; "" where it is.
    """

    scene: dict[str, Any] | None
    model: bytes
    why: str


def shown(build: Build | None, why: str) -> Shown:
    """Reads the model of a build and what moves it.

    Args:
        build: The build; None where there is none.
        why: Why there is none.
    """
    if build is None:
        return Shown(None, b"", f"not built: {why}")
    try:
        scene, model = build.scene(), build.content(MODEL)
    except StaleBuildError as error:
        return Shown(None, b"", str(error))
    return Shown({key: value for key, value in scene.items() if key != _LEFT_OUT}, model, "")


def pair(row: Mapping[str, Any]) -> tuple[str, str]:
    """Gives both values of a figure as text, with as many digits as tell them apart; a word for None."""
    a, b = row["a"], row["b"]
    nothing = "left out" if row["group"] == "design" else "not built"
    if row["difference"] is None:
        return _text(a, nothing=nothing), _text(b, nothing=nothing)
    digits = next((n for n in range(_DIGITS, _MOST_DIGITS) if a == b or _text(a, n) != _text(b, n)), _MOST_DIGITS)
    return _text(a, digits), _text(b, digits)


def _text(value: Any, digits: int = _DIGITS, nothing: str = "none") -> str:
    return nothing if value is None else value if isinstance(value, str) else with_unit(value, "", digits)


def signed(row: Mapping[str, Any]) -> str:
    """Gives B less A with its sign, and as a share of A; "" where it has no meaning or is 0."""
    difference = row["difference"]
    if not difference:
        return ""
    sign = "+" if difference > 0.0 else ""
    share = f" ({sign}{with_unit(100.0 * difference / abs(row['a']), '%', 2)})" if row["a"] else ""
    return f"{sign}{with_unit(difference, '', 3)}{share}"


def changes(row: Mapping[str, Any]) -> str:
    """States what differs of a part that both machines have."""
    fields = [
        f"{key.replace('_', ' ')} {' -> '.join(_text(value) for value in values)}"
        for key, values in row.items()
        if key not in ("part_number", "shape")
    ]
    return "; ".join(([] if fields or not row["shape"] else ["shape"]) + fields)


def comparison_page(facts: Mapping[str, Any], machines: Sequence[Shown]) -> str:
    """Writes the page, which asks for nothing elsewhere.

    Args:
        facts: As `compare` prints them.
        machines: A and B.
    """
    rows = [*facts["figures"], *facts["same"]]
    order = list(dict.fromkeys(row["group"] for row in rows))
    return moving_page(
        "compare.html",
        "compare.js",
        ("page.css", "compare.css"),
        f"{facts['a']['name']} and {facts['b']['name']}",
        [one.scene for one in machines],
        {f"model-{side}": one.model for side, one in zip("ab", machines, strict=True)},
        facts=facts,
        groups=[(group, [row for row in rows if row["group"] == group]) for group in order],
        differ={(row["group"], row["quantity"]) for row in facts["figures"]},
        pair=pair,
        signed=signed,
        changes=changes,
        shown=machines,
    )
