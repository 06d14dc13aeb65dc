"""Gravity's share of each joint's torque, bounded in closed form, and taken off what is left for the force.

What a shoulder holds at p, with `J_i` the platform's velocity per unit rate of joint i (column i of J):

- platform: it does not turn, so its mass moves with `J_i`;
- rod of mass m whose centre is at the share f of the line from elbow to wrist: `(1 - f)` of m moves with the elbow,
  `L_A` per unit rate and of chain i alone, f of it with the wrist, that is with `J_i`. A centre at e beside the line
  moves at most `e (|J_i| + L_A) / L_B` more: a rod is free to turn about its line, so that its spin takes no torque;
- upper arm: its centre moves with its distance from the shoulder axis;
- pinion: with the distance from its own axis times the turns of the pinion per turn of the arm.

Power balance and the triangle inequality give, at every p and for every direction of a gravity of size g,

    |gravity torque of joint i|  <=  g M |J_i| + g S

with M, `carried_mass`, all that moves with the wrist, and S, `arm_moment`, what moves with the elbow times L_A plus the
rest, of the heaviest chain. A force F in any direction takes at most `F |J_i|` of the same joint. So

    (F + g M) |J_i|  <=  T - g S   in the whole cube

is enough for force and weight together within the torque T: a torque condition again, with a larger force and a
smaller torque. It is conservative by the angle between `J_i` and gravity and by the pose of the upper arm.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.drive.masses import MassError, mass_and_centre, numbers_of, read_mass_properties
from delta_cad.mechanism.limits import Limits, Torque

if TYPE_CHECKING:
    from delta_cad.design import Design

CHAINS = range(3)
RODS = tuple(f"rod_{i}_{j}" for i in CHAINS for j in range(2))
NEEDED = ("platform", *(f"upper_arm_{i}" for i in CHAINS), *RODS)
KNOWN = ("base", *NEEDED, *(f"pinion_{i}" for i in CHAINS))
UPWARDS = 1.0 + 2.0**-40  # lifts a sum of some twenty products over its own rounding, 2^-47 of it at most
# Agreement of the file's home position with the cube's centre: a sum of two lengths in mm, 1e-13 of rounding.
HOME_MM = 1e-6


class GravityError(ValueError):
    """Mass properties or a share of gravity that cannot be used; the message says which field and why."""


@dataclass(frozen=True)
class WeighedMasses:
    """What of the moving bodies' masses the bound needs.

    Attributes:
        acceleration: (3) gravity in the base frame, m/s^2.
        carried_mass: M, kg.
        arm_moment: S, kg m.
        sha256: SHA-256 of the file that they come from.
    """

    acceleration: tuple[float, float, float]
    carried_mass: float
    arm_moment: float
    sha256: str


@dataclass(frozen=True)
class GravityShare:
    """What is taken off for gravity.

    Attributes:
        force: Force required at the handle, N.
        torque: Torque of each joint, N m.
        weight: Added to the force for what the wrist carries, N.
        reserve: Taken off the torque for the arms, or for all of gravity, N m.
        masses: Where weight and reserve come from; None where the reserve was given by hand.
    """

    force: float
    torque: float
    weight: float
    reserve: float
    masses: WeighedMasses | None = None

    def limits(self, limits: Limits) -> Limits:
        """Replaces the torque condition by one that leaves room for gravity, rounded to its strict side.

        Raises:
            GravityError: Nothing of the torque is left.
        """
        left = math.nextafter(self.torque - self.reserve, -math.inf)
        if left < 1e-6:  # below it the prover takes no torque
            raise GravityError(
                f"gravity takes {self.reserve:.6g} N m of each joint's {self.torque:g} N m: none is left"
            )
        return limits.with_(Torque(math.nextafter(self.force + self.weight, math.inf), left))

    def fault(self, limits: Limits) -> str | None:
        """Checks in exact fractions that these conditions leave the room for gravity that they should.

        Args:
            limits: The conditions of a certificate.

        Returns:
            The fault, or None.
        """
        condition = limits.get(Torque)
        if condition is None:
            return "gravity is taken off, but no torque is asked"
        numbers = (self.force, self.torque, self.weight, self.reserve)
        if not all(math.isfinite(x) and x >= 0.0 for x in numbers):
            return "gravity's share holds a number that is negative or not finite"
        force, torque, weight, reserve = (Fraction(x) for x in numbers)
        if Fraction(condition.force) < force + weight:
            needed = f"{self.force:g} N and the weight of {self.weight:.9g} N"
            return f"the force of {condition.force:.9g} N is less than {needed}"
        if Fraction(condition.torque_max) > torque - reserve:
            return f"the torque of {condition.torque_max:.9g} N m is more than gravity's {self.reserve:.9g} N m leave"
        if self.masses is None:
            return None
        m = self.masses
        if m.carried_mass < 0.0 or m.arm_moment < 0.0:
            return "gravity's share holds a negative mass"
        g2 = sum((Fraction(a) ** 2 for a in m.acceleration), Fraction(0))
        if weight**2 < Fraction(m.carried_mass) ** 2 * g2:
            return f"the weight of {self.weight:.9g} N is less than that of the {m.carried_mass:.9g} kg carried"
        if reserve**2 < Fraction(m.arm_moment) ** 2 * g2:
            return f"the reserve of {self.reserve:.9g} N m is less than the arms' moment {m.arm_moment:.9g} kg m asks"
        return None


def given_share(design: Design, reserve: float) -> GravityShare:
    """Makes the share of a reserve given by hand.

    Args:
        design: The design.
        reserve: Taken off the torque of each joint, N m.

    Returns:
        The share.

    Raises:
        GravityError: The reserve is negative, not finite, or leaves no torque.
    """
    r = design.requirements
    if not (math.isfinite(reserve) and 0.0 <= reserve < r.joint_torque_N_m):
        allowed = f"must be >= 0 and < requirements.joint_torque_N_m = {r.joint_torque_N_m:g} N m"
        raise GravityError(f"gravity torque = {reserve:g}: {allowed}")
    return GravityShare(r.force_N, r.joint_torque_N_m, 0.0, reserve)


def share_of_masses(design: Design, masses: WeighedMasses) -> GravityShare:
    """Computes the share that the masses of a machine ask for, as the module's docstring derives it.

    Args:
        design: The design.
        masses: Masses of its machine.

    Returns:
        The share, rounded up.
    """
    g = math.sqrt(sum(a * a for a in masses.acceleration)) * UPWARDS
    r = design.requirements
    weight, reserve = g * masses.carried_mass * UPWARDS, g * masses.arm_moment * UPWARDS
    return GravityShare(r.force_N, r.joint_torque_N_m, weight, reserve, masses)


def read_masses(path: Path, design: Design, tolerance: float = 0.0) -> WeighedMasses:
    """Reads what a build wrote about its masses, `mass_properties.json`.

    Args:
        path: The file.
        design: The design that was built.
        tolerance: Of the links' lengths, m: the masses act at the worst of them.

    Returns:
        The masses.

    Raises:
        GravityError: Unreadable, not mass properties, of another design, or with bodies that the bound does not know.
    """
    try:
        data, content = read_mass_properties(path, design)
        home, centre = data.get("home_mm"), [0.0, 0.0, design.cube.bottom_height_mm + design.cube.half_side_mm]
        here = numbers_of(home, (3,))
        if here is None or (abs(here - centre) > HOME_MM).any():
            raise GravityError(f"{path.name}: home_mm = {home}: is not the centre {centre} mm of this design's cube")
        bodies = data.get("bodies")
        if not isinstance(bodies, dict):
            raise GravityError(f"{path.name}: bodies: is missing")
        carried, moment = _sums(path.name, bodies, design, tolerance)
    except MassError as error:
        raise GravityError(str(error)) from None
    return WeighedMasses(design.requirements.gravity_m_s2, carried, moment, hashlib.sha256(content).hexdigest())


def _sums(file: str, bodies: Mapping[str, Any], design: Design, tolerance: float) -> tuple[float, float]:
    """Sums M and S, rounded up."""
    unknown = [name for name in bodies if name not in KNOWN]
    if unknown:
        raise GravityError(f"{file}: bodies.{unknown[0]}: is no body that the bound knows; known: {', '.join(KNOWN)}")
    masses = {name: mass_and_centre(bodies, name, file) for name in KNOWN if name in bodies or name in NEEDED}
    shortest, longest = design.geometry.forearm_length - tolerance, design.geometry.forearm_length + tolerance
    arm = design.geometry.upper_arm_length + tolerance
    ratio = design.hardware.capstan_ratio if design.hardware.drive == "capstan" else 1.0
    carried, moments = masses["platform"][0], []
    for i in CHAINS:
        elbow, beside = 0.0, 0.0
        for name in RODS[2 * i : 2 * i + 2]:
            mass, (x, y, z) = masses[name]
            off = math.hypot(y, z) / shortest
            carried += mass * (abs(x) / shortest + off)
            elbow += mass * (max(abs(1.0 - x / shortest), abs(1.0 - x / longest)) + off)
        for name, turns in ((f"upper_arm_{i}", 1.0), (f"pinion_{i}", ratio)):
            mass, (x, _, z) = masses.get(name, (0.0, (0.0, 0.0, 0.0)))
            beside += turns * mass * math.hypot(x, z)
        moments.append(elbow * arm + beside)
    return float(carried * UPWARDS), float(max(moments) * UPWARDS)
