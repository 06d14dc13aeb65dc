"""The energy tank: bounds the energy that the force may give to the hand.

Over one tick the held torque r gives the hand exactly `r . (theta_after - theta_before)`; that is taken out of the
tank, and what the hand puts in goes back into it, up to its capacity. The level is known only afterwards and the slew
limit lets the torque fall by `step` a tick at most, so the tank must hold, at every tick, what the torque can still
give away while it is braked to zero. With u the joint's mean speed over the last tick, `gain` the most by which that
can grow from one tick to the next, and `late` the longest interval, j ticks ahead it turns by at most
`t_j = late (u + (j + 1) gain) + count`, so the rule is

    need(r) = sum over joints and j >= 0 of t_j (|r| - j step)^+ <= level.

If that holds at one tick, it holds at the next for the braked torque: the tick took at most `t_0 |r|`, which is just
the first term of the sum, and the other terms are the sum of the next tick. So an allowed torque always exists, the
level never falls below zero, and over any window the energy given is at most the difference of two levels, that is at
most the capacity. What comes on top:

- a reading is wrong by up to half a count, which makes up to `count / 2 (|r_first| + |r_last| + sum of |changes|)` for
  each joint over a window (summation by parts);
- a tick that comes later than `late`, or a joint that gains more speed than `gain`, can take up to
  `sum |r| joint_speed dt` more, once for each.

Source:
    Energy observer: Hannaford and Ryu, "Time-domain passivity control of haptic interfaces", 2002. The barrier in
    place of their damper works at rest, too, and cannot be outrun by the slew limit; derived above.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import inlined
from haptics.control.supervisor import memory as m

HALVINGS = 12  # Bisections of the largest share that the tank allows: to 1/4096 of the torque, always on the safe side


@inlined
def need(torque, step, turn, growth):
    """Energy that a joint's torque can give away while it is braked to zero, J.

    Args:
        torque: N m.
        step: Largest fall in a tick, N m.
        turn: Largest turn of the joint in the coming tick, rad.
        growth: By how much that can grow from tick to tick, rad.
    """
    a = abs(torque)
    n = float(math.floor(a / step))
    plain = (n + 1.0) * (a - 0.5 * step * n)  # sum of a - j step over j = 0 .. n
    rising = n * (n + 1.0) * (0.5 * a - step * (2.0 * n + 1.0) / 6.0)  # sum of j (a - j step)
    return turn * plain + growth * rising


@inlined
def slewed(target, before, step):
    """The torque next to the target that the slew limit allows, N m."""
    return min(max(target, before - step), before + step)


@inlined
def share_allowed(level, growth, step, mem):
    """Largest share of a wanted torque that the tank can answer for.

    Args:
        level: Level of the tank, J.
        growth: By how much the largest turn can grow from tick to tick, rad.
        step: Largest change of a torque in a tick, N m.
        mem: (MEMORY,) the supervisor's: TURNS, the largest turn of each joint in the coming tick; RENDERED, the torque
            of the tick before; WANTED, the wanted torque.

    Returns:
        Between 0 and 1; 1 if all of it is allowed, 0 if it must be braked. |torque| rises with the share, also where
        the slew limit holds, so the search by halves finds it.
    """
    low, high, share = 0.0, 1.0, 1.0
    for _ in range(HALVINGS + 1):
        needed = 0.0
        for i in range(3):
            torque = slewed(share * mem[m.WANTED + i], mem[m.RENDERED + i], step)
            needed += need(torque, step, mem[m.TURNS + i], growth)
        if needed <= level:
            low = share
        else:
            high = share
        if low >= 1.0:
            break
        share = 0.5 * (low + high)
    return low
