"""What is loosened and taken off when a motor is exchanged, the rest of the machine as it stands.

The pinion's set screws, then the motor's: the motor is drawn off the cheek, its shaft out of the pinion, which stays in
the turns of its cable. A direct drive's motor carries the arm, which must come off its shaft first: nothing is stated.
"""

from __future__ import annotations

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.layers import motor_thread_mm
from delta_cad.mechanism.placement import CHAINS
from delta_cad.solids.part import Reach, Removal

KEYS_MM = {  # width across flats: long and short leg
    0.9: (33.0, 11.0),
    1.3: (41.0, 13.0),
    1.5: (46.5, 15.5),
    2.0: (52.0, 18.0),
    2.5: (58.5, 20.5),
    3.0: (66.0, 23.0),
    4.0: (74.0, 29.0),
    5.0: (85.0, 33.0),
    6.0: (96.0, 38.0),
}
"""Hexagon keys, standard type, mm. Source: ISO 2936, as JIS B 4648:2008 gives it (mikipulley.co.jp, tech13)."""
CORNERS = 1.13  # largest width across corners by that across flats: 1.68 / 1.5, 2.82 / 2.5 in the same table
CUT = 0.8  # share of its short leg to which a key is cut that must turn between the two cheeks
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
        Removal(f"motor_{i}", (0.0, 1.0, 0.0), (*_motor_screws(d, i), *_set_screws(i)), "is exchanged") for i in CHAINS
    )
