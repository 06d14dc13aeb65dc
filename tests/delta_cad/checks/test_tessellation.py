"""Meshes: closed, close to the solid by no more than they say, and never taken from a cache."""

from dataclasses import replace
from itertools import product

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.tessellation import MERGE_MM, Mesh, MeshLibrary, _same, tessellate
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import BuildError
from tests.delta_cad.checks.machines import ball, box, part, parts, rod, solid

RNG = np.random.default_rng(5)

SHAPES = {
    "box": box((0, 0, 0), (1, 2, 3)),
    "cylinder": rod(8, (0, 0, 0), (0, 0, 20)),
    "ball": ball(4),
    "torus": cq.Solid.makeTorus(20, 4),
    "cone": cq.Solid.makeCone(5, 2, 8),
    "tip": cq.Solid.makeCone(5, 0, 3),
    "plate": solid(cq.Workplane().box(60, 30, 8).edges("|Z").fillet(3).faces(">Z").workplane().hole(4).val()),
    "spline": solid(cq.Workplane().spline([(0, 0), (4, 3), (9, 1), (6, -4)], periodic=True).close().extrude(5).val()),
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("linear", [0.5, 0.05])
def test_mesh_is_watertight_and_strays_no_farther_than_it_says(name: str, linear: float) -> None:
    shape = SHAPES[name]
    mesh = tessellate(shape, linear, 1.0)
    assert mesh.is_watertight
    assert mesh.volume_mm3 > 0.0
    # oracle: random points of the triangles against the exact surface, by the kernel
    rng = np.random.default_rng(1)
    weights = rng.dirichlet((1, 1, 1), 60)
    chosen = mesh.triangles[rng.integers(len(mesh.faces), size=60)]
    surface = cq.Shell.makeShell(shape.Faces())
    for point in np.einsum("kc,kcx->kx", weights, chosen):
        assert surface.distance(cq.Vertex.makeVertex(*point)) <= mesh.deviation_mm


@pytest.mark.parametrize("name", ["cylinder", "ball", "torus", "cone", "tip"])
def test_the_bound_is_not_wasteful(name: str) -> None:
    coarse, fine = (tessellate(SHAPES[name], linear, 1.5) for linear in (0.4, 0.025))
    assert fine.deviation_mm < coarse.deviation_mm / 4.0
    assert fine.deviation_mm < 4.0 * 0.025  # face and edge each may take the setting, and slightly exceed it


def test_points_of_the_surface_are_within_the_deviation_of_the_mesh() -> None:
    mesh = tessellate(SHAPES["cylinder"], 0.5, 1.5)
    angle = np.linspace(0, 2 * np.pi, 721)
    rim = np.stack([8 * np.cos(angle), 8 * np.sin(angle)], axis=1)
    corners = np.unique(np.round(mesh.vertices[:, :2], 9), axis=0)
    corners = corners[np.argsort(np.arctan2(corners[:, 1], corners[:, 0]))]
    ends = np.roll(corners, -1, axis=0)
    along = ends - corners
    share = np.clip(((rim[:, None] - corners) * along).sum(-1) / (along**2).sum(-1), 0, 1)
    away = np.linalg.norm(rim[:, None] - corners - share[..., None] * along, axis=-1).min(axis=1)
    assert away.max() <= mesh.deviation_mm
    assert away.max() > 0.05  # the chords are coarse enough to tell


def test_a_cached_mesh_is_neither_used_nor_spoiled() -> None:
    shape = ball(10)
    shape.tessellate(2.0, 2.0)
    before = tessellate(ball(10), 0.02, 0.2)
    mesh = tessellate(shape, 0.02, 0.2)
    assert len(mesh.faces) == len(before.faces) > 1000


def test_deflection_is_absolute() -> None:
    counts = [len(tessellate(rod(radius, (0, 0, 0), (0, 0, 1)), 0.01, 3.0).faces) for radius in (1.0, 100.0)]
    assert counts[1] > 5 * counts[0]


def test_open_and_inconsistent_meshes_are_not_watertight() -> None:
    mesh = tessellate(SHAPES["box"], 0.1, 0.5)
    assert not Mesh(mesh.vertices, mesh.faces[1:], 0.0).is_watertight
    turned = np.concatenate([mesh.faces[:1, ::-1], mesh.faces[1:]])
    assert not Mesh(mesh.vertices, turned, 0.0).is_watertight
    assert not Mesh(mesh.vertices, mesh.faces[:0], 0.0).is_watertight


def test_shapes_without_faces_are_refused() -> None:
    with pytest.raises(ValueError, match="no faces"):
        tessellate(cq.Edge.makeLine(cq.Vector(), cq.Vector(1, 0, 0)), 0.1, 0.5)


def test_library_keeps_one_mesh_a_part() -> None:
    arm = parts()["arm"]
    library = MeshLibrary([arm, arm], 0.1, 0.5)
    assert library["arm"] is library["arm"]
    assert library["arm"].is_watertight


def test_library_refuses_two_parts_of_one_number() -> None:
    one: Part = part("same", box((0, 0, 0), (1, 1, 1)))
    other = part("same", box((0, 0, 0), (1, 1, 2)))
    with pytest.raises(ValueError, match="'same'"):
        MeshLibrary([one, other])


def test_a_face_that_cannot_be_triangulated_is_refused() -> None:
    bare = cq.Face(cq.Face.makePlane(1, 1).wrapped.EmptyCopied())
    with pytest.raises(ValueError, match="could not be triangulated"):
        tessellate(bare, 0.1, 0.5)
    odd = replace(part("odd", box((0, 0, 0), (1, 1, 1))), solid=bare)
    with pytest.raises(BuildError, match=r"^odd: mesh cannot be built \(deflection 0.1 mm\)"):
        MeshLibrary([odd], 0.1, 0.5)["odd"]


def test_copies_of_a_point_are_one_and_points_farther_apart_are_not() -> None:
    """Against all distances: points on a lattice as fine as may be told apart, copied with what the kernel leaves."""
    lattice = np.array(list(product(range(5), repeat=3))) * 3e-6
    which = RNG.integers(len(lattice), size=900)
    points = lattice[which] + RNG.uniform(-1e-7, 1e-7, (900, 3))
    label, first = _same(points)
    near = np.linalg.norm(points[:, None] - points[None], axis=2) <= MERGE_MM
    assert ((label[:, None] == label[None]) == near).all()
    assert (np.diff(first) > 0).all()
    assert (label[first] == np.arange(len(first))).all()
