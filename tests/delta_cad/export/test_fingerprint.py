"""The content fingerprint: blind to numbering, order, counters and header; sharp for content."""

from __future__ import annotations

import random
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.export.fingerprint import FingerprintError, canonical
from delta_cad.export.step import write_assembly_step
from tests.committed import ROOT
from tests.delta_cad.export.machine import make_assembly, make_parts, translation

PROGRAM = """
import sys
from pathlib import Path
from delta_cad.export.fingerprint import canonical
from delta_cad.export.step import write_assembly_step
from tests.committed import ROOT
from tests.delta_cad.export.machine import make_assembly
for _ in range(int(sys.argv[2])):
    write_assembly_step(make_assembly(), Path(sys.argv[1]))
print(canonical(Path(sys.argv[1]).read_bytes())[1])
"""


def content_fingerprint(data: bytes) -> str:
    return canonical(data)[1]


def step_text(*entities: str) -> bytes:
    body = "\n".join(f"{entity};" for entity in entities)
    return f"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n{body}\nENDSEC;\nEND-ISO-10303-21;\n".encode()


def shuffled(data: bytes, seed: int) -> bytes:
    """The same content with other numbers and another order."""
    generator = random.Random(seed)
    head, rest = data.decode().split("DATA;\n", 1)
    body, tail = rest.split("ENDSEC;", 1)
    entities = re.findall(r"#\d+ ?= ?(?:'(?:[^']|'')*'|[^;'])*;\n", body)
    numbers = [int(entity[1:].split("=")[0]) for entity in entities]
    fresh = dict(zip(numbers, generator.sample(range(1, 10 * len(numbers)), len(numbers)), strict=True))
    reference = re.compile(r"('(?:[^']|'')*')|#(\d+)")
    renumbered = [reference.sub(lambda m: m[1] or f"#{fresh[int(m[2])]}", entity) for entity in entities]
    generator.shuffle(renumbered)
    return f"{head}DATA;\n{''.join(renumbered)}ENDSEC;{tail}".encode()


@pytest.mark.slow
def test_a_fresh_process_agrees_with_this_one(tmp_path: Path, step_file: Path) -> None:
    """It at its second file: the kernel counts on."""
    command = [sys.executable, "-c", PROGRAM, str(tmp_path / "2"), "2"]
    reported = subprocess.run(
        command, stdout=subprocess.PIPE, text=True, cwd=ROOT, timeout=120, check=True
    ).stdout.strip()
    assert len(reported) == 64
    assert reported == content_fingerprint(step_file.read_bytes())
    entities = {path.read_bytes().partition(b"DATA;")[2] for path in (tmp_path / "2", step_file)}
    assert len(entities) == 1  # byte for byte: only the time stamp in the header was asked to differ


def test_the_canonical_file_says_the_same_whatever_the_numbers_and_the_order(step_file: Path) -> None:
    data = step_file.read_bytes()
    assert canonical(data) == (data, content_fingerprint(data))  # the writer made it so
    for seed in range(2):
        other = shuffled(data, seed)
        assert other != data
        assert canonical(other)[0] == data
    assert content_fingerprint(canonical(shuffled(data, 3))[0]) == content_fingerprint(data)


def test_equal_entities_with_different_users_keep_them() -> None:
    """Two equal points, one under a named vertex, one in a set of two: by content alone they could be exchanged."""
    one = step_text("#1=P(0.)", "#2=P(0.)", "#3=V('a',#1)", "#4=V('b',#2)", "#5=W(#3,#1)", "#6=W(#4,#2)")
    other = step_text("#9=P(0.)", "#2=P(0.)", "#3=V('a',#9)", "#4=V('b',#2)", "#5=W(#3,#2)", "#6=W(#4,#9)")
    renumbered = step_text("#6=P(0.)", "#5=P(0.)", "#4=V('a',#6)", "#3=V('b',#5)", "#2=W(#4,#6)", "#1=W(#3,#5)")
    assert canonical(one)[0] == canonical(renumbered)[0]
    assert canonical(one)[0] != canonical(other)[0]


def test_a_changed_hole_changes_it(tmp_path: Path, step_file: Path) -> None:
    write_assembly_step(make_assembly(make_parts(arm_hole_mm=6.001)), tmp_path / "a.step")
    assert content_fingerprint((tmp_path / "a.step").read_bytes()) != content_fingerprint(step_file.read_bytes())


