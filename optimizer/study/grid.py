"""The grid file of an atlas: a base task, axes to vary it along, seeds and a method; read, validated, spread out.

Axes are dotted fields of the requirements file. A file that is refused says which field, its value and what is allowed.
"""

from __future__ import annotations

import copy
import hashlib
import itertools
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from delta_cad.common.refusal import short
from delta_cad.design import NAME_PATTERN, NAME_RULE, Hardware
from optimizer.problem.brief import DesignBrief, brief_from_dict
from optimizer.problem.requirements import Requirements, RequirementsError, read_toml, requirements_from_dict
from optimizer.search.genetic import GENERATIONS
from optimizer.synthesis.three_step import METHODS

VALUES_MAX = 1_000  # values of one axis, and seeds
SETS_MAX = 10_000  # sets of one atlas: a night on two cores
_POPULATION = (4, 100_000)
_GENERATION = (1, 100_000)
_INTEGER_MAX = 10**15  # a TOML integer may have thousands of digits; up to here each is a float too
_KEYS = ("name", "base", "axes", "method", "seeds", "steps", "population", "generations")
_SPACINGS = ("linspace", "geomspace")
TABLES = ("requirements", "bounds_mm", "limits", "step_3")
MACHINES = "design"  # method of an atlas whose sets are briefs and whose rows are machines
_BRIEF_TABLES = ("requirements", "feel", "limits", "bounds_mm")
AtlasRow = dict[str, Any]  # what came of one set, as plain data; see `cluster.solve`
_OF_STEPS = ("steps", "population", "generations")


class GridError(RequirementsError):
    """A grid file that is refused; fields and message as of `RequirementsError`."""


@dataclass(frozen=True)
class Axis:
    """One axis.

    Attributes:
        field: Dotted field of the requirements file, such as "requirements.joint_torque_N_m".
        values: What it takes, in the order given: numbers, or lists of numbers where the field holds a list.
    """

    field: str
    values: tuple[Any, ...]


@dataclass(frozen=True)
class Set:
    """One set of requirements to be solved; plain data, so that it can travel.

    Attributes:
        index: Its place in the atlas.
        inputs: Field -> value, one for each axis.
        requirements: What a requirements file would hold.
        method: One of `three_step.METHODS`, or `MACHINES`.
        seed: Seed of everything random.
        steps: Which steps.
        population: Individuals of the GA; None for the paper's.
        generations: Generations of the GA.
        folder: Where a brief's own parts are looked for.
    """

    index: int
    inputs: dict[str, Any]
    requirements: dict[str, Any]
    method: str
    seed: int
    steps: tuple[int, ...]
    population: int | None
    generations: int
    folder: str = ""


@dataclass(frozen=True)
class Grid:
    """A grid.

    Attributes:
        name: Safe as a file name.
        axes: In the order of the file; the last one varies fastest.
        sets: Every combination of the axes' values, and for each every seed.
    """

    name: str
    axes: tuple[Axis, ...]
    sets: tuple[Set, ...]

    @property
    def sha256(self) -> str:
        """SHA-256 of everything that decides the results, in hexadecimal."""
        decisive = [[s.requirements, s.method, s.seed, s.steps, s.population, s.generations] for s in self.sets]
        text = json.dumps([self.name, [axis.field for axis in self.axes], decisive], sort_keys=True, allow_nan=False)
        return hashlib.sha256(text.encode("ascii")).hexdigest()


def load_grid(path: str | Path) -> Grid:
    """Reads and validates a grid file.

    Args:
        path: TOML file, UTF-8. `base` is the path of a requirements file, from the grid file's folder, or such a file's
            tables; `[axes]` holds dotted fields, each a list of values or `{linspace = [first, last, count]}` or
            `{geomspace = ...}`; `method`, `seeds`, `steps`, `population`, `generations` and `name` may be left out.
            With the method `MACHINES` base and sets are briefs, and `hardware` may vary by ids, too.

    Returns:
        The grid.

    Raises:
        GridError: Unreadable, not TOML, or anything `grid_from_dict` refuses.
        RequirementsError: The base, or one of the sets, is refused.
    """
    path = Path(path)
    return grid_from_dict(read_toml(path, path.name, GridError), path.name, path.parent)


