"""Exploded view: which way a part leaves, how far, and that no two parts meet at the end."""

from __future__ import annotations

import re
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Mesh, MeshLibrary
from delta_cad.export.bom import items_of
from delta_cad.export.views import views
from delta_cad.export.views.explode import GAP_MM, _Unit, apart, exploded, exploded_chain, revolution_axis
from delta_cad.export.views.sheet import Sheet
from delta_cad.export.views.views import Stage
from delta_cad.report.subject import Subject
from tests.committed import Built
from tests.delta_cad.report.reading import Page

X, Y, Z = range(3)


def lathe(*rings: tuple[float, float]) -> Mesh:
    """A closed body of revolution about y through rings of (radius, y), mm."""
    count = 24
    angles = 2.0 * np.pi * np.arange(count) / count
    points = [[r * np.cos(a), y, -r * np.sin(a)] for r, y in rings for a in angles]
    points += [[0.0, rings[0][1], 0.0], [0.0, rings[-1][1], 0.0]]
    faces = []
    for k in range(len(rings) - 1):
        for i in range(count):
            a, b = k * count + i, k * count + (i + 1) % count
            faces += [[a, b, b + count], [a, b + count, a + count]]
    last = (len(rings) - 1) * count
    for i in range(count):
        j = (i + 1) % count
        faces += [[len(points) - 2, j, i], [len(points) - 1, last + i, last + j]]
    return Mesh(np.array(points), np.array(faces), 0.0)


def brick(x: float, y: float, z: float) -> Mesh:
    corners = np.array([[i, j, k] for i in (0.0, x) for j in (0.0, y) for k in (0.0, z)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]]
    faces += [[0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    return Mesh(corners, np.array(faces), 0.0)


def test_a_screw_points_to_its_head_and_a_plate_to_nothing() -> None:
    screw = lathe((1.5, 0.0), (1.5, 10.0), (3.0, 10.0), (3.0, 13.0))
    assert screw.is_watertight
    assert screw.volume_mm3 > 0.0
    assert revolution_axis(screw) == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)
    turned = Mesh(-screw.vertices, screw.faces[:, ::-1], 0.0)
    assert revolution_axis(turned) == pytest.approx([0.0, -1.0, 0.0], abs=1e-6)
    washer = revolution_axis(lathe((5.0, 0.0), (5.0, 1.0)))
    assert washer is not None
    assert abs(washer) == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)
    assert brick(3.0, 20.0, 40.0).is_watertight
    assert revolution_axis(brick(3.0, 20.0, 40.0)) is None
    assert revolution_axis(brick(10.0, 10.0, 10.0)) is None  # as of a ball: no axis before another


def unit(name: str, low: tuple[float, ...], high: tuple[float, ...], axis: int, sense: int = 0) -> _Unit:
    return _Unit((name,), np.array([[low, high]], dtype=float), axis, sense, name.split("#")[0])


def test_parts_leave_in_turn_the_outermost_farthest() -> None:
    units = [
        unit("block", (0, 0, 0), (10, 10, 10), Z),
        unit("plate", (0, 10, 0), (10, 14, 10), Y),
        unit("screw", (4, 8, 4), (6, 16, 6), Y, 1),
        unit("foot", (4, -3, 4), (6, 0, 6), Y),
        unit("flag", (40, 0, 0), (50, 10, 10), X),
    ]
    moves = apart(units, lambda one: {"block": 3}.get(one.names[0], 0))
    assert moves["block"] == pytest.approx([0.0, 0.0, 0.0])
    assert moves["plate"] == pytest.approx([0.0, GAP_MM, 0.0])
    assert moves["screw"] == pytest.approx([0.0, 18.0 + GAP_MM - 8.0, 0.0])  # from 8 to beyond the plate, now at 18
    assert moves["foot"] == pytest.approx([0.0, -GAP_MM, 0.0])
    assert moves["flag"] == pytest.approx([0.0, 0.0, 0.0])  # nothing is in its way


def test_like_parts_side_by_side_go_together() -> None:
    units = [
        unit("block", (0, 0, 0), (50, 10, 10), Z),
        unit("lug", (0, 10, 0), (10, 20, 10), Y),
        unit("screw#0", (4, 10, 4), (6, 22, 6), Y, 1),
        unit("screw#1", (44, 10, 4), (46, 22, 6), Y, 1),
    ]
    moves = apart(units, lambda one: {"block": 3}.get(one.names[0], 0))
    assert moves["screw#0"] == pytest.approx(moves["screw#1"])
    assert moves["screw#0"][Y] > moves["lug"][Y] > 0.0


