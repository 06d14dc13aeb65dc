"""The page of hazards: each check and test that it names exists, and no fault code or hardware function is left out."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

from haptics.control.supervisor.faults import FaultCode
from haptics.firmware.ports import files_of_ports

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "reference" / "hazards.md").read_text(encoding="utf-8")
COLUMNS = ["hazard", "cause", "effect", "S", "detection", "reaction", "test", "residual risk"]
PORTS = files_of_ports()
HARDWARE = set(re.findall(r"\b(hal_\w+)\(", PORTS["delta_hal.h"]))


def rows() -> list[dict[str, str]]:
    """Rows of all tables by their columns."""
    lines = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in PAGE.splitlines() if line[:2] == "| "]
    assert all(len(line) == len(COLUMNS) for line in lines)
    return [dict(zip(COLUMNS, line, strict=True)) for line in lines if line != COLUMNS]


def missing(name: str) -> str | None:
    """What a name in code stands for and does not exist; None if it does."""
    if "::" in name:
        path, test = name.split("::")
        found = (ROOT / path).is_file() and re.search(rf"^def {test}\(", (ROOT / path).read_text(), re.MULTILINE)
    elif name.startswith("FaultCode."):
        found = name.split(".")[1] in FaultCode.__members__
    elif re.fullmatch(r"[\w/-]+\.[ch]:\w+", name):
        path, function = name.split(":")
        found = re.search(rf"^[\w ]+ \*?{function}\([^;{{]*\)\s*{{", PORTS.get(path, ""), re.MULTILINE)
    elif name.startswith("hal_"):
        found = name in HARDWARE
    elif name.startswith("haptics."):
        module, _, attribute = name.rpartition(".")
        found = hasattr(importlib.import_module(module), attribute)
    else:
        found = name in PORTS or name == "README.md" or (ROOT / name).is_file() or name == "code"
    return None if found else name


def test_each_name_on_the_page_exists() -> None:
    names = re.findall(r"`([^`]+)`", PAGE)
    assert len(names) > 80
    assert [name for name in names if missing(name)] == []


def test_a_name_that_does_not_exist_is_found() -> None:
    for name in ("FaultCode.NONE", "hal_nothing", "drivers/mt6835.c:crc16", "drivers/none.c:crc", "none.c",
                 "haptics.control.supervisor.supervisor.none", "tests/docs/test_hazards.py::test_none"):  # fmt: skip
        assert missing(name) == name


def test_each_row_is_whole() -> None:
    for row in rows():
        assert all(row.values()), row
        assert row["S"] in "123", row
        assert "::test_" in row["test"], row
        assert "`" in row["detection"] or row["detection"].startswith(("none", "the ")), row


def test_no_fault_code_and_no_function_of_the_hardware_is_left_out() -> None:
    cells = " ".join(row["detection"] + row["reaction"] + row["cause"] for row in rows())
    assert {code.name for code in FaultCode if f"`FaultCode.{code.name}`" not in cells} == set()
    assert {name for name in HARDWARE if f"`{name}`" not in cells} == set()
