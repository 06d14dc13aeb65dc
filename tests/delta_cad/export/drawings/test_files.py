"""The files of a drawing, read back by readers that are not their writers."""

from __future__ import annotations

from dataclasses import replace
from math import hypot
from pathlib import Path
from xml.etree import ElementTree

import pypdfium2
import pytest

from delta_cad.export.drawings.sheet_io.dxf import dxf_text
from delta_cad.export.drawings.sheet_io.pdf import pdf_bytes
from delta_cad.export.drawings.sheet_io.sheet import Drawing, Text
from delta_cad.export.drawings.sheet_io.svg import svg_text
from tests.delta_cad.export.drawings.reading import SVG, dxf_texts, entities, styles
from tests.delta_cad.export.drawings.sample import drawn, texts


@pytest.fixture(scope="module")
def drawing() -> Drawing:
    return drawn()[0]


def test_the_pdf_has_its_true_size_and_its_texts(drawing: Drawing) -> None:
    for document, count in ((drawing, 1), (Drawing("two", "two", drawing.sheets * 2), 2)):
        data = pdf_bytes(document)
        assert data == pdf_bytes(document)
        read = pypdfium2.PdfDocument(data)
        assert len(read) == count
        for page in read:
            size = [side * 25.4 / 72.0 for side in page.get_size()]
            assert size == pytest.approx([document.sheets[0].width, document.sheets[0].height], abs=0.01)
            words = page.get_textpage().get_text_range()
            for text in ("Ø8 H7 through, shaft", "-8 ±0.02", "Aluminium EN AW-6082 T6", "ISO 2768-mK"):
                assert text in words
    assert read.get_metadata_value("Title") == "two"


def test_the_pdf_shows_what_is_drawn(drawing: Drawing) -> None:
    """Black where a wide line is, white in the middle of nothing."""
    picture = pypdfium2.PdfDocument(pdf_bytes(drawing))[0].render(scale=4.0).to_pil().convert("L")
    dots = 4.0 * 72.0 / 25.4
    height = drawing.sheets[0].height
    assert picture.getpixel((round(20.0 * dots), round((height - 100.0) * dots))) < 80  # the frame's left side
    assert picture.getpixel((round(10.0 * dots), round((height - 100.0) * dots))) == 255


def test_the_svg_has_its_true_size_and_its_texts(drawing: Drawing) -> None:
    text = svg_text(drawing)
    assert text == svg_text(drawing)
    root = ElementTree.fromstring(text)
    sheet = drawing.sheets[0]
    assert (root.get("width"), root.get("height")) == (f"{sheet.width:g}mm", f"{sheet.height:g}mm")
    assert [element.text for element in root.iter(f"{SVG}text")] == texts(drawing)
    layers = {group.get("id") for group in root.iter(f"{SVG}g")}
    assert {"visible", "hidden", "centre", "dimension", "frame"} <= layers


def test_the_dxf_passes_its_audit_and_reads_as_lines_of_text(drawing: Drawing, tmp_path: Path) -> None:
    from ezdxf.filemanagement import readfile

    text = dxf_text(drawing)
    assert text == dxf_text(drawing)
    (tmp_path / "plate.dxf").write_text(text, encoding="utf-8")
    document = readfile(tmp_path / "plate.dxf")
    assert document.audit().errors == []
    assert document.header["$INSUNITS"] == 4  # millimetres
    assert dxf_texts(text) == texts(drawing)
    circles = [dict(entity) for entity in entities(text) if entity[0] == (0, "CIRCLE") and (8, "visible") in entity]
    scale = next(text.text for text in drawing.sheets[0].texts if text.text in ("1:1", "2:1", "5:1"))
    radii = {round(float(circle[40]) / float(scale[0]), 3) for circle in circles}
    assert {4.0, 1.65, 2.75, 5.0} <= radii


def test_sheets_stand_side_by_side_in_files_that_hold_one(drawing: Drawing) -> None:
    two = Drawing("two", "two", drawing.sheets * 2)
    width = drawing.sheets[0].width
    assert ElementTree.fromstring(svg_text(two)).get("width") == f"{2 * width:g}mm"
    first, second = (len(entities(dxf_text(one))) for one in (drawing, two))
    assert second == 2 * first


def test_dimensions_of_the_dxf_measure_what_is_printed(drawing: Drawing) -> None:
    """Each by its own points and its style's scale, as a reader that knows DIMENSION measures it again."""
    text = dxf_text(drawing)
    scales, kinds = styles(text), []
    for entity in entities(text):
        if entity[0][1] != "DIMENSION":
            continue
        own = dict(entity)
        kinds.append(int(own[70]) & 7)
        first, last = {6: (10, 13), 3: (10, 15), 4: (10, 15), 0: (13, 14)}[kinds[-1]]
        dx, dy = (float(own[last + step]) - float(own[first + step]) for step in (0, 10))
        length = abs(dx if int(own[70]) & 64 else dy) if kinds[-1] == 6 else hypot(dx, dy)
        measured = length * scales[own[3]]
        assert measured == pytest.approx(float(own[42]), abs=1e-4)
        if kinds[-1] == 6:
            assert abs(float(own[1].split(" ")[0])) == pytest.approx(measured, abs=6e-4)
    features = drawn()[1]
    assert kinds.count(6) >= len({round(place.value, 3) for place in features.places})
    assert kinds.count(3) == len(features.groups)  # each group of holes by the diameter of one


def test_a_letter_without_a_code_is_written_by_its_number(drawing: Drawing) -> None:
    sheet = replace(drawing.sheets[0], items=[Text((50.0, 50.0), 2.5, "5 µm Ø8 ±1°")])
    text = dxf_text(replace(drawing, sheets=(sheet,)))
    assert "5 \\U+00B5m %%c8 %%p1%%d" in text
