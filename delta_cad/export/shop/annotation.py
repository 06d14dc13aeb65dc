"""Annotations of a part that viewers of its AP242 file show: each a text on a leader, as lines in space.

An annotation stands on its face as a flag: the leader goes from an edge of the face along its normal, or a bore's axis,
until it is clear of the part, and ends in the text, which is never upside down. No two of one direction stand equally
high, so that none hides another where they are looked at from the side.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from io import BytesIO
from typing import Any, NamedTuple

import cadquery as cq
import numpy as np

from delta_cad.assembly.faces import solid_face
from delta_cad.common.vectors import cross
from delta_cad.export.drawings.sheet_io.lettering import NARROW, Run, carried, coded_program, em_mm, runs

_LETTER_SHARE, _LETTER_MM = 0.025, (1.2, 4.0)  # height of letters as a share of the part's diagonal, and its bounds
_RISE, _ABOVE, _GAP = 1.8, 1.5, 0.5  # from text to text, from the part to the first, from leader to text, in letters
_STEPS = 3  # straight pieces in place of a curve of a letter
_DECIMALS = 4
_MIDDLE_MM = 1e-3
_SIDE = 0.5  # cosine to x from which on a leader points aside

Line = list[tuple[float, float]]


class Flag(NamedTuple):
    """An annotation in space.

    Attributes:
        shape: The kernel's compound of one edge a line.
        at_mm: (3,) where the text begins.
        normal: (3,) out of the text's plane, to who reads it.
        right: (3,) along the text.
    """

    shape: Any
    at_mm: np.ndarray
    normal: np.ndarray
    right: np.ndarray


class Flags:
    """The annotations of one part, one after the other."""

    def __init__(self, solid: cq.Solid) -> None:
        box = solid.BoundingBox(1e-4)
        self._low, self._high = np.array([box.xmin, box.ymin, box.zmin]), np.array([box.xmax, box.ymax, box.zmax])
        least, most = _LETTER_MM
        self._letter = min(max(_LETTER_SHARE * box.DiagonalLength, least), most)
        self._count: Counter[tuple[float, ...]] = Counter()

    def flag(self, text: str, face: cq.Face) -> Flag:
        """Sets a text up over a face."""
        up = self._up(face)
        corners = [np.array(vertex.toTuple()) for vertex in face.Vertices()] or [np.array(face.Center().toTuple())]
        foot = max(corners, key=lambda corner: (round(float(corner @ up), 3), *np.round(corner, 3).tolist()))
        key = tuple(np.round(up, 3).tolist())
        level = float(np.maximum(self._low * up, self._high * up).sum())
        level += self._letter * (_ABOVE + _RISE * self._count[key])
        self._count[key] += 1
        right, upright = _reading(up)
        head = foot + (level - float(foot @ up)) * up
        begin = head + _GAP * self._letter * right
        lines = [[foot, head, begin]]
        lines += [[begin + x * right + y * upright for x, y in line] for line in outlines(text, self._letter)]
        return Flag(_compound(lines), begin, cross(right, upright), right)

    def _up(self, face: cq.Face) -> np.ndarray:
        """The way out of a face: a plane's normal, an axis to the nearer side, or away from the part's middle."""
        read, middle = solid_face(face), (self._low + self._high) / 2.0
        away = read.centre - middle
        if read.kind == "plane":
            return read.direction
        if read.kind in ("cylinder", "cone"):
            nearer = float(read.direction @ away)
            if abs(nearer) < _MIDDLE_MM:  # through its middle: towards the positive end
                nearer = float(read.direction[np.abs(read.direction).argmax()])
            return read.direction if nearer > 0.0 else -read.direction
        length = float(np.linalg.norm(away))
        return away / length if length > _MIDDLE_MM else np.array([0.0, 0.0, 1.0])


def _reading(up: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(3,) along a text and (3,) up its letters on a leader along a direction, whichever of both ways that points.

    Texts over and under a part stand upright, seen from the front (-y); those before and behind it, seen from above;
    those at its sides are read from the right, seen from above.
    """
    side = abs(up[0]) > _SIDE
    right = np.eye(3)[1 if side else 0]
    right = right - (right @ up) * up
    right /= np.linalg.norm(right)
    upright = up if (up[0] < 0.0 if side else up[np.abs(up).argmax()] > 0.0) else -up
    return right, upright


