"""The laid cable against a chain of cells, its friction added up cell by cell: pulled, worked, slipped, released."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import exp, pi, tanh

import numpy as np
import pytest

from delta_cad.drive.laid_cable import FRICTION, Arc, LaidCable

CELLS = 600
RIM, PINION, NOSE = 37.8, 7.79, 5.27
HALF, BEYOND, WRAP, FREE, OUT, ANCHOR = 1.037, 0.106, 18.43, 9.6, 7.2, 6.0
STOP = 0.98  # as far as the arm goes to either side


def cable(turned: float) -> LaidCable:
    one = np.ones(1)
    return LaidCable(
        outer=(Arc(RIM * (HALF + BEYOND + turned) * one, RIM), Arc(OUT * one)),
        pinion=Arc(WRAP * PINION * one, PINION),
        inner=(Arc(RIM * (HALF + BEYOND - turned) * one, RIM), Arc(NOSE * pi / 2 * one, NOSE), Arc(ANCHOR * one)),
        free_mm=FREE,
    )


@dataclass(frozen=True)
class Chain:
    """Cells along the cable from the pulled end; the tension of each is what it was stretched by when it last slid."""

    tension: np.ndarray
    friction: float

    def places(self, turned: float) -> tuple[np.ndarray, np.ndarray]:
        """Region of each cell, 0 to 7 from the carriage to the anchor, and how many radians it lies from a strand."""
        outer, inner = RIM * (HALF + BEYOND + turned), RIM * (HALF + BEYOND - turned)
        ends = np.cumsum([OUT, outer, FREE, WRAP * PINION, FREE, inner, NOSE * pi / 2, ANCHOR])
        at = (np.arange(CELLS) + 0.5) * ends[-1] / CELLS
        region = np.searchsorted(ends, at)
        angle = np.zeros(CELLS)
        for number, begins, radius, before in (
            (1, ends[1], -RIM, 0.0),
            (3, ends[2], PINION, 0.0),
            (5, ends[4], RIM, 0.0),
            (6, ends[5], NOSE, inner / RIM),
        ):
            there = region == number
            angle[there] = before + (at[there] - begins) / radius
        angle[region == 0] = outer / RIM
        angle[region == 7] = inner / RIM + pi / 2
        return region, angle

    def with_strands(self, turned: float, outer: float, inner: float) -> Chain:
        """Sets both strands; then friction, from either of them outwards, keeps each cell within what it can hold."""
        region, angle = self.places(turned)
        found = self.tension.copy()
        found[region == 2], found[region == 4] = outer, inner
        for there, strand, away in (
            (region <= 1, outer, angle),
            (region >= 5, inner, angle),
            (region == 3, outer, angle),
            (region == 3, inner, WRAP - angle),
        ):
            grown = np.exp(self.friction * away[there])
            found[there] = np.clip(found[there], strand / grown, strand * grown)
        return replace(self, tension=found)

    def balanced(self, turned: float, outer: float, inner: float) -> Chain:
        """Scales both strands' tensions until what is stretched in all is what it was: the ends do not move."""
        low, high = 0.0, 1e3 * float(self.tension.max())
        for _ in range(44):
            middle = (low + high) / 2.0
            over = self.with_strands(turned, middle * outer, middle * inner).tension.sum() > self.tension.sum()
            low, high = (low, middle) if over else (middle, high)
        return self.with_strands(turned, low * outer, low * inner)

    def worked(self, strokes: int, begins: float) -> Chain:
        """Moves the arm from stop to stop, the pinion free: both strands pull alike."""
        found = self
        for stroke in range(strokes):
            there = np.linspace(begins if stroke == 0 else -STOP, STOP, 10)
            for turned in (*there, *np.linspace(STOP, -STOP, 14)):
                found = found.balanced(float(turned), 1.0, 1.0)
        return found

    def slipped(self, turned: float, outer_tight: bool) -> Chain:
        grip = exp(self.friction * WRAP)
        return self.balanced(turned, *((grip, 1.0) if outer_tight else (1.0, grip)))

    def strands(self, turned: float) -> tuple[float, float]:
        region, _ = self.places(turned)
        return float(self.tension[region == 2].mean()), float(self.tension[region == 4].mean())


def pulled(turned: float, friction: float) -> Chain:
    """A slack cable pulled by 1 N at its carriage: each step along a drum takes `mu T dphi`."""
    chain = Chain(np.zeros(CELLS), friction)
    region, angle = chain.places(turned)
    found, strand = np.ones(CELLS), 1.0
    for k in range(1, CELLS):
        on_rim = region[k] == region[k - 1] == 1 or (region[k] in (5, 6) and region[k - 1] in (5, 6))
        turn = abs(angle[k] - angle[k - 1]) if on_rim else 0.0
        found[k] = found[k - 1] * (1.0 - friction * turn / 2.0) / (1.0 + friction * turn / 2.0)
        if region[k] == 2:
            strand = found[k]
        if region[k] == 3:  # the pinion turns: pulled from either side
            found[k] = strand * exp(-friction * min(angle[k], WRAP - angle[k]))
        if region[k] == 4:
            found[k] = strand
    return replace(chain, tension=found)


