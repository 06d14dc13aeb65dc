"""A storm of faults over a moving handle, compiled: what goes wrong, when, and what the supervisor then put out."""

# ruff: noqa: NPY002 - compiled code has NumPy's legacy generator only
from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from delta_cad.common.jit import compiled
from haptics.control.pose_margins import pose_margins
from haptics.control.supervisor import memory as m
from haptics.control.supervisor.faults import FaultCode
from haptics.control.supervisor.supervisor import ALL_FRESH, check, findings_left_out, left_out, limit
from haptics.model.plant import angles

CALM = 0
MODES = 25
"""Kinds of trouble; see `storm`."""
LYING = (2, 3, 8)
"""Those in which an encoder reads a number that is not so."""
_SIGNALS = np.array([FaultCode.WATCHDOG.bit, FaultCode.DEVICE_LOST.bit, FaultCode.EMERGENCY_STOP.bit], dtype=np.float64)


class Log(NamedTuple):
    """Of n ticks.

    Attributes:
        out: (n, 3) N m.
        rendered: (n, 3) N m, that part of it.
        theta: (n, 3) true angles at the reading, rad.
        dt: (n,) true time since the tick before, s.
        state: (n,) after the tick.
        latched: (n,) bits after the tick.
        bits: (n,) all that was said.
        request: (n,) of the operator before the tick.
        mode: (n,) kind of trouble.
        tank: (n,) J.
    """

    out: np.ndarray
    rendered: np.ndarray
    theta: np.ndarray
    dt: np.ndarray
    state: np.ndarray
    latched: np.ndarray
    bits: np.ndarray
    request: np.ndarray
    mode: np.ndarray
    tank: np.ndarray


def empty_log(ticks: int) -> Log:
    """Room for so many ticks."""
    three = [np.full((ticks, 3), np.nan) for _ in range(3)]
    whole = [np.zeros(ticks, dtype=np.int64) for _ in range(5)]
    return Log(three[0], three[1], three[2], np.zeros(ticks), *whole, np.zeros(ticks))


