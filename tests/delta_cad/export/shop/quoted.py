"""An archive for a quotation read back, against the folder that it was made of."""

from __future__ import annotations

import csv
import zipfile
from io import StringIO
from pathlib import Path


def check_quotation(folder: Path) -> list[dict[str, str]]:
    """Checks that the archive holds the folder's own files, each listed, one body a STEP file; gives the table."""
    with zipfile.ZipFile(folder / "quotation.zip") as archive:
        assert archive.testzip() is None
        content = {info.filename: archive.read(info) for info in archive.infolist()}
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    rows = list(csv.DictReader(StringIO(content["quotation.csv"].decode())))
    assert rows
    assert set(content) == {"quotation.csv"} | {name for row in rows for name in row["files"].split()}
    for row in rows:
        number = row["part_number"]
        names = row["files"].split()
        assert all(name.startswith(f"{number}/{number}.") for name in names)
        assert row["material"]
        assert row["finish"]
        assert (f"{number}/{number}.3mf" in names) == (row["process"] != "cut")
        assert row["process"] == "cut" or not any(name.endswith(".profile.dxf") for name in names)
        assert len([float(size) for size in row["size_mm"].split(" x ")]) == 3
        assert content[f"{number}/{number}.step"].count(b"MANIFOLD_SOLID_BREP") == 1
        for name in names:
            (own,) = (path for path in folder.rglob(name.split("/")[1]))
            assert content[name] == own.read_bytes()
    return rows