@pytest.mark.parametrize("friction", FRICTION)
@pytest.mark.parametrize("turned", [-0.9, 0.0, 0.9])
def test_what_is_pulled_at_the_carriage_falls_along_every_drum(friction: float, turned: float) -> None:
    found, along = cable(turned).pulled(2.0, friction), pulled(turned, friction)
    assert found["carriage"] == 2.0
    assert found["strands"] == pytest.approx(2.0 * along.strands(turned)[0], rel=0.01)
    assert found["anchor"] == pytest.approx(2.0 * along.tension[-1], rel=0.03)  # a cell's turn is lost at each border
    assert found["middle of the turns"] == pytest.approx(
        2.0 * along.tension[along.places(turned)[0] == 3].min(), rel=0.03
    )
    assert found["mean"] == pytest.approx(2.0 * along.tension.mean(), rel=0.01)


def test_by_euler_alone() -> None:
    """Pinion without rims or strands: half a turn holds e^(mu pi), and an even tension grows to its mean."""
    one, friction = np.ones(1), 0.2
    bare = LaidCable((Arc(0.0 * one),), Arc(10.0 * pi * one, 10.0), (Arc(0.0 * one),), 0.0)
    grip = exp(friction * pi)
    assert bare.grip(friction) == pytest.approx(grip)
    assert bare.held_N(friction, True)[0] == pytest.approx(
        friction * pi
    )  # (grip - 1) T of a mean (grip - 1) T / (mu pi)
    stiff = replace(bare, free_mm=1e9)  # all of the stretch is in the strands: halves of the difference
    assert stiff.strands_N(20.0, 8.0 * one, friction, True) == (pytest.approx(16.0), pytest.approx(24.0))
    assert stiff.held_N(friction, True)[0] == pytest.approx(2.0 * tanh(friction * pi / 2.0))


@pytest.mark.parametrize("friction", [FRICTION[0], 0.2, FRICTION[1]])
@pytest.mark.parametrize("outer_tight", [True, False])
def test_where_it_slips_does_not_depend_on_how_it_was_laid(friction: float, outer_tight: bool) -> None:
    """Even, or pulled at a carriage at either stop and worked: the difference is that of the closed form."""
    for turned in (-0.7, 0.3):
        expected = cable(turned).held_N(friction, outer_tight)[0]
        for begins in (None, -0.9, 0.9):
            laid = Chain(np.ones(CELLS), friction) if begins is None else pulled(begins, friction).worked(2, begins)
            outer, inner = laid.slipped(turned, outer_tight).strands(turned)
            assert abs(outer - inner) / laid.tension.mean() == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("friction", FRICTION)
def test_strands_under_a_difference_that_grows_step_by_step(friction: float) -> None:
    for turned, outer_tight in ((0.8, False), (-0.8, False), (0.0, True)):
        chain = Chain(np.full(CELLS, 20.0), friction)
        for more in np.linspace(1.0, 24.0, 24):
            low, high = 0.0, 20.0
            for _ in range(50):  # of the slack strand: what is stretched stays the same
                slack = (low + high) / 2.0
                pair = (slack + more, slack) if outer_tight else (slack, slack + more)
                over = chain.with_strands(turned, *pair).tension.sum() > chain.tension.sum()
                low, high = (low, slack) if over else (slack, high)
            chain = chain.with_strands(turned, *pair)
        outer, inner = chain.strands(turned)
        slack, tight = cable(turned).strands_N(20.0, np.array([24.0]), friction, outer_tight)
        assert (slack[0], tight[0]) == pytest.approx((min(outer, inner), max(outer, inner)), rel=0.01)


@pytest.mark.parametrize("friction", [FRICTION[0], 0.2, FRICTION[1]])
def test_released_and_worked_no_strand_has_more_than_half_of_what_both_had_as_it_slipped(friction: float) -> None:
    """The bound that the setting uses, which is largest where friction is least."""
    slipped = Chain(np.ones(CELLS), friction).slipped(0.2, True)
    outer, inner = slipped.strands(0.2)
    released = slipped.balanced(0.2, 1.0, 1.0)
    most = max(max(released.strands(0.2)), max(released.worked(2, 0.2).strands(-STOP)))
    bound = (outer - inner) / tanh(friction * WRAP / 2.0) / 2.0
    assert bound == pytest.approx((outer + inner) / 2.0, rel=1e-3)
    assert 0.5 * bound < most < bound
    least = (outer - inner) / tanh(FRICTION[0] * WRAP / 2.0) / 2.0
    assert bound <= least * (1.0 + 1e-12)


def test_more_friction_holds_more_and_its_share_at_another_angle_lies_between_those_of_the_band() -> None:
    frictions = np.linspace(*FRICTION, 9)
    here, there = ([float(cable(t).held_N(f, True)[0]) for f in frictions] for t in (-0.2, 0.9))
    assert np.all(np.diff(here) > 0.0)
    share = np.array(there) / here
    assert np.all(np.diff(share) < 0.0) or np.all(np.diff(share) > 0.0)
