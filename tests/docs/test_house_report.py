"""The report on the size of the house: what it counts, on a small house."""

from __future__ import annotations

from pathlib import Path

from scripts.house import report


def test_lines_names_and_modules_with_one_importer_are_counted(tmp_path: Path) -> None:
    files = {
        "delta_cad/a.py": "X = 1\nY, _Z = 2, 3\n\ndef f():\n    from delta_cad import c\n\nclass _C: ...\n",
        "delta_cad/b.py": "from delta_cad.a import X\nimport json\n",
        "delta_cad/c.py": "",
        "optimizer/__init__.py": "from delta_cad import a, c\n",
        "haptics/d.c": "int x;\n",
        "tests/test_a.py": "from delta_cad import b\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    assert report(tmp_path) == {
        "lines of delta_cad": 9,
        "lines of optimizer": 1,
        "lines of haptics": 1,
        "lines of tests": 1,
        "public names": 2,  # X and f
        "public names that share a statement": 1,  # Y
        "modules": 3,
        "modules that one module imports": 0,  # a and c have two, b is imported by a test alone
    }
    (tmp_path / "optimizer" / "__init__.py").write_text("from delta_cad.a import X\n")
    assert report(tmp_path)["modules that one module imports"] == 1  # c
