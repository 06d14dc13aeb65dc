"""The JSON Schema of the design file: it takes what the reader takes and refuses what the reader refuses."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import pytest
from hypothesis import given

from delta_cad.catalogue import CatalogueError
from delta_cad.design import Design, design_schema, design_to_json
from tests.committed import BEST
from tests.delta_cad.design.json_schema import violations
from tests.designs import UNTIMED, changed, designs, minimal


def test_the_schema_accepts_what_the_reader_accepts() -> None:
    schema = design_schema()
    assert violations(schema, json.loads(BEST.read_text(encoding="utf-8")), schema) == []
    assert violations(schema, minimal(), schema) == []
    assert violations(schema, json.loads(json.dumps(schema["$defs"]["Hardware"]["properties"])), schema) != []


def test_one_base_radius_is_enough_or_those_of_the_chains() -> None:
    schema, data = design_schema(), changed("mechanism.base_radii_mm", [40.0, 42.0, 42.0])
    assert violations(schema, data, schema) == []
    del data["mechanism"]["base_radius_mm"]
    assert violations(schema, data, schema) == []
    data["mechanism"]["base_radii_mm"] = None
    assert violations(schema, data, schema) != []


@UNTIMED
@given(design=designs())
def test_the_schema_accepts_every_written_design(design: Design) -> None:
    schema = design_schema()
    assert violations(schema, json.loads(design_to_json(design)), schema) == []


def test_the_schema_is_json_and_does_not_change_when_read() -> None:
    schema = design_schema()
    untouched = copy.deepcopy(schema)
    schema["$defs"]["Hardware"]["else"]["properties"]["motor"]["enum"].clear()
    assert design_schema() == untouched == json.loads(json.dumps(untouched))


def test_the_schema_takes_own_ids_where_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "cable.csv").write_text("id,diameter_mm,breaking_load_N\nmine,0.5,150\n", encoding="utf-8")
    own, known = design_schema(), design_schema(tmp_path)
    for hardware, accepted in (
        ({"cable": "mine"}, (False, False)),
        ({"cable": "mine", "catalogue": None}, (False, False)),
        ({"cable": "mine", "catalogue": "parts"}, (True, True)),
        ({"cable": "yours", "catalogue": "parts"}, (True, False)),
        ({"cable": "steel-0.54-7x7", "catalogue": "parts"}, (True, True)),
        ({"catalogue": ""}, (False, False)),
    ):
        data = changed("hardware", hardware)
        assert tuple(violations(schema, data, schema) == [] for schema in (own, known)) == accepted, hardware
    with pytest.raises(CatalogueError):
        design_schema(tmp_path / "none")
