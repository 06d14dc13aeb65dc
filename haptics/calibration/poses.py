"""Measured poses: the position of the handle and the encoder readings there."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from delta_cad.common.reading import ReadError, read_bounded, text_of
from delta_cad.common.refusal import RefusedError, short
from delta_cad.common.units import MM_PER_M

COLUMNS = ("x_mm", "y_mm", "z_mm", "reading_0_deg", "reading_1_deg", "reading_2_deg")
MOST_BYTES = 10_000_000
_MOST_POSES = 20_000  # a tracker's minute at 300 a second; the fit takes seconds
_LARGEST = {"mm": 10_000.0, "deg": 360.0 * 100.0}


class PosesError(RefusedError):
    """Poses that are refused."""


@dataclass(frozen=True)
class Poses:
    """Measured poses.

    Attributes:
        positions: (n, 3) of the platform's centre, in the base frame or in the tracker's own, m.
        readings: (n, 3) of the encoders, rad.
    """

    positions: np.ndarray
    readings: np.ndarray


def load_poses(path: Path) -> Poses:
    """Reads poses from a CSV file.

    Args:
        path: Its first line has exactly `COLUMNS`, in any order.

    Raises:
        PosesError: It cannot be read, has other columns, a row of other length, or a cell that is no finite number
            within bounds.
    """
    name = Path(path).name
    try:
        text = text_of(read_bounded(Path(path), MOST_BYTES), name)
    except ReadError as error:
        raise PosesError(error.file, error.field, error.value, error.allowed) from None
    try:
        rows = [row for row in csv.reader(io.StringIO(text, newline=""), strict=True) if row]
    except csv.Error as error:
        raise PosesError(name, "", "", f"is not CSV: {error}") from None
    head = [cell.strip() for cell in rows[0]] if rows else []
    if sorted(head) != sorted(COLUMNS):
        raise PosesError(name, "columns", short(head), f"must be {', '.join(COLUMNS)}")
    if len(rows) - 1 > _MOST_POSES:
        raise PosesError(name, "rows", str(len(rows) - 1), f"must be at most {_MOST_POSES}")
    table = np.empty((len(rows) - 1, len(COLUMNS)))
    for n, row in enumerate(rows[1:]):
        if len(row) != len(head):
            raise PosesError(name, f"row {n + 1}", short(row), f"must have {len(head)} numbers")
        for column, cell in zip(head, row, strict=True):
            table[n, COLUMNS.index(column)] = _number(name, f"row {n + 1} {column}", cell)
    return Poses(table[:, :3] / MM_PER_M, np.radians(table[:, 3:]))


def _number(name: str, field: str, cell: str) -> float:
    most = _LARGEST[field.rsplit("_", 1)[-1]]
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not abs(value) <= most:
        unit = "degrees, of which an encoder's counts are turned into first" if field.endswith("deg") else "mm"
        raise PosesError(name, field, short(cell), f"must be a number from -{most:g} to {most:g} {unit}")
    return value
