"""Recordings of a device: what was read and what was written at each tick, in memory, as CSV, and as npz."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

# Columns of a CSV file, and with their values side by side of the array in an npz file.
COLUMNS = (
    "time_s",
    *(f"shoulder_angle_{i}_rad" for i in range(3)),
    *(f"torque_{i}_N_m" for i in range(3)),
)


class RecordingError(ValueError):
    """A recording that is refused; the message names the file and what is wrong."""


class Recording(NamedTuple):
    """What was read and written over n ticks.

    Attributes:
        time: (n,) s.
        angles: (n, 3) rad; NaN where an encoder had none.
        torques: (n, 3) N m, as written after the reading of the same row.
    """

    time: np.ndarray
    angles: np.ndarray
    torques: np.ndarray


class Recorder:
    """Collects ticks."""

    def __init__(self) -> None:
        self._rows: list[np.ndarray] = []

    def add(self, time: float, angles: ArrayLike, torques: ArrayLike) -> None:
        """Adds a tick; the arrays are copied.

        Args:
            time: s.
            angles: (3,) rad.
            torques: (3,) N m.
        """
        self._rows.append(np.concatenate([[time], np.asarray(angles, dtype=float), np.asarray(torques, dtype=float)]))

    def __len__(self) -> int:
        return len(self._rows)

    def recording(self) -> Recording:
        """All ticks so far."""
        return _split(np.array(self._rows, dtype=float).reshape(-1, len(COLUMNS)))


def save_recording(recording: Recording, path: str | Path) -> None:
    """Writes a recording; what is read back is the same to the last bit.

    Args:
        recording: The recording.
        path: Ends in .csv or .npz.

    Raises:
        RecordingError: It ends in something else.
    """
    path = Path(path)
    table = np.column_stack([recording.time, recording.angles, recording.torques])
    if path.suffix == ".npz":
        np.savez_compressed(path, columns=np.array(COLUMNS), values=table)
    elif path.suffix == ".csv":
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            writer.writerows([repr(float(value)) for value in row] for row in table)
    else:
        raise RecordingError(f"{path.name}: a recording ends in .csv or .npz")


def load_recording(path: str | Path) -> Recording:
    """Reads a recording.

    Args:
        path: Ends in .csv or .npz.

    Returns:
        The recording.

    Raises:
        RecordingError: It cannot be read, other columns, a row that is not numbers, or a time that does not grow.
    """
    path = Path(path)
    if path.suffix not in (".csv", ".npz"):
        raise RecordingError(f"{path.name}: a recording ends in .csv or .npz")
    try:
        columns, table = _read_npz(path) if path.suffix == ".npz" else _read_csv(path)
    except OSError as error:
        raise RecordingError(f"{path.name}: cannot be read: {error.strerror or error}") from None
    except (ValueError, KeyError, EOFError) as error:
        raise RecordingError(f"{path.name}: is not a recording: {error}") from None
    if columns != COLUMNS or table.ndim != 2 or table.shape[1:] != (len(COLUMNS),):
        raise RecordingError(f"{path.name}: its columns must be {', '.join(COLUMNS)}")
    if not np.isfinite(table[:, 0]).all() or not (np.diff(table[:, 0]) > 0.0).all():
        raise RecordingError(f"{path.name}: time_s must be finite and grow from row to row")
    return _split(table)


def _read_npz(path: Path) -> tuple[tuple[str, ...], np.ndarray]:
    import zipfile

    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            return tuple(str(name) for name in file["columns"]), np.asarray(file["values"], dtype=float)
    except zipfile.BadZipFile as error:
        raise ValueError(error) from None


def _read_csv(path: Path) -> tuple[tuple[str, ...], np.ndarray]:
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    if not rows:
        raise ValueError("it is empty")
    values = np.array([[float(cell) for cell in row] for row in rows[1:]], dtype=float)
    return tuple(rows[0]), values.reshape(-1, len(COLUMNS)) if values.size == 0 else values


def _split(table: np.ndarray) -> Recording:
    return Recording(table[:, 0], table[:, 1:4], table[:, 4:7])
