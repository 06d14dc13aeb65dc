"""The page of the recomputed tables, in Markdown, from the same facts as the JSON file."""

from __future__ import annotations

from optimizer.paper.facts import Facts, free_bounds
from optimizer.paper.runs import AGREEMENT
from optimizer.paper.words import percent, signed
from optimizer.problem.evaluator import VARIABLES

TITLES = {
    "4": "Tables 3 and 4: step 1 by GA",
    "6": "Tables 5 and 6: step 1 by GA, longer forearm",
    "7": "Table 7: step 2 by GA",
    "8": "Table 8: step 3 by GA",
    "9": "Table 9: step 1 by SQP",
    "10": "Table 10: step 2 by SQP",
    "11": "Table 11: step 3 by SQP",
    "12": "Table 12: step 3 by GA, then by SQP from its result",
}
AIMS = {
    1: "Largest half side L (mm) within the reach.",
    2: "Largest half side L (mm) within the reach and the joint torque.",
    3: "Smallest worst condition number over the cube.",
}
VERDICTS = ("off by", f"within {percent(AGREEMENT, 1)}", "with half the last digit")
NONE = "-"


def page(told: Facts) -> str:
    """The page.

    Args:
        told: What `paper_facts.facts` found.

    Returns:
        Markdown.
    """
    parts = [
        "# The published tables, recomputed",
        f"**{told['summary']}**",
        *told["verdict"],
        f"Source: {told['source']}. Ours: version {told['version']}, seed {told['seed']}; proofs to a gap of "
        f"{told['gap_asked']:g}. Lengths in mm.",
        "How to read it: *printed* is the paper's number; *follows* is what the printed lengths give by the paper's "
        "own equations; *ours* are GA, SQP and GA+SQP under the same bounds (SQP from the paper's start where there is "
        "one); *proven* is a bound that no design within those bounds can beat; *gap* is how far the printed result is "
        "from that bound, negative where it is beyond it; *off by* is *printed* against *follows*, and two verdicts "
        f"are given of it: whether it is within {percent(told['agreement'], 1)}, and whether it is with half of the "
        "last printed digit added to that.",
        "## Table 2: parameters of the genetic algorithm",
        _parameters(told["table_2"]),
    ]
    for number, table in told["tables"].items():
        parts += [f"## {TITLES[number]}", AIMS[table["step"]]]
        parts.append(_kappa(table["rows"]) if table["step"] == 3 else _sides(table["rows"], table["step"]))
        remarks = _remarks(table["rows"])
        parts += ["\n".join(f"- {text}" for text in remarks)] if remarks else []
    parts += ["## Notes", "\n".join(f"{n + 1}. {text}" for n, text in enumerate(told["notes"]))]
    return "\n\n".join(parts) + "\n"


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _number(value: float | None, digits: int) -> str:
    return NONE if value is None else f"{value:.{digits}f}"


def _share(value: float | None) -> str:
    return NONE if value is None else percent(value)


def _lengths(design: Facts | None, wanted: tuple[int, ...]) -> str:
    return NONE if design is None else ", ".join(f"{design[f'{VARIABLES[k]}_mm']:g}" for k in wanted)


def _parameters(rows: list[Facts]) -> str:
    def words(value: object) -> str:
        if value is None:
            return "one island, no migration"
        return ", ".join(str(v) for v in value) if isinstance(value, list) else str(value)

    return _table(["parameter", "paper", "ours"], [[r["parameter"], words(r["paper"]), words(r["ours"])] for r in rows])


def _sides(rows: list[Facts], step: int) -> str:
    head = [
        "row",
        "bounds",
        "L_B, r, H",
        "printed L",
        "keeps its constraints",
        "follows: its lengths allow L",
        *VERDICTS,
    ]
    head += ["our GA", "our SQP", "our GA+SQP", "proven L at most", "gap"]
    if step == 2:
        head += ["torque of the printed design, N m", "its kappa", "kappa of the optimum"]
    lines = []
    for row in rows:
        ours = row["by_our_equations"]
        line = [
            str(row["row"]),
            free_bounds(row),
            _lengths(row["printed"], (1, 3, 4)),
            NONE if row["printed_objective"] is None else f"{row['printed_objective']:g}",
            _faults(ours),
            _number(row["follows"], 3),
            *_verdicts(row),
            *(_number(row["found"][name]["objective"], 3) for name in ("ga", "sqp", "ga+sqp")),
            _number(row["proven"]["bound"], 4),
            _share(row["gap"]),
        ]
        if step == 2:
            line += [
                _number(None if ours is None else ours["max_torque_N_m"], 3),
                _number(None if ours is None else ours["max_kappa"], 3),
                _number(row["found"]["ga+sqp"]["max_kappa"], 1),
            ]
        lines.append(line)
    return _table(head, lines)


def _kappa(rows: list[Facts]) -> str:
    head = ["row", "method", "bounds", "L_B, r, H", "printed kappa", "follows: kappa", "Frobenius", "torque, N m"]
    head += ["keeps its constraints", *VERDICTS, "our GA", "our SQP", "our GA+SQP", "proven kappa at least", "gap"]
    lines = []
    for row in rows:
        ours = row["by_our_equations"] or {}
        lines.append(
            [
                str(row["row"]),
                row["method"],
                free_bounds(row),
                _lengths(row["printed"], (1, 3, 4)),
                _number(row["printed_objective"], 3),
                _number(row["follows"], 4),
                _number(ours.get("max_kappa_frobenius"), 3),
                _number(ours.get("max_torque_N_m"), 3),
                _faults(row["by_our_equations"]),
                *_verdicts(row),
                *(_number(row["found"][name]["objective"], 4) for name in ("ga", "sqp", "ga+sqp")),
                _number(row["proven"]["bound"], 5),
                _share(row["gap"]),
            ]
        )
    return _table(head, lines)


def _faults(judged: Facts | None) -> str:
    if judged is None:
        return "no results"
    words = [f"{f['name']} missed by {f['by']:.3g} {f['unit']}".strip() for f in judged["faults"]]
    return ", ".join(words) or "yes"


def _verdicts(row: Facts) -> tuple[str, ...]:
    """Under `VERDICTS`: the deviation, and whether it is within the agreement bare, and beside the print's rounding."""
    if row["difference"] is None:
        return (NONE,) * len(VERDICTS)
    both = (row["within_agreement"], row["within_beside_half_last_digit"])
    return (signed(row["difference"]), *("yes" if good else "no" for good in both))


def _remarks(rows: list[Facts]) -> list[str]:
    """What must be known of rows beside their numbers; each text once, with the rows that it is about."""
    about: dict[str, list[str]] = {}
    for row in rows:
        proven, sqp = row["proven"], row["found"]["sqp"]
        texts = [row["note"], *row["changed"]]
        if proven["status"] != "proved":
            gap = "" if proven["gap"] is None else f", gap {proven['gap']:.1e}"
            texts.append(f"the proof ended with: {proven['status']}{gap}")
        if sqp["start"] == "paper" and sqp["ending"] != "converged":
            texts.append(f"SQP from the paper's start: {sqp['ending']}")
        for text in texts:
            if text:
                about.setdefault(text, []).append(str(row["row"]))
    return [f"row{'s' if len(found) > 1 else ''} {', '.join(found)}: {text}" for text, found in about.items()]