def test_another_occurrence_name_changes_it(step_file: Path) -> None:
    text = step_file.read_bytes()
    assert text.count(b"'motor_1'") == 1
    assert content_fingerprint(text.replace(b"'motor_1'", b"'motor_9'")) != content_fingerprint(step_file.read_bytes())


def test_a_moved_occurrence_changes_it(machine: Assembly, tmp_path: Path, step_file: Path) -> None:
    moved = replace(machine.occurrences[0], placement=translation(0.0, 0.0, -64.001))
    write_assembly_step(replace(machine, occurrences=(moved, *machine.occurrences[1:])), tmp_path / "a.step")
    assert content_fingerprint((tmp_path / "a.step").read_bytes()) != content_fingerprint(step_file.read_bytes())


@pytest.mark.parametrize("seed", range(3))
def test_numbering_and_order_do_not_matter(step_file: Path, seed: int) -> None:
    data = shuffled(step_file.read_bytes(), seed)
    assert data != step_file.read_bytes()
    assert content_fingerprint(data) == content_fingerprint(step_file.read_bytes())


def test_the_header_does_not_matter(step_file: Path) -> None:
    data = step_file.read_bytes()
    assert b"2000-01-01" in data
    assert content_fingerprint(data.replace(b"2000-01-01", b"1999-12-31")) == content_fingerprint(
        step_file.read_bytes()
    )


def test_text_is_content_even_if_it_looks_like_syntax() -> None:
    one = step_text("#1=A('x; #2 (''y'')',#2)", "#2=B(1.)")
    two = step_text("#1=A('x; #3 (''y'')',#2)", "#2=B(1.)")
    assert content_fingerprint(one) != content_fingerprint(two)
    assert content_fingerprint(one) == content_fingerprint(step_text("#7=B(1.)", "#3=A('x; #2 (''y'')',#7)"))


def test_spaces_comments_and_line_breaks_are_not_content() -> None:
    loose = step_text("#1 = A ( 1. ,\n  #2 )", "/* a ; comment */ #2=B('a  b')")
    assert content_fingerprint(loose) == content_fingerprint(step_text("#1=A(1.,#2)", "#2=B('a  b')"))
    assert content_fingerprint(loose) != content_fingerprint(step_text("#1=A(1.,#2)", "#2=B('a b')"))


def test_order_counts_in_a_list_and_not_in_a_set() -> None:
    leaves = ("#1=P(1.)", "#2=P(2.)")
    assert content_fingerprint(step_text(*leaves, "#3=POLYLINE('',(#1,#2))")) != content_fingerprint(
        step_text(*leaves, "#3=POLYLINE('',(#2,#1))")
    )
    assert content_fingerprint(step_text(*leaves, "#3=CLOSED_SHELL('',(#1,#2))")) == content_fingerprint(
        step_text(*leaves, "#3=CLOSED_SHELL('',(#2,#1))")
    )


def test_how_often_something_stands_there_counts() -> None:
    assert content_fingerprint(step_text("#1=P(1.)")) != content_fingerprint(step_text("#1=P(1.)", "#2=P(1.)"))


def test_cycles_are_distinguished_by_what_hangs_on_them() -> None:
    ring = step_text("#1=A(#2)", "#2=A(#3)", "#3=B(#1,#4)", "#4=P(1.)")
    same = step_text("#9=P(1.)", "#5=B(#7,#9)", "#6=A(#5)", "#7=A(#6)")
    other = step_text("#1=A(#2)", "#2=A(#3)", "#3=B(#1,#4)", "#4=P(2.)")
    longer = step_text("#1=A(#2)", "#2=A(#3)", "#3=A(#5)", "#5=B(#1,#4)", "#4=P(1.)")
    own = step_text("#1=A(#1)", "#2=A(#2)", "#3=B(#3,#4)", "#4=P(1.)")
    prints = [content_fingerprint(data) for data in (ring, same, other, longer, own)]
    assert prints[0] == prints[1]
    assert len(set(prints)) == 4


def test_a_deep_chain_needs_no_recursion() -> None:
    count = 20_000
    chain = step_text(*(f"#{k}=A(#{k + 1})" for k in range(1, count)), f"#{count}=P()")
    assert len(content_fingerprint(chain)) == 64


def test_what_is_no_step_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.step").write_text("solid cube\nendsolid\n")
    with pytest.raises(FingerprintError, match="DATA"):
        content_fingerprint((tmp_path / "a.step").read_bytes())


def test_a_missing_entity_is_refused() -> None:
    with pytest.raises(FingerprintError, match=r"#1 .*#2"):
        content_fingerprint(step_text("#1=A(#2)"))
