"""Output for a person: what fails first, ten figures, and on demand the inspection table or the result table."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    from delta_cad.commands.inspection import InspectionRow
    from delta_cad.commands.pipeline import Outcome

_PAGE = "report.html"
_FIGURES = 5  # significant digits of a value in a table
MOST_FIGURES = 10  # that are told first
FIRST_CHECKED = (
    "envelope width",
    "envelope depth",
    "height",
    "clearance",
    "torque with gravity",
    "drive torque",
    "kappa",
    "effective mass",
    "friction",
    "structure stiffness at the knob",
    "structure first mode",
    "lean",
    "couple index",
)
"""Checks whose figures are told first, as far as there are."""
_FIRST_INSPECTED = (
    "cube side 2 L",
    "longer side",
    "shorter side",
    "torque for",
    "joint torque, continuous",
    "kappa",
    "effective mass",
    "friction",
    "least stiffness",
    "lean",
    "couple index",
    "motor",
)
"""How the figures begin that are told first, as far as there are."""
_UNKNOWN_MASSES = "give --mass-properties"
_DETAILED = (  # checks whose detail a buyer wants
    "envelope width",
    "envelope depth",
    "clearance proof",
    "drive torque",
    "structure stiffness at the knob",
)


def _number(value: float | str | None) -> str:
    return "" if value is None else value if isinstance(value, str) else f"{value:.{_FIGURES}g}"


def _unit(unit: str) -> str:
    """A unit as people write it, where the terminal can."""
    reported = unit.replace("^2", "²").replace("^3", "³")
    try:
        reported.encode(sys.stdout.encoding or "ascii")
    except UnicodeEncodeError:
        return unit
    return reported


def _console() -> Console:
    """Colours on a terminal only; elsewhere as wide as the table needs."""
    return Console(file=sys.stdout) if sys.stdout.isatty() else Console(file=sys.stdout, width=160)


def _table(*columns: str) -> Table:
    """An empty table; columns whose name starts with > are flush right."""
    table = Table()
    for column in columns:
        table.add_column(column.removeprefix(">"), justify="right" if column.startswith(">") else "left")
    return table


def _figures(lines: Sequence[Sequence[str]]) -> Table:
    """Lists figures without frames: what it is, value, unit, what it is held against."""
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 1, 0, 1))
    for justify in ("left", "right", "left", "left"):
        table.add_column(justify=justify)
    for line in lines:
        table.add_row(*line)
    return table


def _words(row: InspectionRow) -> str:
    """Says what a row is without its heading."""
    return f"{row.group}, {row.quantity}" if row.quantity.endswith("side") else row.quantity


def print_inspection(name: str, rows: list[InspectionRow], whole: bool = False, reasons: int = 0) -> None:
    """Prints the inspection of a design: what fails, ten figures, and on demand the whole table.

    Args:
        name: The design's.
        rows: The inspection.
        whole: Whether to print every row.
        reasons: How many reasons there are against building it.
    """
    console = _console()
    bounded = [row for row in rows if row.holds is not None]
    failed = [row for row in bounded if not row.holds]
    verdict = f"{len(failed)} of {len(bounded)} limits FAIL" if failed else f"all {len(bounded)} limits hold"
    unknown = [row.quantity for row in rows if row.limit and isinstance(row.value, str)]
    verdict += f"; no build: {reasons} reason{'s' * (reasons > 1)}" if reasons else ""
    verdict += f"; not computed: {', '.join(unknown)}" if unknown else ""
    console.print(f"{name}: {verdict}", highlight=False, soft_wrap=True)
    for row in failed:
        at = "" if row.at_mm is None else " at ({:.1f}, {:.1f}, {:.1f}) mm".format(*row.at_mm)
        reported = f"{_number(row.value)} {_unit(row.unit)}".strip()
        console.print(f"[red]FAILS[/red] {row.quantity}{at}: {reported}, {row.limit}", highlight=False, soft_wrap=True)
    if not whole:
        named = {word: row for word in _FIRST_INSPECTED for row in reversed(rows) if row.quantity.startswith(word)}
        shown = list(named.values())[:MOST_FIGURES]
        shown += [row for row in rows if row.value == _UNKNOWN_MASSES and row not in shown]
        console.print(_figures([(_words(row), _number(row.value), _unit(row.unit), row.limit) for row in shown]))
        console.print("--all prints every figure and where it is worst", highlight=False)
        return
    table = _table("", ">value", "unit", "limit", ">at x, y, z mm")
    group = ""
    for row in rows:
        if row.group != group:
            group = row.group
            table.add_row(f"[bold]{group}[/bold]")
        mark = "" if row.holds is None else " [green]holds[/green]" if row.holds else " [red]FAILS[/red]"
        at = "" if row.at_mm is None else ", ".join(f"{round(v, 1) + 0.0:.1f}" for v in row.at_mm)
        table.add_row(f"  {row.quantity}", _number(row.value), _unit(row.unit), f"{row.limit}{mark}", at)
    console.print(table)


def print_outcome(outcome: Outcome, whole: bool = False) -> None:
    """Prints the result of a build or a check: what fails, ten figures, and on demand every check and its detail."""
    from delta_cad.checks.range.feel import poor_verdict  # loads the proofs

    console = _console()
    failed = [result for result in outcome.results if not result.passed]
    count = len(outcome.results)
    verdict = f"{len(failed)} of {count} checks FAIL" if failed else f"all {count} checks hold"
    verdict = f"[yellow]{escape(poor_verdict(outcome.poor))}[/yellow]" if outcome.poor else verdict
    console.print(f"{outcome.design.name}: {verdict}", highlight=False, soft_wrap=True)
    for result in failed:
        at = "" if result.worst_pose_mm is None else " at ({:.1f}, {:.1f}, {:.1f}) mm".format(*result.worst_pose_mm)
        where = f" ({' / '.join(result.worst_pair)})" if result.worst_pair else ""
        text = f"[red]FAILS[/red] {result.name}{at}: {result.detail}{where}"
        console.print(text, highlight=False, soft_wrap=True)
    if whole:
        _print_checks(console, outcome)
    else:
        console.print(_figures(_headline(outcome)))
    total, moving = outcome.masses["total_mass_kg"], outcome.masses["moving_mass_kg"]
    console.print(f"mass {total * 1000:.0f} g, moving mass {moving * 1000:.0f} g", highlight=False)
    if outcome.unverified:
        console.print(
            f"verify before ordering, data not fully verified: {', '.join(outcome.unverified)}",
            highlight=False,
            soft_wrap=True,
        )
    if outcome.folder is not None:
        state = "" if outcome.passed else " (rejected: a check fails)"
        console.print(f"files in {escape(str(outcome.folder))}{state}", highlight=False, soft_wrap=True)
    if not whole:
        console.print("--all prints every check with its limit", highlight=False)
    if outcome.folder is not None and (outcome.folder / _PAGE).is_file():
        console.print(f"open {escape(str(outcome.folder / _PAGE))}", highlight=False, soft_wrap=True)


def _headline(outcome: Outcome) -> list[tuple[str, str, str, str]]:
    """Gives the cube's side and those of the first figures that were checked: words, value, unit, limit."""
    from delta_cad.report.figures import line  # loads all checks

    found = {result.name: result for result in outcome.results}
    lines = [("cube side", _number(2.0 * outcome.design.cube.half_side_mm), "mm", "")]
    for name in [name for name in FIRST_CHECKED if name in found][: MOST_FIGURES - 1]:
        limit = " ".join(line(found[name]).limit.replace("≤", "<=").replace("≥", ">=").split()[:2])  # the unit is told
        lines.append((name, _number(found[name].value), _unit(found[name].unit), limit))
    return lines


