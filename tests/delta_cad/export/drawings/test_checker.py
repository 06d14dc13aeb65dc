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
    box_of,
    overlap,
    primitives,
)
from delta_cad.export.drawings.title import FIELDS
from delta_cad.export.drawings.views.lines import boxed
from delta_cad.export.drawings.views.marks import arrow
from delta_cad.export.drawings.write import part_drawing
from delta_cad.solids.part import Part
from tests.delta_cad.export.drawings.sample import TITLES, drawn, plate, texts
from tests.delta_cad.export.drawings.test_zones import NONE
from tests.delta_cad.export.drawings.test_zones import plate as zoned


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


def located() -> tuple[Drawing, Part, Features]:
    """A plate with a seat, a pilot and dowels, each with its place from those before."""
    part = zoned()
    drawing, features = part_drawing(part, NONE, TITLES)
    assert drawing_faults(drawing, part, features) == []
    return drawing, part, features


def without_boxes(items: list[Item]) -> list[Item]:
    """Items without the frames of numbers, as of a drawing that has none."""

    def is_frame(leaf: Primitive, texts: list[Text]) -> bool:
        box = box_of([leaf])
        inside = (text for text in texts if text.text.replace("-", "").replace(".", "").isdigit())
        return (
            isinstance(leaf, Stroke)
            and leaf.closed
            and any(overlap(box, t.box) and box[2] - box[0] < 20 for t in inside)
        )

    texts = [leaf for leaf in primitives(items) if isinstance(leaf, Text)]
    return [
        replace(item, items=tuple(leaf for leaf in item.items if not is_frame(leaf, texts)))
        if isinstance(item, Annotation) and item.measure is not None
        else item
        for item in items
        if isinstance(item, Annotation) or not is_frame(item, texts)
    ]


def test_a_position_whose_coordinates_are_not_boxed_is_found() -> None:
    drawing, part, features = located()
    faults = drawing_faults(spoiled(drawing, without_boxes), part, features)
    assert sum("and its coordinate" in fault and fault.endswith("is not boxed") for fault in faults) >= 4
    assert len(faults) == sum("is not boxed" in fault for fault in faults)


def test_a_box_around_what_has_no_zone_of_position_is_found(sound: tuple[Drawing, Features]) -> None:
    drawing, features = sound
    text = next(t for t in drawing.sheets[0].texts if t.text == "60")
    framed_ = spoiled(drawing, lambda items: [*items, boxed(text)])
    (fault,) = drawing_faults(framed_, plate(), features)
    assert fault.endswith("is boxed, 60, and nothing tolerances its position")


@pytest.mark.parametrize(
    ("old", "new", "wording"),
    [
        (("A", "B", "C"), ("A", "B"), "holds 2 axes and neither fixes nor combines them: more datums, or CZ"),
        (("A", "B", "C"), ("A",), "holds 2 axes and neither fixes nor combines them: more datums, or CZ"),
        (("A", "B"), ("A",), "names too few datums to place an axis"),
    ],
)
def test_a_frame_whose_datums_do_not_place_what_it_holds_is_found(
    old: tuple[str, ...], new: tuple[str, ...], wording: str
) -> None:
    drawing, part, features = located()

    def cells(item: Item) -> list[Text]:
        return [leaf for leaf in primitives([item]) if isinstance(leaf, Text)]

    def fewer(items: list[Item]) -> list[Item]:
        found = []
        for item in items:
            if isinstance(item, Annotation) and item.name == f"position Ø0.05 {' '.join(old)}":
                gone = cells(item)[1 + len(new) :]
                kept = tuple(leaf for leaf in item.items if leaf not in gone)
                item = Annotation(f"position Ø0.05 {' '.join(new)}", kept)
            found.append(item)
        return found

    (fault,) = drawing_faults(spoiled(drawing, fewer), part, features)
    assert fault.endswith(wording)


def test_a_pattern_that_is_combined_needs_no_more_datums() -> None:
    drawing, part, features = located()

    def combined(items: list[Item]) -> list[Item]:
        found = []
        for item in items:
            if isinstance(item, Annotation) and item.name == "position Ø0.05 A B C":
                first = next(leaf for leaf in item.items if isinstance(leaf, Text))
                kept = [leaf for leaf in item.items if not isinstance(leaf, Text) or leaf.text == "A"]
                item = Annotation("position Ø0.05 CZ A", (replace(first, text="Ø0.05 CZ"), *kept))
            found.append(item)
        return found

    faults = drawing_faults(spoiled(drawing, combined), part, features)
    assert [fault for fault in faults if fault.startswith("position")] == []


@pytest.mark.parametrize(
    ("description", "wording"),
    [
        ("plate, hardened to 58 HRC", "'Hardened to 58 HRC' stands only in the part's description"),
        ("plate; bonded, reamed with a mandrel", "'Bonded, reamed with a mandrel' stands only in"),
        ("plate 8 h6", "8 h6 stands only in the title"),
    ],
)
def test_a_requirement_that_is_printed_nowhere_is_found(
    sound: tuple[Drawing, Features], description: str, wording: str
) -> None:
    drawing, features = sound
    part = replace(plate(), description=description)
    (fault,) = drawing_faults(drawing, part, features)
    assert fault.startswith(wording)
    assert drawing_faults(drawn(part)[0], part, features) == ([] if "only in the title" not in wording else [fault])


def test_a_section_that_misses_what_is_hidden_is_found(sound: tuple[Drawing, Features]) -> None:
    drawing, features = sound
    (section,) = drawing.sections
    astray = replace(section, steps=((np.inf, 13.0),))
    through = replace(section, steps=((np.inf, 20.0),))  # the plain bore and the threads, and no counterbore
    wording = "a section meets no bore of those with the most steps or a floor"
    assert drawing_faults(replace(drawing, sections=(astray,)), plate(), features) == [wording]
    assert drawing_faults(replace(drawing, sections=(through,)), plate(), features) == []
    (fault,) = drawing_faults(replace(drawing, sections=()), plate(), features)
    assert fault == "nothing is cut open, and a step or a floor is hidden"
    untitled = spoiled(drawing, lambda items: [i for i in items if not (isinstance(i, Text) and i.text == "A-A")])
    assert "a view is cut open and has no title A-A" in drawing_faults(untitled, plate(), features)


@pytest.mark.parametrize("label", FIELDS)
def test_a_field_of_the_title_block_without_its_text_is_found(sound: tuple[Drawing, Features], label: str) -> None:
    drawing, features = sound
    at = next(text.at for text in drawing.sheets[0].texts if text.text == label)

    def emptied(items: list[Item]) -> list[Item]:
        return [i for i in items if not (isinstance(i, Text) and i.at[0] == at[0] and 0 < at[1] - i.at[1] < 6)]

    assert drawing_faults(spoiled(drawing, emptied), plate(), features) == [f"sheet 1: title block: {label} is missing"]
