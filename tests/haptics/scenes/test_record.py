"""Series as files read back by readers that are not the writer; a folder that appears whole or not at all."""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np
import pytest

from haptics.loop.simulation import SimulatedRun
from haptics.scenes.record import DECIMALS, Promise, Scene, series, write_csv, write_parquet

COLUMNS = {
    "time_s": np.array([-0.8, -0.799, 0.1 + 0.2]),
    "position_x_mm": np.array([1.0 / 3.0, -0.0, 5e-324]),
    "force_N": np.array([np.nan, 1e22, -1.7976931348623157e308]),
    "supervisor_bits": np.array([0, 1 << 25, 3]),
}


def test_csv_reads_back_to_the_same_doubles(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", COLUMNS)
    with (tmp_path / "a.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == list(COLUMNS)
    for name, column in COLUMNS.items():
        read = np.array([float(row[name]) for row in rows])
        assert np.array_equal(read, column.astype(float), equal_nan=True)
    assert rows[1]["supervisor_bits"] == str(1 << 25)


def test_parquet_reads_back_to_the_same_columns(tmp_path: Path) -> None:
    from pyarrow import parquet

    assert write_parquet(tmp_path / "a.parquet", COLUMNS)
    table = parquet.read_table(tmp_path / "a.parquet")
    assert table.column_names == list(COLUMNS)
    for name, column in COLUMNS.items():
        read = table[name].to_numpy()
        assert read.dtype == column.dtype
        assert read.tobytes() == column.tobytes()  # bit by bit: signs of zeros and NaN, too


def test_without_pyarrow_there_is_no_parquet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert not write_parquet(tmp_path / "a.parquet", COLUMNS)
    assert list(tmp_path.iterdir()) == []


def test_columns_carry_units_and_are_rounded_to_them() -> None:
    rng, n = np.random.default_rng(0), 5
    three = {name: rng.normal(size=(n, 3)) for name in ("position", "velocity", "measured", "estimated", "force")}
    more = {name: rng.normal(size=(n, 3)) for name in ("torque", "applied", "hand")}
    reading = {name: np.zeros((n, 3)) for name in ("angles", "rendered", "shoulders", "knob")}
    whole = {"bits": np.arange(n), "state": np.zeros(n), "fresh": np.zeros(n, dtype=int)}
    r = SimulatedRun(np.arange(n) * 1e-3, **three, **more, **reading, **whole, energy=np.zeros(n))
    columns = series(r, 0.002, r.force, distance_mm=np.full(n, 1.23456789))
    assert columns["time_s"].tolist() == [-0.002, -0.001, 0.0, 0.001, 0.002]
    assert columns["position_z_mm"] == pytest.approx(1000.0 * r.position[:, 2], abs=0.5e-5)
    assert columns["velocity_y_mm_per_s"] == pytest.approx(1000.0 * r.velocity[:, 1], abs=0.5e-3)
    assert columns["force_of_hand_x_N"] == pytest.approx(r.hand[:, 0], abs=0.5e-5)
    assert columns["torque_2_N_m"] == pytest.approx(r.applied[:, 2], abs=0.5e-7)
    assert columns["distance_mm"].tolist() == [1.23457] * n
    assert list(columns)[-1] == "supervisor_bits"
    assert all(name == "supervisor_bits" or name.endswith(tuple(DECIMALS)) for name in columns)


def test_a_scene_is_kept_if_all_its_promises_are() -> None:
    assert Scene("", "", [], {}, [Promise("a", True)], []).kept
    assert not Scene("", "", [], {}, [Promise("a", True), Promise("b", False)], []).kept
