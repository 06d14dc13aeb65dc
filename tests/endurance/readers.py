"""The readers of files and packets, and what damage must never do to them."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import signal
import tomllib
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from delta_cad.catalogue import CHOSEN, FAMILIES, CatalogueError, own_parts
from delta_cad.catalogue.reader import DATA, read_family
from delta_cad.checks.report import CheckResult
from delta_cad.commands import cli as delta_cad_cli
from delta_cad.common.files import RECORD, refuse_foreign_files
from delta_cad.design import Design, DesignError, design_hash, design_to_dict, load_design
from delta_cad.design.lengths import load_lengths
from delta_cad.drive.masses import MassError, load_masses
from delta_cad.report.built import Build, StaleBuildError
from delta_cad.report.statements import certificate as wording
from haptics.calibration.accuracy import accuracy
from haptics.calibration.fit import fit
from haptics.calibration.poses import PosesError, load_poses
from haptics.calibration.record import CalibrationError, calibration_of, load_calibration, to_dict
from haptics.commands import cli as haptics_cli
from haptics.devices.protocol import Packet, PacketError, PacketKind, decode, encode
from haptics.devices.recording import Recording, RecordingError, load_recording, save_recording
from optimizer.certify.certificate import Certificate, CertificateError, limits_of
from optimizer.certify.file import certificate_to_dict, read_certificate
from optimizer.certify.gravity import GravityError, allowance_of_masses
from optimizer.codesign.corrections import reference
from optimizer.codesign.lengths import Found
from optimizer.codesign.search import SolidResults
from optimizer.codesign.search_log import Journal
from optimizer.commands import cli as optimizer_cli
from optimizer.commands.init import preset_text
from optimizer.problem.brief import load_brief
from optimizer.problem.requirements import (
    RequirementsError,
    load_requirements,
    requirements_from_dict,
    requirements_hash,
)
from optimizer.problem.validation import MOST_REPORTED
from optimizer.study.grid import load_grid
from optimizer.study.machines import existing_builds
from optimizer.synthesis.checkpoint import Checkpoint, CheckpointError, as_json
from optimizer.synthesis.output import DesignFile, OtherDesignError
from tests.committed import BEST, ROOT
from tests.endurance.mutation import csv_text, damaged, json_text, mutated, strange, toml_text
from tests.haptics.calibration.devices import cube_points, made, measured, poses_text
from tests.optimizer.certify.designs import masses, redigested

HANG_S = 10.0
LONGEST_LINE = 3000  # characters of a message: the longest lists of what is known have half of it
KEY = {"run": 1}
RESULTS = [CheckResult("clearance", False, 1.9, 2.0, "mm", (1.0, 2.0, 3.0), ("rod_0_0", "motor_1"), "too close")]
# Step of a search's journal -> what it is computed from, its result, the type of that.
STEPS: dict[str, tuple[str, Any, Any]] = {
    "lengths": ("a", Found((91.0, 2.0, 3.0, 4.0, 5.0, 6.0), 7.0), Found | None),
    "moving": ("b", RESULTS, list[CheckResult]),
    "weighed": ("c", (reference(), RESULTS, (0.1, 0.2)), SolidResults),
}
COMMANDS_EVERY = 20  # one of so many refused files goes through its command, too


class HangError(Exception):
    """A reader that did not come back."""


@dataclass(frozen=True)
class Reader:
    """One reader.

    Attributes:
        name: Its name.
        file: Name that its files have.
        make: Damaged content of a file, of random numbers.
        read: Reads a file.
        refuses: The only errors it may raise.
        command: A command's `main` and its arguments for a file that is refused; None where none reads such files.
    """

    name: str
    file: str
    make: Callable[[Random], bytes]
    read: Callable[[Path], object]
    refuses: tuple[type[Exception], ...]
    command: tuple[Callable[[list[str]], int], Callable[[Path], list[str]]] | None = None


def _of_tree(data: Any, write: Callable[[Any, Random], str], forge: Callable[[Any], Any] | None = None) -> Any:
    """Content by grammar, two thirds of the time, else by bytes, or by both."""

    def make(rng: Random) -> bytes:
        how = rng.randrange(6)
        try:
            tree = data if how == 0 else mutated(data, rng)
            if forge is not None and rng.random() < 0.7:
                with contextlib.suppress(AttributeError, TypeError, ValueError):
                    tree = forge(tree)
            content = write(tree, rng).encode("utf-8", "surrogatepass")
        except (RecursionError, ValueError):  # an integer, or a depth, that Python does not write
            content, how = write(data, rng).encode(), 0
        return damaged(content, rng) if how < 2 else content

    return make


def _lines(records: list[Any]) -> Callable[[Random], bytes]:
    """AppendLog of a checkpoint whose check sums are right, more often than not."""

    def line(record: Any, rng: Random) -> str:
        text = json.dumps(record, separators=(",", ":"))
        return f'{{"crc32":{zlib.crc32(text.encode()) + (rng.random() < 0.05)},"record":{text}}}'

    def make(rng: Random) -> bytes:
        try:
            kept = [mutated(one, rng) if rng.random() < 0.5 else one for one in records]
            lines = [json.dumps({"key": KEY}, separators=(",", ":")), *(line(one, rng) for one in kept)]
        except (RecursionError, ValueError):
            lines = ["{}"]
        content = ("\n".join(lines) + "\n").encode("utf-8", "surrogatepass")
        return damaged(content, rng) if rng.random() < 0.3 else content

    return make


def _resumed(path: Path) -> None:
    Checkpoint(path, KEY, resume=True).close()


def _searched(path: Path) -> None:
    """Takes up a search's journal, every step of it as the search does."""
    journal = Journal(path, KEY, True)
    try:
        for step, (of, made, kind) in STEPS.items():
            journal.memoize(step, of, lambda made=made: made, kind)
    finally:
        journal.close()


