"""The scene of noise: figures of its series, promises of the design's own encoder and what a coarse one does."""

from __future__ import annotations

import numpy as np
import pytest

from haptics.control.supervisor.faults import FaultCode
from haptics.loop.choice import BOARD
from haptics.loop.noise import FORCE, MOTION, BAND_Hz
from haptics.model.machine import MachineModel
from haptics.scenes.noise import READY, _felt, in_band, noise
from haptics.scenes.pictures import noise as picture
from haptics.scenes.pictures import spectrum
from haptics.scenes.record import Scene


@pytest.fixture(scope="module")
def scene(machine: MachineModel) -> Scene:
    return noise(machine)


def test_the_designs_own_encoder_keeps_its_promises(scene: Scene) -> None:
    assert scene.kept
    for run in scene.runs:
        f = run.facts
        if f["encoder"] == "own":
            assert f["force_N_rms"] <= FORCE
            assert f["motion_um_rms"] <= 1e6 * MOTION
            assert f["supervisor_bits"] == 0
            # friction that sticks is not in the prediction of the motion; the force is noise through the law
            assert f["force_N_rms"] == pytest.approx(f["force_predicted_N_rms"], rel=0.06)
            assert f["motion_um_rms"] == pytest.approx(f["motion_predicted_um_rms"], rel=0.5)


def test_who_feels_the_noise_is_said_by_its_motion(scene: Scene) -> None:
    motion = max(run.facts["motion_um_rms"] for run in scene.runs if run.facts["encoder"] == "own")
    assert f"{motion:.3f} um is {motion / 0.01:.1f} times the 0.01 um" in scene.discussion[0]
    assert "No hand is known to feel" in _felt(0.9e-8)


def test_a_coarse_encoder_is_too_loud_for_the_supervisor(scene: Scene) -> None:
    for run in scene.runs:
        if run.facts["encoder"] == "coarse":
            # by K more than by B, of which the law has little: 5 N/mm times some 70 um of noise are 0.35 N
            assert run.facts["force_predicted_N_rms"] > 9.0 * FORCE
            assert run.facts["supervisor_bits"] & (FaultCode.RAMP_HELD.bit | FaultCode.ENERGY_LIMITED.bit)
        if run.facts["encoder"] == "exact":
            assert run.facts["force_predicted_N_rms"] == 0.0
            assert run.facts["force_N_rms"] < 1e-3
    assert any("never comes in" in text or "takes" in text for text in scene.discussion)


def test_figures_are_those_of_the_series(scene: Scene) -> None:
    for run in scene.runs:
        force = np.column_stack([run.series[f"force_asked_{axis}_N"] for axis in "xyz"])
        deviations = force.std(axis=0)
        assert deviations.max() <= run.facts["force_N_rms"] * (1.0 + 1e-3) + 1e-5
        assert run.facts["force_N_rms"] <= np.linalg.norm(deviations) * (1.0 + 1e-3) + 1e-5
        assert run.series["time_s"][0] == pytest.approx(0.0, abs=BOARD.period)
        assert run.recording.time[0] == pytest.approx(READY)


def test_a_band_keeps_what_lies_in_it() -> None:
    t = np.arange(16_000) * BOARD.period
    tones = [np.sin(2.0 * np.pi * f * t) for f in (60.0, 300.0, 900.0)]
    kept = in_band(np.stack([sum(tones), tones[0]], axis=1), BOARD.period)
    assert kept[:, 0] == pytest.approx(tones[1][1600:-1600], abs=1e-9)
    assert np.abs(kept[:, 1]).max() < 1e-9
    assert BAND_Hz[0] < 300.0 < BAND_Hz[1]


def test_the_spectrum_holds_the_power_and_is_drawn(scene: Scene) -> None:
    series = np.random.default_rng(0).standard_normal(16_000)
    at, density = spectrum(series, BOARD.period)
    assert np.sqrt(np.sum(density**2) * (at[1] - at[0])) == pytest.approx(1.0, rel=0.02)
    figure = picture(scene, "device")
    figure.canvas.draw()
    assert [ax.get_title() for ax in figure.axes][::2] == ["held spring", "wall leant on"]
    labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert len(labels) == 3
    assert any("holds its force back" in label for label in labels)
