"""The manufacturing rules over all machined parts, each with the worst part and place."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from delta_cad.checks.dfm.bores import Finding, depths, odd_sizes, run_outs, unreached
from delta_cad.checks.dfm.corners import corner_radii, sharp_corners
from delta_cad.checks.dfm.setups import setups
from delta_cad.checks.dfm.threads import thread_walls
from delta_cad.checks.dfm.walls import undercuts, walls
from delta_cad.checks.report import CheckResult
from delta_cad.solids.part import Part

SHOWN = 8  # faults that a report names; their number is told
ROUNDING = 1e-9


@dataclass(frozen=True)
class Rule:
    """A rule of a shop.

    Attributes:
        name: Of its result.
        find: Findings of a part.
        unit: Of figure and limit.
        what: What is measured, a few words.
        counts: Whether the figure is the number of findings, of which none is allowed.
    """

    name: str
    find: Callable[[Part], Iterator[Finding]]
    unit: str
    what: str
    counts: bool = False


RULES = (
    Rule("dfm corners", sharp_corners, "", "inner corners without a radius along a milling axis", counts=True),
    Rule("dfm corner radii", corner_radii, "", "deepest inner corner in diameters of its cutter"),
    Rule("dfm walls", walls, "mm", "thinnest wall"),
    Rule("dfm thread walls", thread_walls, "mm", "thinnest wall beside a thread"),
    Rule("dfm bore depth", depths, "", "bore or thread deepest for its diameter"),
    Rule("dfm run-out", run_outs, "mm", "shortest run-out of a blind thread for its pitch"),
    Rule("dfm sizes", odd_sizes, "", "bores of a size for which there is no drill", counts=True),
    Rule("dfm reach", unreached, "", "bores to which no straight tool comes", counts=True),
    Rule("dfm undercuts", undercuts, "", "faces to which no straight tool comes", counts=True),
    Rule("dfm setups", setups, "", "clampings of a part"),
)
"""All rules, in the order of the report."""


def check_dfm(parts: Iterable[Part]) -> list[CheckResult]:
    """Holds every part that is made against the rules of a shop.

    Args:
        parts: With valid solids; those that are bought are left out.

    Returns:
        One result a rule, named `dfm ...`, with the worst figure of all parts.
    """
    made = [part for part in parts if part.make]
    return [_result(rule, [finding for part in made for finding in rule.find(part)], len(made)) for rule in RULES]


def _result(rule: Rule, findings: list[Finding], parts: int) -> CheckResult:
    findings.sort(key=lambda finding: -finding.share)
    bad = [finding for finding in findings if finding.share > 1.0 + ROUNDING]
    shown = [finding.where for finding in (bad[:SHOWN] or findings[:1])]
    told = f"{f'{len(bad)} fail' if bad else 'worst'}: {'; '.join(shown)}; " if shown else ""
    value, limit = (findings[0].value, findings[0].limit) if findings else (None, None)
    if rule.counts:
        value, limit = float(len(bad)), 0.0
    pair = (findings[0].part,) if findings else None
    return CheckResult(
        rule.name, not bad, value, limit, rule.unit, worst_pair=pair, detail=f"{rule.what}; {told}{parts} parts"
    )
