"""The criterion on series whose answer is known."""

import numpy as np
import pytest

from haptics.stability.oscillation import oscillation

T, COUNT, WALL = 1e-3, 3e-5, 3000.0
TIME = np.arange(2000) * T


def judge(x: np.ndarray, **more):
    return oscillation(x, -WALL * np.maximum(x, 0.0), T, COUNT, **more)


def swing(amplitude: float, rate: float = 0.0, frequency: float = 20.0, phase: float = 0.0) -> np.ndarray:
    """Around 1 mm in the wall; `rate` in 1/s."""
    return 1e-3 + amplitude * np.exp(rate * TIME) * np.sin(2 * np.pi * frequency * TIME + phase)


def test_steady_cycle() -> None:
    found = judge(swing(2e-4))
    assert (found.kind, found.oscillates) == ("sustained", True)
    assert found.swing == pytest.approx(4e-4, rel=0.02)  # the line takes a little
    assert found.force_swing == pytest.approx(WALL * 4e-4, rel=0.02)
    assert found.frequency == pytest.approx(20.0, abs=1.0)  # one reversal in 0.5 s
    assert found.contact == 1.0


def test_growth_and_decay() -> None:
    assert judge(swing(2e-5, 2.0)).kind == "grows"
    assert judge(swing(2e-4, -2.0)).kind == "settles"  # falls to 0.37 a window
    assert judge(swing(2e-3, -0.7)).kind == "sustained"  # to 0.70: dies too slowly to be called settled
    assert judge(swing(2e-3, -0.7), decay=0.75).kind == "settles"


@pytest.mark.parametrize("frequency", [5.4, 50.0, 333.0])
def test_any_frequency_of_a_wall_is_seen_at_any_phase(frequency: float) -> None:
    for phase in np.linspace(0.0, 2 * np.pi, 24):
        found = judge(swing(2e-4, frequency=frequency, phase=phase))
        assert found.kind == "sustained"
        assert found.ratio == pytest.approx(1.0, abs=0.05)  # half of what growth begins at
        assert found.frequency == pytest.approx(frequency, abs=1.0)


def test_a_count_to_and_fro_is_quantisation() -> None:
    steps = 1e-3 + COUNT * (np.sin(2 * np.pi * 30.0 * TIME) > 0.0)
    found = judge(steps)
    assert found.kind == "settles"
    assert found.swing == pytest.approx(COUNT, rel=0.1)
    assert judge(steps, counts=0.5).kind == "sustained"


def test_creep_and_bends_are_no_oscillation() -> None:
    assert judge(1e-3 + 5e-4 * TIME).kind == "settles"
    assert judge(2e-3 - 1e-3 * np.exp(-TIME / 0.4)).kind == "settles"
    bend = judge(1e-3 + 2e-3 * (TIME - 1.0) ** 2)  # as much in both windows, and three counts and more
    assert (bend.kind, bend.swing > 3.0 * COUNT) == ("settles", True)
    assert bend.ratio == pytest.approx(1.0, abs=0.01)
    # a cycle on top of creep is one all the same
    assert judge(swing(2e-4) + 5e-4 * TIME).kind == "sustained"


def test_bounce_is_seen_with_its_contact() -> None:
    found = judge(swing(2e-3) - 1e-3)
    assert found.oscillates
    assert found.contact == pytest.approx(0.5, abs=0.02)


def test_handle_at_rest_settles_and_one_that_starts_grows() -> None:
    assert judge(np.full(len(TIME), 1e-3)).kind == "settles"
    x, push = np.zeros(len(TIME)), np.ones(len(TIME))
    still = oscillation(x, push, T, COUNT)
    assert (still.kind, still.swing, still.ratio) == ("settles", 0.0, 0.0)
    x[1500:] = swing(2e-4)[1500:]
    starts = oscillation(x, push, T, COUNT)
    assert (starts.kind, starts.ratio) == ("grows", np.inf)


def test_divergence() -> None:
    x = swing(2e-4)
    x[-3:] = np.nan
    found = oscillation(x, np.zeros(len(x)) + 1.0, T, COUNT)
    assert (found.kind, found.oscillates, found.contact) == ("diverged", True, 1.0)


def test_only_the_last_two_windows_count() -> None:
    x = swing(1e-2)
    x[1000:] = 1e-3
    assert judge(x).kind == "settles"


def test_refusals() -> None:
    x = swing(2e-4)
    with pytest.raises(ValueError, match=" 1 s"):
        oscillation(x, np.zeros(len(x)), T, COUNT)
    for short in (x[:999], x[:0]):
        with pytest.raises(ValueError, match="500 samples"):
            oscillation(short, short, T, COUNT)
    with pytest.raises(ValueError, match="500 samples"):
        oscillation(x, x[:-1], T, COUNT)
    for name in ("period", "resolution", "window"):
        with pytest.raises(ValueError, match=name):
            oscillation(x, x, **{"period": T, "resolution": COUNT, "window": 0.5, name: 0.0})
