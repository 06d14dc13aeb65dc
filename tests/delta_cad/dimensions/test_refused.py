"""What cannot be made is refused, and names the changes that end it."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import pytest

from delta_cad import catalogue
from delta_cad.design import Design
from delta_cad.dimensions import DimensionError, Dimensions, dimensions, preload_spring
from delta_cad.dimensions.arm import shaft_dimensions
from delta_cad.dimensions.bracket import MESHES_MM
from delta_cad.dimensions.capstan import CapstanDimensions, cable_run, capstan_dimensions, pinion_places
from delta_cad.dimensions.layers import Layers, layers
from delta_cad.dimensions.platform import platform_dimensions
from delta_cad.dimensions.rules import WIDTH, larger, require
from delta_cad.mechanism import UnreachableError
from tests.delta_cad.dimensions.edited import edited

SMALL_CUBE: dict[str, float | str] = {"bottom_height_mm": 70.0, "half_side_mm": 8.0}
# Without a pinion, whose set screws would not come to their key's slot in so small a cube.
DIRECT: dict[str, float | str] = {"drive": "direct", "motor": "maxon-ec60flat-625858", "arm_thickness_mm": 14.0}
REFUSED = {
    # what: (changes, field, a value that is refused, part, feature, whether it is to grow or to shrink)
    "arm": (SMALL_CUBE | {"bottom_height_mm": 88.0}, "upper_arm_length_mm", 45.0, "upper_arm", "length", 1),
    "tube": (
        DIRECT | {"upper_arm_length_mm": 60.0, "bottom_height_mm": 60.0, "half_side_mm": 5.0},
        "forearm_length_mm",
        40.0,
        "rod_tube",
        "length",
        1,
    ),
    "block": (
        DIRECT | {"motor": "maxon-ec45flat-411812"},
        "arm_thickness_mm",
        7.9,
        "foot_block",
        "thickness",
        1,
    ),
    "board": (DIRECT, "base_radius_mm", 31.0, "encoder_board", "beside the neighbour's motor", 1),
    "hub": (
        SMALL_CUBE | DIRECT | {"parallelogram_width_mm": 34.5, "platform_thickness_mm": 16.0},
        "platform_radius_mm",
        17.0,
        "platform",
        "hub",
        1,
    ),
    "wrists": (
        SMALL_CUBE | DIRECT | {"ball_diameter_mm": 6.0},
        "platform_radius_mm",
        21.5,
        "platform",
        "wrists",
        1,
    ),
    "short spring": (SMALL_CUBE, "parallelogram_width_mm", 33.0, "rod_spring", "length", 1),
    "long spring": (
        SMALL_CUBE | {"platform_radius_mm": 70.0, "bottom_height_mm": 80.0},
        "parallelogram_width_mm",
        160.0,
        "rod_spring",
        "length",
        -1,
    ),
    "slot": ({"capstan_ratio": 3.0, "base_radius_mm": 43.0}, "sector_radius_mm", 20.0, "sector", "slot", 1),
    "base": ({}, "base_plate_thickness_mm", 4.5, "base_plate", "counterbore", 1),
    "collar": ({}, "platform_thickness_mm", 8.0, "platform", "wrist boss", 1),
    "thick boss": (
        DIRECT | {"parallelogram_width_mm": 34.5, "platform_radius_mm": 27.0, "base_radius_mm": 40.0},
        "platform_thickness_mm",
        30.0,
        "platform",
        "wrist boss, length",
        -1,
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_cannot_be_made_is_refused_and_the_change_that_is_named_ends_it(what: str) -> None:
    changes, field, value, part, feature, sense = REFUSED[what]
    with pytest.raises(DimensionError) as refused:
        edited(**(changes | {field: value}))
    assert (refused.value.part, refused.value.feature) == (part, feature)
    message = str(refused.value)
    assert message.startswith(f"{part}, {feature}: ")
    assert "\n" not in message
    ways = {(way.fields, way.larger) for way in refused.value.reasons[0].ways}
    assert {(tuple(f"{section}.{field}" for _ in "1"), sense > 0) for section in ("mechanism", "hardware")} & ways
    for share in (1.05, 1.1, 1.2, 1.4, 2.0):  # a step of them ends it, whatever else it brings
        try:
            edited(**(changes | {field: value * share**sense}))
        except DimensionError as error:
            if (part, feature) in {one.key for one in error.reasons}:
                continue
        break
    else:
        pytest.fail(f"{field} ends it nowhere")


def test_a_boss_that_no_thinner_platform_makes_long_enough_asks_for_a_wider_parallelogram(
    best_dimensions: Dimensions,
) -> None:
    d = best_dimensions
    narrow = replace(d.forearm, width_mm=22.0)
    with pytest.raises(DimensionError) as refused:
        platform_dimensions(d.platform.radius_mm, 10.0, narrow, d.knob)
    (reason,) = refused.value.reasons
    assert larger(WIDTH) in reason.ways
    made = platform_dimensions(d.platform.radius_mm, 10.0, d.forearm, d.knob)
    assert made.boss_length_mm >= 10.0


def direct_layers(d: Dimensions, arm_mm: float, motor: catalogue.Motor, grown: float = 1.0) -> Layers:
    """The stack of a direct drive with an arm of a thickness on a motor."""
    none = {"rim_mm": None, "pinion_end_mm": 0.0, "preload_mm": 0.0}
    return layers(arm_thickness_mm=arm_mm, bearing=d.bearing, encoder=d.encoder, motor=motor, grown=grown, **none)


def test_a_thin_arm_clamps_too_little_of_a_thick_shaft(best_dimensions: Dimensions) -> None:
    """By hand: 3.5 mm of the plate's bore are the stub's and a gap, and half of 12 mm is to be clamped."""
    d = best_dimensions
    motor = replace(catalogue.motor("maxon-ec60flat-625858"), shaft_diameter_mm=12.0)
    with pytest.raises(DimensionError, match=r"^upper_arm, shaft bore: 4\.4 mm .* at least 6$"):
        direct_layers(d, 7.9, motor)
    with pytest.raises(DimensionError, match="shaft bore"):
        direct_layers(d, 9.49, motor)
    direct_layers(d, 9.5, motor)


def test_a_shaft_that_a_thick_cheek_keeps_from_the_arm_asks_for_a_longer_one_and_no_thicker_arm(
    best_dimensions: Dimensions,
) -> None:
    """A cheek of 12 mm and 1 mm beside it leave 2 mm of a shaft of 15, however thick the arm is."""
    d = best_dimensions
    motor = catalogue.motor("maxon-ec60flat-408057")
    grown = (12.0 / 6.0) ** 3
    for thickness in (9.5, 20.0):
        with pytest.raises(DimensionError) as refused:
            direct_layers(d, thickness, motor, grown)
        assert [one.field for one in refused.value.reasons] == ["hardware.motor"]
        assert "15 mm lacks 2 mm" in refused.value.reasons[0].message
    direct_layers(d, 20.0, replace(motor, shaft_length_mm=17.0), grown)


def test_a_ball_that_is_not_in_the_catalogue_is_refused_with_those_that_are() -> None:
    with pytest.raises(DimensionError, match=r"^joint_ball, diameter: .* 9 mm; it has 5, 6, 8, 10 mm$"):
        edited(ball_diameter_mm=9.0)


def test_a_magnet_wider_than_the_inner_ring_is_refused(best_dimensions: Dimensions) -> None:
    """A seat of 8.1 mm and 0.9 mm around it, which would touch more than the bearing's inner ring."""
    d = best_dimensions
    narrow = replace(d.bearing, inner_ring_outer_mm=9.8)
    wide = catalogue.magnet("ndfeb-8x2.5-diametric")
    with pytest.raises(DimensionError, match=r"^shoulder_shaft, magnet seat: .* 9\.9 mm"):
        shaft_dimensions(8.0, "capstan", d.layers, narrow, d.encoder, wide)
    made = shaft_dimensions(8.0, "capstan", d.layers, replace(d.bearing, inner_ring_outer_mm=9.9), d.encoder, wide)
    assert made.head_diameter_mm == pytest.approx(9.9)