def test_a_screw_goes_further_than_a_board_whose_connector_is_higher_than_its_head() -> None:
    board = unit("board", (0, 10, 0), (10, 12, 10), Y)
    board.boxes = np.concatenate([board.boxes, [[[0, 12, 0], [3, 30, 3]]]])  # its connector
    units = [unit("block", (0, 0, 0), (10, 10, 10), Z), board, unit("screw", (7, 4, 7), (9, 14, 9), Y, 1)]
    moves = apart(units, lambda one: {"block": 3}.get(one.names[0], 0))
    assert moves["board"] == pytest.approx([0.0, GAP_MM, 0.0])
    assert 4 + moves["screw"][Y] >= 12 + moves["board"][Y] + GAP_MM  # its tip is beyond the board


def test_no_two_parts_of_the_machine_meet_when_it_is_apart(page: Page, built: Built) -> None:
    import trimesh
    from trimesh.collision import CollisionManager

    scene = trimesh.load_scene(built.folder / "assembly.glb")
    to_z_up = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    manager, known = CollisionManager(), page.data()["occurrences"]
    for name, (_, _, move) in known.items():
        matrix, geometry = scene.graph[name]
        mesh = scene.geometry[geometry].convex_hull  # more than the part itself
        points = (mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]) @ to_z_up.T + np.array(move) / 1000.0
        manager.add_object(name, trimesh.Trimesh(points, mesh.faces, process=False))
    _, pairs = manager.in_collision_internal(return_names=True)
    own = [pair for pair in pairs if not (bonded(pair, "capstan_cable") or bonded(pair, "joint_ball"))]
    assert own == []


def test_the_drive_alone_comes_apart_too_and_screws_leave_their_plates(
    best_assembly: Assembly, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reported: dict[int, np.ndarray] = {}
    taken: dict[str, np.ndarray] = {}
    monkeypatch.setattr(views, "VIEWS", ("exploded",))
    monkeypatch.setattr(Sheet, "balloons", lambda _, points: reported.update(points))

    def kept(*given: Any) -> dict[str, np.ndarray]:
        taken.update(exploded_chain(*given))
        return taken

    monkeypatch.setattr(views, "exploded_chain", kept)
    meshes = MeshLibrary(best_assembly.parts, 0.1, 0.5)
    views.write_views(best_assembly, meshes, tmp_path, Stage((270.0, 220.0), (0.0, 0.0), 57.0, 37.5))
    shown = {o.name: o for o in best_assembly.occurrences if o.name in taken}
    items = items_of(best_assembly)
    assert reported.keys() == {items[o.part.piece_of or o.part.number] for o in shown.values()}
    poses, boxes = best_assembly.poses(best_assembly.home_mm), {}
    for name, o in shown.items():
        points = meshes[o.part.number].vertices @ poses[name][:3, :3].T + poses[name][:3, 3] + taken[name]
        boxes[name] = points.min(axis=0), points.max(axis=0)
    for item, at in reported.items():  # on a part of that item
        own = [boxes[n] for n, o in shown.items() if items[o.part.piece_of or o.part.number] == item]
        assert any((low - 1e-6 <= at).all() and (at <= high + 1e-6).all() for low, high in own)
    meeting = [
        (a, b)
        for a, b in combinations(boxes, 2)
        if (boxes[a][0] < boxes[b][1]).all() and (boxes[b][0] < boxes[a][1]).all()
    ]
    screws = {name for name in shown if "screw" in name}
    assert screws
    assert [pair for pair in meeting if screws & set(pair)] == []
    assert [p for p in meeting if not (bonded(p, "capstan_cable") or bonded(p, "joint_ball"))] == []


def bonded(pair: tuple[str, str], kind: str) -> bool:
    """Pieces of one cable stay together, and balls on their bar."""
    return any(kind in name for name in pair) and all(kind in n or "cross_bar" in n for n in pair)


def test_every_part_has_its_way_and_chains_go_alike(subject: Subject) -> None:
    moves = exploded(subject.assembly, subject.meshes)
    assert set(moves) == {o.name for o in subject.assembly.occurrences}
    turn = np.array([[-0.5, -np.sqrt(0.75), 0.0], [np.sqrt(0.75), -0.5, 0.0], [0.0, 0.0, 1.0]])
    first = [name for name in moves if re.match(r"\D*_0", name)]
    assert len(first) == 6
    for name in first:
        assert turn @ moves[name] == pytest.approx(moves[name.replace("_0", "_1", 1)], abs=1e-6), name
