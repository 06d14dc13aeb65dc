"""Text of any alphabet, as anybody's catalogue may have it, in PDF, SVG, DXF and STEP: read back by other readers."""

from __future__ import annotations

import csv
import hashlib
import json
import re
import unicodedata
from dataclasses import fields, replace
from functools import lru_cache
from io import StringIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pypdfium2
import pytest
from fontTools.ttLib import TTFont
from hypothesis import example, given, settings
from hypothesis import strategies as st

from delta_cad.common.refusal import FORMULAS, LONGEST, visible
from delta_cad.export.bom import BomRow, write_bom
from delta_cad.export.drawings.checker import sheet_faults
from delta_cad.export.drawings.items import item_lists
from delta_cad.export.drawings.sheet_io import lettering
from delta_cad.export.drawings.sheet_io.dxf import dxf_text
from delta_cad.export.drawings.sheet_io.lettering import SUBSTITUTE, fitted, missing, shown, width_of
from delta_cad.export.drawings.sheet_io.pdf import pdf_bytes
from delta_cad.export.drawings.sheet_io.sheet import Drawing, Sheet, Text
from delta_cad.export.drawings.sheet_io.svg import svg_text
from delta_cad.export.drawings.title import Titles, framed, title_box
from tests.delta_cad.export.drawings.reading import SVG

BYTES = [f"iso8859_{k}" for k in (1, 2, 3, 4, 5, 7, 9, 10, 13, 14, 15, 16)] + ["koi8_u", "cp1251", "cp1258", "ptcp154"]
PAIRS = ["gb2312", "big5", "shift_jis", "euc_jp", "euc_kr"]
ISSUED = [
    "Silnik prądu stałego ≥ 24 V, Ø 30, 5 Ω, μ → ∞",
    "Ocelové lanko, ΣΧΟΙΝΙ, стальной трос",
    "球形ハンドル 25 \U0001f600 \u202e",
    "강철 케이블 (한국)",
    "%%c %%% \\U+00D8 \\P ^J ^ \\X2\\0041\\X0\\ <&>\"' \\",
    "שלום مرحبا नमस्ते",
    "e\u0301 \u2126 \u00a0\u3000x\u200b",
    "=1+1",
    "\ue000",
    "x" * 900,
    "漢" * 900,
]
ANY = st.one_of(st.sampled_from(ISSUED), st.text(max_size=60)).map(visible)
SOME = settings(max_examples=25, deadline=None)


def letters_of(codec: str) -> set[str]:
    """Letters that a code of one byte, or of two, has."""
    found: set[str] = set()
    for first in range(256):
        for raw in (bytes([first]), *(bytes([first, second]) for second in range(256) if codec in PAIRS)):
            try:
                found |= set(raw.decode(codec))
            except UnicodeDecodeError:
                continue
    return {letter for letter in found if unicodedata.category(letter).startswith("L")}


@lru_cache(maxsize=1)
def covered() -> set[str]:
    """Letters that one of the faces has by its own table, and that are written one after the other from the left."""
    codes = {code for face in (0, 1) for code in TTFont(lettering._file(face)).getBestCmap()}
    letters = {chr(code) for code in codes if code < 2**16}
    return {one for one in letters if one.isprintable() and unicodedata.bidirectional(one) not in ("R", "AL", "AN")}


def sheet_of(*texts: str) -> Drawing:
    sheet = Sheet(300.0, 200.0, [Text((10.0, 190.0 - 10.0 * k), 2.5, text) for k, text in enumerate(texts)])
    return Drawing("text", texts[0], (sheet,))


def by_numbers(text: str) -> str:
    """A text of a DXF with its letters that are written by their numbers."""
    return re.sub(r"\\U\+([0-9A-F]{4})", lambda found: chr(int(found[1], 16)), text)


@pytest.mark.parametrize("codec", BYTES + PAIRS)
def test_every_letter_of_a_country_s_code_is_there(codec: str) -> None:
    letters = letters_of(codec)
    assert len(letters) > (2000 if codec in PAIRS else 80)
    assert missing(letters) == []


def test_the_face_is_the_one_that_is_described() -> None:
    face = lettering._file(1)
    assert hashlib.sha256(face.read_bytes()).hexdigest() in (face.parent / "README.md").read_text(encoding="utf-8")


@SOME
@given(ANY)
def test_what_no_face_has_is_shown_by_a_substitute_and_named(text: str) -> None:
    composed = unicodedata.normalize("NFC", text)
    lacking = {letter for letter in composed if letter not in covered()}
    assert shown(text) == "".join(SUBSTITUTE if letter in lacking else letter for letter in composed)
    assert missing([text]) == [f"U+{ord(letter):04X}" for letter in sorted(lacking)]
    assert width_of(text, 2.5) == pytest.approx(sum(width_of(letter, 2.5) for letter in composed))


@SOME
@given(ANY, st.floats(3.0, 60.0), st.integers(1, 5))
def test_a_text_that_is_too_long_for_its_cell_ends_so(text: str, most_mm: float, most: int) -> None:
    lines = fitted(text, 2.0, most_mm, most)
    assert len(lines) <= most
    assert all(width_of(line, 2.0) <= most_mm + 1e-9 or len(line) <= 2 for line in lines)
    words = "".join(text.split())
    if "".join("".join(lines).split()) != words:
        assert words.startswith("".join(lines)[:-1].replace(" ", ""))
        assert lines[-1].endswith("…")
        assert len(lines) == most