def _steps() -> list[dict[str, Any]]:
    """Records of a journal, as a search writes them."""
    return [{"step": step, "of": sha256(repr(of).encode()).hexdigest(), "result": as_json(made, kind)}
            for step, (of, made, kind) in STEPS.items()]  # fmt: skip


def _written(folder: Path) -> Callable[[Path], None]:
    """Looks at a folder with a record of what was written, as before it is replaced."""

    def read(path: Path) -> None:
        place = folder / "written"
        place.mkdir(exist_ok=True)
        (place / "a.txt").write_text("a")
        path.replace(place / RECORD)
        refuse_foreign_files(place)

    return read


def _packed(whole: bytes) -> Callable[[Random], bytes]:
    """An npz file damaged, or one of other arrays."""

    def make(rng: Random) -> bytes:
        if rng.random() < 0.7:
            content = whole
            for _ in range(rng.randint(1, 3)):
                content = damaged(content, rng)
            return content
        arrays: dict[str, Any] = {}
        for name in ("columns", "values", rng.choice(("other", "values"))):
            with contextlib.suppress(ValueError, OverflowError, TypeError):
                arrays[name] = np.array(strange(rng))
        file = io.BytesIO()
        with contextlib.suppress(UnicodeEncodeError):
            np.savez(file, **{name: one for name, one in arrays.items() if one.dtype != object})
        return file.getvalue()

    return make


def _packet(rng: Random) -> bytes:
    values = {
        PacketKind.HELLO: 1,
        PacketKind.WELCOME: 4,
        PacketKind.STATE: 3,
        PacketKind.COMMAND: 3,
        PacketKind.REFUSED: 2,
    }
    kind = rng.choice(list(PacketKind))
    numbers = tuple(rng.choice((0, 1, 2)) for _ in range(values.get(kind, 0)))
    content = damaged(
        encode(Packet(kind, rng.getrandbits(32), rng.getrandbits(32), 0, rng.getrandbits(64), numbers)), rng
    )
    return content if rng.random() < 0.3 else content[:-4] + zlib.crc32(content[:-4]).to_bytes(4, "little")


MANIFEST = {"input_sha256": "0" * 64, "versions": {"delta-haptics": version("delta-haptics"), "python": "3.11.7"}}
MANIFEST |= {"files": {"bom.json": {"sha256": sha256(b"a").hexdigest(), "bytes": 1}}}
LENGTHS = {
    "mechanism": {
        "base_side_mm": 567.0, "base_joints_at": "middles", "platform_radius_mm": 44.0, "upper_arm_length_mm": 524.0,
        "forearm_length_mm": 1244.0, "collar_elbow_mm": 5.0,
    },
    "cube": {"bottom_height_mm": 900.0, "half_side_mm": 100.0},
}  # fmt: skip


