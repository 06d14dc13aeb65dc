"""Verdict and notes on the recomputed tables in words; every number in them is computed from the rows."""

from __future__ import annotations

import itertools
import math

from optimizer.paper.cases import EXCHANGED_H, STEP_3_HALF_SIDE_MM, numbers
from optimizer.paper.judgement import Judged
from optimizer.paper.runs import AGREEMENT, METHODS, Recomputed

SMALL = 1e-5
"""Shares below it are told as powers of ten."""


def percent(share: float, digits: int = 2) -> str:
    """A share as a percentage."""
    return f"{100.0 * share:.{digits}f} %"


def signed(share: float) -> str:
    """A share as a percentage, with its sign."""
    return f"{'+' if share > 0.0 else ''}{percent(share)}"


def verdict(rows: list[Recomputed]) -> list[str]:
    """One paragraph for each step of which there are rows."""
    return [text for text in (_step_1(rows), _step_2(rows), _step_3(rows)) if text]


def summary(rows: list[Recomputed]) -> str:
    """The verdict in one line."""
    parts = []
    for step in (1, 2, 3):
        known = [r for r in _of(rows, step) if r.difference is not None]
        if known:
            worst = percent(max(abs(r.difference or 0.0) for r in known), 1)
            off = "" if all(r.agrees for r in known) else f" (off by up to {worst})"
            parts.append(f"step {step} {_word(known)}{off}")
    text = ", ".join(parts)
    return f"{text[:1].upper()}{text[1:]}." if text else "No published result is among these tables."


def notes(rows: list[Recomputed]) -> list[str]:
    """What explains the numbers, each from the rows that there are."""
    makers = (_rounding, _fold, _printed_h, _exchanged, _no_results, _ridge, _second_method, _methods, _step_3_side)
    return [text for maker in makers for text in [maker(rows)] if text]


def span(values: list[float], digits: int) -> str:
    """The smallest and the largest of some numbers."""
    low, high = f"{min(values):.{digits}f}", f"{max(values):.{digits}f}"
    return low if low == high else f"{low} to {high}"


def _of(rows: list[Recomputed], step: int) -> list[Recomputed]:
    return [r for r in rows if r.case.step == step]


def _word(rows: list[Recomputed]) -> str:
    """Whether a step reproduces, from its rows; names those that are outside the bare agreement."""
    known = [r for r in rows if r.agrees is not None]
    if not any(r.agrees for r in known):
        return "does not reproduce"
    bare, rounded = sum(bool(r.within) for r in known), _rounded(known)
    where = "" if bare == len(known) else f" in {bare} of {len(known)} rows"
    more = f", and in {len(rounded)} more only with half of their last printed digit ({_named(rounded)})"
    return f"reproduces within {percent(AGREEMENT, 1)}{where}{more if rounded else ''}"


def _rounded(rows: list[Recomputed]) -> list[Recomputed]:
    """The rows that agree with half of their last printed digit added, and not without."""
    return [r for r in rows if r.agrees and not r.within]


def _named(rows: list[Recomputed]) -> str:
    return ", ".join(f"{r.case.name} {signed(r.difference or 0.0)}" for r in rows)


def _rounding(rows: list[Recomputed]) -> str:
    """What is known of the rows that are outside the bare agreement."""
    about: dict[str, list[str]] = {}
    for r in _rounded(rows):
        words = f"{r.case.objective:g} is printed where the lengths give {r.follows:.3f}, {signed(r.difference or 0.0)}"
        same = [o.case.objective for o in rows if o.within and o.case.objective is not None and _same_optimum(o, r)]
        if r.case.note:
            words += f" ({r.case.note})"
        if same:
            words += f", and the {len(same)} other rows with this proven optimum print {' to '.join(_ends(same))}"
        about.setdefault(words, []).append(r.case.name)
    parts = [f"{', '.join(names)}: {words}" for words, names in about.items()]
    if not parts:
        return ""
    return (
        f"Outside {percent(AGREEMENT, 1)}, and within it only with half of the last printed digit added, which shows "
        f"nothing but that print is no finer. {'; '.join(parts)}."
    )


def _same_optimum(a: Recomputed, b: Recomputed) -> bool:
    """Whether two rows of one step have the same optimum, as far as it is proved."""
    low, high = sorted((a.proven.objective, b.proven.objective))
    return a.case.step == b.case.step and high - low <= max(a.proven.gap, b.proven.gap) * high


