"""The machine for simulators, from one graph of its joints: MJCF for MuJoCo, URDF and SDF for ROS, Gazebo and others.

Inertias are those of the solids. A spring's mass is halved upon its rods; the springs across a pair hold its rods from
turning about themselves, which the ball joints alone would let them: with their centres beside their axes they would
hang down. So each rod swings about its stud and leans square to it, and the platform slides without turning.

MJCF: each upper arm has the rotor's and pinion's inertia as its armature, and each rod is connected to the platform. At
`qpos = 0` every chain is closed, so the file loads without a solve; joint angles count from home. Shapes are for the
eye only: nothing collides.

URDF knows trees alone. There the platform hangs on the base by three slides and the six wrists are cut: a `loop_joint`
element states each, with the point in both links' frames. URDF wants an inertia wherever there are two hinges or slides
in a row; the links between have `DUST_KG`. Shoulders count from level, as everywhere else: its tree is closed at the
shoulder angles that a comment gives, all other joints at 0.

SDF holds loops: a universal joint at each elbow, a ball joint at each wrist, and the platform free. The poses are those
of home, where all joints are at 0. A rotor's inertia, which neither URDF nor SDF has a place for, stands in a comment
with the drive's ratio.

Source:
    MuJoCo XML reference: body, joint (armature), equality/connect. The engine's connect is a stiff constraint; the
    motion converges to the exact closed chain at first order in the time step.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.common.units import M_PER_MM
from delta_cad.drive import DriveReport
from delta_cad.drive.friction import IDLE_SPEED
from delta_cad.mechanism import inverse_kinematics
from delta_cad.mechanism.placement import CHAINS, SIDES

_TIMESTEP_S = 1e-4
# Time constant of a closure, two time steps, which is the least the engine takes, and critical damping.
_STIFF = {"solref": "0.0002 1", "solimp": "0.999 0.9999 0.0001"}
DUST_KG, _DUST_KG_M2 = 1e-6, 1e-10  # of a link between two joints: a millionth of the platform, and no zero
_FREE_LIMITS = {"universal": (-3.2, 3.2, 0.0, 1e3), "slide": (-0.5, 0.5, 0.0, 1e2)}
"""Lower, upper, effort and speed, rad and m, of joints that other joints limit, which URDF wants to see."""
_UPRIGHT = 1e-9  # cosine of a pitch that is a right angle but for roundings
_SCALE = " ".join([repr(M_PER_MM)] * 3)  # STL files are in mm
_ARM_COLOUR, _ROD_COLOUR = "0.25 0.45 0.7 1", "0.1 0.1 0.1 1"


@dataclass(frozen=True)
class Joint:
    """A joint between two links.

    Attributes:
        name: Such as "elbow_0_1".
        kind: "revolute" of a driven shoulder, "universal" of an elbow, "ball" of a wrist, which closes a loop, or
            "slide" of the platform, three in one.
        parent: Link on the base's side; of a wrist the platform.
        child: Link in whose frame the axes are.
        axes: Name -> (3,) direction of each hinge or slide at home, in their order; none of a ball.
        between: Names of the links between these, where only joints of one axis are known.
        home_rad: Angle of a shoulder at home, counted from level.
    """

    name: str
    kind: str
    parent: str
    child: str
    axes: Mapping[str, np.ndarray]
    between: tuple[str, ...] = ()
    home_rad: float = 0.0


@dataclass(frozen=True)
class Robot:
    """What the three formats are made of.

    Attributes:
        assembly: The machine.
        bodies: Mass properties by link, as `mass_report` has them.
        drive: Ratio, rotor and the torque at the joint that the controller lets it give.
        stops_rad: Smallest and largest shoulder angle.
        friction: Coulomb friction (N m) and damping (N m s/rad) of a joint's drive; the ball joints' is left out.
    """

    assembly: Assembly
    bodies: Mapping[str, Any]
    drive: DriveReport
    stops_rad: tuple[float, float]
    friction: tuple[float, float] = (0.0, 0.0)

    @property
    def home_mm(self) -> np.ndarray:
        """(3,) position of the platform at home, mm."""
        return np.asarray(self.assembly.home_mm, dtype=float)

    @cached_property
    def home_angles(self) -> np.ndarray:
        """(3,) shoulder angles there, rad."""
        return inverse_kinematics(self.assembly.placement.geometry, self.home_mm * M_PER_MM)

    @cached_property
    def frames(self) -> Mapping[str, np.ndarray]:
        """Link -> (4, 4) frame at home, mm."""
        return self.assembly.placement(self.home_mm)

    @property
    def wrist_m(self) -> np.ndarray:
        """(3,) a rod's wrist in its own frame, m."""
        return np.array([self.assembly.placement.geometry.forearm_length, 0.0, 0.0])

    @property
    def turning_kg_m2(self) -> float:
        """Inertia of a rotor and its pinion about the joint."""
        pinion = self.bodies["pinion_0"]["inertia_kg_m2"][1][1] if "pinion_0" in self.bodies else 0.0
        return self.drive.reflected_inertia_kg_m2 + self.drive.ratio**2 * pinion

    @property
    def links(self) -> list[str]:
        """The links, base first."""
        return ["base", *(joint.child for joint in self.joints if joint.kind != "ball")]

    @cached_property
    def joints(self) -> list[Joint]:
        """The graph: each arm's shoulder, then elbow and wrist of either rod, last the platform."""
        found = []
        for i in CHAINS:
            shoulder, arm = f"shoulder_{i}", f"upper_arm_{i}"
            axes, home = {shoulder: np.array([0.0, -1.0, 0.0])}, float(self.home_angles[i])
            found.append(Joint(shoulder, "revolute", "base", arm, axes, home_rad=home))
            for j in SIDES:
                elbow, rod = f"elbow_{i}_{j}", f"rod_{i}_{j}"
                axes = {f"{elbow}_swing": self.stud(i, j), f"{elbow}_lean": np.array([0.0, 0.0, 1.0])}
                found.append(Joint(elbow, "universal", arm, rod, axes, (elbow,)))
                found.append(Joint(f"wrist_{i}_{j}", "ball", "platform", rod, {}))
        slides = {f"platform_{axis}": np.eye(3)[k] for k, axis in enumerate("xyz")}
        return [*found, Joint("platform", "slide", "base", "platform", slides, ("slide_x", "slide_y"))]

    def stud(self, i: int, j: int) -> np.ndarray:
        """(3,) axis of the arm's cross-bar in a rod's frame at home."""
        return self.frames[f"rod_{i}_{j}"][:3, :3].T @ self.frames[f"upper_arm_{i}"][:3, 1]

    def wrist(self, rod: str) -> np.ndarray:
        """(3,) a rod's wrist in the platform's frame at home, m."""
        point = self.frames[rod] @ [*(self.wrist_m / M_PER_MM), 1.0]
        return (np.linalg.inv(self.frames["platform"]) @ point)[:3] * M_PER_MM

    def offset(self, joint: Joint) -> np.ndarray:
        """(4, 4) frame of a joint's child in its parent's at home, mm."""
        return np.linalg.inv(self.frames[joint.parent]) @ self.frames[joint.child]

    def stops_from(self, zero_rad: float) -> tuple[float, float]:
        """Smallest and largest shoulder angle counted from another zero than level, rad."""
        low, high = self.stops_rad
        return low - zero_rad, high - zero_rad

    def meshes(self, link: str) -> list[tuple[str, np.ndarray, str]]:
        """Name, placement (4, 4) in mm and colour of the made parts on a link; bought ones have no mesh."""
        return [
            (one.part.number, one.placement, _text([*one.part.material.colour, 1.0]))
            for one in self.assembly.occurrences
            if one.link == link and one.part.make
        ]

    def remark(self) -> Any:
        """A comment of what URDF and SDF have no place for."""
        return ET.Comment(
            f" home: platform at {_text(self.home_mm * M_PER_MM)} m, shoulder angles {_text(self.home_angles)} rad; "
            f"each shoulder's rotor and pinion add {self.turning_kg_m2!r} kg m2 at the joint, "
            f"ratio {self.drive.ratio!r} "
        )