def readers(folder: Path) -> list[Reader]:
    """Makes the readers, with valid files of each to damage.

    Args:
        folder: Where valid files may be written.
    """
    design, task = load_design(BEST), tomllib.loads((ROOT / "examples/synthesized.toml").read_text())
    brief = tomllib.loads(preset_text("dashboard")) | {"hardware": {"motor": ["maxon-re30-310007"], "drive": "capstan"}}
    brief["bounds_mm"] = {"base_radius": ["3 cm", 40], "half_side": [0, "100 mm"]}
    grid = {"name": "g", "seeds": [0, 1], "axes": {"requirements.joint_torque_N_m": [0.4, 0.8]}, "base": task}
    grid["axes"]["limits.outline_radius_max_mm"] = {"linspace": [118, 122, 3]}
    weights = masses(folder, design, 1e-5)
    certificate = certificate_to_dict(
        Certificate(
            design.name, "0" * 64, design.geometry, design.workspace, limits_of(design, None), (),
            np.array([[0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 1, 1]]), 3,
        )
    )  # fmt: skip
    scores = [[1.0, 2.0], [[0.1, 0.2], [0.3, -0.4]]]
    kept = [{"step": "ga", "of": "a", "result": scores}, {"step": "1/ga", "of": "b", "result": [[1.0], "done"]}]
    recording = Recording(np.arange(5.0), np.ones((5, 3)), np.zeros((5, 3)))
    for name in ("whole.csv", "whole.npz"):
        save_recording(recording, folder / name)
    found = [
        Reader("design", "d.json", _of_tree(json.loads(BEST.read_text()), json_text), load_design, (DesignError,),
               (delta_cad_cli.main, lambda p: ["inspect", "--design", str(p)])),
        Reader("lengths", "l.json", _of_tree(LENGTHS, json_text), load_lengths, (DesignError,),
               (delta_cad_cli.main, lambda p: ["inspect", "--kinematics", str(p)])),
        Reader("requirements", "r.toml", _of_tree(task, toml_text), load_requirements, (RequirementsError,),
               (optimizer_cli.main, lambda p: ["synthesize", str(p), "--out", str(p.with_name("b.json"))])),
        Reader("brief", "b.toml", _of_tree(brief, toml_text), load_brief, (RequirementsError,),
               (optimizer_cli.main, lambda p: ["design", str(p), "--out", str(p.parent)])),
        Reader("grid", "g.toml", _of_tree(grid, toml_text), load_grid, (RequirementsError,),
               (optimizer_cli.main, lambda p: ["atlas", str(p), "--out", str(p.parent)])),
        Reader("masses", "m.json", _of_tree(json.loads(weights.read_text()), json_text),
               lambda p: load_masses(p, design), (MassError,),
               (haptics_cli.main, lambda p: ["gravity", "--design", str(BEST), "--mass-properties", str(p)])),
        Reader("certificate", "c.json", _of_tree(certificate, json_text, redigested), read_certificate,
               (CertificateError,), (optimizer_cli.main, lambda p: ["verify", str(p)])),
        Reader("certificate's words", "p.json", _of_tree(certificate | {"design_hash": design_hash(design)}, json_text),
               lambda p: wording(design, p), ()),
        Reader("checkpoint", "c.jsonl", _lines(kept), _resumed, (CheckpointError,)),
        Reader("recording csv", "r.csv", _of_tree(_table(folder / "whole.csv"), csv_text), load_recording,
               (RecordingError,)),
        Reader("recording npz", "r.npz", _packed((folder / "whole.npz").read_bytes()), load_recording,
               (RecordingError,)),
        Reader("packet", "packet", _packet, lambda p: decode(p.read_bytes()), (PacketError,)),
    ]  # fmt: skip
    found += _calibration_readers(design, weights)
    found += _more_readers(design, weights, folder, task)
    for family in FAMILIES.values():
        found.append(
            Reader(
                f"catalogue {family.name}", Path(family.file).name, _of_tree(_table(DATA / family.file), csv_text),
                lambda p, record=family.record: read_family(p, record), (CatalogueError,),
            )
        )  # fmt: skip
    return found


def _calibration_readers(design: Design, weights: Path) -> list[Reader]:
    rng = np.random.default_rng(1)
    poses = measured(made(design, rng), cube_points(design, rng, 20), rng)
    found = fit(design.geometry, poses)
    calibration = to_dict(calibration_of(design, found, 20, accuracy(found, design)))
    rows = [line.split(",") for line in poses_text(poses).splitlines()]
    machine = ["--design", str(BEST), "--mass-properties", str(weights), "--fast", "--seconds", "0.01"]
    return [
        Reader("calibration", "k.json", _of_tree(calibration, json_text), lambda p: load_calibration(p, design),
               (CalibrationError,), (haptics_cli.main, lambda p: ["run", *machine, "--calibration", str(p)])),
        Reader("poses", "p.csv", _of_tree(rows, csv_text), load_poses, (PosesError,),
               (haptics_cli.main, lambda p: ["calibrate", "--design", str(BEST), str(p), "--out", str(p) + ".out"])),
    ]  # fmt: skip


