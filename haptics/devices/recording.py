"""Recordings of a device: readings and torques of each tick, in memory, as CSV, and as npz."""

from __future__ import annotations

import csv
import io
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.files import write_whole
from delta_cad.common.reading import ReadError, read_bounded, text_of
from delta_cad.common.refusal import printable

MOST_BYTES = 500_000_000  # of a recording, also unpacked; an hour of ticks has a fifth of it in npz, the half in CSV
LONGEST = 200  # characters of another library's complaint
# Columns of a CSV file, and with their values side by side of the array in an npz file.
COLUMNS = (
    "time_s",
    *(f"shoulder_angle_{i}_rad" for i in range(3)),
    *(f"torque_{i}_N_m" for i in range(3)),
)


class RecordingError(ValueError):
    """A recording that is refused; the message names the file and what is wrong in one printable line."""

    def __init__(self, text: str) -> None:
        super().__init__(printable(text))


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


class Forgetful(Recorder):
    """Keeps nothing: a device may run for days."""

    def add(self, time: float, angles: ArrayLike, torques: ArrayLike) -> None:
        """Drops a tick."""


def save_recording(recording: Recording, path: str | Path) -> None:
    """Writes a recording; what is read back is the same to the last bit.

    Args:
        recording: The recording.
        path: Ends in .csv or .npz.

    Raises:
        RecordingError: It ends in something else.
        OSError: It cannot be written; a file that was there is as it was.
    """
    path = Path(path)
    table = np.column_stack([recording.time, recording.angles, recording.torques])
    if path.suffix == ".npz":
        packed = io.BytesIO()
        np.savez_compressed(packed, columns=np.array(COLUMNS), values=table)
        write_whole(path, packed.getvalue())
    elif path.suffix == ".csv":
        text = io.StringIO()
        writer = csv.writer(text)
        writer.writerow(COLUMNS)
        writer.writerows([repr(float(value)) for value in row] for row in table)
        write_whole(path, text.getvalue())
    else:
        raise RecordingError(f"{path.name}: a recording ends in .csv or .npz")


def load_recording(path: str | Path) -> Recording:
    """Reads a recording.

    Args:
        path: Ends in .csv or .npz.

    Raises:
        RecordingError: It cannot be read, is too large, has other columns, a row that is not numbers, or a time that
            does not grow.
    """
    path = Path(path)
    if path.suffix not in (".csv", ".npz"):
        raise RecordingError(f"{path.name}: a recording ends in .csv or .npz")
    read = _read_npz if path.suffix == ".npz" else _read_csv
    try:
        columns, table = read(read_bounded(path, MOST_BYTES), path.name)
    except ReadError as error:
        raise RecordingError(str(error)) from None
    except Exception as error:  # unpacking a damaged file raises anything
        text = str(error)[:LONGEST] or type(error).__name__
        raise RecordingError(f"{path.name}: is not a recording: {text}") from None
    if columns != COLUMNS or table.ndim != 2 or table.shape[1:] != (len(COLUMNS),):
        raise RecordingError(f"{path.name}: its columns must be {', '.join(COLUMNS)}")
    if not np.isfinite(table[:, 0]).all() or not (np.diff(table[:, 0]) > 0.0).all():
        raise RecordingError(f"{path.name}: time_s must be finite and grow from row to row")
    return _split(table)


def _read_npz(content: bytes, _name: str) -> tuple[tuple[str, ...], np.ndarray]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        columns, values = (_member(archive, name) for name in ("columns", "values"))
    return tuple(str(name) for name in columns.tolist()), np.asarray(values, dtype=float)


def _member(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    """An array of the archive; a file of few bytes may unpack to many, or say that it does."""
    info = archive.getinfo(f"{name}.npy")
    if info.file_size > MOST_BYTES:
        raise ValueError(f"{name} unpacks to more than {MOST_BYTES / 1e6:g} MB")
    return np.lib.format.read_array(io.BytesIO(archive.read(info)), allow_pickle=False)


def _read_csv(content: bytes, name: str) -> tuple[tuple[str, ...], np.ndarray]:
    rows = list(csv.reader(io.StringIO(text_of(content, name), newline="")))
    if not rows:
        raise ValueError("it is empty")
    values = np.array([[float(cell) for cell in row] for row in rows[1:]], dtype=float)
    return tuple(rows[0]), values.reshape(-1, len(COLUMNS)) if values.size == 0 else values


def _split(table: np.ndarray) -> Recording:
    return Recording(table[:, 0], table[:, 1:4], table[:, 4:7])