def _ends(values: list[float]) -> list[str]:
    return list(dict.fromkeys(f"{x:g}" for x in (min(values), max(values))))


def _step_1(rows: list[Recomputed]) -> str:
    mine = [r for r in _of(rows, 1) if r.difference is not None]
    if not mine:
        return ""
    worst = max(mine, key=lambda r: abs(r.difference or 0.0))
    note = f" ({worst.case.note})" if worst.case.note else ""
    gaps = [r.gap for r in mine if r.gap is not None]
    return (
        f"Step 1 {_word(mine)}: the {len(mine)} printed half sides differ by at most "
        f"{percent(abs(worst.difference or 0.0))} from those that the printed L_B, R and r allow "
        f"(worst {worst.case.name}{note}); they are at "
        f"most {percent(max(0.0, *gaps))} below the proven optimum under the same bounds."
    )


def _step_2(rows: list[Recomputed]) -> str:
    mine = [r for r in _of(rows, 2) if r.published is not None]
    if not mine:
        return ""
    torques = [r.published.torque_N_m for r in mine if r.published and r.published.torque_N_m is not None]
    fixed = numbers()["constraints"]
    best = [r.proven.objective for r in mine if math.isfinite(r.proven.objective)]
    return (
        f"Step 2 {_word(mine)}: by the paper's own equations the published designs need {span(torques, 3)} N m for "
        f"{fixed['force_N']:g} N, so that the limit of {fixed['joint_torque_N_m']:g} N m does not bind; under the same "
        f"bounds and limits half sides of {span(best, 2)} mm are possible where "
        f"{span([r.case.objective or 0.0 for r in mine], 1)} mm are printed."
    )


def _step_3(rows: list[Recomputed]) -> str:
    mine = [r for r in _of(rows, 3) if r.published is not None and r.published.kappa is not None]
    if not mine:
        return ""
    kappas = [r.published.kappa for r in mine if r.published and r.published.kappa]
    frobenius = [r.published.kappa_frobenius for r in mine if r.published and r.published.kappa_frobenius]
    return (
        f"Step 3 {_word(mine)}: for condition numbers printed as {span([r.case.objective or 0.0 for r in mine], 3)} "
        f"the paper's equations give {span(kappas, 3)} (2-norm; {span(frobenius, 3)} in Frobenius's), and the proven "
        f"optimum is {span([r.proven.objective for r in mine], 3)}: the published designs are "
        f"{span([100.0 * (r.gap or 0.0) for r in mine], 1)} % above it."
    )


def _fold(rows: list[Recomputed]) -> str:
    designs = [r.proven.design_mm for r in _of(rows, 1) if r.proven.design_mm]
    if not designs:
        return ""
    off = max(abs(H - (L_B - L_A)) for L_A, L_B, _, _, H, _ in designs)
    radii = max(abs(R - r) for _, _, R, r, _, _ in designs)
    kappas = [r.method("ga+sqp").kappa for r in _of(rows, 1)]
    infinite = sum(kappa is None for kappa in kappas)
    return (
        f"Why step 1 alone is no design: its proven optima lie within {off:.1e} mm of H = L_B - L_A with R - r within "
        f"{radii:.1e} mm of 0, where upper arm and forearm fold in line above the base's centre. There the condition "
        f"number has no bound (infinite over the cube in {infinite} of {len(kappas)} rows of ours)."
    )


def _printed_h(rows: list[Recomputed]) -> str:
    skip = EXCHANGED_H
    missed = [
        fault.by
        for r in _of(rows, 1)
        if r.published is not None and (r.case.table, r.case.row) not in skip
        for fault in r.published.faults
        if fault.name == "reach"
    ]
    if not missed:
        return ""
    return (
        f"{len(missed)} published designs of step 1 miss the reach as printed, by {min(missed):.3f} to "
        f"{max(missed):.3f} mm of forearm: an optimum on the fold does not bear the rounding of H and L. So the column "
        '"its lengths allow" leaves H free within its bounds.'
    )


def _exchanged(rows: list[Recomputed]) -> str:
    parts = [
        f"row {r.case.row} misses {_missed(r.published)} as printed, {_missed(r.exchanged)} with the other's H"
        for r in rows
        if r.exchanged is not None and r.published is not None
    ]
    return f"Table {EXCHANGED_H[0][0]}: the H of two rows look exchanged in print: {'; '.join(parts)}." if parts else ""


