"""Limits from plain numbers, as most tests state them."""

from __future__ import annotations

from delta_cad.mechanism.limits import (
    AssemblyMode,
    CoupleIndex,
    EffectiveMass,
    ElbowAngle,
    Friction,
    HandleFriction,
    HandleInertia,
    HeldMasses,
    HoldingTorque,
    Kappa,
    Lean,
    Limits,
    PositionStep,
    Reach,
    Shoulder,
    Torque,
)


def limits(
    elbow_arm_min: float = 0.0,
    assembly_mode: bool = True,
    force: float | None = None,
    torque_max: float | None = None,
    kappa_max: float | None = None,
    shoulder: tuple[float, float] | None = None,
    lean_max: float | None = None,
    mass_max: float | None = None,
    inertia: HandleInertia | None = None,
    couple_index_min: float | None = None,
    held: tuple[float, float, HeldMasses] | None = None,
    friction: tuple[float, HandleFriction] | None = None,
    step: tuple[float, float] | None = None,
    elbow_angle_min: float | None = None,
) -> Limits:
    """Limits with these thresholds in SI units; None leaves one out."""
    return Limits.of(
        Reach(elbow_arm_min),
        AssemblyMode() if assembly_mode else None,
        None if force is None or torque_max is None else Torque(force, torque_max),
        None if kappa_max is None else Kappa(kappa_max),
        None if lean_max is None else Lean(lean_max),
        None if shoulder is None else Shoulder(*shoulder),
        None if mass_max is None or inertia is None else EffectiveMass(mass_max, inertia),
        None if couple_index_min is None else CoupleIndex(couple_index_min),
        None if held is None else HoldingTorque(*held),
        None if friction is None else Friction(friction[0], *friction[1]),
        None if step is None else PositionStep(*step),
        None if elbow_angle_min is None else ElbowAngle(elbow_angle_min),
    )