def mjcf(robot: Robot, gravity_m_s2: Sequence[float]) -> str:
    """Writes the MJCF text of a machine under a gravity, (3,) in the base frame."""
    root = ET.Element("mujoco", model=robot.assembly.name)
    home = f"platform at {_text(robot.home_mm)} mm, shoulder angles {_text(robot.home_angles)} rad"
    root.append(ET.Comment(f" home: {home} "))
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    ET.SubElement(root, "option", timestep=repr(_TIMESTEP_S), gravity=_text(gravity_m_s2), integrator="implicitfast")
    default = ET.SubElement(root, "default")
    ET.SubElement(default, "geom", contype="0", conaffinity="0", group="1", mass="0")
    ET.SubElement(default, "equality", _STIFF)
    world, equality, actuator, sensor = (
        ET.SubElement(root, tag) for tag in ("worldbody", "equality", "actuator", "sensor")
    )
    ET.SubElement(world, "light", pos="0.3 -0.3 0.6", dir="-0.4 0.4 -0.8")
    bodies = {"base": ET.SubElement(world, "body", name="base")}
    _fill(bodies["base"], robot, "base")
    torque = robot.drive.controlled_torque_N_m
    for joint in robot.joints:
        if joint.kind == "ball":
            ends = {"name": joint.name, "body1": joint.child, "body2": joint.parent}
            ET.SubElement(equality, "connect", ends, anchor=_text(robot.wrist_m))
            continue
        at = robot.offset(joint)
        pose = {"pos": _text(at[:3, 3] * M_PER_MM), "quat": _text(_quaternion(at[:3, :3]))}
        parent = world if joint.kind == "slide" else bodies[joint.parent]
        body = bodies[joint.child] = ET.SubElement(parent, "body", pose, name=joint.child)
        for name, axis in joint.axes.items():
            kind = "slide" if joint.kind == "slide" else "hinge"
            hinge = ET.SubElement(body, "joint", type=kind, name=name, axis=_text(axis))
            if joint.kind == "revolute":
                travel = _text(robot.stops_from(joint.home_rad))
                hinge.attrib |= {"armature": repr(robot.turning_kg_m2), "frictionloss": repr(robot.friction[0])}
                hinge.attrib |= {"damping": repr(robot.friction[1]), "range": travel}
                chain = name.rpartition("_")[2]
                ET.SubElement(actuator, "motor", name=f"motor_{chain}", joint=name, ctrlrange=_text([-torque, torque]))
                ET.SubElement(sensor, "jointpos", name=f"encoder_{chain}", joint=name)
        _fill(body, robot, joint.child)
    ET.SubElement(sensor, "framepos", name="handle_position", objtype="site", objname="handle")
    return _indented(root)


