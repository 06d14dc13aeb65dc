"""The machine as URDF and SDF, for ROS, Gazebo and whatever reads them; inertias from the solids, meshes of the parts.

URDF knows trees alone. There the platform hangs on the base by three slides, as the parallelograms let it move, each
rod on its arm by two hinges, and the six wrists are cut: a `loop_joint` element tells each, with the point in both
links' frames. URDF wants an inertia wherever there are two hinges or slides in a row; the links between have `DUST_KG`.
SDF holds loops: a universal joint at each elbow, a ball joint at each wrist, and the platform free.

In URDF shoulders count from level, as everywhere else: its tree is closed at the shoulder angles that a comment gives,
all other joints at 0. In SDF the poses are those of home, where all joints are at 0. A rotor's inertia, which neither
format has a place for, is told in a comment with the drive's ratio.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.common.units import M_PER_MM
from delta_cad.drive import DriveReport
from delta_cad.drive.friction import IDLE_SPEED
from delta_cad.mechanism import inverse_kinematics
from delta_cad.mechanism.placement import CHAINS, SIDES

DUST_KG, DUST_KG_M2 = 1e-6, 1e-10  # of a link between two joints: a millionth of the platform, and no zero
HALF_TURN, FAR = 3.2, 0.5  # rad and m: limits of joints that other joints limit, which URDF wants to see
UPRIGHT = 1e-9  # cosine of a pitch that is a right angle but for roundings
SCALE = " ".join([repr(M_PER_MM)] * 3)  # STL files are in mm


@dataclass(frozen=True)
class Robot:
    """What both formats are made of.

    Attributes:
        assembly: The machine.
        bodies: Mass properties by link, as `mass_report` has them.
        drive: Ratio, rotor and torque at the joint.
        stops_rad: Smallest and largest shoulder angle.
        friction: Coulomb friction (N m) and damping (N m s/rad) of a joint.
    """

    assembly: Assembly
    bodies: Mapping[str, Any]
    drive: DriveReport
    stops_rad: tuple[float, float]
    friction: tuple[float, float]

    @property
    def home_m(self) -> np.ndarray:
        """(3,) position of the platform at home, m."""
        return np.asarray(self.assembly.home_mm, dtype=float) * M_PER_MM

    @property
    def home_angles(self) -> np.ndarray:
        """(3,) shoulder angles there, rad."""
        return inverse_kinematics(self.assembly.placement.geometry, self.home_m)

    @property
    def frames(self) -> Mapping[str, np.ndarray]:
        """Link -> (4, 4) frame at home, mm."""
        return self.assembly.placement(np.asarray(self.assembly.home_mm, dtype=float))

    @property
    def links(self) -> list[str]:
        """The links that both have, base first."""
        arms = [name for i in CHAINS for name in (f"upper_arm_{i}", *(f"rod_{i}_{j}" for j in SIDES))]
        return ["base", *arms, "platform"]

    def stud(self, i: int, j: int) -> np.ndarray:
        """(3,) axis of the arm's cross-bar in a rod's frame at home."""
        return self.frames[f"rod_{i}_{j}"][:3, :3].T @ self.frames[f"upper_arm_{i}"][:3, 1]

    def wrist(self, i: int, j: int) -> np.ndarray:
        """(3,) a rod's wrist in the platform's frame, m."""
        rod = self.frames[f"rod_{i}_{j}"]
        point = rod @ [self.assembly.placement.geometry.forearm_length / M_PER_MM, 0.0, 0.0, 1.0]
        return (np.linalg.inv(self.frames["platform"]) @ point)[:3] * M_PER_MM

    def told(self) -> str:
        """What neither format has a place for."""
        pinion = self.bodies.get("pinion_0", {}).get("inertia_kg_m2")
        turning = self.drive.reflected_inertia_kg_m2
        if pinion is not None:
            turning += self.drive.ratio**2 * pinion[1][1]
        return (
            f" home: platform at {_text(self.home_m)} m, shoulder angles {_text(self.home_angles)} rad; "
            f"each shoulder's rotor and pinion add {turning!r} kg m2 at the joint, ratio {self.drive.ratio!r} "
        )

    def meshes(self, link: str) -> list[tuple[str, np.ndarray, tuple[float, float, float]]]:
        """Name, placement (4, 4) in mm and colour of the made parts on a link; bought ones have no mesh."""
        return [
            (one.part.number, one.placement, one.part.material.colour)
            for one in self.assembly.occurrences
            if one.link == link and one.part.make
        ]


def urdf(robot: Robot) -> str:
    """Writes the URDF text of a machine, its loops cut at the wrists and told."""
    g, frames = robot.assembly.placement.geometry, robot.frames
    root = ET.Element("robot", name=robot.assembly.name)
    root.append(ET.Comment(robot.told()))
    for name in robot.links:
        link = ET.SubElement(root, "link", name=name)
        _urdf_inertial(link, robot.bodies[name])
        for number, at, colour in robot.meshes(name):
            visual = ET.SubElement(link, "visual")
            ET.SubElement(visual, "origin", _origin(at))
            geometry = ET.SubElement(visual, "geometry")
            ET.SubElement(geometry, "mesh", filename=f"parts/{number}.stl", scale=SCALE)
            material = ET.SubElement(visual, "material", name=f"colour_{number}")
            ET.SubElement(material, "color", rgba=_text([*colour, 1.0]))
    torque, (coulomb, viscous) = robot.drive.controlled_torque_N_m, robot.friction
    for i in CHAINS:
        arm = f"upper_arm_{i}"
        level = frames[arm].copy()
        level[:3, :3] = level[:3, :3] @ _about_y(robot.home_angles[i])
        low, high = robot.stops_rad
        limit = (low, high, torque, IDLE_SPEED / robot.drive.ratio)
        joint = _urdf_joint(root, f"shoulder_{i}", "revolute", "base", arm, _relative(frames["base"], level), limit)
        ET.SubElement(joint, "axis", xyz="0 -1 0")
        ET.SubElement(joint, "dynamics", damping=repr(viscous), friction=repr(coulomb))
        for j in SIDES:
            rod, between = f"rod_{i}_{j}", f"elbow_{i}_{j}"
            _dust(root, between)
            free = (-HALF_TURN, HALF_TURN, 0.0, 1e3)
            at = _relative(frames[arm], frames[rod])
            swing = _urdf_joint(root, f"{between}_swing", "revolute", arm, between, at, free)
            ET.SubElement(swing, "axis", xyz=_text(robot.stud(i, j)))
            lean = _urdf_joint(root, f"{between}_lean", "revolute", between, rod, np.eye(4), free)
            ET.SubElement(lean, "axis", xyz="0 0 1")
    above = "base"
    for k, axis in enumerate("xyz"):
        below = "platform" if axis == "z" else f"slide_{axis}"
        if axis != "z":
            _dust(root, below)
        at = _relative(frames["base"], frames["platform"]) if k == 0 else np.eye(4)
        slide = _urdf_joint(root, f"platform_{axis}", "prismatic", above, below, at, (-FAR, FAR, 0.0, 1e2))
        ET.SubElement(slide, "axis", xyz=_text(np.eye(3)[k]))
        above = below
    root.append(
        ET.Comment(" the cut joints: balls at the wrists, the same point of both links; simulators close them ")
    )
    for i in CHAINS:
        for j in SIDES:
            loop = ET.SubElement(root, "loop_joint", name=f"wrist_{i}_{j}", type="ball")
            ET.SubElement(loop, "link1", link=f"rod_{i}_{j}", xyz=_text([g.forearm_length, 0.0, 0.0]), rpy="0 0 0")
            ET.SubElement(loop, "link2", link="platform", xyz=_text(robot.wrist(i, j)), rpy="0 0 0")
    for i in CHAINS:
        transmission = ET.SubElement(root, "transmission", name=f"drive_{i}")
        ET.SubElement(transmission, "type").text = "transmission_interface/SimpleTransmission"
        ET.SubElement(transmission, "joint", name=f"shoulder_{i}")
        actuator = ET.SubElement(transmission, "actuator", name=f"motor_{i}")
        ET.SubElement(actuator, "mechanicalReduction").text = repr(float(robot.drive.ratio))
    ET.indent(root)
    return '<?xml version="1.0"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def sdf(robot: Robot) -> str:
    """Writes the SDF text of a machine, its loops closed, at home."""
    g, frames = robot.assembly.placement.geometry, robot.frames
    root = ET.Element("sdf", version="1.7")
    model = ET.SubElement(root, "model", name=robot.assembly.name)
    model.append(ET.Comment(robot.told()))
    world = ET.SubElement(model, "joint", name="fixed_to_world", type="fixed")
    ET.SubElement(world, "parent").text = "world"
    ET.SubElement(world, "child").text = "base"
    for name in robot.links:
        link = ET.SubElement(model, "link", name=name)
        ET.SubElement(link, "pose").text = _pose(frames[name])
        body = robot.bodies[name]
        inertial = ET.SubElement(link, "inertial")
        ET.SubElement(inertial, "pose").text = f"{_text(body['centre_m'])} 0 0 0"
        ET.SubElement(inertial, "mass").text = repr(float(body["mass_kg"]))
        inertia = ET.SubElement(inertial, "inertia")
        for key, value in _moments(body).items():
            ET.SubElement(inertia, key).text = value
        for n, (number, at, colour) in enumerate(robot.meshes(name)):
            visual = ET.SubElement(link, "visual", name=f"{number}_{n}")
            ET.SubElement(visual, "pose").text = _pose(at)
            mesh = ET.SubElement(ET.SubElement(visual, "geometry"), "mesh")
            ET.SubElement(mesh, "uri").text = f"parts/{number}.stl"
            ET.SubElement(mesh, "scale").text = SCALE
            material = ET.SubElement(visual, "material")
            ET.SubElement(material, "diffuse").text = _text([*colour, 1.0])
    coulomb, viscous = robot.friction
    for i in CHAINS:
        arm, home = f"upper_arm_{i}", robot.home_angles[i]
        low, high = (stop - home for stop in robot.stops_rad)
        axis = _sdf_joint(model, f"shoulder_{i}", "revolute", "base", arm, ("axis", np.array([0.0, -1.0, 0.0])))[0]
        limit, dynamics = ET.SubElement(axis, "limit"), ET.SubElement(axis, "dynamics")
        numbers = {"lower": low, "upper": high, "effort": robot.drive.controlled_torque_N_m}
        for key, value in (numbers | {"velocity": IDLE_SPEED / robot.drive.ratio}).items():
            ET.SubElement(limit, key).text = repr(float(value))
        ET.SubElement(dynamics, "damping").text = repr(viscous)
        ET.SubElement(dynamics, "friction").text = repr(coulomb)
        for j in SIDES:
            rod = f"rod_{i}_{j}"
            axes = ("axis", robot.stud(i, j)), ("axis2", np.array([0.0, 0.0, 1.0]))
            _sdf_joint(model, f"elbow_{i}_{j}", "universal", arm, rod, *axes)
            wrist = ET.SubElement(model, "joint", name=f"wrist_{i}_{j}", type="ball")
            ET.SubElement(wrist, "parent").text = "platform"
            ET.SubElement(wrist, "child").text = rod
            ET.SubElement(wrist, "pose").text = f"{_text([g.forearm_length, 0.0, 0.0])} 0 0 0"
    ET.indent(root)
    return '<?xml version="1.0"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def _urdf_inertial(link: ET.Element, body: Mapping[str, Any]) -> None:
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=_text(body["centre_m"]), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=repr(float(body["mass_kg"])))
    ET.SubElement(inertial, "inertia", _moments(body))


def _dust(root: ET.Element, name: str) -> None:
    """A link between two joints."""
    inertia = (np.eye(3) * DUST_KG_M2).tolist()
    body = {"centre_m": [0.0] * 3, "mass_kg": DUST_KG, "inertia_kg_m2": inertia}
    _urdf_inertial(ET.SubElement(root, "link", name=name), body)


def _urdf_joint(
    root: ET.Element, name: str, kind: str, parent: str, child: str, at: np.ndarray, limit: Sequence[float]
) -> ET.Element:
    joint = ET.SubElement(root, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    ET.SubElement(joint, "origin", _origin(at))
    names = ("lower", "upper", "effort", "velocity")
    ET.SubElement(joint, "limit", {key: repr(float(value)) for key, value in zip(names, limit, strict=True)})
    return joint


def _sdf_joint(
    model: ET.Element, name: str, kind: str, parent: str, child: str, *axes: tuple[str, np.ndarray]
) -> list[ET.Element]:
    """A joint in its child's frame, and its axes."""
    joint = ET.SubElement(model, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent").text = parent
    ET.SubElement(joint, "child").text = child
    made = []
    for key, direction in axes:
        made.append(ET.SubElement(joint, key))
        ET.SubElement(made[-1], "xyz").text = _text(direction)
    return made


def _moments(body: Mapping[str, Any]) -> dict[str, str]:
    """The six moments of inertia about the centre, in the link's axes."""
    inertia, names = body["inertia_kg_m2"], "xyz"
    pairs = [(a, b) for a in range(3) for b in range(a, 3)]
    return {f"i{names[a]}{names[b]}": repr(float(inertia[a][b])) for a, b in pairs}


def _about_y(angle: float) -> np.ndarray:
    """Turn that takes an arm at an angle back to level: arms turn about -y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _relative(parent: np.ndarray, child: np.ndarray) -> np.ndarray:
    return np.linalg.inv(parent) @ child


def _angles(frame: np.ndarray) -> np.ndarray:
    """Roll, pitch and yaw about fixed axes, as both formats have them."""
    r = frame[:3, :3]
    level = np.hypot(r[0, 0], r[1, 0])
    pitch = np.arctan2(-r[2, 0], level)
    if level < UPRIGHT:  # roll and yaw turn about the same line: one of them does for both
        return np.array([np.arctan2(-r[1, 2], r[1, 1]), pitch, 0.0])
    return np.array([np.arctan2(r[2, 1], r[2, 2]), pitch, np.arctan2(r[1, 0], r[0, 0])])


def _origin(frame: np.ndarray) -> dict[str, str]:
    return {"xyz": _text(frame[:3, 3] * M_PER_MM), "rpy": _text(_angles(frame))}


def _pose(frame: np.ndarray) -> str:
    return f"{_text(frame[:3, 3] * M_PER_MM)} {_text(_angles(frame))}"


def _text(values: Sequence[float] | np.ndarray) -> str:
    """Numbers that read back to the last bit."""
    return " ".join(repr(float(value)) for value in values)
