"""What is loosened and taken off when a motor is exchanged, the rest of the machine as it stands.

The motor's leads, the pinion's set screws, then the motor's: it is drawn off the cheek, its shaft out of the pinion,
which stays in the turns of its cable. A direct drive's motor carries the arm, which must come off its shaft first:
nothing is stated.
"""

from __future__ import annotations

from delta_cad.assembly.leads import lead_names
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.layers import motor_thread_mm
from delta_cad.mechanism.placement import CHAINS
from delta_cad.solids.part import Reach, Removal

LOOSE_MM = 0.5  # way of a set screw that leaves its shaft free
SET_SCREWS = 2


def _motor_screws(d: Dimensions, i: int) -> tuple[str, ...]:
    return tuple(f"motor_screw_{i}_{k}" for k in range(len(d.bracket.motor_screws_rad)))


def _set_screws(i: int) -> tuple[str, ...]:
    return tuple(f"set_screw_{i}_{k}" for k in range(SET_SCREWS))


def reached(d: Dimensions) -> tuple[Reach, ...]:
    """States the screws that a key reaches to take a motor off, by the names of their occurrences."""
    if d.capstan is None:
        return ()
    thread = motor_thread_mm(d.motor)  # the screws fill it
    return tuple(
        reach
        for i in CHAINS
        for reach in (
            *(Reach(name, thread, "holds the motor") for name in _motor_screws(d, i)),
            *(Reach(name, LOOSE_MM, "holds the pinion on the motor's shaft") for name in _set_screws(i)),
        )
    )


def removals(d: Dimensions) -> tuple[Removal, ...]:
    """States the motors that come off along their own axes, away from the arms."""
    if d.capstan is None:
        return ()
    return tuple(
        Removal(
            f"motor_{i}", (0.0, 1.0, 0.0), (*_motor_screws(d, i), *_set_screws(i), *lead_names(d, i)), "is exchanged"
        )
        for i in CHAINS
    )
