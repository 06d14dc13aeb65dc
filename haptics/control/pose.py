"""The pose from the encoders: position, Jacobian, singularity margins and holding torque; compiled.

Everything follows from the shoulder angles in closed form: the position from three spheres, the forearms from it, and
the Jacobian's columns `J_i = L_A w_i (s_j x s_k) / det S`. The same formulas stand in `delta_cad.mechanism` for arrays;
here they are scalars without allocation, for a controller that has a millisecond. Importing this module loads numba.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from delta_cad.common.jit import compiled
from delta_cad.drive.masses import Masses
from delta_cad.mechanism.geometry import DeltaGeometry
from haptics.control.pose_margins import singularity_margins
from haptics.control.sincos import sincos

POSITION, RATES, HOLDING = 3, 4, 5  # Rows of what `pose` fills; rows 0-2 are the Jacobian's columns
ROWS = 6


class Model(NamedTuple):
    """Parameters of the device as the controller knows it, SI; plain floats.

    Attributes:
        radius_difference: R_0 - r, of chain 0, m.
        side_difference: R_1 - r, of chains 1 and 2, m.
        side_cosine: Cosine of the azimuth of chain 1; chain 2 mirrors it.
        side_sine: Its sine.
        upper_arm_length: L_A, m.
        forearm_length: L_B, m.
        hanging: Mass on the wrists, kg.
        moment: First moment of an upper arm and the rods on its elbow, along the arm, kg m.
        across: First moment along the elbow's motion, kg m.
        gravity_x: m/s^2 in the base frame, as gravity_y, gravity_z.
        gravity_y: m/s^2.
        gravity_z: m/s^2.
    """

    radius_difference: float
    side_difference: float
    side_cosine: float
    side_sine: float
    upper_arm_length: float
    forearm_length: float
    below_elbows: float
    moment: float
    across: float
    gravity_x: float
    gravity_y: float
    gravity_z: float


def model(geometry: DeltaGeometry, masses: Masses, gravity_vector: tuple[float, float, float]) -> Model:
    """The controller's model of a device.

    Args:
        geometry: The mechanism.
        masses: Masses of the moving bodies.
        gravity_vector: (3,) in the base frame, m/s^2.
    """
    gx, gy, gz = (float(g) for g in gravity_vector)
    return Model(
        radius_difference=float(geometry.radius_differences[0]),
        side_difference=float(geometry.radius_differences[1]),
        side_cosine=geometry.side_cosine,
        side_sine=geometry.side_sine,
        upper_arm_length=geometry.upper_arm_length,
        forearm_length=geometry.forearm_length,
        below_elbows=masses.at_wrists,
        moment=masses.arm_along + masses.at_elbow * geometry.upper_arm_length,
        across=masses.arm_across,
        gravity_x=gx,
        gravity_y=gy,
        gravity_z=gz,
    )


@compiled
def pose(known, theta, out):
    """Position, Jacobian, holding torque and margins at shoulder angles.

    Args:
        known: `Model`.
        theta: (3,) shoulder angles, rad.
        out: (ROWS, 3) filled: rows 0-2 columns of J, the velocity (m/s) per joint rate (rad/s); row 3 position (m);
            row 5 holding torque (N m). Row 4 is left alone. NaN where the spheres do not meet.

    Returns:
        Smallest w of the chains (m), and det S / L_B^3: the distances to both kinds of singularity; NaN likewise.
    """
    la, lb = known.upper_arm_length, known.forearm_length
    a, side, cs, sn = known.radius_difference, known.side_difference, known.side_cosine, known.side_sine
    s0, c0 = sincos(theta[0])
    s1, c1 = sincos(theta[1])
    s2, c2 = sincos(theta[2])
    r0, r1, r2 = a + la * c0, side + la * c1, side + la * c2
    # sphere centres: the elbows, moved in by the platform's radius
    x0, y0, z0 = r0, 0.0, la * s0
    x1, y1, z1 = cs * r1, sn * r1, la * s1
    x2, y2, z2 = cs * r2, -sn * r2, la * s2
    bx, by, bz = x1 - x0, y1 - y0, z1 - z0
    cx, cy, cz = x2 - x0, y2 - y0, z2 - z0
    nx, ny, nz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    b2, cc, n2 = bx * bx + by * by + bz * bz, cx * cx + cy * cy + cz * cz, nx * nx + ny * ny + nz * nz
    half = 0.5 / n2
    ux = (cc * (ny * bz - nz * by) + b2 * (cy * nz - cz * ny)) * half
    uy = (cc * (nz * bx - nx * bz) + b2 * (cz * nx - cx * nz)) * half
    uz = (cc * (nx * by - ny * bx) + b2 * (cx * ny - cy * nx)) * half
    up = math.sqrt((lb * lb - (ux * ux + uy * uy + uz * uz)) / n2)
    px, py, pz = x0 + ux + up * nx, y0 + uy + up * ny, z0 + uz + up * nz
    ax, ay, az = px - x0, py - y0, pz - z0
    dx, dy, dz = px - x1, py - y1, pz - z1
    ex, ey, ez = px - x2, py - y2, pz - z2
    # w: the forearm along the elbow's direction of motion, -sin radial + cos up
    w0 = c0 * az - s0 * ax
    w1 = c1 * dz - s1 * (cs * dx + sn * dy)
    w2 = c2 * ez - s2 * (cs * ex - sn * ey)
    fx, fy, fz = dy * ez - dz * ey, dz * ex - dx * ez, dx * ey - dy * ex
    det = ax * fx + ay * fy + az * fz
    scale = la / det
    out[0, 0], out[0, 1], out[0, 2] = scale * w0 * fx, scale * w0 * fy, scale * w0 * fz
    k = scale * w1
    out[1, 0], out[1, 1], out[1, 2] = k * (ey * az - ez * ay), k * (ez * ax - ex * az), k * (ex * ay - ey * ax)
    k = scale * w2
    out[2, 0], out[2, 1], out[2, 2] = k * (ay * dz - az * dy), k * (az * dx - ax * dz), k * (ax * dy - ay * dx)
    out[3, 0], out[3, 1], out[3, 2] = px, py, pz
    gx, gy, gz = known.gravity_x, known.gravity_y, known.gravity_z
    for i in range(3):
        c, s = (c0, s0) if i == 0 else ((c1, s1) if i == 1 else (c2, s2))
        g = gx if i == 0 else (cs * gx + sn * gy if i == 1 else cs * gx - sn * gy)  # along the radius
        platform = out[i, 0] * gx + out[i, 1] * gy + out[i, 2] * gz
        out[5, i] = -known.below_elbows * platform - known.moment * (c * gz - s * g) + known.across * (c * g + s * gz)
    return singularity_margins(w0, w1, w2, det, lb)
