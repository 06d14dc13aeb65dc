"""Oracle: one axis in time, by Runge-Kutta steps with commands that arrive on the clock; nothing of the model."""

import math

import numpy as np

from delta_cad.common.jit import compiled

STEPS = 40
"""Steps a period; delays are to be multiples of T / 40."""


@compiled
def one_axis(mass, friction, stiffness, lag, num, den, K, B, period, delay_steps, ticks, v0):
    """Positions at the samples after a push that leaves the speed v0.

    `delay_steps` is the delay in steps of T / STEPS; a command of sample k acts from step `k STEPS + delay_steps` on.
    """
    dt = period / STEPS
    x, v, f = 0.0, v0, 0.0
    seen, rates = np.zeros(len(num)), np.zeros(len(den))
    age = delay_steps // STEPS + 2
    required = np.zeros(age)  # asked[0] the newest
    out = np.empty(ticks)
    for k in range(ticks):
        out[k] = x
        for j in range(len(seen) - 1, 0, -1):
            seen[j] = seen[j - 1]
        seen[0] = x
        rate = 0.0
        for j in range(len(num)):
            rate += num[j] * seen[j]
        for j in range(1, len(den)):
            rate -= den[j] * rates[j - 1]
        for j in range(len(rates) - 1, 0, -1):
            rates[j] = rates[j - 1]
        rates[0] = rate
        for j in range(age - 1, 0, -1):
            required[j] = required[j - 1]
        required[0] = -K * x - B * rate
        for s in range(STEPS):
            back = (delay_steps - s + STEPS - 1) // STEPS if delay_steps > s else 0
            u = required[back]
            if lag == 0.0:
                f = u
            k1x, k1v = v, (f - friction * v - stiffness * x) / mass
            k1f = (u - f) / lag if lag > 0.0 else 0.0
            h = 0.5 * dt
            x2, v2, f2 = x + h * k1x, v + h * k1v, f + h * k1f
            k2x, k2v = v2, (f2 - friction * v2 - stiffness * x2) / mass
            k2f = (u - f2) / lag if lag > 0.0 else 0.0
            x3, v3, f3 = x + h * k2x, v + h * k2v, f + h * k2f
            k3x, k3v = v3, (f3 - friction * v3 - stiffness * x3) / mass
            k3f = (u - f3) / lag if lag > 0.0 else 0.0
            x4, v4, f4 = x + dt * k3x, v + dt * k3v, f + dt * k3f
            k4x, k4v = v4, (f4 - friction * v4 - stiffness * x4) / mass
            k4f = (u - f4) / lag if lag > 0.0 else 0.0
            x += dt / 6.0 * (k1x + 2.0 * (k2x + k3x) + k4x)
            v += dt / 6.0 * (k1v + 2.0 * (k2v + k3v) + k4v)
            f += dt / 6.0 * (k1f + 2.0 * (k2f + k3f) + k4f)
    return out


def growth(positions: np.ndarray) -> float:
    """Growth a sample of the envelope, from the largest swings in the third and the last quarter."""
    quarter = len(positions) // 4
    third = np.abs(positions[2 * quarter : 3 * quarter]).max()
    last = np.abs(positions[3 * quarter : 4 * quarter]).max()
    return math.exp(math.log(last / third) / quarter)
