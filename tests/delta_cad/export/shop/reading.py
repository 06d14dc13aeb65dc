"""The instances of a STEP file by its plain text, without the kernel."""

from __future__ import annotations

import re
from pathlib import Path

Entities = dict[int, str]


def entities(path: Path) -> Entities:
    """Number -> text of every instance of a Part 21 file, blanks outside strings left out."""
    body = path.read_text().split("DATA;", 1)[1]
    pieces = re.split(r"('(?:[^']|'')*')", body)
    text = "".join(piece if k % 2 else re.sub(r"\s+", "", piece) for k, piece in enumerate(pieces))
    found: Entities = {}
    for match in re.finditer(r"#(\d+)=((?:'(?:[^']|'')*'|[^;'])*);", text):
        found[int(match[1])] = match[2]
    return found


def of_kind(found: Entities, kind: str) -> list[str]:
    """Instances that are of a kind, alone or beside others."""
    return [text for text in found.values() if re.search(rf"(^|[()]){kind}\(", text)]


def strings(text: str) -> list[str]:
    """The strings of an instance."""
    return [one.replace("\n", "").replace("''", "'") for one in re.findall(r"'((?:[^']|'')*)'", text)]
