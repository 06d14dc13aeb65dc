"""Gravity's part in a joint's torque: what a build's masses are to the limit on it, or a torque given by hand.

What a shoulder holds at p, with `J_i` the platform's velocity per unit rate of joint i (column i of J):

- platform: it does not turn, so its mass moves with `J_i`;
- rod of mass m whose centre is at the share f of the line from elbow to wrist: `(1 - f)` of m moves with the elbow,
  `L_A` per unit rate and of chain i alone, f of it with the wrist, that is with `J_i`. A centre at e beside the line
  moves at most `e (|J_i| + L_A) / L_B` more: a rod is free to turn about its line, so that its spin takes no torque;
- upper arm: its centre, along the arm and square to it, moves with the arm;
- pinion: its centre moves with its distance from its own axis times the turns of the pinion per turn of the arm.

`HoldingTorque` says what these sums are to it. A torque given by hand is taken off that of every joint instead.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.refusal import LONGEST, short
from delta_cad.drive.masses import MassError, mass_and_centre, numbers_of, read_mass_properties
from delta_cad.mechanism import GeometryError
from delta_cad.mechanism.limits import HeldMasses, HoldingTorque, Limits, Torque

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
class GravityShare:
    """How gravity is counted in.

    Attributes:
        force: Force required at the handle, N.
        torque: Torque of each joint, N m.
        reserve: Taken off the torque for all of gravity, given by hand, N m; None where masses say what it takes.
        sha256: SHA-256 of the file of masses; None where the reserve was given by hand.
        masses: What they are to the limit; None likewise.
    """

    force: float
    torque: float
    reserve: float | None = None
    sha256: str | None = None
    masses: HeldMasses | None = None

    def limits(self, limits: Limits) -> Limits:
        """Adds the limit on torque with gravity, or takes the reserve off the torque, rounded to its strict side.

        Raises:
            GravityError: Nothing of the torque is left.
        """
        if self.masses is not None:
            return limits.with_(HoldingTorque(self.force, self.torque, self.masses))
        assert self.reserve is not None
        left = math.nextafter(self.torque - self.reserve, -math.inf)
        if left < 1e-6:  # below it the prover takes no torque
            raise GravityError(
                f"gravity takes {self.reserve:.6g} N m of each joint's {self.torque:g} N m: none is left"
            )
        return limits.with_(Torque(self.force, left))

    def fault(self, limits: Limits) -> str | None:
        """Checks in exact fractions that these conditions count gravity in as they should.

        Args:
            limits: The conditions of a certificate.

        Returns:
            The fault, or None.
        """
        if self.masses is not None:
            held = limits.get(HoldingTorque)
            if held is None:
                return "gravity is counted in by masses, but no torque with gravity is asked"
            if held.laxer(HoldingTorque(self.force, self.torque, self.masses)):
                return f"torque with gravity is asked less strictly than {self.torque:.9g} N m for {self.force:.9g} N"
            return None
        condition = limits.get(Torque)
        if condition is None:
            return "gravity is taken off, but no torque is asked"
        reserve = self.reserve
        if reserve is None or not all(math.isfinite(x) and x >= 0.0 for x in (self.force, self.torque, reserve)):
            return "gravity's share holds a number that is missing, negative or not finite"
        if Fraction(condition.force) < Fraction(self.force):
            return f"the force of {condition.force:.9g} N is less than {self.force:g} N"
        if Fraction(condition.torque_max) > Fraction(self.torque) - Fraction(reserve):
            return f"the torque of {condition.torque_max:.9g} N m is more than gravity's {reserve:.9g} N m leave"
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
    return GravityShare(r.force_N, r.joint_torque_N_m, reserve)


def share_of_masses(path: Path, design: Design, tolerance: float = 0.0) -> GravityShare:
    """Reads what a build wrote about its masses, `mass_properties.json`.

    Args:
        path: The file.
        design: The design that was built.
        tolerance: Of the links' lengths, m: the masses act anywhere within it.

    Returns:
        The share.

    Raises:
        GravityError: Unreadable, not mass properties, of another design, or with bodies that the limit does not know.
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
        masses = held_masses(path.name, bodies, design, tolerance)
    except (MassError, GeometryError) as error:
        raise GravityError(str(error)) from None
    r = design.requirements
    return GravityShare(r.force_N, r.joint_torque_N_m, None, hashlib.sha256(content).hexdigest(), masses)


def held_masses(file: str, bodies: Mapping[str, Any], design: Design, tolerance: float = 0.0) -> HeldMasses:
    """Sums up what gravity acts on, as the module's docstring says; what chains and tolerance spread is loose.

    Args:
        file: Name that messages start with.
        bodies: Link -> mass and centre, as `mass_properties.json` has them.
        design: The design.
        tolerance: Of the links' lengths, m.

    Raises:
        GravityError: A body is unknown.
        MassError: One is missing, or its numbers are refused.
    """
    unknown = [name for name in bodies if name not in KNOWN]
    if unknown:
        name = unknown[0] if unknown[0].isidentifier() and len(unknown[0]) <= LONGEST else short(unknown[0])
        raise GravityError(f"{file}: bodies.{name}: is no body that the bound knows; known: {', '.join(KNOWN)}")
    of = {name: mass_and_centre(bodies, name, file) for name in KNOWN if name in bodies or name in NEEDED}
    arms, rods = (
        (length - tolerance, length + tolerance)
        for length in (design.geometry.upper_arm_length, design.geometry.forearm_length)
    )
    ratio = design.hardware.capstan_ratio if design.hardware.drive == "capstan" else 1.0
    carried, loose_mass = [of["platform"][0]] * 2, 0.0
    along, across, loose = [], [], []
    for i in CHAINS:
        moment, beside = [0.0, 0.0], 0.0
        for name in RODS[2 * i : 2 * i + 2]:
            mass, (x, y, z) = of[name]
            shares = sorted(x / length for length in rods)
            off = mass * math.hypot(y, z) / rods[0]
            loose_mass, beside = loose_mass + off, beside + off * arms[1]
            carried = [total + mass * share for total, share in zip(carried, shares, strict=True)]
            ends = [mass * (1.0 - share) * arm for share in shares for arm in arms]
            moment = [moment[0] + min(ends), moment[1] + max(ends)]
        mass, (x, _, z) = of[f"upper_arm_{i}"]
        along += [end + mass * x for end in moment]
        across.append(mass * z)
        mass, (x, _, z) = of.get(f"pinion_{i}", (0.0, (0.0, 0.0, 0.0)))
        loose.append(beside + ratio * mass * math.hypot(x, z))
    (M, m), (S, s), (Z, z) = (_middle(ends) for ends in (carried, along, across))
    gravity = design.requirements.gravity_m_s2
    rounding = (UPWARDS - 1.0) * (abs(M) + abs(S) + abs(Z))
    return HeldMasses(
        *(gravity[0], abs(gravity[1]), gravity[2]),
        *(M, S, Z),
        loose_mass=(loose_mass + m + rounding) * UPWARDS,
        loose_moment=(max(loose) + math.hypot(s, z) + rounding) * UPWARDS,
    )


def _middle(ends: list[float]) -> tuple[float, float]:
    """The middle of numbers, and half of what they spread."""
    return (min(ends) + max(ends)) / 2.0, (max(ends) - min(ends)) / 2.0
