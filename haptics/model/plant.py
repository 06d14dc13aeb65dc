"""The plant: its state, exact equations of motion, friction, motors, and a hand; compiled.

Coordinates are the platform's position p and velocity v. With `theta_dot_i = G_i . v` (G the inverse Jacobian),
elbow velocity `u_i = L_A theta_dot_i e_i` and its acceleration `L_A (e_i theta_ddot_i - x_i theta_dot_i^2)`, the
forearm of constant length asks `s_i . (v - u_i) = 0`, and once more differentiated
`theta_ddot_i = G_i . a + h_i`, `h_i = (|v - u_i|^2 + L_A theta_dot_i^2 s_i . x_i) / (L_A w_i)`. Virtual work over
`d theta_i = G_i . dp` then gives `M(p) a + c(p, v) = gravity + G^T torque + force` with

    M = (m + 3 m_vv) 1 + sum m_uv L_A (e G^T + G e^T) + (m_uu L_A^2 + I) G G^T
    c = sum m_uv L_A (e h - x theta_dot^2) + (m_uu L_A^2 + I) h G

and the names of `masses`. Friction of a joint is a bristle in series with a slider (Prandtl, Jenkin): its deflection b
follows the turn, `db = d theta / presliding`, until it slips at -1 or 1; torque `-coulomb b - viscous theta_dot -
bristle_damping (1 - b^2) theta_dot`: the last is what metal, cable and grease take while they bend. It sticks without
creeping or ringing on, slips, and is passive. b depends on the path alone, so a step takes it in closed form and no
stiffness is left to the integrator. The motors' currents follow in closed form, too.

What gives way is optional, each as a spring and damper between two masses: the cable between rotor and arm
(`drive_train.py`), the structure between platform and knob, the grasp between knob and arm (`handle.py`). Where all are
rigid, the first twelve states are all there is. Importing this module loads numba.

Source:
    The rods' exact energy in place of the half masses of [RCIM2018]; friction that does not creep under vibration, as
    P. Dupont et al., "Single state elastoplastic friction models", IEEE Trans. Automatic Control 47 (2002), ask of one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from delta_cad.common.jit import compiled, inlined
from delta_cad.common.units import DOWN
from delta_cad.drive.masses import Masses
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.kernel import arm, azimuth, chain_closure, in_base, wrist
from haptics.model.drive_train import ARM_BRISTLES, BRISTLES, MOTOR, STATES, TWIST, bristle, drive_torque, rotor_energy
from haptics.model.handle import handle_energy, handle_force

RIGID = 12  # States that are used where nothing gives way


class Plant(NamedTuple):
    """All parameters of the machine, SI; plain floats, so that compiled code takes it as it is.

    Attributes:
        radius_difference: R_0 - r, of chain 0, m.
        side_difference: R_1 - r, of chains 1 and 2, m.
        side_cosine: Cosine of the azimuth of chain 1; chain 2 mirrors it.
        side_sine: Its sine.
        upper_arm_length: L_A, m.
        forearm_length: L_B, m.
        platform: Mass of the platform with what is rigidly held to it, kg.
        arm_along: First moment of an upper arm along itself, kg m.
        arm_across: First moment along the elbow's motion, kg m.
        joint_inertia: Upper arm, rotor and pinion about the shoulder, kg m^2.
        rod_elbow: m_uu of a chain's rods, kg.
        rod_cross: m_uv, kg.
        rod_wrist: m_vv, kg.
        gravity_x: Acceleration of gravity in the base frame, m/s^2.
        gravity_y: Its part along y, m/s^2.
        gravity_z: Its part along z, m/s^2.
        coulomb: Friction torque of a joint that slips, N m.
        viscous: N m s/rad, where no wall is touched.
        presliding: Turn by which the bristle bends before it slips, rad.
        bristle_damping: Bristle damping of a bristle that is not bent, N m s/rad; none where it slips.
        current_lag: Time constant of the current loop, s; 0 for none.
        rotor_inertia: Rotor and pinion at the joint where the cable gives way, kg m^2; `joint_inertia` is then the
            arm's alone.
        cable_stiffness: Between rotor and arm, N m/rad; 0: rigid.
        cable_damping: N m s/rad.
        arm_coulomb: Share of the friction that rubs behind the cable, N m; `coulomb` is then the rotor's alone.
        knob: Mass of the knob where the structure gives way, kg; `platform` is then the rest.
        structure_stiffness: Between platform and knob, N/m; 0: rigid.
        structure_damping: N s/m.
        stop_low: Shoulder angle at which an arm meets its lower stop, rad; may be infinite.
        stop_high: The upper one, rad.
        stop_stiffness: Of a stop, N m/rad.
        stop_damping: N m s/rad.
        ripple: Largest deviation of a motor's torque from its current's, as a share.
        ripple_per_rad: Waves of it in a radian of the joint, times 2 pi.
        cogging: Largest torque of a motor without a current, at the joint, N m.
        cogging_per_rad: As `ripple_per_rad`.
        bezel_x: x of the middle of the square over which the handle goes under a panel, m.
        bezel_half: Half its side, m.
        bezel_limit: How far outside it the stem meets the bezel, m.
        bezel_stiffness: Of stem and bezel, N/m; 0 where there is no panel.
        bezel_damping: N s/m.
        contact_damping: What the drive damps more while a wall is touched, N m s/rad.
    """

    radius_difference: float
    side_difference: float
    side_cosine: float
    side_sine: float
    upper_arm_length: float
    forearm_length: float
    platform: float
    arm_along: float
    arm_across: float
    joint_inertia: float
    rod_elbow: float
    rod_cross: float
    rod_wrist: float
    gravity_x: float
    gravity_y: float
    gravity_z: float
    coulomb: float
    viscous: float
    presliding: float
    bristle_damping: float
    current_lag: float
    rotor_inertia: float = 0.0
    cable_stiffness: float = 0.0
    cable_damping: float = 0.0
    arm_coulomb: float = 0.0
    knob: float = 0.0
    structure_stiffness: float = 0.0
    structure_damping: float = 0.0
    stop_low: float = -math.inf
    stop_high: float = math.inf
    stop_stiffness: float = 0.0
    stop_damping: float = 0.0
    ripple: float = 0.0
    ripple_per_rad: float = 0.0
    cogging: float = 0.0
    cogging_per_rad: float = 0.0
    bezel_x: float = 0.0
    bezel_half: float = 0.0
    bezel_limit: float = 0.0
    bezel_stiffness: float = 0.0
    bezel_damping: float = 0.0
    contact_damping: float = 0.0

    @property
    def in_contact(self) -> Plant:
        """The device while a wall is touched."""
        return self._replace(viscous=self.viscous + self.contact_damping, contact_damping=0.0)


class Hand(NamedTuple):
    """A hand that holds the handle: the arm's mass, its spring and damper to where the person wants it, and the grasp.

    Attributes:
        mass: kg.
        damping: N s/m.
        stiffness: N/m.
        grasp_stiffness: Between handle and mass, N/m; 0: the mass is rigid on the handle.
        grasp_damping: N s/m.
    """

    mass: float
    damping: float
    stiffness: float
    grasp_stiffness: float = 0.0
    grasp_damping: float = 0.0

    @property
    def leaning(self) -> float:
        """Stiffness with which it leans on a wall, N/m: the grasp's and the arm's springs one behind the other."""
        if self.grasp_stiffness == 0.0:
            return self.stiffness
        return self.stiffness * self.grasp_stiffness / (self.stiffness + self.grasp_stiffness)


FREE = Hand(0.0, 0.0, 0.0)  # No hand


def plant(
    geometry: DeltaGeometry,
    masses: Masses,
    gravity_vector: tuple[float, float, float] = DOWN,
    *,
    coulomb: float = 0.0,
    viscous: float = 0.0,
    presliding: float = 1e-3,
    bristle_damping: float = 0.0,
    current_lag: float = 0.0,
) -> Plant:
    """Collects the parameters of a machine.

    Args:
        geometry: The mechanism.
        masses: Masses of the moving bodies.
        gravity_vector: (3,) in the base frame, m/s^2.
        coulomb: N m at a joint.
        viscous: N m s/rad at a joint.
        presliding: rad, positive.
        bristle_damping: N m s/rad.
        current_lag: s.

    Raises:
        ValueError: A figure is not finite, one is negative, or `presliding` is not positive.
    """
    none_negative = {"coulomb": coulomb, "viscous": viscous, "bristle_damping": bristle_damping}
    for name, value in (none_negative | {"current_lag": current_lag}).items():
        if not (math.isfinite(value) and value >= 0.0):
            raise ValueError(f"{name} is {value!r}; it must be finite and not negative")
    if not (math.isfinite(presliding) and presliding > 0.0):
        raise ValueError(f"presliding is {presliding!r} rad; it must be finite and positive")
    gx, gy, gz = (float(g) for g in gravity_vector)
    return Plant(
        radius_difference=float(geometry.radius_differences[0]),
        side_difference=float(geometry.radius_differences[1]),
        side_cosine=geometry.side_cosine,
        side_sine=geometry.side_sine,
        upper_arm_length=geometry.upper_arm_length,
        forearm_length=geometry.forearm_length,
        platform=masses.platform,
        arm_along=masses.arm_along,
        arm_across=masses.arm_across,
        joint_inertia=masses.arm_inertia + masses.rotor_inertia,
        rod_elbow=masses.rod_elbow,
        rod_cross=masses.rod_cross,
        rod_wrist=masses.rod_wrist,
        gravity_x=gx,
        gravity_y=gy,
        gravity_z=gz,
        coulomb=float(coulomb),
        viscous=float(viscous),
        presliding=float(presliding),
        bristle_damping=float(bristle_damping),
        current_lag=float(current_lag),
    )


@inlined
def chain(par, i, x, y, z):
    """One chain at a position.

    Returns:
        Cosine and sine of the azimuth, cosine and sine of the shoulder angle, w (m), and the forearm s (m) in the base
        frame: 8 floats; NaN where the chain cannot be closed.
    """
    la = par.upper_arm_length
    cos_phi, sin_phi = azimuth(i, par.side_cosine, par.side_sine)
    difference = par.radius_difference if i == 0 else par.side_difference
    q, t = wrist(x, y, difference, cos_phi, sin_phi)
    rho2, m, w2 = chain_closure(q, t, z, la, par.forearm_length)
    w = math.sqrt(w2)
    cos, sin = arm(q, z, rho2, m, w)
    sx, sy = in_base(q - la * cos, t, cos_phi, sin_phi)
    return cos_phi, sin_phi, cos, sin, w, sx, sy, z - la * sin


@inlined
def motion(par, hand_mass, state, out):
    """Mass matrix, bias and joint rates at a state.

    Args:
        par: The plant.
        hand_mass: kg, moves with the platform.
        state: (STATES,) state.
        out: (6, 3) filled: rows 0-2 G, the inverse Jacobian (rad/m); row 3 theta_dot (rad/s); row 4 gravity less c (N);
            row 5 shoulder angles (rad).

    Returns:
        The mass matrix, kg: m11, m22, m33, m12, m13, m23.
    """
    x, y, z, vx, vy, vz = state[0], state[1], state[2], state[3], state[4], state[5]
    la = par.upper_arm_length
    translating_mass = par.platform + hand_mass + 3.0 * par.rod_wrist
    turning = par.rod_elbow * la * la + par.joint_inertia
    cross = par.rod_cross * la
    platform_mass = par.platform + par.knob + 3.0 * (par.rod_cross + par.rod_wrist)  # the hand carries its own weight
    moment = par.arm_along + (par.rod_elbow + par.rod_cross) * la
    m11 = m22 = m33 = translating_mass
    m12 = m13 = m23 = 0.0
    fx, fy, fz = platform_mass * par.gravity_x, platform_mass * par.gravity_y, platform_mass * par.gravity_z
    for i in range(3):
        ca, sa, cos, sin, w, sx, sy, sz = chain(par, i, x, y, z)
        ax, ay, az = ca * cos, sa * cos, sin
        ex, ey, ez = -ca * sin, -sa * sin, cos
        lever = 1.0 / (la * w)
        gx, gy, gz = sx * lever, sy * lever, sz * lever
        rate = gx * vx + gy * vy + gz * vz
        speed = la * rate
        dx, dy, dz = vx - speed * ex, vy - speed * ey, vz - speed * ez
        h = (dx * dx + dy * dy + dz * dz + la * rate * rate * (sx * ax + sy * ay + sz * az)) * lever
        m11 += 2.0 * cross * ex * gx + turning * gx * gx
        m22 += 2.0 * cross * ey * gy + turning * gy * gy
        m33 += 2.0 * cross * ez * gz + turning * gz * gz
        m12 += cross * (ex * gy + gx * ey) + turning * gx * gy
        m13 += cross * (ex * gz + gx * ez) + turning * gx * gz
        m23 += cross * (ey * gz + gy * ez) + turning * gy * gz
        square = rate * rate
        pull = moment * (ex * par.gravity_x + ey * par.gravity_y + ez * par.gravity_z)
        pull -= par.arm_across * (ax * par.gravity_x + ay * par.gravity_y + az * par.gravity_z)
        pull -= turning * h
        fx += pull * gx - cross * (ex * h - ax * square)
        fy += pull * gy - cross * (ey * h - ay * square)
        fz += pull * gz - cross * (ez * h - az * square)
        out[i, 0], out[i, 1], out[i, 2] = gx, gy, gz
        out[3, i] = rate
        out[5, i] = math.atan2(sin, cos)
    out[4, 0], out[4, 1], out[4, 2] = fx, fy, fz
    return m11, m22, m33, m12, m13, m23


@inlined
def derivative(par, hand, anchor, force, command, state, theta, work, out):
    """Time derivative of the state.

    Args:
        par: The plant.
        hand: The hand.
        anchor: (3,) where the person wants the handle, m.
        force: (3,) further force on the handle, N.
        command: (3,) torque commanded of the motors, N m.
        state: (STATES,) state; its bristles are those at the angles `theta` and the twists `theta[3:]`.
        theta: (3,) or (6,) shoulder angles at which the step began, rad, and the cables' twists where they give way.
        work: (6, 3) room; afterwards as `motion` leaves it, but row 4 with all forces.
        out: (STATES,) filled; 0 for the bristles and the motors' torques, which a step takes in closed form.
    """
    carried = hand.mass if par.structure_stiffness <= 0.0 and hand.grasp_stiffness <= 0.0 else 0.0
    m11, m22, m33, m12, m13, m23 = motion(par, carried, state, work)
    fx, fy, fz = handle_force(par, hand, anchor, force, state, out)
    fx, fy, fz = fx + work[4, 0], fy + work[4, 1], fz + work[4, 2]
    for i in range(3):
        torque = drive_torque(par, i, command[i], state, theta, work[5, i], work[3, i], out)
        fx += torque * work[i, 0]
        fy += torque * work[i, 1]
        fz += torque * work[i, 2]
    # cofactors of the symmetric mass matrix
    c11, c22, c33 = m22 * m33 - m23 * m23, m11 * m33 - m13 * m13, m11 * m22 - m12 * m12
    c12, c13, c23 = m13 * m23 - m12 * m33, m12 * m23 - m13 * m22, m12 * m13 - m11 * m23
    over = 1.0 / (m11 * c11 + m12 * c12 + m13 * c13)
    out[0], out[1], out[2] = state[3], state[4], state[5]
    out[3] = (c11 * fx + c12 * fy + c13 * fz) * over
    out[4] = (c12 * fx + c22 * fy + c23 * fz) * over
    out[5] = (c13 * fx + c23 * fy + c33 * fz) * over


@compiled
def angles(par, state, out):
    """Fills (3,) shoulder angles, rad; NaN where a chain cannot be closed."""
    for i in range(3):
        _, _, cos, sin, _, _, _, _ = chain(par, i, state[0], state[1], state[2])
        out[i] = math.atan2(sin, cos)


@compiled
def advance(par, hand, anchor, force, command, seconds, steps, state, room):
    """Moves the state on by equal steps of the classical Runge-Kutta method; command and anchor are held.

    Args:
        par: The plant.
        hand: The hand.
        anchor: (3,) m.
        force: (3,) N.
        command: (3,) N m.
        seconds: Time, s.
        steps: Number of steps.
        state: (STATES,) moved on in place.
        room: (13, STATES) room; row 5 ends with the shoulder angles (rad) in its first three places.
    """
    theta = room[5, :6]
    angles(par, state, theta)
    for i in range(3):
        theta[3 + i] = state[TWIST + i]
    moved_on(par, hand, anchor, force, command, seconds, steps, state, theta, room)


@inlined
def moved_on(par, hand, anchor, force, command, seconds, steps, state, theta, room):
    """As `advance`; theta are shoulder angles and the cables' twists at the state, (6,) rad, moved on in place, too."""
    dt = seconds / steps
    work, stage, after = room[6:12, :3], room[4], room[12, :3]
    gives = par.cable_stiffness > 0.0 or par.structure_stiffness > 0.0 or hand.grasp_stiffness > 0.0
    used = STATES if gives else RIGID
    stays = math.exp(-0.5 * dt / par.current_lag) if par.current_lag > 0.0 else 0.0  # of a motor's error in half a step
    for _ in range(steps):
        for s in range(4):  # of Runge and Kutta; one call, so that all of it is one piece of machine code
            whole = 0.5 if s in (1, 2) else 1.0
            for k in range(used):
                stage[k] = state[k] + (whole * dt * room[s - 1, k] if s > 0 else 0.0)
            for i in range(3):
                left = 1.0 if s == 0 else (stays if s < 3 else stays * stays)
                stage[MOTOR + i] = command[i] + left * (state[MOTOR + i] - command[i])
            derivative(par, hand, anchor, force, command, stage, theta, work, room[s])
        for k in range(used):
            state[k] += dt / 6.0 * (room[0, k] + 2.0 * (room[1, k] + room[2, k]) + room[3, k])
        angles(par, state, after)
        for i in range(3):
            state[MOTOR + i] = command[i] + stays * stays * (state[MOTOR + i] - command[i])
            turn, twist = after[i] - theta[i], state[TWIST + i] - theta[3 + i]
            state[BRISTLES + i] = bristle(state[BRISTLES + i], turn + twist, par.presliding)
            state[ARM_BRISTLES + i] = bristle(state[ARM_BRISTLES + i], turn, par.presliding)
            theta[i], theta[3 + i] = after[i], state[TWIST + i]


