"""The calibration fixture: its poses, that the stem's edge lies in its cones, that it stands clear, its files."""

from __future__ import annotations

import json
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.commands.cli import main
from delta_cad.design import Design, design_from_dict
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.export.shop.fixture import COLUMN_MM, LEVELS, Seats, fixture_parts, seats_of
from delta_cad.mechanism import GeometryError, forward_kinematics
from haptics.calibration.accuracy import accuracy
from haptics.calibration.fit import Noise, fit, poses_needed
from haptics.calibration.poses import load_poses
from tests.committed import BEST, ROOT
from tests.delta_cad.export.shop.quoted import check_quotation
from tests.haptics.calibration.devices import made, measured


@pytest.fixture(scope="module")
def seats(best_dimensions: Dimensions) -> Seats:
    return seats_of(best_dimensions)


@pytest.mark.parametrize("machine", ["best", "placed"])
def test_poses_lie_in_the_cube_and_are_enough(machine: str, request: pytest.FixtureRequest) -> None:
    d: Dimensions = request.getfixturevalue(f"{machine}_dimensions")
    cube, seats = d.design.cube, seats_of(d)
    middle = np.array([0.0 if machine == "best" else 11.1, 0.0, cube.bottom_height_mm + cube.half_side_mm])
    assert np.abs(seats.poses_mm - middle).max() < cube.half_side_mm - 2.0
    assert len(seats.poses_mm) >= poses_needed(own_frame=True)
    apart = np.linalg.norm(seats.places_mm[:, None] - seats.places_mm, axis=-1) + 1e3 * np.eye(len(seats.places_mm))
    assert apart.min() > seats.mouth_mm + 4.0


def levels(seats: Seats, plate: cq.Solid, bench: float) -> list[cq.Solid]:
    """The plate as it stands on columns and spacers, level by level."""
    return [
        plate.translate(cq.Vector(0, 0, bench + seats.column_mm + level * seats.spacer_mm)) for level in range(LEVELS)
    ]