def _missed(judged: Judged | None) -> str:
    faults = judged.faults if judged is not None else ()
    return ", ".join(f"{f.name} by {f.by:.2f} {f.unit}".strip() for f in faults) or "nothing"


def _no_results(rows: list[Recomputed]) -> str:
    mine = [r for r in rows if r.case.result is None]
    if not mine:
        return ""
    parts = []
    for r in mine:
        found = r.method("sqp")
        reached = "ends infeasible" if found.objective is None else f"reaches {found.objective:.3f} mm"
        parts.append(f"{r.case.name} {reached} ({found.ending})")
    feasible = sum(math.isfinite(r.proven.objective) for r in mine)
    return (
        f'{feasible} of the {len(mine)} runs for which the paper has "no results" have feasible designs, so that it '
        f"was the solver that failed; from the same starts our SQP gives: {'; '.join(parts)}."
    )


def _ridge(rows: list[Recomputed]) -> str:
    mine = _of(rows, 2)
    kappas = [r.method("ga+sqp").kappa for r in mine]
    known = [kappa for kappa in kappas if kappa is not None]
    if not known:
        return ""
    published = [r.published.kappa for r in mine if r.published and r.published.kappa]
    against = f", against {span(published, 2)} of the published designs" if published else ""
    text = (
        f"Why step 2 wants a limit on kappa: the largest cubes within the torque have a worst kappa of "
        f"{min(known):.1f} to {max(known):.0f}{against}. Torque alone does not see a fold, "
        "where it vanishes."
    )
    pairs = [
        (a, b)
        for a in mine
        for b in mine
        if (a.case.lower, a.case.upper[:1] + a.case.upper[2:]) == (b.case.lower, b.case.upper[:1] + b.case.upper[2:])
        and a.case.upper[1] < b.case.upper[1]
    ]
    if pairs:
        a, b = pairs[0]
        text += (
            f" The ridge goes on with L_B: its bound raised from {a.case.upper[1]:g} to {b.case.upper[1]:g} mm "
            f"({a.case.name} and {b.case.name}) gives {b.proven.objective - a.proven.objective:.2f} mm more."
        )
    return text


def _second_method(rows: list[Recomputed]) -> str:
    """What SQP adds to the GA, table 12: each row of GA is followed by its GA+SQP."""
    mine = [r for r in rows if r.case.table == 12]
    parts = []
    for a, b in itertools.pairwise(mine):
        known = (a.case.objective, b.case.objective, a.follows, b.follows)
        if (a.case.method, b.case.method) == ("GA", "GA+SQP") and None not in known:
            printed_a, printed_b, follows_a, follows_b = (x or math.nan for x in known)
            ours = [b.method(name).objective or math.nan for name in ("ga", "ga+sqp")]
            parts.append(
                f"rows {a.case.row} and {b.case.row}: {percent(1.0 - printed_b / printed_a)} as printed, "
                f"{percent(1.0 - follows_b / follows_a)} by our equations; ours from GA to GA+SQP "
                f"{_small(1.0 - ours[1] / ours[0])} under the bounds of row {b.case.row}"
            )
    return f"What SQP takes off the GA's condition number in table 12: {'; '.join(parts)}." if parts else ""


def _methods(rows: list[Recomputed]) -> str:
    parts = []
    for name in METHODS:
        found = [(r.method(name).objective, r.proven.objective) for r in rows]
        known = [abs(objective / best - 1.0) for objective, best in found if objective is not None]
        failed = sum(objective is None for objective, _ in found)
        worst = f"at most {_small(max(known))}" if known else "none"
        parts.append(f"{name.upper()} {worst}" + (f" ({failed} rows without result)" if failed else ""))
    return f"Distance of our methods from the certified optimum over all rows: {', '.join(parts)}."


def _small(share: float) -> str:
    return percent(share, 3) if abs(share) >= SMALL else f"{share:.0e}"


def _step_3_side(rows: list[Recomputed]) -> str:
    if not _of(rows, 3):
        return ""
    return (
        f"The paper prints no L for step 3. {STEP_3_HALF_SIDE_MM:g} mm is taken, half the side of its prototype's cube "
        f"of {2.0 * STEP_3_HALF_SIDE_MM:g} mm. Cubes on the same bottom face contain each other, so that a larger L "
        "gives no smaller condition number, neither for the published design nor for the optimum."
    )
