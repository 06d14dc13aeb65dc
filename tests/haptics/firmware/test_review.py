"""The generated C as a reviewer reads it: named state, enums, no library name taken, each equality with its reason."""

from __future__ import annotations

import ctypes
import importlib.util
import math
import re
from pathlib import Path

import pytest
from numba import float64, int64

from delta_cad.common.jit import compiled
from delta_cad.design import Design
from haptics.control.startup import record
from haptics.control.startup.record import Refusal, Step
from haptics.control.supervisor import memory
from haptics.control.supervisor.faults import FaultCode, State
from haptics.firmware.expressions import TranslationError
from haptics.firmware.generate import sources
from haptics.firmware.memories import START, SUPERVISOR, WHOLE, Layout, layout
from haptics.firmware.ports import files_of_ports
from haptics.firmware.precision import DOUBLE, MIXED, Precision
from haptics.firmware.translate import Translation
from haptics.loop.hardware import board_controller
from haptics.loop.start_up import start_up
from haptics.rendering.registry import LAWS
from tests.haptics.scene_machine import scene_machine

LIBRARIES = [ctypes.CDLL(name) for name in ("libm.so.6", "libc.so.6")]


@pytest.fixture(scope="module", params=[DOUBLE, MIXED], ids=["double", "single"])
def files(best: Design, request: pytest.FixtureRequest) -> dict[str, str]:
    machine = scene_machine(best)
    precision: Precision = request.param
    return sources(board_controller(machine, stale=0.1), "x", precision, start_up(machine, 1e-3))


def enumerators(header: str, prefix: str) -> dict[str, int]:
    """Names behind a prefix -> their values."""
    return {name: int(value) for name, value in re.findall(rf"^ *{prefix}(\w+) = (\d+),?$", header, re.MULTILINE)}


def test_faults_states_steps_and_refusals_are_enums(files: dict[str, str]) -> None:
    header = files["delta_controller.h"]
    for kind, prefix in ((FaultCode, "DELTA_FAULT_"), (State, "DELTA_STATE_"), (Refusal, "DELTA_REFUSED_"),
                         (Step, "DELTA_STARTUP_")):  # fmt: skip
        assert enumerators(header, prefix) == {one.name: int(one) for one in kind}
    assert "delta_state_code delta_state(const delta_memory *memory);" in header
    assert "delta_startup_step_code delta_startup_step(const delta_startup_memory *memory);" in header


@pytest.mark.parametrize("laid", [SUPERVISOR, START], ids=["supervisor", "start-up"])
def test_each_place_of_a_memory_is_a_named_member_with_its_comment(files: dict[str, str], laid: Layout) -> None:
    body = re.search(
        rf"typedef struct {{\n((?:(?!typedef).)*?)}} {laid.struct};", files["delta_controller.h"], re.DOTALL
    )
    assert body is not None
    rows = re.findall(r"^    [\w ]+? (\w+?)_?(?:\[(\d+)\])?; /\* (.*) \*/$", body[1], re.MULTILINE)
    found = {name.upper(): (int(width or 1), about) for name, width, about in rows}
    # the constants of the module are the offsets, one after the other
    assert sum(width for width, _ in found.values()) == laid.module.MEMORY
    offset, source = 0, Path(laid.module.__file__ or "").read_text()
    for name, (width, about) in found.items():
        assert getattr(laid.module, name) == offset
        assert re.search(rf"^{name} = {offset}  # {re.escape(about)}$", source, re.MULTILINE)
        offset += width


def test_no_state_is_reached_by_a_number(files: dict[str, str]) -> None:
    code = files["delta_controller.c"]
    assert "mem->theta[i]" in code
    assert not re.search(r"\b(mem|supervisor|start)(\.at)?\[\d", code + files["delta_controller.h"])
    assert {name for name in WHOLE if not hasattr(memory, name) and not hasattr(record, name)} == set()


def test_no_library_name_is_redefined(files: dict[str, str]) -> None:
    everything = {**files, **files_of_ports()}
    defined = {
        name
        for path, text in everything.items()
        if path.endswith((".c", ".h"))
        for name in re.findall(r"^#define (\w+)", text, re.MULTILINE)
    }
    assert len(defined) > 20
    assert hasattr(LIBRARIES[0], "fabs")
    assert not {name for name in defined if any(hasattr(library, name) for library in LIBRARIES)}


def test_each_equality_of_real_numbers_says_why(files: dict[str, str]) -> None:
    """`equal` alone compares so; compilers warn of anything else, and warnings are errors in all tests."""
    lines = files["delta_controller.c"].splitlines()
    calls = [k for k, line in enumerate(lines) if re.search(r"\bequalf?\(", line) and "static inline" not in line]
    assert all(lines[k - 1].strip().startswith("/* exact: ") for k in calls)
    quarters, wall, reference = 3, 1, 1
    assert len(calls) == quarters + len(LAWS) + wall + reference


@compiled
def _reasoned(a, b):
    return 1.0 if a == b else 2.0  # exact: a test


@compiled
def _bare(a, b):
    return 1.0 if a == b else 2.0


def test_an_equality_without_a_reason_has_no_translation() -> None:
    translation = Translation(DOUBLE)
    name, _ = translation.add(_reasoned, (float64, float64))
    assert "/* exact: a test */\n    return ((equal(a, b)) ? 1.0 : 2.0);" in translation.functions[name]
    with pytest.raises(TranslationError, match="need a reason"):
        translation.add(_bare, (float64, float64))
    assert _reasoned(math.nan, math.nan) == 2.0


@compiled
def _beyond(mem, i):
    return mem[memory.TANK + i]


@compiled
def _numbered(mem, i):
    return mem[3] + i


@compiled
def _named(mem, i):
    return mem[memory.ANCHOR + 3 * i + 1] + mem[memory.TANK]


def test_a_place_is_reached_by_its_name_alone() -> None:
    translation = Translation(DOUBLE)
    name, _ = translation.add(_named, (SUPERVISOR, int64))
    assert "return (mem->anchor[((3LL * i) + 1LL)] + mem->tank);" in translation.functions[name]
    with pytest.raises(TranslationError, match="TANK is one number"):
        translation.add(_beyond, (SUPERVISOR, int64))
    with pytest.raises(TranslationError, match="must begin with the name of a place"):
        translation.add(_numbered, (SUPERVISOR, int64))


@pytest.mark.parametrize("lines", ["A = 0\nB = 1  # m\nMEMORY = 2", "A = 1  # m\nB = 1  # m\nMEMORY = 2"])
def test_a_place_without_a_comment_or_room_is_refused(tmp_path: Path, lines: str) -> None:
    (tmp_path / "laid.py").write_text(lines + "\n")
    spec = importlib.util.spec_from_file_location("laid", tmp_path / "laid.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    with pytest.raises(ValueError, match=r"laid\.A: offsets must rise, and each line needs a comment"):
        layout(module, "delta_laid")
