"""The example that has a panel over it: its data, changed where a test asks, its dimensions and its machine."""

from __future__ import annotations

import json
from copy import deepcopy
from functools import cache
from typing import Any

from delta_cad.commands.pipeline import BuiltMachine, make_machine
from delta_cad.design import Design, design_from_dict
from delta_cad.dimensions import Dimensions, dimensions
from tests.committed import ROOT

PANEL = ROOT / "examples" / "dashboard-panel.json"
DATA: dict[str, Any] = json.loads(PANEL.read_text())


def with_panel(**values: Any) -> Design:
    """The example with some entries changed, as "section__field" or "section"; None takes away."""
    data = deepcopy(DATA)
    for name, value in values.items():
        section, _, field = name.partition("__")
        place, key = (data.setdefault(section, {}), field) if field else (data, section)
        place[key] = value
        if value is None:
            del place[key]
    return design_from_dict(data)


def of_panel(**values: Any) -> Dimensions:
    """The dimensions of the same."""
    return dimensions(with_panel(**values))


@cache
def machine() -> BuiltMachine:
    """The example made solid, once in a process."""
    return make_machine(with_panel())
