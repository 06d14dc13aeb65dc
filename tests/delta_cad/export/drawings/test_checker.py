"""The checker finds nothing on a sound drawing, and each fault that is put into it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.export.drawings.checker import drawing_faults, extent_faults, sheet_faults
from delta_cad.export.drawings.part.record import Features
from delta_cad.export.drawings.sheet_io.sheet import (
    Annotation,
    Drawing,
    Item,
    Primitive,
    Sheet,
    Stroke,
    Text,
    primitives,
)
from delta_cad.export.drawings.views.marks import arrow
from tests.delta_cad.export.drawings.sample import drawn, plate, texts


@pytest.fixture(scope="module")
def sound() -> tuple[Drawing, Features]:
    return drawn()


def spoiled(drawing: Drawing, spoil: Callable[[list[Item]], list[Item]]) -> Drawing:
    first = drawing.sheets[0]
    return replace(drawing, sheets=(replace(first, items=spoil(list(first.items))), *drawing.sheets[1:]))


def _is_reported(leaf: Primitive, text: str) -> bool:
    return isinstance(leaf, Text) and leaf.text == text and bool(leaf.states)


def edited(drawing: Drawing, old: str, new: str | None) -> Drawing:
    """A drawing with the first of a text's occurrences changed, or taken away."""
    assert old in texts(drawing)

    def spoil(items: list[Item]) -> list[Item]:
        k = next(k for k, item in enumerate(items) if any(_is_reported(leaf, old) for leaf in primitives([item])))
        own = [leaf for leaf in primitives([items[k]]) if not _is_reported(leaf, old)]
        (text,) = (leaf for leaf in primitives([items[k]]) if isinstance(leaf, Text) and _is_reported(leaf, old))
        return [*items[:k], *own, *([replace(text, text=new)] if new is not None else []), *items[k + 1 :]]

    return spoiled(drawing, spoil)


def test_a_sound_drawing_has_no_faults(sound: tuple[Drawing, Features]) -> None:
    drawing, features = sound
    assert drawing_faults(drawing, plate(), features) == []
    assert "-8 ±0.02" in texts(drawing)


@pytest.mark.parametrize(
    ("old", "new", "wording"),
    [
        ("Ø8 H7 through, shaft", None, "holes Ø8 H7 are stated 0 times, 1 are declared"),
        ("2x M4 x 6, drilled 6 deep", "3x M4 x 6, drilled 6 deep", "holes M4 are stated 3 times, 2 are declared"),
        ("2x M4 x 6, drilled 6 deep", "2x M3 x 6", "holes M4 are stated 0 times"),
        ("Ø8 H7 through, shaft", "Ø8 through, shaft", "holes Ø8 H7 are stated 0 times"),
        ("2x Ø5.5 through, screws", None, "holes Ø5.5 are stated 0 times, 2 are declared"),
        ("50", None, "is stated 0 times"),
        ("60", "61", "is printed as [61.0], it is 60.000 mm from the datum"),
        ("10", "10.01", "it is 10.000 mm from the datum"),
    ],
)
def test_what_is_missing_or_wrong_is_found(
    sound: tuple[Drawing, Features], old: str, new: str | None, wording: str
) -> None:
    drawing, features = sound
    faults = drawing_faults(edited(drawing, old, new), plate(), features)
    assert any(wording in fault for fault in faults), faults


def test_what_is_reported_twice_is_found(sound: tuple[Drawing, Features]) -> None:
    drawing, features = sound
    text = next(t for t in drawing.sheets[0].texts if t.text == "60")
    twice = spoiled(drawing, lambda items: [*items, replace(text, at=(200.0, 100.0))])
    assert any(fault.endswith("is stated 2 times") for fault in drawing_faults(twice, plate(), features))
    strange = spoiled(drawing, lambda items: [*items, Text((200.0, 100.0), 2.5, "7", states=("plane 99",))])
    assert "plane 99 is stated and is nothing of the part" in drawing_faults(strange, plate(), features)


@pytest.mark.parametrize(
    ("items", "wording"),
    [
        ([Text((100, 100), 2.5, "abc"), Text((103, 101), 2.5, "def")], "'abc' and 'def' overlap"),
        ([Text((100, 100), 2.5, "abc"), Text((103, 98), 2.5, "def", upright=True)], "'abc' and 'def' overlap"),
        ([Text((100, 100), 2.5, "abc"), Stroke("visible", ((90, 101), (120, 101)))], "'abc' lies over an edge"),
        ([Text((10, 100), 2.5, "abc")], "'abc' is outside of the frame"),
        ([Text((284, 100), 2.5, "abc")], "'abc' is outside of the frame"),
    ],
)
def test_what_lies_over_something_is_found(items: list[Item], wording: str) -> None:
    assert sheet_faults(Sheet(297.0, 210.0, items)) == [wording]


