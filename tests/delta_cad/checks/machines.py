"""A simple delta joystick of boxes, cylinders and spheres on the real placement, to be spoiled by the tests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import cadquery as cq
import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.clearance.clearance import CALLS_MAX, mesh_clearance, with_exact
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.placement import CHAINS, SIDES, LinkPlacement, chain_stand, chain_turn
from delta_cad.solids.part import Contact, Fit, Hole, Joint, Material, Occurrence, Part, Stop

GEOMETRY = DeltaGeometry(base_radius=0.040, platform_radius=0.030, upper_arm_length=0.082, forearm_length=0.112079)
PLACED = replace(GEOMETRY, side_shift=0.006, side_cosine=float(np.cos(np.radians(116.0))))
L_A, L_B, R, RADIUS_PLATFORM, WIDTH = 82.0, 112.079, 40.0, 30.0, 54.0
PINION = (40.0, -43.5)
STEEL = Material("steel", 7850.0, (0.6, 0.6, 0.6))
LIMITS = CheckLimits(
    bottom_height_mm=57.112,
    half_side_mm=37.5,
    envelope_width_mm=270.0,
    envelope_depth_mm=220.0,
    grid=5,
    random_poses=40,
)
PLACED_LIMITS = replace(LIMITS, half_side_mm=33.0, bottom_height_mm=61.0, centre_x_mm=6.0)
"""Of the same chains in other places: one radius is longer by 6 mm, the azimuths are 116 deg, the cube is aside."""


EDGE = np.array([60.0 - R, -64.0])  # of the plate, seen from the shoulder of chain 0
STOP_RAD = np.arctan2(EDGE[1], EDGE[0]) + np.arcsin(6.0 / np.linalg.norm(EDGE))  # the arm's lower face lies on it
STOP = Stop("shoulder_0", "base_plate", "arm_0", float(STOP_RAD), -1, 7.9)


def placement(drive_ratio: float = 9.5, geometry: DeltaGeometry = GEOMETRY) -> LinkPlacement:
    return LinkPlacement(geometry, WIDTH, PINION if drive_ratio != 1.0 else (R, 0.0), drive_ratio)


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    frame = np.eye(4)
    frame[:3, 3] = x, y, z
    return frame


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> cq.Solid:
    return cq.Solid.makeBox(*(b - a for a, b in zip(low, high, strict=True)), pnt=cq.Vector(*low))


def rod(radius: float, start: tuple[float, float, float], end: tuple[float, float, float]) -> cq.Solid:
    a, b = cq.Vector(*start), cq.Vector(*end)
    return cq.Solid.makeCylinder(radius, (b - a).Length, a, (b - a).normalized())


def ball(radius: float, centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> cq.Solid:
    return cq.Solid.makeSphere(radius, cq.Vector(*centre), angleDegrees1=-90, angleDegrees2=90)


def solid(shape: cq.Shape) -> cq.Solid:
    (one,) = shape.Solids()
    return one


def part(number: str, shape: cq.Shape, holes: tuple[Hole, ...] = ()) -> Part:
    return Part(number, number, solid(shape), STEEL, True, holes)


@cache
def parts() -> dict[str, Part]:
    plate = box((-60, -60, -72), (60, 60, -64))
    for x in (-50, 50):
        for y in (-50, 50):
            plate = plate.cut(rod(1.25, (x, y, -73), (x, y, -63)))
    bracket = box((30, -22, -64), (50, -15, 12)).cut(rod(8, (40, -23, 0), (40, -14, 0)))
    arm = box((9, -4, -6), (77, 4, 6)).fuse(rod(11, (0, -4, 0), (0, 4, 0))).cut(rod(4, (0, -5, 0), (0, 5, 0)))
    sector = rod(34, (0, 5, 0), (0, 10, 0)).cut(box((-40, 4, -3), (40, 11, 40))).cut(rod(12, (0, 4, 0), (0, 11, 0)))
    sector = sector.fuse(box((15, 4, -6), (30, 5.5, -3.5)))  # seat on the arm
    motor = rod(15, (0, 14, 0), (0, 60, 0)).fuse(box((-5, 16, -20.5), (5, 24, -5)))  # stands on the plate
    elbow_bar = rod(3, (L_A, -WIDTH / 2 + 9.75, 0), (L_A, WIDTH / 2 - 9.75, 0))
    wrist_bar = rod(3, (RADIUS_PLATFORM, -WIDTH / 2 + 9.75, 0), (RADIUS_PLATFORM, WIDTH / 2 - 9.75, 0))
    elbow_bar = elbow_bar.fuse(box((77, -3, -2), (L_A, 3, 2)))
    wrist_bar = wrist_bar.fuse(box((24, -3, -2), (RADIUS_PLATFORM, 3, 2)))
    socket = rod(5.5, (-4, 0, 0), (12, 0, 0)).cut(ball(4.05))
    for side in (-1, 1):  # open for the stud's neck to 30 degrees
        socket = socket.cut(rod(5, (0, side * 2.2, 0), (0, side * 6, 0)))
    stud = ball(4).fuse(rod(1.5, (0, 0, 0), (0, -9.75, 0)))
    tube = rod(2.5, (12, 0, 0), (L_B - 12, 0, 0)).cut(rod(1.5, (11, 0, 0), (L_B - 11, 0, 0)))
    return {
        p.number: p
        for p in (
            part("base_plate", plate, (Hole(2.5, 4, "M3"),)),
            part("bracket", bracket, (Hole(16.0, 1, "16 H7"),)),
            part("arm", arm, (Hole(8.0, 1, "8 H7"),)),
            part("sector", sector),
            part("shaft", rod(4, (0, -22, 0), (0, 22, 0))),
            part(
                "bearing",
                rod(8, (0, -22, 0), (0, -15, 0)).cut(rod(4, (0, -23, 0), (0, -14, 0))),
                (Hole(8.0, 1, "shaft"),),
            ),
            part("pinion", rod(7.6, (0, 4, 0), (0, 11, 0)).fuse(rod(3, (0, -2, 0), (0, 4, 0)))),
            part("motor", motor),
            part("elbow_bar", elbow_bar),
            part("socket", socket, (Hole(10.0, 1, "stud"),)),
            part("stud", stud),
            part("tube", tube, (Hole(3.0, 1, "through"),)),
            part("platform", rod(24, (0, 0, -5), (0, 0, 5))),
            part("wrist_bar", wrist_bar),
            part("screw", rod(1.25, (0, 0, 0), (0, 0, 8)).fuse(rod(2.75, (0, 0, -3), (0, 0, 0)))),
        )
    }


def machine(drive_ratio: float = 9.5, extra_screws: int = 0, geometry: DeltaGeometry = GEOMETRY) -> Assembly:
    p = parts()
    flip = np.diag([-1.0, -1.0, 1.0, 1.0])  # turns a stud to the other side
    mirror = at(L_B) @ np.diag([-1.0, -1.0, 1.0, 1.0])  # the wrist's socket
    out = [Occurrence("base_plate", p["base_plate"], "base", np.eye(4))]
    joints, fits = [], []
    for k, (x, y) in enumerate([(-50, -50), (-50, 50), (50, -50), (50, 50)]):
        out.append(Occurrence(f"screw_{k}", p["screw"], "base", at(x, y, -72)))
    for k in range(extra_screws):
        out.append(
            Occurrence(f"extra_screw_{k}", p["screw"], "base", at(7.0 * (k % 10) - 30, 7.0 * (k // 10) - 20, -90))
        )
    for i in CHAINS:
        stand, chain = chain_stand(geometry, i), chain_turn(geometry, i)
        out += [
            Occurrence(f"bracket_{i}", p["bracket"], "base", stand),
            Occurrence(f"bearing_{i}", p["bearing"], "base", stand @ at(R)),
            Occurrence(f"motor_{i}", p["motor"], "base", stand @ at(PINION[0], 0.0, PINION[1])),
            Occurrence(f"pinion_{i}", p["pinion"], f"pinion_{i}", np.eye(4)),
            Occurrence(f"arm_{i}", p["arm"], f"upper_arm_{i}", np.eye(4)),
            Occurrence(f"shaft_{i}", p["shaft"], f"upper_arm_{i}", np.eye(4)),
            Occurrence(f"elbow_bar_{i}", p["elbow_bar"], f"upper_arm_{i}", np.eye(4)),
            Occurrence(f"sector_{i}", p["sector"], f"upper_arm_{i}", np.eye(4)),
            Occurrence(f"wrist_bar_{i}", p["wrist_bar"], "platform", chain),
        ]
        fits += [
            Fit(f"shaft_{i}", f"bearing_{i}", "contact", overlap_mm3=0.01, reason="shaft in its bearing"),
            Fit(f"sector_{i}", f"pinion_{i}", "running gap", gap_mm=0.5, reason="cable drive"),
            Fit(f"arm_{i}", f"bracket_{i}", "running gap", gap_mm=0.5, reason="side by side"),
        ]
        joints.append(Joint(f"shoulder_{i}", "revolute", "base", f"upper_arm_{i}", stand @ at(R), np.eye(4)))
        for j in SIDES:
            y, side = (j - 0.5) * WIDTH, np.eye(4) if j else flip
            link = f"rod_{i}_{j}"
            out += [
                Occurrence(f"tube_{i}_{j}", p["tube"], link, np.eye(4)),
                Occurrence(f"socket_{i}_{j}_elbow", p["socket"], link, np.eye(4)),
                Occurrence(f"socket_{i}_{j}_wrist", p["socket"], link, mirror),
                Occurrence(f"stud_{i}_{j}_elbow", p["stud"], f"upper_arm_{i}", at(L_A, y) @ side),
                Occurrence(f"stud_{i}_{j}_wrist", p["stud"], "platform", chain @ at(RADIUS_PLATFORM, y) @ side),
            ]
            for end, holder, frame, x in (
                ("elbow", f"upper_arm_{i}", at(L_A, y), 0.0),
                ("wrist", "platform", chain @ at(RADIUS_PLATFORM, y), L_B),
            ):
                fits.append(
                    Fit(f"socket_{i}_{j}_{end}", f"stud_{i}_{j}_{end}", "contact", overlap_mm3=0.01, reason="ball")
                )
                limit = np.radians(30.0)
                joints.append(Joint(f"{end}_{i}_{j}", "ball", holder, link, frame, at(x), limit))
    out.append(Occurrence("platform", p["platform"], "platform", np.eye(4)))
    touching = tuple(_contact(f) for f in fits if f.kind == "contact")
    where = placement(drive_ratio, geometry)
    parts_ = tuple(out), tuple(joints), tuple(fits)
    return Assembly("synthetic", *parts_, where, LIMITS.centre_mm, touching, (STOP,))


def _contact(fit: Fit) -> Contact:
    """What holds in a fit: 7 mm of the shaft in its bearing, a zone of the ball in its socket."""
    if fit.reason == "ball":
        return Contact(fit.b, fit.a, "ball", 60.0, 0.06, fit.reason)
    return Contact(fit.a, fit.b, "cylinder", 7.0, 0.01, fit.reason)


def changed(assembly: Assembly, name: str, **changes: object) -> Assembly:
    """The assembly with one occurrence changed."""
    assert any(o.name == name for o in assembly.occurrences)
    return replace(
        assembly, occurrences=tuple(replace(o, **changes) if o.name == name else o for o in assembly.occurrences)
    )


def check_clearance(
    assembly: Assembly,
    limits: CheckLimits,
    meshes: Meshes,
    progress: Callable[[str], None] = lambda _: None,
    calls_max: int = CALLS_MAX,
) -> list[CheckResult]:
    """The clearance of a machine, that of the exact solids included."""
    return with_exact(assembly, mesh_clearance(assembly, limits, meshes, progress, calls_max))
