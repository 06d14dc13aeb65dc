"""All tolerance chains of a machine, the loosest general class with which they hold, and how they are written down."""

from __future__ import annotations

from math import isfinite
from typing import Any

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.cable import cable_chains
from delta_cad.dimensions.tolerances.chain import MADE, Chain, Link
from delta_cad.dimensions.tolerances.general import ASKED, CLASSES, NOTES, coarsest_grade
from delta_cad.dimensions.tolerances.lengths import deviation_mm, length_chains, twist_chain
from delta_cad.dimensions.tolerances.shoulder import shoulder_chains

SCHEMA = "delta-tolerances/1"
ASSUMED = (
    "Worst case: every part at the worst end of its tolerance at once",
    "Statistical (root sum of squares): 99.73 % of machines, each deviation normal about the middle of its "
    "zone, whose half width is three sigmas",
    "Widths of bearings, dowels and pilots of motors by their standards; chips, magnets and what is set by hand as the "
    "links state",
)
DECIMALS = 5


def machine_chains(d: Dimensions, general: str = ASKED) -> list[Chain]:
    """Lists the chains that have bounds; the three chains of a machine are alike.

    Args:
        d: Dimensions of the machine.
        general: Class of the general tolerances, of ISO 2768-1.
    """
    return [*shoulder_chains(d, general), *cable_chains(d, general), twist_chain(d)]


def loosest_class(d: Dimensions) -> str | None:
    """Finds the loosest general class with which every chain holds; None: not even the finest does."""
    holding = [name for name in CLASSES if all(chain.holds for chain in machine_chains(d, name))]
    return holding[-1] if holding else None


def general_class(d: Dimensions) -> str:
    """Chooses the general class that drawings state: the usual one, or a finer one where chains need it."""
    loosest = loosest_class(d)
    return ASKED if loosest is None or CLASSES.index(loosest) >= CLASSES.index(ASKED) else loosest


def tolerance_record(d: Dimensions) -> dict[str, Any]:
    """Tells a machine's chains as JSON types: `tolerances.json`."""
    general = general_class(d)
    lengths = length_chains(d, general)
    return {
        "schema": SCHEMA,
        "assumed": list(ASSUMED),
        "general_class": NOTES[general],
        "loosest_class": loosest_class(d),
        "largest_length_deviation_mm": _plain(max(map(deviation_mm, lengths))),
        "chains": [_told(chain) for chain in machine_chains(d, general)],
        "lengths": [_told(chain) for chain in lengths],
    }


def _told(chain: Chain) -> dict[str, Any]:
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
    """A link, and how much looser what a shop is asked for could be."""
    told: dict[str, Any] = {
        "part": link.part,
        "what": link.what,
        "kind": link.kind,
        "deviation_mm": [_plain(link.lower_mm), _plain(link.upper_mm)],
        "adds": [_plain(v) for v in link.range],
    }
    if link.kind in MADE and isfinite(largest := chain.largest_mm(link)):
        told["largest_mm"] = _plain(largest)
        if link.nominal_mm:
            grade = coarsest_grade(2.0 * largest, link.nominal_mm)
            told["loosest_grade"] = None if grade is None else f"IT{grade}"
    return told


def _plain(value: float) -> float | None:
    return round(value, DECIMALS) + 0.0 if isfinite(value) else None