def test_a_shaft_too_thin_for_a_screw_in_its_end_is_refused(best_dimensions: Dimensions) -> None:
    d = best_dimensions
    for bore, size in ((8.0, "M4"), (7.0, "M4"), (6.9, "M3"), (5.5, "M2.5")):
        assert shaft_dimensions(bore, "capstan", d.layers, d.bearing, d.encoder, d.magnet).end_screw == size
    with pytest.raises(DimensionError, match=r"^shoulder_shaft, end screw: .* takes 5\.5 mm$"):
        shaft_dimensions(5.4, "capstan", d.layers, d.bearing, d.encoder, d.magnet)


def test_a_bearing_without_a_wave_spring_is_refused(best_dimensions: Dimensions) -> None:
    assert preload_spring(best_dimensions.bearing).housing_mm == best_dimensions.bearing.outer_mm
    with pytest.raises(DimensionError, match=r"^shoulder, preload: .* 17 mm; for "):
        preload_spring(replace(best_dimensions.bearing, outer_mm=17.0))


def test_the_least_thicknesses_are_what_the_features_in_them_need() -> None:
    """By hand: a dowel of 3 mm and 1 mm on either side; 1 mm around a bar of 8 mm."""
    edited(platform_thickness_mm=10.0 * (1 + 1e-12))  # on the bound, but for its last digit
    with pytest.raises(DimensionError, match=r"^platform, wrist boss: "):
        edited(platform_thickness_mm=10.0 * (1 - 1e-9))


