"""The archive for a quotation: what is packed, what is listed, and the same bytes at any time."""

from __future__ import annotations

import time
import zipfile
from pathlib import Path

import pytest

from delta_cad.export.shop.quotation import QuotedPart, write_quotation

PLATE = QuotedPart("plate", 2, "Aluminium", "cut", "as cut, no coating", "80 x 60 x 8", "103")
PLATE_2 = QuotedPart("plate_2", 1, "Brass", "cut", "=1+1", "10 x 10 x 3", "2.5")


def packed(folder: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(folder / "quotation.zip") as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A part's files in the folders of a build, with some that no shop asks for."""
    contents = {
        "parts/plate.step": "solid",
        "parts/plate.stl": "mesh",
        "parts/plate_2.step": "other",
        "drawings/plate.pdf": "drawing",
        "drawings/plate.svg": "picture",
        "profiles/plate.profile.dxf": "profile",
    }
    for name, text in contents.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_each_part_has_its_own_files_and_its_row(folder: Path) -> None:
    write_quotation([PLATE, PLATE_2], folder)
    content = packed(folder)
    assert list(content) == [
        "quotation.csv",
        "plate/plate.pdf",
        "plate/plate.step",
        "plate/plate.profile.dxf",
        "plate_2/plate_2.step",
    ]
    assert content["plate/plate.profile.dxf"] == b"profile"
    assert content["quotation.csv"].decode().splitlines() == [
        "part_number,quantity,material,process,finish,size_mm,mass_g,files",
        'plate,2,Aluminium,cut,"as cut, no coating",80 x 60 x 8,103,'
        "plate/plate.pdf plate/plate.step plate/plate.profile.dxf",
        "plate_2,1,Brass,cut,'=1+1,10 x 10 x 3,2.5,plate_2/plate_2.step",
    ]


def test_a_printed_part_has_its_body_to_print_and_a_cut_one_none(folder: Path) -> None:
    for name in ("plate.3mf", "print.3mf", "print.step", "print.stl"):
        (folder / "parts" / name).write_text(name)
    printed = QuotedPart("print", 1, "PETG", "fdm", "as printed", "80 x 60 x 8", "103")
    write_quotation([PLATE, printed], folder)
    assert {name for name in packed(folder) if name.endswith(("mf", "tl"))} == {"print/print.3mf"}


def test_it_is_the_same_bytes_whenever_it_is_written(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_quotation([PLATE, PLATE_2], folder)
    first = (folder / "quotation.zip").read_bytes()
    later = time.time() + 1e6
    monkeypatch.setattr(time, "time", lambda: later)
    write_quotation([PLATE, PLATE_2], folder)
    assert (folder / "quotation.zip").read_bytes() == first
