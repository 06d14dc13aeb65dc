"""Which loop a device has: option over design file over the board loop, and the design file that says it."""

from __future__ import annotations

import pytest

from delta_cad.design import Design, DesignError, Loop, design_from_dict, design_hash, design_to_dict
from haptics.loop.choice import BOARD, DAMPED, PAPER, LoopChoice, at_rate, chosen_loop, other_drives


def with_loop(best: Design, **loop: float) -> Design:
    return best.model_copy(update={"loop": Loop(**loop)})


def test_by_default_drives_add_no_damping(best: Design) -> None:
    assert best.loop is None
    assert chosen_loop(best) == BOARD
    assert (BOARD.drive_damping, BOARD.contact_damping) == (0.0, 0.0)
    assert other_drives(BOARD) == DAMPED
    assert other_drives(DAMPED) == BOARD


def test_an_option_goes_before_the_file_and_the_file_before_the_default(best: Design) -> None:
    file = with_loop(best, rate_Hz=4000.0, delay_ticks=1.0, damping_N_s_m=1.0, drive_damping=0.3)
    found = chosen_loop(file)
    assert (1.0 / found.period, found.delays, found.damping) == (4000.0, (0.5, 1.0, 1.5), 1.0)
    assert (found.drive_damping, found.contact_damping) == (0.1, 0.3)
    option = chosen_loop(file, 2000.0, 0.5, 0.0)
    assert (1.0 / option.period, option.damping, option.contact_damping) == (2000.0, 0.5, 0.0)
    assert option.drive_damping == 0.0
    assert option.delays == found.delays
    assert chosen_loop(with_loop(best, drive_damping=0.62)) == DAMPED
    assert chosen_loop(with_loop(best, drive_damping=0.05)).drive_damping == 0.05  # no more elsewhere than at a wall
    assert chosen_loop(best, 1000.0) == at_rate(1000.0)


@pytest.mark.parametrize("loop", [PAPER, BOARD, DAMPED, at_rate(1000.0)])
def test_a_loop_is_named_with_what_decides_its_walls(loop: LoopChoice) -> None:
    """Two loops of 1 kHz have two names."""
    assert loop.label.startswith(f"{loop.name} loop, {1e-3 / loop.period:g} kHz, delay {1e3 * loop.delay:.3g} ms")
    assert f"wall damping {loop.damping:g} N s/m" in loop.label
    assert ("no damping" in loop.label) == (loop.contact_damping == 0.0)
    assert PAPER.label != at_rate(1000.0).label


def test_a_loop_is_no_part_of_what_is_built(best: Design) -> None:
    chosen = with_loop(best, rate_Hz=4000.0)
    assert design_hash(chosen) == design_hash(best)
    assert design_from_dict(design_to_dict(chosen)) == chosen


@pytest.mark.parametrize(
    ("entry", "says"),
    [
        ({"rate_Hz": 50}, "design: loop.rate_Hz = 50: must be >= 100 and <= 100000 Hz"),
        ({"delay_ticks": 5}, "design: loop.delay_ticks = 5: must be >= 0 and <= 4 ticks"),
        ({"damping_N_s_m": -1}, "design: loop.damping_N_s_m = -1: must be >= 0 and <= 100 N s/m"),
        ({"drive_damping": 1.5}, "design: loop.drive_damping = 1.5: must be >= 0 and <= 1"),
        ({"rate": 1}, "design: loop.rate = 1: "),
    ],
)
def test_a_loop_out_of_bounds_is_refused_by_name(best: Design, entry: dict[str, float], says: str) -> None:
    with pytest.raises(DesignError) as refused:
        design_from_dict(design_to_dict(best) | {"loop": entry})
    assert str(refused.value).startswith(says)
