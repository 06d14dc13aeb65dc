"""The machine as an MJCF file for the MuJoCo engine: closed chains, inertias from the solids, at its home position.

Bodies carry the names of the links. Each upper arm turns on a hinge with the rotor's and pinion's inertia as its
armature; each rod swings about its stud and leans square to it, and is connected to the platform, which slides without
turning, as the parallelograms have it. The springs across a pair hold its rods from turning about themselves, which the
ball joints alone would let them: with their centres beside their axes they would hang down. A spring's mass is halved
upon its rods. At `qpos = 0` every chain
is closed, so the file loads without a solve. Shapes are for the eye only: nothing collides. Joint angles count from
home, whose angles a comment of the file gives.

Source:
    MuJoCo XML reference: body, joint (armature), equality/connect. The engine's connect is a stiff constraint; the
    motion converges to the exact closed chain at first order in the time step.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.common.units import M_PER_MM
from delta_cad.drive import DriveReport
from delta_cad.mechanism import inverse_kinematics
from delta_cad.mechanism.placement import CHAINS, SIDES

TIMESTEP_S = 1e-4
# Time constant of a closure, two time steps, which is the least the engine takes, and critical damping.
STIFF = {"solref": "0.0002 1", "solimp": "0.999 0.9999 0.0001"}


def twin(
    assembly: Assembly,
    masses: Mapping[str, Any],
    drive: DriveReport,
    stops_rad: tuple[float, float],
    gravity_m_s2: Sequence[float],
    friction: tuple[float, float] = (0.0, 0.0),
) -> str:
    """Writes the MJCF text of a machine.

    Args:
        assembly: The machine.
        masses: What `mass_report` returned.
        drive: Rotor inertia, ratio and the torque at the joint that the controller lets it give.
        stops_rad: Smallest and largest shoulder angle.
        gravity_m_s2: (3,) in the base frame.
        friction: Coulomb friction (N m) and damping (N m s/rad) of a joint's drive; the ball joints' is left out.

    Returns:
        The text, indented, ending with a line break.
    """
    g = assembly.placement.geometry
    home_mm = np.asarray(assembly.home_mm, dtype=float)
    frames = assembly.placement(home_mm)
    theta = inverse_kinematics(g, home_mm * M_PER_MM)
    bodies = masses["bodies"]
    armature = drive.reflected_inertia_kg_m2
    if "pinion_0" in bodies:
        armature += drive.ratio**2 * bodies["pinion_0"]["inertia_kg_m2"][1][1]
    half_width = assembly.placement.parallelogram_width_mm * M_PER_MM / 2.0

    root = ET.Element("mujoco", model=assembly.name)
    root.append(ET.Comment(f" home: platform at {_text(home_mm)} mm, shoulder angles {_text(theta)} rad "))
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    ET.SubElement(root, "option", timestep=_text(TIMESTEP_S), gravity=_text(gravity_m_s2), integrator="implicitfast")
    default = ET.SubElement(root, "default")
    ET.SubElement(default, "geom", contype="0", conaffinity="0", group="1", mass="0")
    ET.SubElement(default, "equality", STIFF)
    world = ET.SubElement(root, "worldbody")
    ET.SubElement(world, "light", pos="0.3 -0.3 0.6", dir="-0.4 0.4 -0.8")
    base = ET.SubElement(world, "body", name="base")
    _inertial(base, bodies["base"])
    _geom(base, "cylinder", f"{_text(g.base_radius + 0.03)} 0.002", "0 0 -0.06", "0.5 0.5 0.55 1")
    for i in CHAINS:
        arm = _body(base, f"upper_arm_{i}", frames[f"upper_arm_{i}"], frames["base"])
        hinge = {"name": f"shoulder_{i}", "axis": "0 -1 0", "armature": _text(armature)}
        hinge |= {"frictionloss": _text(friction[0]), "damping": _text(friction[1])}
        travel = [stop - theta[i] for stop in stops_rad]
        ET.SubElement(arm, "joint", hinge, type="hinge", range=_text(travel))
        _inertial(arm, bodies[f"upper_arm_{i}"])
        ends = f"0 0 0 {_text(g.upper_arm_length)} 0 0"
        _capsule(arm, ends, 0.006, "0.25 0.45 0.7 1")
        across = f"{_text(g.upper_arm_length)} {_text(-half_width)} 0 {_text(g.upper_arm_length)} {_text(half_width)} 0"
        _capsule(arm, across, 0.003, "0.25 0.45 0.7 1")
        for j in SIDES:
            name = f"rod_{i}_{j}"
            rod = _body(arm, name, frames[name], frames[f"upper_arm_{i}"])
            stud = frames[name][:3, :3].T @ frames[f"upper_arm_{i}"][:3, 1]
            for turn, axis in (("swing", stud), ("lean", np.array([0.0, 0.0, 1.0]))):
                ET.SubElement(rod, "joint", type="hinge", name=f"elbow_{i}_{j}_{turn}", axis=_text(axis))
            _inertial(rod, bodies[name])
            _capsule(rod, f"0 0 0 {_text(g.forearm_length)} 0 0", 0.0025, "0.1 0.1 0.1 1")
            ET.SubElement(rod, "site", name=f"wrist_{i}_{j}", pos=f"{_text(g.forearm_length)} 0 0", size="0.004")
    platform = _body(world, "platform", frames["platform"], np.eye(4))
    for axis, direction in zip("xyz", ("1 0 0", "0 1 0", "0 0 1"), strict=True):
        ET.SubElement(platform, "joint", type="slide", name=f"platform_{axis}", axis=direction)
    _inertial(platform, bodies["platform"])
    _geom(platform, "cylinder", f"{_text(g.platform_radius)} 0.003", "0 0 0", "0.8 0.8 0.82 1")
    ET.SubElement(platform, "site", name="handle", pos="0 0 0", size="0.003")

    equality = ET.SubElement(root, "equality")
    for i in CHAINS:
        for j in SIDES:
            rod = f"rod_{i}_{j}"
            anchor = f"{_text(g.forearm_length)} 0 0"
            ET.SubElement(equality, "connect", name=f"wrist_{i}_{j}", body1=rod, body2="platform", anchor=anchor)
    actuator, sensor = ET.SubElement(root, "actuator"), ET.SubElement(root, "sensor")
    for i in CHAINS:
        limits = _text((-drive.controlled_torque_N_m, drive.controlled_torque_N_m))
        ET.SubElement(actuator, "motor", name=f"motor_{i}", joint=f"shoulder_{i}", ctrlrange=limits)
        ET.SubElement(sensor, "jointpos", name=f"encoder_{i}", joint=f"shoulder_{i}")
    ET.SubElement(sensor, "framepos", name="handle_position", objtype="site", objname="handle")
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _body(parent: ET.Element, name: str, frame: np.ndarray, parent_frame: np.ndarray) -> ET.Element:
    """A body at its home frame, given in the parent's; both (4, 4) in mm."""
    relative = np.linalg.inv(parent_frame) @ frame
    pose = {"pos": _text(relative[:3, 3] * M_PER_MM), "quat": _text(_quaternion(relative[:3, :3]))}
    return ET.SubElement(parent, "body", pose, name=name)


def _inertial(body: ET.Element, properties: Mapping[str, Any]) -> None:
    inertia = np.array(properties["inertia_kg_m2"])
    full = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]  # the order of `fullinertia`
    about = {"pos": _text(properties["centre_m"]), "mass": _text(properties["mass_kg"])}
    ET.SubElement(body, "inertial", about, fullinertia=_text(full))


def _geom(body: ET.Element, kind: str, size: str, at: str, rgba: str) -> None:
    ET.SubElement(body, "geom", type=kind, size=size, pos=at, rgba=rgba)


def _capsule(body: ET.Element, ends: str, radius: float, rgba: str) -> None:
    ET.SubElement(body, "geom", type="capsule", fromto=ends, size=_text(radius), rgba=rgba)


def _quaternion(rotation: np.ndarray) -> np.ndarray:
    """Quaternion w, x, y, z of a rotation matrix."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return np.array([w, x, y, z])


def _text(values: float | Sequence[float] | np.ndarray) -> str:
    """Numbers that read back to the last bit."""
    return " ".join(repr(float(value)) for value in np.atleast_1d(np.asarray(values, dtype=float)))
