"""What goes wrong between joints and controller in a simulated loop: readings and amplifiers; compiled.

A fault begins at a tick and stays. One joint has it, or all. Importing this module loads numba.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

from delta_cad.common.jit import compiled
from haptics.control.supervisor.supervisor import ALL_FRESH

PAST = 128  # Ticks of readings that are kept for those that come late


class Wrong(IntEnum):
    """What is wrong.

    Of readings all but UNREAD are passed on as fresh: the chip's or the wire's own check saw nothing.
    """

    NOTHING = 0
    FROZEN = 1  # the last reading before the fault again and again
    UNREAD = 2  # the same, and the hardware layer says so
    LATE = 3  # readings of `size` ticks ago
    BIT = 4  # bit `size` of the count turned round, and stuck there
    OFFSET = 5  # `size` rad too much
    DRIFT = 6  # `size` rad/s more and more too much
    SWAPPED = 7  # with that of the next joint
    UNPLUGGED = 8  # all bits up: a turn less a count
    WEAK = 9  # the amplifier gives no torque
    FULL = 10  # the amplifier gives `size` N m, whatever is commanded


class LoopFault(NamedTuple):
    """A fault of a loop; plain numbers, so that compiled code takes it as it is.

    Attributes:
        wrong: A `Wrong`.
        begin: Tick at which it begins.
        joint: 0 to 2; 3 for all.
        size: As `Wrong` says.
        noticed: Ticks after its begin at which the drive signals WATCHDOG; 0 for never.
    """

    wrong: int = 0
    begin: int = 0
    joint: int = 3
    size: float = 0.0
    noticed: int = 0


HEALTHY = LoopFault()
_FROZEN, _UNREAD, _LATE, _BIT = int(Wrong.FROZEN), int(Wrong.UNREAD), int(Wrong.LATE), int(Wrong.BIT)
_OFFSET, _DRIFT, _SWAPPED = int(Wrong.OFFSET), int(Wrong.DRIFT), int(Wrong.SWAPPED)
_UNPLUGGED, _WEAK, _FULL = int(Wrong.UNPLUGGED), int(Wrong.WEAK), int(Wrong.FULL)


@compiled
def read_wrong(fault, k, period, count, past, read):
    """Spoils the readings of a tick.

    Args:
        fault: `LoopFault`.
        k: Tick.
        period: Of the tick, s.
        count: Of an encoder at the joint, rad; 0 for none.
        past: (PAST + 1, 3) true readings by tick, rad, and in the last row what a reading or a bit is stuck at.
        read: (3,) true readings, spoiled in place, rad.

    Returns:
        Bits of the joints whose readings are said to be fresh.
    """
    for i in range(3):
        past[k % PAST, i] = read[i]
    if fault.wrong == 0 or k < fault.begin:
        return ALL_FRESH
    fresh = ALL_FRESH
    for i in range(3):
        if fault.joint != 3 and fault.joint != i:
            continue
        if fault.wrong == _FROZEN or fault.wrong == _UNREAD:
            if k == fault.begin:
                past[PAST, i] = past[(k - 1) % PAST, i]
            read[i] = past[PAST, i]
            if fault.wrong == _UNREAD:
                fresh &= ~(1 << i)
        elif fault.wrong == _LATE:
            read[i] = past[(k - int(fault.size)) % PAST, i]
        elif fault.wrong == _BIT:
            bit = 2.0**fault.size
            digit = math.floor(read[i] / (bit * count)) % 2.0
            if k == fault.begin:
                past[PAST, i] = 1.0 - digit
            read[i] += (past[PAST, i] - digit) * bit * count
        elif fault.wrong == _OFFSET:
            read[i] += fault.size
        elif fault.wrong == _DRIFT:
            read[i] += fault.size * (k - fault.begin + 1) * period
        elif fault.wrong == _SWAPPED:
            read[i] = past[k % PAST, (i + 1) % 3]
            read[(i + 1) % 3] = past[k % PAST, i]
        elif fault.wrong == _UNPLUGGED:
            read[i] = 2.0 * math.pi - count
    return fresh


@compiled
def drive_wrong(fault, k, torque):
    """Spoils the torques that motors give at a tick, (3,) N m, in place."""
    if k < fault.begin:
        return
    for i in range(3):
        if fault.joint == 3 or fault.joint == i:
            if fault.wrong == _WEAK:
                torque[i] = 0.0
            elif fault.wrong == _FULL:
                torque[i] = fault.size
