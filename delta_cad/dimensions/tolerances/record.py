"""How a machine's tolerance chains are written down: `tolerances.json`."""

from __future__ import annotations

from math import isfinite
from typing import Any

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.chain import MADE, Chain, Link
from delta_cad.dimensions.tolerances.general import NOTES, coarsest_grade
from delta_cad.dimensions.tolerances.machine import (
    deviation_mm,
    general_class,
    length_chains,
    loosest_class,
    machine_chains,
)

_SCHEMA = "delta-tolerances/1"
_ASSUMED = (
    "Worst case: every part at the worst end of its tolerance at once",
    "Statistical (root sum of squares): 99.73 % of machines, each deviation normal about the middle of its "
    "zone, whose half width is three sigmas",
    "Widths of bearings, dowels and pilots of motors by their standards; chips, magnets and what is set by hand as the "
    "links state",
)
_DECIMALS = 5


def tolerance_record(d: Dimensions) -> dict[str, Any]:
    """Gives a machine's chains as JSON types: `tolerances.json`."""
    general = general_class(d)
    lengths = length_chains(d, general)
    return {
        "schema": _SCHEMA,
        "assumed": list(_ASSUMED),
        "general_class": NOTES[general],
        "loosest_class": loosest_class(d),
        "largest_length_deviation_mm": _plain(max(map(deviation_mm, lengths))),
        "chains": [_reported(chain) for chain in machine_chains(d, general)],
        "lengths": [_reported(chain) for chain in lengths],
    }


def _reported(chain: Chain) -> dict[str, Any]:
    return {
        "name": chain.name,
        "unit": chain.unit,
        "nominal": _plain(chain.nominal),
        "worst": [_plain(v) for v in chain.worst],
        "rss": [_plain(v) for v in chain.rss],
        "allowed": [_plain(v) for v in (chain.low, chain.high)],
        "decided_by": "rss" if chain.statistical else "worst",
        "holds": chain.holds,
        "made_looser_by": _plain(chain.looser()),
        "why": chain.why,
        "links": [_link(chain, link) for link in chain.links],
    }


def _link(chain: Chain, link: Link) -> dict[str, Any]:
    """A link, and how much looser its tolerance, or its fit, could be."""
    reported: dict[str, Any] = {
        "part": link.part,
        "what": link.what,
        "kind": link.kind,
        "deviation_mm": [_plain(link.lower_mm), _plain(link.upper_mm)],
        "adds": [_plain(v) for v in link.range],
    }
    if link.kind in MADE and isfinite(largest := chain.largest_mm(link)):
        reported["largest_mm"] = _plain(largest)
        if link.nominal_mm:
            grade = coarsest_grade(2.0 * largest, link.nominal_mm)
            reported["loosest_grade"] = None if grade is None else f"IT{grade}"
    return reported


def _plain(value: float) -> float | None:
    return round(value, _DECIMALS) + 0.0 if isfinite(value) else None
