"""The JSON Schema of the requirements file: it takes what the reader takes and refuses what the reader refuses."""

from __future__ import annotations

import copy
import json
import math
import tomllib
from pathlib import Path
from typing import Any

import pytest

from delta_cad import catalogue
from optimizer.commands.init import PRESETS, preset_text
from optimizer.problem.brief import MOVED, UNUSED, DesignBrief, brief_from_dict
from optimizer.problem.requirements import RequirementsError
from optimizer.problem.schema import brief_schema
from tests.committed import ROOT
from tests.delta_cad.design.json_schema import violations
from tests.optimizer.problem.requirements import CUBE, OUTLINE, second_edition

LEAST = math.nextafter(0.0, 1.0)
TAKEN: list[dict[str, Any]] = [
    {"requirements": OUTLINE},
    {"requirements": CUBE},
    {"requirements": OUTLINE | CUBE, "goal": {"minimize": "cost"}},
    {"requirements": CUBE, "goal": {}, "feel": {}, "limits": {}, "bounds_mm": {}, "hardware": {}, "step_3": {}},
    {"requirements": {"cube_side_mm": "12 cm", "force_N": "3 N", "gravity_m_s2": [0, 0, "9.81 m/s²"]}},
    {"requirements": CUBE, "limits": {"shoulder_deg": ["-60 deg", "1 rad"]}, "feel": {"stiffness_min_N_mm": "8 kN/m"}},
    {"requirements": CUBE, "hardware": {"motor": ["maxon-re30-310007", "maxon-re30-310009"], "drive": "capstan"}},
    {"requirements": CUBE, "hardware": {"capstan_ratio": [4, 5.5], "sector_radius_mm": ["38.7 mm"]}},
    {"requirements": CUBE, "limits": {"gravity_m_s2": [0, 0, 1], "clearance_min_mm": 1, "kappa_max": 2}},
]


def named(tables: dict[str, Any]) -> dict[str, Any]:
    return {"name": "d"} | tables


def taken(data: dict[str, Any]) -> bool:
    try:
        brief_from_dict(data)
    except RequirementsError:
        return False
    return True


@pytest.fixture(scope="module")
def schema() -> dict[str, Any]:
    return brief_schema()


@pytest.mark.parametrize("tables", TAKEN, ids=[json.dumps(t)[:60] for t in TAKEN])
def test_it_takes_what_the_reader_takes(tables: dict[str, Any], schema: dict[str, Any]) -> None:
    assert taken(named(tables))
    assert violations(schema, named(tables), schema) == []


def test_it_takes_files_of_both_editions(schema: dict[str, Any]) -> None:
    for path in (ROOT / "examples/synthesized.toml", ROOT / "tests/references/joystick.toml"):
        assert violations(schema, tomllib.loads(path.read_text(encoding="utf-8")), schema) == []
    assert violations(schema, second_edition(), schema) == []
    for preset in PRESETS:
        assert violations(schema, tomllib.loads(preset_text(preset)), schema) == []


@pytest.mark.parametrize("change", [-1, 1])
def test_every_bound_is_the_readers(change: int, schema: dict[str, Any]) -> None:
    """Each number on each of its bounds, and the next double beyond."""
    tried = 0
    for table, record in schema["properties"].items():
        for field, inner in record.get("properties", {}).items():
            rules = next((one for one in inner.get("anyOf", [inner]) if one.get("type") == "number"), None)
            if rules is None or table in ("inertia", "hardware") or f"{table}.{field}" in (*MOVED, *UNUSED):
                continue
            keys = ("exclusiveMinimum", "minimum") if change < 0 else ("exclusiveMaximum", "maximum")
            for bound in (rules[key] for key in keys if key in rules):
                for value in (
                    float(bound),
                    math.nextafter(bound, bound + change),
                    math.nextafter(bound, bound - change),
                ):
                    data = named({"requirements": {"cube_side_mm": 1.0, "clearance_min_mm": 0.0}})
                    data[table] = data.get(table, {}) | {field: value}
                    if field.startswith("envelope"):
                        data[table] |= {"envelope_width_mm": value, "envelope_depth_mm": value}
                    if value == LEAST:
                        continue  # within its bounds, but less than the cube, the force for ever, or what a proof takes
                    assert (violations(schema, data, schema) == []) == taken(data), (table, field, value)
                    tried += 1
    assert tried > 20


def test_units_bounds_choices_and_what_is_old_are_reported(schema: dict[str, Any]) -> None:
    properties = schema["properties"]
    assert "[mm]" in properties["requirements"]["properties"]["cube_side_mm"]["description"]
    assert properties["requirements"]["properties"]["force_N"]["default"] == 3.0
    motors = properties["hardware"]["else"]["properties"]["motor"]["anyOf"][0]["enum"]
    assert motors == [k for k, row in catalogue.family("motor").items() if "none" not in getattr(row, "drives", ())]
    assert properties["hardware"]["properties"]["drive"]["anyOf"][0]["enum"] == ["capstan", "direct"]
    for field in (*MOVED, *(f for f in UNUSED if "." in f)):
        table, name = field.split(".")
        assert properties[table]["properties"][name]["deprecated"]
    for table, record in properties.items():
        assert record["description"], table
        for field, inner in record.get("properties", {}).items():
            assert inner["description"], (table, field)
    assert set(properties) == set(DesignBrief.model_fields)
    assert "null" not in json.dumps(schema)


def test_it_is_json_and_does_not_change_when_read(schema: dict[str, Any]) -> None:
    untouched = copy.deepcopy(schema)
    again = brief_schema()
    again["properties"].clear()
    assert brief_schema() == untouched == json.loads(json.dumps(untouched))


def test_it_takes_own_ids_where_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "cable.csv").write_text("id,diameter_mm,breaking_load_N\nmine,0.5,150\n", encoding="utf-8")
    own, known = brief_schema(), brief_schema(catalogue.own_parts(tmp_path))
    for hardware, accepted in (
        ({"cable": "mine"}, (False, False)),
        ({"cable": "mine", "catalogue": "parts"}, (True, True)),
        ({"cable": ["yours"], "catalogue": "parts"}, (True, False)),
        ({"cable": ["steel-0.54-7x7", "mine"], "catalogue": "parts"}, (True, True)),
        ({"catalogue": ""}, (False, False)),
    ):
        data = named({"requirements": CUBE, "hardware": hardware})
        assert tuple(violations(schema, data, schema) == [] for schema in (own, known)) == accepted, hardware
