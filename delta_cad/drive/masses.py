"""Masses of the moving bodies as the dynamics sees them: read from the solids, or lumped as the paper does.

A rod that keeps its two ends' velocities u (elbow) and v (wrist) has the kinetic energy
`(m_uu |u|^2 + 2 m_uv u.v + m_vv |v|^2) / 2`, whatever its distribution along its length: with c the place of its
centre between 0 at the elbow and 1 at the wrist and I its transverse inertia about the centre,
`m_uu = m (1 - c)^2 + I / L_B^2`, `m_uv = m c (1 - c) - I / L_B^2`, `m_vv = m c^2 + I / L_B^2`. Both rods of a chain
move alike. What a rod's turning about itself adds (2.3e-8 kg m^2) is left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from delta_cad.common.reading import ReadError, parse_json, read_bounded
from delta_cad.common.refusal import RefusedError, short
from delta_cad.design import Design, design_hash
from delta_cad.drive.report import DriveReport, drive_torque
from delta_cad.mechanism.limits import HandleInertia

_SCHEMA = "delta-mass-properties/1"
_BUILT_FROM = "input_sha256"  # key of the hash of the design that was built
CHAINS = range(3)
# Relative difference up to which chains are the same: the solids are integrated each in its own frame, to rounding.
_ALIKE = 1e-6
_MASS_MAX = 1e3  # kg; beyond any joystick, so that grams given as kilograms are refused.
# Largest difference of a rod's two transverse inertias as a share of them; beyond it the one figure would not do.
_SLENDER = 1e-2


class MassError(RefusedError):
    """Masses that are refused."""


@dataclass(frozen=True)
class Masses:
    """Mass of the moving bodies, the same for the three chains.

    Attributes:
        platform: Platform with all it carries, kg.
        arm_along: First moment of an upper arm about its shoulder along the arm, kg m.
        arm_across: First moment of an upper arm along the elbow's direction of motion, kg m.
        arm_inertia: Inertia of an upper arm about its shoulder axis, kg m^2.
        rod_elbow: m_uu of both rods of a chain, kg.
        rod_cross: m_uv of both, kg.
        rod_wrist: m_vv of both, kg.
        rotor_inertia: Rotor and pinion seen through the drive at the joint, kg m^2.

    Raises:
        MassError: A figure is not finite, or one that must not be negative is.
    """

    platform: float
    arm_along: float
    arm_across: float
    arm_inertia: float
    rod_elbow: float
    rod_cross: float
    rod_wrist: float
    rotor_inertia: float = 0.0

    def __post_init__(self) -> None:
        signed = ("arm_along", "arm_across", "rod_cross")
        for field in fields(self):
            value = getattr(self, field.name)
            if not math.isfinite(value) or (field.name not in signed and value < 0.0):
                rule = "finite" if field.name in signed else "finite and not negative"
                raise MassError("masses", field.name, repr(value), f"must be {rule}")

    @property
    def handle_inertia(self) -> HandleInertia:
        """Inertias that make up the effective mass at the handle."""
        return HandleInertia(
            carried_mass=self.platform + 3.0 * self.rod_wrist,
            elbow_mass=self.rod_elbow,
            cross_mass=self.rod_cross,
            joint_inertia=self.arm_inertia + self.rotor_inertia,
        )

    @property
    def at_wrists(self) -> float:
        """Mass that hangs on the platform, kg: the platform and each rod's share at its wrist."""
        return self.platform + 3.0 * (self.rod_cross + self.rod_wrist)

    @property
    def at_elbow(self) -> float:
        """Mass of one chain's rods that hangs on its elbow, kg."""
        return self.rod_elbow + self.rod_cross


@dataclass(frozen=True)
class PointMasses:
    """The paper's masses: half of each link at each of its ends.

    Attributes:
        platform: m1, kg.
        upper_arm: m2, one upper arm, kg.
        forearm: m3, both rods of a chain, kg.

    Source:
        [RCIM2018] eqs. (17)-(22).
    """

    platform: float
    upper_arm: float
    forearm: float

    def masses(self, upper_arm_length: float, rotor_inertia: float = 0.0) -> Masses:
        """Lumps the masses as the dynamics takes them.

        Args:
            upper_arm_length: L_A, m.
            rotor_inertia: At the joint, kg m^2.

        Returns:
            The masses; exact for gravity. The kinetic energy of a rod with its mass at its ends is larger than that
            of an even rod: for the same velocities at both ends they agree, for opposite ones it is three times that.
        """
        half = self.upper_arm / 2.0 * upper_arm_length
        return Masses(
            platform=self.platform,
            arm_along=half,
            arm_across=0.0,
            arm_inertia=half * upper_arm_length,
            rod_elbow=self.forearm / 2.0,
            rod_cross=0.0,
            rod_wrist=self.forearm / 2.0,
            rotor_inertia=rotor_inertia,
        )


