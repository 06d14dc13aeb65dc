"""Default limits of feel: without them a linkage may be called a haptic device that hands feel as a brake or a load.

`[feel]` of a requirements file replaces each. A result that is worse than one that the file leaves out holds its set
limits, but is poor as a haptic device.
"""

from __future__ import annotations

_FRICTION_SHARE = 0.2
"""Friction at the handle over the continuous force: of a force display's range a fifth is lost, in either direction."""
ACCELERATION_M_S2 = 5.0
"""Acceleration that the continuous force gives the handle: a reach of 140 mm in 0.4 s has 10 / sqrt(3) 0.14 / 0.4^2 =
5.05 m/s^2 at most, by the minimum-jerk profile (Flash and Hogan, J. Neurosci. 5(7), 1985), so that the inertia of what
is moved takes no more than the device can give back."""
_LIGHT_KG = 0.25
"""Effective mass that is light at any force: arms that held a handle had 0.204 to 0.269 kg (`haptics.model.hands`)."""
COUPLE_INDEX = 0.4
"""Least rotational stiffness index: below it the floor of a cube is soft, as the platform hardly resists turning."""


def feel_defaults(force_N: float) -> dict[str, float]:
    """Computes the default limits of feel.

    Args:
        force_N: Continuous force.

    Returns:
        Field of `[feel]` -> its default: at most so much effective mass in the heaviest direction, kg, and friction at
        the handle, N, and at least such a rotational stiffness index, anywhere in the cube.
    """
    return {
        "effective_mass_max_kg": max(_LIGHT_KG, force_N / ACCELERATION_M_S2),
        "friction_max_N": _FRICTION_SHARE * force_N,
        "couple_index_min": COUPLE_INDEX,
    }
