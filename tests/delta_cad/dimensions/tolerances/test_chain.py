"""Sums of a chain against machines drawn at random, and against what a loosened link does."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isfinite

import numpy as np
import pytest

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.chain import Chain, Link, either_way
from delta_cad.dimensions.tolerances.machine import length_chains, machine_chains

MACHINES = 100_000
LINKS = (either_way("a", "x", "stated", 0.1, -2.0), Link("b", "y", "bought", -0.3, 0.0, 1.0))
CHAIN = Chain("c", "mm", 5.0, LINKS, 4.0, 6.0, "")


def test_sums_of_two_links() -> None:
    assert CHAIN.worst == pytest.approx((5.0 - 0.2 - 0.3, 5.0 + 0.2))
    assert CHAIN.rss == pytest.approx((4.85 - 0.25, 4.85 + 0.25))
    assert CHAIN.room == pytest.approx(0.5)
    assert CHAIN.holds
    assert not replace(CHAIN, high=5.19).holds
    assert replace(CHAIN, high=5.19, statistical=True).holds
    assert not replace(CHAIN, low=4.6001, statistical=True).holds


def test_every_chain_against_machines_drawn_at_random(best_dimensions: Dimensions) -> None:
    """Even deviations stay within the worst case; normal ones are within the sum of squares but for 0.27 %."""
    random = np.random.default_rng(12)
    for chain in [*machine_chains(best_dimensions), *length_chains(best_dimensions, "m")]:
        low, high = (np.array([getattr(link, f"{end}_mm") for link in chain.links]) for end in ("lower", "upper"))
        shares = np.array([link.share for link in chain.links])
        even = chain.nominal + random.uniform(low, high, (MACHINES, len(low))) @ shares
        assert chain.worst[0] <= even.min()
        assert even.max() <= chain.worst[1]
        normal = chain.nominal + random.normal((low + high) / 2, (high - low) / 6, (MACHINES, len(low))) @ shares
        off = np.mean((normal < chain.rss[0]) | (normal > chain.rss[1]))
        assert off == pytest.approx(0.0027, abs=6 * (0.0027 / MACHINES) ** 0.5), chain.name
        corners = chain.nominal + np.where(shares > 0, high, low) @ shares
        assert corners == pytest.approx(chain.worst[1])


@pytest.mark.parametrize("statistical", [False, True])
def test_a_link_or_all_that_is_made_may_be_as_loose_as_reported(statistical: bool, best_dimensions: Dimensions) -> None:
    """With it the chain just holds, with a little more it does not."""
    for given in machine_chains(best_dimensions):
        chain = replace(given, statistical=statistical)
        if not chain.holds:
            continue
        for which in [[link] for link in chain.links] + [
            [x for x in chain.links if x.kind in ("stated", "place", "general")]
        ]:
            factor = (
                chain.looser()
                if len(which) != 1
                else chain.largest_mm(which[0]) / ((which[0].upper_mm - which[0].lower_mm) / 2)
            )
            if not which or not isfinite(factor):
                continue
            for by, holds in ((0.999, True), (1.001, False)):
                links = tuple(_scaled(link, factor * by) if link in which else link for link in chain.links)
                assert replace(chain, links=links).holds is holds, (chain.name, which[0].what)


def _scaled(link: Link, factor: float) -> Link:
    middle, half = (link.lower_mm + link.upper_mm) / 2, (link.upper_mm - link.lower_mm) / 2
    return replace(link, lower_mm=middle - factor * half, upper_mm=middle + factor * half)


def test_without_bound_nothing_is_too_loose() -> None:
    assert replace(CHAIN, low=-inf, high=inf).looser() == inf
    assert replace(CHAIN, links=LINKS[1:]).looser() == inf
    assert CHAIN.largest_mm(replace(LINKS[0], share=0.0)) == inf
    assert replace(CHAIN, low=5.5).looser() == 0.0
