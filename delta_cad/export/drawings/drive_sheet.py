"""A sheet of the assembly drawing: the drive of one chain, cut open in the plane of its axes, fits and gaps called out.

What is called out is read off what decides it: contacts and running gaps of the assembly, fits of the parts, the
chains of tolerances, the spring's preload. Gaps are measured in the section.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances import preload_range_N
from delta_cad.dimensions.tolerances.chain import Chain
from delta_cad.dimensions.tolerances.machine import general_class, machine_chains
from delta_cad.export.drawings.layout import ratio
from delta_cad.export.drawings.part.controlled import controlled
from delta_cad.export.drawings.sheet_io.lettering import LINE, width_of, wrapped
from delta_cad.export.drawings.sheet_io.sheet import Area, Box, Item, Point, Stroke, Text, box_of, moved
from delta_cad.export.drawings.title import TITLE_MM, inner
from delta_cad.export.drawings.views.marks import LETTER_MM, spread_within
from delta_cad.export.drawings.views.projection import HATCH_MM, Frame, cut_open, hatched
from delta_cad.solids.part import Occurrence, location_of

_SIZE = "A3"
_SCALES = (5.0, 2.0, 1.0, 0.5)
_CHAIN = re.compile(r"[A-Za-z_]+_0(_.*)?")
_WHOLE = re.compile(r"motor|(shoulder_s|dowel_|screw_|set_screw|capstan_cable).*")
"""Numbers of what a section leaves whole, ISO 128-50, or shows too small to hatch."""
_LEFT_OUT = re.compile(r"foot|(rod_|cup_shell|joint_ball|cross_bar|lead_|motor_lead|sensor_lead).*")
_WIDE_MM, _AWAY_MM = 60.0, 8.0  # a column of callouts, and from it to the view
_PITCH_MM = LETTER_MM * LINE
_SAMPLE_MM = 0.1  # of an outline where gaps are measured
_BORE_MM = 0.2  # from a bore's wall to what is in it, at most
_NARROW_MM = 2.0  # widest gap in the section that is called out there
_DOT_MM = 0.7
_COLUMNS = (62.0, 22.0, 32.0, 30.0)


@dataclass(frozen=True)
class _Cut:
    """One part in the section: its outlines, mm, and points along them, (n, 2)."""

    one: Occurrence
    pose: np.ndarray
    rings: list[list[Point]]
    points: np.ndarray


@dataclass(frozen=True)
class _Callout:
    """What is said of a point of the section, mm of the machine."""

    at: Point
    text: str


def drive_page(d: Dimensions, assembly: Assembly) -> tuple[str, list[Item], dict[str, Box]]:
    """Sets the sheet out: its scale, items and frames."""
    frame, depth = _plane(assembly)
    cuts = list(_cut(assembly, frame, depth))
    callouts = [*_fits(d, assembly, cuts, frame, depth), *_gaps(assembly, cuts), *_preload(d, cuts)]
    x0, y0, x1, y1 = box_of([Stroke("visible", tuple(ring)) for cut in cuts for ring in cut.rings])
    area = inner(_SIZE)
    room = area[2] - area[0] - 2 * (_WIDE_MM + _AWAY_MM) - 12.0, area[3] - area[1] - TITLE_MM[1] - 24.0
    scale = next((s for s in _SCALES if s * (x1 - x0) <= room[0] and s * (y1 - y0) <= room[1]), _SCALES[-1])
    items = [item for n, cut in enumerate(cuts) for item in _drawn(cut, scale, n)]
    drawn = (x0 * scale, y0 * scale, x1 * scale, y1 * scale)
    items += _called(callouts, scale, drawn)
    box = box_of(items)
    by = area[0] + 8.0 - box[0], area[3] - 16.0 - box[3]
    items = [moved(item, by) for item in items]
    items.append(Text((area[0] + 8.0, area[3] - 8.0), 3.5, "drive of one chain, cut open through its axes"))
    table = _chain_table(d)
    table = [moved(item, (area[0] + 8.0, area[1] + 3.0 - box_of(table)[1])) for item in table]
    return ratio(scale), [*items, *table], {"section": box_of(items), "tolerance chains": box_of(table)}


def _plane(assembly: Assembly) -> tuple[Frame, float]:
    """The plane of shoulder and pinion of chain 0, or the upright one through a shoulder without a pinion."""
    poses = assembly.poses(assembly.home_mm)
    joint = next(joint for joint in assembly.joints if joint.name == "shoulder_0")
    shoulder = assembly.placement(assembly.home_mm)[joint.link_a] @ joint.frame_a
    axis, at = shoulder[:3, 1], shoulder[:3, 3]
    up = np.array([0.0, 0.0, 1.0])
    if "pinion_0" in poses:
        up = at - poses["pinion_0"][:3, 3]
    up = up - (up @ axis) * axis
    frame = Frame.of(axis, up / np.linalg.norm(up))
    return frame, float(at @ frame.towards)


def _cut(assembly: Assembly, frame: Frame, depth: float) -> Iterable[_Cut]:
    """The parts of chain 0's drive that the plane goes through."""
    import cadquery as cq

    poses = assembly.poses(assembly.home_mm)
    for one in assembly.occurrences:
        if not _CHAIN.fullmatch(one.name) or _LEFT_OUT.fullmatch(one.part.number):
            continue
        solid = one.part.solid.moved(cq.Location(location_of(poses[one.name])))
        _, rings = cut_open(solid, frame, [(inf, depth)])
        rings = [ring for ring in rings if len(ring) > 2]
        if rings:
            yield _Cut(one, poses[one.name], rings, np.concatenate([_sampled(ring) for ring in rings]))


