"""STL, 3MF and GLB, read back by trimesh."""

from __future__ import annotations

import hashlib
import json
import struct
import time
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.export.glb import write_glb
from delta_cad.export.meshes import MeshError, write_3mf, write_stl
from delta_cad.export.views.polydata import poly_data, shaded
from delta_cad.export.views.scene import PartScene, Placed
from tests.delta_cad.export.machine import VOLUMES_MM3

CHORD_VOLUME = 0.03
"""Chords of 0.2 rad lose up to 1 - sin(0.2) / 0.2 = 0.7 % of a cylinder, more of a thin tube and a sphere."""
FLOAT32 = 1e-5
"""STL and GLB hold single precision: relative 6e-8 a coordinate; volumes of thin tubes cancel two digits."""


@dataclass(frozen=True)
class Triangles:
    vertices: np.ndarray
    faces: np.ndarray
    deviation_mm: float = 0.0


CORNERS = np.array([[x, y, z] for x in (0, 2.0) for y in (0, 3.0) for z in (0, 5.0)])
BOX = Triangles(
    CORNERS,
    np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
              [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]),
)  # fmt: skip


@pytest.mark.parametrize("number", sorted(VOLUMES_MM3))
def test_stl_encloses_the_parts_volume(meshes: MeshLibrary, tmp_path: Path, number: str) -> None:
    import trimesh

    write_stl(meshes[number], tmp_path / "a.stl", number)
    found = trimesh.load_mesh(tmp_path / "a.stl")
    assert found.is_watertight
    assert found.volume == pytest.approx(meshes[number].volume_mm3, rel=FLOAT32)
    assert found.volume == pytest.approx(VOLUMES_MM3[number], rel=CHORD_VOLUME)


def test_stl_bytes_are_those_of_the_format(tmp_path: Path) -> None:
    write_stl(BOX, tmp_path / "a.stl", "box")  # type: ignore[arg-type]
    data = (tmp_path / "a.stl").read_bytes()
    assert len(data) == 84 + 50 * 12
    assert not data.startswith(b"solid")
    assert struct.unpack("<I", data[80:84]) == (12,)
    assert struct.unpack("<3f", data[84:96]) == (-1.0, 0.0, 0.0)


@pytest.mark.parametrize("number", sorted(VOLUMES_MM3))
def test_3mf_encloses_the_parts_volume_in_millimetres(meshes: MeshLibrary, tmp_path: Path, number: str) -> None:
    import trimesh

    write_3mf(meshes[number], tmp_path / "a.3mf", number)
    scene: Any = trimesh.load_scene(tmp_path / "a.3mf")
    assert scene.units == "millimeter"
    assert list(scene.geometry) == [number]
    (mesh,) = scene.geometry.values()
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(meshes[number].volume_mm3, rel=FLOAT32)


def test_3mf_package_is_well_formed(tmp_path: Path) -> None:
    from lxml import etree

    write_3mf(BOX, tmp_path / "a.3mf", 'box "<1>"', "A & B", "steel")  # type: ignore[arg-type]
    with zipfile.ZipFile(tmp_path / "a.3mf") as package:
        assert package.testzip() is None
        assert package.namelist() == ["[Content_Types].xml", "_rels/.rels", "3D/3dmodel.model"]
        roots = [etree.fromstring(package.read(name)) for name in package.namelist()]
    core = {"m": "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"}
    model = roots[2]
    assert model.get("unit") == "millimeter"
    (entity,) = model.findall("m:resources/m:object", core)
    assert (entity.get("name"), entity.get("type")) == ('box "<1>"', "model")
    (item,) = model.findall("m:build/m:item", core)
    assert item.get("objectid") == entity.get("id")
    texts = {entry.get("name"): entry.text for entry in model.findall("m:metadata", core)}
    assert (texts["Title"], texts["Description"]) == ('box "<1>"', "A & B; steel")
    assert roots[1][0].get("Target") == "/3D/3dmodel.model"


