"""The runner of the benchmarks, on tiny subjects that end in every way a subject can."""

from __future__ import annotations

import ast
import fcntl
import json
from importlib import import_module
from pathlib import Path

import pytest

from tests.benchmarks import start_time
from tests.benchmarks.__main__ import MINUTES, chosen, main, run

FAKES = {
    "fine": "    say('counting')\n    return [Figure('fakes', 'two', 2.0, 's', 3.0, spread=(1.0, 2.5)), "
    "Figure('fakes', 'none', 0.0, '')]",
    "raises": "    raise KeyError('elbow')",
    "ends": "    import os\n    os._exit(0)",
    "killed": "    import os\n    os.kill(os.getpid(), 9)",
    "child_ends": "    succeeded(python('-c', 'import os; os._exit(3)'))",
    "stops": "    raise SystemExit('enough')",
    "no_figures": "    return [object()]",
    "hangs": "    python('-c', HANGS, str(HERE))",
    "broken": "    pass\n)",
}
HEAD = (
    "from pathlib import Path\nfrom tests.benchmarks.figure import Figure\n"
    "from tests.benchmarks.timing import python, succeeded\nfrom tests.benchmarks.test_runner import HANGS\n"
    "HERE = Path(__file__).parent\ndef run(say):\n"
)
HANGS = """
import fcntl, pathlib, sys, time
folder = pathlib.Path(sys.argv[1])
lock = open(folder / "held", "w")
fcntl.flock(lock, fcntl.LOCK_EX)
time.sleep(30)
(folder / "late").touch()
"""


@pytest.fixture
def fakes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of subjects `fake_...` that the runner's children can import."""
    for name, body in FAKES.items():
        (tmp_path / f"fake_{name}.py").write_text(f"{HEAD}{body}\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return tmp_path


@pytest.mark.slow
def test_no_subject_takes_the_others_with_it(fakes: Path) -> None:
    names = ("raises", "ends", "killed", "child_ends", "stops", "no_figures", "broken", "fine")
    assert run({f"fake_{name}": 60.0 for name in names}, fakes / "out", "bench") == 1
    reported = json.loads((fakes / "out" / "bench.json").read_text())
    assert [(f["name"], f["value"], f["spread"], f["reached"]) for f in reported["figures"]] == [
        ("two", 2.0, [1.0, 2.5], True),
        ("none", 0.0, None, None),
    ]
    failed = dict(line.split(": ", 1) for line in reported["failed"])
    assert list(failed) == [f"fake {name.replace('_', ' ')}" for name in names[:-1]]
    assert "KeyError" in failed["fake raises"]
    assert "elbow" in failed["fake raises"]
    assert "exit code 0" in failed["fake ends"]  # it came to no figures, whatever it says
    assert "signal 9" in failed["fake killed"]
    assert "exit code 3" in failed["fake child ends"]
    page = (fakes / "out" / "bench.md").read_text()
    assert "| two | 2 s | 1 to 2.5 | <= 3 s | yes |" in page
    assert all(line in page for line in reported["failed"])


def test_a_subject_that_does_not_end_is_killed_with_its_children(fakes: Path) -> None:
    assert run({"fake_hangs": 3.0, "fake_fine": 60.0}, fakes / "out", "bench") == 1
    reported = json.loads((fakes / "out" / "bench.json").read_text())
    assert len(reported["figures"]) == 2
    assert "3 s" in reported["failed"][0]
    with open(fakes / "held", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # its child holds it as long as it lives
    assert not (fakes / "late").exists()


def test_all_that_is_measured_is_exit_code_0(fakes: Path) -> None:
    assert run({"fake_fine": 60.0}, fakes / "new", "bench-some") == 0
    assert sorted(path.name for path in (fakes / "new").iterdir()) == ["bench-some.json", "bench-some.md"]


def test_subjects_are_chosen_by_full_or_last_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert chosen(["certificates", "haptics.wall"]) == ["optimizer.certificates", "haptics.wall"]
    assert sorted([*chosen([]), *chosen(["long"])]) == sorted(MINUTES)
    assert "optimizer.seeds" in chosen(["long"])
    with pytest.raises(SystemExit) as ended:
        main(["certificates", "walls"])
    assert ended.value.code == 2
    assert "walls" in capsys.readouterr().err
    assert len({name.rsplit(".", 1)[-1] for name in MINUTES}) == len(MINUTES)


@pytest.mark.parametrize("name", MINUTES)
def test_every_subject_can_be_imported_with_what_it_imports_later(name: str) -> None:
    module = import_module(f"tests.benchmarks.{name}")
    assert callable(module.run)
    for node in ast.walk(ast.parse(Path(module.__file__ or "").read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            for imported in node.names:
                if not hasattr(import_module(node.module), imported.name):
                    import_module(f"{node.module}.{imported.name}")


@pytest.mark.parametrize("package", start_time.PACKAGES)
def test_the_commands_whose_help_is_timed_are_found(package: str) -> None:
    assert len(start_time._subcommands(package)) >= 4