def grid_from_dict(data: Mapping[str, Any], file: str = "grid", folder: Path = Path()) -> Grid:
    """Validates a grid given as plain data.

    Args:
        data: What the file holds.
        file: Name that error messages start with.
        folder: Where the path of a base starts.

    Returns:
        The grid.

    Raises:
        GridError: Unknown or missing keys, an axis that is no field of a requirements file, values that are not finite,
            twice there or too many, a space that cannot be spread, or a method, seeds, steps or sizes out of range.
        RequirementsError: The base, or one of the sets, is refused.
    """
    for key in data:
        if key not in _KEYS:
            raise GridError(file, str(key), short(data[key]), f"unknown key; known here: {', '.join(_KEYS)}")
    base, where = _base(data, file, folder)
    method = data.get("method", "ga+sqp")
    machines = method == MACHINES
    place = (folder / data["base"]).parent if isinstance(data["base"], str) else folder

    def read(task: dict[str, Any], source: str) -> Requirements | DesignBrief:
        return brief_from_dict(task, source, place) if machines else requirements_from_dict(task, source)

    read(base, where)
    name = data.get("name", base["name"])
    if not isinstance(name, str) or re.fullmatch(NAME_PATTERN, name) is None:
        raise GridError(file, "name", short(name), NAME_RULE)
    if method not in (*METHODS, MACHINES):
        raise GridError(file, "method", short(method), f"must be one of {', '.join((*METHODS, MACHINES))}")
    for key in _OF_STEPS if machines else ():
        if key in data:
            raise GridError(file, key, short(data[key]), f'is of the paper\'s method: method = "{MACHINES}" has none')
    seeds = data.get("seeds", [0])
    if not _naturals(seeds) or len(seeds) > VALUES_MAX:
        allowed = f"must be a list of 1 to {VALUES_MAX} different whole numbers >= 0"
        raise GridError(file, "seeds", short(seeds), allowed)
    steps = data.get("steps", [1, 2, 3])
    if not _naturals(steps) or not set(steps) <= {1, 2, 3} or steps != sorted(steps):
        raise GridError(file, "steps", short(steps), "must be a list of 1, 2, 3, each once at most, in order")
    population = _integer(data, file, "population", None, _POPULATION)
    generations = _integer(data, file, "generations", GENERATIONS, _GENERATION)
    axes = _axes(data.get("axes"), file, machines)
    count = math.prod(len(axis.values) for axis in axes) * len(seeds)
    if count > SETS_MAX:
        raise GridError(file, "axes", "", f"{count:,} sets, seeds included; at most {SETS_MAX:,} are solved at once")
    sets, index = [], 0
    for values in itertools.product(*(axis.values for axis in axes)):
        inputs = {axis.field: value for axis, value in zip(axes, values, strict=True)}
        given = _placed(base, inputs)
        record = read(given, file)
        if isinstance(record, Requirements) and {2, 3} & set(steps) == {3} and record.step_3.half_side_mm is None:
            raise GridError(file, "steps", short(steps), "step 3 needs step 2 or step_3.half_side_mm")
        for seed in seeds:
            sizes = tuple(steps), population, int(generations or 0)
            sets.append(Set(index, inputs, given, method, seed, *sizes, str(place.resolve()) if machines else ""))
            index += 1
    return Grid(name, axes, tuple(sets))


def _base(data: Mapping[str, Any], file: str, folder: Path) -> tuple[dict[str, Any], str]:
    """Reads the base as plain data; with it, what its error messages start with."""
    base = data.get("base")
    if isinstance(base, str):
        return read_toml(folder / base, base, GridError), base
    if isinstance(base, Mapping):
        return dict(base), f"{file}: base"
    kind = "is missing; it must be" if "base" not in data else "must be"
    given = short(base) if "base" in data else ""
    raise GridError(file, "base", given, f"{kind} the path of a requirements file, or its tables")


def _axes(data: object, file: str, machines: bool) -> tuple[Axis, ...]:
    if not isinstance(data, Mapping):
        given = "" if data is None else short(data)
        raise GridError(file, "axes", given, "must be a table of dotted fields")
    axes = tuple(_axis(field, value, file, machines) for field, value in _fields(data, ""))
    if not axes:
        raise GridError(file, "axes", short(dict(data)), "must hold at least one dotted field")
    twice = [axis.field for k, axis in enumerate(axes) if axis.field in [other.field for other in axes[:k]]]
    if twice:
        raise GridError(file, f"axes.{twice[0]}", "", "is given twice")
    return axes


