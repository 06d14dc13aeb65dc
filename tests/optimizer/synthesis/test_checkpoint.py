"""Checkpoints and rows that were damaged on the disk: refused in one line, or taken up to the last bit, never half."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from optimizer.commands import cli
from optimizer.synthesis.checkpoint import Checkpoint, CheckpointError, Records
from tests.designs import named

KEY = {"seed": 1}
RECORDS = [{"index": 0, "value": 1.0 / 3.0}, {"index": 1, "value": 1e-300}, {"index": 2, "value": [0.1, None]}]


def written(path: Path) -> list[str]:
    """A file of three records; its lines."""
    store = Records(path, KEY, resume=False)
    for record in RECORDS:
        store.append(record)
    store.close()
    return path.read_text().splitlines()


def taken_up(path: Path) -> list[dict[str, Any]]:
    store = Records(path, KEY, resume=True)
    store.close()
    return store.found


def test_every_cut_and_every_wrong_byte_is_refused_or_leaves_whole_records(tmp_path: Path) -> None:
    path = tmp_path / "c.jsonl"
    lines = written(path)
    whole = path.read_bytes()
    for cut in range(len(whole) + 1):
        path.write_bytes(whole[:cut])
        assert taken_up(path) == RECORDS[: max(0, whole[:cut].count(b"\n") - 1)]
    refused = 0
    for place in range(len(lines[0]) + 1, len(whole) - 1):  # the key's bytes decide whose file it is
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        try:
            found = taken_up(path)
        except CheckpointError:
            refused += 1
            assert path.read_bytes()[place] == whole[place] ^ 1  # left as it is
        else:  # a blank that JSON ignores, or the same number written otherwise
            assert found == RECORDS
    assert refused > 0.9 * (len(whole) - len(lines[0]) - 2)


@pytest.mark.parametrize(
    "line",
    [
        "[" * 100_000, '{"record":' * 100_000, "9" * 5000, "\x00", "null", "[]", '{"record":{}}',
        '{"crc32":0,"record":{"step":"1/ga","result":3}}', '{"crc32":0,"record":NaN}',
        '{"crc32":"\\ud800","record":1}',
    ],
    ids=range(10),
)  # fmt: skip
def test_lines_that_nobody_wrote_are_refused_in_one_line(
    line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "c.jsonl"
    first = written(path)[0]
    for text, number in ((f"{line}\n", 1), (f"{first}\n{line}\n", 2)):
        path.write_text(text)
        for kind in (Records, Checkpoint):
            with pytest.raises(CheckpointError, match=rf"^c\.jsonl: .* damaged in line {number};"):
                kind(path, KEY, resume=True)
            assert path.read_text() == text
    task = Path(__file__).parents[2] / "references" / "joystick.toml"
    (tmp_path / "b.json.checkpoint.jsonl").write_text(f"{line}\n")
    (tmp_path / "dashboard-joystick-front.checkpoint.jsonl").write_text(f"{line}\n")
    for words in (["synthesize", task, "--out", tmp_path / "b.json"], ["front", task, "--out", tmp_path]):
        assert cli.main([*map(str, words), "--resume"]) == 2
        err = capsys.readouterr().err
        assert "damaged in line 1" in err
        assert err.count("\n") == 1


def test_opening_changes_nothing_and_a_torn_line_is_cut_away_by_the_next(tmp_path: Path) -> None:
    path = tmp_path / "c.jsonl"
    written(path)
    torn = path.read_bytes()[:-5]
    path.write_bytes(torn)
    store = Records(path, KEY, resume=True)
    assert path.read_bytes() == torn
    store.append({"index": 9})
    store.close()
    assert taken_up(path) == [*RECORDS[:2], {"index": 9}]
    assert all(json.loads(line) for line in path.read_text().splitlines())


@pytest.mark.parametrize(
    "record",
    [
        [], 3, {}, {"step": "a"}, {"step": "a", "of": "b"}, {"step": "a", "result": 3}, {"index": 3},
    ],
    ids=named,
)  # fmt: skip
def test_a_whole_record_of_another_shape_is_refused(record: Any, tmp_path: Path) -> None:
    path = tmp_path / "c.jsonl"
    store = Records(path, KEY, resume=False)
    store.append(record)
    store.close()
    whole = path.read_bytes()
    with pytest.raises(CheckpointError, match=r"^c\.jsonl: .* damaged in line 2"):
        Checkpoint(path, KEY, resume=True)
    assert path.read_bytes() == whole
    Checkpoint(path, KEY, resume=False).close()  # its lock was given back


def test_a_kill_while_a_resumed_run_opens_its_checkpoint_loses_nothing(tmp_path: Path) -> None:
    """SIGKILL at each call that opens, locks, lists or renames a file: what was kept is there afterwards."""
    path = tmp_path / "c.jsonl"
    code = (
        "import os, signal, sys\nfrom pathlib import Path\nfrom optimizer.synthesis.checkpoint import Records\n"
        "path, whole = Path(sys.argv[1]), Path(sys.argv[1]).read_bytes()\n"
        "def run(left):\n"
        "    def watch(event, arguments):\n        nonlocal left\n"
        "        if event in ('open', 'os.rename', 'os.truncate', 'os.remove', 'fcntl.flock', 'os.listdir'):\n"
        "            left -= 1\n            left or os.kill(os.getpid(), signal.SIGKILL)\n"
        "    sys.addaudithook(watch)\n    Records(path, {'seed': 1}, True).append({'index': 7})\n    os._exit(0)\n"
        "for at in range(1, 30):\n    path.write_bytes(whole)\n    child = os.fork() or run(at)\n"
        "    signalled = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])\n"
        "    found = Records(path, {'seed': 1}, True)\n    found.close()\n"
        "    print(signalled, len(found.found), found.found[-1]['index'], len(os.listdir(path.parent)))\n"
        "    if not signalled:\n        break"
    )
    written(path)
    run = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True)
    *killed, ended = [tuple(map(int, line.split())) for line in run.stdout.splitlines()]
    assert len(killed) > 3
    assert all(code == -signal.SIGKILL and (count, last) in ((3, 2), (4, 7)) for code, count, last, _ in killed)
    assert ended == (0, 4, 7, 1)  # and nothing is left beside it
