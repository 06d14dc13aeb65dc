"""Time series as files: CSV for everybody, parquet where pyarrow is installed; both hold the same doubles."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path

import numpy as np


def write_csv(path: Path, columns: Mapping[str, np.ndarray]) -> None:
    """Writes columns under their names, each figure with the fewest digits that read back to the same double.

    Args:
        path: File to write.
        columns: Name -> (n,) numbers.
    """
    texts = [map(repr, column.tolist()) for column in columns.values()]
    with path.open("w", encoding="ascii", newline="") as file:
        file.write(",".join(columns) + "\n")
        file.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))


def write_parquet(path: Path, columns: Mapping[str, np.ndarray]) -> bool:
    """Writes the same as parquet.

    Args:
        path: File to write.
        columns: Name -> (n,) numbers.

    Returns:
        Whether pyarrow is there; without it nothing is written.
    """
    try:
        pa, pq = import_module("pyarrow"), import_module("pyarrow.parquet")
    except ModuleNotFoundError:
        return False
    pq.write_table(pa.table(dict(columns)), path)
    return True