def _fields(data: Mapping[str, Any], path: str) -> list[tuple[str, Any]]:
    """Collects the dotted fields and their values; a field may be written as one quoted key or as nested tables."""
    fields: list[tuple[str, Any]] = []
    for key, value in data.items():
        field = f"{path}.{key}" if path else str(key)
        nested = isinstance(value, Mapping) and "." not in field
        fields += _fields(value, field) if nested else [(field, value)]
    return fields


def _axis(field: str, value: Any, file: str, machines: bool) -> Axis:
    table, _, name = field.partition(".")
    tables: dict[str, Any] = {t: Requirements.model_fields[t].annotation for t in TABLES}
    if machines:
        tables = {t: DesignBrief.model_fields[t].annotation for t in _BRIEF_TABLES} | {"hardware": Hardware}
    model = tables.get(table)
    if not isinstance(model, type) or not issubclass(model, BaseModel) or name not in model.model_fields:
        of = [table] if table in tables else list(tables)
        known = "; ".join(f"{t}.{', '.join(getattr(tables[t], 'model_fields', {}))}" for t in of)
        raise GridError(file, f"axes.{field}", "", f"is no field that can vary; known: {known}")
    where = f"axes.{field}"
    values = _spread(value, where, file) if isinstance(value, Mapping) else value
    if not isinstance(values, list) or not 1 <= len(values) <= VALUES_MAX:
        allowed = f"must be a list of 1 to {VALUES_MAX} values, or {{linspace = [first, last, count]}}, or geomspace so"
        raise GridError(file, where, short(value), allowed)
    for k, one in enumerate(values):
        if not (_numeric(one) or (table == "hardware" and isinstance(one, str))):
            raise GridError(file, f"{where}[{k}]", short(one), "must be a finite number, or a list of such")
        if one in values[:k]:
            raise GridError(file, f"{where}[{k}]", short(one), "is there twice")
    return Axis(field, tuple(values))


def _spread(spec: Mapping[str, Any], where: str, file: str) -> list[float]:
    """Computes the values of a linspace or geomspace."""
    kinds = [key for key in spec if key in _SPACINGS]
    if len(spec) != 1 or len(kinds) != 1:
        raise GridError(file, where, short(dict(spec)), "must hold one key, linspace or geomspace")
    kind, numbers = kinds[0], spec[kinds[0]]
    where = f"{where}.{kind}"
    shape = isinstance(numbers, list) and len(numbers) == 3 and _numeric(numbers)
    if not shape or not isinstance(numbers[2], int) or not 2 <= numbers[2] <= VALUES_MAX:
        allowed = f"must be [first, last, count], finite numbers and 2 to {VALUES_MAX} of them"
        raise GridError(file, where, short(numbers), allowed)
    first, last, count = float(numbers[0]), float(numbers[1]), numbers[2]
    if kind == "geomspace" and not (first > 0.0 and last > 0.0):
        raise GridError(file, where, short(numbers), "both ends must be > 0")
    return [float(v) for v in (np.geomspace if kind == "geomspace" else np.linspace)(first, last, count)]


def _placed(base: dict[str, Any], inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Puts the inputs in their places in the base."""
    given = copy.deepcopy(base)
    for field, value in inputs.items():
        table, _, name = field.partition(".")
        given.setdefault(table, {})[name] = value
    return given


def _integer(data: Mapping[str, Any], file: str, key: str, default: int | None, allowed: tuple[int, int]) -> int | None:
    value = data.get(key, default)
    if key in data and (not _natural(value) or not allowed[0] <= value <= allowed[1]):
        raise GridError(file, key, short(value), f"must be a whole number >= {allowed[0]} and <= {allowed[1]:,}")
    return value


def _natural(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _naturals(value: object) -> bool:
    return isinstance(value, list) and all(_natural(v) for v in value) and 0 < len(value) == len(set(value))


def _numeric(value: object) -> bool:
    if isinstance(value, list):
        return bool(value) and all(not isinstance(v, list) and _numeric(v) for v in value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return math.isfinite(value) if isinstance(value, float) else abs(value) < _INTEGER_MAX