def _fill(body: ET.Element, robot: Robot, link: str) -> None:
    """Gives a body its inertia, what of it the eye sees, and the site of wrist or handle."""
    properties = robot.bodies[link]
    moments = _moments(properties)
    full = " ".join(moments[key] for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))  # the order of `fullinertia`
    about = {"pos": _text(properties["centre_m"]), "mass": repr(float(properties["mass_kg"]))}
    ET.SubElement(body, "inertial", about, fullinertia=full)
    g, half = robot.assembly.placement.geometry, robot.assembly.placement.parallelogram_width_mm * M_PER_MM / 2.0

    def capsule(ends: Sequence[float], radius: float, rgba: str) -> None:
        ET.SubElement(body, "geom", type="capsule", fromto=_text(ends), size=repr(radius), rgba=rgba)

    def disc(radius: float, thick: float, height: float, rgba: str) -> None:
        at, size = _text([0.0, 0.0, height]), _text([radius, thick])
        ET.SubElement(body, "geom", type="cylinder", size=size, pos=at, rgba=rgba)

    if link == "base":
        disc(float(g.base_radii.max()) + 0.03, 0.002, -0.06, "0.5 0.5 0.55 1")
    elif link == "platform":
        disc(g.platform_radius, 0.003, 0.0, "0.8 0.8 0.82 1")
        ET.SubElement(body, "site", name="handle", pos="0 0 0", size="0.003")
    elif link.startswith("rod"):
        capsule([0.0, 0.0, 0.0, *robot.wrist_m], 0.0025, _ROD_COLOUR)
        ET.SubElement(body, "site", name=link.replace("rod", "wrist"), pos=_text(robot.wrist_m), size="0.004")
    else:
        elbow = g.upper_arm_length
        capsule([0.0, 0.0, 0.0, elbow, 0.0, 0.0], 0.006, _ARM_COLOUR)
        capsule([elbow, -half, 0.0, elbow, half, 0.0], 0.003, _ARM_COLOUR)


