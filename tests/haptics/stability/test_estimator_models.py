"""Linear models of the velocity estimators against the estimators themselves, sample by sample."""

import numpy as np
import pytest

from haptics.control.filters import backward_difference, foaw, low_pass
from haptics.stability.estimator_models import LinearEstimator, linear_models
from tests.haptics.control.signals import velocities

T = 1e-3
RNG = np.random.default_rng(4)
WALK = np.cumsum(RNG.normal(size=400)) * 1e-4


def through(model: LinearEstimator, x: np.ndarray) -> np.ndarray:
    """The state space of a model, step by step, from rest at the first sample."""
    step, into, direct = model.realisation()
    w, out = np.zeros(len(step)), np.empty(len(x))
    for k, value in enumerate(x - x[0]):
        out[k] = (w[0] if len(w) else 0.0) + direct * value
        w = step @ w + into * value
    return out


@pytest.mark.parametrize("estimator", [backward_difference(T), low_pass(T, 60.0), low_pass(T, 5.0)])
def test_state_space_is_the_controllers_estimator(estimator) -> None:
    given = velocities(estimator, WALK)
    (model,) = linear_models(estimator)
    np.testing.assert_allclose(through(model, WALK), given, atol=1e-12 / T)  # rounding of the positions over T


@pytest.mark.parametrize("best", [False, True])
def test_adaptive_window_is_modelled_by_its_windows(best: bool) -> None:
    """A band that lets any line pass keeps the window at its longest: the last model, once the window is full."""
    estimator = foaw(T, 1.0, 12, best_fit=best)
    models = linear_models(estimator)
    assert [int(m.name.split()[-1]) for m in models] == [1, 2, 4, 8, 12]
    given = velocities(estimator, WALK)
    np.testing.assert_allclose(through(models[-1], WALK)[12:], given[12:], atol=1e-12 / T)


def test_window_of_a_power_of_two_is_modelled_once() -> None:
    assert [m.name for m in linear_models(foaw(T, 1.0, 4))] == ["end fit over 1", "end fit over 2", "end fit over 4"]


def test_response_follows_a_slow_motion_and_the_state_space() -> None:
    for model in (*linear_models(low_pass(T, 60.0)), *linear_models(foaw(T, 1.0, 8, best_fit=True))):
        slow = np.exp(1j * 1e-4)
        assert abs(model.response(np.array(slow)) / (1j * 1e-4 / T) - 1.0) < 1e-3  # lag of some samples times 1e-4
        step, into, direct = model.realisation()
        z = np.exp(1j * 0.7)
        state = np.linalg.solve(z * np.eye(len(step)) - step, into)
        np.testing.assert_allclose(model.response(np.array(z)), state[0] + direct, rtol=1e-10)


@pytest.mark.parametrize(
    ("numerator", "denominator", "says"),
    [
        ((), (1.0,), "finite"),
        ((1.0, float("nan")), (1.0,), "finite"),
        ((1.0, -1.0), (2.0,), "must be 1"),
        ((1.0, -1.0), (), "must be 1"),
        ((1.0, -0.5), (1.0,), "stands still"),
    ],
)
def test_coefficients_that_cannot_be_are_refused(numerator, denominator, says) -> None:
    with pytest.raises(ValueError, match=says):
        LinearEstimator("odd", numerator, denominator)
