"""Prices of bought parts: the catalogue's where it has one with its source, else an estimate that says so."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from math import ceil
from pathlib import Path
from typing import Literal

from delta_cad.catalogue import CatalogueRow, Motor
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.export.shop.cost.rates import ESTIMATE, share_at

FILE = Path(__file__).parent / "data" / "prices.csv"
PACK_MACHINES = 10  # that a pack of adhesive or grease is enough for
MOTOR_EUR, MOTOR_EUR_N_m = 100.0, 1800.0  # of a motor whose price is nowhere: that, and so much per N m for ever
BENCH_MM = 40.0  # of cable beyond its length, cut off on the bench


@dataclass(frozen=True)
class Price:
    """A price of one, EUR without tax.

    Attributes:
        one_EUR: Of one piece, metre or pack, bought for one machine.
        per: What it is of.
        source: Date and source, or why it is an estimate.
        length_mm: Of a piece, where the price is that of a metre.
    """

    one_EUR: float
    per: Literal["piece", "metre", "pack"]
    source: str
    length_mm: float = 0.0

    def of_one(self, quantity: int, machines: int) -> float:
        """Computes what one of a quantity in each machine costs when several machines are made, EUR.

        Args:
            quantity: In each machine.
            machines: Made at once.
        """
        share = share_at(machines)
        if self.per == "pack":
            packs = ceil(machines / PACK_MACHINES)
            return self.one_EUR * share * packs / (machines * quantity)
        if self.per == "metre":
            metres = ceil(machines * quantity * self.length_mm / MM_PER_M)
            return self.one_EUR * share * metres / (machines * quantity)
        return self.one_EUR * share


def row_price(kind: str, row: CatalogueRow, length_mm: float = 0.0) -> Price:
    """Gives the price of a row of the catalogue: its own, else that of our list.

    Args:
        kind: Family.
        row: The row.
        length_mm: Of a piece of what is sold by the metre.
    """
    per = "metre" if kind in ("cable", "tube") else "piece"
    if row.price_EUR is not None:
        return Price(row.price_EUR, per, row.price_source, length_mm)
    own = [one for one in _list() if one[0] == kind and one[1] in (row.id, "")]
    if own:
        return Price(own[0][2], per, own[0][4], length_mm)
    assert isinstance(row, Motor)
    by_torque = MOTOR_EUR + MOTOR_EUR_N_m * row.nominal_torque_N_m
    return Price(by_torque, "piece", f"{ESTIMATE} by its torque: {MOTOR_EUR:g} EUR and {MOTOR_EUR_N_m:g} EUR per N m")


def part_price(number: str) -> Price:
    """Gives the estimate of our list for a bought part by its number."""
    _, _, price, per, source = next(one for one in _list() if one[0] == "part" and fnmatchcase(number, one[1]))
    return Price(price, per, source)


def prices(d: Dimensions) -> dict[str, Price]:
    """Gives the prices of what is bought by a row of the catalogue, by part number: of parts, and of stock."""
    found = {
        "motor": row_price("motor", d.motor),
        "encoder_board": row_price("encoder", d.encoder),
        "encoder_magnet": row_price("magnet", d.magnet),
        "bearing": row_price("bearing", d.bearing),
        "rod_spring": row_price("tension_spring", d.forearm.spring),
        "joint_ball": row_price("ball", d.forearm.ball),
        "rod_tube": row_price("tube", d.tube, d.forearm.tube_length_mm),
        "knob": row_price("knob", d.knob),
        "foot": row_price("foot", d.foot),
    }
    if d.preload is not None:
        found["wave_spring"] = row_price("wave_spring", d.preload)
    if d.capstan is not None:
        found["capstan_cable"] = row_price("cable", d.cable, d.capstan.bench_mm[0] + BENCH_MM)
    return found


@cache
def _list() -> tuple[tuple[str, str, float, Literal["piece", "metre", "pack"], str], ...]:
    return tuple(_rows())


def _rows() -> Iterator[tuple[str, str, float, Literal["piece", "metre", "pack"], str]]:
    with FILE.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            per: Literal["piece", "metre", "pack"] = "piece"
            if row["per"] == "metre":
                per = "metre"
            elif row["per"] == "pack":
                per = "pack"
            yield row["kind"], row["id"], float(row["price_EUR"]), per, row["source"]
