"""Output for a person: the inspection table, the result table."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    from delta_cad.commands.inspection import InspectionRow
    from delta_cad.commands.pipeline import Outcome

FIGURES = 5  # significant digits of a value in a table
DETAILED = (  # checks whose detail a buyer wants
    "envelope width",
    "envelope depth",
    "clearance proof",
    "drive torque",
    "structure stiffness at the knob",
)


def _number(value: float | str | None) -> str:
    return "" if value is None else value if isinstance(value, str) else f"{value:.{FIGURES}g}"


def _console() -> Console:
    """Colours on a terminal only; elsewhere as wide as the table needs."""
    return Console(file=sys.stdout) if sys.stdout.isatty() else Console(file=sys.stdout, width=160)


def _table(title: str, *columns: str) -> Table:
    """An empty table; columns whose name starts with > are flush right."""
    table = Table(title=title, title_justify="left")
    for column in columns:
        table.add_column(column.removeprefix(">"), justify="right" if column.startswith(">") else "left")
    return table


def print_inspection(name: str, rows: list[InspectionRow]) -> None:
    """Prints the inspection of a design."""
    table = _table(name, "", ">value", "unit", "limit", ">at x, y, z mm")
    group = ""
    for row in rows:
        if row.group != group:
            group = row.group
            table.add_row(f"[bold]{group}[/bold]")
        mark = "" if row.holds is None else " [green]holds[/green]" if row.holds else " [red]FAILS[/red]"
        at = "" if row.at_mm is None else ", ".join(f"{v:.1f}" for v in row.at_mm)
        table.add_row(f"  {row.quantity}", _number(row.value), row.unit, f"{row.limit}{mark}", at)
    _console().print(table)


def print_outcome(outcome: Outcome) -> None:
    """Prints the result of a build or a check: one line a check, equal checks of the three chains as one."""
    from delta_cad.checks.report import closeness, grouped  # loads all checks

    console = _console()
    table = _table(outcome.design.name, "check", ">value", ">limit", "unit", "", "where")
    for name, results in grouped(outcome.results).items():
        worst = min(results, key=closeness)
        verdict = "[green]holds[/green]" if all(r.passed for r in results) else "[red]FAILS[/red]"
        if all(r.passed and r.limit is None and r.value is not None for r in results):
            verdict = ""  # a figure that nothing is asked of
        count = f" ({len(results)}x)" if len(results) > 1 else ""
        where = " / ".join(worst.worst_pair or ())
        table.add_row(f"{name}{count}", _number(worst.value), _number(worst.limit), worst.unit, verdict, where)
    console.print(table)
    for result in outcome.results:
        if not result.passed:
            at = "" if result.worst_pose_mm is None else " at ({:.1f}, {:.1f}, {:.1f}) mm".format(*result.worst_pose_mm)
            console.print(f"[red]FAILS[/red] {result.name}{at}: {result.detail}", highlight=False, soft_wrap=True)
    for result in outcome.results:
        if result.passed and result.name in DETAILED:
            console.print(f"{result.name}: {result.detail}", highlight=False, soft_wrap=True)
    total, moving = outcome.masses["total_mass_kg"], outcome.masses["moving_mass_kg"]
    console.print(f"mass {total * 1000:.0f} g, of it moving {moving * 1000:.0f} g", highlight=False)
    if outcome.unverified:
        console.print(
            f"check before ordering, not all data verified: {', '.join(outcome.unverified)}",
            highlight=False,
            soft_wrap=True,
        )
    if outcome.folder is not None:
        state = "" if outcome.passed else " (rejected: a check fails)"
        console.print(f"files in {escape(str(outcome.folder))}{state}", highlight=False, soft_wrap=True)
