"""The lettering of a drawing: its faces, their true widths, and what of them the files carry.

DejaVu Sans comes with matplotlib, Droid Sans Fallback (Chinese, Japanese, Korean) with this package; both are set
narrower, which ISO 3098 leaves free. A letter that neither has is shown as `SUBSTITUTE`, and `missing` names it for a
note on the sheet; so is one that is written from the right, which needs more than letters in a row.
"""

from __future__ import annotations

import unicodedata
from base64 import b64encode
from collections.abc import Iterable
from functools import lru_cache
from importlib.util import find_spec
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

FACES = ("DejaVu Sans", "Droid Sans Fallback")
FAMILIES = ", ".join([*(f"Lettering{face}" for face in range(len(FACES))), FACES[0], "Arial", "sans-serif"])
NARROW = 0.85  # of a face's own width
ENCODING = "cp1252"
LINE = 1.6  # from line to line, in heights of the capitals
SURFACE, SURFACE_WIDE = "\ue000", 1.25
"""Stands in a text for the symbol of a surface, which is drawn where the text is set; how wide, in heights."""
SUBSTITUTE = "\u25a1"  # a square
_LEFT_OUT = "\u2026"
_FROM_THE_RIGHT = {"R", "AL", "AN"}  # classes of direction, of Unicode
_LAST = "\uffff"  # a DXF file has no number for a letter beyond
_NAMED = 12  # letters that a note names


@lru_cache(maxsize=len(FACES))
def _face(face: int) -> Any:
    from fontTools.ttLib import TTFont

    return TTFont(_file(face), lazy=True)


def _file(face: int = 0) -> Path:
    if face:
        return Path(__file__).parent / "faces" / "DroidSansFallback.ttf"
    found = find_spec("matplotlib")
    if found is None or not found.submodule_search_locations:
        raise ModuleNotFoundError("No module named 'matplotlib'", name="matplotlib")
    return Path(found.submodule_search_locations[0]) / "mpl-data" / "fonts" / "ttf" / "DejaVuSans.ttf"


@lru_cache(maxsize=len(FACES))
def _advances(face: int) -> dict[int, float]:
    """Character's code -> how far it goes on, in ems, narrowed."""
    read = _face(face)
    widths, em = read["hmtx"].metrics, float(read["head"].unitsPerEm)
    return {code: NARROW * widths[name][0] / em for code, name in read.getBestCmap().items()}


@lru_cache(maxsize=4096)
def _face_of(letter: str) -> int | None:
    """Number of the first face that has a letter; None where none has it, or it is not one to be set as it comes."""
    if letter > _LAST or not letter.isprintable() or unicodedata.bidirectional(letter) in _FROM_THE_RIGHT:
        return None
    return next((face for face in range(len(FACES)) if ord(letter) in _advances(face)), None)


def _composed(text: str) -> str:
    """The text with letters and their accents in one, and every kind of space as one."""
    found = unicodedata.normalize("NFC", text)
    return "".join(" " if unicodedata.category(letter) == "Zs" else letter for letter in found)


@lru_cache(maxsize=4096)
def shown(text: str) -> str:
    """Gives a text as it is shown, with a substitute for each letter that no face has."""
    return "".join(letter if _face_of(letter) is not None else SUBSTITUTE for letter in _composed(text))


def missing(texts: Iterable[str]) -> list[str]:
    """Names the letters of texts that are shown by a substitute, such as "U+1F600", in the order of their codes."""
    letters = {letter for text in texts for letter in _composed(text.replace(SURFACE, "")) if _face_of(letter) is None}
    return [f"U+{ord(letter):04X}" for letter in sorted(letters)]


def missing_note(texts: Iterable[str]) -> str:
    """Says which letters of texts are shown by a substitute; "" where none is."""
    names = missing(texts)
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    listed = f"{', '.join(names[:_NAMED])}{more}"
    return f"{SUBSTITUTE} stands for what the lettering lacks: {listed}; see bom.csv" if names else ""


class Run(NamedTuple):
    """A part of a shown text that one face sets; `coded`: in the files' encoding, which the first face has whole."""

    face: int
    coded: bool
    text: str


def runs(text: str) -> list[Run]:
    """Splits a text, as it is shown, where the face or its encoding changes."""

    def kind(letter: str) -> tuple[int, bool]:
        return _face_of(letter) or 0, _encodable(letter)

    return [Run(*key, "".join(letters)) for key, letters in groupby(shown(text), kind)]


@lru_cache(maxsize=4096)
def width_of(text: str, height_mm: float) -> float:
    """Computes how long a text is, mm.

    Args:
        text: One line.
        height_mm: Height of its capitals.
    """
    plain = text.replace(SURFACE, "")
    ems = sum(_advances(_face_of(letter) or 0)[ord(letter)] for letter in shown(plain))
    return height_mm * SURFACE_WIDE * (len(text) - len(plain)) + em_mm(height_mm) * ems