def test_what_lies_clear_is_not_found() -> None:
    items = [Text((100, 100), 2.5, "abc"), Text((100, 104), 2.5, "def"), Stroke("visible", ((90, 99), (120, 99)))]
    assert sheet_faults(Sheet(297.0, 210.0, [*items, Stroke("dimension", ((90, 101), (120, 101)))])) == []


def test_an_end_that_nothing_tells_is_found(sound: tuple[Drawing, Features]) -> None:
    drawing, features = sound
    longer = replace(plate(), extent_mm=((0.0, 61.0), (0.0, 40.0), (0.0, 8.0)))
    assert drawing_faults(drawing, longer, features) == ["nothing tells its end at 61.000 mm along x"]


def test_a_corner_of_slanted_faces_needs_no_coordinate_and_a_face_across_does(sound: tuple[Drawing, Features]) -> None:
    """A sector's lug ends in corners, which its own sides tell."""
    across = [face for face in sound[1].faces if face.kind == "plane" and abs(face.axis[0]) > 0.5]
    slanted = [replace(face, axis=np.array([0.8, 0.6, 0.0])) for face in across]
    part, bare = replace(plate(), extent_mm=((0.0, 60.0), None, None)), replace(sound[1], places=[], sizes=[])
    for faces, faults in ((across, 2), (slanted, 0), ([*across, *slanted], 2)):
        assert len(list(extent_faults(part, replace(bare, faces=faces)))) == faults


def test_frames_that_overlap_are_found() -> None:
    sheet = Sheet(297.0, 210.0, [], {"a": (30, 30, 60, 60), "b": (59, 59, 80, 80), "c": (60, 30, 70, 59)})
    assert sheet_faults(sheet) == ["a and b overlap"]


def symbol(x: float, y: float, name: str = "datum A") -> Annotation:
    """A box of 4 mm with a letter in it."""
    box = Stroke("dimension", ((x, y), (x + 4, y), (x + 4, y + 4), (x, y + 4)), closed=True)
    return Annotation(name, (box, Text((x + 1, y + 1), 2.0, "A")))


@pytest.mark.parametrize(
    ("items", "wording"),
    [
        ([symbol(100, 100), Text((103, 101), 2.5, "def")], ["symbol datum A and 'def' overlap"]),
        ([symbol(100, 100), Text((93.8, 102), 2.5, "over")], ["symbol datum A and 'over' overlap"]),
        ([symbol(100, 100), symbol(103.9, 100, "datum B")], ["symbol datum A and symbol datum B overlap"]),
        ([symbol(100, 100), Stroke("visible", ((90, 103.5), (120, 103.5)))], ["symbol datum A lies over an edge"]),
        ([symbol(18, 100)], ["'A' is outside of the frame", "symbol datum A is outside of the frame"]),
        ([symbol(100, 100), symbol(104, 100), symbol(100, 104), Stroke("dimension", ((90, 102), (120, 102)))], []),
    ],
)
def test_a_symbol_stands_clear_of_texts_edges_and_others(items: list[Item], wording: list[str]) -> None:
    assert sheet_faults(Sheet(297.0, 210.0, items)) == wording


def leader(*points: tuple[float, float]) -> list[Item]:
    """A line that ends in an arrow."""
    return [Stroke("dimension", points), arrow(points[-1], points[-2])]


CROSSED = [*leader((100, 100), (80, 80)), *leader((80, 100), (100, 80))]
LEVEL = leader((120, 90), (100, 90))


@pytest.mark.parametrize(
    ("items", "wording"),
    [
        (CROSSED, ["leaders to (80.0, 80.0) and (100.0, 80.0) cross"]),
        ([*CROSSED[:2], *leader((100, 80), (95, 80), (90, 80))], []),
        ([*LEVEL, Stroke("visible", ((90, 90), (110, 90)))], ["leader to (100.0, 90.0) runs along an edge"]),
        ([*LEVEL, Stroke("visible", ((90, 90), (102, 90)))], []),
        ([*LEVEL, Stroke("visible", ((100, 80), (100, 110)))], []),
    ],
)
def test_leaders_that_cannot_be_followed_are_found(items: list[Item], wording: list[str]) -> None:
    assert sheet_faults(Sheet(297.0, 210.0, items)) == wording