@compiled
def energy(par, hand_mass, state):
    """Kinetic and potential energy of the moving bodies, J, without the hand's spring.

    The kinetic energy is summed over the bodies from their velocities, not taken from the mass matrix.
    """
    vx, vy, vz = state[3], state[4], state[5]
    la = par.upper_arm_length
    v2 = vx * vx + vy * vy + vz * vz
    kinetic = 0.5 * (par.platform + hand_mass) * v2
    platform_mass = par.platform + par.knob + 3.0 * (par.rod_cross + par.rod_wrist)
    moment = par.arm_along + (par.rod_elbow + par.rod_cross) * la
    height = par.gravity_x * state[0] + par.gravity_y * state[1] + par.gravity_z * state[2]
    potential = -platform_mass * height
    for i in range(3):
        ca, sa, cos, sin, w, sx, sy, sz = chain(par, i, state[0], state[1], state[2])
        rate = (sx * vx + sy * vy + sz * vz) / (la * w)
        along = ca * cos * par.gravity_x + sa * cos * par.gravity_y + sin * par.gravity_z
        across = -ca * sin * par.gravity_x - sa * sin * par.gravity_y + cos * par.gravity_z
        product = la * rate * (cos * vz - sin * (ca * vx + sa * vy))
        kinetic += 0.5 * par.joint_inertia * rate * rate
        kinetic += 0.5 * (par.rod_elbow * (la * rate) ** 2 + 2.0 * par.rod_cross * product + par.rod_wrist * v2)
        potential -= moment * along + par.arm_across * across
        turning, wound = rotor_energy(par, i, state)
        kinetic, potential = kinetic + turning, potential + wound
    moving, bent = handle_energy(par, state)
    return kinetic + moving, potential + bent
