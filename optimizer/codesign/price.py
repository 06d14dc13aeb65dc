"""What a candidate costs, estimated from hardware and lengths; a build of it tells by how much that was off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.export.shop.cost.bought import row_price
from delta_cad.mechanism.placement import CHAINS
from optimizer.codesign.choice import Choice, motor_of
from optimizer.problem.brief import DesignBrief
from optimizer.problem.evaluator import VARIABLES

MADE_EUR = {"capstan": 2502.0, "direct": 1892.0}
"""Drive -> made parts of one machine, but for what grows with its lengths: batches that must be set up anyway."""
MADE_EUR_mm2 = 1.11e-3
"""Of (R + L_A + L_B)^2: of machines of 265 and 479 mm, 2581 and 2758 EUR by their solids."""
COUNTS = {"encoder": 3, "magnet": 3, "bearing": 6, "knob": 1, "foot": 3}
"""Entry of the hardware -> how many a machine has, of what is bought by the piece."""
CAPSTAN_ONLY = ("bearing",)
SHOULDER_ONLY = ("encoder", "magnet")
ROPE_MM = 400.0  # about what a chain takes of rope
REST_EUR = 110.0  # springs, balls, screws, dowels, adhesives
SIZED = ("upper_arm_length", "forearm_length", "base_radius")


def price_EUR(brief: DesignBrief, choice: Choice, lengths_mm: Sequence[float]) -> float:
    """Estimates the price of one machine, EUR.

    Args:
        brief: What the customer asks, whose own parts may have prices.
        choice: Hardware.
        lengths_mm: (6) in the order of `VARIABLES`.
    """
    size = sum(lengths_mm[VARIABLES.index(name)] for name in SIZED)
    motors = len(CHAINS) * row_price("motor", motor_of(brief, choice.motor)).one_EUR
    return motors + _rows_EUR(brief, choice, lengths_mm) + REST_EUR + MADE_EUR[choice.drive] + MADE_EUR_mm2 * size**2


def cheapest(brief: DesignBrief) -> Mapping[str, Any]:
    """Chooses the cheapest row of every entry of which the brief states several."""
    found = {}
    for entry in (*COUNTS, "cable", "tube"):
        rows = brief.choices.get(entry, ())
        if entry in brief.hardware and len(rows) > 1:
            found[entry] = min(rows, key=lambda row, entry=entry: _row_EUR(brief, entry, row))
    return found


def _rows_EUR(brief: DesignBrief, choice: Choice, lengths_mm: Sequence[float]) -> float:
    """What is bought by rows of the catalogue other than the motors."""
    total, forearm = 0.0, lengths_mm[VARIABLES.index("forearm_length")]
    sensed = choice.stated(brief, "encoder_at") != "motor"
    for entry, count in COUNTS.items():
        if (entry in CAPSTAN_ONLY and choice.drive != "capstan") or (entry in SHOULDER_ONLY and not sensed):
            continue
        total += count * _row_EUR(brief, entry, choice.stated(brief, entry))
    rope = len(CHAINS) * ROPE_MM if choice.drive == "capstan" else 0.0
    for entry, length in (("tube", 2 * len(CHAINS) * forearm), ("cable", rope)):
        total += length / MM_PER_M * _row_EUR(brief, entry, choice.stated(brief, entry))
    return total


def _row_EUR(brief: DesignBrief, entry: str, row: str) -> float:
    return row_price(entry, cast(catalogue.CatalogueRow, catalogue.family(entry, brief.own_parts)[row])).one_EUR
