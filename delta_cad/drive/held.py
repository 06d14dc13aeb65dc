"""What a build's masses are to the limits that need them: the inertia at the handle, and what gravity acts on.

What a shoulder holds at p, with `J_i` the platform's velocity per unit rate of joint i (column i of J):

- platform: it does not turn, so its mass moves with `J_i`;
- rod of mass m whose centre is at the share f of the line from elbow to wrist: `(1 - f)` of m moves with the elbow,
  `L_A` per unit rate and of chain i alone, f of it with the wrist, that is with `J_i`. A centre at e beside the line
  moves at most `e (|J_i| + L_A) / L_B` more: a rod is free to turn about its line, so that its spin takes no torque;
- upper arm: its centre, along the arm and square to it, moves with the arm;
- pinion: its centre moves with its distance from its own axis times the turns of the pinion per turn of the arm.

`HoldingTorque` says what these sums are to it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from delta_cad.common.refusal import LONGEST, short
from delta_cad.design import Design
from delta_cad.drive.masses import CHAINS, MassError, mass_and_centre, masses_from_dict
from delta_cad.drive.report import drive_torque
from delta_cad.mechanism.limits import HeldMasses

_RODS = tuple(f"rod_{i}_{j}" for i in CHAINS for j in range(2))
NEEDED = ("platform", *(f"upper_arm_{i}" for i in CHAINS), *_RODS)
KNOWN = ("base", *NEEDED, *(f"pinion_{i}" for i in CHAINS))
_UPWARDS = 1.0 + 2.0**-40  # lifts a sum of some twenty products over its own rounding, 2^-47 of it at most


def known_masses(data: Mapping[str, Any], design: Design, file: str = "masses") -> dict[str, Any]:
    """Gathers what limits need to know of a machine's masses.

    Args:
        data: As `mass_properties.json` has them.
        design: The design that was built.
        file: Name that messages start with.

    Returns:
        `inertia`, a `HandleInertia`, and `held_masses`.

    Raises:
        MassError: A body is unknown or missing, or its numbers are refused.
    """
    masses = masses_from_dict(data, design.geometry.forearm_length, drive_torque(design), file)
    return {"inertia": masses.handle_inertia, "held_masses": held_masses(file, data.get("bodies"), design)}


def held_masses(file: str, bodies: object, design: Design, tolerance: float = 0.0) -> HeldMasses:
    """Sums up what gravity acts on, as the module's docstring says; what chains and tolerance spread is loose.

    Args:
        file: Name that messages start with.
        bodies: Link -> mass and centre, as `mass_properties.json` has them.
        design: The design.
        tolerance: Of the links' lengths, m.

    Raises:
        MassError: A body is unknown or missing, or its numbers are refused.
    """
    if not isinstance(bodies, Mapping):
        raise MassError(file, "bodies", "", "is missing")
    unknown = [name for name in bodies if name not in KNOWN]
    if unknown:
        name = unknown[0] if unknown[0].isidentifier() and len(unknown[0]) <= LONGEST else short(unknown[0])
        raise MassError(file, f"bodies.{name}", "", f"is no body that the bound knows; known: {', '.join(KNOWN)}")
    of = {name: mass_and_centre(bodies, name, file) for name in KNOWN if name in bodies or name in NEEDED}
    arms, rods = (
        (length - tolerance, length + tolerance)
        for length in (design.geometry.upper_arm_length, design.geometry.forearm_length)
    )
    ratio = design.hardware.capstan_ratio if design.hardware.drive == "capstan" else 1.0
    carried, loose_mass = [of["platform"][0]] * 2, 0.0
    along, across, loose = [], [], []
    for i in CHAINS:
        moment, adjacent = [0.0, 0.0], 0.0
        for name in _RODS[2 * i : 2 * i + 2]:
            mass, (x, y, z) = of[name]
            shares = sorted(x / length for length in rods)
            off = mass * math.hypot(y, z) / rods[0]
            loose_mass, adjacent = loose_mass + off, adjacent + off * arms[1]
            carried = [total + mass * share for total, share in zip(carried, shares, strict=True)]
            ends = [mass * (1.0 - share) * arm for share in shares for arm in arms]
            moment = [moment[0] + min(ends), moment[1] + max(ends)]
        mass, (x, _, z) = of[f"upper_arm_{i}"]
        along += [end + mass * x for end in moment]
        across.append(mass * z)
        mass, (x, _, z) = of.get(f"pinion_{i}", (0.0, (0.0, 0.0, 0.0)))
        loose.append(adjacent + ratio * mass * math.hypot(x, z))
    (M, m), (S, s), (Z, z) = (_middle(ends) for ends in (carried, along, across))
    gravity = design.requirements.gravity_m_s2
    rounding = (_UPWARDS - 1.0) * (abs(M) + abs(S) + abs(Z))
    return HeldMasses(
        *(gravity[0], abs(gravity[1]), gravity[2]),
        *(M, S, Z),
        loose_mass=(loose_mass + m + rounding) * _UPWARDS,
        loose_moment=(max(loose) + math.hypot(s, z) + rounding) * _UPWARDS,
    )


def _middle(ends: list[float]) -> tuple[float, float]:
    """The middle of numbers, and half of what they spread."""
    return (min(ends) + max(ends)) / 2.0, (max(ends) - min(ends)) / 2.0
