"""Maps readings of a made device to the drawn one, and torques of the drawn device to the made one; compiled.

A controller that knows the drawn lengths alone is right about a calibrated device if it sees, in place of the readings,
the angles that the drawn device has where the made one is: readings to angles, angles to the position by the made
lengths, the position to the drawn angles. Torques, which act on angles and not on readings, go back by the derivative
`D = d drawn / d angle`: `torque = D^T torque_drawn` has the same power, so that force and gravity come out at the
handle as they were meant.
Scalars without allocation, in the subset of the language that the firmware is translated from, with sine and cosine of
our own: a board computes the same bits. Importing this module loads numba.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.kernel import azimuth
from haptics.calibration.unknowns import LENGTHS, Unknowns
from haptics.control.sincos import sincos

# Rows of what `correct` fills; rows 0-2 are D, row i the drawn angle of chain i by each angle; row 5 the made angles.
POSITION, DRAWN, ANGLE = 3, 4, 5
# Rows of work: elbows, then forearms; of the made device's angles; the handle's velocity by the rate of each made arm.
ELBOW, COS, SIN, MOVES = 6, 9, 10, 11
ROWS = 14
# Columns of the table, by chain: radius difference, upper arm, forearm, side and height offset, zero, four waves.
COLUMNS = 10
TAU = 2.0 * math.pi
MOST_TURNS = 1e4  # rad of an encoder's own turn: beyond, no encoder is, and a whole number of turns might not fit


class Correction(NamedTuple):
    """Parameters of the map, SI.

    Attributes:
        radius_difference: R_0 - r of chain 0 as drawn, m.
        side_difference: R_1 - r of chains 1 and 2 as drawn, m.
        side_cosine: Cosine of the azimuth of chain 1 as drawn; chain 2 mirrors it.
        side_sine: Its sine.
        upper_arm_length: L_A as drawn, m.
        forearm_length: L_B as drawn, m.
        turns: Turns of an encoder in one of the arm.
        table: (3, COLUMNS) of the made device.
    """

    radius_difference: float
    side_difference: float
    side_cosine: float
    side_sine: float
    upper_arm_length: float
    forearm_length: float
    turns: float
    table: np.ndarray


def correction(g: DeltaGeometry, unknowns: Unknowns) -> Correction:
    """Makes the map of a device.

    Args:
        g: The device as drawn.
        unknowns: As it was measured.
    """
    made, table = unknowns.mechanism, unknowns.table
    own = np.column_stack([made.radius_difference, table[:, 2:LENGTHS], table[:, LENGTHS:]])
    return Correction(
        radius_difference=float(g.radius_differences[0]),
        side_difference=float(g.radius_differences[1]),
        side_cosine=g.side_cosine,
        side_sine=g.side_sine,
        upper_arm_length=g.upper_arm_length,
        forearm_length=g.forearm_length,
        turns=unknowns.turns,
        table=np.ascontiguousarray(own),
    )


@compiled
def shoulders(known, readings, angles):
    """Gives the angles of the made device's arms: readings with zero and waves of each encoder.

    Args:
        known: `Correction`.
        readings: (3,) rad.
        angles: (3,) filled, rad; NaN for a reading that is no number.
    """
    table = known.table
    for i in range(3):
        a = known.turns * readings[i]
        whole = TAU * float(math.floor(a / TAU + 0.5)) if abs(a) <= MOST_TURNS else math.nan
        s1, c1 = sincos(a - whole)
        c2, s2 = c1 * c1 - s1 * s1, 2.0 * s1 * c1
        waves = table[i, 6] * c1 + table[i, 7] * s1 + table[i, 8] * c2 + table[i, 9] * s2
        angles[i] = readings[i] + table[i, 5] + waves


@compiled
def correct(known, readings, out):
    """Gives where the handle is, and how the drawn device would stand there.

    Args:
        known: `Correction`.
        readings: (3,) rad.
        out: (ROWS, 3) filled: rows 0-2 D; row 3 the position, m; row 4 the drawn angles, rad; NaN where the
            chains do not close, or arms stand otherwise than a device that was made to the drawing; row 5 the angles
            of its own arms. The rest is work.
    """
    table, e, c, s, moves = known.table, out[ELBOW:COS, 0:3], out[COS], out[SIN], out[MOVES:ROWS, 0:3]
    shoulders(known, readings, out[ANGLE])
    for i in range(3):
        s[i], c[i] = sincos(out[ANGLE, i])
        rx, ry = azimuth(i, known.side_cosine, known.side_sine)
        radial = table[i, 0] + table[i, 1] * c[i]
        e[i, 0] = radial * rx - table[i, 3] * ry
        e[i, 1] = radial * ry + table[i, 3] * rx
        e[i, 2] = table[i, 4] + table[i, 1] * s[i]
    bx, by, bz = e[1, 0] - e[0, 0], e[1, 1] - e[0, 1], e[1, 2] - e[0, 2]
    dx, dy, dz = e[2, 0] - e[0, 0], e[2, 1] - e[0, 1], e[2, 2] - e[0, 2]
    nx, ny, nz = by * dz - bz * dy, bz * dx - bx * dz, bx * dy - by * dx
    n2 = nx * nx + ny * ny + nz * nz
    l0, l1, l2 = table[0, 2], table[1, 2], table[2, 2]
    beta = 0.5 * (l0 * l0 - l1 * l1 + bx * bx + by * by + bz * bz)
    gamma = 0.5 * (l0 * l0 - l2 * l2 + dx * dx + dy * dy + dz * dz)
    ux = (beta * (dy * nz - dz * ny) + gamma * (ny * bz - nz * by)) / n2
    uy = (beta * (dz * nx - dx * nz) + gamma * (nz * bx - nx * bz)) / n2
    uz = (beta * (dx * ny - dy * nx) + gamma * (nx * by - ny * bx)) / n2
    square = (l0 * l0 - (ux * ux + uy * uy + uz * uz)) / n2
    up = math.sqrt(square) if square >= 0.0 else math.nan
    px, py, pz = e[0, 0] + ux + up * nx, e[0, 1] + uy + up * ny, e[0, 2] + uz + up * nz
    out[POSITION, 0], out[POSITION, 1], out[POSITION, 2] = px, py, pz
    for i in range(3):
        e[i, 0], e[i, 1], e[i, 2] = px - e[i, 0], py - e[i, 1], pz - e[i, 2]
    det = (
        e[0, 0] * (e[1, 1] * e[2, 2] - e[1, 2] * e[2, 1])
        + e[0, 1] * (e[1, 2] * e[2, 0] - e[1, 0] * e[2, 2])
        + e[0, 2] * (e[1, 0] * e[2, 1] - e[1, 1] * e[2, 0])
    )
    for j in range(3):
        k, n = (j + 1) % 3, (j + 2) % 3
        jx, jy = azimuth(j, known.side_cosine, known.side_sine)
        rate = table[j, 1] * (c[j] * e[j, 2] - s[j] * (e[j, 0] * jx + e[j, 1] * jy)) / det
        moves[j, 0] = rate * (e[k, 1] * e[n, 2] - e[k, 2] * e[n, 1])
        moves[j, 1] = rate * (e[k, 2] * e[n, 0] - e[k, 0] * e[n, 2])
        moves[j, 2] = rate * (e[k, 0] * e[n, 1] - e[k, 1] * e[n, 0])
    for i in range(3):
        rx, ry = azimuth(i, known.side_cosine, known.side_sine)
        q = px * rx + py * ry - (known.radius_difference if i == 0 else known.side_difference)
        t = py * rx - px * ry
        rho2 = q * q + pz * pz
        la, lb = known.upper_arm_length, known.forearm_length
        m = (rho2 + t * t + la * la - lb * lb) / (2.0 * la)
        w2 = rho2 - m * m
        w = math.sqrt(w2) if w2 >= 0.0 else math.nan
        cos, sin = (q * m + pz * w) / rho2, (pz * m - q * w) / rho2
        # from the made angle, less than a right angle away, by the arcsine's series: off by 0.4, 8e-4, 2e-17 at most
        near, sn, cn = out[ANGLE, i], s[i], c[i]
        out[DRAWN, i] = near if cos * cn + sin * sn > 0.0 else math.nan
        for k in range(3):
            if k > 0:
                sn, cn = sincos(out[DRAWN, i])
            rest = sin * cn - cos * sn
            out[DRAWN, i] += rest * (1.0 + rest * rest / 6.0)
        # the drawn angle turns by s . v / (L_A w), s being the drawn forearm
        along, height = q - la * cos, pz - la * sin
        sx, sy, share = along * rx - t * ry, along * ry + t * rx, 1.0 / (la * w)
        for j in range(3):
            out[i, j] = share * (sx * moves[j, 0] + sy * moves[j, 1] + height * moves[j, 2])


@compiled
def turned(out, torque, most, made):
    """Turns torques for the drawn device into those that do the same at the handle of the made one, `D^T torque`.

    Args:
        out: What `correct` filled at the last reading.
        torque: (3,) N m.
        most: Largest that a joint may have, N m; beyond, all three are scaled down. May be infinite.
        made: (3,) filled, N m; none where it is not known where the handle is.
    """
    largest = 0.0
    known = True
    for j in range(3):
        made[j] = out[0, j] * torque[0] + out[1, j] * torque[1] + out[2, j] * torque[2]
        known = known and abs(made[j]) < math.inf
        largest = max(largest, abs(made[j]))
    scale = (most / largest if largest > most else 1.0) if known else 0.0
    for j in range(3):
        made[j] = scale * made[j] if known else 0.0