def _sampled(ring: Sequence[Point]) -> np.ndarray:
    """(n, 2) points along a closed outline."""
    found = []
    for start, end in pairwise([*ring, ring[0]]):
        a, b = np.array(start), np.array(end)
        count = int(np.linalg.norm(b - a) / _SAMPLE_MM) + 1
        found.append(a + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (b - a))
    return np.concatenate(found)


def _drawn(cut: _Cut, scale: float, n: int) -> list[Item]:
    """A part's outlines, hatched one way or the other, wider or closer, than the parts before."""
    rings = [[(x * scale, y * scale) for x, y in ring] for ring in cut.rings]
    items: list[Item] = [Stroke("visible", tuple(ring), closed=True) for ring in rings]
    if _WHOLE.fullmatch(cut.one.part.number):
        return items
    sense = 1.0 if n % 2 else -1.0
    strokes = hatched([[(sense * x, y) for x, y in ring] for ring in rings], HATCH_MM * (1.0 + 0.3 * (n % 3)))
    return [*items, *(Stroke(one.layer, tuple((sense * x, y) for x, y in one.points)) for one in strokes)]


def _nearest(a: _Cut, b: _Cut) -> tuple[float, Point]:
    """The least distance of two parts in the section, mm, and the middle between them there."""
    from scipy.spatial import KDTree

    apart, index = map(np.asarray, KDTree(b.points).query(a.points))
    k = int(np.argmin(np.round(apart, 6)))
    middle = (a.points[k] + b.points[index[k]]) / 2.0
    return float(apart[k]), (float(middle[0]), float(middle[1]))


def _fits(d: Dimensions, assembly: Assembly, cuts: Sequence[_Cut], frame: Frame, depth: float) -> Iterable[_Callout]:
    """The fit of each pair of which one is in a bore of the other: classes of bore and of what is in it."""
    held, known = controlled(d), {cut.one.name: cut for cut in cuts}
    for contact in assembly.contacts:
        if contact.kind != "cylinder" or contact.a not in known or contact.b not in known:
            continue
        inside, outside = known[contact.a], known[contact.b]
        rounds = held[inside.one.part.number].rounds if inside.one.part.number in held else ()
        for size, bore_fit, at in _walls(outside, inside, frame, depth):
            shaft = next((f"/{one.fit}" for one in rounds if one.fit and one.is_of(size)), "")
            yield _Callout(at, f"Ø{size:g} {bore_fit}{shaft}: {contact.reason}")
            break
        else:
            fitted = next((one for one in rounds if one.fit), None)
            if fitted is not None and outside.one.part.number.startswith("bearing"):
                yield _Callout(_nearest(inside, outside)[1], f"Ø{fitted.diameter_mm:g} {fitted.fit}: {contact.reason}")


def _walls(outside: _Cut, inside: _Cut, frame: Frame, depth: float) -> Iterable[tuple[float, str, Point]]:
    """Bores with a fit whose axis lies in the plane, at whose wall another part is: diameter, class, a point there."""
    turn, shift = outside.pose[:3, :3], outside.pose[:3, 3]
    for bore in (bore for hole in outside.one.part.holes for bore in hole.bores if bore.fit):
        start, along = turn @ np.array(bore.start_mm) + shift, turn @ np.array(bore.direction)
        if abs(float(start @ frame.towards) - depth) > _BORE_MM or abs(float(along @ frame.towards)) > 1e-6:
            continue
        aside = np.cross(frame.towards, along)
        for share, sense in ((share, sense) for share in (0.5, 0.25, 0.75) for sense in (1.0, -1.0)):
            at = np.array(frame(start + share * bore.depth_mm * along + sense * bore.diameter_mm / 2.0 * aside))
            if float(np.linalg.norm(inside.points - at, axis=1).min()) < _BORE_MM:
                yield bore.diameter_mm, bore.fit, (float(at[0]), float(at[1]))
                break


