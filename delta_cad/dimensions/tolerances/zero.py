"""Chains of the zero of a shoulder's encoder: where an arm stands on its lower stop, and what calibration leaves of it.

The stop gives the zero to begin with; `python -m haptics calibrate` on the fixture then finds it to what control needs.
"""

from __future__ import annotations

from math import degrees, hypot

import numpy as np

from delta_cad.common.units import M_PER_MM
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances import (
    PLACE_MM,
    PREDRILLED_MM,
    PREDRILLED_ZONE_MM,
    PRINTED_PLACE_MM,
    SEATS_MM,
    STOP_ZONE_MM,
    deviations_um,
)
from delta_cad.dimensions.tolerances.chain import Chain, Link, either_way
from delta_cad.dimensions.tolerances.general import general_mm
from delta_cad.mechanism.jacobian import inverse_jacobian
from delta_cad.mechanism.workspace import cube_grid

ZERO_DEG = 0.5
"""Largest error of a shoulder's angle that control is made for, as the manual's last step has it."""
START_ZERO_DEG = 2.0
"""Largest difference of a stop's angle from a true zero with which a start goes on, see `haptics.loop.start_up`."""
CALIBRATED_MM = 0.1
"""Largest predicted error of a position in the cube with which the manual has `haptics calibrate` keep its result."""
_SAME = 1e-9
_GRID = 5  # positions along a side of the cube: the least lever lies in a corner


def zero_chains(d: Dimensions, general: str) -> list[Chain]:
    """Lists the chains of an encoder's zero; that of the stop of a machine whose encoders sit on the shoulders."""
    return [*([stop_chain(d, general)] if d.sensed_at_shoulder else []), calibrated_chain(d)]


def stop_chain(d: Dimensions, general: str) -> Chain:
    """Computes by how much an arm on its lower stop is off the drawn angle, deg."""
    pin, play = d.bracket.stop_pin_mm, []
    thick = sum(map(abs, deviations_um("m6", pin))) / 4000.0
    if d.capstan is None:
        flank = either_way(
            "upper_arm", "flank that meets the pin", "general", general_mm(2 * d.arm.boss_radius_mm, general)
        )
        links = [flank]
    else:
        c = d.capstan
        at_dowels = degrees(2.0 / d.arm.dowel_circle_mm)
        drilled = general_mm(PREDRILLED_MM, general) / 2.0
        links = [
            either_way("sector", "place of its slot's end", "place", STOP_ZONE_MM / 2.0),
            either_way("sector", "width of its slot", "general", general_mm(c.slot_width_mm, general) / 2.0),
        ]
        play = [
            *(
                either_way(part, "holes drilled for the dowels", "place", PREDRILLED_ZONE_MM / 2.0, at_dowels)
                for part in ("sector", "upper_arm")
            ),
            *(
                either_way(part, "pin in a drilled hole while they are reamed", "general", drilled, at_dowels)
                for part in ("sector", "upper_arm")
            ),
        ]
        links.append(either_way("bearing", "in its seat", "fit", SEATS_MM[0] / 2.0))
    links.append(either_way("motor_cheek", "stop pin from the shoulder's axis", "place", STOP_ZONE_MM / 2.0))
    links.append(either_way("stop_pin", "half of its thickness", "bought", thick))
    turned = [_at(link, stop_radius_mm(d)) for link in links]
    turned.append(
        either_way(
            "upper_arm",
            "bar's bore from the shaft's",
            "place",
            (PRINTED_PLACE_MM if d.is_printed("upper_arm") else PLACE_MM) / 2.0,
            degrees(1.0 / d.arm.length_mm),
        )
    )
    why = "beyond, a start refuses a true zero: stop and zero do not agree"
    return Chain("encoder's zero on its stop", "deg", 0.0, (*turned, *play), -START_ZERO_DEG, START_ZERO_DEG, why)


def _at(link: Link, radius_mm: float) -> Link:
    """The same as an angle about the shoulder, deg."""
    return Link(link.part, link.what, link.kind, link.lower_mm, link.upper_mm, degrees(1.0 / radius_mm))


def calibrated_chain(d: Dimensions) -> Chain:
    """Computes what is left of a zero's error when the machine is calibrated, deg."""
    rows = inverse_jacobian(d.design.geometry, cube_grid(d.design.workspace, _GRID))
    per_mm = degrees(float(np.linalg.norm(rows, axis=-1).max()) * M_PER_MM)
    link = either_way("calibration", "position anywhere in the cube", "set", CALIBRATED_MM, per_mm)
    why = "beyond, haptics calibrate with the poses of the fixture does not give what control needs"
    return Chain("encoder's zero", "deg", 0.0, (link,), -ZERO_DEG, ZERO_DEG, why)


def travel_off_deg(d: Dimensions, general: str) -> float:
    """Computes by how much the angle between both stops may be off as an encoder tells it, worst case, deg.

    Either stop may be off by what is made of it; the encoder adds its error over a turn, and two counts.
    """
    at_stop = ("sector", "stop_pin", "motor_cheek", "upper_arm")
    radius = stop_radius_mm(d)
    links = (link for link in stop_chain(d, general).links if link.part in at_stop)
    made = sum(link.half for link in links if abs(link.share - degrees(1.0 / radius)) < _SAME)
    return 2.0 * made + (d.encoder.nonlinearity_deg or 0.0) + 720.0 / d.encoder.counts_per_turn


def stop_radius_mm(d: Dimensions) -> float:
    """Gives how far from the shoulder's axis an arm meets its stop."""
    if d.capstan is not None:
        return d.capstan.slot_radius_mm
    (u, z), *_ = d.bracket.stop_pins_mm
    return hypot(u - d.bracket.shoulder_u_mm, z)
