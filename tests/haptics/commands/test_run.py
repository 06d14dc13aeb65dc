"""The command `run`: every device, every scene, what it prints and writes, and what ends it."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from delta_cad.design import Design
from haptics.calibration.accuracy import accuracy
from haptics.calibration.fit import fit
from haptics.calibration.record import calibration_of, save_calibration
from haptics.commands.cli import main
from haptics.commands.run import SCENES, laws_of
from haptics.devices.recording import Recording, load_recording, save_recording
from haptics.loop.choice import at_rate
from haptics.loop.walls import WallStability
from haptics.model.plant import FREE
from tests.committed import BEST, ROOT
from tests.haptics.calibration.devices import cube_points, made, measured
from tests.haptics.devices.served import served
from tests.haptics.scene_machine import scene_machine
from tests.optimizer.certify.designs import masses
from tests.terminal import said


@pytest.fixture
def weights(best: Design, tmp_path: Path) -> Path:
    return masses(tmp_path, best, 1e-5)


def ran(capsys: pytest.CaptureFixture[str], weights: Path, *more: object) -> tuple[int, dict]:
    code = main(["run", "--design", str(BEST), "--masses", str(weights), "--json", *map(str, more)])
    out = capsys.readouterr().out
    return code, json.loads(out) if out else {}


@pytest.mark.parametrize("scene", SCENES)
def test_every_scene_runs_on_the_simulated_device(
    best: Design, weights: Path, capsys: pytest.CaptureFixture[str], scene: str
) -> None:
    code, facts = ran(capsys, weights, "--scene", scene, "--seconds", 1.0, "--fast")
    assert (code, facts["passed"], facts["faults"], facts["ticks"]) == (0, True, [], 1001)
    assert (facts["largest_force_N"] > 0.05) == (scene != "none")
    off = np.array(facts["position_mm"]) - [0.0, 0.0, best.cube.bottom_height_mm + best.cube.half_side_mm]
    assert 1.0 < np.abs(off).max() < best.cube.half_side_mm


def test_what_it_recorded_is_replayed(weights: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept = tmp_path / "kept.npz"
    code, first = ran(capsys, weights, "--seconds", 0.7, "--fast", "--record", kept)
    assert (code, len(load_recording(kept).time)) == (0, 701)
    code, again = ran(capsys, weights, "--device", "recorded", "--recording", kept)
    assert (code, again["ticks"]) == (0, 701)
    np.testing.assert_allclose(again["position_mm"], first["position_mm"], atol=1e-9)
    assert again["largest_force_N"] == pytest.approx(first["largest_force_N"], rel=1e-6)


def test_a_board_is_driven(best: Design, weights: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with served(scene_machine(best)) as up:
        code, facts = ran(capsys, weights, "--device", "socket", "--port", up.port, "--timeout", 20, "--seconds", 0.3)
        assert not up.device.torques.any()
    assert (code, facts["lost"], facts["ticks"]) == (0, None, 301)


def test_a_fault_is_reported_and_exits_1(weights: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    angles = np.zeros((900, 3)) + 1e-5 * (np.arange(900) % 2)[:, None]
    angles[700] = np.nan
    bad = tmp_path / "bad.csv"
    save_recording(Recording(np.arange(900) * 1e-3, angles, np.zeros((900, 3))), bad)
    code, facts = ran(capsys, weights, "--device", "recorded", "--recording", bad, "--scene", "none")
    assert code == 1
    assert "ANGLE_INVALID" in facts["faults"]


def test_a_calibration_moves_what_is_read(
    best: Design, weights: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(1)
    device = made(best, rng)
    found = fit(best.geometry, measured(device, cube_points(best, rng, 60), rng))
    save_calibration(calibration_of(best, found, 60, accuracy(found, best)), tmp_path / "calibration.json")
    point = cube_points(best, rng, 1, 0.3)
    from tests.haptics.calibration.devices import readings

    noise = rng.normal(0.0, math.radians(0.0015), (300, 3))  # of the default encoder: a reading that repeats is a fault
    still = Recording(np.arange(300) * 1e-3, readings(device, point) + noise, np.zeros((300, 3)))
    save_recording(still, tmp_path / "still.npz")
    off = []
    for more in ((), ("--calibration", tmp_path / "calibration.json")):
        code, facts = ran(
            capsys, weights, "--device", "recorded", "--recording", tmp_path / "still.npz", "--scene", "none", *more
        )
        assert code == 0
        off.append(float(np.linalg.norm(np.array(facts["position_mm"]) - 1e3 * point[0])))
    assert off[1] < 0.1 * off[0]


def test_ctrl_c_ends_it_with_force_zero(best: Design, weights: Path) -> None:
    with served(scene_machine(best)) as up:
        command = [sys.executable, "-m", "haptics", "run", "--design", BEST, "--masses", weights, "--device", "socket"]
        process = subprocess.Popen(
            [*map(str, command), "--port", str(up.port), "--timeout", "20"], stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, text=True, cwd=ROOT, env=os.environ | {"PYTHONPATH": str(ROOT)},
        )  # fmt: skip
        try:
            end = time.monotonic() + 120.0
            while up.board.served < 300 and process.poll() is None and time.monotonic() < end:
                time.sleep(0.02)
            assert up.device.torques.any()
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=60)
        finally:
            process.kill()
            process.communicate()
        assert (process.returncode, said(err)) == (0, "")
        assert "Ctrl-C" in out
        assert not up.device.torques.any()
        assert not up.board.connected


def test_a_board_that_goes_away_is_reported(best: Design, weights: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with served(scene_machine(best)) as up:
        real, count = up.device.read, 0

        def read():
            nonlocal count
            count += 1
            if count == 100:
                up.board.end()
            return real()

        up.device.read = read  # type: ignore[method-assign]
        code, facts = ran(capsys, weights, "--device", "socket", "--port", up.port, "--timeout", 0.3)
    assert code == 1
    assert facts["lost"]
    assert "DEVICE_LOST" in facts["faults"] or facts["ticks"] < 120


@pytest.mark.parametrize("scene", ["spring", "home", "resistance"])
def test_a_spring_is_half_of_what_stands_in_the_softest_corner_without_a_wall(best: Design, scene: str) -> None:
    machine, loop = scene_machine(best), at_rate(1000.0)
    corner = machine.centre + machine.half_side * np.array([-1.0, 1.0, 1.0])
    free = replace(loop, contact_damping=loop.drive_damping)
    at = WallStability(machine, free, corner, (1.0, 0.0, 0.0), place=0, delay=loop.delays[2] * loop.period)
    assert 10.0 < laws_of(machine, scene, loop).stiffness <= 0.5 * at.stable(FREE)
