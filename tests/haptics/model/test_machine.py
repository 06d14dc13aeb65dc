"""Machines that haptics refuses before it drives them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from haptics.commands.cli import main
from tests.designs import below_elbows, changed


def pocket() -> dict[str, Any]:
    """A cube whose corners are within reach and an edge of whose floor is not: chain 1 folds there, off its plane."""
    data = changed("cube", {"bottom_height_mm": 30.945, "half_side_mm": 20.0})
    data["mechanism"] |= {"base_radius_mm": 65.0, "platform_radius_mm": 40.0, "forearm_length_mm": 113.0}
    return data


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (below_elbows(), "assembly mode det S > 0"),
        (pocket(), "within reach at every position"),
    ],
)
@pytest.mark.parametrize(
    "command",
    [["simulate", "--scene", "wall"], ["stiffness"], ["feel"], ["gravity", "--at", "0,0,44"], ["firmware"], ["board"]],
)
def test_a_machine_that_cannot_be_driven_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: list[str], data: dict[str, object], named: str
) -> None:
    path = tmp_path / "design.json"
    path.write_text(json.dumps(data))
    more = ["--out", str(tmp_path / "out")] if command[0] in ("simulate", "firmware") else []
    assert main([command[0], "--design", str(path), *command[1:], *more]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert err.startswith("design.json: cube.bottom_height_mm = ")
    assert named in err
    assert not (tmp_path / "out").exists()
