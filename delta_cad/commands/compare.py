"""`compare`: two machines side by side: figures, parts, cost, and both in 3D on one page."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, print_result, refuse, refuse_all, refuse_folder
from delta_cad.common.options import CATALOGUE, JSON, OUT_FOLDER, Option

if TYPE_CHECKING:
    from delta_cad.commands.inspection import InspectionRow
    from delta_cad.design import Design
    from delta_cad.report.built import Build

NAME = "compare"
TEXT = "two machines side by side: figures, parts, cost and 3D, as a table and a page"
_MACHINE = "design file, whose build is sought in OUT/NAME, or the folder of a build"
OPTIONS = (
    Option("a", type=Path, metavar="A", help=f"first machine: {_MACHINE}"),
    Option("b", type=Path, metavar="B", help="second machine, likewise"),
    CATALOGUE.but(help="folder of your own parts (motor.csv, cable.csv, ...); default: the one named in each design"),
    JSON,
    OUT_FOLDER.but(help="folder of builds, and of the page; default: out"),
)
_DESIGN, _CHECKS, _MASSES, _BILL, _COST = (
    "design.json", "checks.json", "mass_properties.json", "bom.json", "cost.json",
)  # fmt: skip
_SECTIONS = ("requirements", "mechanism", "cube", "hardware")
_SAME = 1e-6  # relative difference of figures below which they are the same: optima are polished to less
_LOWER, _HIGHER = "lower", "higher"
_AT_FORCE = "lower at the same force"
_COMPUTED = (
    ("dimensions", "cube side", "cube side", _HIGHER),
    ("height", "height,", "height, mounting surface to knob at the cube's top", _LOWER),
    ("limits", "torque for", "joint torque for the required force, largest", _AT_FORCE),
    ("limits", "torque with gravity", "joint torque, force and weight together, largest", _AT_FORCE),
    ("limits", "kappa", "conditioning (kappa), worst", _LOWER),
    ("limits", "effective mass", "effective mass, worst", _LOWER),
    ("limits", "friction", "friction at the handle, worst", _LOWER),
    ("limits", "position step", "position step, worst", _LOWER),
    ("limits", "couple index", "rotational stiffness index, least", _HIGHER),
    ("limits", "lean", "lean of the rods, largest", _LOWER),
    ("limits", "elbow arm", "distance from a stretched or folded arm, least", _HIGHER),
    ("over the cube", "margin to a fold", "margin to a fold, least", _HIGHER),
    ("drive", "joint torque, continuous", "drive torque, continuous", _HIGHER),
    ("drive", "joint torque, ", "drive torque, peak", _HIGHER),
    ("drive", "rotor's inertia", "rotor's inertia at the joint", _LOWER),
    ("structure", "least stiffness", "stiffness at the knob, least", _HIGHER),
    ("structure", "the same in the cube's centre", "stiffness at the knob, in the cube's centre", _HIGHER),
)
"""Figures in closed form: how group and row of the inspection begin, words, which of two is better."""
_CHECKED = (
    ("envelope width", "swept outline, width", _LOWER),
    ("envelope depth", "swept outline, depth", _LOWER),
    ("clearance", "clearance of moving bodies, least", _HIGHER),
    ("structure first mode", "first mode, lowest", _HIGHER),
)
"""Figures of the solids: name of the check, words, which of two is better."""
_PART = ("description", "quantity", "material", "standard", "order_code", "unit_mass_g", "unit_cost_EUR")
_UNITS = {"N_mm": "N/mm", "N_m": "N m", "m_s2": "m/s^2"} | {one: one for one in ("mm", "deg", "kg", "g", "N", "EUR")}
"""What a field of a design may end in -> its unit."""
_Value = float | str | None


@dataclass(frozen=True)
class _Machine:
    """One of the two.

    Attributes:
        design: Its design.
        build: What was built of it; None where nothing was, or not of this design.
        why: Why not.
        rows: Its inspection.
        files: What was read of the build: name -> content; none without.
    """

    design: Design
    build: Build | None
    why: str
    rows: list[InspectionRow]
    files: Mapping[str, Any]

    @property
    def failed(self) -> list[str]:
        """Limits and checks that fail."""
        return self.files.get(_CHECKS, {}).get("failed") or [row.quantity for row in self.rows if row.holds is False]

    def facts(self) -> dict[str, Any]:
        """Gives what the comparison states of it, as JSON types."""
        from delta_cad.design import design_hash

        return {
            "name": self.design.name,
            "input_sha256": design_hash(self.design),
            "folder": None if self.build is None else str(self.build.folder),
            "not_built": self.why,
            "failed": self.failed,
        }


@dataclass(frozen=True)
class _Figure:
    """A figure of both machines; None where it is not known, which for one of the solids means not built."""

    group: str
    quantity: str
    unit: str
    a: _Value
    b: _Value
    prefer: str = ""

    @property
    def difference(self) -> float | None:
        """B less A; None where one is no number."""
        both = isinstance(self.a, int | float) and isinstance(self.b, int | float)
        return self.b - self.a if both else None  # type: ignore[operator]

    @property
    def differs(self) -> bool:
        """Decides whether the two are not the same, roundings apart."""
        if self.difference is None:
            return self.a != self.b
        return not isclose(self.a, self.b, rel_tol=_SAME, abs_tol=1e-12)  # type: ignore[arg-type]

    def record(self) -> dict[str, Any]:
        """Gives it as JSON types; `better` is "a", "b" or None where no direction is defined or one is not known."""
        better = None
        if self.prefer and self.differs and self.difference is not None:
            better = "b" if (self.difference > 0.0) == (self.prefer == _HIGHER) else "a"
        found = {"group": self.group, "quantity": self.quantity, "unit": self.unit, "a": self.a, "b": self.b}
        return found | {"difference": self.difference, "better": better}


def run(given: argparse.Namespace) -> int:
    """Compares two machines, writes the page and returns the exit code: 1 where a limit or a check of one fails."""
    from delta_cad.commands.tables import print_comparison
    from delta_cad.common.files import require_room, write_whole
    from delta_cad.report.comparison import comparison_page, shown

    found = []
    for path in (given.a, given.b):
        machine = _machine(path, given)
        if isinstance(machine, int):
            return machine
        found.append(machine)
    a, b = found
    page = given.out / f"compare-{a.design.name}-{b.design.name}.html"
    try:
        require_room(page)
    except OSError as error:
        return refuse_folder(given.out, error)
    figures = list(_figures(a, b))
    facts = {
        "schema": "delta-comparison/1",
        "a": a.facts(),
        "b": b.facts(),
        "figures": [one.record() for one in figures if one.differs],
        "same": [one.record() for one in figures if not one.differs],
        "parts": _parts(a, b),
        "cost": _cost(a, b),
        "page": str(page),
    }
    write_whole(page, comparison_page(facts, [shown(one.build, one.why) for one in found]))
    print_result(given, facts, lambda: print_comparison(facts))
    return NOT_MET if a.failed or b.failed else DONE


def _machine(path: Path, given: argparse.Namespace) -> _Machine | int:
    """Reads a machine; refuses what is none and returns the exit code."""
    from delta_cad.commands.inspection import inspection
    from delta_cad.design import DesignError, load_design
    from delta_cad.drive.held import known_masses
    from delta_cad.mechanism import MechanismError
    from delta_cad.report.built import StaleBuildError, find_build

    folder = path if path.is_dir() else None
    file = path if folder is None else path / _DESIGN
    if folder is not None and not file.is_file():
        return refuse(f"{path}: holds no {_DESIGN}; must be the folder of a build, or a design file", BAD_INPUT)
    try:
        design = load_design(file, given.catalogue)
    except DesignError as error:
        return refuse_all([f"{path}: {line}" for line in error.lines], BAD_INPUT)
    places = [folder] if folder else [given.out / f"{design.name}{ending}" for ending in ("", ".rejected")]
    build, why = find_build(design, places)
    files: dict[str, Any] = {}
    if build is not None:
        try:
            files = {name: build.json(name) for name in (_CHECKS, _MASSES, _BILL, _COST)}
        except StaleBuildError as error:
            build, why = None, str(error)
    try:
        rows = inspection(design, known_masses(files[_MASSES], design) if files else None)
    except MechanismError as error:
        return refuse(f"{path}: cube: {error}", BAD_INPUT)
    return _Machine(design, build, why, rows, files)


def _figures(a: _Machine, b: _Machine) -> Iterator[_Figure]:
    """Lists the figures of both: computed, of the solids, and the fields of their designs."""
    rows = [_computed(one.rows) for one in (a, b)]
    same_force = a.design.requirements.force_N == b.design.requirements.force_N
    for words, prefer in {words: prefer for *_, words, prefer in _COMPUTED}.items():
        if units := [row[words][1] for row in rows if words in row]:
            a_value, b_value = (row[words][0] if words in row else None for row in rows)
            at_force = _LOWER if same_force else ""
            sense = at_force if prefer == _AT_FORCE else prefer
            yield _Figure("figures", words, units[0], a_value, b_value, sense)
    solids = [_solids(one) for one in (a, b)]
    for words, (_, unit, prefer) in {**solids[1], **solids[0]}.items():
        a_value, b_value = (found[words][0] if words in found else None for found in solids)
        yield _Figure("figures", words, unit, a_value, b_value, prefer)
    fields = [dict(_fields(one.design)) for one in (a, b)]
    for name in dict.fromkeys([*fields[0], *fields[1]]):
        unit = next((unit for end, unit in _UNITS.items() if name.endswith(f"_{end}")), "")
        yield _Figure("design", name, unit, fields[0].get(name), fields[1].get(name))


def _computed(rows: Iterable[InspectionRow]) -> dict[str, tuple[float, str]]:
    """Words -> value and unit of the figures of an inspection; those of unknown masses are left out."""
    found: dict[str, tuple[float, str]] = {}
    for row in rows:
        for group, begins, words, _ in _COMPUTED:
            if row.group.startswith(group) and row.quantity.startswith(begins) and not isinstance(row.value, str):
                found.setdefault(words, (row.value, row.unit))
                break
    return found


def _solids(machine: _Machine) -> dict[str, tuple[float, str, str]]:
    """Words -> value, unit and the better sense of the figures that only a build has."""
    if not machine.files:
        return {}
    record = machine.files[_CHECKS]
    checks = {check["name"]: check for check in record["checks"]}
    found = {
        words: (checks[name]["value"], checks[name]["unit"], prefer)
        for name, words, prefer in _CHECKED
        if name in checks
    }
    masses = (("total_mass_kg", "mass"), ("moving_mass_kg", "moving mass"))
    return found | {words: (record[key], "kg", _LOWER) for key, words in masses}


def _fields(design: Design) -> Iterator[tuple[str, _Value]]:
    """Lists the fields of a design by their path: numbers and words, lists as words."""
    from delta_cad.design import design_to_dict

    data = design_to_dict(design)
    for section in _SECTIONS:
        for name, value in (data.get(section) or {}).items():
            plain = ", ".join(map(str, value)) if isinstance(value, list | tuple) else value
            plain = plain if plain is None or isinstance(plain, int | float | str) else str(plain)
            yield f"{section}.{name}", str(plain) if isinstance(plain, bool) else plain


def _parts(a: _Machine, b: _Machine) -> dict[str, Any] | None:
    """Compares the bills of materials: parts of one only, and what differs of the others; None without both."""
    if a.build is None or b.build is None:
        return None
    bills = [{row["part_number"]: row for row in one.files[_BILL]["items"]} for one in (a, b)]
    solids = [{name: sha for name, sha in one.files.items() if name.startswith("parts/")} for one in (a.build, b.build)]
    changed = []
    for number in bills[0]:
        if number not in bills[1]:
            continue
        first, second = bills[0][number], bills[1][number]
        fields = {key: [first.get(key), second.get(key)] for key in _PART if first.get(key) != second.get(key)}
        file = f"parts/{number}.step"
        if fields or solids[0].get(file) != solids[1].get(file):
            changed.append({"part_number": number, "shape": solids[0].get(file) != solids[1].get(file)} | fields)

    def only(own: int) -> list[dict[str, Any]]:
        rows = (row for number, row in bills[own].items() if number not in bills[1 - own])
        return [{key: row.get(key) for key in ("part_number", "quantity", "description")} for row in rows]

    same = len(bills[0].keys() & bills[1]) - len(changed)
    return {"only_a": only(0), "only_b": only(1), "changed": changed, "same": same}


def _cost(a: _Machine, b: _Machine) -> dict[str, Any] | None:
    """Compares what machines cost, EUR: the sums by machines made at once, and lines of one that differ."""
    if a.build is None or b.build is None:
        return None
    first, second = a.files[_COST], b.files[_COST]
    lines = [
        {line["part_number"]: round(line["quantity"] * line["unit_EUR"][0], 2) for line in one["lines"]}
        for one in (first, second)
    ]
    differ = [
        {"part_number": number, "a_EUR": lines[0].get(number), "b_EUR": lines[1].get(number)}
        for number in dict.fromkeys([*lines[0], *lines[1]])
        if lines[0].get(number) != lines[1].get(number)
    ]
    for line in differ:
        line["difference_EUR"] = round((line["b_EUR"] or 0.0) - (line["a_EUR"] or 0.0), 2)
    sums = {key: {"a": first[key], "b": second[key]} for key in ("made_EUR", "bought_EUR", "total_EUR")}
    return (
        {"machines": first["machines"]} | sums | {"lines": sorted(differ, key=lambda one: -abs(one["difference_EUR"]))}
    )
