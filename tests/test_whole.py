"""Files and folders that appear whole or not at all."""

from pathlib import Path

import pytest

from delta_cad.whole import whole_folder, write_all, write_whole


def test_folder_takes_its_place_when_it_is_full(tmp_path: Path) -> None:
    target = tmp_path / "new" / "front"
    for text in ("first", "second"):
        with whole_folder(target) as folder:
            assert list(folder.iterdir()) == []
            (folder / "a").write_text(text)
            assert folder != target
        assert (target / "a").read_text() == text
    assert [path.name for path in target.parent.iterdir()] == ["front"]


def test_folder_that_fails_leaves_what_was(tmp_path: Path) -> None:
    target = tmp_path / "front"
    target.mkdir()
    (target / "a").write_text("old")

    def fill() -> None:
        with whole_folder(target) as folder:
            (folder / "a").write_text("new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fill()
    assert (target / "a").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["front"]


def test_folder_of_a_killed_run_is_put_right(tmp_path: Path) -> None:
    for name in ("front.part", "front.old"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "rest").write_text("")
    with whole_folder(tmp_path / "front") as folder:
        assert list(folder.iterdir()) == []
    assert [path.name for path in tmp_path.iterdir()] == ["front"]


def test_file_in_the_folders_place_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "front").write_text("a file")
    with pytest.raises(FileExistsError, match="a file has the folder's name"), whole_folder(tmp_path / "front"):
        pass
    assert (tmp_path / "front").read_text() == "a file"


def test_a_file_is_whole_or_not_at_all(tmp_path: Path) -> None:
    write_whole(tmp_path / "a" / "b.json", "one")
    with pytest.raises(UnicodeEncodeError):
        write_whole(tmp_path / "a" / "b.json", "\ud800")  # no UTF-8: fails while it is written
    assert (tmp_path / "a" / "b.json").read_text() == "one"
    assert [file.name for file in (tmp_path / "a").iterdir()] == ["b.json"]


def test_two_files_are_written_both_or_none(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old")
    (tmp_path / "b").mkdir()
    with pytest.raises(IsADirectoryError):
        write_all({tmp_path / "a": "new", tmp_path / "b": "new"})
    assert (tmp_path / "a").read_text() == "old"
    assert sorted(f.name for f in tmp_path.iterdir()) == ["a", "b"]


def test_a_folder_that_a_kill_left_between_the_two_renames_is_put_back(tmp_path: Path) -> None:
    (tmp_path / "front.old").mkdir()
    (tmp_path / "front.old" / "a").write_text("old")

    def fill() -> None:
        with whole_folder(tmp_path / "front"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fill()
    assert (tmp_path / "front.old" / "a").read_text() == "old"  # nothing is lost before the new one is whole