def print_comparison(facts: Mapping[str, Any]) -> None:
    """Prints what differs of two machines, as `compare` gathers it, and where its page is."""
    from delta_cad.report.comparison import changes, pair, signed  # loads the page's templates

    console = _console()
    for side in "ab":
        one = facts[side]
        state = (
            f"figures in closed form; not built: {one['not_built']}"
            if one["not_built"]
            else f"built in {one['folder']}"
        )
        console.print(f"{side.upper()} {escape(one['name'])}: {escape(state)}", highlight=False, soft_wrap=True)
        if one["failed"]:
            failed = escape(", ".join(one["failed"]))
            console.print(f"[red]FAILS[/red] {side.upper()}: {failed}", highlight=False, soft_wrap=True)
    table = _table("what differs", ">A", ">B", ">B - A", "unit", "better")
    group = ""
    for row in facts["figures"]:
        if row["group"] != group:
            group = row["group"]
            table.add_row(f"[bold]{group}[/bold]")
        values = (*pair(row), signed(row), _unit(row["unit"]))
        table.add_row(f"  {escape(row['quantity'])}", *map(escape, values), (row["better"] or "").upper())
    console.print(table if facts["figures"] else "no figure differs", highlight=False)
    if (parts := facts["parts"]) is None:
        console.print("parts and cost: both machines must be built", highlight=False)
    else:
        for words, rows in (("only in A", parts["only_a"]), ("only in B", parts["only_b"])):
            named = ", ".join(f"{row['quantity']} x {row['part_number']}" for row in rows) or "none"
            console.print(f"parts {words}: {escape(named)}", highlight=False, soft_wrap=True)
        console.print(f"parts changed ({parts['same']} are the same):", highlight=False)
        for row in parts["changed"]:
            console.print(f"  {escape(row['part_number'])}: {escape(changes(row))}", highlight=False, soft_wrap=True)
        _print_cost(console, facts["cost"])
    console.print(f"both in 3D: open {escape(facts['page'])}", highlight=False, soft_wrap=True)


