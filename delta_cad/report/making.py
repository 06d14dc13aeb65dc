"""Tables of the page about making: what the machine costs, and what its tolerances do, from the files beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from delta_cad.common.reading import read_json
from delta_cad.report.figures import with_unit

COST, TOLERANCES = "cost.json", "tolerances.json"
DECIDES = {"worst": "worst case", "rss": "statistically"}
DEAREST = 10  # lines that are told, of what is made and bought together


def cost(folder: Path) -> dict[str, Any] | None:
    """Gives the sums and the dearest lines of `cost.json` in a folder as text; None where it is not there."""
    if not (folder / COST).is_file():
        return None
    record: Mapping[str, Any] = read_json(folder / COST)
    lines = sorted(record["lines"], key=lambda line: -line["quantity"] * line["unit_EUR"][0])
    sums = (("made parts", "made_EUR"), ("bought parts", "bought_EUR"), ("one machine", "total_EUR"))
    return {
        "machines": record["machines"],
        "sums": [(words, [_euro(v) for v in record[key]]) for words, key in sums],
        "lines": [
            (
                f"{line['quantity']} × {line['part_number']}",
                [_euro(line["quantity"] * one) for one in line["unit_EUR"]],
                line["source"],
            )
            for line in lines[:DEAREST]
        ],
        "left_out": record["assumed"]["left_out"],
        "hour": _euro(record["assumed"]["shop"]["hour_EUR"]),
    }


def tolerances(folder: Path) -> dict[str, Any] | None:
    """Gives the chains of `tolerances.json` in a folder as text; None where it is not there."""
    if not (folder / TOLERANCES).is_file():
        return None
    record: Mapping[str, Any] = read_json(folder / TOLERANCES)
    return {
        "general": record["general_class"],
        "assumed": record["assumed"],
        "chains": [_chain(chain) for chain in (*record["chains"], *record["lengths"])],
    }


def _chain(chain: Mapping[str, Any]) -> dict[str, Any]:
    low, high = chain["allowed"]
    unit = chain["unit"]
    bounded = low is not None or high is not None
    return {
        "name": chain["name"],
        "nominal": with_unit(chain["nominal"], unit),
        "worst": _range(chain["worst"], unit),
        "rss": _range(chain["rss"], unit),
        "allowed": _allowed(low, high, unit),
        "decides": DECIDES.get(chain["decided_by"], chain["decided_by"]) if bounded else "",
        "holds": chain["holds"] if bounded else None,
        "why": chain["why"],
        "links": [
            f"{link['part']}, {link['what']} ({link['kind']}): {_range(link['adds'], unit)}" for link in chain["links"]
        ],
    }


def _allowed(low: float | None, high: float | None, unit: str) -> str:
    """Bounds as text; "" where there is none."""
    if low is not None and high is not None:
        return _range((low, high), unit)
    return f"≥ {with_unit(low, unit)}" if low is not None else f"≤ {with_unit(high, unit)}" if high is not None else ""


def _range(ends: Any, unit: str) -> str:
    low, high = ends
    return f"{with_unit(low)} … {with_unit(high, unit)}"


def _euro(value: float) -> str:
    return f"{value:,.2f}" if value < 100.0 else f"{value:,.0f}"
