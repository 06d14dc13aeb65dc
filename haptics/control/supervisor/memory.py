"""Layout of the supervisor's memory: one array of floats, common to compiled code and firmware."""

from __future__ import annotations

import numpy as np

from haptics.control.supervisor.limits import SafetyLimits

# one float each where no length is said
STATE = 0  # a `faults.State`
LATCHED = 1  # bits; below 2^53, so exact in a float
PRESENT = 2  # bits of this tick
REQUEST = 3  # of the operator, taken by the next check: one of those below
SIGNALS = 4  # bits of `faults.EXTERNAL` that somebody outside holds up
STARTED = 5  # 1 once a time is known
NOW = 6  # s
HEARD = 7  # time of the host's last command, s
CHECKED = 8  # 1 between a check and its limit
KNOWN = 9  # 1 if THETA are good angles
PLACED = 10  # 1 if PLACE is a good position
LATE = 11  # late ticks not yet forgotten
SCALE = 12  # of the ramp, 0 to 1
STALE = 13  # of the host's age, 0 to 1
EDGE = 14  # of the workspace's edge, 0 to 1
NEAR = 15  # of the distance to a singularity, 0 to 1
PROBE = 16  # of the search for a frozen encoder, 1 to -0.5
TANK = 17  # J
SPENT = 18  # time for which more was demanded of the tank than it had, s
SHORT = 19  # 1 if the tank limited the last torque
ALLOWED = 20  # torque that the warmest motor allows, N m
GIVEN = 21  # energy given to the hand since enabling, J
TICKS = 22  # number of checks
POWER = 23  # given to the hand, low-passed over the ramp's fall, W
THETA = 24  # (3) rad
RATE = 27  # (3) low-passed, rad/s
FASTEST = 30  # (3) bound of the joints' mean speed over the last tick, rad/s
STILL = 33  # (3) 1 while a joint is probed
LOADED = 36  # (3) time without a count under torque, s
ANCHOR = 39  # (3, 3) row i: all angles when joint i changed last, rad
PLACE = 48  # (3) m
SPEED = 51  # (3) low-passed velocity of the handle, m/s
RENDERED = 54  # (3) the last rendered torque, N m
GRAVITY = 57  # (3) the last gravity torque, N m
OUT = 60  # (3) their sum, what was written, N m
WINDING = 63  # (3) C
HOUSING = 66  # (3) C
TURNS = 69  # (3) room of `limit`
WANTED = 72  # (3) room of `limit`
READ = 75  # (3) the last readings, rad
REPEATS = 78  # (3) how often each has repeated
ALL_REPEAT = 81  # how often all three have repeated together
MISSED = 82  # ticks in a row whose readings were not all fresh
PACE = 83  # (3) speed of the joints over the last tick, rad/s
PACED = 86  # 1 if that tick was in time
LOWERED = 87  # time since weight and damping began to be taken away, s
MEMORY = 88

ENABLE, DISABLE, RESET = 1.0, 2.0, 3.0  # Values of memory[REQUEST]; 0 for none
# Share of a period below which the time of a tick is taken as standing still: rates would have no meaning.
SHORTEST = 1e-3
LONGEST = 1.0  # An interval is taken as no longer than this, s: a drive's own watchdog cuts the torque long before


def reset_memory(limits: SafetyLimits) -> np.ndarray:
    """A memory that knows nothing, with cold motors, disabled.

    Returns:
        (MEMORY,) the memory.
    """
    memory = np.zeros(MEMORY)
    memory[[STALE, EDGE, NEAR, PROBE]] = 1.0
    memory[ALLOWED] = limits.torque
    memory[FASTEST : FASTEST + 3] = limits.joint_speed
    memory[WINDING : WINDING + 3] = memory[HOUSING : HOUSING + 3] = limits.motor.ambient
    return memory
