"""JSON of somebody else: what is refused, at whatever depth, and that no more is read than the bound."""

from __future__ import annotations

import json
import os
import tomllib
from pathlib import Path
from threading import Thread

import pytest

from delta_cad.common import reading
from delta_cad.common.reading import (
    DEEPEST,
    MOST_KEYS,
    MOST_VALUES,
    ReadError,
    parse_json,
    parse_toml,
    read_bounded,
    read_json,
)
from tests.designs import named


def test_plain_data_is_read_as_the_standard_reader_reads_it(tmp_path: Path) -> None:
    data = {"a": [1, -2.5e-3, "ü\U0001f600", None, True], "b": {"a": {}}, "c": 2**70, "\\ud800": "\\"}
    (tmp_path / "f.json").write_text(json.dumps(data))
    assert read_json(tmp_path / "f.json") == data
    (tmp_path / "f.json").write_text(json.dumps(data, ensure_ascii=False), encoding="utf-8")
    assert read_json(tmp_path / "f.json") == data
    deep = b"[" * DEEPEST + b"]" * DEEPEST
    assert parse_json(deep, "f") == json.loads(deep)
    assert parse_json(b"3", "f") == 3
    assert parse_json(b"\xef\xbb\xbf3", "f") == 3  # as some editors begin a file


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b'{"a": 1, "a": 1}', "a = 1: is given more than once"),
        (b'[{"b": [{"a": 1, "x": 2, "x\\u001b": 3, "x\\u001b": 4}]}]', r"x\\x1b = 4: is given more than once"),
        (b'{"a": NaN}', "NaN is no number"),
        (b"[-Infinity]", "-Infinity is no number"),
        (b"[1e999]", "1e999 is larger than any double"),
        (b"[" + b"9" * 5000 + b"]", "is not JSON we can read"),
        (b'{"a": {"b": [1, ' + b"9" * 400 + b"]}}", r"a.b\[1\] = 9+\.\.\.: is larger than any double"),
        (b"[-1" + b"0" * 309 + b"]", r"\[0\] = -10+\.\.\.: is larger than any double"),
        (b"{", "is not JSON: .* at line 1 column 2"),
        (b"", "is not JSON: "),
        (b"\xff{}", "is not UTF-8 text: .* at byte 0"),
        (b'["\\ud800"]', "half a surrogate pair"),
        (b'{"\\uDFFF": 1}', "half a surrogate pair"),
        (b"[" * (DEEPEST + 1) + b"]" * (DEEPEST + 1), "is nested deeper"),
        (b'{"a":' * 200_000 + b"1" + b"}" * 200_000, "is nested deeper"),
    ],
)
def test_what_is_no_json_of_own_is_refused(content: bytes, words: str) -> None:
    with pytest.raises(ReadError, match=words) as caught:
        parse_json(content, "f.json")
    text = str(caught.value)
    assert text.startswith("f.json: ")
    assert text.isprintable()


def test_no_object_has_more_keys_than_anybody_looks_at() -> None:
    """What reads them gathers a fault for each: megabytes of unknown keys took minutes and gigabytes to refuse."""
    most = {f"k{i}": i for i in range(MOST_KEYS)}
    assert parse_json(json.dumps([most]).encode(), "f") == [most]
    with pytest.raises(ReadError, match=r"f: is not JSON we can read: an object has 10001 keys; .* at most 10000"):
        parse_json(json.dumps([most | {"k": 0}]).encode(), "f")


def test_a_file_of_millions_of_values_is_refused_before_it_is_taken_apart() -> None:
    """31 million empty lists are read for half a minute, and take gigabytes."""
    assert len(parse_json(b"[" + b"1," * (MOST_VALUES - 1) + b"1]", "f")) == MOST_VALUES
    for piece in (b"1,", b"[],", b'{"a":1},'):
        with pytest.raises(ReadError, match=r"f: has more than 2000000 values; it must have at most that"):
            parse_json(b"[" + piece * MOST_VALUES + b"0]", "f")


