"""Where a view is cut open: through the axes of the bores that are hidden in it, in steps where one plane misses some.

A step lies where nothing is bored, and nothing is drawn of it, ISO 128-50.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf

import numpy as np

from delta_cad.export.drawings.part.faces import is_along
from delta_cad.export.drawings.part.holes import Bore
from delta_cad.export.drawings.part.record import SAME_MM, Features
from delta_cad.export.drawings.views.projection import Frame

_WALL_MM = 0.5  # from a step to a bore, at least
_SHARES = 0.5, 0.3, 0.7, 0.15, 0.85  # of the way between two bores where a step may be


@dataclass(frozen=True)
class Section:
    """Planes across the direction to the viewer, side by side.

    Attributes:
        frame: The view that is cut open.
        axis: Along which axis of the view the planes follow one another, 0 or 1.
        steps: Up to where along it each goes, mm, and its depth, the coordinate towards the viewer, mm.
    """

    frame: Frame
    axis: int
    steps: tuple[tuple[float, float], ...]

    @classmethod
    def plane(cls, frame: Frame, depth: float) -> Section:
        """Gives the section in one plane."""
        return cls(frame, 1, ((inf, depth),))

    def depth_at(self, point: np.ndarray) -> float:
        """Gives the depth of the plane at a (3,) point, mm."""
        along = float(self.frame.axes[self.axis] @ point)
        return next(depth for end, depth in self.steps if along <= end)

    def holds(self, point: np.ndarray) -> bool:
        """Decides whether a (3,) point is in its planes."""
        return abs(float(point @ self.frame.towards) - self.depth_at(point)) < SAME_MM

    def meets(self, bore: Bore) -> bool:
        """Decides whether a bore is cut along its axis."""
        return abs(float(bore.axis @ self.frame.towards)) < SAME_MM and self.holds(bore.point)

    def clips(self, bore: Bore) -> bool:
        """Decides whether a bore is cut beside its axis: it would be seen narrower than it is."""
        along, depth = _spot(bore, self)
        low = -inf
        for end, level in self.steps:
            is_off = SAME_MM < abs(depth - level) < bore.widest / 2
            if is_off and along + bore.widest / 2 > low and along - bore.widest / 2 < end:
                return True
            low = end
        return False


def hidden_bores(features: Features, along: np.ndarray) -> list[Bore]:
    """Gives the bores along a direction whose steps or floors are not seen from there."""
    bores = (bore for group in features.groups for bore in group.bores)
    return [bore for bore in bores if is_along(bore.axis, along) and (len(bore.diameters) > 1 or not bore.through)]


def section_of(frame: Frame, front: Frame, features: Features) -> Section:
    """Chooses where a view beside the main one is cut open: through as many kinds of hidden bores as there is room."""
    axis = next(k for k in (0, 1) if any(is_along(frame.axes[k], other) for other in front.axes))
    inside = [b for group in features.groups for b in group.bores if is_along(b.axis, front.towards)]
    hidden = hidden_bores(features, front.towards)

    def worth(bore: Bore) -> tuple[int, int, int, float]:
        alone = Section(frame, axis, ((inf, float(bore.point @ frame.towards)),))
        met = sum(alone.meets(other) for other in inside)
        return len(bore.diameters), -sum(alone.clips(other) for other in inside), met, bore.widest

    chosen = [max(hidden or inside, key=worth)]
    section = _through(frame, axis, chosen, inside)
    assert section is not None
    datums = {id(face) for datum in features.datums for face in datum.faces}
    bored = {id(bore) for bore in hidden}
    bored |= {id(bore) for bore in inside if any(id(face) in datums for face in bore.faces)}
    kinds = [group.bores for group in features.groups if any(id(bore) in bored for bore in group.bores)]
    for bores in sorted(kinds, key=lambda some: (-len(some[0].diameters), -some[0].widest)):
        if any(section.meets(bore) for bore in bores):
            continue
        for bore in (bore for bore in bores if is_along(bore.axis, front.towards)):
            tried = _through(frame, axis, [*chosen, bore], inside)
            if tried is None or sum(map(tried.clips, inside)) > sum(map(section.clips, inside)):
                continue
            if _met(section, features) <= _met(tried, features):
                section, chosen = tried, [*chosen, bore]
                break
    return section


def _met(section: Section, features: Features) -> set[int]:
    """Numbers of the groups of bores of which a section meets one."""
    return {g for g, group in enumerate(features.groups) if any(map(section.meets, group.bores))}


def _spot(bore: Bore, section: Section) -> tuple[float, float]:
    """Where a bore is along the planes, and how deep."""
    return float(bore.point @ section.frame.axes[section.axis]), float(bore.point @ section.frame.towards)


def _through(frame: Frame, axis: int, bores: Sequence[Bore], inside: Sequence[Bore]) -> Section | None:
    """The section through some bores; None where a step between two has no room."""
    flat = Section(frame, axis, ())
    spots = sorted((*_spot(bore, flat), bore.widest / 2) for bore in bores)
    steps: list[tuple[float, float]] = []
    for (start, depth, radius), (end, other, wide) in pairwise(spots):
        if abs(depth - other) < SAME_MM:
            continue
        low, high = start + radius + _WALL_MM, end - wide - _WALL_MM
        places = (low + share * (high - low) for share in _SHARES) if high > low else ()
        free = (at for at in places if not any(_is_hit(at, depth, other, _spot(b, flat), b.widest / 2) for b in inside))
        at = next(free, None)
        if at is None:
            return None
        steps.append((at, depth))
    return Section(frame, axis, (*steps, (inf, spots[-1][1])))


def _is_hit(at: float, depth: float, other: float, spot: tuple[float, float], radius: float) -> bool:
    """Whether a step goes through a bore."""
    low, high = sorted((depth, other))
    return abs(spot[0] - at) < radius and low - radius < spot[1] < high + radius
