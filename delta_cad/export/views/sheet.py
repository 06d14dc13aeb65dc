"""Drawing sheet of a parallel view: camera, dimension lines, captions; coordinates in mm on the sheet."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from delta_cad.export.views.scene import SUPERSAMPLING, Colour, aim, flat_actor, flat_shapes

_INK: Colour = (0.16, 0.19, 0.24)
_TITLE_PIXELS, _TEXT_PIXELS = 26, 18
_ARROW_PIXELS = 11.0
_ARROW_SLOPE = 0.16
_GAP_PIXELS = 5.0
DIMENSION_PIXELS = 34.0  # Distance of a dimension line from what it measures, and of the next one from it.
_BAND_PIXELS = 92.0  # Height of the strip at the bottom that is kept for the title.
_MARGIN = 1.05
_BOX_WIDTH = 1.6  # Line width of cube and outline, pixels of the finished picture.
_BALLOON_PIXELS, _BALLOON_PITCH, BALLOON_ROOM = (
    15.0,
    36.0,
    78.0,
)  # radius; from one to the next; what they take at a side
_DOT_PIXELS = 3.5  # where a balloon's line ends, as drawing standards have it on a surface
_CHAIN_PIXELS = (22.0, 5.0, 4.0)  # Long dash, gap, short dash of a centre line.


class Sheet:
    """A view of a renderer along one direction, with an overlay for dimensions and captions.

    Attributes:
        scene: The renderer.
        towards: (3,) unit vector from the machine to the viewer.
        right: (3,) unit vector to the right on the sheet.
        up: (3,) unit vector upwards on the sheet.
        mm_per_pixel: Scale of the finished picture.
        overlay: Renderer of the annotations.
    """

    def __init__(
        self, renderer: Any, towards: np.ndarray, size: tuple[int, int], box: np.ndarray, *, room: float = 0.0
    ) -> None:
        """Sets up the camera so that a box fills the sheet.

        Args:
            renderer: The scene.
            towards: (3,) direction from the machine to the viewer.
            size: Pixels of the finished picture.
            box: (n, 3) points that must be visible, mm.
            room: Pixels to keep free around them for dimension lines.
        """
        self.towards = np.asarray(towards, dtype=float) / np.linalg.norm(towards)
        pole = np.array([0.0, 0.0, 1.0]) if abs(self.towards[2]) < 0.99 else np.array([0.0, 1.0, 0.0])
        self.right = np.cross(pole, self.towards)
        self.right /= np.linalg.norm(self.right)
        self.up = np.cross(self.towards, self.right)
        flat = self.flat(box)
        low, high = flat.min(axis=0), flat.max(axis=0)
        free = np.array([size[0] - 2 * room, size[1] - 2 * room - _BAND_PIXELS])
        self._ends, self.scene = (low, high), renderer
        self.mm_per_pixel = float((_MARGIN * (high - low) / free).max())
        centre = (low + high) / 2 - [0.0, _BAND_PIXELS / 2 * self.mm_per_pixel]
        self.overlay = aim(renderer, self.solid(centre), self.towards, self.up, size[1] * self.mm_per_pixel)
        self._segments: list[np.ndarray] = []
        self._arrows: list[np.ndarray] = []

    def flat(self, points: np.ndarray) -> np.ndarray:
        """(..., 3) points in mm to (..., 2) on the sheet, mm."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)

    def solid(self, flat: np.ndarray) -> np.ndarray:
        """(..., 2) sheet points to (..., 3) points in the plane through the origin."""
        return flat[..., :1] * self.right + flat[..., 1:] * self.up

    def dimension(
        self, a: tuple[float, float], b: tuple[float, float], text: str, *, rows: float, upright: bool
    ) -> None:
        """Dimension line between two sheet points, measured along one axis of the sheet.

        Args:
            a: Where the first extension line starts, mm on the sheet.
            b: Where the second one starts.
            text: What it says.
            rows: How far out it sits, in steps of `DIMENSION_PIXELS`; positive is above or to the right.
            upright: True measures along the sheet's height, False along its width.
        """
        pixel = self.mm_per_pixel
        along, across = (1, 0) if upright else (0, 1)
        base = (max if rows > 0 else min)(a[across], b[across])
        level = base + rows * DIMENSION_PIXELS * pixel
        sense = np.sign(rows)
        ends = []
        for point in (a, b):
            end = np.zeros(2)
            end[along], end[across] = point[along], level
            start = np.array(point, dtype=float)
            start[across] += sense * _GAP_PIXELS * pixel
            over = end.copy()
            over[across] += sense * _GAP_PIXELS * pixel
            self._segments.append(np.array([start, over]))
            ends.append(end)
        self._segments.append(np.array(ends))
        run = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        side = np.array([-run[1], run[0]])
        length = _ARROW_PIXELS * pixel
        for tip, way in ((ends[0], run), (ends[1], -run)):
            back = tip + length * way
            self._arrows.append(
                np.array([tip, back + _ARROW_SLOPE * length * side, back - _ARROW_SLOPE * length * side])
            )
        middle = (ends[0] + ends[1]) / 2
        middle[across] += 4.0 * pixel if not upright else -4.0 * pixel
        self.label(middle, text, turned=upright)

    def balloons(self, points: Mapping[int, np.ndarray]) -> None:
        """Numbers in circles on both sides of what is shown, each with a line that ends in a dot on its point.

        Args:
            points: Number -> (3,) point, mm.
        """
        from delta_cad.export.drawings.views.marks import spread

        pixel, (low, high) = self.mm_per_pixel, self._ends
        radius, off = _BALLOON_PIXELS * pixel, (BALLOON_ROOM - _BALLOON_PIXELS - _GAP_PIXELS) * pixel
        flat = {number: self.flat(point) for number, point in points.items()}
        order = sorted(flat, key=lambda number: flat[number][0])
        turn = np.linspace(0.0, 2.0 * np.pi, 33)
        around = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        left, right = order[: len(order) // 2], order[len(order) // 2 :]
        for side, x, sense in ((left, low[0] - off, 1.0), (right, high[0] + off, -1.0)):
            column = sorted(side, key=lambda number: flat[number][1])
            heights = spread([flat[number][1] for number in column], [_BALLOON_PITCH * pixel] * len(column))
            for number, y in zip(column, heights, strict=True):
                circle = around + np.array([x, y])
                self._segments += [circle[k : k + 2] for k in range(len(circle) - 1)]
                self._segments.append(np.array([(x + sense * radius, y), flat[number]]))
                rim = flat[number] + _DOT_PIXELS * pixel / radius * around
                self._arrows += [np.array([flat[number], *rim[k : k + 2]]) for k in range(len(rim) - 1)]
                self.label(np.array([x, y - 0.62 * radius]), str(number))

    def centre_line(self, left: float, right: float, height: float) -> None:
        """Level chain line (long dash, short dash) between two abscissas, mm on the sheet."""
        pixel = self.mm_per_pixel
        long, gap, short = (length * pixel for length in _CHAIN_PIXELS)
        start = left
        while start < right:
            for length in (long, short):
                end = min(start + length, right)
                if end > start:
                    self._segments.append(np.array([[start, height], [end, height]]))
                start = end + gap

    def label(self, at: np.ndarray, text: str, *, turned: bool = False, colour: Colour = _INK) -> None:
        """Text above a sheet point; turned texts read from the right."""
        actor = _text(text, _TEXT_PIXELS, colour)
        place = actor.GetPositionCoordinate()
        place.SetCoordinateSystemToWorld()
        place.SetValue(*self.solid(np.asarray(at, dtype=float)))
        actor.GetTextProperty().SetJustificationToCentered()
        actor.GetTextProperty().SetVerticalJustificationToBottom()
        if turned:
            actor.GetTextProperty().SetOrientation(90.0)
        self.overlay.AddViewProp(actor)

    def caption(self, title: str, subtitle: str) -> None:
        """Title and subtitle in the strip at the bottom."""
        for text, pixels, bold, height in ((title, _TITLE_PIXELS, True, 46), (subtitle, _TEXT_PIXELS, False, 20)):
            actor = _text(text, pixels, _INK)
            actor.GetTextProperty().SetBold(bold)
            actor.SetPosition(28 * SUPERSAMPLING, height * SUPERSAMPLING)
            self.overlay.AddViewProp(actor)

    def finish(self) -> Any:
        """Draws what was collected; returns the overlay."""
        for shapes in (self._segments, self._arrows):
            if shapes:
                self.overlay.AddActor(flat_shapes(list(self.solid(np.array(shapes))), _INK))
        return self.overlay


def box_actor(low: np.ndarray, high: np.ndarray, colour: Colour) -> Any:
    """Edges of an upright box in space, hidden by what is before them; of a rectangle, if the box is flat.

    Args:
        low: (3,) lowest corner, mm.
        high: (3,) highest corner, mm.
        colour: sRGB.
    """
    from vtkmodules.vtkFiltersSources import vtkOutlineSource

    box = vtkOutlineSource()
    box.SetBounds(low[0], high[0], low[1], high[1], low[2], high[2])
    return flat_actor(box, colour, _BOX_WIDTH)


def _text(text: str, pixels: int, colour: Colour) -> Any:
    from vtkmodules.vtkRenderingCore import vtkTextActor

    actor = vtkTextActor()
    actor.SetInput(text)
    style = actor.GetTextProperty()
    style.SetFontFamilyToArial()
    style.SetFontSize(pixels * SUPERSAMPLING)
    style.SetColor(*colour)
    return actor
