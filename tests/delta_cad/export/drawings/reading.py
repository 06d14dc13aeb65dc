"""A DXF and an SVG by their plain text, without any reader of theirs."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

SVG = "{http://www.w3.org/2000/svg}"
Entity = list[tuple[int, str]]


def entities(text: str, section: str = "ENTITIES") -> list[Entity]:
    """Entities of a DXF's section by its plain lines: group codes and values."""
    assert text.isascii()
    for code, sign in (("%%c", "Ø"), ("%%p", "±"), ("%%d", "°")):
        text = text.replace(code, sign)
    lines = text.splitlines()
    pairs = [(int(code), value) for code, value in zip(lines[::2], lines[1::2], strict=True)]
    found: list[Entity] = []
    for code, value in pairs[pairs.index((2, section)) + 1 :]:
        if (code, value) == (0, "ENDSEC"):
            return found
        if code == 0:
            found.append([])
        found[-1].append((code, value))
    return found


def blocks(text: str) -> dict[str, list[Entity]]:
    """What is in each block of a DXF."""
    found: dict[str, list[Entity]] = {}
    name = ""
    for entity in entities(text, "BLOCKS"):
        if entity[0][1] == "BLOCK":
            name = dict(entity)[2]
            found[name] = []
        elif entity[0][1] != "ENDBLK":
            found[name].append(entity)
    return found


def dxf_texts(text: str) -> list[str]:
    """All that stands on a DXF's sheet, those of a dimension where it comes."""
    inside, found = blocks(text), list[str]()
    for entity in entities(text):
        kind, own = entity[0][1], dict(entity)
        parts = inside[own[2]] if kind == "DIMENSION" else [entity]
        found += [dict(part)[1] for part in parts if part[0][1] == "TEXT"]
    return found


def styles(text: str) -> dict[str, float]:
    """Scale of each dimension style of a DXF: what a length on the sheet is multiplied by."""
    return {dict(one)[2]: float(dict(one).get(144, "1")) for one in entities(text, "TABLES") if one[0][1] == "DIMSTYLE"}


def svg_texts(path: Path) -> list[str]:
    """All that stands on an SVG."""
    return [element.text or "" for element in ElementTree.parse(path).getroot().iter(f"{SVG}text")]


def svg_symbols(path: Path) -> list[str]:
    """What each symbol of an SVG says."""
    groups = (g for g in ElementTree.parse(path).getroot().iter(f"{SVG}g") if g.get("class") == "symbol")
    return [group.findtext(f"{SVG}desc") or "" for group in groups]
