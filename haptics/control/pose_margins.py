"""Margins of a pose to both kinds of singularity, compiled; importing this module loads numba."""

from __future__ import annotations

from delta_cad.common.jit import compiled, inlined
from haptics.model.plant import chain


@inlined
def singularity_margins(w0, w1, w2, det, forearm_length):
    """Smallest w of the chains (m) and det S / L_B^3, both NaN where a w is."""
    return min(w0, w1, w2) + 0.0 * (w0 + w1 + w2), det / forearm_length**3


@compiled
def pose_margins(par, p):
    """The distances to both kinds of singularity.

    Args:
        par: `plant.Plant`, or any record with what its `chain` reads.
        p: (3,) position, m.

    Returns:
        Smallest w of the three chains (m), and det S / L_B^3; NaN where a chain cannot be closed.
    """
    _, _, _, _, w0, ax, ay, az = chain(par, 0, p[0], p[1], p[2])
    _, _, _, _, w1, bx, by, bz = chain(par, 1, p[0], p[1], p[2])
    _, _, _, _, w2, cx, cy, cz = chain(par, 2, p[0], p[1], p[2])
    det = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return singularity_margins(w0, w1, w2, det, par.forearm_length)