def _more_readers(design: Design, weights: Path, folder: Path, task: dict[str, Any]) -> list[Reader]:
    """Those of files that a run finds where it is to write, and of designs and briefs with a panel."""
    panel = json.loads((ROOT / "examples/dashboard-panel.json").read_text())
    behind = tomllib.loads((ROOT / "examples/dashboard-panel.toml").read_text())
    given = requirements_from_dict(task)
    stands = design_to_dict(design) | {"name": given.name}
    stands["provenance"] = {"requirements_sha256": requirements_hash(given)}
    checks = {"input_sha256": design_hash(design), "passed": True, "failed": ["reach"], "checks": []}

    def built(path: Path) -> None:
        place = path.parent / design.name
        place.mkdir(exist_ok=True)
        (place / "report.html").write_text("")
        path.replace(place / "checks.json")
        existing_builds({"one": design}, path.parent)

    found = [
        Reader("design with a panel", "p.json", _of_tree(panel, json_text), load_design, (DesignError,)),
        Reader("brief with a panel", "p.toml", _of_tree(behind, toml_text), load_brief, (RequirementsError,)),
        Reader("masses for gravity", "m.json", _of_tree(json.loads(weights.read_text()), json_text),
               lambda p: allowance_of_masses(p, design, 1e-5), (GravityError,),
               (optimizer_cli.main, lambda p: ["certify", "--design", str(BEST), "--mass-properties", str(p),
                                               "--out", str(p) + ".out"])),
        Reader("search's journal", "s.jsonl", _lines(_steps()), _searched, (CheckpointError,)),
        Reader("design in the place", "o.json", _of_tree(stands, json_text), lambda p: DesignFile(p, given),
               (OtherDesignError,)),
        Reader("record of a folder", "w.json", _of_tree({"files": {"a.txt": {"sha256": sha256(b"a").hexdigest()}}},
               json_text), _written(folder), (FileExistsError,)),
        Reader("manifest of a build", "manifest.json", _of_tree(MANIFEST, json_text), lambda p: Build.read(p.parent),
               (StaleBuildError,)),
        Reader("checks of a build", "k.json", _of_tree(checks, json_text), built, ()),
    ]  # fmt: skip
    for family in CHOSEN.values():
        table, others = _table(DATA / family.file), family.rows
        table = [table[0], *([f"my-{row[0]}", *row[1:]] for row in table[1:3])]

        def own(path: Path, name: str = family.name) -> None:
            place = path.parent / f"own-{name}"
            place.mkdir(exist_ok=True)
            path.replace(place / f"{name}.csv")
            own_parts(place)

        assert table[1][0] not in others
        found.append(Reader(f"own {family.name}", f"{family.name}.own", _of_tree(table, csv_text), own,
                            (CatalogueError,)))  # fmt: skip
    return found


def _table(path: Path) -> list[list[str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.reader(file))


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Interrupts what takes longer."""

    def late(*_: object) -> None:
        raise HangError(f"no answer within {seconds:g} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def fault(reader: Reader, number: int, folder: Path) -> str | None:
    """Lets a reader read the damaged file of a number.

    Args:
        reader: The reader.
        number: Its random numbers' seed; the file is left in the folder.
        folder: Of the file.

    Returns:
        What the reader did that it must not; None if it read or refused the file as it should.
    """
    path = folder / reader.file
    path.write_bytes(reader.make(Random(f"{reader.name} {number}")))
    try:
        with within(HANG_S):
            reader.read(path)
    except reader.refuses as error:
        wrong = unfit(str(error))
        return wrong or (_commanded(reader, path) if number % COMMANDS_EVERY == 0 else None)
    except Exception as error:  # what is looked for
        return f"{type(error).__name__}: {str(error)[:200]!r}"
    return None


def unfit(line: str) -> str | None:
    """Says why a text cannot be shown as one line."""
    if not line or not line.isprintable():
        return f"the message is not one printable line: {line[:200]!r}"
    return f"the message has {len(line)} characters: {line[:100]}..." if len(line) > LONGEST_LINE else None


def _commanded(reader: Reader, path: Path) -> str | None:
    """What a command does with a refused file that it must not do."""
    if reader.command is None:
        return None
    main, arguments = reader.command
    out, err = io.StringIO(), io.StringIO()
    try:
        with within(HANG_S), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main(arguments(path))
    except BaseException as error:  # what is looked for
        return f"the command raised {type(error).__name__}: {str(error)[:200]!r}"
    text = err.getvalue()
    if code not in (1, 2) or out.getvalue() or not 1 <= text.count("\n") <= MOST_REPORTED + 1:
        return f"the command ended with {code}, {out.getvalue()[:100]!r} and {text[:200]!r}"
    return next((wrong for line in text.splitlines() if (wrong := unfit(line))), None)