@SOME
@example(["2^3", "^I"])
@given(st.lists(ANY.filter(bool), min_size=1, max_size=4))
def test_drawings_read_back_as_they_are_shown(texts: list[str]) -> None:
    from ezdxf.filemanagement import read

    drawing, looks = sheet_of(*texts), [shown(text) for text in texts]
    assert pdf_bytes(drawing) == pdf_bytes(drawing)
    page = pypdfium2.PdfDocument(pdf_bytes(drawing))
    said = "".join(page[0].get_textpage().get_text_range().split())
    assert unicodedata.normalize("NFKC", said) == unicodedata.normalize("NFKC", "".join("".join(looks).split()))
    if len(texts[0]) <= LONGEST:
        assert page.get_metadata_value("Title") == texts[0]
    root = ElementTree.fromstring(svg_text(drawing))
    assert [element.text for element in root.iter(f"{SVG}text")] == looks
    text = dxf_text(drawing)
    assert text.isascii()
    dxf: Any = read(StringIO(text))
    assert dxf.audit().errors == []
    plain = [by_numbers(entity.plain_text()) for entity in dxf.modelspace().query("TEXT")]
    assert [one.replace(" ", "") for one in plain] == [look.replace(" ", "") for look in looks]


def test_a_letter_of_another_alphabet_is_drawn_where_it_is_said() -> None:
    """Each as the reader's picture has it: as wide as told, as black as the same letters by the face itself."""
    from PIL import Image, ImageDraw, ImageFont

    scale, size = 8.0, 5.0
    for text in ("ąčΩЖ", "球形한"):
        drawing = Drawing("t", "t", (Sheet(100.0, 40.0, [Text((10.0, 10.0), size, text)]),))
        picture = pypdfium2.PdfDocument(pdf_bytes(drawing))[0].render(scale=scale).to_pil().convert("L")
        ink = picture.point(lambda value: 255 * (value < 128))
        left, _, right, _ = ink.getbbox() or (0, 0, 0, 0)
        dots = scale * 72.0 / 25.4
        assert right - left == pytest.approx(width_of(text, size) * dots, abs=0.15 * size * dots)
        face = ImageFont.truetype(str(lettering._file(text == "球形한")), round(lettering.em_mm(size) * dots))
        own = Image.new("L", (2000, 400))
        ImageDraw.Draw(own).text((20, 20), text, 255, face)
        black, expected = (sum(one.histogram()[128:]) for one in (ink, own))
        assert black == pytest.approx(lettering.NARROW * expected, rel=0.1)
    assert len(pdf_bytes(sheet_of("球形한"))) - len(pdf_bytes(sheet_of("abc"))) < 10_000  # of a face of 3.4 MB


def row(text: str) -> BomRow:
    free = {one.name: text for one in fields(BomRow) if one.type == "str"}
    return replace(BomRow(1, "a", "b", 1, "buy", "c", 1.0, 1.0, "d", "e", "f"), **free | {"make_or_buy": "buy"})


@SOME
@given(ANY)
def test_every_column_of_the_item_list_and_every_field_of_a_title_block_takes_any_text(text: str) -> None:
    title = Titles(**{one.name: text for one in fields(Titles)})
    sheet = framed("A3", "1:1", "1 / 1", title)
    (left, low, right, high), names = title_box("A3"), missing([text])
    for one in sheet.texts:
        assert left <= one.box[0] <= one.box[2] <= right + 1e-9
        assert low <= one.box[1] <= one.box[3] <= high
    for scale, items, frames in item_lists([row(text)] * 3):
        page = framed("A3", scale, "1 / 1", Titles(*["a"] * 8))
        page.add(items)
        page.frames |= frames
        assert sheet_faults(page) == []
        reported = " ".join(one.text for one in page.texts)
        assert all(name in reported for name in names[:12]) or scale != "-"


@SOME
@given(st.one_of(st.sampled_from(["=1+1", "+cmd|' /C calc'!A0", "-2", "@SUM(A1)", *ISSUED]), ANY))
def test_no_cell_of_the_bill_of_materials_is_a_formula(text: str) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        write_bom([row(text)], Path(folder))
        with (Path(folder) / "bom.csv").open(encoding="utf-8", newline="") as file:
            cells = next(csv.DictReader(file))
        record = json.loads((Path(folder) / "bom.json").read_text(encoding="utf-8"))["items"][0]
    assert record["description"] == text
    assert cells["description"].removeprefix("'") == text.removeprefix("'")
    assert not any(cell.startswith(FORMULAS) for cell in cells.values())
    assert (cells["item"], cells["unit_mass_g"]) == ("1", "1.0")


def test_a_step_file_has_any_text_in_ascii_and_another_reader_reads_it(tmp_path: Path) -> None:
    import cadquery as cq
    from OCP.STEPControl import STEPControl_Reader
    from OCP.StepRepr import StepRepr_DescriptiveRepresentationItem

    from delta_cad.export.step import write_part_step
    from delta_cad.solids.part import Material, Part

    text = visible(" ".join(ISSUED[:7]))
    solid: Any = cq.Workplane().box(10, 10, 10).val()
    write_part_step(Part("p", text, solid, Material(text, 2700.0, (0.5, 0.5, 0.5)), True), tmp_path / "p.step")
    raw = (tmp_path / "p.step").read_bytes()
    assert raw.isascii()
    joined = re.sub(rb"'\s*\n|\n\s*", b"", raw).decode()
    assert "\\X2\\0105\\X0\\" in joined  # of the first word that has one
    reader: Any = STEPControl_Reader()
    reader.ReadFile(str(tmp_path / "p.step"))
    model = reader.StepModel()
    entities = [model.Value(number) for number in range(1, model.NbEntities() + 1)]
    notes = [e for e in entities if isinstance(e, StepRepr_DescriptiveRepresentationItem)]
    read = {e.Name().ToCString(): e.Description().ToCString() for e in notes}
    assert (read["remark"], read["material"]) == (text, text)