def test_a_stop_pin_longer_than_any_in_stock_is_refused(best_dimensions: Dimensions) -> None:
    """Half a millimetre sunk outside and 3 mm into the web: a pin of 40 mm spans 36.5 mm between the two faces."""
    from delta_cad.solids.brackets import stop_pin_length_mm

    layers, longest = best_dimensions.layers, max(catalogue.dowel("4").lengths_mm)

    def pin(outside: float) -> float:
        moved = replace(layers, motor_cheek_mm=(layers.motor_cheek_mm[0], outside))
        return stop_pin_length_mm(replace(best_dimensions, layers=moved))

    face = web(best_dimensions) + longest - 2.5
    assert pin(face - 1e-9) == longest
    with pytest.raises(DimensionError, match=r"^stop_pin, length: .* 40 mm$"):
        pin(face + 1e-6)


@pytest.mark.parametrize("outside", [18.0, 20.5, 22.4])
def test_the_stop_pin_is_the_shortest_in_stock_that_reaches_3_mm_deep(
    best_dimensions: Dimensions, outside: float
) -> None:
    from delta_cad.solids.brackets import stop_pin_length_mm

    layers, stock = best_dimensions.layers, catalogue.dowel("4").lengths_mm
    moved = replace(layers, motor_cheek_mm=(layers.motor_cheek_mm[0], outside))
    length = stop_pin_length_mm(replace(best_dimensions, layers=moved))
    deep = [web(best_dimensions) - (outside - 0.5 - v) for v in stock]
    assert length == min(v for v, into in zip(stock, deep, strict=True) if into >= 3.0 - 1e-9)


def web(d: Dimensions) -> float:
    """Face of the sector's web, 3 mm thick about its middle, that the stop pin reaches into."""
    return sum(d.layers.sector_mm) / 2 + 1.5


def made_capstan(d: Dimensions, shoulder: tuple[float, float], motor: catalogue.Motor) -> CapstanDimensions:
    assert d.capstan is not None
    h = d.design.hardware
    run = cable_run(h.sector_radius_mm, h.capstan_ratio, shoulder, d.cable)
    apart = d.design.requirements.clearance_min_mm + MESHES_MM
    return capstan_dimensions(
        place=pinion_places(run, d.layers.sector_mm, d.cable.diameter_mm, motor, apart)[0],
        run=run,
        ratio=h.capstan_ratio,
        shoulder_rad=shoulder,
        layers=d.layers,
        cable=d.cable,
        motor=motor,
        stop_pin_mm=4.0,
        slot_radius_mm=d.capstan.slot_radius_mm,
        direction_rad=radians(-115.0),
    )


def test_a_motor_shaft_too_short_for_the_pinion_is_refused(best_dimensions: Dimensions) -> None:
    d = best_dimensions
    shaft = d.layers.motor_face_mm - made_capstan(d, (-0.6, 1.1), d.motor).pinion_y_mm[1] + 5.9
    with pytest.raises(DimensionError, match=r"^pinion, bore: .* 5\.9 mm.* 6$"):
        made_capstan(d, (-0.6, 1.1), replace(d.motor, shaft_length_mm=shaft))
    made_capstan(d, (-0.6, 1.1), replace(d.motor, shaft_length_mm=shaft + 0.2))


def test_a_sector_of_more_than_250_degrees_is_refused(best_dimensions: Dimensions) -> None:
    c = made_capstan(best_dimensions, (-1.0, 1.0), best_dimensions.motor)
    over = c.rim_angles_rad[1] - c.rim_angles_rad[0] - 2.0  # what the sector has beyond the shoulder's range
    widest = (radians(250.0) - over) / 2
    made_capstan(best_dimensions, (-widest + 1e-9, widest - 1e-9), best_dimensions.motor)
    with pytest.raises(DimensionError, match=r"^sector, angle: .* 250$"):
        made_capstan(best_dimensions, (-widest - 1e-6, widest + 1e-6), best_dimensions.motor)


def test_an_unreachable_cube_is_refused_before_any_dimension(best: Design) -> None:
    """The design file's own closed forms stand before it; here they are passed by."""
    unchecked = best.model_copy(update={"cube": best.cube.model_copy(update={"half_side_mm": 80.0})})
    with pytest.raises(UnreachableError, match="chain"):
        dimensions(unchecked)


def test_require_says_part_feature_and_message() -> None:
    require(True, "a", "b", "c")
    with pytest.raises(DimensionError, match=r"^a, b: c$"):
        require(False, "a", "b", "c")
