"""Tolerance chains of a machine against what they may be, and what its lengths come to."""

from __future__ import annotations

from math import inf

from delta_cad.checks.report import CheckResult
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.chain import Chain
from delta_cad.dimensions.tolerances.general import CLASSES, NOTES
from delta_cad.dimensions.tolerances.machine import (
    deviation_mm,
    general_class,
    length_chains,
    loosest_class,
    machine_chains,
)

_LARGEST = 3  # links that a report names


def check_tolerances(d: Dimensions) -> list[CheckResult]:
    """Checks the chains of a machine.

    Args:
        d: Its dimensions.

    Returns:
        One result a chain, named `tolerance ...`; the general class with which all hold, as its place among the known
        ones; and the largest deviation of the mechanism's lengths, which is told alone.
    """
    general = general_class(d)
    return [*map(check_chain, machine_chains(d, general)), _class(d), _lengths(d, general)]


def check_chain(chain: Chain) -> CheckResult:
    """Checks one chain: the end of the range that decides which is nearest to its bound."""
    low, high = chain.decides
    below = low - chain.low <= chain.high - high
    value, limit = (low, chain.low) if below else (high, chain.high)
    largest = sorted(chain.links, key=lambda link: -link.half)[:_LARGEST]
    most = ", ".join(f"{link.part} {link.what} {link.half:.3g}" for link in largest)
    (a, b), (r, s) = chain.worst, chain.rss
    looser = chain.looser()
    margin = "" if looser == inf else f"; what a shop is asked for may be {looser:.2g} times as loose"
    by = "99.73 % of machines decide" if chain.statistical else "the worst case decides"
    detail = (
        f"nominal {chain.nominal:.3g} {chain.unit}, worst case {a:.3g} to {b:.3g}, by the sum of squares {r:.3g} to "
        f"{s:.3g}; {by}; most by {most} {chain.unit} either way{margin}; {chain.why}"
    )
    pair = tuple(link.part for link in largest[:1])
    return CheckResult(f"tolerance {chain.name}", chain.holds, value, limit, chain.unit, worst_pair=pair, detail=detail)


def _class(d: Dimensions) -> CheckResult:
    loosest, required = loosest_class(d), general_class(d)
    what = (
        "none of f, m and c is fine enough"
        if loosest is None
        else f"the loosest with which all chains hold is {loosest}"
    )
    detail = f"{NOTES[required]} is asked for where nothing is stated; {what}"
    value = 0.0 if loosest is None else float(1 + CLASSES.index(loosest))
    return CheckResult(
        "tolerance general class", loosest is not None, value, 1.0 + CLASSES.index(required), "", detail=detail
    )


def _lengths(d: Dimensions, general: str) -> CheckResult:
    chains = {chain.name: deviation_mm(chain) for chain in length_chains(d, general)}
    worst = max(chains, key=lambda name: chains[name])
    reported = ", ".join(f"{name} {value:.3f}" for name, value in chains.items())
    detail = (
        f"worst case, either way, mm: {reported}; `certify --tolerance parts` proves the cube for all such machines"
    )
    return CheckResult("tolerance of the lengths", True, chains[worst], None, "mm", detail=detail)