def test_bytes_depend_on_nothing_but_the_mesh(
    meshes: MeshLibrary, machine: Assembly, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    digests = []
    for year in (2001, 2031):
        moment = time.struct_time((year, 1, 2, 3, 4, 5, 0, 2, 0))
        monkeypatch.setattr(time, "localtime", lambda *_, moment=moment: moment)
        write_stl(meshes["upper_arm"], tmp_path / "a.stl", "upper_arm")
        write_3mf(meshes["upper_arm"], tmp_path / "a.3mf", "upper_arm")
        write_glb(machine, meshes, tmp_path / "a.glb")
        digests.append(
            [hashlib.sha256((tmp_path / f"a.{kind}").read_bytes()).digest() for kind in ("stl", "3mf", "glb")]
        )
    assert digests[0] == digests[1]


@pytest.mark.parametrize("write", [write_stl, write_3mf])
def test_broken_meshes_are_refused(tmp_path: Path, write: Any) -> None:
    with pytest.raises(MeshError, match=r"^box: "):
        write(Triangles(CORNERS, np.empty((0, 3), int)), tmp_path / "a", "box")
    with pytest.raises(MeshError, match=r"^box: .* 8"):
        write(Triangles(CORNERS, np.array([[0, 1, 8]])), tmp_path / "a", "box")
    assert not (tmp_path / "a").exists()


@pytest.fixture(scope="module")
def glb(machine: Assembly, meshes: MeshLibrary, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("glb") / "assembly.glb"
    write_glb(machine, meshes, path)
    return path


def test_glb_is_in_metres_with_y_up(machine: Assembly, meshes: MeshLibrary, glb: Path) -> None:
    import trimesh

    poses = machine.poses(machine.home_mm)
    points = np.concatenate(
        [meshes[o.part.number].vertices @ poses[o.name][:3, :3].T + poses[o.name][:3, 3] for o in machine.occurrences]
    )
    swapped = points[:, [0, 2, 1]] * [1, 1, -1] / 1000
    bounds = trimesh.load_scene(glb).bounds
    # half a micrometre: single precision at 0.2 m is 1e-8 m
    np.testing.assert_allclose(bounds, [swapped.min(axis=0), swapped.max(axis=0)], atol=5e-7)


def test_glb_names_nodes_after_occurrences_and_meshes_after_parts(machine: Assembly, glb: Path) -> None:
    data = glb.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    tree = json.loads(data[20 : 20 + length])
    assert [mesh["name"] for mesh in tree["meshes"]] == [part.number for part in machine.parts]
    assert all(len(mesh["primitives"]) == 1 for mesh in tree["meshes"])
    assert all("NORMAL" in mesh["primitives"][0]["attributes"] for mesh in tree["meshes"])
    nodes = {node["name"]: tree["meshes"][node["mesh"]]["name"] for node in tree["nodes"] if "mesh" in node}
    assert nodes == {o.name: o.part.number for o in machine.occurrences}
    colours = {
        mesh["name"]: tree["materials"][mesh["primitives"][0]["material"]]["pbrMetallicRoughness"]["baseColorFactor"]
        for mesh in tree["meshes"]
    }
    # sRGB (0.85, 0.42, 0.12) in linear light, to the byte that the writer keeps
    np.testing.assert_allclose(colours["upper_arm"], [0.6939, 0.1470, 0.0137, 1.0], atol=1 / 255)


def test_glb_places_each_occurrence(machine: Assembly, glb: Path) -> None:
    import trimesh

    scene: Any = trimesh.load_scene(glb)
    poses = machine.poses(machine.home_mm)
    for occurrence in machine.occurrences:
        matrix, geometry = scene.graph[occurrence.name]
        assert geometry == occurrence.part.number
        x, y, z = poses[occurrence.name][:3, 3] / 1000
        np.testing.assert_allclose(matrix[:3, 3], [x, z, -y], atol=1e-9)
        np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-9)


def split(points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points, triangles and normals as they are drawn."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    data = shaded(poly_data(points, faces))
    triangles = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return vtk_to_numpy(data.GetPoints().GetData()), triangles, vtk_to_numpy(data.GetPointData().GetNormals())


def lines_drawn(points: np.ndarray, faces: np.ndarray, towards: tuple[float, float, float]) -> int:
    """Number of edges that a scene of one mesh shows to a parallel camera."""
    renderer = PartScene([Placed(points, faces, (0.5, 0.5, 0.5))]).renderer
    renderer.GetActiveCamera().SetPosition(*towards)
    edges = renderer.GetActors().GetLastActor().GetMapper()
    edges.Update()
    return edges.GetInput().GetNumberOfLines()


def test_a_box_is_split_along_its_edges_and_drawn_with_twelve() -> None:
    points, triangles, normals = split(BOX.vertices, BOX.faces)
    assert points.shape == (24, 3)
    corners = points[triangles]
    facets = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets /= np.linalg.norm(facets, axis=1, keepdims=True)
    np.testing.assert_allclose(normals[triangles], np.repeat(facets[:, None], 3, axis=1), atol=1e-12)
    np.testing.assert_allclose(corners, BOX.vertices[BOX.faces])
    assert lines_drawn(BOX.vertices, BOX.faces, (1.0, 0.2, 0.1)) == 12


def test_a_cylinder_is_smooth_and_drawn_with_its_outline(meshes: MeshLibrary) -> None:
    mesh = meshes["motor_30x68"]
    points, _, normals = split(mesh.vertices, mesh.faces)
    round_points = np.abs(normals[:, 1]) < 0.5
    radial = points[round_points] * [1, 0, 1] / 15.0
    np.testing.assert_allclose(normals[round_points], radial, atol=0.02)  # a tenth of the 0.2 rad between facets
    rims = np.abs(points[:, 1]) > 67.9, np.abs(points[:, 1]) < 0.1
    sharp = sum(int(rim.sum()) // 2 for rim in rims)  # each rim point stands there for the side and for the end face
    assert lines_drawn(mesh.vertices, mesh.faces, (1.0, 0.0, 0.0)) == sharp + 2