def rod_masses(mass: float, centre: float, inertia: float, length: float) -> tuple[float, float, float]:
    """Computes m_uu, m_uv and m_vv of one rigid rod, kg.

    Args:
        mass: kg.
        centre: Distance of its centre from the elbow, m.
        inertia: About the centre, square to the rod, kg m^2.
        length: L_B, m.
    """
    c, turning = centre / length, inertia / length**2
    return mass * (1.0 - c) ** 2 + turning, mass * c * (1.0 - c) - turning, mass * c**2 + turning


def load_masses(path: str | Path, design: Design) -> Masses:
    """Reads `mass_properties.json` of a design's build.

    Args:
        path: The file.
        design: The design, whose rotors and pinions turn with the joints.

    Returns:
        The masses.

    Raises:
        MassError: Unreadable, not of this schema, of another design, a body that is missing or malformed, or chains
            that differ.
    """
    data, _ = read_mass_properties(Path(path), design)
    return masses_from_dict(data, design.geometry.forearm_length, drive_torque(design), Path(path).name)


def read_mass_properties(path: Path, design: Design) -> tuple[Mapping[str, Any], bytes]:
    """Reads what a build wrote about masses, and checks its schema and that it is about a design.

    Args:
        path: The file.
        design: The design; a file that does not say which one it is about is taken to be about this.

    Returns:
        What the file holds, and its bytes.

    Raises:
        MassError: Unreadable, refused by `parse_json`, not of this schema, or of a build of another design.
    """
    try:
        content = read_bounded(path)
        data = parse_json(content, path.name)
    except ReadError as error:
        raise MassError(error.file, error.field, error.value, error.allowed) from None
    read, own = _of_schema(data, path.name), design_hash(design)
    built_from = read.get(_BUILT_FROM, own)
    if built_from != own:
        rule = f"was built from another design than {design.name}, {own[:12]}; build it again"
        raise MassError(path.name, _BUILT_FROM, short(built_from), rule)
    return read, content


def _of_schema(data: object, file: str) -> Mapping[str, Any]:
    if not isinstance(data, Mapping) or data.get("schema") != _SCHEMA:
        raise MassError(file, "schema", "", f'must be "{_SCHEMA}"')
    return data


def masses_from_dict(
    data: object, forearm_length: float, drive: DriveReport | None = None, file: str = "masses"
) -> Masses:
    """Makes masses of what a file holds; see `load_masses`.

    Args:
        data: What it holds.
        forearm_length: L_B, m.
        drive: Whose rotor and pinion turn with the joint; None for none.
        file: Name of the file, for messages.

    Raises:
        MassError: As `load_masses`; the design is not looked at.
    """
    bodies = _of_schema(data, file).get("bodies")
    arms = [_body(bodies, f"upper_arm_{i}", file) for i in CHAINS]
    rods = [_body(bodies, f"rod_{i}_0", file) for i in CHAINS]
    rods += [_mirrored(_body(bodies, f"rod_{i}_1", file)) for i in CHAINS]  # cups of a pair come from either side
    platform = _body(bodies, "platform", file)
    _require_alike(arms, "upper_arm", file)
    _require_alike(rods, "rod", file)
    mass, centre, inertia = arms[0]
    about_shoulder = inertia[1, 1] + mass * (centre[0] ** 2 + centre[2] ** 2)
    rod_mass, rod_centre, rod_inertia = rods[0]
    transverse = (rod_inertia[1, 1] + rod_inertia[2, 2]) / 2.0
    if abs(rod_inertia[1, 1] - rod_inertia[2, 2]) > _SLENDER * transverse:
        raise MassError(file, "bodies.rod_0_0.inertia_kg_m2", "", "its two transverse inertias differ by more than 1 %")
    uu, uv, vv = rod_masses(rod_mass, float(rod_centre[0]), float(transverse), forearm_length)
    return Masses(
        platform=platform[0],
        arm_along=mass * float(centre[0]),
        arm_across=mass * float(centre[2]),
        arm_inertia=float(about_shoulder),
        rod_elbow=2.0 * uu,
        rod_cross=2.0 * uv,
        rod_wrist=2.0 * vv,
        rotor_inertia=0.0 if drive is None else _rotor_inertia(bodies, drive, file),
    )


