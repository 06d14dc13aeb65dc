"""The table of fields in optimizer/README.md has every field of the requirements file, as `init` writes it."""

from __future__ import annotations

import re

from tests.committed import ROOT


def test_the_table_has_every_field_with_its_meaning() -> None:
    source = (ROOT / "optimizer" / "commands" / "presets" / "fields.toml").read_text(encoding="utf-8")
    page = (ROOT / "optimizer" / "README.md").read_text(encoding="utf-8")
    tables = re.findall(r"^\[(\w+)\]\s*# (.+)$", source, re.MULTILINE)
    fields = re.findall(r"^# (\w+) = (.+?)  # (.+)$", source, re.MULTILINE)
    assert (len(tables), len(fields) > 40) == (7, True)
    missing = [name for name, text in tables if f"| **`[{name}]`** | | {text} |\n" not in page]
    missing += [name for name, value, text in fields if f"| `{name}` | `{value}` | {text} |\n" not in page]
    assert missing == []
