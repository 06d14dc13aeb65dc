"""Feel of a machine: figures over its cube, whatever limits are set, and those worse than a default left out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from delta_cad.design import Design
from delta_cad.design.feel_defaults import feel_defaults
from delta_cad.dimensions.joint import known_joints
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import masses_from_dict
from delta_cad.mechanism.limits import CoupleIndex, EffectiveMass, Friction, Kappa
from delta_cad.mechanism.limits.limit import PoseLimit
from delta_cad.mechanism.proof.extremes import worst_of
from delta_cad.mechanism.workspace import CubeSearch

_KINDS: Mapping[str, type[PoseLimit]] = {
    "effective_mass_max_kg": EffectiveMass,
    "friction_max_N": Friction,
    "couple_index_min": CoupleIndex,
    "kappa_max": Kappa,
}
"""Field of the requirements -> the limit that it sets."""
_WORSE = 5e-3  # share of a default by which a result is worse: three digits of both are printed


def feel_figures(design: Design, masses: Mapping[str, Any]) -> dict[str, float]:
    """Computes the worst over the cube of each figure of feel that is known of a machine.

    Args:
        design: The machine.
        masses: Result of `mass_report`.

    Returns:
        Key of `_KINDS` -> kg, N or a number; without friction where no friction is known of the motor.
    """
    inertia = masses_from_dict(masses, design.geometry.forearm_length, drive_torque(design)).handle_inertia
    known, search = known_joints(design) | {"inertia": inertia}, CubeSearch(design.workspace)
    limits = {key: kind.measured(known) for key, kind in _KINDS.items()}
    return {
        key: worst_of(search, design.geometry, limit, limit.figures[0]).value
        for key, limit in limits.items()
        if limit is not None
    }


def poor_figures(design: Design, masses: Mapping[str, Any]) -> list[str]:
    """Lists the figures of a machine that are worse than a default limit of feel that its design leaves out.

    Args:
        design: The machine.
        masses: Result of `mass_report`.

    Returns:
        Each with its value and the default, as text.
    """
    required, values = design.requirements, feel_figures(design, masses)
    found = list[str]()
    for key, default in feel_defaults(required.force_N).items():
        if getattr(required, key) is not None or (value := values.get(key)) is None:
            continue
        figure = _KINDS[key].figures[0]
        if (value - default if figure.upper else default - value) > _WORSE * default:
            words = f"{figure.words} {value:.3g} {figure.unit}".rstrip()
            found.append(f"{words}, at {'most' if figure.upper else 'least'} {default:.3g}")
    return found


def poor_verdict(poor: list[str]) -> str:
    """States the verdict on a machine that passes every check and has such figures; "" without any."""
    return f"holds, but poor as a haptic device: {'; '.join(poor)}" if poor else ""
