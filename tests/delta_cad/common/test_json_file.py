"""JSON of somebody else: what is refused, at whatever depth, and that no more is read than the bound."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from delta_cad.common.json_file import DEEPEST, JsonError, parse_json, read_bounded, read_json


def test_plain_data_is_read_as_the_standard_reader_reads_it(tmp_path: Path) -> None:
    data = {"a": [1, -2.5e-3, "ü\U0001f600", None, True], "b": {"a": {}}, "c": 2**70, "\\ud800": "\\"}
    (tmp_path / "f.json").write_text(json.dumps(data))
    assert read_json(tmp_path / "f.json") == data
    (tmp_path / "f.json").write_text(json.dumps(data, ensure_ascii=False), encoding="utf-8")
    assert read_json(tmp_path / "f.json") == data
    deep = b"[" * DEEPEST + b"]" * DEEPEST
    assert parse_json(deep, "f") == json.loads(deep)
    assert parse_json(b"3", "f") == 3


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b'{"a": 1, "a": 1}', "the key 'a' stands twice"),
        (b'[{"b": [{"a": 1, "x": 2, "x\\u001b": 3, "x\\u001b": 4}]}]', r"the key 'x\\x1b' stands twice"),
        (b'{"a": NaN}', "NaN is no number"),
        (b"[-Infinity]", "-Infinity is no number"),
        (b"[1e999]", "1e999 is larger than any double"),
        (b"[" + b"9" * 5000 + b"]", "is not JSON we can read"),
        (b"{", "is not JSON we can read"),
        (b"", "is not JSON we can read"),
        (b"\xff{}", "is not JSON we can read"),
        (b'["\\ud800"]', "half a surrogate pair"),
        (b'{"\\uDFFF": 1}', "half a surrogate pair"),
        (b"[" * (DEEPEST + 1) + b"]" * (DEEPEST + 1), "is nested deeper"),
        (b'{"a":' * 200_000 + b"1" + b"}" * 200_000, "is nested deeper"),
    ],
)
def test_what_is_no_json_of_ours_is_refused(content: bytes, words: str) -> None:
    with pytest.raises(JsonError, match=words) as caught:
        parse_json(content, "f.json")
    text = str(caught.value)
    assert text.startswith("f.json: ")
    assert text.isprintable()


def test_no_more_is_read_than_the_bound(tmp_path: Path) -> None:
    file = tmp_path / "f.json"
    file.write_bytes(b"[1]" + b" " * 97)
    assert read_json(file, most_bytes=100) == [1]
    with pytest.raises(JsonError, match=r"f\.json: is larger than 9\.9e-05 MB"):
        read_json(file, most_bytes=99)
    with pytest.raises(JsonError, match=r"is larger than 0\.001 MB"):
        read_bounded(Path("/dev/zero"), most_bytes=1000)
    with pytest.raises(JsonError, match=r"none\.json: cannot be read: No such file"):
        read_json(tmp_path / "none.json")
    with pytest.raises(JsonError, match="cannot be read: Is a directory"):
        read_json(tmp_path)
    with pytest.raises(JsonError, match="cannot be read: embedded null byte"):
        read_json(Path("a\0b"))
