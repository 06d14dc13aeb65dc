"""Pictures of the machine: isometric, front, top, side, one drive whole and exploded, lowest and highest position."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.export.bom import items_of
from delta_cad.export.views.explode import chain_of, exploded_chain
from delta_cad.export.views.scene import Colour, PartScene, Placed, joined, photograph, placed, render_window
from delta_cad.export.views.sheet import BALLOON_ROOM, DIMENSION_PIXELS, Sheet, box_actor
from delta_cad.solids.part import Occurrence

SIZE = (1280, 960)
CUBE_COLOUR: Colour = (0.08, 0.36, 0.75)
ENVELOPE_COLOUR: Colour = (0.75, 0.12, 0.12)
_CABLE_COLOUR: Colour = (0.85, 0.1, 0.1)  # in the drive's picture, where steel on aluminium is not seen
ISO, _FRONT, _SIDE, _TOP = (np.array(v, dtype=float) for v in ((0.42, -0.78, 0.46), (0, -1, 0), (1, 0, 0), (0, 0, 1)))
_DRIVE = np.array([0.45, -0.86, -0.12])  # from the encoder's side, a little from below: pinion and cable are seen
_OPENED = re.compile(r"encoder_cheek|encoder_board|board_|wave_spring|bearing_0_e|cheek_\w+_0_e")
_EXPLODED = np.array([0.80, -0.55, 0.38])
# Boxes of parts that are closer hang together; the running gaps of the drive are wider, its seats narrower.
_NEAR_MM = 0.5
_SIGHTED = 60  # vertices of a part of which those that are seen are sought
_SIGHT_MM, _FAR_MM = 0.05, 2000.0  # before a surface, where its own facets are left; beyond any machine
VIEWS = ("iso", "front", "top", "side", "drive", "exploded", "poses")


@dataclass(frozen=True)
class Stage:
    """Outline into which the machine has to fit and cube that it has to reach, in the base frame.

    Attributes:
        envelope_mm: (2,) size of the outline along x and y, mm.
        envelope_centre_mm: (2,) its centre, mm.
        cube_bottom_mm: Height of the cube's bottom face, mm.
        cube_half_side_mm: Half the side of the cube, mm.
        cube_centre_x_mm: How far its middle stands off the base's axis along x, mm.
    """

    envelope_mm: tuple[float, float]
    envelope_centre_mm: tuple[float, float]
    cube_bottom_mm: float
    cube_half_side_mm: float
    cube_centre_x_mm: float = 0.0

    def cube(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner of the cube, (3,) mm each."""
        half, bottom, middle = self.cube_half_side_mm, self.cube_bottom_mm, self.cube_centre_x_mm
        return np.array([middle - half, -half, bottom]), np.array([middle + half, half, bottom + 2 * half])

    def envelope(self, z: float) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner of the outline rectangle at a height, (3,) mm each."""
        centre, half = np.array([*self.envelope_centre_mm, z]), np.array([*self.envelope_mm, 0.0]) / 2
        return centre - half, centre + half


def write_views(assembly: Assembly, meshes: Meshes, directory: Path, stage: Stage) -> list[Path]:
    """Draws all pictures of the machine at home.

    Args:
        assembly: The machine.
        meshes: Part number -> mesh in mm.
        directory: Folder to write into, made if missing.
        stage: Outline and cube.

    Returns:
        The files, named after `VIEWS`.

    Raises:
        PictureError: There is no OpenGL.
        UnreachableError: The centre of the cube, or of its bottom or top face, cannot be reached.
    """
    directory.mkdir(parents=True, exist_ok=True)
    studio = _Studio(assembly, meshes, stage)
    paths = [directory / f"{view}.png" for view in VIEWS]
    try:
        for view, path in zip(VIEWS, paths, strict=True):
            studio.draw(view, path)
    finally:
        studio.window.Finalize()
    return paths


def write_motion(
    assembly: Assembly, meshes: Meshes, directory: Path, stage: Stage, positions_mm: np.ndarray, size: tuple[int, int]
) -> list[Path]:
    """Draws the machine at positions one after the other, from one fixed camera, with its cube.

    Args:
        assembly: The machine.
        meshes: Part number -> mesh in mm.
        directory: Folder to write into, made if missing.
        stage: Its cube.
        positions_mm: (n, 3) of the platform's centre, within reach.
        size: Width and height of a picture, pixels.

    Returns:
        The files, 000.png and on.

    Raises:
        PictureError: There is no OpenGL.
        UnreachableError: A position cannot be reached.
    """
    directory.mkdir(parents=True, exist_ok=True)
    window, cube, paths = render_window(size), box_actor(*stage.cube(), CUBE_COLOUR), list[Path]()

    def at(p_mm: np.ndarray) -> PartScene:
        poses = assembly.poses(p_mm)
        return PartScene(
            [placed(meshes[o.part.number], poses[o.name], o.part.material.colour) for o in assembly.occurrences]
        )

    try:
        seen = np.concatenate([at(p_mm).points_mm for p_mm in _box(*stage.cube())])  # nothing is farther out
        for number, p_mm in enumerate(positions_mm):
            scene = at(p_mm)
            scene.renderer.AddActor(cube)
            sheet = Sheet(scene.renderer, ISO, size, seen)
            words = f"handle along the edges of its cube workspace of {2 * stage.cube_half_side_mm:.4g} mm"
            sheet.caption(assembly.name, words)
            paths.append(directory / f"{number:03d}.png")
            photograph(window, [sheet.scene, sheet.finish()], paths[-1])
    finally:
        window.Finalize()
    return paths


def edge_path(stage: Stage, steps: int) -> np.ndarray:
    """Gives a closed path along eight edges of the cube that passes each corner once, slow at the corners.

    Args:
        stage: With the cube.
        steps: Positions on an edge.

    Returns:
        (8 steps, 3) positions, mm; the first is a corner of the bottom.
    """
    low, high = stage.cube()
    turns = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 0, 1), (0, 0, 1)])
    corners = low + turns * (high - low)
    along = (1.0 - np.cos(np.pi * np.arange(steps) / steps)) / 2.0
    ways = np.roll(corners, -1, axis=0) - corners
    return (corners[:, None] + along[None, :, None] * ways[:, None]).reshape(-1, 3)


class _Studio:
    """A window, and the machine at home before it."""

    def __init__(self, assembly: Assembly, meshes: Meshes, stage: Stage) -> None:
        self.assembly, self.meshes, self.stage, self.at = assembly, meshes, stage, np.array(assembly.home_mm)
        self.window = render_window(SIZE)
        self.scene = PartScene(self._placed(self.at, assembly.occurrences))
        self.bounds = self.scene.bounds_mm
        self.cube = box_actor(*stage.cube(), CUBE_COLOUR)
        self.envelope = box_actor(*stage.envelope(self.bounds[0, 2]), ENVELOPE_COLOUR)

    def _placed(self, p_mm: np.ndarray, occurrences: Sequence[Occurrence]) -> list[Placed]:
        """Occurrences at a handle position."""
        poses = self.assembly.poses(p_mm)
        return [placed(self.meshes[o.part.number], poses[o.name], o.part.material.colour) for o in occurrences]

    def draw(self, view: str, path: Path) -> None:
        """Draws one picture into its file."""
        sheets: list[Sheet] = getattr(self, f"_{view}")()
        photograph(self.window, [layer for sheet in sheets for layer in (sheet.scene, sheet.finish())], path)
        for sheet in sheets:
            sheet.scene.RemoveActor(self.cube)
            sheet.scene.RemoveActor(self.envelope)

    def _sheet(self, towards: np.ndarray, points: np.ndarray, room: float, frames: list[Any]) -> Sheet:
        for frame in frames:
            self.scene.renderer.AddActor(frame)
        return Sheet(self.scene.renderer, towards, SIZE, points, room=room)

    def _where(self) -> str:
        x, y, z = self.at
        return f"platform centre at ({x:.1f}, {y:.1f}, {z:.1f}) mm"

    def _corners(self) -> np.ndarray:
        """Points that every overall view must show."""
        return np.concatenate([_box(*self.bounds), _box(*self.stage.cube())])

    def _iso(self) -> list[Sheet]:
        points = np.concatenate(
            [self.scene.points_mm, _box(*self.stage.cube()), _box(*self.stage.envelope(self.bounds[0, 2]))]
        )
        sheet = self._sheet(ISO, points, 0.0, [self.cube, self.envelope])
        width, depth = self.stage.envelope_mm
        side = 2 * self.stage.cube_half_side_mm
        sheet.caption(
            self.assembly.name,
            f"{self._where()}; blue: cube workspace {side:g} mm; red: outline {width:g} x {depth:g} mm",
        )
        return [sheet]

    def _front(self) -> list[Sheet]:
        return self._elevation(_FRONT, "front view", 0)

    def _side(self) -> list[Sheet]:
        return self._elevation(_SIDE, "side view", 1)

    def _elevation(self, towards: np.ndarray, title: str, axis: int) -> list[Sheet]:
        """A view along the ground: overall width and height, the cube's side and height."""
        sheet = self._sheet(towards, self._corners(), 95.0, [self.cube])
        (left, bottom), (right, top) = sheet.flat(self.bounds[0]), sheet.flat(self.bounds[1])
        sheet.dimension((left, bottom), (right, bottom), f"{right - left:.1f}", rows=-1, upright=False)
        sheet.dimension((left, bottom), (left, top), f"{top - bottom:.1f}", rows=-1.4, upright=True)
        low, high = (sheet.flat(corner) for corner in self.stage.cube())
        edge = max(right, high[0])
        side, floor = high[1] - low[1], low[1]
        sheet.dimension((edge, floor), (edge, floor + side), f"{side:g}", rows=1, upright=True)
        sheet.dimension((edge, 0.0), (edge, floor), f"{floor:g}", rows=1, upright=True)
        sheet.centre_line(left - 6.0, edge + 6.0, 0.0)
        crown = max(top, high[1])
        sheet.dimension((low[0], crown), (high[0], crown), f"cube {side:g}", rows=0.8, upright=False)
        letter = "xy"[axis]
        sheet.caption(
            f"{self.assembly.name}, {title}",
            f"{self._where()}; {letter} to the right, z up; chain line: plane of the shoulder axes",
        )
        return [sheet]

    def _top(self) -> list[Sheet]:
        low, high = self.stage.envelope(self.bounds[0, 2])
        points = np.concatenate([_box(*self.bounds), _box(low, high)])
        sheet = self._sheet(_TOP, points, 80.0, [self.envelope])
        (left, bottom), (right, top) = sheet.flat(low), sheet.flat(high)
        sheet.dimension((left, bottom), (right, bottom), f"outline {right - left:g}", rows=-1, upright=False)
        sheet.dimension((left, bottom), (left, top), f"outline {top - bottom:g}", rows=-1, upright=True)
        (west, south), (east, north) = sheet.flat(self.bounds[0]), sheet.flat(self.bounds[1])
        sheet.dimension(
            (west, north), (east, north), f"{east - west:.1f}", rows=1 + _rows(sheet, top - north), upright=False
        )
        sheet.dimension(
            (east, south), (east, north), f"{north - south:.1f}", rows=1 + _rows(sheet, right - east), upright=True
        )
        sheet.caption(f"{self.assembly.name}, top view", f"{self._where()}; x to the right, y up; red: outline allowed")
        return [sheet]

    def _drive(self) -> list[Sheet]:
        parts = [
            replace(part, colour=_CABLE_COLOUR) if o.part.number.startswith("capstan_cable") else part
            for o, part in self._chain()
            if not _OPENED.match(o.name)
        ]
        words = "without the encoder's cheek" + (
            "; red: cable" if _CABLE_COLOUR in {part.colour for part in parts} else ""
        )
        return self._alone(_DRIVE, parts, "drive of chain 0", f"{self._where()}; {words}")

    def _exploded(self) -> list[Sheet]:
        """The drive taken apart, with the item of each part."""
        chain = self._chain()
        moves = exploded_chain(self.assembly, self.meshes, [o for o, _ in chain])
        pulled = [(o, replace(part, points=part.points + moves[o.name])) for o, part in chain]
        scene = PartScene([part for _, part in pulled])
        sheet = Sheet(scene.renderer, _EXPLODED, SIZE, scene.points_mm, room=BALLOON_ROOM)
        items, shown = items_of(self.assembly), _Sight([part for _, part in pulled], sheet.towards)
        of_item: dict[int, list[np.ndarray]] = {}
        for o, part in pulled:
            of_item.setdefault(items[o.part.piece_of or o.part.number], []).append(part.points)
        sheet.balloons({item: shown.point_of(parts) for item, parts in of_item.items()})
        words = "each part along its own axis; numbers: items of bom.csv"
        sheet.caption(f"{self.assembly.name}, drive of chain 0, exploded", words)
        return [sheet]

    def _alone(self, towards: np.ndarray, parts: list[Placed], title: str, subtitle: str) -> list[Sheet]:
        """Some of the parts, filling the sheet."""
        scene = PartScene(parts)
        sheet = Sheet(scene.renderer, towards, SIZE, scene.points_mm, room=10.0)
        sheet.caption(f"{self.assembly.name}, {title}", subtitle)
        return [sheet]

    def _chain(self) -> list[tuple[Occurrence, Placed]]:
        """Chain 0 without its rods, and of the base only what hangs together with it."""
        links = ("base", "upper_arm_0", "pinion_0")
        chain = [o for o in self.assembly.occurrences if o.link in links and chain_of(o.name) == 0]
        parts = self._placed(self.at, chain)
        boxes = np.array([[part.points.min(axis=0), part.points.max(axis=0)] for part in parts])
        joined = np.array([o.link != "base" for o in chain])
        touching = (boxes[:, None, 0] <= boxes[None, :, 1] + _NEAR_MM).all(axis=2)
        touching &= touching.T
        for _ in chain:
            joined = joined | (touching & joined).any(axis=1)
        return [(o, part) for o, part, keep in zip(chain, parts, joined, strict=True) if keep]

    def _poses(self) -> list[Sheet]:
        low, high = self.stage.cube()
        half = (SIZE[0] // 2, SIZE[1])
        heights = {"lowest": float(low[2]), "highest": float(high[2])}
        everything = self.assembly.occurrences
        middle = float(low[0] + high[0]) / 2.0
        scenes = {word: PartScene(self._placed(np.array([middle, 0.0, z]), everything)) for word, z in heights.items()}
        points = np.concatenate([_box(*scene.bounds_mm) for scene in scenes.values()] + [_box(low, high)])
        sheets = []
        for column, (word, scene) in enumerate(scenes.items()):
            scene.renderer.SetViewport((0.5 * column, 0.0, 0.5 * column + 0.5, 1.0))
            scene.renderer.AddActor(self.cube)
            sheet = Sheet(scene.renderer, _FRONT, half, points, room=10.0)
            sheet.caption(
                f"{word} position", f"platform centre at ({middle:.4g}, 0, {heights[word]:.1f}) mm, same scale"
            )
            sheets.append(sheet)
        return sheets


class _Sight:
    """What of placed parts is seen from far away.

    Args:
        parts: All that may hide something.
        towards: (3,) unit vector to the viewer.
    """

    def __init__(self, parts: Sequence[Placed], towards: np.ndarray) -> None:
        from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

        self._mesh = joined(parts)
        self._locator, self._towards = vtkStaticCellLocator(), towards
        self._locator.SetDataSet(self._mesh)
        self._locator.BuildLocator()

    def point_of(self, parts: Sequence[np.ndarray]) -> np.ndarray:
        """Finds a vertex of parts (n, 3) near the middle of what is seen of one; the middle of one where nothing is."""
        best: tuple[int, np.ndarray] = (0, parts[0].mean(axis=0))
        for points in parts:
            candidates = points[:: max(1, len(points) // _SIGHTED)]
            seen = np.array([point for point in candidates if self._is_seen(point)]).reshape(-1, 3)
            if len(seen) > best[0]:
                best = len(seen), seen[np.linalg.norm(seen - seen.mean(axis=0), axis=1).argmin()]
        return best[1]

    def _is_seen(self, point: np.ndarray) -> bool:
        """Whether nothing is before a point of a surface."""
        from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints

        start, end = point + _SIGHT_MM * self._towards, point + _FAR_MM * self._towards
        return not self._locator.IntersectWithLine(start.tolist(), end.tolist(), 1e-6, vtkPoints(), vtkIdList())


def _box(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(8, 3) corners of an upright box."""
    return np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])


def _rows(sheet: Sheet, distance_mm: float) -> float:
    """A distance on the sheet as steps of dimension lines, to clear what lies between; never negative."""
    return max(0.0, distance_mm / (DIMENSION_PIXELS * sheet.mm_per_pixel))