def urdf(robot: Robot) -> str:
    """Writes the URDF text of a machine, its loops cut at the wrists and stated."""
    root = ET.Element("robot", name=robot.assembly.name)
    root.append(robot.remark())
    for name in robot.links:
        link = _urdf_link(root, name, robot.bodies[name])
        for number, at, colour in robot.meshes(name):
            visual = ET.SubElement(link, "visual")
            ET.SubElement(visual, "origin", _origin(at))
            geometry = ET.SubElement(visual, "geometry")
            ET.SubElement(geometry, "mesh", filename=f"parts/{number}.stl", scale=_SCALE)
            material = ET.SubElement(visual, "material", name=f"colour_{number}")
            ET.SubElement(material, "color", rgba=colour)
    dust = {"centre_m": [0.0] * 3, "mass_kg": DUST_KG, "inertia_kg_m2": (np.eye(3) * _DUST_KG_M2).tolist()}
    for joint in (joint for joint in robot.joints if joint.kind != "ball"):
        at, driven = robot.offset(joint), joint.kind == "revolute"
        if driven:
            at[:3, :3] = at[:3, :3] @ _about_y(joint.home_rad)
        limit = _drive_limits(robot, robot.stops_rad) if driven else _FREE_LIMITS[joint.kind]
        links = [joint.parent, *joint.between, joint.child]
        for (name, axis), parent, child in zip(joint.axes.items(), links, links[1:], strict=False):
            if child in joint.between:
                _urdf_link(root, child, dust)
            kind = "prismatic" if joint.kind == "slide" else "revolute"
            element = ET.SubElement(root, "joint", name=name, type=kind)
            ET.SubElement(element, "parent", link=parent)
            ET.SubElement(element, "child", link=child)
            ET.SubElement(element, "origin", _origin(at if parent == joint.parent else np.eye(4)))
            names = ("lower", "upper", "effort", "velocity")
            ET.SubElement(element, "limit", {key: repr(float(v)) for key, v in zip(names, limit, strict=True)})
            ET.SubElement(element, "axis", xyz=_text(axis))
            if driven:
                coulomb, viscous = robot.friction
                ET.SubElement(element, "dynamics", damping=repr(viscous), friction=repr(coulomb))
    root.append(
        ET.Comment(" the cut joints: balls at the wrists, the same point of both links; simulators close them ")
    )
    for joint in (joint for joint in robot.joints if joint.kind == "ball"):
        loop = ET.SubElement(root, "loop_joint", name=joint.name, type="ball")
        ET.SubElement(loop, "link1", link=joint.child, xyz=_text(robot.wrist_m), rpy="0 0 0")
        ET.SubElement(loop, "link2", link=joint.parent, xyz=_text(robot.wrist(joint.child)), rpy="0 0 0")
    for i in CHAINS:
        transmission = ET.SubElement(root, "transmission", name=f"drive_{i}")
        _child(transmission, "type", "transmission_interface/SimpleTransmission")
        ET.SubElement(transmission, "joint", name=f"shoulder_{i}")
        actuator = ET.SubElement(transmission, "actuator", name=f"motor_{i}")
        _child(actuator, "mechanicalReduction", repr(float(robot.drive.ratio)))
    return '<?xml version="1.0"?>\n' + _indented(root)


def _urdf_link(root: ET.Element, name: str, body: Mapping[str, Any]) -> ET.Element:
    link = ET.SubElement(root, "link", name=name)
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=_text(body["centre_m"]), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=repr(float(body["mass_kg"])))
    ET.SubElement(inertial, "inertia", _moments(body))
    return link


