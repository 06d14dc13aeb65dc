"""Lengths and axes of the exported STEP, read by gmsh's own kernel.

65 s of processor: the one whole build of the tests' machine, which some twenty other files read.
"""

from __future__ import annotations

from math import cos, degrees, sin
from pathlib import Path

import gmsh
import numpy as np
import pytest

from delta_cad.dimensions import Dimensions
from tests.committed import Built
from tests.delta_cad.solids.measured import UM, axis_distance

LOOKED_AT = {
    *("joint_ball", "cup_shell", "cross_bar"),
    *("upper_arm", "platform", "motor", "pinion"),
}


@pytest.fixture(scope="module")
def exported(built: Built) -> dict[str, list[list[tuple[str, np.ndarray, np.ndarray, float]]]]:
    """Part number -> one list a solid of (kind, point, direction, diameter) of its spheres and cylinders.

    Spheres and axes are fitted to points and normals of the faces: nothing of the writer's numbers enters.
    """
    return read(built.folder / "assembly.step", LOOKED_AT)


def read(path: Path, numbers: set[str]) -> dict[str, list[list[tuple[str, np.ndarray, np.ndarray, float]]]]:
    gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
        gmsh.model.add("read")
        solids = [tag for _, tag in gmsh.model.occ.importShapes(str(path))]
        gmsh.model.occ.synchronize()
        found: dict[str, list[list[tuple[str, np.ndarray, np.ndarray, float]]]] = {}
        for tag in solids:
            number = gmsh.model.getEntityName(3, tag).split("/")[-1]
            if number not in numbers:
                continue
            faces = gmsh.model.getBoundary([(3, tag)], oriented=False)
            found.setdefault(number, []).append([fit for _, face in faces if (fit := fitted(face))])
        return found
    finally:
        gmsh.finalize()


def fitted(face: int) -> tuple[str, np.ndarray, np.ndarray, float] | None:
    kind = gmsh.model.getType(2, face)
    if kind not in ("Sphere", "Cylinder"):
        return None
    low, high = gmsh.model.getParametrizationBounds(2, face)
    u, v = np.meshgrid(np.linspace(low[0], high[0], 8)[1:-1], np.linspace(low[1], high[1], 6)[1:-1])
    at = np.stack([u.ravel(), v.ravel()], axis=1).ravel().tolist()
    points = np.array(gmsh.model.getValue(2, face, at)).reshape(-1, 3)
    normals = np.array(gmsh.model.getNormal(face, at)).reshape(-1, 3)
    if kind == "Sphere":
        direction, project = np.zeros(3), np.eye(3)
    else:
        direction = np.linalg.svd(normals)[2][2]
        project = np.eye(3) - np.outer(direction, direction)
    # all normals' lines meet the centre (or the axis): least squares of (I - n n^T) (c - p) = 0 across the axis
    middle = points.mean(axis=0)
    across = np.array([np.eye(3) - np.outer(n, n) for n in normals]) @ project
    right = np.einsum("kab,kb->ka", across, points - middle).ravel()
    centre = middle + project @ np.linalg.lstsq(across.reshape(-1, 3), right, rcond=1e-9)[0]
    radius = np.linalg.norm((points - centre) @ project, axis=1)
    assert np.ptp(radius) < 1e-9
    return kind, centre, direction, 2 * float(radius.mean())


Exported = dict[str, list[list[tuple[str, np.ndarray, np.ndarray, float]]]]


def centres(exported: Exported, number: str, diameter: float) -> np.ndarray:
    """(n, 3) the one sphere centre of each solid of a part."""
    found = []
    for solid in exported[number]:
        seen = [c for kind, c, _, d in solid if kind == "Sphere" and abs(d - diameter) < 1e-6]
        assert seen
        assert np.linalg.norm(np.ptp(seen, axis=0)) < 1e-6
        found.append(seen[0])
    return np.array(found)


