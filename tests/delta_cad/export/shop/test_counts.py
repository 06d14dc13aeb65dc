"""What a part's STEP file has as data is what its drawing shows, of every made part of the one real build.

The drawing is read from its SVG, the STEP file from its Part 21 text: neither by what wrote it.
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import pytest

from delta_cad.assembly.machine import Assembly
from tests.committed import Built
from tests.delta_cad.export.drawings.reading import SVG, svg_symbols
from tests.delta_cad.export.shop.test_pmi import Entities, entities, measures, of_kind, strings

KINDS = ("position", "perpendicularity", "coaxiality")


def shown(path: Path) -> list[str]:
    """What stands on a drawing outside of its title block, a callout's lines together."""
    root = ElementTree.parse(path).getroot()
    width, height = (float((root.get(side) or "").removesuffix("mm")) for side in ("width", "height"))
    sheets = max(1, round(width / 420.0)) if width > 300.0 else 1
    edges = [width / sheets * (k + 1) - 191.0 for k in range(sheets)]
    found: list[str] = []
    for text in root.iter(f"{SVG}text"):
        x, y, words = float(text.get("x") or 0), float(text.get("y") or 0), text.text or ""
        if y > height - 59.0 and any(edge < x < edge + 191.0 for edge in edges):
            continue
        if words.startswith("from both sides") and found:
            found[-1] += f" {words}"
        else:
            found.append(words)
    return found


def drawn(path: Path) -> Counter[str]:
    """Fits by class, threads by size and symmetric tolerances on a drawing; frames and datums by their symbols."""
    counts: Counter[str] = Counter()
    for text in shown(path):
        match = re.match(r"(?:(\d+)x )?(.*)", text)
        assert match is not None
        times = int(match[1] or 1) * (2 if "H7" in text and "from both sides" in text else 1)
        for fit in re.findall(r"([A-Za-z]\d+) \([+-]?[\d.]+/[+-]?[\d.]+\)", text):
            counts[fit] += times
        counts["own"] += times * len(re.findall(r"Ø[\d.]+ \+[\d.]+/0", text))
        if thread := re.match(r"M[\d.]+", match[2]):
            counts[thread[0]] += times
        counts["either"] += times * (text.count("±") - text.count("delivered SØ"))  # data are of what is assembled
        counts["own"] += len(re.findall(r"^-?[\d.]+ (?:0|\+[\d.]+)/-[\d.]+$", text))  # of a length
        counts["own"] += times * len(re.findall(r"^slot [\d.]+ H7 wide", match[2]))  # limits of a width, in a STEP file
    for symbol in svg_symbols(path):
        if symbol.split()[0] in KINDS or symbol.startswith("datum"):
            counts[symbol] += 1
    return +counts


def stated(found: Entities) -> Counter[str]:
    """The same in a STEP file."""
    fits = [strings(text)[0] + strings(text)[2] for text in of_kind(found, "LIMITS_AND_FITS")]
    counts = Counter(fits)
    limits = [sorted(measures(found, [text])) for text in of_kind(found, "TOLERANCE_VALUE")]
    counts["either"] = sum(low == -high for low, high in limits)
    counts["own"] = len(limits) - counts["either"] - len(fits)
    for name, *value in (strings(text) for text in of_kind(found, "DESCRIPTIVE_REPRESENTATION_ITEM") if strings(text)):
        if name == "thread":
            counts[re.match(r"M[\d.]+", value[0])[0]] += 1  # type: ignore[index]
    for text in of_kind(found, "DATUM"):
        counts[f"datum {strings(text)[-1]}"] += 1
    for kind in KINDS:
        for text in of_kind(found, f"{kind.upper()}_TOLERANCE"):
            (value,) = set(measures(found, [text]))
            combined = " CZ" if "COMMON_ZONE" in text else ""
            counts[f"{kind} {_zone(found, text)}{value:g}{combined} {_letters(found, text)}"] += 1
    return +counts


def _letters(found: Entities, text: str) -> str:
    """Datums that a tolerance counts from, in order: its datum system's compartments, each of one datum."""
    match = re.search(r"GEOMETRIC_TOLERANCE_WITH_DATUM_REFERENCE\(\(#(\d+)\)\)", text)
    assert match is not None
    compartments = re.findall(r"#(\d+)", found[int(match[1])].rpartition("(")[2])
    return " ".join(strings(found[int(_last(found[int(number)]))])[-1] for number in compartments)


def _last(text: str) -> str:
    """The datum that a compartment names: the one of its references that is a DATUM."""
    return re.findall(r"#(\d+)", text)[-1]


def _zone(found: Entities, text: str) -> str:
    """Whether a tolerance's zone is round: a TOLERANCE_ZONE of it has a form that says so."""
    (number,) = (number for number, other in found.items() if other is text)
    zones = [other for other in of_kind(found, "TOLERANCE_ZONE") if f"(#{number})" in other]
    forms = [found[int(re.findall(r"#(\d+)", zone)[-1])] for zone in zones]
    return "Ø" if any("cylindrical or circular" in form for form in forms) else ""


def differences(folder: Path) -> dict[str, tuple[Counter[str], Counter[str]]]:
    """What STEP file and drawing say of each made part of a build of which they do not say the same.

    Of a spring the file has no shape to which its sheet's loads and diameters belong.
    """
    files = [path for path in sorted((folder / "parts").glob("*.step")) if not path.stem.endswith("_spring")]
    data = {path.stem: stated(entities(path)) for path in files}
    paper = {number: drawn(folder / "drawings" / f"{number}.svg") for number in data}
    return {number: (data[number], paper[number]) for number in data if data[number] != paper[number]}


def test_data_and_drawing_of_every_made_part_say_the_same(built: Built, best_assembly: Assembly) -> None:
    files = [built.folder / "parts" / f"{part.number}.step" for part in best_assembly.parts if part.is_drawn]
    assert len(files) == 21
    assert differences(built.folder) == {}
    total = sum((stated(entities(path)) for path in files), Counter())
    assert sum(total[fit] for fit in ("H6", "H7", "G7", "h6", "h7")) >= 25
    assert sum(count for key, count in total.items() if key.split()[0] in KINDS) >= 15
    assert min(total[one] for one in ("H7", "h6", "M3", "datum A", "position Ø0.05 CZ A")) > 0


@pytest.mark.parametrize(("old", "new"), [("Ø0.05", "Ø0.06"), ("H7 (+0.018/0)", "H8"), ("datum B", "datum D")])
def test_a_drawing_that_says_something_else_is_noticed(built: Built, tmp_path: Path, old: str, new: str) -> None:
    text = (built.folder / "drawings" / "motor_cheek.svg").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "other.svg").write_text(text.replace(old, new), encoding="utf-8")
    data = stated(entities(built.folder / "parts" / "motor_cheek.step"))
    assert drawn(tmp_path / "other.svg") != data == drawn(built.folder / "drawings" / "motor_cheek.svg")
