"""A drawing as PDF 1.4: a page a sheet in its true size, text as text with its face, the same bytes each time."""

from __future__ import annotations

import zlib
from math import cos, radians, sin, tan

from delta_cad.export.drawings.paper.lettering import ENCODING, FACE, NARROW, em_mm, metrics, program
from delta_cad.export.drawings.paper.sheet import LAYERS, Arc, Area, Drawing, Sheet, Stroke, Text, leaves

POINTS = 72.0 / 25.4  # in a millimetre
FIRST, LAST = 32, 255
NAME = FACE.replace(" ", "")


def pdf_bytes(drawing: Drawing) -> bytes:
    """Gives the file's bytes."""
    count = len(drawing.sheets)
    pages = [5 + 2 * k for k in range(count)]
    face, shape = program(), metrics()
    widths = " ".join(map(str, shape["widths"]))
    font = 5 + 2 * count
    objects: dict[int, bytes] = {
        1: b"<< /Type /Catalog /Pages 2 0 R >>",
        2: f"<< /Type /Pages /Kids [{' '.join(f'{k} 0 R' for k in pages)}] /Count {count} >>".encode(),
        3: b"<< /Title " + _string(drawing.title) + b" /Producer (delta_cad) >>",
        4: (
            f"<< /Type /Font /Subtype /TrueType /BaseFont /{NAME} /FirstChar {FIRST} /LastChar {LAST} "
            f"/Widths [{widths}] /FontDescriptor {font} 0 R /Encoding /WinAnsiEncoding >>"
        ).encode(),
        font: (
            f"<< /Type /FontDescriptor /FontName /{NAME} /Flags 32 /FontBBox {str(shape['bbox']).replace(',', '')} "
            f"/ItalicAngle 0 /Ascent {shape['ascent']} /Descent {shape['descent']} /CapHeight {shape['capital']} "
            f"/StemV 80 /FontFile2 {font + 1} 0 R >>"
        ).encode(),
        font + 1: _stream(face, f"/Length1 {len(face)} "),
    }
    for number, sheet in zip(pages, drawing.sheets, strict=True):
        size = f"0 0 {sheet.width * POINTS:.3f} {sheet.height * POINTS:.3f}"
        objects[number] = (
            f"<< /Type /Page /Parent 2 0 R /MediaBox [{size}] /Contents {number + 1} 0 R "
            "/Resources << /Font << /F 4 0 R >> >> >>"
        ).encode()
        objects[number + 1] = _stream(_content(sheet))
    return _file(objects)


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


def _string(text: str) -> bytes:
    coded = text.encode(ENCODING)
    for letter in (b"\\", b"(", b")"):
        coded = coded.replace(letter, b"\\" + letter)
    return b"(" + coded + b")"


def _content(sheet: Sheet) -> bytes:
    """Operators of a page, in millimetres by the first of them; layer by layer."""
    out = [f"{POINTS:.6f} 0 0 {POINTS:.6f} 0 0 cm 1 J 1 j".encode()]
    for layer, pen in LAYERS.items():
        dashes = " ".join(f"{dash:g}" for dash in pen.dashes)
        out.append(f"{pen.width_mm:g} w [{dashes}] 0 d".encode())
        for item in leaves(sheet.items):
            if isinstance(item, Text):
                continue
            if item.layer == layer:
                out.append(_drawn(item).encode())
    out.append(b"BT")
    for text in sheet.texts:
        x, y = text.at
        turn = "0 1 -1 0" if text.upright else "1 0 0 1"
        out.append(
            f"/F {em_mm(text.height):.4f} Tf {100 * NARROW:g} Tz {turn} {x:.3f} {y:.3f} Tm ".encode()
            + _string(text.text)
            + b" Tj"
        )
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
