"""Compiled code is found again while its sources stand, never after they changed, and no disk stops a run."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest

from delta_cad.common import numba_code
from delta_cad.common.jit import compiled
from delta_cad.common.numba_code.kept import PACKAGES, ROOT, UNUSED_MAX_S
from tests.delta_cad.common.forked import Forked

CALLER = """
from delta_cad.mechanism.enclosure.pose import scalar, table
pose = table()
pose[:, 0], pose[:, 1:] = 1.0, 0.0
print(scalar(pose, 0, 1)[0], sum(scalar.stats.cache_hits.values()))
"""
"""`scalar` stands in another file than the sum of forms that it calls."""
TRIAL = """
from {room} import compiled
from optimizer.constant_of_trial import FACTOR
@compiled
def product(x):
    return FACTOR * x
"""
TURN = """
from delta_cad.common.jit import compiled, unrolled_dispatch
@compiled
def one(a, k, out):
    out[k] += a
@compiled
def other(a, k, out):
    out[k] *= a
first = unrolled_dispatch("a, out", [(one, 0), (other, 1), (one, 1)], "{0}(a, {1}, out)")
second = unrolled_dispatch("a, out", [(other, 0), (one, 1)], "{0}(a, {1}, out)", last="return out[0] - out[1]")
"""


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """The three packages, to be changed."""
    for name in PACKAGES:
        shutil.copytree(ROOT / name, tmp_path / "copy" / name, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path / "copy"


_FORKED: list[Forked] = []


@pytest.fixture(scope="module", autouse=True)
def _forked() -> Iterator[None]:
    """The process that `run` forks from: it has numba and nothing of ours; a file edited twice leaves no bytecode."""
    with Forked("import sys, numba; sys.dont_write_bytecode = True; numba.njit(lambda x: x)(1.0)") as forked:
        _FORKED.append(forked)
        yield
        _FORKED.clear()


def surroundings(**places: Path) -> dict[str, str]:
    """No other place for what is compiled than the given."""
    kept = {key: value for key, value in os.environ.items() if key not in ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR")}
    unkept = {"PYTHONDONTWRITEBYTECODE": "1"}  # Python takes two edits of one second and one length for the same file
    return kept | unkept | {key: str(value) for key, value in places.items()}


def run(copy: Path, code: str = CALLER, **places: Path) -> subprocess.CompletedProcess[str]:
    """A process that sees the copy, and no other place for what is compiled than the given; numba is loaded already."""
    return _FORKED[0].run(code, copy, surroundings(**places))


def fresh(copy: Path, code: str = CALLER, **places: Path) -> subprocess.CompletedProcess[str]:
    """As `run`, from nothing, as a user has it."""
    command, environment = [sys.executable, "-c", code], surroundings(**places)
    # `make coverage` has every process write what it ran: none of a copy, and on a full disk there is no room for it
    environment = {name: value for name, value in environment.items() if not name.startswith("COVERAGE")}
    return subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True)


def wording(process: subprocess.CompletedProcess[str]) -> list[float]:
    """The numbers that a process printed, which had nothing else to say."""
    assert process.stderr == ""
    return [float(word) for word in process.stdout.split()]


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


def times(folder: Path) -> dict[Path, int]:
    return {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}


def test_a_changed_callee_is_seen_through_a_caller_that_did_not_change(copy: Path, tmp_path: Path) -> None:
    assert wording(fresh(copy, HOME=tmp_path)) == [3.0, 0.0]
    before = times(tmp_path / ".cache")
    assert wording(fresh(copy, HOME=tmp_path)) == [3.0, 1.0]
    assert times(tmp_path / ".cache") == before
    edit(copy / "delta_cad/mechanism/enclosure/affine_form.py", "s4 = a[0] + b[0],", "s4 = a[0] - b[0],")
    assert wording(fresh(copy, HOME=tmp_path)) == [-1.0, 0.0]


def test_a_changed_constant_of_a_file_without_compiled_code_is_seen(copy: Path, tmp_path: Path) -> None:
    (copy / "optimizer/trial.py").write_text(TRIAL.format(room="delta_cad.common.jit"))
    for factor in (2.0, 5.0):
        (copy / "optimizer/constant_of_trial.py").write_text(f"FACTOR = {factor}\n")
        process = run(copy, "from optimizer.trial import product; print(product(1.5))", HOME=tmp_path)
        assert wording(process) == [1.5 * factor]


def test_a_file_that_hides_its_decorator_is_refused(copy: Path, tmp_path: Path) -> None:
    (copy / "optimizer/trial.py").write_text(TRIAL.format(room="optimizer.globalopt.cutting_points"))
    (copy / "optimizer/constant_of_trial.py").write_text("FACTOR = 1.0\n")
    process = run(copy, "from optimizer.trial import product; product(1.5)", HOME=tmp_path)
    assert "optimizer/trial.py is to import its decorator from" in process.stderr


def test_edits_next_to_compiled_code_cost_nothing(copy: Path, tmp_path: Path) -> None:
    run(copy, HOME=tmp_path)
    edit(copy / "delta_cad/common/console.py", "from __future__", "# another line\nfrom __future__")
    assert wording(run(copy, HOME=tmp_path)) == [3.0, 1.0]


@pytest.mark.parametrize("name", ["NUMBA_CACHE_DIR", "XDG_CACHE_HOME"])
def test_users_say_where_it_is_kept(copy: Path, tmp_path: Path, name: str) -> None:
    run(copy, HOME=tmp_path, **{name: tmp_path / "there"})
    assert not (tmp_path / ".cache").exists()
    assert list((tmp_path / "there/delta-haptics").rglob("*.nbc"))
    assert not list(copy.rglob("*.nbc"))


def test_damaged_files_are_compiled_anew(copy: Path, tmp_path: Path) -> None:
    run(copy, HOME=tmp_path)
    for path in times(tmp_path / ".cache"):
        os.truncate(path, path.stat().st_size // 2)
    assert wording(run(copy, HOME=tmp_path)) == [3.0, 0.0]
    assert wording(run(copy, HOME=tmp_path)) == [3.0, 1.0]


@pytest.mark.slow
@pytest.mark.parametrize("trouble", ["no HOME", "no folder can be made", "disk full"])
def test_where_nothing_can_be_kept_one_line_says_so(copy: Path, tmp_path: Path, trouble: str) -> None:
    (tmp_path / "file").write_text("")
    places = {} if trouble == "no HOME" else {"HOME": tmp_path / ("file" if trouble == "no folder can be made" else "")}
    full = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))\n" if trouble == "disk full" else ""
    process = (fresh if full else run)(copy, full + CALLER, **places)  # a fork writes what it says to files
    assert process.stdout == "3.0 0\n"
    assert process.stderr.count("\n") == 1
    assert "NUMBA_CACHE_DIR" in process.stderr


@pytest.mark.slow
def test_folders_that_nobody_used_for_long_are_thrown_away(copy: Path, tmp_path: Path) -> None:
    old, young = tmp_path / ".cache/delta-haptics/old", tmp_path / ".cache/delta-haptics/young"
    for folder, age in ((old, UNUSED_MAX_S + 60.0), (young, UNUSED_MAX_S - 3600.0)):
        folder.mkdir(parents=True)
        os.utime(folder, (time.time() - age,) * 2)
    run(copy, HOME=tmp_path)
    assert (old.exists(), young.exists()) == (False, True)


def test_nothing_is_loaded_before_the_first_call(copy: Path, tmp_path: Path) -> None:
    (copy / "optimizer/trial.py").write_text(TURN)
    code = "import sys; from optimizer.trial import first; print(int('numba' in sys.modules), first.__name__ != '')"
    assert fresh(copy, code, HOME=tmp_path).stdout == "0 True\n"


def test_calls_in_turn_are_made_as_if_written_by_hand_and_kept_apart(copy: Path, tmp_path: Path) -> None:
    (copy / "optimizer/trial.py").write_text(TURN)
    code = """
