"""The sentences about the recomputed tables, and the numbers in them, computed from the runs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from typing import Any, NamedTuple

from optimizer.paper.evaluation import Evaluation
from optimizer.paper.published import EXCHANGED_H, STEP_3_HALF_SIDE_MM, numbers
from optimizer.paper.reproduction import AGREEMENT, METHODS, ReproducedRun
from optimizer.search.result import finite

Runs = list[ReproducedRun]
LONGER_FOREARM = ("table 7 row 1", "table 7 row 2")  # their bounds differ in the largest L_B alone
SMALL = 1e-5  # shares below it are written as powers of ten
VERDICT = (
    "Step 1 {step_1}: the {count} printed half sides differ by at most {off:.2f} % from those that the printed L_B, R "
    "and r allow (worst {worst}); they are at most {below:.2f} % below the proven optimum under the same bounds.",
    "Step 2 {step_2}: by the paper's own equations the published designs need {torque:.3f} N m for {force_N:g} N, so "
    "that the limit of {joint_torque_N_m:g} N m does not bind; under the same bounds and limits half sides of "
    "{best_sides:.2f} mm are possible where {printed_sides:.1f} mm are printed.",
    "Step 3 {step_3}: for condition numbers printed as {printed_kappas:.3f} the paper's equations give {kappas:.3f} "
    "(2-norm; {frobenius:.3f} in Frobenius's), and the proven optimum is {best_kappas:.3f}: the published designs are "
    "{above:.1f} % above it.",
)
# A sentence whose numbers are not there, because no run gives them, is left out.
NOTES = (
    "Outside {agreement:.1f} %, and within it only with half of the last printed digit added, which shows nothing but "
    "that print is no finer. {rounded}.",
    "Why step 1 alone is no design: its proven optima lie within {fold_mm:.1e} mm of H = L_B - L_A with R - r within "
    "{radii_mm:.1e} mm of 0, where upper arm and forearm fold in line above the base's centre. There the condition "
    "number has no bound (infinite over the cube in {infinite} of {step_1_runs} rows of ours).",
    "{missing} published designs of step 1 miss the reach as printed, by {missed:.3f} mm of forearm: an optimum on the "
    'fold does not bear the rounding of H and L. So the column "its lengths allow" leaves H free within its bounds.',
    "Table 9: the H of two rows look exchanged in print: {exchanged}.",
    '{feasible} of the {unsolved} runs for which the paper has "no results" have feasible designs, so that it was the '
    "solver that failed; from the same starts our SQP gives: {solved}.",
    "Why step 2 wants a limit on kappa: the largest cubes within the torque have a worst kappa of {least_ridge:.1f} to "
    "{largest_ridge:.0f}{against}. Torque alone does not see a fold, where it vanishes.{longer}",
    "What SQP takes off the GA's condition number in table 12: {second_method}.",
    "Distance of our methods from the certified optimum over all rows: {distances}.",
    "The paper prints no L for step 3. {side_mm:g} mm is taken, half the side of its prototype's cube of {cube_mm:g} "
    "mm. Cubes on the same bottom face contain each other, so that a larger L gives no smaller condition number, "
    "neither for the published design nor for the optimum.",
)


class Span(NamedTuple):
    """The smallest and the largest of some numbers; formatted like one where both look the same."""

    low: float
    high: float

    def __format__(self, form: str) -> str:
        return " to ".join(dict.fromkeys(format(end, form) for end in self))


def percent(share: float, digits: int = 2) -> str:
    """Writes a share as a percentage."""
    return f"{100.0 * share:.{digits}f} %"


def signed(share: float | None) -> str:
    """Writes a share as a percentage with its sign."""
    return f"{100.0 * (share or 0.0):+.2f} %"


def summary(runs: Runs) -> str:
    """Writes the verdict in one line."""
    parts = []
    for step in (1, 2, 3):
        if mine := _compared(runs, step):
            off = "" if all(r.agrees for r in mine) else f" (off by up to {percent(_largest(mine), 1)})"
            parts.append(f"step {step} {_reproduces(mine)}{off}")
    text = ", ".join(parts)
    return f"{text[:1].upper()}{text[1:]}." if text else "No published result is among these tables."


def statements(runs: Runs, sentences: tuple[str, ...]) -> list[str]:
    """Fills in the sentences of `VERDICT` or `NOTES` that the runs give the numbers for."""
    known, complete = figures(runs), []
    for sentence in sentences:
        try:
            complete.append(sentence.format(**known))
        except KeyError:
            continue
    return complete


def figures(runs: Runs) -> dict[str, Any]:
    """Computes the numbers of the sentences by name; shares in per cent; only those that the runs give."""
    known: dict[str, Any] = {"agreement": 100.0 * AGREEMENT, **_differences(runs), **_of_our_methods(runs)}
    if designs := [r.proven.design_mm for r in runs if r.run.step == 1 and r.proven.design_mm]:
        kappas = [_kappa(r) for r in runs if r.run.step == 1]
        known |= {"fold_mm": max(abs(H - (L_B - L_A)) for L_A, L_B, _, _, H, _ in designs)}
        known |= {"radii_mm": max(abs(R - r) for _, _, R, r, _, _ in designs)}
        known |= {"infinite": kappas.count(None), "step_1_runs": len(kappas)}
    own = [r.published for r in runs if r.run.step == 1 and r.published and (r.run.table, r.run.row) not in EXCHANGED_H]
    if missed := [fault.by for published in own for fault in published.faults if fault.name == "reach"]:
        known |= {"missing": len(missed), "missed": _span(missed)}
    if exchanged := [
        f"row {r.run.row} misses {_missed(r.published)} as printed, {_missed(r.exchanged)} with the other's H"
        for r in runs
        if r.exchanged and r.published
    ]:
        known["exchanged"] = "; ".join(exchanged)
    if any(r.run.step == 3 for r in runs):
        known |= {"side_mm": STEP_3_HALF_SIDE_MM, "cube_mm": 2.0 * STEP_3_HALF_SIDE_MM}
    return known


def _differences(runs: Runs) -> dict[str, Any]:
    """Compares print with what follows from it and with the proven optima, step by step."""
    known: dict[str, Any] = {}
    one, two, three = (_compared(runs, step) for step in (1, 2, 3))
    if one:
        worst = max(one, key=lambda r: abs(r.difference or 0.0)).run
        known |= {"step_1": _reproduces(one), "count": len(one), "off": 100.0 * _largest(one)}
        known |= {"worst": worst.name + (f" ({worst.note})" if worst.note else "")}
        known |= {"below": 100.0 * max(0.0, *(r.gap or 0.0 for r in one))}
    if two:
        known |= numbers()["constraints"] | {"step_2": _reproduces(two)}
        known |= {"torque": _span(r.published.max_torque_N_m for r in two if r.published)}
        known |= {"best_sides": _span(r.proven.objective for r in two)}
        known |= {"printed_sides": _span(r.run.objective for r in two)}
    if three:
        known |= {"step_3": _reproduces(three), "printed_kappas": _span(r.run.objective for r in three)}
        known |= {"kappas": _span(r.follows for r in three), "best_kappas": _span(r.proven.objective for r in three)}
        known |= {"frobenius": _span(r.published.max_kappa_frobenius for r in three if r.published)}
        known |= {"above": _span(100.0 * (r.gap or 0.0) for r in three)}
    about: dict[str, list[str]] = {}
    for r in _rounded(runs):
        remark = f"{r.run.objective:g} is printed where the lengths give {r.follows:.3f}, {signed(r.difference)}"
        remark += f" ({r.run.note})" if r.run.note else ""
        best, gap = r.proven.objective, r.proven.gap  # the same as far as it is proved
        same = [o for o in _compared(runs, r.run.step) if math.isclose(o.proven.objective, best, rel_tol=gap)]
        if others := [o.run.objective for o in same if o.within]:
            remark += f", and the {len(others)} other rows with this proven optimum print {_span(others):g}"
        about.setdefault(remark, []).append(r.run.name)
    if about:
        known["rounded"] = "; ".join(f"{', '.join(names)}: {remark}" for remark, names in about.items())
    return known


def _of_our_methods(runs: Runs) -> dict[str, Any]:
    """Evaluates our methods: where the paper has no result, along step 2's ridge, after the GA, from the proof."""
    known: dict[str, Any] = {}
    if unsolved := [r for r in runs if r.run.result is None]:
        ends = [(r.run.name, r.attempts["sqp"].objective, r.attempts["sqp"].ending) for r in unsolved]
        reached = [(name, "ends infeasible" if L is None else f"reaches {L:.3f} mm", why) for name, L, why in ends]
        known |= {"unsolved": len(unsolved), "solved": "; ".join(f"{n} {L} ({why})" for n, L, why in reached)}
        known |= {"feasible": sum(math.isfinite(r.proven.objective) for r in unsolved)}
    two = {r.run.name: r for r in runs if r.run.step == 2}
    if kappas := [kappa for r in two.values() if (kappa := _kappa(r)) is not None]:
        published = [r.published.max_kappa for r in two.values() if r.published]
        against = f", against {_span(published):.2f} of the published designs" if published else ""
        known |= {"least_ridge": min(kappas), "largest_ridge": max(kappas), "against": against, "longer": ""}
        if two.keys() >= set(LONGER_FOREARM):
            a, b = (two[name] for name in LONGER_FOREARM)
            known["longer"] = (
                f" The ridge goes on with L_B: its bound raised from {a.run.upper[1]:g} to {b.run.upper[1]:g} mm "
                f"({a.run.name} and {b.run.name}) gives {b.proven.objective - a.proven.objective:.2f} mm more."
            )
    pairs = list(itertools.pairwise(r for r in runs if r.run.table == 12))
    if parts := [_gains(a, b) for a, b in pairs if (a.run.method, b.run.method) == ("GA", "GA+SQP")]:
        known["second_method"] = "; ".join(parts)
    if runs:
        known["distances"] = ", ".join(f"{name.upper()} {_distance(runs, name)}" for name in METHODS)
    return known


