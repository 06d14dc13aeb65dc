"""The file of a calibration, `delta-calibration/1`: written completely, read strictly, valid for one design only."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from delta_cad.common.files import write_whole
from delta_cad.common.reading import ReadError, read_json
from delta_cad.common.refusal import RefusedError, short
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design, design_hash
from haptics.calibration.accuracy import Accuracy
from haptics.calibration.fit import Fit
from haptics.calibration.unknowns import ANGLES, LENGTHS, NAMES, Unknowns, nominal

# Unobservable parameters: those that act alike, and those that the poses are too close together for.
_NEVER = 1e-6  # singular value below which no noise is small enough: roundings leave 1e-12, the weakest true one 1e-2
_DRAWN = 1.0  # below it the drawing tells more of a combination than the poses do
SHARE = 0.1  # of a parameter that has to lie in what is not told for it to be named


@dataclass(frozen=True)
class _Unobservable:
    """Parameters of which some combinations are not told.

    Attributes:
        names: Such as "base_radius_0".
        combinations: How many.
        never: Whether no poses, however exact, would tell them.
        moves: Of a single combination the parts that move together, in units of what each may be off; else empty.
    """

    names: tuple[str, ...]
    combinations: int
    never: bool
    moves: tuple[float, ...] = ()

    def __str__(self) -> str:
        if self.never and len(self.names) == 2:
            which = "difference" if self.moves[0] * self.moves[1] > 0.0 else "sum"
            return f"{' and '.join(self.names)} cannot be told apart: only their {which} acts"
        listed, several = ", ".join(self.names), f"{self.combinations} combination{'s' * (self.combinations > 1)}"
        if len(self.names) == 1:
            return f"{listed}: these poses do not tell it better than the drawing: more poses, farther apart, would"
        if self.never:
            return f"{several} of {listed} cannot be told by any poses in this frame"
        return (
            f"{several} of {listed} these poses do not tell better than the drawing: more poses, farther apart, would"
        )


def unobservable(found: Fit) -> list[_Unobservable]:
    """Finds the parameters that the poses do not determine.

    Returns:
        Groups of parameters that hang together, those that no poses would tell first.
    """
    reported, rows = found.singular_values, found.directions
    missing = np.linalg.svd(rows)[2][len(reported) :]  # where there are fewer equations than parameters
    never = np.vstack([rows[reported < _NEVER], missing])
    weak = rows[(reported >= _NEVER) & (reported < _DRAWN)]
    return [*_groups(never, True), *_groups(weak, False)]


def _groups(rows: np.ndarray, never: bool) -> Iterator[_Unobservable]:
    """Groups of parameters that a space of directions (k, 33) ties together."""
    shared = rows.T @ rows
    left = [k for k in range(len(shared)) if shared[k, k] > SHARE]
    names = [f"{name}_{i}" for i in range(3) for name in NAMES]
    while left:
        group, work = {left[0]}, [left[0]]
        while work:
            k = work.pop()
            for other in left:
                if other not in group and abs(shared[k, other]) > SHARE:
                    group.add(other)
                    work.append(other)
        left = [k for k in left if k not in group]
        members = sorted(group)
        values, vectors = np.linalg.eigh(shared[np.ix_(members, members)])
        count = max(1, round(float(values.sum())))
        moves = tuple(float(v) for v in vectors[:, -1]) if count == 1 else ()
        yield _Unobservable(tuple(names[k] for k in members), count, never, moves)


_SCHEMA = "delta-calibration/1"
FILE = "calibration.json"
MOST_BYTES = 1_000_000
_FIELDS = tuple(f"{name}_{'mm' if k < LENGTHS else 'deg'}" for k, name in enumerate(NAMES))
_KEYS = ("schema", "name", "design_sha256", "encoder_turns", "chains", "uncertainty", "not_told", "fit")
# How far a parameter may be from the drawn one: a device farther off was not made to this drawing. mm and degrees.
_LENGTH_OFF_MM, _WAVE_OFF_DEG, _ZERO_OFF_DEG = 5.0, 10.0, 180.0
_TURNS_MOST = 1000.0


class CalibrationError(RefusedError):
    """A calibration that is refused."""


@dataclass(frozen=True)
class Calibration:
    """A device as it was measured.

    Attributes:
        name: Of the design.
        design_sha256: Of the design that was calibrated.
        unknowns: Its parameters.
        sigma: (3, 11) standard deviations, m and rad.
        unidentifiable: What the poses did not tell, in words.
        fit: Figures of the fit, with their units in their names.
    """

    name: str
    design_sha256: str
    unknowns: Unknowns
    sigma: np.ndarray
    unidentifiable: tuple[str, ...]
    fit: Mapping[str, float | int | str | None]


def calibration_of(design: Design, found: Fit, poses: int, expected: Accuracy) -> Calibration:
    """Makes the record of a fit.

    Args:
        design: What was calibrated.
        found: The fit.
        poses: Their number.
        expected: Predicted error of a position over the cube.
    """
    x, y, z = (MM_PER_M * float(v) for v in expected.worst_at)
    figures: dict[str, float | int | str | None] = {
        "poses": poses,
        "frame": "own" if found.frame.solved else "base",
        "before_rms_mm": _finite(MM_PER_M * _rms(found.before)),
        "after_rms_mm": MM_PER_M * _rms(found.after),
        "worst_mm": MM_PER_M * float(found.after.max()),
        "worst_pose": int(found.after.argmax()) + 1,
        "misfit": found.misfit,
        "predicted_rms_mm": MM_PER_M * expected.rms,
        "predicted_worst_mm": MM_PER_M * expected.worst,
        "predicted_worst_x_mm": x,
        "predicted_worst_y_mm": y,
        "predicted_worst_z_mm": z,
    }
    said = tuple(str(one) for one in unobservable(found))
    return Calibration(design.name, design_hash(design), found.unknowns, found.sigma, said, figures)


def save_calibration(calibration: Calibration, path: Path) -> None:
    """Writes a calibration, whole or not at all.

    Raises:
        OSError: It cannot be written.
    """
    write_whole(path, json.dumps(to_dict(calibration), indent=1, allow_nan=False) + "\n")


def to_dict(calibration: Calibration) -> dict[str, Any]:
    """Gives a calibration as the file has it."""
    return {
        "schema": _SCHEMA,
        "name": calibration.name,
        "design_sha256": calibration.design_sha256,
        "encoder_turns": calibration.unknowns.turns,
        "chains": _rows(calibration.unknowns.table),
        "uncertainty": _rows(calibration.sigma),
        "not_told": list(calibration.unidentifiable),
        "fit": dict(calibration.fit),
    }


def load_calibration(path: Path, design: Design) -> Calibration:
    """Reads the calibration of a device.

    Args:
        path: The file.
        design: The device's design.

    Raises:
        CalibrationError: It cannot be read, is of another design, lacks a key or has an unknown one, or a number is not
            finite or farther from the drawing than a made device is.
    """
    path = Path(path)
    try:
        data = read_json(path, MOST_BYTES)
    except ReadError as error:
        raise CalibrationError(error.file, error.field, error.value, error.allowed) from None
    file = path.name
    _require_keys(file, "", data, _KEYS)
    if data["schema"] != _SCHEMA:
        raise CalibrationError(file, "schema", short(data["schema"]), f'must be "{_SCHEMA}"')
    if data["design_sha256"] != design_hash(design):
        rule = f"is of another design than {design.name}, {design_hash(design)[:12]}; calibrate again"
        raise CalibrationError(file, "design_sha256", short(data["design_sha256"]), rule)
    turns = _number(file, "encoder_turns", data["encoder_turns"], 1.0, _TURNS_MOST)
    as_drawn = nominal(design.geometry, turns)
    drawn = as_drawn.table
    off = np.radians([_ZERO_OFF_DEG] + [_WAVE_OFF_DEG] * (len(ANGLES) - 1))
    off = np.concatenate([[_LENGTH_OFF_MM / MM_PER_M] * LENGTHS, off])
    table = _table(file, "chains", data["chains"], drawn - off, drawn + off)
    sigma = _table(file, "uncertainty", data["uncertainty"], np.zeros(drawn.shape), np.full(drawn.shape, 10.0))
    words, figures = data["not_told"], data["fit"]
    if not (isinstance(words, list) and all(isinstance(one, str) for one in words)):
        raise CalibrationError(file, "not_told", short(words), "must be a list of text")
    if not (isinstance(figures, dict) and all(isinstance(one, int | float | str | None) for one in figures.values())):
        raise CalibrationError(file, "fit", short(figures), "must be an object of numbers and text")
    if not isinstance(data["name"], str):
        raise CalibrationError(file, "name", short(data["name"]), "must be text")
    made = replace(as_drawn, table=table)
    return Calibration(data["name"], data["design_sha256"], made, sigma, tuple(words), figures)


def _rows(table: np.ndarray) -> list[dict[str, float]]:
    """A table (3, 11) in mm and degrees."""
    return [{key: _shown(k, float(v)) for k, (key, v) in enumerate(zip(_FIELDS, row, strict=True))} for row in table]


def _shown(k: int, value: float) -> float:
    return value * MM_PER_M if k < LENGTHS else math.degrees(value)


def _table(file: str, field: str, data: object, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Reads a table between two others, all m and rad; messages state the bounds in the units of the file."""
    if not (isinstance(data, list) and len(data) == len(low)):
        raise CalibrationError(file, field, short(data), f"must be a list of {len(low)} chains")
    out = np.empty(low.shape)
    for i, row in enumerate(data):
        _require_keys(file, f"{field}[{i}]", row, _FIELDS)
        for k, key in enumerate(_FIELDS):
            least, most = _shown(k, float(low[i, k])), _shown(k, float(high[i, k]))
            value = _number(file, f"{field}[{i}].{key}", row[key], least, most)
            out[i, k] = value / MM_PER_M if k < LENGTHS else math.radians(value)
    return out


def _require_keys(file: str, field: str, data: object, keys: tuple[str, ...]) -> None:
    if not isinstance(data, dict):
        raise CalibrationError(file, field, short(data), "must be an object")
    for key in keys:
        if key not in data:
            raise CalibrationError(file, f"{field}.{key}".lstrip("."), "", "is missing")
    for key, value in data.items():
        if key not in keys:
            rule = f"unknown key; known here: {', '.join(keys)}"
            raise CalibrationError(file, f"{field}.{key}".lstrip("."), short(value), rule)


def _number(file: str, field: str, value: object, least: float, most: float) -> float:
    slack = 1e-9 * (abs(least) + abs(most))  # an angle of 180 degrees, there and back
    if isinstance(value, bool) or not isinstance(value, int | float) or not least - slack <= value <= most + slack:
        raise CalibrationError(file, field, short(value), f"must be a number from {least:.6g} to {most:.6g}")
    return float(value)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt((values**2).mean()))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