def test_no_more_is_read_than_the_bound(tmp_path: Path) -> None:
    file = tmp_path / "f.json"
    file.write_bytes(b"[1]" + b" " * 97)
    assert read_json(file, most_bytes=100) == [1]
    with pytest.raises(ReadError, match=r"f\.json: is larger than 9\.9e-05 MB"):
        read_json(file, most_bytes=99)
    with pytest.raises(ReadError, match=r"is larger than 0\.001 MB"):
        read_bounded(Path("/dev/zero"), most_bytes=1000)
    with pytest.raises(ReadError, match=r"none\.json: cannot be read: No such file"):
        read_json(tmp_path / "none.json")
    with pytest.raises(ReadError, match="cannot be read: Is a directory"):
        read_json(tmp_path)
    with pytest.raises(ReadError, match="cannot be read: embedded null byte"):
        read_json(Path("a\0b"))


def test_a_pipe_that_nobody_writes_into_is_refused_and_holds_nobody_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reading, "NOBODY_S", 0.0)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ReadError, match="pipe: is a pipe that nobody writes into; must be"):
        read_bounded(tmp_path / "pipe")


def test_a_pipe_is_read_to_the_end_that_who_writes_gives_it(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    content = bytes(range(256)) * 1000  # more than a pipe holds

    def write() -> None:
        with open(tmp_path / "pipe", "wb", buffering=0) as pipe:  # waits for who reads
            for start in range(0, len(content), 1000):
                pipe.write(content[start : start + 1000])

    Thread(target=write, daemon=True).start()
    assert read_bounded(tmp_path / "pipe") == content


def test_an_anonymous_pipe_is_read_whoever_ended_first() -> None:
    """As `/dev/stdin`, and the shell's `<(command)`."""
    for content in (b"", b"{}"):
        own, theirs = os.pipe()
        os.write(theirs, content)
        os.close(theirs)
        assert read_bounded(Path(f"/dev/fd/{own}")) == content
        os.close(own)


def test_toml_is_read_as_the_standard_reader_reads_it() -> None:
    text = "a.'b c'.\"d\" = [1.5, {x = 'one. two. three'}]\n" + f"{'k.' * (DEEPEST - 1)}k = 1 # {'1.' * 100}\n"
    assert parse_toml(text.encode(), "f") == tomllib.loads(text)
    assert parse_toml(text.encode("utf-8-sig"), "f") == tomllib.loads(text)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"a = ", "is not TOML we can read"),
        (b"a = 1\na = 2", "is not TOML we can read"),
        (b"a = '\xff'", "is not UTF-8 text: .* at byte 5"),
        (b"a = " + b"9" * 5000, "is not TOML we can read"),
        (b"a = " + b"[" * 100_000, "is nested deeper than 32"),
        (b"a = " + b"{b = " * 800 + b"1" + b"}" * 800, "is nested deeper than 32"),
        (b"a = " + b"[" * 40 + b"]" * 40, "is nested deeper than 32"),
        (b"[" + b"a." * 800 + b"a]", "is nested deeper than 32"),
        (b"'" + b"a'.'" * 40 + b"' = 1", "is nested deeper than 32"),
        (b"a." * 400_000 + b"a = 1", "is nested deeper than 32"),  # the standard reader takes hours
        (b"a . " * 200_000 + b"a = 1", "is nested deeper than 32"),
        (b"a" * 999_000 + b"=", "is not TOML we can read"),
        (b'"' * 999_000, "is not TOML we can read"),
    ],
    ids=named,
)
def test_what_is_no_toml_of_own_is_refused(content: bytes, words: str) -> None:
    with pytest.raises(ReadError, match=words) as caught:
        parse_toml(content, "f.toml")
    text = str(caught.value)
    assert text.startswith("f.toml: ")
    assert text.isprintable()
    assert len(text) < 300