import numpy as np
from optimizer.trial import first, second
out = np.array([1.0, 2.0])
first(3.0, out)
hits = sum(first.stats.cache_hits.values())
print(*out, second(3.0, out), hits + sum(second.stats.cache_hits.values()))
"""
    # (1 + 3, 2 * 3 + 3), then (4 * 3) - (9 + 3)
    assert wording(run(copy, code, HOME=tmp_path)) == [4.0, 9.0, 0.0, 0.0]
    assert wording(run(copy, code, HOME=tmp_path)) == [4.0, 9.0, 0.0, 2.0]


def test_a_number_that_is_written_out_compiles_nothing_anew(copy: Path, tmp_path: Path) -> None:
    (copy / "optimizer/trial.py").write_text(TURN)
    code = "import numpy as np; from optimizer.trial import first; first(3.0, np.array([1.0, 2.0]))"
    assert wording(run(copy, code, HOME=tmp_path)) == []
    # one file of machine code a function, though the first one is called with 0 and with 1
    kept = [path.name.split("-")[0] for path in (tmp_path / ".cache").rglob("trial.*.nbc")]
    assert sorted(kept)[:2] == ["trial.one", "trial.other"]
    assert len(kept) == 3


def test_what_python_does_not_call_becomes_machine_code_only_within_its_callers(copy: Path, tmp_path: Path) -> None:
    (copy / "optimizer/trial.py").write_text(TURN)
    code = """
