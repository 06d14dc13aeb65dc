"""What requirements are refused with, as the files in refused/ have it: field, value and bound of each line."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from optimizer.problem.brief import MOVED
from optimizer.problem.quantity import KINDS, QuantityError, pattern, quantity
from optimizer.problem.schema import brief_schema
from tests.delta_cad.design.json_schema import violations
from tests.designs import named
from tests.optimizer.messages import holds
from tests.optimizer.problem.requirements import CUBE, OUTLINE, first_edition, lines_of_brief, lines_of_requirements


def cases(name: str) -> list[dict[str, Any]]:
    return tomllib.loads((Path(__file__).parent / f"refused/{name}.toml").read_text(encoding="utf-8"))["case"]


def merged(base: dict[str, Any], more: dict[str, Any]) -> dict[str, Any]:
    both = {key: merged(base[key], more[key]) for key in base.keys() & more.keys() if isinstance(more[key], dict)}
    return base | more | both


def twice(old: str, new: str) -> dict[str, Any]:
    """A brief with one number in both its places."""
    value = [0, 0, 1] if "gravity" in old else 2 if "kappa" in old else 0.5
    tables: dict[str, Any] = {"requirements": dict(OUTLINE)}
    for field in (old, new):
        table, name = field.split(".")
        tables.setdefault(table, {})[name] = value
    return {"tables": tables, "says": [f"{old} = "]}


MANY = {"requirements": CUBE, "hardware": {"motor": ["maxon-re30-310007"] * 101}}
BRIEFS = [
    *cases("brief"),
    {"tables": MANY, "says": ["hardware.motor = "]},
    *(twice(old, new) for old, new in MOVED.items()),
]


@pytest.mark.parametrize("case", cases("requirements"), ids=named)
def test_the_first_edition_is_refused_by_field_value_and_bound(case: dict[str, Any]) -> None:
    data = merged(first_edition(), case.get("set", {}))
    if (left_out := case.get("without")) is not None:
        *tables, name = left_out.split(".")
        del (data[tables[0]] if tables else data)[name]
    first, *_ = lines_of_requirements(data)
    assert holds(first, case["says"])


@pytest.fixture(scope="module")
def schema() -> dict[str, Any]:
    return brief_schema()


@pytest.mark.parametrize("case", BRIEFS, ids=named)
def test_a_brief_is_refused_by_field_value_and_bound_and_by_the_schema(
    case: dict[str, Any], schema: dict[str, Any]
) -> None:
    data = {"name": "d"} | case["tables"]
    found = lines_of_brief(data)
    for line, wanted in zip(found, case.get("says", found), strict=True):
        assert wanted in line or holds(line, wanted), (line, wanted)
    assert bool(violations(schema, data, schema)) is not case.get("reader_alone", False)


@pytest.mark.parametrize("case", cases("quantity"), ids=named)
def test_a_text_that_is_no_quantity_is_refused_with_what_to_write(case: dict[str, Any]) -> None:
    text, unit = case["text"], case["unit"]
    with pytest.raises(QuantityError) as caught:
        quantity(text, unit)
    assert all(word in str(caught.value) for word in case["says"]), str(caught.value)
    assert unit not in KINDS or not re.fullmatch(pattern(unit), text) or "finite" in case["says"]