def _gaps(assembly: Assembly, cuts: Sequence[_Cut]) -> Iterable[_Callout]:
    """Running gaps between parts of the section, as wide as they are there, once for each pair of kinds."""
    known, seen = {cut.one.name: cut for cut in cuts}, set[frozenset[str]]()
    for fit in assembly.fits:
        if fit.kind != "running gap" or fit.a not in known or fit.b not in known:
            continue
        a, b = known[fit.a], known[fit.b]
        pair = frozenset((a.one.part.number, b.one.part.number))
        wide, at = _nearest(a, b)
        if pair in seen or wide > _NARROW_MM:
            continue
        seen.add(pair)
        most = "" if fit.gap_max_mm is None else f", at most {fit.gap_max_mm:g}"
        names = " and ".join(sorted(number.replace("_", " ") for number in pair))
        yield _Callout(at, f"gap {wide:.2g}, at least {fit.gap_mm:g}{most}: {names}")


def _preload(d: Dimensions, cuts: Sequence[_Cut]) -> Iterable[_Callout]:
    """What the wave spring presses with."""
    spring = next((cut for cut in cuts if cut.one.part.number == "wave_spring"), None)
    if spring is None or d.preload is None:
        return
    low, high = preload_range_N(d.preload)
    x, y = spring.points[int(np.argmin(spring.points[:, 1]))]
    text = f"preload of the bearings {d.preload.force_N:g} N, {low:.1f} to {high:.1f} over all tolerances: wave spring "
    yield _Callout((float(x), float(y)), f"{text}{d.preload.work_height_mm:g} high")


def _called(callouts: Sequence[_Callout], scale: float, drawn: Box) -> list[Item]:
    """Sets callouts in a column on either side of a view, each about level with its point; leaders do not cross.

    Leaders that are as short as can be, all together, do not cross: two that did could change their ends.
    """
    from scipy.optimize import linear_sum_assignment  # loads for a while

    items: list[Item] = []
    ordered = sorted(callouts, key=lambda one: one.at)
    half = (len(ordered) + 1) // 2
    for side, group in ((-1.0, ordered[:half]), (1.0, ordered[half:])):
        texts = [wrapped(one.text, LETTER_MM, _WIDE_MM) for one in group]
        pitch = _PITCH_MM * (max(map(len, texts), default=1) + 0.5)
        points = [(one.at[0] * scale, one.at[1] * scale) for one in group]
        levels = spread_within(sorted(y for _, y in points), pitch, drawn[1], drawn[3])
        x = drawn[0] - _AWAY_MM if side < 0.0 else drawn[2] + _AWAY_MM
        away = [[float(np.hypot(x - p[0], y - p[1])) for y in levels] for p in points]
        for one, place in zip(*linear_sum_assignment(np.reshape(away, (len(group), len(levels)))), strict=True):
            lines, y, at = texts[one], levels[place], points[one]
            items += [Stroke("dimension", ((x, y), at)), _dot(at)]
            top = y + _PITCH_MM * len(lines) / 2
            for n, line in enumerate(lines):
                left = x + 1.0 if side > 0.0 else x - 1.0 - width_of(line, LETTER_MM)
                items.append(Text((left, top - _PITCH_MM * (n + 1) + 0.8), LETTER_MM, line))
    return items


def _dot(at: Point) -> Area:
    x, y = at
    return Area("dimension", ((x - _DOT_MM, y), (x, y + _DOT_MM), (x + _DOT_MM, y), (x, y - _DOT_MM)))


def _chain_table(d: Dimensions) -> list[Item]:
    """The chains of tolerances of the machine from (0, 0) down: each figure, what it comes to and what it may be."""
    rows = [("What must come out", "as drawn", "comes to", "may be")]
    rows += [_row(chain) for chain in machine_chains(d, general_class(d))]
    edges = np.cumsum([0.0, *_COLUMNS]).tolist()
    items: list[Item] = [
        Text((edges[k] + 1.0, -_PITCH_MM * (n + 1) + 1.1), LETTER_MM, cell)
        for n, row in enumerate(rows)
        for k, cell in enumerate(row)
    ]
    low = -_PITCH_MM * len(rows)
    items += [Stroke("table", ((0.0, -_PITCH_MM * n), (edges[-1], -_PITCH_MM * n))) for n in range(len(rows) + 1)]
    return [*items, *(Stroke("table", ((edge, 0.0), (edge, low))) for edge in edges)]


def _row(chain: Chain) -> tuple[str, str, str, str]:
    low, high = chain.decides
    bounds = f"{chain.low:.3g} to {chain.high:.3g}" if chain.high < inf else f"at least {chain.low:.3g}"
    return f"{chain.name}, {chain.unit}", f"{chain.nominal:.3g}", f"{low:.3g} to {high:.3g}", bounds