def outlines(text: str, height_mm: float) -> list[Line]:
    """Gives the closed outlines of letters in the lettering of drawings, from the left end of the base line, mm."""
    found, at, em = list[Line](), 0.0, em_mm(height_mm)
    for run in runs(text):
        glyphs, advances = _glyphs(run)
        for letter in run.text:
            found += [[(at + NARROW * em * x, em * y) for x, y in line] for line in glyphs[letter]]
            at += NARROW * em * advances[letter]
    return found


@lru_cache(maxsize=256)
def _glyphs(run: Run) -> tuple[dict[str, list[Line]], dict[str, float]]:
    """Outlines and advance of each letter of a run, in ems."""
    from fontTools.ttLib import TTFont

    letters = "".join(sorted(set(run.text)))
    read: Any = TTFont(BytesIO(coded_program() if run.coded else carried(run.face, letters).program))
    glyphs, known, em = read.getGlyphSet(), read.getBestCmap(), float(read["head"].unitsPerEm)
    lines, advances = {}, {}
    for letter in letters:
        name = known[ord(letter)]
        lines[letter], advances[letter] = _flattened(glyphs, name, em), read["hmtx"].metrics[name][0] / em
    return lines, advances


def _flattened(glyphs: Any, name: str, em: float) -> list[Line]:
    from fontTools.pens.basePen import decomposeQuadraticSegment
    from fontTools.pens.recordingPen import DecomposingRecordingPen

    pen = DecomposingRecordingPen(glyphs)
    glyphs[name].draw(pen)
    found = list[Line]()
    for kind, points in pen.value:
        if kind == "moveTo":
            found.append([points[0]])
        elif kind == "lineTo":
            found[-1].append(points[0])
        elif kind == "qCurveTo":
            for (bx, by), (cx, cy) in decomposeQuadraticSegment(points):
                ax, ay = found[-1][-1]
                for share in (k / _STEPS for k in range(1, _STEPS + 1)):
                    a, b, c = (1.0 - share) ** 2, 2.0 * share * (1.0 - share), share**2
                    found[-1].append((a * ax + b * bx + c * cx, a * ay + b * by + c * cy))
        elif kind == "closePath":
            found[-1].append(found[-1][0])
    return [[(x / em, y / em) for x, y in line] for line in found]


def _compound(lines: Sequence[Sequence[np.ndarray]]) -> Any:
    """Lines as the kernel's writer takes them for one polyline each: curves of degree 1, without doubled points."""
    from OCP.BRep import BRep_Builder
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.Geom import Geom_BSplineCurve
    from OCP.gp import gp_Pnt
    from OCP.TColgp import TColgp_Array1OfPnt
    from OCP.TColStd import TColStd_Array1OfInteger, TColStd_Array1OfReal
    from OCP.TopoDS import TopoDS_Compound

    builder, whole = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(whole)
    for line in lines:
        rounded = np.round(np.array(line), _DECIMALS) + 0.0
        kept = rounded[np.r_[True, np.any(rounded[1:] != rounded[:-1], axis=1)]]
        count = len(kept)
        if count < 2:
            continue
        poles, knots, times = (
            TColgp_Array1OfPnt(1, count), TColStd_Array1OfReal(1, count), TColStd_Array1OfInteger(1, count)
        )  # fmt: skip
        for k, point in enumerate(kept.tolist(), start=1):
            poles.SetValue(k, gp_Pnt(*point))
            knots.SetValue(k, float(k))
            times.SetValue(k, 2 if k in (1, count) else 1)
        builder.Add(whole, BRepBuilderAPI_MakeEdge(Geom_BSplineCurve(poles, knots, times, 1, False)).Edge())
    return whole
