"""The lettering of a drawing: one face, its true widths, and the face itself for the files that carry it.

DejaVu Sans comes with matplotlib; it is set narrower, which ISO 3098 leaves free. A text is refused if it holds what
the files' encoding (Windows 1252) or the face does not.
"""

from __future__ import annotations

from functools import lru_cache
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any

FACE = "DejaVu Sans"
NARROW = 0.85  # of the face's own width
ENCODING = "cp1252"
LINE = 1.6  # from line to line, in heights of the capitals
SURFACE, SURFACE_WIDE = "\ue000", 1.25
"""Stands in a text for the symbol of a surface, which is drawn where the text is set; how wide, in heights."""


class LetteringError(ValueError):
    """A text cannot be lettered: the face or the files' encoding lacks a character."""


@lru_cache(maxsize=1)
def _face() -> Any:
    from fontTools.ttLib import TTFont

    return TTFont(_file())


def _file() -> Path:
    found = find_spec("matplotlib")
    if found is None or not found.submodule_search_locations:
        raise ModuleNotFoundError("No module named 'matplotlib'", name="matplotlib")
    return Path(found.submodule_search_locations[0]) / "mpl-data" / "fonts" / "ttf" / "DejaVuSans.ttf"


@lru_cache(maxsize=1)
def _advances() -> dict[int, float]:
    """Character's code -> how far it goes on, in heights of the capitals, narrowed."""
    face = _face()
    widths, capital = face["hmtx"].metrics, float(face["glyf"]["H"].yMax)
    return {code: NARROW * widths[name][0] / capital for code, name in face.getBestCmap().items()}


@lru_cache(maxsize=4096)
def width_of(text: str, height_mm: float) -> float:
    """Computes how long a text is, mm.

    Args:
        text: One line.
        height_mm: Height of its capitals.

    Raises:
        LetteringError: A character is not in the face or not in the encoding.
    """
    advances = _advances()
    plain = text.replace(SURFACE, "")
    for letter in plain:
        if ord(letter) not in advances or not letter.isprintable() or not _encodable(letter):
            raise LetteringError(f"{letter!r} in {text!r} cannot be lettered: not in {FACE} or not in {ENCODING}")
    wide = SURFACE_WIDE * (len(text) - len(plain))
    return height_mm * (wide + sum(advances[ord(letter)] for letter in plain))


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


def em_mm(height_mm: float) -> float:
    """Gives the size of the face, its em, for a height of its capitals."""
    face = _face()
    return height_mm * face["head"].unitsPerEm / face["glyf"]["H"].yMax


def metrics() -> dict[str, Any]:
    """Gives what a file that carries the face says of it, in thousandths of its em.

    Returns:
        "widths" of the encoding's characters 32 to 255, "bbox", "ascent", "descent", "capital".
    """
    face = _face()
    scale = 1000.0 / face["head"].unitsPerEm
    known, lengths = face.getBestCmap(), face["hmtx"].metrics
    letters = [bytes([code]).decode(ENCODING, "replace") for code in range(32, 256)]
    widths = [round(scale * lengths[known.get(ord(letter), ".notdef")][0]) for letter in letters]
    head, line = face["head"], face["hhea"]
    box = [round(scale * edge) for edge in (head.xMin, head.yMin, head.xMax, head.yMax)]
    ends = round(scale * line.ascent), round(scale * line.descent), round(scale * face["glyf"]["H"].yMax)
    return {"widths": widths, "bbox": box, "ascent": ends[0], "descent": ends[1], "capital": ends[2]}


@lru_cache(maxsize=1)
def program() -> bytes:
    """Gives the face as a TrueType file with the characters of the encoding alone, the same bytes each time."""
    from fontTools.subset import Options, Subsetter
    from fontTools.ttLib import TTFont

    options = Options()
    options.hinting, options.layout_features, options.name_IDs, options.notdef_outline = False, [], [], True
    options.drop_tables += ["GDEF", "GPOS", "GSUB", "kern", "FFTM", "name", "post"]
    letters = "".join(bytes([code]).decode(ENCODING, "ignore") for code in range(32, 256))
    face: Any = TTFont(_file(), recalcTimestamp=False)
    subset = Subsetter(options)
    subset.populate(text=letters)
    subset.subset(face)
    out = BytesIO()
    face.save(out)
    return out.getvalue()


def _encodable(letter: str) -> bool:
    try:
        letter.encode(ENCODING)
    except UnicodeEncodeError:
        return False
    return True
