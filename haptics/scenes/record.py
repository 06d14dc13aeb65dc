"""Results of a scene: runs with time series and figures, properties that hold or not, and a discussion.

Time series as files: CSV for everybody, parquet where pyarrow is installed; both hold the same doubles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from haptics.control.supervisor.faults import LATCHING, described
from haptics.loop.simulation import SimulatedRun

# Decimals that the series keep of each unit: 10 nm, 10 uN, a thousandth of what encoders and motors resolve. More
# digits would only be more bytes.
DECIMALS = {"_s": 6, "_mm": 5, "_N": 5, "_N_m": 7, "_mm_per_s": 3}


@dataclass(frozen=True)
class SceneRun:
    """One run of a scene.

    Attributes:
        name: Name of the run's files: letters, digits, dot, dash, underscore, plus.
        label: What a person reads.
        recording: What happened.
        series: Name with its unit -> (n,) column; see `series`.
        facts: Name with its unit -> figure, what the run came to.
    """

    name: str
    label: str
    recording: SimulatedRun
    series: dict[str, np.ndarray]
    facts: dict[str, Any]


@dataclass(frozen=True)
class Promise:
    """Something that a design should hold in a scene.

    Attributes:
        text: What, with its figures.
        kept: Whether it does.
    """

    text: str
    kept: bool


@dataclass(frozen=True)
class Scene:
    """Results of a scene.

    Attributes:
        name: Name of the scene.
        figures: The paper's figures that it stands beside.
        runs: Runs in the order simulated.
        facts: Common to all runs.
        promises: Those that decide the exit code.
        discussion: Sentences: what differs from the paper, and why.
    """

    name: str
    figures: str
    runs: list[SceneRun]
    facts: dict[str, Any]
    promises: list[Promise]
    discussion: list[str]

    @property
    def kept(self) -> bool:
        """Whether all promises are kept."""
        return all(promise.kept for promise in self.promises)


def series(recording: SimulatedRun, begin: float, force: np.ndarray, **more: np.ndarray) -> dict[str, np.ndarray]:
    """The columns of a run's table, each rounded to the `DECIMALS` of its unit.

    Args:
        recording: What happened.
        begin: When the scene proper begins, s; time is counted from there.
        force: (n, 3) force on the handle of what the motors give beyond the weight, N.
        **more: (n,) further columns, their units in their names.

    Returns:
        Name -> (n,) column; the supervisor's bits last, as whole numbers.
    """
    columns = {"time_s": recording.time - begin}
    for name, unit, array in (
        ("position", "mm", MM_PER_M * recording.position),
        ("velocity", "mm_per_s", MM_PER_M * recording.velocity),
        ("force_asked", "N", recording.force),
        ("force_of_motors", "N", force),
        ("force_of_hand", "N", recording.hand),
    ):
        columns |= {f"{name}_{axis}_{unit}": array[:, k] for k, axis in enumerate("xyz")}
    columns |= {f"torque_{i}_N_m": recording.applied[:, i] for i in range(3)}
    columns |= more
    return {name: np.round(column, _decimals(name)) + 0.0 for name, column in columns.items()} | {
        "supervisor_bits": recording.bits
    }


def _decimals(name: str) -> int:
    return DECIMALS[max((unit for unit in DECIMALS if name.endswith(unit)), key=len)]


def supervised(recording: SimulatedRun, begin: float) -> dict[str, Any]:
    """Findings of the supervisor from the beginning of the scene proper.

    Args:
        recording: What happened.
        begin: s.

    Returns:
        Whether it latched a fault, and its findings as text.
    """
    bits = int(np.bitwise_or.reduce(recording.bits[recording.time > begin]))
    return {"supervisor_fault": bool(bits & LATCHING), "supervisor_findings": described(bits)}


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
