"""A drawing as PDF 1.4: a page a sheet in its true size, text as text with its faces, the same bytes each time."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from math import cos, radians, sin, tan

from delta_cad.common.refusal import printable
from delta_cad.export.drawings.sheet_io.lettering import (
    ENCODING,
    FACES,
    NARROW,
    Carried,
    carried,
    coded_program,
    coded_widths,
    em_mm,
    extra_letters,
    metrics,
    runs,
)
from delta_cad.export.drawings.sheet_io.sheet import LAYERS, Arc, Area, Drawing, Sheet, Stroke, Text, primitives

_POINTS = 72.0 / 25.4  # in a millimetre
_FIRST, _LAST = 32, 255
_CAPITALS = 729  # height, in thousandths of the em


def pdf_bytes(drawing: Drawing) -> bytes:
    """Gives the file's bytes."""
    count = len(drawing.sheets)
    pages = [5 + 2 * k for k in range(count)]
    font = 5 + 2 * count
    objects: dict[int, bytes] = {
        1: b"<< /Type /Catalog /Pages 2 0 R >>",
        2: f"<< /Type /Pages /Kids [{' '.join(f'{k} 0 R' for k in pages)}] /Count {count} >>".encode(),
        3: b"<< /Title " + _title(printable(drawing.title)) + b" /Producer (delta_cad) >>",
        4: (
            f"<< /Type /Font /Subtype /TrueType /BaseFont /{_name(0)} /FirstChar {_FIRST} /LastChar {_LAST} "
            f"/Widths [{' '.join(map(str, coded_widths()))}] /FontDescriptor {font} 0 R /Encoding /WinAnsiEncoding >>"
        ).encode(),
        font: _descriptor(0, font + 1, 32),
        font + 1: _program(coded_program()),
    }
    extra = {
        face: carried(face, letters)
        for face, letters in extra_letters(text.text for sheet in drawing.sheets for text in sheet.texts).items()
    }
    fonts = "/F 4 0 R"
    for face, one in extra.items():
        start = max(objects) + 1
        objects |= _composite(face, one, start)
        fonts += f" /G{face} {start} 0 R"
    for number, sheet in zip(pages, drawing.sheets, strict=True):
        size = f"0 0 {sheet.width * _POINTS:.3f} {sheet.height * _POINTS:.3f}"
        objects[number] = (
            f"<< /Type /Page /Parent 2 0 R /MediaBox [{size}] /Contents {number + 1} 0 R "
            f"/Resources << /Font << {fonts} >> >> >>"
        ).encode()
        objects[number + 1] = _stream(_content(sheet, {face: one.letters for face, one in extra.items()}))
    return _file(objects)


def _name(face: int) -> str:
    return FACES[face].replace(" ", "")


def _descriptor(face: int, program: int, flags: int) -> bytes:
    shape = metrics(face)
    return (
        f"<< /Type /FontDescriptor /FontName /{_name(face)} /Flags {flags} "
        f"/FontBBox {str(shape['bbox']).replace(',', '')} "
        f"/ItalicAngle 0 /Ascent {shape['ascent']} /Descent {shape['descent']} /CapHeight {_CAPITALS} "
        f"/StemV 80 /FontFile2 {program} 0 R >>"
    ).encode()


def _program(face: bytes) -> bytes:
    return _stream(face, f"/Length1 {len(face)} ")


def _composite(face: int, one: Carried, start: int) -> dict[int, bytes]:
    """Objects of a font whose codes, of two bytes, are the places of its letters from 1 on, with what they read as."""
    below, descriptor, program, glyphs, reads = range(start + 1, start + 6)
    places = b"\0\0" + b"".join(glyph.to_bytes(2, "big") for glyph in one.glyphs)
    lines = [f"<{k:04X}> <{letter.encode('utf-16-be').hex().upper()}>" for k, letter in enumerate(one.letters, 1)]
    blocks = [lines[k : k + 100] for k in range(0, len(lines), 100)]
    table = "\n".join(f"{len(block)} beginbfchar\n" + "\n".join(block) + "\nendbfchar" for block in blocks)
    return {
        start: (
            f"<< /Type /Font /Subtype /Type0 /BaseFont /{_name(face)} /Encoding /Identity-H "
            f"/DescendantFonts [{below} 0 R] /ToUnicode {reads} 0 R >>"
        ).encode(),
        below: (
            f"<< /Type /Font /Subtype /CIDFontType2 /BaseFont /{_name(face)} /CIDToGIDMap {glyphs} 0 R "
            "/CIDSystemInfo << /Registry (Adobe) /Ordering (Identity) /Supplement 0 >> "
            f"/FontDescriptor {descriptor} 0 R /W [1 [{' '.join(map(str, one.widths))}]] >>"
        ).encode(),
        descriptor: _descriptor(face, program, 4),
        program: _program(one.program),
        glyphs: _stream(places),
        reads: _stream(
            (
                "/CIDInit /ProcSet findresource begin 12 dict begin begincmap /CMapName /Letters def /CMapType 2 def\n"
                f"1 begincodespacerange <0000> <FFFF> endcodespacerange\n{table}\n"
                "endcmap CMapName currentdict /CMap defineresource pop end end"
            ).encode()
        ),
    }


