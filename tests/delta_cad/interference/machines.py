"""Machines that solids refused, as changes of files of the checkout: `machines.json`; null: left out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from delta_cad.design import Design, design_from_dict
from tests.committed import ROOT

SECTIONS = {"mechanism", "cube", "hardware", "requirements"}
CHANGES: dict[str, dict[str, Any]] = json.loads(Path(__file__).with_name("machines.json").read_text())


def of(path: str, **values: Any) -> Design:
    """A machine of the gallery or the examples with some of its numbers changed; None: left out."""
    data = json.loads((ROOT / path).read_text())
    for name, value in values.items():
        section, _, field = name.partition("__")
        data[section][field] = value
        if value is None:
            del data[section][field]
    return design_from_dict(data)


def machine(name: str, **values: Any) -> Design:
    """A machine of the file, by its name, with more numbers changed."""
    one = CHANGES[name]
    changes = {
        f"{section}__{field}": one[section][field] for section in SECTIONS & one.keys() for field in one[section]
    }
    return of(one["of"], **(changes | values))


def synthesized(**values: Any) -> Design:
    """The example's machine, loaded little and free of an outline, with some of its numbers changed."""
    return machine("synthesized", **values)