import numpy as np
from optimizer.trial import first, one, other
first(3.0, np.array([1.0, 2.0]))
for function, inner in ((first.dispatcher, False), (one.inner, True), (other.inner, True)):
    (found,) = function.overloads.values()
    engine = found.library.codegen._engine
    print(int(engine.is_symbol_defined(found.fndesc.llvm_func_name) != inner), int(function.stats.cache_misses != {}))
"""
    assert wording(run(copy, code, HOME=tmp_path)) == [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    other = "from optimizer.trial import second, one; import numpy as np; out = np.array([1.0, 2.0])\n"
    hits = "print(*out, second(3.0, out), sum(one.inner.stats.cache_hits.values()))"
    assert wording(run(copy, other + hits, HOME=tmp_path)) == [1.0, 2.0, -2.0, 1.0]  # 1 * 3 - (2 + 3)


def test_arrays_that_inlined_code_passes_on_are_not_counted(copy: Path, tmp_path: Path) -> None:
    """Each count is two atomic operations: they took a sixth of the simulation's time."""
    code = """
import numpy as np
from haptics.model.plant import FREE, STATES, Plant, advance
zero, state, room = np.zeros(3), np.zeros(STATES), np.zeros((13, STATES))
advance(Plant(*len(Plant._fields) * [1.0]), FREE, zero, zero, zero, 1e-4, 1, state, room)
(text,) = advance.dispatcher.inspect_llvm().values()
print(text.count("call void @NRT_incref"))
"""
    assert wording(run(copy, code, HOME=tmp_path)) == [0.0]


def test_operators_remember_types_and_learn_of_new_ones(copy: Path, tmp_path: Path) -> None:
    (copy / "optimizer/trial.py").write_text(
        "from delta_cad.common.jit import compiled\n@compiled\ndef product(a, b):\n    return a * b\n"
    )
    code = """
import operator
from numba.core.errors import TypingError
from numba.extending import overload, types
from optimizer.trial import product
print(product(2, 3), product(2.0, 3.0), product(2, 3.5))
mul = product.dispatcher.typingctx.resolve_value_type(operator.mul)
context = product.dispatcher.typingctx
asked = types.float64, types.float64
print(int(mul.get_call_type(context, asked, {}) is mul.get_call_type(context, asked, {})))
for _ in range(2):
    try:
        product(2.0, None)
    except TypingError as error:
        print(int("Invalid use" in str(error) or "No implementation" in str(error)))
@overload(operator.mul)
def by_a_word(a, b):
    if isinstance(b, types.UnicodeType):
        return lambda a, b: a * len(b)
print(product(2.0, "word"))
"""
    assert wording(run(copy, code, HOME=tmp_path)) == [6.0, 6.0, 7.0, 1.0, 1.0, 1.0, 8.0]


OWN = """
from delta_cad.common.jit import compiled, unrolled_dispatch
@compiled
def law(a):
    return {factor} * a[0]
@compiled
def of_the_law(a):
    return law(a) + 1.0
import haptics.rendering.states as states
exec("from delta_cad.common.jit import unrolled_dispatch\\nturn = unrolled_dispatch('a', [(law,)], 'return {{0}}(a)')",
     states.__dict__ | {{"law": law}}, out := {{}})
import numpy
a = numpy.ones(1)
print(of_the_law(a), out["turn"](a))
"""
"""A user's own functions, and one that a file of ours makes to call them."""


@pytest.mark.slow
def test_what_is_compiled_of_a_users_own_file_is_never_kept(copy: Path, tmp_path: Path) -> None:
    for factor in (2.0, 5.0):
        own = copy / "own.py"
        own.write_text(OWN.format(factor=factor))
        assert wording(run(copy, "import own", HOME=tmp_path)) == [factor + 1.0, factor]


