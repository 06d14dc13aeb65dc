"""Positions of the table's bars in the drawn parts, for checks of the solids.

With `beam_model.py` and `strength.py` alone this knows dimensions: a redesigned part changes its function here, too.
Left out beside what the model leaves out: the boss of an arm, whose bore takes half of it and whose bar gives that
back; the cones of a cross-bar, taken by their middle; the sector, whose web the model takes as a whole ring.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import acos, asin, inf, pi, sin

import numpy as np

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.bracket import BOARD_EDGE_MM
from delta_cad.dimensions.platform import STEM_FLATS_MM, STEM_FLATS_Z_MM, WEB_CORNER_MM
from delta_cad.dimensions.rules import CORNERS_MM
from delta_cad.mechanism.placement import CHAINS
from delta_cad.structure.beam import Beam, BeamSlice
from delta_cad.structure.beam_model import CHEEK_ROOT, BeamModel, beam_model, moduli_N_mm2
from delta_cad.structure.section import Section, circle

X, Y, Z = np.eye(3)
CLOSE = (0.97, 1.03)  # a tapered bar's slices step by 1.6 %; broken edges take 0.5 %
_CHEEK = (0.85, 1.03)  # broken edges take 8 % of what bends a narrow leg, and more of a narrower
_WINDOW = (0.7, 1.15)  # the table opens a web's window by a straight line, the drawing rounds its corners
PAD = 0.7  # of a motor's pad, with the slot that a key reaches the pinion through
_EDGE_MM = 0.5  # of a shaft's end that is broken


@dataclass(frozen=True)
class Span:
    """A length of a part whose cross-sections the structure's table assumes.

    Attributes:
        part: Number of the part.
        name: What it is, for a person; spans of one name and part are meant to be alike.
        frame: (4, 4) frame in the part's, mm: origin at the bar's root, x along the bar, y and z of its sections.
        reach_mm: From where to where along x, mm.
        bar: Whose sections are assumed.
        least: Least share of area and second moments that is enough, with what a drawing takes.
        most: Largest share of the area: a part heavier than it was counted is as wrong.
        filled: Whether declared bores count as filled, because what is in them carries, or the table has taken them.
        own: A place on x and half an angle: what has its middle outside, seen from there, is another bar's; where all
            has, it is one with the others', and what lies inside is this one's.
    """

    part: str
    name: str
    frame: np.ndarray
    reach_mm: tuple[float, float]
    bar: Beam
    least: float
    most: float
    filled: bool = False
    own: tuple[float, float] | None = None

    def assumed(self, place_mm: float) -> Section:
        """Gives the section that is assumed at a place along the bar, mm from its root."""
        end = 0.0
        for piece in self.bar.slices:
            end += piece.length_mm
            if place_mm <= end:
                return piece.section
        return self.bar.slices[-1].section


def structure_spans(d: Dimensions) -> tuple[Span, ...]:
    """Lists what of a design's parts has the cross-sections that its structure is computed with."""
    table = beam_model(d)
    return (
        _arm(d, table),
        *_cheeks(d, table),
        *_shafts(d),
        Span("rod_tube", "tube", _frame(0.0 * X, X, Y), (0.0, d.forearm.tube_length_mm), table.rod, *CLOSE),
        *_bars(d, table),
        *_webs(d, table),
        *_stem(d, table),
    )


def _frame(origin: np.ndarray, along: np.ndarray, across: np.ndarray) -> np.ndarray:
    frame = np.eye(4)
    frame[:3] = np.stack([along, across, np.cross(along, across), origin], axis=1)
    return frame


def _arm(d: Dimensions, table: BeamModel) -> Span:
    """From the hub's edge to the elbow's boss."""
    a, root = d.arm, d.arm.shaft_bore_mm / 2
    reach = max(a.flange_radius_mm, a.collar_diameter_mm / 2) - root, a.length_mm - a.boss_radius_mm - root
    return Span("upper_arm", "beam", _frame(root * X, X, Y), reach, table.arm, *CLOSE)


def _cheeks(d: Dimensions, table: BeamModel) -> list[Span]:
    """A leg from its block up to what is wider, and that to the bearing; bores are seats, threads and passages."""
    if table.shoulder is None:
        return []
    b = d.bracket
    head = max(d.encoder.hole_spacing_length_mm / 2 + BOARD_EDGE_MM, b.head_radius_mm) + CORNERS_MM[0]
    pad_z, pad = b.motor_axis_mm[1], b.motor_pad_radius_mm
    cuts = {"encoder_cheek": (head,), "motor_cheek": (-pad_z + pad, -pad_z - pad)}
    found = []
    plates = d.layers.encoder_cheek_mm, d.layers.motor_cheek_mm
    for part, bar, y in zip(cuts, table.shoulder.cheeks, plates, strict=True):
        root, frame = bar.length_mm, _frame(-bar.length_mm * Z, Z, Y)
        top = CHEEK_ROOT * (y[1] - y[0])  # of the block that it is screwed to
        places = [top, *(min(max(root - cut, top), root) for cut in cuts[part]), root]
        for k, reach in enumerate(pairwise(places)):
            least, most = _CHEEK if k == 0 else (PAD, inf)
            found.append(Span(part, ("leg", "pad", "head")[k], frame, reach, bar, least, most, filled=True))
    return found


