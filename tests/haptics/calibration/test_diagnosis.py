"""Files of poses with one error each, which is named; and poses of which none is wrong, of which nothing is named."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from delta_cad.design import Design, design_from_dict, load_design
from haptics.calibration.diagnosis import Cause, causes, fits
from haptics.calibration.fit import Fit, FitError, Noise, fit
from haptics.calibration.poses import Poses
from tests.committed import BEST
from tests.designs import placed
from tests.haptics.calibration.devices import cube_points, made, measured

NOISE = Noise(0.02e-3, 5e-5)
COUNT = 2.0 * math.pi / 2**14


@cache
def design() -> Design:
    return load_design(BEST)


@cache
def good() -> Poses:
    rng = np.random.default_rng(5)
    return measured(made(design(), rng), cube_points(design(), rng, 40), rng)


def named(poses: Poses, own_frame: bool = False, of: Design | None = None) -> list[Cause]:
    """The causes of a misfit, or of a refusal; the poses do not fit as they are."""

    g = (of or design()).geometry

    def refit(changed: Poses, own: bool) -> Fit:
        return fit(g, changed, noise=NOISE, own_frame=own)

    try:
        failed: Fit | FitError = refit(poses, own_frame)
        assert isinstance(failed, Fit)
        assert not fits(failed)
    except FitError as error:
        failed = error
    return causes(refit, poses, own_frame, failed, COUNT, g.three_fold)


def moved(k: int, *mm: float) -> Poses:
    positions = good().positions.copy()
    positions[k] += np.array(mm) / 1e3
    return replace(good(), positions=positions)


def exchanged(i: int, j: int) -> Poses:
    positions = good().positions.copy()
    positions[[i, j]] = positions[[j, i]]
    return replace(good(), positions=positions)


def times(positions: float = 1.0, readings: float = 1.0) -> Poses:
    return Poses(positions * good().positions, readings * good().readings)


ERRORS = {
    "metres": (lambda: times(positions=1e-3), "unit", "in metres"),
    "inches": (lambda: times(positions=1.0 / 25.4), "unit", "in inches"),
    "radians": (lambda: times(readings=math.radians(1.0)), "unit", "in radians"),
    "counts": (lambda: times(readings=math.radians(1.0) / COUNT), "unit", "in counts"),
    "other sense": (lambda: times(readings=-1.0), "sign", "readings fall"),
    "z downwards": (lambda: replace(good(), positions=good().positions * [1.0, 1.0, -1.0]), "sign", "z_mm falls"),
    "chains": (lambda: replace(good(), readings=good().readings[:, [1, 0, 2]]), "columns", "0_deg holds reading_1_deg"),
    "turned chains": (
        lambda: replace(good(), readings=good().readings[:, [1, 2, 0]]),
        "columns",
        "reading_0_deg holds reading_1_deg, reading_1_deg holds reading_2_deg, reading_2_deg holds reading_0_deg",
    ),
    "axes": (lambda: replace(good(), positions=good().positions[:, [1, 0, 2]]), "columns", "x_mm holds y_mm"),
    "frame": (lambda: replace(good(), positions=good().positions - [0.1, 0.2, 0.3]), "frame", "--frame own"),
    "label": (lambda: moved(7, 0.0, 3.0, 0.0), "label", "pose 8 has"),
    "label out of reach": (lambda: moved(3, 0.0, 0.0, 400.0), "label", "pose 4 has"),
    "labels": (lambda: exchanged(4, 20), "label", "poses 5 and 21 have each other's position"),
}


@pytest.mark.parametrize("kind", ERRORS)
def test_an_error_of_a_file_is_named(kind: str) -> None:
    make, expected, words = ERRORS[kind]
    first, *_ = named(make())
    assert (first.kind, first.misfit < 1.5) == (expected, True)
    assert words in first.text


def test_mirror_images_are_named_where_the_frame_is_free() -> None:
    (only,) = named(replace(good(), readings=good().readings[:, [1, 0, 2]]), own_frame=True)
    assert only.kind == "columns"
    assert "mirror images" in only.text


@pytest.mark.parametrize("order", [(1, 2, 0), (0, 2, 1)])
def test_readings_of_other_chains_are_named_where_chains_are_placed_and_the_frame_is_free(
    order: tuple[int, int, int],
) -> None:
    """Free lengths fit the poses of a machine turned by a chain, but to a machine that nobody drew."""
    machine, rng = design_from_dict(placed()), np.random.default_rng(5)
    poses = measured(made(machine, rng), cube_points(machine, rng, 40), rng)
    found = named(replace(poses, readings=poses.readings[:, list(order)]), own_frame=True, of=machine)
    holds = ", ".join(f"reading_{k}_deg holds reading_{n}_deg" for k, n in enumerate(order) if k != n)
    assert any(cause.text == f"columns are swapped: {holds}" for cause in found)


def test_noise_beyond_what_was_stated_has_no_cause() -> None:
    rng = np.random.default_rng(6)
    noisy = replace(good(), positions=good().positions + rng.normal(0.0, 0.2e-3, good().positions.shape))
    assert named(noisy) == []