@pytest.mark.slow
def test_two_of_one_text_that_call_others_are_two(copy: Path, tmp_path: Path) -> None:
    same = """
from delta_cad.common.jit import compiled, unrolled_dispatch
@compiled
def double(a):
    return 2.0 * a
@compiled
def triple(a):
    return 3.0 * a
twice, thrice = (unrolled_dispatch("a", [(f,)], "return {0}(a)") for f in (double, triple))
"""
    (copy / "optimizer/trial.py").write_text(same)
    for _ in range(2):
        assert wording(run(copy, "from optimizer.trial import *; print(twice(1.0), thrice(1.0))", HOME=tmp_path)) == [
            2,
            3,
        ]


@pytest.mark.slow
def test_an_edit_while_a_process_runs_does_not_reach_another(copy: Path, tmp_path: Path) -> None:
    (copy / "optimizer/constant_of_trial.py").write_text("FACTOR = 2.0\n")
    (copy / "optimizer/trial.py").write_text(TRIAL.format(room="delta_cad.common.jit"))
    late = """
import pathlib, optimizer.trial
pathlib.Path("optimizer/constant_of_trial.py").write_text("FACTOR = 3.0\\n")
print(optimizer.trial.product(1.0))
"""
    assert wording(run(copy, late, HOME=tmp_path)) == [2.0]
    assert wording(run(copy, "from optimizer.trial import product; print(product(1.0))", HOME=tmp_path)) == [3.0]


@pytest.mark.slow
@pytest.mark.parametrize("head", ["try:\n    {0}\nexcept ImportError:\n    pass", "if True:\n    {0}", "{0}"])
def test_a_constant_is_seen_wherever_it_is_imported(copy: Path, tmp_path: Path, head: str) -> None:
    line = "from optimizer.constant_of_trial import FACTOR"
    (copy / "optimizer/trial.py").write_text(TRIAL.format(room="delta_cad.common.jit").replace(line, head.format(line)))
    for value in (2.0, 7.0):
        (copy / "optimizer/constant_of_trial.py").write_text(f"FACTOR = {value}\n")
        assert wording(run(copy, "from optimizer.trial import product; print(product(1.0))", HOME=tmp_path)) == [value]


@pytest.mark.slow
def test_numba_may_be_switched_off(copy: Path, tmp_path: Path) -> None:
    (copy / "optimizer/constant_of_trial.py").write_text("FACTOR = 2.0\n")
    (copy / "optimizer/trial.py").write_text(TRIAL.format(room="delta_cad.common.jit"))
    code = "from optimizer.trial import product; print(product(1.0))"
    assert wording(fresh(copy, code, HOME=tmp_path, NUMBA_DISABLE_JIT=Path("1"))) == [2.0]


def test_another_release_of_numba_compiles_by_its_public_interface(copy: Path, tmp_path: Path) -> None:
    (copy / "optimizer/trial.py").write_text(TURN)
    code = """
import numba, sys
numba.__version__ = "9.0.0"
import numpy as np
from optimizer.trial import first, second
out = np.array([1.0, 2.0])
first(3.0, out)
print(*out, second(3.0, out), int("delta_cad.common.numba_code.private" in sys.modules))
print(sum(first.dispatcher.stats.cache_hits.values()))
"""
    private = wording(run(copy, code.replace('numba.__version__ = "9.0.0"', ""), HOME=tmp_path))
    found = wording(run(copy, code, HOME=tmp_path))
    assert private[:3] == found[:3] == [4.0, 9.0, 0.0]
    assert (private[3:], found[3:]) == ([1.0, 0.0], [0.0, 0.0])
    assert wording(run(copy, code, HOME=tmp_path))[3:] == [
        0.0,
        1.0,
    ]  # the second run finds the machine code of the first


def test_two_threads_that_call_first_at_once_share_one_dispatcher(monkeypatch: pytest.MonkeyPatch) -> None:
    made, both = [], Barrier(2)

    def dispatcher_of(*_: object, **__: object) -> object:
        one = object()
        both.wait(60.0)
        made.append(one)
        return one

    monkeypatch.setattr(numba_code, "dispatcher_of", dispatcher_of)
    one = compiled(abs)
    with ThreadPoolExecutor(2) as threads:
        first, second = threads.map(lambda _: one.dispatcher, range(2))
    assert len(made) == 2
    assert first is second is one.dispatcher