def _shafts(d: Dimensions) -> list[Span]:
    """The motor's shaft before its pilot, and a shoulder's from its head; what is in its bores is screwed or bonded."""
    m, s = d.motor, d.shaft
    reach = m.pilot_height_mm, m.shaft_length_mm
    found = [Span("motor", "shaft", _frame(0.0 * X, -Y, X), reach, _round(m.shaft_diameter_mm), *CLOSE)]
    if d.capstan is not None:
        reach = 0.0, s.y_mm[1] - s.head_to_y_mm - _EDGE_MM
        frame, bar = _frame(s.head_to_y_mm * Y, Y, X), _round(s.diameter_mm)
        found.append(Span("shoulder_shaft", "shaft", frame, reach, bar, *CLOSE, filled=True))
    return found


def _round(diameter_mm: float) -> Beam:
    """A round bar of steel, whose sections alone count here."""
    return Beam((BeamSlice(1.0, circle(diameter_mm), *moduli_N_mm2("steel")),))


def _bars(d: Dimensions, table: BeamModel) -> list[Span]:
    """Both halves of a cross-bar, from the shorter boss to its cone, and the stud to where the ball takes over."""
    f = d.forearm
    bar = max(table.elbow_bar, table.wrist_bar, key=lambda one: one.length_mm)
    neck, pin, _ = table.stud.slices
    found = []
    for side in (-1.0, 1.0):
        inner, outer = side * (f.bar_length_mm / 2 - bar.length_mm) * Y, side * f.bar_length_mm / 2 * Y
        reach = 0.0, bar.length_mm - f.cone_mm
        found.append(Span("cross_bar", "bar", _frame(inner, side * Y, X), reach, bar, *CLOSE))
        reach = 0.0, neck.length_mm + pin.length_mm
        found.append(Span("cross_bar", "stud", _frame(outer, side * Y, X), reach, table.stud, *CLOSE))
    return found


def _webs(d: Dimensions, table: BeamModel) -> list[Span]:
    """The platform's webs from the hub to the window, along it, and on to the wrist's boss.

    Beside a wide platform's hub the neighbours' webs and bosses run into a web: there it is only heavier than its own.
    """
    p, bar, g = d.platform, table.spoke, table.geometry
    root, half = p.radius_mm - bar.length_mm, p.boss_length_mm / 2
    boss = p.radius_mm - p.boss_diameter_mm / 2
    found = []
    for i in CHAINS:
        u, t = g.radial[i], g.tangential[i]
        shared, between = p.hub_radius_mm, pi
        for other in np.delete(g.radial, i, axis=0):
            cosine, sine = float(u @ other), abs(float(t @ other))
            web = WEB_CORNER_MM[1] + cosine * p.radius_mm + sine * (half - WEB_CORNER_MM[0])
            shared, between = max(shared, web, cosine * boss + sine * half), min(between, acos(cosine))
        shared = min(shared, boss)
        frame = _frame(root * u + table.spoke_up_mm * Z, u, t)
        own = -root, between / 2  # wide bosses of the neighbours reach beside a web's root
        for name, low, high, most in (
            ("web's root", p.hub_radius_mm, shared, inf),
            ("web", shared, boss, _WINDOW[1]),
        ):
            if high > low:
                reach = low - root, high - root
                found.append(Span("platform", name, frame, reach, bar, _WINDOW[0], most, own=own))
        reach = boss - root, bar.length_mm
        found.append(Span("platform", "boss", frame, reach, bar, _WINDOW[0], inf, filled=True))
    return found


def _stem(d: Dimensions, table: BeamModel) -> list[Span]:
    """The handle's stem from the platform to the knob; the table leaves out its spanner's flats."""
    p, (first, last) = d.platform, STEM_FLATS_Z_MM
    half = asin(min(STEM_FLATS_MM / p.stem_diameter_mm, 1.0))
    flats = (2 * half - sin(4 * half) / 2) / pi  # share of a circle's second moment that the flats leave across them
    frame, low = _frame(0.0 * X, Z, Y), CLOSE[0] * flats
    spans = {
        "foot": ((0.0, first), CLOSE[0]),
        "flats": ((first, last), low),
        "stem": ((last, p.stem_length_mm), CLOSE[0]),
    }
    return [Span("handle_stem", name, frame, at, table.stem, least, CLOSE[1]) for name, (at, least) in spans.items()]