def axes(exported: Exported, number: str, diameter: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """The one axis of a diameter of each solid of a part."""
    found = []
    for solid in exported[number]:
        seen = [(c, e) for kind, c, e, d in solid if kind == "Cylinder" and abs(d - diameter) < 1e-6]
        assert seen
        for other in seen[1:]:
            assert max(axis_distance(seen[0], other)) < 1e-6
        found.append(seen[0])
    return found


def chain_of(point: np.ndarray) -> int:
    return round(degrees(np.arctan2(point[1], point[0])) / 120) % 3


def test_links_of_the_exported_step_have_the_design_s_lengths(exported: Exported, best_dimensions: Dimensions) -> None:
    m, cube = best_dimensions.design.mechanism, best_dimensions.design.cube
    home = np.array([0.0, 0.0, cube.bottom_height_mm + cube.half_side_mm])
    balls = centres(exported, "joint_ball", best_dimensions.forearm.ball_diameter_mm)
    seat = best_dimensions.forearm.seat_diameter_mm
    seats = centres(exported, "cup_shell", seat)
    assert balls.shape == seats.shape == (12, 3)
    apart = np.linalg.norm(balls[:, None] - seats[None], axis=-1)
    assert (apart.min(axis=1) < UM).all()
    assert sorted(apart.argmin(axis=1)) == list(range(12))
    shafts = axes(exported, "upper_arm", best_dimensions.arm.shaft_bore_mm)
    bars = axes(exported, "upper_arm", best_dimensions.arm.bar_bore_mm)
    assert len(shafts) == 3
    for i in range(3):
        u, t = (
            np.array([cos(2 * i * np.pi / 3), sin(2 * i * np.pi / 3), 0]),
            np.array([-sin(2 * i * np.pi / 3), cos(2 * i * np.pi / 3), 0]),
        )
        mine = [
            b
            for b in balls
            if abs(abs(b @ t) - m.parallelogram_width_mm / 2) < UM and b @ u > 0 and chain_of(b - (b @ t) * t) == i
        ]
        wrists = [b for b in mine if abs(b[2] - home[2]) < UM]
        elbows = [b for b in mine if abs(b[2] - home[2]) >= UM]
        assert len(wrists) == len(elbows) == 2
        for side in (-1, 1):
            (elbow,) = [b for b in elbows if side * (b @ t) > 0]
            (wrist,) = [b for b in wrists if side * (b @ t) > 0]
            assert np.linalg.norm(wrist - elbow) == pytest.approx(m.forearm_length_mm, abs=UM)
            assert (wrist - home) @ u == pytest.approx(m.platform_radius_mm, abs=UM)
        (k,) = [k for k, (p, e) in enumerate(shafts) if abs(e @ t) > 1 - 1e-9 and p @ u > 0]
        point, _ = shafts[k]
        assert point @ u == pytest.approx(m.base_radius_mm, abs=UM)
        assert abs(point[2]) < UM
        distance, sine = axis_distance((point, t), bars[k])
        assert distance == pytest.approx(m.upper_arm_length_mm, abs=UM)
        assert sine < 1e-9
        elbow = (elbows[0] + elbows[1]) / 2
        assert np.linalg.norm(np.cross(elbow - bars[k][0], t)) < UM  # the balls sit on the cross-bar's axis
        assert np.linalg.norm(elbow - m.base_radius_mm * u) == pytest.approx(m.upper_arm_length_mm, abs=UM)


def test_pinions_of_the_exported_step_sit_on_their_motors(exported: Exported, best_dimensions: Dimensions) -> None:
    bore = best_dimensions.motor.shaft_diameter_mm
    motors, pinions = axes(exported, "motor", bore), axes(exported, "pinion", bore)
    assert len(motors) == len(pinions) == 3
    for motor in motors:
        assert min(max(axis_distance(motor, pinion)) for pinion in pinions) < UM
