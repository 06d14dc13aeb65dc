"""The views of a part and the dimensions in each: the fewest views that show everything in true shape.

First angle: the view from the left stands on the right of the main one, that from above below it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import atan2, degrees
from typing import Any

import numpy as np

from delta_cad.common.memoize import cached
from delta_cad.export.drawings.part.faces import Face, is_across, is_along, is_straight
from delta_cad.export.drawings.part.holes import Bore, HoleGroup
from delta_cad.export.drawings.part.places import auxiliary_directions
from delta_cad.export.drawings.part.record import Features, Place, Size
from delta_cad.export.drawings.sheet_io.sheet import Arc, Item, Point, Stroke
from delta_cad.export.drawings.views.projection import Frame, cut_open, projected
from delta_cad.export.drawings.views.section import Section, hidden_bores, section_of
from delta_cad.solids.part import Part, solid_digest

_SEEN_MM = 5e-3  # the kernel's curves of a view are true to 1e-4
_WORTH = {"below": 1.0, "right": 1.0, "above": 0.0, "left": 0.0}  # of sides that show equally much the usual one


class ViewError(ValueError):
    """Something of a part is seen in its true shape from no side that it is drawn from."""


@dataclass(eq=False)
class View:
    """One view of a part.

    Attributes:
        slot: "front", "right", "left", "above", "below" for what stands beside the main view, "turned" or "picture".
        frame: From where.
        title: Written over it.
        cut: Where it is cut open; None: it is not.
        items: What is seen, mm, true size.
        behind: What is hidden in a view that is cut open, and left out but for what a coordinate is of.
        rings: Around the faces where it is cut open.
        places: Coordinates told in it.
        sizes: Sizes told in it.
        groups: Holes told in it.
        planes: Datum planes and planes with a tolerance that are told in it, each seen as an edge.
    """

    slot: str
    frame: Frame
    title: str = ""
    cut: Section | None = None
    items: list[Item] = field(default_factory=list)
    behind: list[Item] = field(default_factory=list)
    rings: list[list[Point]] = field(default_factory=list)
    places: list[Place] = field(default_factory=list)
    sizes: list[Size] = field(default_factory=list)
    groups: list[HoleGroup] = field(default_factory=list)
    planes: list[Face] = field(default_factory=list)

    @property
    def towards(self) -> np.ndarray:
        """(3,) to the viewer."""
        return self.frame.towards

    def shows(self, place: Place) -> bool:
        """Decides whether a coordinate is seen along an axis of this view."""
        return any(is_along(place.along, axis) for axis in self.frame.axes)

    def end_on(self, bore: Bore) -> bool:
        """Decides whether a bore is seen as a circle."""
        return is_along(bore.axis, self.towards)


def views_of(part: Part, features: Features, groove_mm: tuple[float, float] | None = None) -> list[View]:
    """Chooses the views of a part and draws them; a helical groove as threads are, see `Controlled.groove_mm`.

    Raises:
        ViewError: A coordinate is along no axis of any view, or a bore is slanted in all of them.
    """
    for bore in (bore for group in features.groups for bore in group.bores):
        if not is_straight(bore.axis) and not is_across(bore.axis, features.main):
            raise ViewError(f"a bore of {bore.widest:g} mm is slanted as seen from every side")
    views = [View("front", _front(features))]
    _add_sides(views, features)
    _add_turned(views, features)
    _cut(views, features)
    for view in views:
        _draw(view, part.solid)
        if groove_mm is not None and features.turned:
            _draw_groove(view, groove_mm[0] / 2.0, groove_mm[1] / 2.0)
    _share(views, features)
    for view in views:
        _reveal(view)
    views.append(_picture(part, views[0]))
    return views


def _front(features: Features) -> Frame:
    main = features.main
    if features.turned:
        flats = [size.faces[0].axis for size in features.sizes if size.kind == "flat"]
        aside = [bore.axis for g in features.groups for bore in g.bores if not is_along(bore.axis, main)]
        others = [axis for axis in np.eye(3) if not is_along(axis, main)]
        up = np.abs([*flats, *aside, others[-1]][0])
        return Frame.of(main, up)
    opens = 0.0
    for group in features.groups:
        for bore in group.bores:
            if is_along(bore.axis, main) and (not bore.through or len(bore.diameters) > 1):
                opens += float(bore.axis @ main)
    towards = -main if opens < 0.0 or (opens == 0.0 and main[1] > 0.5) else main
    up = np.array([0.0, 0.0, 1.0]) if abs(main[2]) < 0.5 else np.array([0.0, 1.0, 0.0])
    return Frame.of(np.cross(up, towards), up)


def adjacent(front: Frame, slot: str) -> Frame:
    """Gives the view that stands in a slot beside a main view, in first angle."""
    right, up, towards = np.array(front.right), np.array(front.up), front.towards
    axes = {"below": (right, -towards), "above": (right, towards), "right": (towards, up), "left": (-towards, up)}
    return Frame.of(axes[slot][0], axes[slot][1])


def _add_sides(views: list[View], features: Features) -> None:
    """Adds sides until every coordinate along an axis of the part is told, each bore where it is seen as a circle."""
    front = views[0].frame
    while True:
        missing = [p for p in features.places if not _reported(p, views) and is_straight(p.along)]
        if not missing:
            return
        free = [slot for slot in _WORTH if not any(view.slot == slot for view in views)]
        sides = [View(slot, adjacent(front, slot)) for slot in free]

        def worth(view: View, missing: Sequence[Place] = tuple(missing)) -> tuple[float, float, float]:
            reported = sum(_reported(place, [view]) for place in missing)
            opens = sum(float(b.axis @ view.towards) for g in features.groups for b in g.bores if view.end_on(b))
            wide = np.ptp(np.concatenate([face.box for face in features.faces]), axis=0)
            lies = float(np.abs(view.frame.right) @ wide - np.abs(view.frame.up) @ wide)
            fits = lies if view.slot in ("below", "above") else -lies
            return reported, opens, _WORTH[view.slot] * 1e3 + fits

        best = max(sides, key=worth, default=None)
        if best is None or worth(best)[0] == 0:
            raise ViewError(f"{missing[0].key} is seen from no side")
        views.append(best)


def _reported(place: Place, views: Sequence[View]) -> bool:
    """Whether a coordinate can be told in one of some views."""
    needed = place.end_on if place.end_on is not None and is_straight(place.end_on) else None
    return any(view.shows(place) and (needed is None or is_along(needed, view.towards)) for view in views)


def _add_turned(views: list[View], features: Features) -> None:
    """Adds the main view once more, turned, for each pair of slanted directions along which something is placed."""
    front = views[0].frame
    for n, along in enumerate(auxiliary_directions(features)):
        if not is_across(along, front.towards):
            raise ViewError(f"a coordinate along {np.round(along, 3)} is seen in no view")
        u, v = front(along)
        angle = (degrees(atan2(v, u)) + 45.0) % 90.0 - 45.0
        right = np.cos(np.radians(angle)) * np.array(front.right) + np.sin(np.radians(angle)) * np.array(front.up)
        sense = "clockwise" if angle > 0.0 else "anticlockwise"
        title = f"View {'BCDE'[n % 4]}, turned {round(abs(angle), 4):g}° {sense}"
        views.append(View("turned", Frame.of(right, np.cross(front.towards, right)), title))


def _cut(views: list[View], features: Features) -> None:
    """Cuts a view open where bores with steps or floors would be hidden in it."""
    front = views[0]
    if features.turned:
        bored = any(is_along(bore.axis, features.main) for g in features.groups for bore in g.bores)
        if bored or any(face.kind == "sphere" and face.hollow for face in features.faces):
            front.cut = Section.plane(front.frame, 0.0)
        return
    hidden = hidden_bores(features, front.towards)
    hollow = [face for face in features.faces if face.kind == "sphere" and face.hollow]
    inside = [bore for g in features.groups for bore in g.bores if front.end_on(bore)]
    if not hidden and not hollow and not inside:
        return
    sides = [view for view in views[1:] if view.slot != "turned"]
    plain = [v for v in sides if not any(v.end_on(b) for g in features.groups for b in g.bores)]
    if plain:
        view = plain[0]
    elif not hidden and not hollow:
        if not sides:
            return
        view = sides[0]
    else:
        free = [slot for slot in _WORTH if not any(view.slot == slot for view in sides)]
        view = View(free[0], adjacent(front.frame, free[0]))
        views.append(view)
    cut = Section.plane(view.frame, float(hollow[0].point @ view.towards)) if hollow else None
    view.cut, view.title = cut or section_of(view.frame, front.frame, features), "A-A"


def _share(views: list[View], features: Features) -> None:
    """Assigns dimensions to views: each coordinate, size and group of holes to the first view that shows it."""
    for place in features.places:
        able = [view for view in views if view.shows(place)]
        needed = place.end_on
        best = [view for view in able if needed is not None and is_along(needed, view.towards)]
        flat = [view for view in able if view.cut is None] if needed is None else []
        chosen = [*best, *flat[:1], *able]
        if not chosen:
            raise ViewError(f"{place.key} is seen from no side")
        chosen[0].places.append(place)
    for size in features.sizes:
        axis = size.faces[0].axis
        if size.kind in ("ball", "ring"):
            hollow = size.faces[0].hollow
            best = [view for view in views if hollow and view.cut is not None]
        elif features.turned or size.kind == "flat":
            best = [view for view in views if is_across(axis, view.towards) or size.kind == "flat"]
        else:
            best = [view for view in views if is_along(axis, view.towards)]
            best = [v for v in best if v.cut is None] or [v for v in best if _arc_seen(v, size)]
        aside = [view for view in views if is_across(axis, view.towards)]
        plain = [view for view in aside if view.cut is None]
        (best or plain or aside or views)[0].sizes.append(size)
    for group in features.groups:
        best = [view for view in views if view.end_on(group.bores[0])]
        aside = [v for v in views if is_across(group.bores[0].axis, v.towards)]
        along = [v for v in aside if any(is_along(group.bores[0].axis, a) for a in v.frame.axes)]
        (best or along or aside or views)[0].groups.append(group)

    required = [*(datum.faces[0] for datum in features.datums), *(zone.faces[0] for zone in features.zones)]
    for face in {id(face): face for face in required if face.kind == "plane"}.values():
        able = [view for view in views if any(is_along(face.axis, axis) for axis in view.frame.axes)]
        if not able:
            raise ViewError(f"a plane of {face.area:.1f} mm^2 that is a datum is seen as an edge in no view")
        (next((view for view in able if view.slot != "turned"), able[0])).planes.append(face)


def _arc_seen(view: View, size: Size) -> bool:
    """Whether a round face is seen as an arc in a view."""
    face = size.faces[0]
    u, v = view.frame(face.point)
    return any(
        isinstance(item, Arc)
        and item.layer == "visible"
        and max(abs(item.centre[0] - u), abs(item.centre[1] - v), abs(item.radius - face.radius)) < _SEEN_MM
        for item in view.items
    )


def _draw(view: View, solid: Any) -> None:
    if (cut := view.cut) is None:
        view.items = list(_projected(solid, view.frame))
        return

    def opened() -> tuple[list[Item], list[list[Point]]]:
        rest, rings = cut_open(solid, view.frame, cut.steps, cut.axis)
        return projected([rest.wrapped], view.frame), rings

    items, rings = cached("section", (solid_digest(solid), view.frame, cut.steps, cut.axis), opened)
    view.rings, items = list(rings), [item for item in items if isinstance(item, (Arc, Stroke))]
    for at, _ in cut.steps[:-1]:  # nothing is drawn of a step
        items = [item for item in items if not _is_level(item, cut.axis, at)]
    view.items = [item for item in items if item.layer == "visible"]
    view.behind = [item for item in items if item.layer == "hidden"]


def _projected(solid: Any, frame: Frame, hidden: bool = True) -> list[Item]:
    of = solid_digest(solid), frame, hidden
    return cached("view", of, lambda: projected([solid.wrapped], frame, hidden))


def _draw_groove(view: View, bottom: float, land: float) -> None:
    """Draws the lands of a helical groove, which is modelled as a cylinder, bold and its bottom thin, as ISO 6410 does.

    The part's axis lies along the view's right.
    """

    def is_bottom(item: Item) -> bool:
        return isinstance(item, Stroke) and all(abs(abs(v) - bottom) < _SEEN_MM for _, v in item.points)

    def is_step(item: Item) -> bool:
        heights = sorted(abs(v) for _, v in item.points) if isinstance(item, Stroke) else ()
        return len(heights) == 2 and abs(heights[0] - bottom) < _SEEN_MM and abs(heights[1] - land) < _SEEN_MM

    kept = [item for item in view.items if not (is_bottom(item) or is_step(item))]
    for item in filter(is_bottom, view.items):
        assert isinstance(item, Stroke)
        edge = tuple((u, land if v > 0.0 else -land) for u, v in item.points)
        kept += [Stroke("dimension", item.points), Stroke("visible", edge)]
    view.items = kept
    view.rings = [[(u, land * v / abs(v) if abs(abs(v) - bottom) < _SEEN_MM else v) for u, v in r] for r in view.rings]


def _reveal(view: View) -> None:
    """Adds to a view that is cut open the hidden lines that its coordinates are of, where nothing is seen at them."""
    for place in view.places:
        for k, axis in enumerate(view.frame.axes):
            level = float(place.at @ axis)
            if is_along(place.along, axis) and not any(_is_level(item, k, level) for item in view.items):
                view.items += [item for item in view.behind if _is_level(item, k, level)]


def _is_level(item: Item, k: int, level: float) -> bool:
    """Whether an item is a straight line at a coordinate along one of the axes of a view."""
    return isinstance(item, Stroke) and all(abs(point[k] - level) < _SEEN_MM for point in item.points)


def _picture(part: Part, front: View) -> View:
    """The part seen from a corner, to tell its shape at a glance."""
    right, up, towards = np.array(front.frame.right), np.array(front.frame.up), front.towards
    frame = Frame.seen_from(towards + 0.6 * right + 0.6 * up, up)
    return View("picture", frame, items=list(_projected(part.solid, frame, hidden=False)))
