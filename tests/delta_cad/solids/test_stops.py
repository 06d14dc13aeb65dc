"""The stop pins stop: beyond the stop angle pin and moving part share material, before it they do not."""

from __future__ import annotations

from math import cos, degrees, hypot, sin
from typing import Any

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.machine import Assembly
from delta_cad.design import design_from_dict
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.solids.part import Occurrence
from tests.committed import changed
from tests.delta_cad.solids.measured import placed

DIRECT: dict[str, Any] = {
    "hardware__drive": "direct",
    "hardware__arm_thickness_mm": 8.0,
    "mechanism__base_radius_mm": 36.0,
    "cube__bottom_height_mm": 76.0,
}
DESIGNS: dict[str, dict[str, Any]] = {
    "capstan": {},
    "direct, 60 mm motor": DIRECT | {"hardware__motor": "maxon-ec60flat-625858"},
    "capstan, thick arm": {"hardware__arm_thickness_mm": 14.0, "mechanism__base_radius_mm": 38.0},
    "capstan, wide bearing": {"hardware__bearing": "608", "mechanism__base_radius_mm": 34.0},
    "capstan, slot into the rim": {"hardware__capstan_ratio": 3.09, "hardware__sector_radius_mm": 25.2},
    "direct, 43 mm motor": DIRECT | {"hardware__motor": "maxon-ec45flat-411812"},
}
NOISE_MM3 = 1e-9
"""A boolean of parts that do not meet gives no solid at all; 1 deg beyond a stop some 0.5 mm of pin are inside."""


@pytest.fixture(scope="module", params=DESIGNS)
def machine(request: pytest.FixtureRequest) -> tuple[Dimensions, Assembly]:
    d = dimensions(design_from_dict(changed(**DESIGNS[request.param])))
    return d, assemble(d)


def of_chain_0(assembly: Assembly, name: str) -> list[Occurrence]:
    return [o for o in assembly.occurrences if o.name.startswith(f"{name}_0")]


def turned(d: Dimensions, theta: float) -> np.ndarray:
    """(4, 4) arm of chain 0, which lies in the x-z plane, at a shoulder angle."""
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 2] = (cos(theta), 0.0, sin(theta)), (-sin(theta), 0.0, cos(theta))
    frame[0, 3] = d.design.mechanism.base_radius_mm
    return frame


def pins_and_stopped(d: Dimensions, assembly: Assembly) -> tuple[list[cq.Shape], cq.Shape]:
    pins = [placed(o.part.solid, o.placement) for o in of_chain_0(assembly, "stop_pin")]
    (stopped,) = of_chain_0(assembly, "upper_arm" if d.capstan is None else "sector")
    return pins, stopped.part.solid


def common(d: Dimensions, assembly: Assembly, theta: float) -> float:
    """Volume that pins and stopped part share, mm^3."""
    pins, solid = pins_and_stopped(d, assembly)
    return sum(pin.intersect(placed(solid, turned(d, theta))).Volume() for pin in pins)


@pytest.mark.quick(2)
def test_arms_are_stopped_three_degrees_outside_the_cube_and_not_before(machine: tuple[Dimensions, Assembly]) -> None:
    d, assembly = machine
    low, high = np.degrees([d.extremes.shoulder_min.value, d.extremes.shoulder_max.value])
    for stop, outwards in ((low - 3.0, -1.0), (high + 3.0, 1.0)):
        assert common(d, assembly, np.radians(stop - outwards)) < NOISE_MM3
        assert common(d, assembly, np.radians(stop + outwards)) > 0.1
    assert common(d, assembly, np.radians(low)) < NOISE_MM3
    assert common(d, assembly, np.radians(high)) < NOISE_MM3
    assert np.degrees(d.stops_rad) == pytest.approx([low - 3.0, high + 3.0])


@pytest.mark.quick(2)
def test_each_direction_has_a_pin_that_reaches_3_mm_into_what_it_stops(machine: tuple[Dimensions, Assembly]) -> None:
    """Depth along the shoulder axis of what they share, measured on the solids 1 deg beyond the stop."""
    d, assembly = machine
    pins, solid = pins_and_stopped(d, assembly)
    for stop, outwards in zip(d.stops_rad, (-1.0, 1.0), strict=True):
        arm = placed(solid, turned(d, stop + outwards * np.radians(1.0)))
        shared = [s for pin in pins if (s := pin.intersect(arm)).Volume() > 0.1]
        assert len(shared) == 1, degrees(stop)
        box = shared[0].BoundingBox()
        assert box.ymax - box.ymin >= 3.0 - 0.4 - 1e-6  # less the arm's broken edge of 0.4 mm


@pytest.mark.quick(2)
def test_pins_are_held_in_the_cheek_and_touch_nothing_else(machine: tuple[Dimensions, Assembly]) -> None:
    d, assembly = machine
    (cheek,) = of_chain_0(assembly, "motor_cheek")
    (other,) = of_chain_0(assembly, "encoder_cheek")
    inside, outside = d.layers.motor_cheek_mm
    pin_mm, shoulder = d.bracket.stop_pin_mm, d.design.mechanism.base_radius_mm
    for o in of_chain_0(assembly, "stop_pin"):
        pin = placed(o.part.solid, o.placement)
        box = pin.BoundingBox()
        held = min(box.ymax, outside) - max(box.ymin, inside)
        assert held >= pin_mm == pytest.approx(min(box.xlen, box.zlen))  # at least its diameter
        across = d.design.requirements.peak_torque_N_m * 1000.0 / hypot(box.center.x - shoulder, box.center.z)
        lever = held / 2 + inside - box.ymin  # from the middle of what is held to the pin's free end
        pressure = across / (pin_mm * held) * (1.0 + 6.0 * lever / held)  # N/mm^2, linear along a stiff pin
        assert pressure <= 125.0  # half the proof stress of the cheek's EN AW-6082
        assert box.ymax <= outside - 0.4
        assert pin.intersect(placed(cheek.part.solid, cheek.placement)).Volume() < NOISE_MM3
        assert pin.distance(placed(other.part.solid, other.placement)) > 1.0


def test_no_stop_pin_reaches_into_its_motor(machine: tuple[Dimensions, Assembly]) -> None:
    """The motor stands in its cheek's pocket, and next to a small sector over the pin."""
    d, assembly = machine
    pins, _ = pins_and_stopped(d, assembly)
    (motor,) = of_chain_0(assembly, "motor")
    body = placed(motor.part.solid, motor.placement)
    assert sum(pin.intersect(body).Volume() for pin in pins) < NOISE_MM3