def wrapped(text: str, height_mm: float, most_mm: float) -> list[str]:
    """Breaks a text into lines of at most a width between its words; a longer word has a line of its own."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and width_of(longer, height_mm) > most_mm:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


def fitted(text: str, height_mm: float, most_mm: float, most_lines: int) -> list[str]:
    """Breaks a text into so many lines of at most a width, within words that are longer; what is left out shows so.

    Args:
        text: One line.
        height_mm: Height of its capitals.
        most_mm: Width of a line.
        most_lines: At least one.
    """
    lines: list[str] = []
    for line in wrapped(text, height_mm, most_mm):
        rest = line
        while (count := _fits(rest, height_mm, most_mm)) < len(rest):
            lines.append(rest[:count])
            rest = rest[count:]
        lines.append(rest)
    if len(lines) > most_lines:
        last = lines[most_lines - 1]
        last = last[: _fits(last, height_mm, most_mm - width_of(_LEFT_OUT, height_mm))]
        lines = [*lines[: most_lines - 1], last + _LEFT_OUT]
    return lines


def _fits(text: str, height_mm: float, most_mm: float) -> int:
    """How many letters from the start are at most so long; at least one."""
    low, high = 1, len(text)
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if width_of(text[:middle], height_mm) <= most_mm else (low, middle - 1)
    return low


def em_mm(height_mm: float) -> float:
    """Gives the size of a face, its em, for a height of the first one's capitals."""
    face = _face(0)
    return height_mm * face["head"].unitsPerEm / face["glyf"]["H"].yMax


def metrics(face: int) -> dict[str, Any]:
    """Gives what a file that carries a face says of it, in thousandths of its em.

    Returns:
        "bbox", "ascent", "descent".
    """
    read = _face(face)
    scale, head, line = 1000.0 / read["head"].unitsPerEm, read["head"], read["hhea"]
    box = [round(scale * edge) for edge in (head.xMin, head.yMin, head.xMax, head.yMax)]
    return {"bbox": box, "ascent": round(scale * line.ascent), "descent": round(scale * line.descent)}


def coded_widths() -> list[int]:
    """Gives the widths of the encoding's characters 32 to 255 in the first face, in thousandths of its em."""
    face = _face(0)
    known, lengths, scale = face.getBestCmap(), face["hmtx"].metrics, 1000.0 / face["head"].unitsPerEm
    letters = [bytes([code]).decode(ENCODING, "replace") for code in range(32, 256)]
    return [round(scale * lengths[known.get(ord(letter), ".notdef")][0]) for letter in letters]


@lru_cache(maxsize=1)
def coded_program() -> bytes:
    """Gives the first face as a TrueType file with the characters of the encoding alone, the same bytes each time."""
    return _subset(0, "".join(bytes([code]).decode(ENCODING, "ignore") for code in range(32, 256)), ("name", "post"))[0]


class Carried(NamedTuple):
    """What a file carries of a face: a TrueType file, and of each letter glyph and width in thousandths of the em."""

    program: bytes
    letters: str
    glyphs: list[int]
    widths: list[int]


@lru_cache(maxsize=64)
def carried(face: int, letters: str) -> Carried:
    """Gives what a file carries of a face for letters that the encoding lacks, the same bytes each time."""
    program, read = _subset(face, letters)
    known, lengths, scale = read.getBestCmap(), read["hmtx"].metrics, 1000.0 / read["head"].unitsPerEm
    names = [known[ord(letter)] for letter in letters]
    return Carried(program, letters, [read.getGlyphID(n) for n in names], [round(scale * lengths[n][0]) for n in names])


def _subset(face: int, letters: str, dropped: tuple[str, ...] = ()) -> tuple[bytes, Any]:
    from fontTools.subset import Options, Subsetter
    from fontTools.ttLib import TTFont

    options = Options()
    options.hinting, options.layout_features, options.name_IDs, options.notdef_outline = False, [], [], True
    options.drop_tables += ["GDEF", "GPOS", "GSUB", "kern", "FFTM", *dropped]
    read: Any = TTFont(_file(face), recalcTimestamp=False)
    subset = Subsetter(options)
    subset.populate(text=letters)
    subset.subset(read)
    out = BytesIO()
    read.save(out)
    return out.getvalue(), TTFont(BytesIO(out.getvalue()))


def extra_letters(texts: Iterable[str]) -> dict[int, str]:
    """Gives the letters of texts that the encoding lacks, by the number of their face, in the order of their codes."""
    found: dict[int, set[str]] = {}
    for run in (run for text in texts for run in runs(text) if not run.coded):
        found.setdefault(run.face, set()).update(run.text)
    return {face: "".join(sorted(found[face])) for face in sorted(found)}


def face_rules(texts: Iterable[str]) -> str:
    """Gives the faces of `FAMILIES` for a page, as rules of CSS that hold the letters not every reader's own have."""
    rules = []
    for face, letters in extra_letters(texts).items():
        data = b64encode(carried(face, letters).program).decode()
        of = ", ".join(f"U+{ord(letter):04X}" for letter in letters)
        source = f'font-family: "Lettering{face}"; src: url("data:font/ttf;base64,{data}"); unicode-range: {of}'
        rules.append(f"@font-face {{ {source} }}")
    return " ".join(rules)


def _encodable(letter: str) -> bool:
    try:
        letter.encode(ENCODING)
    except UnicodeEncodeError:
        return False
    return True
