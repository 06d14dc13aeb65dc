"""A folder is replaced only where all that it holds was written by a run, and is as it was written."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from delta_cad.common.files import RECORD, remove, require_room, whole_folder
from delta_cad.export.folder import output_folder
from delta_cad.export.manifest import write_manifest


def written(place: Path, *names: str, text: str = "ours") -> Path:
    with whole_folder(place) as folder:
        for name in names:
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text(text)
    return place


def names(place: Path) -> list[str]:
    return sorted(path.relative_to(place).as_posix() for path in place.rglob("*") if path.is_file())


def test_what_a_run_wrote_is_replaced_also_by_less(tmp_path: Path) -> None:
    place = written(tmp_path / "feel", "a", "pictures/b.png")
    require_room(place, folder=True)
    written(place, "a", text="again")
    assert names(place) == [RECORD, "a"]
    assert (place / "a").read_text() == "again"


def other(place: Path) -> None:
    (place / "notes.txt").write_text("mine")


def below(place: Path) -> None:
    (place / "sub" / "thesis").mkdir(parents=True)
    (place / "sub" / "thesis" / "notes.txt").write_text("mine")


def changed(place: Path) -> None:
    (place / "a").write_text("mended by hand")


def linked(place: Path) -> None:
    (place / "a").rename(place.with_name("kept"))
    (place / "a").symlink_to(place.with_name("kept"))


def manifest(place: Path) -> None:
    """That of something else, as programs for the web have one."""
    (place / "manifest.json").write_text('{"files": ["a.js"]}')


def gone(place: Path) -> None:
    (place / RECORD).unlink()


def damaged(place: Path) -> None:
    (place / RECORD).write_text('{"files": {"a": 1}}')


@pytest.mark.parametrize("touch", [other, below, changed, linked, manifest, gone, damaged])
def test_what_no_run_wrote_is_not_replaced_and_refused_before_the_work(
    tmp_path: Path, touch: Callable[[Path], None]
) -> None:
    place = written(tmp_path / "firmware", "a")
    touch(place)
    before = {name: (place / name).read_bytes() for name in names(place)}
    for attempt in (lambda: require_room(place, folder=True), lambda: written(place, "a", "b")):
        with pytest.raises(FileExistsError, match="to lose nothing") as refused:
            attempt()
        assert refused.value.filename == str(place)
        assert {name: (place / name).read_bytes() for name in names(place)} == before
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []


def test_what_somebody_puts_there_during_the_work_is_not_replaced(tmp_path: Path) -> None:
    place = written(tmp_path / "firmware", "a")

    def work() -> None:
        with whole_folder(place) as folder:
            (folder / "a").write_text("again")
            other(place)

    with pytest.raises(FileExistsError, match=r"notes\.txt, which no run wrote"):
        work()
    assert (place / "notes.txt").read_text() == "mine"


def test_nobody_owns_an_empty_folder_and_what_desktops_put_into_one(tmp_path: Path) -> None:
    (tmp_path / "empty" / "sub").mkdir(parents=True)
    (tmp_path / "empty" / ".DS_Store").write_text("")
    assert names(written(tmp_path / "empty", "a")) == [RECORD, "a"]


def built(out: Path, rejected: bool = False) -> None:
    with output_folder(out, "name") as folder:
        folder.rejected = rejected
        (folder.path / "part").write_text("of the build")
        write_manifest(folder.path, input_hash="0", status="passed", fingerprint="0")


def test_a_build_says_by_its_manifest_what_it_wrote(tmp_path: Path) -> None:
    place = tmp_path / "name"
    built(tmp_path)
    assert names(place) == ["manifest.json", "part"]
    written(place / "drawings", "one.pdf")  # by a command of its own, into the folder of the build
    built(tmp_path)
    assert names(place) == ["manifest.json", "part"]
    other(place)
    with pytest.raises(FileExistsError, match=r"notes\.txt"):
        built(tmp_path)
    built_before = json.loads((place / "manifest.json").read_text())
    (place / "notes.txt").unlink()
    written(place / "drawings", "one.pdf")
    (place / "drawings" / "one.pdf").write_text("annotated")
    with pytest.raises(FileExistsError, match=r"drawings/one\.pdf, which was changed"):
        built(tmp_path)
    assert json.loads((place / "manifest.json").read_text()) == built_before


def test_a_rejected_build_is_not_replaced_either(tmp_path: Path) -> None:
    built(tmp_path, rejected=True)
    other(tmp_path / "name.rejected")
    with pytest.raises(FileExistsError, match=r"notes\.txt"):
        built(tmp_path)  # before the work: nobody knows yet whether it passes


def test_where_a_link_leads_to_nothing_is_lost(tmp_path: Path) -> None:
    place = written(tmp_path / "disk", "a")
    (tmp_path / "out").symlink_to(place)
    written(tmp_path / "out", "b")
    assert names(tmp_path / "out") == [RECORD, "b"]
    assert names(place) == [RECORD, "a"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["disk", "out"]


def test_a_folder_goes_whole_though_ctrl_c_comes_while_it_goes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "part" / "in").mkdir(parents=True)
    (tmp_path / "part" / "in" / "a").write_text("a")
    remove_all, count = shutil.rmtree, [0]

    def interrupted(folder: Path, ignore_errors: bool) -> None:
        count[0] += 1
        if count[0] < 3:
            raise KeyboardInterrupt
        remove_all(folder, ignore_errors=ignore_errors)

    monkeypatch.setattr(shutil, "rmtree", interrupted)
    with pytest.raises(KeyboardInterrupt):
        remove(tmp_path / "part")
    assert list(tmp_path.iterdir()) == []