def _gains(a: ReproducedRun, b: ReproducedRun) -> str:
    """Says how much SQP lowers the condition number of the GA in two rows of table 12."""
    ours = (b.attempts["ga+sqp"].objective, b.attempts["ga"].objective)
    pairs = ((b.run.objective, a.run.objective), (b.follows, a.follows), ours)
    printed, follows, ours_gain = (1.0 - (after or math.nan) / (before or math.nan) for after, before in pairs)
    return (
        f"rows {a.run.row} and {b.run.row}: {percent(printed)} as printed, {percent(follows)} by our equations; ours "
        f"from GA to GA+SQP {_small(ours_gain)} under the bounds of row {b.run.row}"
    )


def _distance(runs: Runs, name: str) -> str:
    """Says how far one of our methods ends from the certified optimum at most."""
    pairs = [(r.attempts[name].objective, r.proven.objective) for r in runs]
    known = [abs(objective / best - 1.0) for objective, best in pairs if objective is not None]
    lost = f" ({len(pairs) - len(known)} rows without result)" if len(known) < len(pairs) else ""
    return f"{f'at most {_small(max(known))}' if known else 'none'}{lost}"


def _reproduces(runs: Runs) -> str:
    """Says whether the runs of a step reproduce; names those that are outside the bare agreement."""
    if not any(r.agrees for r in runs):
        return "does not reproduce"
    bare, rounded = sum(bool(r.within) for r in runs), _rounded(runs)
    where = "" if bare == len(runs) else f" in {bare} of {len(runs)} rows"
    named = ", ".join(f"{r.run.name} {signed(r.difference)}" for r in rounded)
    more = f", and in {len(rounded)} more only with half of their last printed digit ({named})" if rounded else ""
    return f"reproduces within {percent(AGREEMENT, 1)}{where}{more}"


def _compared(runs: Runs, step: int) -> Runs:
    """Selects the runs of a step whose print can be compared with what follows from it."""
    return [r for r in runs if r.run.step == step and r.difference is not None]


def _rounded(runs: Runs) -> Runs:
    """Selects the runs that agree with half of their last printed digit added, and not without."""
    return [r for r in runs if r.agrees and not r.within]


def _largest(runs: Runs) -> float:
    return max(abs(r.difference or 0.0) for r in runs)


def _span(values: Iterable[float | None]) -> Span:
    known = [value for value in values if value is not None]
    return Span(min(known, default=math.nan), max(known, default=math.nan))


def _kappa(r: ReproducedRun) -> float | None:
    return finite(r.attempts["ga+sqp"].result.max_kappa)


def _missed(evaluation: Evaluation) -> str:
    return ", ".join(f"{f.name} by {f.by:.2f} {f.unit}".strip() for f in evaluation.faults) or "nothing"


def _small(share: float) -> str:
    return f"{share:.0e}" if abs(share) < SMALL else percent(share, 3)