def _print_cost(console: Console, cost: Mapping[str, Any]) -> None:
    """Prints the sums of two machines, and the lines of one machine that differ, EUR."""
    table = _table("EUR", ">A", ">B", ">B - A")
    for words, key in (("made parts", "made_EUR"), ("bought parts", "bought_EUR"), ("one machine", "total_EUR")):
        for count, a, b in zip(cost["machines"], cost[key]["a"], cost[key]["b"], strict=True):
            if count == 1 or key == "total_EUR":
                of = words if count == 1 else f"{words}, when {count} are made"
                table.add_row(of, f"{a:.2f}", f"{b:.2f}", f"{b - a:+.2f}")
    for line in cost["lines"]:
        a, b = ("" if value is None else f"{value:.2f}" for value in (line["a_EUR"], line["b_EUR"]))
        table.add_row(f"  {escape(line['part_number'])}", a, b, f"{line['difference_EUR']:+.2f}")
    console.print(table)


def _print_checks(console: Console, outcome: Outcome) -> None:
    """Prints one line a check, equal checks of the three chains as one, and what a buyer wants to know of some."""
    from delta_cad.checks.report import closeness, grouped  # loads all checks

    table = _table("check", ">value", ">limit", "unit", "", "where")
    for name, results in grouped(outcome.results).items():
        worst = min(results, key=closeness)
        verdict = "[green]holds[/green]" if all(r.passed for r in results) else "[red]FAILS[/red]"
        if all(r.passed and r.limit is None and r.value is not None for r in results):
            verdict = ""  # a figure that nothing is asked of
        count = f" ({len(results)}x)" if len(results) > 1 else ""
        where = " / ".join(worst.worst_pair or ())
        table.add_row(f"{name}{count}", _number(worst.value), _number(worst.limit), _unit(worst.unit), verdict, where)
    console.print(table)
    for result in outcome.results:
        if result.passed and result.name in _DETAILED:
            console.print(f"{result.name}: {result.detail}", highlight=False, soft_wrap=True)
