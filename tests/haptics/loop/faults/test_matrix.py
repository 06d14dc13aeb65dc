"""The matrix of faults, forces and motions: off in time where it is seen, in C as in Python, and the page of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from haptics.control.supervisor.faults import LATCHING, FaultCode, State
from haptics.firmware.precision import DOUBLE
from haptics.loop.choice import at_rate
from haptics.loop.simulation import Wrong
from tests.haptics.firmware.rig import ENABLED, Recorded, compile_host, reading_type, replay, write
from tests.haptics.loop.faults.matrix import (
    BEGIN,
    CASES,
    FORCES_N,
    MOTIONS,
    Case,
    FAST_s,
    device,
    judged,
    laws,
    run,
)
from tests.haptics.loop.faults.table import PAGE, computed

LONG_s = 0.1  # Looked on after the fault
MOST_FIRST = sorted(FORCES_N, key=lambda force: force not in (0.0, 6.0))
SEEN = [case for case in CASES if case.within is not None]


@pytest.mark.quick(2)
@pytest.mark.parametrize("force", MOST_FIRST)
@pytest.mark.parametrize("motion", MOTIONS)
def test_a_healthy_device_is_never_stopped(force: float, motion: str) -> None:
    record = run(force, motion, LONG_s)
    assert int(np.bitwise_or.reduce(record.bits)) & LATCHING == 0
    assert record.state[-1] == State.ACTIVE
    assert np.linalg.norm(record.force[BEGIN]) == pytest.approx(force, rel=0.35)  # a hand that moves along gives less


@pytest.mark.quick(2 * len(SEEN))
@pytest.mark.parametrize("force", MOST_FIRST)
@pytest.mark.parametrize("case", SEEN, ids=lambda case: case.name)
def test_the_force_is_off_in_time(case: Case, force: float) -> None:
    assert case.within is not None
    for motion in MOTIONS:
        found = judged(case, force, motion, LONG_s)
        assert found.off <= case.within, motion
        record = run(force, motion, LONG_s, case.fault)
        assert not np.any(record.rendered[BEGIN + round(found.off / record.time[1]) :])  # and stays off
        assert found.travel < (1e-3 if case.fault.wrong != Wrong.FULL else 0.02)


@pytest.mark.parametrize("name", ["one encoder frozen, reported as fresh", "all encoders frozen, reported as fresh"])
def test_at_a_kilohertz_a_frozen_encoder_is_found_in_time_as_well(name: str) -> None:
    case = next(case for case in CASES if case.name == name)
    assert judged(case, 6.0, "rest", LONG_s, at_rate(1000.0)).off <= FAST_s


def test_what_is_not_seen_is_what_the_page_says() -> None:
    """Of each fault that no check sees the mildest state; its worst stands on the page, which a slow test computes."""
    for case in CASES:
        if case.within is None:
            assert not np.isfinite(judged(case, 0.0, "rest", LONG_s).off), case.name


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compile_host(write(device()[1], DOUBLE, tmp_path_factory.mktemp("faults")))


@pytest.mark.quick(1)
@pytest.mark.parametrize("force", [6.0, *(force for force in FORCES_N if force != 6.0)])
def test_the_c_controller_gives_the_same_torques_in_the_same_loop(program: Path, force: float) -> None:
    """Bit for bit at each tick, so that the plant that they drive moves alike, too."""
    for case in CASES:
        for motion in MOTIONS:
            record = run(force, motion, LONG_s, case.fault)
            readings = np.zeros(len(record.time), reading_type("f8"))
            readings["now"], readings["theta"] = record.time, record.angles
            readings["fresh"], readings["request"][0] = record.fresh, ENABLED
            if case.fault.noticed:
                readings["signal"][BEGIN + case.fault.noticed :] = FaultCode.WATCHDOG.bit
            answers, _ = replay(program, Recorded(readings, laws(force)))
            assert np.array_equal(answers["torque"], record.torque), (case.name, motion)
            assert np.array_equal(answers["bits"], record.bits), (case.name, motion)


def test_the_page_has_the_limits_and_the_reactions() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert page == computed(page, "limits", "reactions")


@pytest.mark.slow
def test_the_page_has_the_matrix() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert page == computed(page, "matrix")
