"""Pictures: read by another PNG reader and measured; nothing printed, no display needed, a clear error without GL."""

from __future__ import annotations

import os
import subprocess
import sys
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.common.worker_process import WorkerProcess, WorkerProcessError
from delta_cad.export import mesh_files
from delta_cad.export.views import scene as scene_module
from delta_cad.export.views import views as views_module
from delta_cad.export.views.explode import chain_of
from delta_cad.export.views.scene import PartScene, PictureError, placed, render_window
from delta_cad.export.views.sheet import Sheet, box_actor
from delta_cad.export.views.views import (
    CUBE_COLOUR,
    ENVELOPE_COLOUR,
    SIZE,
    VIEWS,
    Stage,
    edge_path,
    write_motion,
    write_views,
)
from delta_cad.mechanism import UnreachableError
from tests.committed import ROOT
from tests.delta_cad.export.machine import make_assembly

STAGE = Stage((220.0, 270.0), (0.0, 0.0), 57.112, 37.5)
PROGRAM = """
import sys
from pathlib import Path
from tests.delta_cad.export.machine import make_assembly
from delta_cad.export.views.views import Stage, write_views
from delta_cad.assembly.tessellation import MeshLibrary
machine = make_assembly()
stage = Stage((220.0, 270.0), (0.0, 0.0), 57.112, 37.5)
write_views(machine, MeshLibrary(machine.parts), Path(sys.argv[1]), stage)
"""