def sdf(robot: Robot) -> str:
    """Writes the SDF text of a machine, its loops closed, at home."""
    root = ET.Element("sdf", version="1.7")
    model = ET.SubElement(root, "model", name=robot.assembly.name)
    model.append(robot.remark())
    _sdf_joint(model, "fixed_to_world", "fixed", "world", "base")
    for name in robot.links:
        link, body = ET.SubElement(model, "link", name=name), robot.bodies[name]
        _child(link, "pose", _pose(robot.frames[name]))
        inertial = ET.SubElement(link, "inertial")
        _child(inertial, "pose", f"{_text(body['centre_m'])} 0 0 0")
        _child(inertial, "mass", repr(float(body["mass_kg"])))
        inertia = ET.SubElement(inertial, "inertia")
        for key, value in _moments(body).items():
            _child(inertia, key, value)
        for n, (number, at, colour) in enumerate(robot.meshes(name)):
            visual = ET.SubElement(link, "visual", name=f"{number}_{n}")
            _child(visual, "pose", _pose(at))
            mesh = ET.SubElement(ET.SubElement(visual, "geometry"), "mesh")
            _child(mesh, "uri", f"parts/{number}.stl")
            _child(mesh, "scale", _SCALE)
            _child(ET.SubElement(visual, "material"), "diffuse", colour)
    for joint in (joint for joint in robot.joints if joint.kind != "slide"):
        element = _sdf_joint(model, joint.name, joint.kind, joint.parent, joint.child)
        if joint.kind == "ball":
            _child(element, "pose", f"{_text(robot.wrist_m)} 0 0 0")
        for key, direction in zip(("axis", "axis2"), joint.axes.values(), strict=False):
            axis = ET.SubElement(element, key)
            _child(axis, "xyz", _text(direction))
            if joint.kind == "revolute":
                limits = _drive_limits(robot, robot.stops_from(joint.home_rad))
                limit, dynamics = ET.SubElement(axis, "limit"), ET.SubElement(axis, "dynamics")
                for name, value in zip(("lower", "upper", "effort", "velocity"), limits, strict=True):
                    _child(limit, name, repr(float(value)))
                for name, value in zip(("damping", "friction"), robot.friction[::-1], strict=True):
                    _child(dynamics, name, repr(value))
    return '<?xml version="1.0"?>\n' + _indented(root)


def _sdf_joint(model: ET.Element, name: str, kind: str, parent: str, child: str) -> ET.Element:
    joint = ET.SubElement(model, "joint", name=name, type=kind)
    _child(joint, "parent", parent)
    _child(joint, "child", child)
    return joint


def _drive_limits(robot: Robot, stops_rad: tuple[float, float]) -> tuple[float, float, float, float]:
    """Lower and upper angle, torque and speed of a shoulder."""
    low, high = stops_rad
    return low, high, robot.drive.controlled_torque_N_m, IDLE_SPEED / robot.drive.ratio


def _moments(body: Mapping[str, Any]) -> dict[str, str]:
    """The six moments of inertia about the centre, in the link's axes."""
    inertia, names = body["inertia_kg_m2"], "xyz"
    pairs = [(a, b) for a in range(3) for b in range(a, 3)]
    return {f"i{names[a]}{names[b]}": repr(float(inertia[a][b])) for a, b in pairs}


def _about_y(angle: float) -> np.ndarray:
    """Turn that takes an arm at an angle back to level: arms turn about -y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _quaternion(rotation: np.ndarray) -> np.ndarray:
    """Quaternion w, x, y, z of a rotation matrix."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return np.array([w, x, y, z])


def _angles(frame: np.ndarray) -> np.ndarray:
    """Roll, pitch and yaw about fixed axes, as URDF and SDF have them."""
    r = frame[:3, :3]
    level = np.hypot(r[0, 0], r[1, 0])
    pitch = np.arctan2(-r[2, 0], level)
    if level < _UPRIGHT:  # roll and yaw turn about the same line: one of them does for both
        return np.array([np.arctan2(-r[1, 2], r[1, 1]), pitch, 0.0])
    return np.array([np.arctan2(r[2, 1], r[2, 2]), pitch, np.arctan2(r[1, 0], r[0, 0])])


def _origin(frame: np.ndarray) -> dict[str, str]:
    return {"xyz": _text(frame[:3, 3] * M_PER_MM), "rpy": _text(_angles(frame))}


def _pose(frame: np.ndarray) -> str:
    return f"{_text(frame[:3, 3] * M_PER_MM)} {_text(_angles(frame))}"


def _child(parent: ET.Element, tag: str, text: str) -> None:
    ET.SubElement(parent, tag).text = text


def _indented(root: ET.Element) -> str:
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _text(values: Sequence[float] | np.ndarray) -> str:
    """Numbers that read back to the last bit."""
    return " ".join(repr(float(value)) for value in values)
