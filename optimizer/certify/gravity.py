"""Gravity's part in a joint's torque: that of a build's masses, see `drive.held`, or a torque given by hand.

A torque given by hand is taken off that of every joint.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from delta_cad.drive.held import held_masses
from delta_cad.drive.masses import MassError, numbers_of, read_mass_properties
from delta_cad.mechanism import GeometryError
from delta_cad.mechanism.limits import HeldMasses, HoldingTorque, Limits, Torque

if TYPE_CHECKING:
    from delta_cad.design import Design

# Agreement of the home positions of file and design, a sum of two lengths in mm: 1e-13 of rounding.
_HOME_MM = 1e-6


class GravityError(ValueError):
    """Mass properties or a share of gravity that cannot be used; the message says which field and why."""


@dataclass(frozen=True)
class GravityAllowance:
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
        """Checks in exact fractions that the conditions of a certificate allow for gravity as it says.

        Returns:
            The fault, or None.
        """
        if self.masses is not None:
            held = limits.get(HoldingTorque)
            if held is None:
                return "gravity is counted in by masses, but no torque with gravity is asked"
            if held.less_strict_than(HoldingTorque(self.force, self.torque, self.masses)):
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


def given_allowance(design: Design, reserve: float) -> GravityAllowance:
    """Makes the share of a reserve given by hand.

    Args:
        design: The design.
        reserve: Taken off the torque of each joint, N m.

    Raises:
        GravityError: The reserve is negative, not finite, or leaves no torque.
    """
    r = design.requirements
    if not (math.isfinite(reserve) and 0.0 <= reserve < r.joint_torque_N_m):
        allowed = f"must be >= 0 and < requirements.joint_torque_N_m = {r.joint_torque_N_m:g} N m"
        raise GravityError(f"gravity torque = {reserve:g}: {allowed}")
    return GravityAllowance(r.force_N, r.joint_torque_N_m, reserve)


def allowance_of_masses(path: Path, design: Design, tolerance: float = 0.0) -> GravityAllowance:
    """Reads what a build wrote about its masses, `mass_properties.json`.

    Args:
        path: The file.
        design: The design that was built.
        tolerance: Of the links' lengths, m: the masses act anywhere within it.

    Raises:
        GravityError: Unreadable, not mass properties, of another design, or with bodies that the limit does not know.
    """
    try:
        data, content = read_mass_properties(path, design)
        home, drawn = data.get("home_mm"), design.home_mm
        here = numbers_of(home, (3,))
        if here is None or (abs(here - drawn) > _HOME_MM).any():
            raise GravityError(f"{path.name}: home_mm = {home}: is not {drawn.tolist()} mm, where this design is drawn")
        masses = held_masses(path.name, data.get("bodies"), design, tolerance)
    except (MassError, GeometryError) as error:
        raise GravityError(str(error)) from None
    r = design.requirements
    return GravityAllowance(r.force_N, r.joint_torque_N_m, None, hashlib.sha256(content).hexdigest(), masses)
