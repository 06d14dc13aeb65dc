"""Limits of the supervisor: a checked record of plain floats, computed from a design."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design, DesignError
from delta_cad.drive import drive_torque, encoder_count_rad
from delta_cad.mechanism import Cube, DeltaGeometry
from delta_cad.mechanism.inverse import closure_margin, forearm_vectors, joint_angles
from delta_cad.mechanism.jacobian import forearm_determinant, inverse_jacobian
from haptics.model.motor_heat import REFERENCE_C, Heat, motor_heat

# Points an edge of the cube at which range, reach and volume are looked up. The thresholds made of them keep 40 % and
# more distance from the extremes, far more than what lies between two points (5 % at 7 points an edge).
GRID = 13


class SafetyLimits(NamedTuple):
    """All limits, SI, in plain floats that compiled code takes as they are. `math.inf` switches one off where said.

    Attributes:
        period: Time between two ticks, s.
        encoder_count: One count of an encoder at the joint, rad.
        joint_speed: Faster than any joint can turn, rad/s.
        joint_acceleration: The most by which a joint's speed grows, rad/s^2.
        theta_low: Smallest shoulder angle, rad.
        theta_high: Largest, rad.
        frozen_turn: Another joint's turn during which a joint must have moved one count, rad; may be infinite.
        frozen_torque: Rendered torque under which an encoder must not stand still for ever, N m; may be infinite.
        frozen_time: After this time under that torque the force is taken away to see whether a count changes, s.
        probe_time: Time in which it is taken away, and for half of which it stays away, s.
        repeats: Ticks for which one encoder may repeat its reading; infinite where its noise is not known.
        all_repeat: Ticks for which all three may do so together; likewise.
        kink: Turn in a tick by which a joint may gain speed on the tick before, rad; may be infinite. A stop or a hand
            turns a joint round, which is no gain.
        unread: Ticks in a row that may be left out because a reading is not fresh.
        late: Interval above which a tick is late, s.
        missed: Interval above which one tick is a fault, s.
        late_ticks: Number of late ticks that are a fault.
        late_recovery: Time after which one of them is forgotten, s.
        cube_x: x of the cube's middle, m.
        cube_half: L, m.
        cube_bottom: H, m.
        edge_margin: The handle may leave the cube by this, m.
        edge_far: Outside by this is a fault, m.
        reach_low: Closure w below which force fades, m.
        reach_min: Closure w below which it is a fault, m.
        volume_low: det S / L_B^3 below which force fades.
        volume_min: det S / L_B^3 below which it is a fault.
        speed: Speed of the handle, m/s.
        velocity_lag: Time constant of the supervisor's own velocities, s.
        torque: Torque of a joint, N m.
        slew: Slew of the rendered torque, N m/s.
        gravity_slew: Slew of the gravity torque, N m/s; the output's slew is the sum of both.
        damping: Coefficient of the damping reaction, N m s/rad.
        lowering: Time in which weight and damping go after a fault that lets the weight down, s.
        stale: Age of the host's last command at which force fades, s; infinite for a controller without host.
        fade: Time in which it fades then, s.
        ramp: Time in which force comes in after enabling, or comes back, s.
        ramp_fall: Time in which it goes again while the scene pushes the handle away, s;
            also that over which its power is averaged.
        ramp_power: Power to the hand up to which force goes on coming in, W.
        energy: Capacity of the energy tank, J.
        energy_start: Level of the tank at enabling, J.
        energy_time: Time of asking for more than the tank has that is a fault, s.
        motor: Thermal parameters of each joint's motor.
    """

    period: float
    encoder_count: float
    joint_speed: float
    joint_acceleration: float
    theta_low: float
    theta_high: float
    frozen_turn: float
    frozen_torque: float
    frozen_time: float
    probe_time: float
    repeats: float
    all_repeat: float
    kink: float
    unread: float
    late: float
    missed: float
    late_ticks: float
    late_recovery: float
    cube_x: float
    cube_half: float
    cube_bottom: float
    edge_margin: float
    edge_far: float
    reach_low: float
    reach_min: float
    volume_low: float
    volume_min: float
    speed: float
    velocity_lag: float
    torque: float
    slew: float
    gravity_slew: float
    damping: float
    lowering: float
    stale: float
    fade: float
    ramp: float
    ramp_fall: float
    ramp_power: float
    energy: float
    energy_start: float
    energy_time: float
    motor: Heat


SIGNED = ("theta_low", "theta_high", "ambient", "derate", "hottest", "cube_x", "cube_bottom")
ZERO_ALLOWED = (
    "damping",
    "velocity_lag",
    "ramp_power",
    "edge_margin",
    "slope",
    "coupling",
    "heat",
    "energy_start",
    "unread",
)
OFF_ALLOWED = ("frozen_turn", "frozen_torque", "repeats", "all_repeat", "kink", "stale")
# Pairs of which the first must be smaller.
RISING = (
    ("theta_low", "theta_high"),
    ("period", "late"),
    ("late", "missed"),
    ("edge_margin", "edge_far"),
    ("reach_min", "reach_low"),
    ("volume_min", "volume_low"),
    ("ambient", "derate"),
    ("derate", "hottest"),
)


def checked(limits: SafetyLimits) -> SafetyLimits:
    """The limits, if they make sense.

    Raises:
        ValueError: A figure is not finite, not positive, or two of them contradict each other; the message names them.
    """
    figures: dict[str, float] = limits._asdict() | limits.motor._asdict()
    del figures["motor"]
    for name, value in figures.items():
        finite = math.isfinite(value) or (name in OFF_ALLOWED and value == math.inf)
        if not finite or (name not in SIGNED and not (value > 0.0 or (value == 0.0 and name in ZERO_ALLOWED))):
            raise ValueError(f"{name} is {value!r}; it must be finite" + ("" if name in SIGNED else " and positive"))
    for low, high in RISING:
        if not figures[low] < figures[high]:
            raise ValueError(f"{low} is {figures[low]!r}; it must be below {high}, {figures[high]!r}")
    for low, high, why in (
        ("gravity_slew", "slew", "so that the rendered torque can always make room for it"),
        ("energy_start", "energy", "the tank's capacity"),
    ):
        if not figures[low] <= figures[high]:
            raise ValueError(f"{low} is {figures[low]!r}; it must be at most {high}: {why}")
    return limits


def safety_limits(
    design: Design, *, period: float = 1e-3, ambient_C: float = REFERENCE_C, **changes: float
) -> SafetyLimits:
    """The limits of a design's machine.

    Torque: what the design asks of a joint, or the drive's peak if that is less. Joint speed: one and a half times the
    turn that the fastest allowed handle gives a joint anywhere in the cube. Joint acceleration: that of the bare rotor
    under twice the torque, once from the motor and once from the hand. Energy: the required force along the cube's
    diagonal, so that no scene with a potential within that force is ever stopped. Thresholds of reach and volume: 60 %
    and 30 % of the smallest in the cube and its margin.

    Args:
        design: A validated design.
        period: Period of the tick, s.
        ambient_C: Temperature of the air at the motors.
        **changes: Any figure of `SafetyLimits` or of its motor's `Heat`, to replace what follows from the design.

    Raises:
        DesignError: The cube, or the margin beyond it, holds a point out of reach or of another assembly mode.
        ValueError: See `checked` and `motor_heat`; or an unknown name.
    """
    legal = (*SafetyLimits._fields[:-1], *Heat._fields)
    unknown = sorted(set(changes) - set(legal))
    if unknown:
        raise ValueError(f"there is no limit {', '.join(unknown)}; legal: {', '.join(legal)}")
    g, drive = design.geometry, drive_torque(design)
    cube = design.workspace
    margin, far, speed = changes.get("edge_margin", 3e-3), changes.get("edge_far", 12e-3), changes.get("speed", 2.0)
    low, high, _, _, _ = _extremes(g, cube, far)
    _, _, reach, volume, turn = _extremes(g, cube, margin)
    if not (reach > 0.0 and volume > 0.0):
        allowed = (
            f"must be smaller, or bottom_height_mm another: the handle may leave the cube by {margin * MM_PER_M:g} mm, "
            "and there it must be within reach and in the assembly mode det S > 0 for the supervisor to hold it"
        )
        raise DesignError(design.name, "cube.half_side_mm", f"{design.cube.half_side_mm:g}", allowed)
    torque = drive.controlled_torque_N_m
    joint_speed, growth = 1.5 * speed * turn, 2.0 * torque / drive.reflected_inertia_kg_m2
    count = encoder_count_rad(design)
    diagonal = 2.0 * math.sqrt(3.0) * cube.half_side
    energy = changes.get("energy", design.requirements.force_N * diagonal)
    heat = motor_heat(catalogue.motor.chosen(design.hardware), drive.ratio * drive.efficiency, ambient_C)
    values = {
        "period": period,
        "encoder_count": count,
        "joint_speed": joint_speed,
        "joint_acceleration": growth,
        "theta_low": low - 0.05,
        "theta_high": high + 0.05,
        "frozen_turn": 1.2,
        "frozen_torque": 0.25 * torque,
        "frozen_time": 2.0,
        "probe_time": 0.2,
        "repeats": math.inf,
        "all_repeat": math.inf,
        "kink": growth * (1.5 * period) ** 2 + 4.0 * count,
        "unread": 2.0,
        "late": 1.5 * period,
        "missed": 20.0 * period,
        "late_ticks": 10.0,
        "late_recovery": 100.0 * period,
        "cube_x": cube.centre_x,
        "cube_half": cube.half_side,
        "cube_bottom": cube.bottom_height,
        "edge_margin": margin,
        "edge_far": far,
        "reach_low": 0.6 * reach,
        "reach_min": 0.3 * reach,
        "volume_low": 0.6 * volume,
        "volume_min": 0.3 * volume,
        "speed": speed,
        "velocity_lag": 2.0 * period,
        "torque": torque,
        "slew": torque / (2.0 * period),
        "gravity_slew": 5.0 * torque,
        "damping": 0.02,
        "lowering": 1.0,
        "stale": math.inf,
        "fade": 0.2,
        "ramp": 0.5,
        "ramp_fall": 0.02,
        "ramp_power": 0.05,
        "energy": energy,
        "energy_start": energy,
        "energy_time": 1.0,
    }
    heat = heat._replace(**{name: changes.pop(name) for name in Heat._fields if name in changes})
    return checked(SafetyLimits(**{**values, **changes}, motor=heat))


def _extremes(g: DeltaGeometry, cube: Cube, margin: float) -> tuple[float, float, float, float, float]:
    """Over the cube and a margin: smallest and largest angle (rad; where it can be reached), smallest w (m) and
    det S / L_B^3 (NaN if a point cannot be reached), and over the cube the largest |G_i| (rad/m).
    """
    half = cube.half_side
    grid = np.linspace(-half - margin, half + margin, GRID)
    x, y, z = np.meshgrid(grid + cube.centre_x, grid, grid + half + cube.bottom_height, indexing="ij")
    p = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    w2 = closure_margin(g, p)
    closed = (w2 >= 0.0).all(axis=-1)
    theta = joint_angles(g, p[closed])
    if not closed.all():
        return float(theta.min(initial=0.0)), float(theta.max(initial=0.0)), math.nan, math.nan, math.nan
    volume = forearm_determinant(forearm_vectors(g, p)) / g.forearm_length**3
    turn = np.linalg.norm(inverse_jacobian(g, p), axis=-1).max() if w2.min() > 0.0 and volume.min() > 0.0 else math.nan
    return float(theta.min()), float(theta.max()), float(np.sqrt(w2.min())), float(volume.min()), float(turn)
