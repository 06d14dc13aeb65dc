"""Bodies between platform and person: a compliant structure, the knob, a grasp, the arm; compiled.

Platform, knob and the arm's mass are a chain; each link of it is a spring and damper, or rigid. The structure's
compliance is lumped in the one link under the knob, alike in all directions; the knob's weight acts on the platform, so
that nothing sags. Importing this module loads numba.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import inlined
from haptics.model.drive_train import GRASP, HAND_SPEED, KNOB, KNOB_SPEED, POSITION, SPEED


@inlined
def handle_force(par, hand, anchor, force, state, out):
    """Force of hand and knob on the platform.

    Args:
        par: The plant.
        hand: The hand.
        anchor: (3,) where the person wants the handle, m.
        force: (3,) further force on the knob, N.
        state: (STATES,) state.
        out: (STATES,) derivative, the places of knob and hand filled.

    Returns:
        Along x, y and z, N.
    """
    side_x, side_y = _bezel_force(par, state)
    return (
        _along(par, hand, anchor, force[0] + side_x, state, out, 0),
        _along(par, hand, anchor, force[1] + side_y, state, out, 1),
        _along(par, hand, anchor, force[2], state, out, 2),
    )


@inlined
def _bezel_force(par, state):
    """Force of a panel's bezel on the stem, a spring and damper that never pulls; none where there is no panel.

    The stem's axis is free over a square whose corners are round: half its side and a limit around each of its points.

    Args:
        par: The plant.
        state: (STATES,) state.

    Returns:
        Along x and y, N.
    """
    if par.bezel_stiffness <= 0.0:
        return 0.0, 0.0
    x, y, vx, vy = state[POSITION], state[POSITION + 1], state[SPEED], state[SPEED + 1]
    if par.structure_stiffness > 0.0:
        x, y, vx, vy = x + state[KNOB], y + state[KNOB + 1], state[KNOB_SPEED], state[KNOB_SPEED + 1]
    x -= par.bezel_x
    dx = x - min(max(x, -par.bezel_half), par.bezel_half)
    dy = y - min(max(y, -par.bezel_half), par.bezel_half)
    out = math.sqrt(dx * dx + dy * dy)
    if out <= par.bezel_limit:
        return 0.0, 0.0
    nx, ny = dx / out, dy / out
    push = max(par.bezel_stiffness * (out - par.bezel_limit) + par.bezel_damping * (vx * nx + vy * ny), 0.0)
    return -push * nx, -push * ny


@inlined
def _along(par, hand, anchor, force, state, out, k):
    bends, grips = par.structure_stiffness > 0.0, hand.grasp_stiffness > 0.0
    place, speed = state[POSITION + k], state[SPEED + k]
    if bends:
        place, speed = place + state[KNOB + k], state[KNOB_SPEED + k]
    if grips:
        way, moves = state[GRASP + k], state[HAND_SPEED + k]
        pull = hand.grasp_stiffness * way + hand.grasp_damping * (moves - speed)
        wants = hand.stiffness * (anchor[k] - place - way) - hand.damping * moves
        out[GRASP + k] = moves - speed
        out[HAND_SPEED + k] = (wants - pull) / hand.mass
    else:
        pull = hand.stiffness * (anchor[k] - place) - hand.damping * speed
        out[GRASP + k] = out[HAND_SPEED + k] = 0.0
    pull += force
    if not bends:
        out[KNOB + k] = out[KNOB_SPEED + k] = 0.0
        return pull
    held = par.structure_stiffness * state[KNOB + k] + par.structure_damping * (speed - state[SPEED + k])
    out[KNOB + k] = speed - state[SPEED + k]
    out[KNOB_SPEED + k] = (pull - held) / (par.knob if grips else par.knob + hand.mass)
    return held


@inlined
def handle_energy(par, state):
    """Kinetic energy of a knob on a compliant structure, and the structure's elastic energy, J; 0 if it is rigid."""
    if par.structure_stiffness <= 0.0:
        return 0.0, 0.0
    moving = bent = 0.0
    for k in range(3):
        moving += 0.5 * par.knob * state[KNOB_SPEED + k] ** 2
        bent += 0.5 * par.structure_stiffness * state[KNOB + k] ** 2
    return moving, bent
