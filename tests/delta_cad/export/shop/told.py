"""What a part's STEP file states as data and what its drawing shows, counted alike: each by its plain text."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from tests.delta_cad.export.drawings.reading import svg_symbols, svg_texts
from tests.delta_cad.export.shop.reading import entities, of_kind, strings

ZONES = ("position", "perpendicularity", "coaxiality")
HOLES = re.compile(r"(?:(?P<count>\d+)x )?S?(?:Ø[\d.]+ (?P<fit>[A-Za-z]\d+)|(?P<thread>M[\d.]+))(?= |$)")


def of_step(path: Path) -> Counter[str]:
    """Counts fits by class, threads by size, geometric tolerances by kind and datums by letter of a STEP file."""
    found = entities(path)
    told = Counter(strings(text)[0] + strings(text)[2] for text in of_kind(found, "LIMITS_AND_FITS"))
    for text in of_kind(found, "DESCRIPTIVE_REPRESENTATION_ITEM"):
        name, *value = [*strings(text), ""]
        if name == "thread":
            told[re.match(r"M[\d.]+", value[0])[0]] += 1  # type: ignore[index]
    for kind in ZONES:
        told[kind] += len(of_kind(found, f"{kind.upper()}_TOLERANCE"))
    told.update({f"datum {letter}" for letter in (strings(text)[-1] for text in of_kind(found, "DATUM"))})
    return +told


def of_drawing(path: Path) -> Counter[str]:
    """Counts the same of a drawing's SVG."""
    told: Counter[str] = Counter()
    texts = svg_texts(path)
    for text, after in zip(texts, [*texts[1:], ""], strict=True):  # a callout may go on in the next line
        if match := HOLES.match(text):
            both = match["fit"] and ("from both" in text or after.startswith("from both"))  # a thread is one hole
            told[match["fit"] or match["thread"]] += int(match["count"] or 1) * (2 if both else 1)
    told.update(symbol.split(" ")[0] for symbol in svg_symbols(path) if symbol.startswith(ZONES))
    told.update({symbol for symbol in svg_symbols(path) if symbol.startswith("datum ")})
    return told


def differences(folder: Path) -> dict[str, tuple[Counter[str], Counter[str]]]:
    """Gives of each made part of a build whose two files do not say the same what STEP file and drawing say."""
    parts = {path.stem: of_step(path) for path in sorted((folder / "parts").glob("*.step"))}
    drawn = {name: of_drawing(folder / "drawings" / f"{name}.svg") for name in parts}
    return {name: (parts[name], drawn[name]) for name in parts if parts[name] != drawn[name]}