def _file(objects: dict[int, bytes]) -> bytes:
    out = bytearray(b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n")
    places = []
    for number in sorted(objects):
        places.append(len(out))
        out += f"{number} 0 obj\n".encode() + objects[number] + b"\nendobj\n"
    start = len(out)
    out += f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n".encode()
    out += b"".join(f"{place:010d} 00000 n \n".encode() for place in places)
    out += f"trailer\n<< /Size {len(objects) + 1} /Root 1 0 R /Info 3 0 R >>\nstartxref\n{start}\n%%EOF\n".encode()
    return bytes(out)


def _stream(data: bytes, more: str = "") -> bytes:
    packed = zlib.compress(data, 9)
    return f"<< {more}/Length {len(packed)} /Filter /FlateDecode >>\nstream\n".encode() + packed + b"\nendstream"


def _string(coded: bytes) -> bytes:
    for letter in (b"\\", b"(", b")"):
        coded = coded.replace(letter, b"\\" + letter)
    return b"(" + coded + b")"


def _title(text: str) -> bytes:
    """A text of the file's properties: in their own code, of which ISO 8859-1 is a part, or in UTF-16."""
    try:
        return _string(text.encode("iso8859_1"))
    except UnicodeEncodeError:
        return b"<FEFF" + text.encode("utf-16-be").hex().upper().encode() + b">"


def _set(text: Text, extra: Mapping[int, str]) -> bytes:
    """Operators that show a text where the line was put."""
    size, out = em_mm(text.height), []
    for run in runs(text.text):
        if run.coded:
            out.append(f"/F {size:.4f} Tf ".encode() + _string(run.text.encode(ENCODING)) + b" Tj")
        else:
            codes = "".join(f"{extra[run.face].index(letter) + 1:04X}" for letter in run.text)
            out.append(f"/G{run.face} {size:.4f} Tf <{codes}> Tj".encode())
    return b" ".join(out)


def _content(sheet: Sheet, extra: Mapping[int, str]) -> bytes:
    """Operators of a page, in millimetres by the first of them; layer by layer."""
    out = [f"{_POINTS:.6f} 0 0 {_POINTS:.6f} 0 0 cm 1 J 1 j".encode()]
    for layer, pen in LAYERS.items():
        dashes = " ".join(f"{dash:g}" for dash in pen.dashes)
        out.append(f"{pen.width_mm:g} w [{dashes}] 0 d".encode())
        for item in primitives(sheet.items):
            if isinstance(item, Text):
                continue
            if item.layer == layer:
                out.append(_drawn(item).encode())
    out.append(b"BT")
    for text in sheet.texts:
        x, y = text.at
        turn = "0 1 -1 0" if text.upright else "1 0 0 1"
        out.append(f"{100 * NARROW:g} Tz {turn} {x:.3f} {y:.3f} Tm ".encode() + _set(text, extra))
    out.append(b"ET")
    return b"\n".join(out)


def _drawn(item: Stroke | Arc | Area) -> str:
    if isinstance(item, Arc):
        return _arc(item)
    path = " ".join(f"{x:.3f} {y:.3f} {'l' if k else 'm'}" for k, (x, y) in enumerate(item.points))
    if isinstance(item, Area):
        return f"{path} f"
    return f"{path} {'s' if item.closed else 'S'}"


def _arc(arc: Arc) -> str:
    """Cubic curves of at most a quarter of a turn each, true to 3e-4 of the radius."""
    pieces = max(1, -(-int(arc.end - arc.start) // 90))
    step = radians((arc.end - arc.start) / pieces)
    pull = 4.0 / 3.0 * tan(step / 4.0) * arc.radius
    (cx, cy), r = arc.centre, arc.radius

    def at(angle: float, along: float = 0.0) -> str:
        return f"{cx + r * cos(angle) - along * sin(angle):.3f} {cy + r * sin(angle) + along * cos(angle):.3f}"

    angle = radians(arc.start)
    out = [f"{at(angle)} m"]
    for _ in range(pieces):
        out.append(f"{at(angle, pull)} {at(angle + step, -pull)} {at(angle + step)} c")
        angle += step
    return " ".join(out) + (" s" if arc.whole else " S")