def test_the_stems_edge_lies_on_the_cones_at_every_pose(
    best_dimensions: Dimensions, best_assembly: Assembly, seats: Seats
) -> None:
    """The edge is the made stem's, placed by the assembly; the plate stands on the heights of column and spacers."""
    plate, column, spacer = (part.solid for part in fixture_parts(seats))
    assert column.BoundingBox().zmax - 8.0 == pytest.approx(seats.column_mm, abs=1e-6)
    assert spacer.BoundingBox().zmax - 8.0 == pytest.approx(seats.spacer_mm, abs=1e-6)
    (stem,) = [one for one in best_assembly.occurrences if one.part.number == "handle_stem"]
    shoulder = max(e.Center().z for e in stem.part.solid.Edges() if e.geomType() == "CIRCLE" and e.radius() > 4.9)
    (base,) = [one for one in best_assembly.occurrences if one.part.number == "base_plate"]
    bench = base.part.solid.BoundingBox().zmin + base.placement[2, 3]
    static = levels(seats, plate, bench)
    radius = best_dimensions.platform.stem_diameter_mm / 2
    for n, pose in enumerate(seats.poses_mm):
        if n % 5:
            continue
        lies = best_assembly.placement(pose)["platform"] @ stem.placement
        for angle in np.radians([10.0, 130.0, 250.0]):
            point = lies @ [radius * np.cos(angle), radius * np.sin(angle), shoulder, 1.0]
            touch = static[n // 7].distance(cq.Vertex.makeVertex(*point[:3]))
            inside = static[n // 7].isInside(cq.Vector(*(point[:3] - [0.0, 0.0, 0.01])))
            assert touch < 1e-6
            assert not inside


@pytest.mark.slow
@pytest.mark.parametrize(("machine", "azimuths"), [("best", (0.0, 120.0, 240.0)), ("placed", (0.0, 116.3, 243.7))])
def test_it_stands_clear_of_the_machine(
    machine: str, azimuths: tuple[float, ...], request: pytest.FixtureRequest
) -> None:
    import trimesh

    d: Dimensions = request.getfixturevalue(f"{machine}_dimensions")
    assembly: Assembly = request.getfixturevalue(f"{machine}_assembly")
    seats = seats_of(d)
    points: dict[str, list[np.ndarray]] = {}
    for one in assembly.occurrences:
        if one.part.number in ("handle_stem", "boot_collar", knob_of(assembly)):
            continue  # the stem stands in the seat, the knob and the boot under it are off
        vertices, faces = one.part.solid.tessellate(0.5, 0.5)
        mesh = [np.array([v.toTuple() for v in vertices]), np.array(faces)]
        fine, _ = trimesh.remesh.subdivide_to_size(mesh[0], mesh[1], 8.0, max_iter=20)
        points.setdefault(one.link, []).append(fine @ one.placement[:3, :3].T + one.placement[:3, 3])
    cloud = {link: np.vstack(many) for link, many in points.items()}
    bench = d.base.top_mm - d.base.thickness_mm
    angles = np.radians(np.array([azimuths[0] + azimuths[1], azimuths[1] + azimuths[2], azimuths[2] + 360.0]) / 2)
    columns = seats.column_radius_mm * np.column_stack([np.cos(angles), np.sin(angles)])
    least = [np.inf, np.inf]
    for n in range(len(seats.poses_mm)):
        frames = assembly.placement(seats.poses_mm[n])
        under = bench + seats.column_mm + (n // 7) * seats.spacer_mm
        for link, many in cloud.items():
            placed = many @ frames[link][:3, :3].T + frames[link][:3, 3]
            least[0] = min(least[0], under - placed[:, 2].max())
            adjacent = np.linalg.norm(placed[:, None, :2] - columns, axis=-1).min() - COLUMN_MM / 2
            least[1] = min(least[1], float(adjacent))
    assert min(least) > 5.0 + 1.0, least  # points of a mesh of 8 mm are at most 4.7 from any other; its chords 0.5


def knob_of(assembly: Assembly) -> str:
    (knob,) = {one.part.number for one in assembly.occurrences if one.name == "knob"}
    return knob


def test_the_command_writes_parts_drawings_and_poses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fixture", "--design", str(BEST), "--out", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["faults"] == {}
    (folder,) = tmp_path.iterdir()
    names = {
        f"calibration_{part}.{kind}" for part in ("plate", "column", "spacer") for kind in ("step", "pdf", "svg", "dxf")
    }
    others = {"poses.csv", "calibration_plate.profile.dxf", "quotation.zip"}
    assert {path.name for path in folder.glob("[!.]*")} == names | others
    check_quotation(folder)
    step = cq.importers.importStep(str(folder / "calibration_plate.step"))
    (solid,) = step.solids().vals()
    cones = [f for f in solid.Faces() if f.geomType() == "CONE"]  # type: ignore[union-attr]
    assert len(cones) == 7
    # the poses left as they are calibrate to the machine as drawn
    poses = load_poses(folder / "poses.csv")
    from delta_cad.design import load_design

    geometry = load_design(BEST).geometry
    np.testing.assert_allclose(forward_kinematics(geometry, poses.readings), poses.positions, atol=1e-6)
    found = fit(geometry, poses, own_frame=True)
    assert found.after.max() < 1e-6


def test_its_poses_calibrate_the_whole_cube(best: Design, seats: Seats) -> None:
    """Within the limit of `calibrate`, measured with the noise that it assumes, the plate's frame fitted."""
    rng = np.random.default_rng(1)
    poses = measured(made(best, rng), seats.poses_mm / 1e3, rng)
    found = fit(best.geometry, poses, noise=Noise(0.02e-3, 5e-5), own_frame=True)
    assert accuracy(found, best).worst < 0.1e-3


def test_a_cube_too_low_for_three_levels_is_refused(best_dimensions: Dimensions) -> None:
    design = best_dimensions.design
    low = design.model_copy(update={"cube": design.cube.model_copy(update={"half_side_mm": 12.0})})
    with pytest.raises(GeometryError, match="too low"):
        seats_of(dimensions(low))


@pytest.mark.parametrize(
    ("radii", "phi", "wrist"), [((48.203, 31.228), 123.0, 20.404), ((25.576, 41.674), 120.7315, 19.109)]
)
def test_columns_stand_clear_of_the_motors_and_their_leads(
    radii: tuple[float, float], phi: float, wrist: float
) -> None:
    """By the kernel: a column and each motor as a cylinder, lengthened by its leads."""
    raw = json.loads((ROOT / "best.json").read_text())
    out, side = radii
    raw["mechanism"] |= {"base_radius_mm": out, "base_radii_mm": [out, side, side], "azimuths_deg": [0, phi, -phi]}
    raw["mechanism"]["platform_radius_mm"] = wrist
    d = dimensions(design_from_dict(raw))
    seats, (u, z) = seats_of(d), d.bracket.motor_axis_mm
    behind = max((behind for leads in d.leads for _, behind in leads.outside_mm), default=0.0)
    for i, azimuth in enumerate(np.radians([0.0, phi, -phi])):
        radial, along = np.array([np.cos(azimuth), np.sin(azimuth)]), np.array([-np.sin(azimuth), np.cos(azimuth)])
        start = (u + (0.0, side - out, side - out)[i]) * radial + d.layers.motor_face_mm * along
        motor = cq.Solid.makeCylinder(
            d.motor.diameter_mm / 2.0,
            d.motor.length_mm + behind,
            cq.Vector(*start, z),
            cq.Vector(*along, 0.0),
        )
        for angle in seats.columns_rad:
            foot = cq.Vector(seats.column_radius_mm * np.cos(angle), seats.column_radius_mm * np.sin(angle), -200.0)
            column = cq.Solid.makeCylinder(COLUMN_MM / 2.0, 400.0, foot, cq.Vector(0, 0, 1))
            assert motor.distance(column) > 5.99