def _rotor_inertia(bodies: object, drive: DriveReport, file: str) -> float:
    """Rotor and pinion at the joint, kg m^2; a direct drive has no pinion."""
    if not isinstance(bodies, Mapping) or "pinion_0" not in bodies:
        return drive.reflected_inertia_kg_m2
    pinion = float(_body(bodies, "pinion_0", file)[2][1, 1])
    return drive.reflected_inertia_kg_m2 + drive.ratio**2 * pinion


def mass_and_centre(bodies: object, name: str, file: str) -> tuple[float, np.ndarray]:
    """Reads the mass of a body and its centre in the body's own frame.

    Args:
        bodies: What a mass file holds under `bodies`.
        name: Name of the body's link.
        file: Name of the file, for messages.

    Returns:
        kg, not negative, and (3,) m: x along the link, y along the joint's axis.

    Raises:
        MassError: There is no such body, or a number of it is none or not finite.
    """
    body = bodies.get(name) if isinstance(bodies, Mapping) else None
    if not isinstance(body, Mapping):
        raise MassError(file, f"bodies.{name}", "", "is missing")
    mass, centre = numbers_of(body.get("mass_kg"), ()), numbers_of(body.get("centre_m"), (3,))
    if mass is None or mass < 0.0:
        raise MassError(file, f"bodies.{name}.mass_kg", short(body.get("mass_kg")), "must be a number >= 0 kg")
    if centre is None:
        raise MassError(file, f"bodies.{name}.centre_m", short(body.get("centre_m")), "must be a list of 3 numbers, m")
    return float(mass), centre


def _body(bodies: object, name: str, file: str) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre (3,) and inertia (3, 3) of a body in its own frame."""
    mass, centre = mass_and_centre(bodies, name, file)
    inertia = numbers_of(bodies[name].get("inertia_kg_m2"), (3, 3))  # type: ignore[index]
    if not 0.0 < mass <= _MASS_MAX:
        rule = f"must be > 0 and at most {_MASS_MAX:g} kg"
        raise MassError(file, f"bodies.{name}.mass_kg", short(mass), rule)
    if inertia is None or not (np.diag(inertia) > 0.0).all():
        rule = "must be 3 x 3 numbers, the moments of inertia > 0 kg m^2"
        raise MassError(file, f"bodies.{name}.inertia_kg_m2", "", rule)
    return mass, centre, inertia


def numbers_of(value: object, shape: tuple[int, ...]) -> np.ndarray | None:
    """Gives nested lists of finite numbers as an array of a shape, None for anything else: true and text are none."""
    if not _in_numbers(value):
        return None
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError):  # lists of unequal length; a number too large for a double
        return None
    return array if array.shape == shape and np.isfinite(array).all() else None


def _in_numbers(value: object) -> bool:
    if isinstance(value, list):
        return all(_in_numbers(part) for part in value)
    return isinstance(value, int | float) and not isinstance(value, bool)


def _mirrored(body: tuple[float, np.ndarray, np.ndarray]) -> tuple[float, np.ndarray, np.ndarray]:
    """A body's image in the plane of its x and z."""
    mass, centre, inertia = body
    mirror = np.array([1.0, -1.0, 1.0])
    return mass, centre * mirror, inertia * np.outer(mirror, mirror)


def _require_alike(bodies: list[tuple[float, np.ndarray, np.ndarray]], kind: str, file: str) -> None:
    mass, centre, inertia = bodies[0]
    size = float(np.sqrt(np.trace(inertia) / mass)) + float(np.linalg.norm(centre))
    for other in bodies[1:]:
        differs = (
            abs(other[0] - mass) > _ALIKE * mass
            or np.abs(other[1] - centre).max() > _ALIKE * size
            or np.abs(other[2] - inertia).max() > _ALIKE * mass * size**2
        )
        if differs:
            raise MassError(file, f"bodies.{kind}_*", "", "the chains differ; the dynamics takes three alike")