def read_png(path: Path) -> np.ndarray:
    """(height, width, 3) by VTK's reader, first row on top."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOImage import vtkPNGReader

    reader = vtkPNGReader()
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)[::-1]


def extent(pixels: np.ndarray, colour: tuple[float, float, float]) -> np.ndarray:
    """(2, 2) first and last column and row of a hue: antialiasing mixes it with white, which keeps its hue."""
    shade = 255.0 - pixels.astype(float)
    wanted = 1.0 - np.array(colour)
    size = np.linalg.norm(shade, axis=2)
    alike = (shade @ wanted) / np.linalg.norm(wanted) > 0.995 * size
    rows, columns = np.nonzero(alike & (size > 120.0))
    return np.array([[columns.min(), columns.max()], [rows.min(), rows.max()]])


def whole_scene(machine: Assembly, meshes: MeshLibrary) -> PartScene:
    poses = machine.poses(machine.home_mm)
    return PartScene(
        [placed(meshes[o.part.number], poses[o.name], o.part.material.colour) for o in machine.occurrences]
    )


@pytest.fixture(scope="module")
def pictures(machine: Assembly, meshes: MeshLibrary, tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    paths = write_views(machine, meshes, tmp_path_factory.mktemp("views") / "deep", STAGE)
    assert [path.stem for path in paths] == list(VIEWS)
    return {path.stem: read_png(path) for path in paths}


@pytest.mark.parametrize("view", VIEWS)
def test_every_picture_shows_the_machine(pictures: dict[str, np.ndarray], view: str) -> None:
    pixels = pictures[view]
    assert pixels.shape == (SIZE[1], SIZE[0], 3)
    middle = pixels[SIZE[1] // 6 : -SIZE[1] // 6, SIZE[0] // 6 : -SIZE[0] // 6].astype(int)
    orange = (middle[..., 0] - middle[..., 2]) > 80
    dark = middle.max(axis=2) < 60
    assert orange.mean() > 0.01  # the arms
    assert dark.mean() > 0.01  # motors and rods
    assert pixels[-1, -1].min() > 200  # the ground stays light


def test_the_pictures_differ(pictures: dict[str, np.ndarray]) -> None:
    assert len({zlib.crc32(pixels.tobytes()) for pixels in pictures.values()}) == len(VIEWS)


def test_the_outline_in_the_top_view_has_its_proportions(pictures: dict[str, np.ndarray]) -> None:
    (left, right), (top, bottom) = extent(pictures["top"], ENVELOPE_COLOUR)
    # the lines are two pixels wide on 500
    assert (right - left) / (bottom - top) == pytest.approx(220 / 270, rel=0.01)


def test_the_cube_in_front_and_side_view_is_square_and_to_scale(pictures: dict[str, np.ndarray]) -> None:
    for view in ("front", "side"):
        (left, right), (top, bottom) = extent(pictures[view], CUBE_COLOUR)
        assert right - left == pytest.approx(bottom - top, abs=3)


def test_the_drive_shows_pinion_and_cable(
    best_assembly: Assembly, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(views_module, "VIEWS", ("drive",))
    (path,) = write_views(best_assembly, MeshLibrary(best_assembly.parts), tmp_path, STAGE)
    pixels = read_png(path).astype(int)
    red = (pixels[..., 0] > 120) & (pixels[..., 1:].max(axis=2) < 60)
    along = np.nonzero(red)[1]
    assert red.sum() > 500
    assert along.max() - along.min() > SIZE[0] / 6  # the strand, beside the turns


def test_the_scale_holds_between_cube_and_machine(machine: Assembly, meshes: MeshLibrary) -> None:
    scene = whole_scene(machine, meshes)
    low, high = scene.bounds_mm
    assert low[2] == pytest.approx(-64.0)
    assert high[2] == pytest.approx(94.6 + 5.0)
    sheet = Sheet(scene.renderer, np.array([0.0, -1.0, 0.0]), SIZE, np.array([low, high]))
    np.testing.assert_allclose(sheet.right, [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(sheet.up, [0, 0, 1], atol=1e-15)
    assert sheet.mm_per_pixel * SIZE[0] > high[0] - low[0]
    np.testing.assert_allclose(sheet.flat(sheet.solid(np.array([3.0, 4.0]))), [3.0, 4.0])


def test_x_is_right_and_y_up_seen_from_above(machine: Assembly, meshes: MeshLibrary) -> None:
    scene = whole_scene(machine, meshes)
    sheet = Sheet(scene.renderer, np.array([0.0, 0.0, 1.0]), SIZE, scene.bounds_mm)
    np.testing.assert_allclose([sheet.right, sheet.up], [[1, 0, 0], [0, 1, 0]], atol=1e-15)


def test_an_unreachable_home_is_an_error(machine: Assembly, meshes: MeshLibrary, tmp_path: Path) -> None:
    with pytest.raises(UnreachableError):
        write_views(replace(machine, home_mm=np.array([0.0, 0.0, 400.0])), meshes, tmp_path, STAGE)


@pytest.mark.slow
def test_a_fresh_process_without_display_prints_nothing(tmp_path: Path) -> None:
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    command = [sys.executable, "-c", PROGRAM, str(tmp_path)]
    job = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert (job.returncode, job.stdout, job.stderr) == (0, "", "")
    assert {path.stem for path in tmp_path.iterdir()} == set(VIEWS)


def test_no_opengl_is_said_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    class Blind:
        def __getattr__(self, _: str):
            return lambda *_: 0

    monkeypatch.setattr(scene_module, "_window_makers", lambda: [Blind])
    with pytest.raises(PictureError, match="OpenGL"):
        render_window((64, 64))


def test_a_writer_that_ends_early_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def ended(_: WorkerProcess) -> None:
        raise WorkerProcessError("mesh_files: Killed")

    monkeypatch.setattr(WorkerProcess, "receive", ended)
    with WorkerProcess(mesh_files.__name__) as writer, pytest.raises(PictureError, match=r"^mesh_files: Killed$"):
        mesh_files.written(writer)


def test_a_display_is_the_last_resort(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    without = [maker.__name__ for maker in scene_module._window_makers()]
    assert "vtkRenderWindow" not in without
    monkeypatch.setenv("DISPLAY", ":0")
    assert [maker.__name__ for maker in scene_module._window_makers()] == [*without, "vtkRenderWindow"]


def test_a_display_that_does_not_answer_does_no_harm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", "nowhere.invalid:7")
    window = render_window((64, 48))
    assert tuple(window.GetSize()) == (128, 96)  # twice the finished picture, which smooths it
    window.Finalize()


@pytest.mark.parametrize(
    ("name", "chain"),
    [("upper_arm_0", 0), ("bearing_1_e", 1), ("screw_M3x12_2_0", 2), ("motor_30x68", None), ("base_plate", None)],
)
def test_the_chain_stands_in_the_name(name: str, chain: int | None) -> None:
    assert chain_of(name) == chain


def test_a_box_is_drawn_by_its_edges() -> None:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    for high, length in (([2.0, 3.0, 5.0], 4 * 10.0), ([2.0, 3.0, 0.0], 2 * (2 * 2.0 + 2 * 3.0))):
        actor = box_actor(np.zeros(3), np.array(high), CUBE_COLOUR)
        actor.GetMapper().Update()
        box = actor.GetMapper().GetInput()
        points = vtk_to_numpy(box.GetPoints().GetData())
        ends = points[vtk_to_numpy(box.GetLines().GetConnectivityArray()).reshape(-1, 2)]
        np.testing.assert_allclose(points.max(axis=0), high)
        # where a box is flat, its bottom and top coincide
        assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(length)


def test_the_module_is_light_until_it_draws() -> None:
    program = (
        "import sys, delta_cad.export.views.views\n"
        "print(any(m.startswith(('vtk', 'cadquery', 'OCP')) for m in sys.modules))"
    )
    job = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60)
    assert job.stdout.strip() == "False"


def test_frames_of_the_stage() -> None:
    low, high = STAGE.cube()
    np.testing.assert_allclose(high - low, 75.0)
    assert low[2] == 57.112
    low, high = Stage((220.0, 270.0), (10.0, -5.0), 0.0, 1.0).envelope(-60.0)
    np.testing.assert_allclose([low, high], [[-100.0, -140.0, -60.0], [120.0, 130.0, -60.0]])
    assert make_assembly().home_mm[2] > 0


def test_the_path_along_the_edges_is_closed_and_passes_each_corner_once() -> None:
    low, high = (stage := Stage((0.0, 0.0), (0.0, 0.0), 60.0, 30.0, 5.0)).cube()
    path = edge_path(stage, 6)
    assert path.shape == (48, 3)
    at_end = np.isclose(path, low) | np.isclose(path, high)
    assert (at_end.sum(axis=1) >= 2).all()  # on an edge
    corners = path[at_end.all(axis=1)]
    assert len(corners) == len({tuple(corner) for corner in corners.round(6)}) == 8
    steps = np.linalg.norm(np.diff(path, axis=0, append=path[:1]), axis=1)
    assert steps.max() < 60.0 * np.pi / 2 / 6 * 1.01  # of a cosine, at most its steepest
    assert steps.reshape(8, 6).sum(axis=1) == pytest.approx(60.0)  # one edge after the other


def test_the_machine_moves_before_a_camera_that_stands(machine: Assembly, meshes: MeshLibrary, tmp_path: Path) -> None:
    """The cube's blue lines stay where they are; twice the same position gives the same bytes."""
    x, y, z = machine.home_mm
    positions = np.array([(x, y, z), (x, y, z + 5.0), (x, y, z)])
    stage = Stage((0.0, 0.0), (0.0, 0.0), z - 5.0, 5.0)
    paths = write_motion(machine, meshes, tmp_path, stage, positions, (320, 240))
    assert [path.name for path in paths] == ["000.png", "001.png", "002.png"]
    first, second, third = (path.read_bytes() for path in paths)
    assert first == third
    assert first != second