@compiled
def storm(lim, par, mem, ticks, seed, log):
    """Fills the log. The handle follows a wandering goal as a mass on a damped spring, so its speed is continuous."""
    np.random.seed(seed)
    middle = lim.cube_bottom + lim.cube_half
    p, v, goal = np.array([0.0, 0.0, middle]), np.zeros(3), np.array([0.0, 0.0, middle])
    state, true, read, place = np.zeros(12), np.zeros(3), np.zeros(3), np.zeros(3)
    stuck, drift, rendered, gravity, out = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    mode, left, joint, now = CALM, 500, 0, 0.0
    for k in range(ticks):
        left -= 1
        if left <= 0:
            mode = CALM if mode != CALM and np.random.random() < 0.7 else np.random.randint(1, MODES)
            left, joint = np.random.randint(1, 600), np.random.randint(0, 3)
            drift[:] = 0.0
            if mode == 3:
                stuck[:] = read
            if mode in (17, 18):
                left = 1200
            if mode == CALM:
                left = 1500
            for i in range(3):
                goal[i] = np.random.uniform(-0.03, 0.03) + (middle if i == 2 else 0.0)
            if mode == 7:
                goal[2] = lim.cube_bottom - np.random.uniform(0.0, 0.02)
        if np.random.random() < 0.004 and mode not in (7, 17):
            for i in range(3):
                goal[i] = np.random.uniform(-0.03, 0.03) + (middle if i == 2 else 0.0)
        # time
        dt = lim.period * np.random.uniform(0.9, 1.1)
        if mode == 5 and np.random.random() < 0.3:
            dt = lim.period * np.random.uniform(1.5, 5.0)
        if mode == 6 and np.random.random() < 0.02:
            dt = lim.period * np.random.uniform(5.0, 60.0)
        now += dt
        stamp = now
        if mode == 4 and np.random.random() < 0.05:
            kind = np.random.randint(0, 4)
            stamp = np.nan if kind == 0 else (np.inf if kind == 1 else (now - 2.0 if kind == 2 else mem[m.NOW]))
        # the handle
        steps = max(int(dt / 5e-4), 1)
        h = dt / steps
        was = p.copy()
        for _ in range(steps):
            stiff = 100.0 if mode == 11 else 30.0
            for i in range(3):
                v[i] += h * (stiff * stiff * (goal[i] - p[i]) - 2.0 * stiff * v[i])
                p[i] += h * v[i]
        if mode == 17:
            v[:] = 0.0
            p[:] = was
        state[:3] = p
        angles(par, state, true)
        for i in range(3):
            read[i] = np.round(true[i] / lim.encoder_count) * lim.encoder_count
            place[i] = p[i]
        reach, volume = pose_margins(par, p)
        # what goes wrong with it
        if mode == 1 and np.random.random() < 0.1:
            read[joint] = np.nan if np.random.random() < 0.5 else (np.inf if np.random.random() < 0.5 else -np.inf)
        if mode == 2 and np.random.random() < 0.05:
            read[joint] += np.random.uniform(-3.0, 3.0)
        if mode == 3:
            read[joint] = stuck[joint]
        if mode == 8:
            drift[joint] += 0.01
            read[joint] += drift[joint]
        if mode == 9 and np.random.random() < 0.05:
            place[np.random.randint(0, 3)] = np.nan
        if mode == 10:
            reach *= np.random.uniform(0.0, 1.0)
            volume *= np.random.uniform(0.0, 1.0)
            if np.random.random() < 0.02:
                reach = np.nan
        # the operator and the host
        request = 0.0
        if np.random.random() < 0.01:
            request = m.RESET if mem[m.LATCHED] != 0.0 else m.ENABLE
        if np.random.random() < 2e-4:
            request = np.random.randint(1, 4) * 1.0
        mem[m.REQUEST] = request
        if mode != 13:
            mem[m.HEARD] = mem[m.NOW]
        mem[m.SIGNALS] = _SIGNALS[joint] if mode == 16 else 0.0
        # what the controller asks for
        for i in range(3):
            gravity[i] = 0.05 * math.cos(true[i])
            rendered[i] = -0.1 * math.sin(3.0 * true[i]) - 0.002 * mem[m.RATE + i]
        if mode in (12, 17):
            rendered[:] = 0.4
        if mode == 14:
            kind = np.random.randint(0, 4)
            if kind == 0 and np.random.random() < 0.02:
                rendered[joint] = np.nan if np.random.random() < 0.5 else np.inf
            elif kind == 1:
                rendered[joint] = np.random.uniform(-1e300, 1e300)
            elif kind == 2:
                gravity[joint] = np.random.uniform(-1e3, 1e3)
                rendered[:] = np.random.uniform(-2.0, 2.0)
        if mode in (18, 19):
            for i in range(3):
                rendered[i] = 0.5 if mem[m.RATE + i] > 0.0 else -0.5
        if mode == 20:
            for i in range(3):
                rendered[i] = np.random.uniform(-3.0, 3.0)
        fresh = ALL_FRESH
        if mode == 24 and np.random.random() < 0.5:
            fresh = np.random.randint(0, ALL_FRESH)
        skipped, bits = left_out(lim, mem, fresh, out), 0
        if skipped:
            bits = findings_left_out(mem)
        if not skipped and not (mode == 15 and np.random.random() < 0.02):
            bits = check(lim, mem, stamp, read, read, place, reach, volume)
        if not skipped:
            bits |= limit(lim, mem, rendered, gravity, out)
        for i in range(3):
            log.out[k, i] = out[i]
            log.rendered[k, i] = mem[m.RENDERED + i]
            log.theta[k, i] = true[i]
        log.dt[k], log.tank[k] = dt, mem[m.TANK]
        log.state[k], log.latched[k] = int(mem[m.STATE]), int(mem[m.LATCHED])
        log.bits[k], log.request[k], log.mode[k] = bits, int(request), mode
