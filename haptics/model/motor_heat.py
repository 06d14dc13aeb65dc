"""How warm a motor gets: two bodies, winding and housing, from the catalogue; a running mean of the square otherwise.

The winding is heated by `R(T) i^2`, gives its heat to the housing, and the housing to the air:

    d T_w / dt = heat torque^2 (1 + slope (T_w - 25)) - (T_w - T_h) / winding_time
    d T_h / dt = (T_w - T_h) coupling - (T_h - ambient) / housing_time

with `heat = R_25 / (k_t drive)^2 / C_w`, `C_w = winding_time / R_wh`, `coupling = 1 / (R_wh C_h)` and
`housing_time = R_ha C_h`. The catalogue has no time constant of the housing: C_h is the motor's mass times 450 J/(kg K)
(steel and copper lie at 385 to 490), which gives 702 s for the RE 30.

Where a motor's thermal data are missing the same equations run without a housing and in units of the allowed rise
(ambient 0, largest 1): `d x / dt = (torque^2 / continuous^2 - x) / time`, "I squared t". Its time is chosen such that
from cold the peak torque may last exactly the peak time. Without a peak above the continuous torque no torque that the
motor may give warms it beyond the allowed rise, whatever the time constant, and the peak time stands for it.
Importing this module loads numba.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from delta_cad.catalogue import Motor
from delta_cad.common.jit import inlined
from delta_cad.common.units import G_PER_KG

COPPER = 0.0039  # Rise of copper's resistance per kelvin, about 25 C
REFERENCE_C = 25.0  # Temperature of the catalogue's resistance and ambient
_SPECIFIC_HEAT = 450.0  # Specific heat of a motor as one body, J/(kg K)
# De-rating begins this far below the largest temperature: at the peak torque the catalogue's windings warm by 6 to 10
# K/s, so there are 3 s in which the torque comes down, and nobody feels a step.
DERATE_K = 30.0
_DERATE_SHARE = 0.7  # The same where only x is known


class Heat(NamedTuple):
    """Thermal parameters of one joint's motor, with torques at the joint.

    Attributes:
        continuous: Torque it can hold for ever, N m.
        ambient: Temperature of the air, C; 0 where only x is known.
        derate: Temperature from which the torque is limited.
        hottest: Temperature at which it is switched off.
        heat: K/s per (N m)^2, at 25 C.
        slope: 1/K of the resistance.
        winding_time: s.
        coupling: Winding to housing, seen by the housing, 1/s; 0 without a housing.
        housing_time: s.
    """

    continuous: float
    ambient: float
    derate: float
    hottest: float
    heat: float
    slope: float
    winding_time: float
    coupling: float
    housing_time: float


def motor_heat(motor: Motor, drive: float, ambient_C: float = REFERENCE_C) -> Heat:
    """The thermal parameters of a catalogue motor behind its drive.

    Args:
        motor: The catalogue row.
        drive: Joint torque over motor torque: ratio times efficiency.
        ambient_C: Temperature of the air. Without thermal data it is taken as 25 C, whatever is given.

    Returns:
        The parameters: of two bodies where resistances, time constant and largest temperature are all known.

    Raises:
        ValueError: `drive` is not positive and finite, or the air is not cooler than the motor may be.
    """
    if not (math.isfinite(drive) and drive > 0.0):
        raise ValueError(f"drive is {drive!r}; it must be finite and positive")
    continuous = motor.nominal_torque_N_m * drive
    inner, outer = motor.thermal_resistance_winding_housing_K_W, motor.thermal_resistance_housing_ambient_K_W
    winding_time, hottest = motor.thermal_time_constant_winding_s, motor.max_winding_temperature_C
    if inner is None or outer is None or winding_time is None or hottest is None:
        over = (motor.peak_torque_N_m / motor.nominal_torque_N_m) ** 2
        time = motor.peak_time_s / -math.log1p(-1.0 / over) if over > 1.0 else motor.peak_time_s
        return Heat(continuous, 0.0, _DERATE_SHARE, 1.0, 1.0 / (continuous**2 * time), 0.0, time, 0.0, 1.0)
    if not ambient_C < hottest - DERATE_K:
        raise ValueError(f"ambient_C is {ambient_C!r}; it must be below {hottest - DERATE_K:g} C for {motor.id}")
    housing = motor.mass_g / G_PER_KG * _SPECIFIC_HEAT
    current = 1.0 / (motor.torque_constant_N_m_A * drive)
    return Heat(
        continuous=continuous,
        ambient=ambient_C,
        derate=hottest - DERATE_K,
        hottest=hottest,
        heat=motor.resistance_ohm * current**2 * inner / winding_time,
        slope=COPPER,
        winding_time=winding_time,
        coupling=1.0 / (inner * housing),
        housing_time=outer * housing,
    )


def hold_time(heat: Heat, torque: float, temperature: float, before: float = 0.0) -> float:
    """Computes how long a motor at rest may hold a torque until its winding reaches a temperature, exactly: at a steady
    torque both bodies are linear, copper's growing resistance included.

    Args:
        heat: Of two bodies, the air not below 25 C.
        torque: N m at the joint.
        temperature: C.
        before: Torque that was held for ever before, N m; 0: all is as warm as the air.

    Returns:
        s; infinite where it is never reached, 0 where it is there already.

    Raises:
        ValueError: The motor's thermal data are not known.
    """
    if heat.coupling == 0.0:
        raise ValueError("heat has no housing: thermal resistances of the motor are not known")
    from scipy.linalg import expm
    from scipy.optimize import root_scalar

    def rates(held: float) -> np.ndarray:
        """(3, 3) of winding, housing and 1: what they grow by, 1/s."""
        power, inner, outer = heat.heat * held**2, 1.0 / heat.winding_time, 1.0 / heat.housing_time
        own = power * (1.0 - heat.slope * REFERENCE_C)
        winding = [power * heat.slope - inner, inner, own]
        return np.array([winding, [heat.coupling, -heat.coupling - outer, heat.ambient * outer], [0.0, 0.0, 0.0]])

    start, grows = rates(before), rates(torque)
    begin = np.append(-np.linalg.solve(start[:2, :2], start[:2, 2]), 1.0)
    if begin[0] >= temperature:
        return 0.0
    cools = np.linalg.eigvals(grows[:2, :2]).real.max() < 0.0
    if cools and -np.linalg.solve(grows[:2, :2], grows[:2, 2])[0] <= temperature:
        return math.inf
    low, high = 0.0, heat.winding_time
    while (expm(high * grows) @ begin)[0] < temperature:
        low, high = high, 2.0 * high
    crossed = root_scalar(lambda t: (expm(t * grows) @ begin)[0] - temperature, bracket=(low, high))
    return float(crossed.root)


@inlined
def _warming(heat, winding, housing, torque, seconds):
    """By how much temperatures grow in a moment.

    Args:
        heat: `Heat`.
        winding: C.
        housing: C.
        torque: N m at the joint.
        seconds: s; more than a tenth of the winding's time constant is taken as that.

    Returns:
        Of winding and housing, K.
    """
    dt = min(seconds, 0.1 * heat.winding_time)
    power = heat.heat * torque * torque * (1.0 + heat.slope * max(winding - REFERENCE_C, 0.0))
    flow = winding - housing
    grows = dt * (power - flow / heat.winding_time)
    return grows, dt * (flow * heat.coupling - (housing - heat.ambient) / heat.housing_time)


@inlined
def warmed(heat, winding, housing, torque, seconds):
    """Temperatures a moment later: winding and housing, C; arguments as `_warming`."""
    grows, follows = _warming(heat, winding, housing, torque, seconds)
    return winding + grows, housing + follows


@inlined
def allowed(heat, torque, winding):
    """Torque that may be given at a temperature: all up to `derate`, then linearly down to `continuous` at `hottest`.

    Args:
        heat: `Heat`.
        torque: Limit of the cold motor, N m.
        winding: C.
    """
    share = min(max((winding - heat.derate) / (heat.hottest - heat.derate), 0.0), 1.0)
    return torque - share * max(torque - heat.continuous, 0.0)
