"""Prices of bought parts: the catalogue price with its source, otherwise a marked estimate."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cache
from math import ceil
from pathlib import Path
from typing import Any, Literal, NamedTuple, cast

from delta_cad import catalogue
from delta_cad.catalogue import CatalogueRow, Motor
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.export.shop.cost.rates import ESTIMATE, share_at

_Per = Literal["piece", "metre", "pack"]
FILE = Path(__file__).parent / "data" / "prices.csv"
_PACK_MACHINES = 10  # that a pack of adhesive or grease is enough for
_MOTOR_EUR, _MOTOR_EUR_N_m = 100.0, 1800.0  # of a motor whose price is nowhere: that, and so much per N m for ever
_BENCH_MM = 40.0  # of cable beyond its length, cut off on the bench


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
    per: _Per
    source: str
    length_mm: float = 0.0

    def of_one(self, quantity: int, machines: int) -> float:
        """Computes what one of a quantity in each machine costs when several machines are made, EUR."""
        share = share_at(machines)
        if self.per == "pack":
            packs = ceil(machines / _PACK_MACHINES)
            return self.one_EUR * share * packs / (machines * quantity)
        if self.per == "metre":
            metres = ceil(machines * quantity * self.length_mm / MM_PER_M)
            return self.one_EUR * share * metres / (machines * quantity)
        return self.one_EUR * share


def row_price(kind: str, row: CatalogueRow, length_mm: float = 0.0) -> Price:
    """Gives the price of a row of a family, of a piece so long where it is cut to length: its own, else our list's."""
    per = "metre" if kind in ("cable", "tube") else "piece"
    if row.price_EUR is not None:
        return Price(row.price_EUR, per, row.price_source, length_mm)
    own = [one for one in _list() if one.kind == kind and one.id in (row.id, "")]
    if own:
        return Price(own[0].price_EUR, per, own[0].source, length_mm)
    assert isinstance(row, Motor)
    by_torque = _MOTOR_EUR + _MOTOR_EUR_N_m * row.nominal_torque_N_m
    return Price(by_torque, "piece", f"{ESTIMATE} by its torque: {_MOTOR_EUR:g} EUR and {_MOTOR_EUR_N_m:g} EUR per N m")


def part_price(number: str) -> Price:
    """Gives the estimate of our list for a bought part by its number."""
    found = next(one for one in _list() if one.kind == "part" and fnmatchcase(number, one.id))
    return Price(found.price_EUR, found.per, found.source)


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
    if d.board_spacer is not None:
        found["board_spacer"] = row_price("spacer", d.board_spacer)
    if d.shaft.washer is not None:
        found["shoulder_washer"] = row_price("spacer", d.shaft.washer)
    if d.motor.drive_board:
        found["drive_board"] = row_price("drive_board", catalogue.drive_board(d.motor.drive_board))
    found |= {f"insert_{row.thread}": row_price("insert", row) for row in catalogue.insert.rows.values()}
    if d.preload is not None:
        found["wave_spring"] = row_price("wave_spring", d.preload)
    if d.capstan is not None:
        found["capstan_cable"] = row_price("cable", d.cable, d.capstan.bench_mm[0] + _BENCH_MM)
    return found


class _Listed(NamedTuple):
    """A row of our list: family and id of a row of the catalogue, or "part" and the pattern of a part's number."""

    kind: str
    id: str
    price_EUR: float
    per: _Per
    source: str


@cache
def _list() -> tuple[_Listed, ...]:
    with FILE.open(encoding="utf-8", newline="") as file:
        rows = cast("Iterable[dict[str, Any]]", csv.DictReader(file))
        return tuple(_Listed(r["kind"], r["id"], float(r["price_EUR"]), r["per"], r["source"]) for r in rows)
