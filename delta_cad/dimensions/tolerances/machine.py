"""All tolerance chains of a machine, the loosest general class with which they hold, and how they are written down.

Of a shoulder: its wave spring, the encoder's gap, centring and zero, the tilt of the shaft in its bearings. Of a
capstan: the plane of the cable, the gap of sector and pinion, the carriage's travel. Of the mechanism's own lengths: by
how much a made chain differs from the drawn one, README (43).
"""

from __future__ import annotations

from dataclasses import replace
from math import degrees, inf, sqrt

import numpy as np

from delta_cad import catalogue
from delta_cad.common.memoize import memoize
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.arm import MAGNET_GLUE_MM
from delta_cad.dimensions.bracket import FOOT_OFF_MM, board_screw
from delta_cad.dimensions.cable_run import CableRun
from delta_cad.dimensions.capstan import (
    PINION_TURNED_MM,
    RIM_TURNED_MM,
    STRETCH,
    TENSION_TRAVEL_MM,
    CapstanDimensions,
)
from delta_cad.dimensions.forearm import BALL_GLUE_MM, BAR_GLUE_MM, TILT_MARGIN_RAD
from delta_cad.dimensions.joint import CLEARANCE_MM, CLEARANCE_TOLERANCE_MM
from delta_cad.dimensions.layers import BOARD_STAND_OFF_MM, SPAN_MM
from delta_cad.dimensions.tolerances import (
    BALL_CENTRE_MM,
    BOARD_THREADS_MM,
    BOARD_ZONE_MM,
    CHIP_HEIGHT_MM,
    CHIP_PLACE_MM,
    COAXIAL_MM,
    DOWEL_PLAY_MM,
    EROSION_UM,
    JIG_DEPTH_MM,
    JIG_MOUTH_MM,
    LENGTH_MM,
    LIP_ROOM_MM,
    MAGNET_WIDER_UM,
    MANDREL_MM,
    PLACE_MM,
    PRINTED_PLACE_MM,
    RING_UM,
    SEATS_MM,
    TILT_RAD,
    TRUE_MM,
    WIDTH_MM,
    bar_bore,
    deviations_um,
    minutes,
    working_mm,
)
from delta_cad.dimensions.tolerances.chain import Chain, Kind, Link, either_way
from delta_cad.dimensions.tolerances.edges import RIM_EDGE_MM
from delta_cad.dimensions.tolerances.general import CLASSES, REQUIRED, flat_mm, general_mm
from delta_cad.dimensions.tolerances.mates import pair, screw_zone_mm
from delta_cad.dimensions.tolerances.square import (
    ARM,
    ENCODER_SEAT,
    MOTOR_SEAT,
    SECTOR,
    SHOULDER,
    Feature,
    Zones,
    bearing_chains,
    loosest,
    tilted,
)
from delta_cad.dimensions.tolerances.zero import zero_chains

_MAGNET_MM = 0.1  # thickness of a sintered magnet, either way, as makers state
_FEELER_MM = 0.1  # what is set with a gauge, either way
_MINUTES_PER_RAD = minutes(1.0)


def _shoulder_chains(d: Dimensions, general: str) -> list[Chain]:
    """Lists the chains of one shoulder."""
    found = [*_spring_chain(d), *_tilt_chain(d), *_bearing_chains(d, square_zones(d))]
    return found + ([_gap_chain(d, general), *_centring_chain(d)] if d.sensed_at_shoulder else [])


def _stack(d: Dimensions) -> list[Link]:
    """Lengths between both bearings' seats, as they add to what is left behind the encoder's bearing."""
    (_, out), (seat, _) = d.layers.bearings_mm[0], d.layers.bearings_mm[1]
    motor, encoder = d.layers.motor_cheek_mm[0], d.layers.encoder_cheek_mm[1]
    arm = d.layers.arm_mm[1]
    width = d.layers.bearings_mm[1][1] - motor
    return [
        either_way("motor_cheek", "depth of the seat", "stated", LENGTH_MM, 1.0, width),
        either_way("foot_block", "width", "stated", LENGTH_MM, 1.0, motor - encoder),
        either_way("sector", "from the arm to its collar", "stated", LENGTH_MM, -1.0, seat - arm),
        either_way("upper_arm", "from its collar to the sector", "stated", LENGTH_MM, -1.0, arm - out),
        Link("bearing", "width, motor's side", "bought", -WIDTH_MM, 0.0, -1.0),
        Link("bearing", "width, encoder's side", "bought", -WIDTH_MM, 0.0, -1.0),
    ]


def _spring_chain(d: Dimensions) -> list[Chain]:
    """The height left to a shoulder's wave spring; none without bearings."""
    if d.preload is None:
        return []
    deep = either_way("encoder_cheek", "depth of the seat", "stated", LENGTH_MM, 1.0, _encoder_seat_mm(d))
    low, high = working_mm(d.preload)
    why = "below, the wave spring is pressed flat and the bearings bind; above, it no longer presses"
    return [Chain("wave spring's height", "mm", d.preload.work_height_mm, (*_stack(d), deep), low, high, why)]


def _tilt_chain(d: Dimensions) -> list[Chain]:
    """How far the shaft tilts in its bearings, minutes of arc; none without bearings."""
    if d.preload is None:
        return []
    b = d.bracket
    apart = b.cheek_dowel_u_mm[1] - b.cheek_dowel_u_mm[0]
    per_mm = _MINUTES_PER_RAD / SPAN_MM
    names = ("motor_cheek", "encoder_cheek")
    links = [
        either_way(part, "mandrel in its seat", "fit", (wide + MANDREL_MM) / 2.0, per_mm)
        for part, wide in zip(names, SEATS_MM, strict=True)
    ]
    for part in names:
        links += [
            either_way(part, "dowels lift it", "fit", DOWEL_PLAY_MM, per_mm),
            either_way(part, "dowels turn it", "fit", DOWEL_PLAY_MM, per_mm * 2 * -b.cheek_screw_z_mm / apart),
        ]
    limit = minutes(TILT_RAD)
    why = "beyond, the bearings' races run askew: take the bearings out and set a cheek by the mandrel again"
    return [Chain("shaft's tilt", "arcmin", 0.0, tuple(links), -limit, limit, why, statistical=True)]


def _bearing_chains(d: Dimensions, zones: Zones) -> list[Chain]:
    """How far the rings of either bearing are askew; none without bearings."""
    if d.preload is None:
        return []
    (shaft,), (encoder, motor) = _tilt_chain(d), d.layers.bearings_mm
    seats = motor[1] - d.layers.motor_cheek_mm[0], _encoder_seat_mm(d)
    return bearing_chains(shaft, zones, seats, d.shaft.head_diameter_mm, encoder[1] - encoder[0])


def _encoder_seat_mm(d: Dimensions) -> float:
    """Depth of the seat in the encoder's cheek, which holds the wave spring behind the bearing."""
    assert d.preload is not None
    return d.layers.encoder_cheek_mm[1] - (d.layers.bearings_mm[0][0] - d.preload.work_height_mm)


def _gap_chain(d: Dimensions, general: str) -> Chain:
    """The air gap between the encoder's chip and its magnet."""
    encoder = d.encoder
    board = [
        either_way("board_spacer", "length", *_board_spacer(d, general), 1.0),
        either_way("encoder_board", "height of its chip", "bought", CHIP_HEIGHT_MM, -1.0),
        either_way("encoder_magnet", "thickness", "bought", _MAGNET_MM, -1.0),
        either_way(
            "shoulder_shaft", "depth of the magnet's seat", "general", general_mm(d.shaft.magnet_depth_mm, general)
        ),
    ]
    nominal = d.shaft.y_mm[0] - d.layers.encoder_board_mm[1] - encoder.chip_height_mm
    if d.preload is None:
        links = [*board, either_way("upper_arm", "clamped by a gauge", "set", _FEELER_MM)]
    else:
        head = d.layers.bearings_mm[0][0] - d.shaft.y_mm[0]
        thick = d.layers.encoder_cheek_mm[1] - d.layers.encoder_head_mm[0]
        links = [
            *_stack(d),
            either_way("shoulder_shaft", "length of its head", "general", general_mm(head, general), -1.0, head),
            either_way("encoder_cheek", "thickness of its head", "general", general_mm(thick, general), 1.0, thick),
            *board,
        ]
    why = f"beyond, {encoder.id} reads badly; a shim under its board, or a spacer ground down, mends it"
    low, high = encoder.air_gap_min_mm, encoder.air_gap_max_mm
    return Chain("encoder's air gap", "mm", nominal, tuple(links), low, high, why, statistical=True)


def _board_spacer(d: Dimensions, general: str) -> tuple[Kind, float]:
    """Where the tolerance of a board's spacer comes from, and what it is, mm."""
    if (row := d.board_spacer) is not None:
        return "bought", row.length_tolerance_mm
    return "general", general_mm(BOARD_STAND_OFF_MM, general)


def board_zone_mm(encoder: catalogue.Encoder) -> float:
    """Zone of the threads of an encoder's board: what its holes bear, and its centring."""
    thread = catalogue.screw(board_screw(encoder)).diameter_mm
    return min(screw_zone_mm(encoder.hole_diameter_mm, thread, other_mm=BOARD_ZONE_MM), BOARD_THREADS_MM)


def _centring_chain(d: Dimensions) -> list[Chain]:
    """How far the magnet's axis is off the chip's, in the direction in which it is most; none where it is not known."""
    e = d.encoder
    if e.centring_mm is None:
        return []
    loose = (e.hole_diameter_mm - catalogue.screw(board_screw(e)).diameter_mm) / 2.0
    links = [
        either_way("encoder_cheek", "place of the board's threads", "place", board_zone_mm(e) / 2.0),
        either_way("encoder_board", "its screws in its holes", "bought", loose),
        either_way("encoder_board", "place of the chip", "bought", CHIP_PLACE_MM),
        either_way("encoder_magnet", "in its seat's bond", "set", MAGNET_GLUE_MM + MAGNET_WIDER_UM / 2000.0),
        either_way("shoulder_shaft", "magnet's seat off its journal", "place", COAXIAL_MM / 2.0),
    ]
    if d.preload is not None:
        wide = (SEATS_MM[1] + RING_UM / 1000.0) / 2.0
        links.append(either_way("bearing", "in its seat", "fit", wide))
        shaft = -deviations_um("h6", d.shaft.diameter_mm)[0] / 2000.0
        links.append(either_way("shoulder_shaft", "in its bearing", "fit", shaft))
        deep, (start, end) = _encoder_seat_mm(d), d.layers.bearings_mm[0]
        links.append(tilted(ENCODER_SEAT, square_zones(d), deep, (deep - (end - start)) / 2.0))
    why = f"beyond, {e.id} reads an angle that is off by more than its maker states, which calibration takes out"
    most = e.centring_mm
    return [Chain("encoder's centring", "mm", 0.0, tuple(links), -most, most, why, statistical=True)]


_PILOT_UM = 18.0  # by which a motor's pilot may be smaller than nominal: h7 up to 18 mm
_STEP_MM = 1e-4  # of the differences that give what a length of cable grows by


def cable_chains(d: Dimensions, general: str) -> list[Chain]:
    """Lists the chains of one capstan; none of a direct drive."""
    if d.capstan is None:
        return []
    return [
        plane_chain(d, d.capstan, general, square_zones(d)),
        _axes_chain(d, d.capstan),
        travel_chain(d, d.capstan, general),
    ]


def plane_chain(d: Dimensions, c: CapstanDimensions, general: str, zones: Zones) -> Chain:
    """How far a rim's end is off the strand's take-off along the axis, beside the groove's own climb."""
    rim, limit = d.layers.sector_mm[1], c.run.lug_tolerance_mm()
    by_end, by_groove = rim - min(c.end_y_mm), c.groove_y_mm[1] - c.middle_y_mm
    inside, face = d.layers.motor_cheek_mm[0], d.layers.motor_face_mm
    shaft = (replace(link, share=link.share * c.run.sector_mm / minutes(1.0)) for link in _tilt_chain(d)[0].links)
    arm, sector = d.layers.arm_mm[1] - d.layers.bearings_mm[0][1], d.layers.bearings_mm[1][0] - d.layers.arm_mm[1]
    links = (
        either_way("sector", "place of a rim's end", "general", general_mm(by_end, general), 1.0, by_end),
        either_way("pinion", "groove from its collar", "general", general_mm(by_groove, general), 1.0, by_groove),
        either_way("pinion", "its collar set to the rim by a feeler", "set", _FEELER_MM),
        *shaft,
        either_way(
            "motor_cheek", "pilot out of square", "place", PLACE_MM / 2.0, 2.0 * c.run.pinion_mm / (face - inside)
        ),
        tilted(SECTOR, zones, sector, c.run.sector_mm),
        tilted(ARM, zones, arm, c.run.sector_mm),
    )
    why = "beyond, a strand leaves its plane by more than 2.5 deg and climbs out of the groove: set the pinion by it"
    return Chain("cable's plane", "mm", 0.0, links, -limit, limit, why, statistical=True)


def _between_axes(d: Dimensions, c: CapstanDimensions) -> tuple[Link, ...]:
    """What moves the axes of sector and pinion apart."""
    pilot, bore = d.motor.pilot_diameter_mm, c.pinion_bore_mm
    shaft_um = -deviations_um("h6", d.shaft.diameter_mm)[0]
    play_um = {
        ("motor", "pilot in its cheek"): deviations_um("H7", pilot)[1] + _PILOT_UM,
        ("bearing", "in its seat"): 1000.0 * SEATS_MM[0] + RING_UM,
        ("shoulder_shaft", "in its bearing"): shaft_um,
        ("sector", "on its shaft"): deviations_um("G7", d.shaft.diameter_mm)[1] + shaft_um,
        ("pinion", "on the motor's shaft"): deviations_um("H7", bore)[1] - deviations_um("h6", bore)[0],
    }
    places = either_way("motor_cheek", "pilot from the bearing's seat", "place", PLACE_MM / 2.0)
    fits = (either_way(part, what, "fit", um / 2000.0) for (part, what), um in play_um.items())
    return places, *fits, either_way("pinion", "groove off its bore", "place", TRUE_MM / 2.0)


def _axes_chain(d: Dimensions, c: CapstanDimensions) -> Chain:
    """The gap between rim and crest of the pinion, through which both strands pass."""
    links = (
        *_between_axes(d, c),
        either_way("sector", "radius of its rim", "stated", RIM_TURNED_MM, -1.0, c.rim_radius_mm),
        either_way("pinion", "diameter of its crest", "stated", PINION_TURNED_MM, -0.5, 2 * c.pinion_radius_mm),
    )
    gap = c.run.centre_distance_mm - c.rim_radius_mm - c.pinion_radius_mm
    why = "below, sector and pinion pinch the cable"
    return Chain("gap of sector and pinion", "mm", gap, links, c.cable_diameter_mm, inf, why)


def travel_chain(d: Dimensions, c: CapstanDimensions, general: str) -> Chain:
    """Where the carriage stands from its first place when the cable is tight."""
    length, tolerance = c.bench_mm
    run = c.run
    sector, pinion, apart = (
        (_path_mm(run, _STEP_MM * axis) - _path_mm(run, -_STEP_MM * axis)) / (2.0 * _STEP_MM) for axis in np.eye(3)
    )
    nose = general_mm(c.nose_radius_mm, general)
    links = (
        either_way("capstan_cable", "length between its sleeves", "stated", tolerance, 1.0),
        either_way("sector", "radius of its rim", "stated", RIM_TURNED_MM, -sector, c.rim_radius_mm),
        either_way("sector", "radius of its nose", "general", nose, -c.turns_rad[0], c.nose_radius_mm),
        either_way("pinion", "diameter of its groove", "stated", PINION_TURNED_MM, -pinion / 2, 2 * run.pinion_mm),
        *(replace(link, share=-apart * link.share) for link in _between_axes(d, c)),
    )
    most = TENSION_TRAVEL_MM - STRETCH * c.cable_length_mm
    why = "below, the cable does not go on; above, it is not tight where the carriage's pocket ends: crimp another"
    return Chain("carriage's travel", "mm", length - c.cable_length_mm, links, 0.0, most, why, statistical=True)


def _path_mm(run: CableRun, off_mm: np.ndarray) -> float:
    """Length of the cable where both radii, of sector and pinion, and the axes' distance are off by (3,) these.

    The rim's ends stay where they are on the sector: the tangent points move past them.
    """
    sector, pinion, apart = (float(v) for v in off_mm)
    radii = {"sector_mm": run.sector_mm + sector, "pinion_mm": run.pinion_mm + pinion}
    made = replace(run, gap_mm=run.gap_mm + apart - sector - pinion, **radii)
    return replace(made, beyond_rad=run.beyond_rad + run.tangent_rad - made.tangent_rad).length_mm()


_CENTRED_MM = 0.05  # a cross-bar in its boss, along it, set by a gauge block between ball and boss, either way
_WHY = "beyond, what is proved of the cube is not of every machine that is made"


def length_chains(d: Dimensions, general: str) -> list[Chain]:
    """Lists by how much each length and offset of a chain is off the drawn one, without bounds of their own."""
    return _length_chains(d, general, square_zones(d))


@memoize
def square_zones(d: Dimensions) -> Zones:
    """Finds how square bores and shoulders of a machine are to what they count from, mm: as loose as all chains bear.

    An arm's bore may tilt the arm as far as its elbow is no more off along the axis than the worst length is off.
    """
    features: list[Feature] = [ARM]
    if d.capstan is not None:
        features += [MOTOR_SEAT, ENCODER_SEAT, SHOULDER, SECTOR]

    def chains(zones: Zones) -> list[Chain]:
        lengths = {chain.name: chain for chain in _length_chains(d, REQUIRED, zones)}
        along = lengths.pop("shoulder along its axis")
        most = max(map(deviation_mm, lengths.values()))
        found = [replace(along, low=-most, high=most), *_bearing_chains(d, zones)]
        return found if d.capstan is None else [*found, plane_chain(d, d.capstan, REQUIRED, zones)]

    return loosest(features, chains)


def _length_chains(d: Dimensions, general: str, zones: Zones) -> list[Chain]:
    m = d.design.mechanism
    size_mm = max(high - low for low, high in d.base.reach_mm)
    flat = either_way("base_plate", "flat under the feet", "general", flat_mm(size_mm, general) / 2.0)
    out, side, _ = m.base_radii_mm or (m.base_radius_mm,) * 3
    of = {"base radius": out} if out == side else {"base radius of chain 0": out, "base radius of chains 1, 2": side}
    chains = {
        **{name: (radius, [*_shoulder(d), *_turned(d, True)]) for name, radius in of.items()},
        "shoulder's height": (0.0, [*_shoulder(d), *_turned(d, False), flat]),
        "shoulder along its axis": (0.0, _along(d, zones)),
        "upper arm": (m.upper_arm_length_mm, _arm(d)),
        "forearm": (m.forearm_length_mm, _rod()),
        "platform radius": (m.platform_radius_mm, _wrist(d)),
        "wrist's height": (0.0, _wrist(d)),
        "wrist along its axis": (0.0, _adjacent(d)),
    }
    return [Chain(name, "mm", nominal, tuple(links), -inf, inf, _WHY) for name, (nominal, links) in chains.items()]


def _foot_chain(d: Dimensions, general: str) -> Chain:
    """The gap of a cheek over the plate, on which the foot block stands alone."""
    b = d.bracket
    why = "below, a cheek stands on the plate and its block does not"
    if d.is_printed("foot_block") or d.is_printed("motor_cheek"):
        set_ = either_way("cheek", "set by a feeler before its dowels' holes are reamed", "set", _FEELER_MM)
        return Chain("cheek off the plate", "mm", FOOT_OFF_MM, (set_,), 0.0, inf, why)
    first, second = ((u - b.shoulder_u_mm, b.cheek_screw_z_mm) for u in b.cheek_dowel_u_mm)
    corner = b.foot_u_mm[0] - b.shoulder_u_mm, b.base_top_mm + FOOT_OFF_MM
    moved = pair(first, second, PLACE_MM).shift_mm(corner, np.array([[0.0, 1.0], [0.0, -1.0]]))
    edge = general_mm(b.cheek_screw_z_mm - corner[1], general)
    links = (
        either_way("cheek", "lower edge from its dowels", "general", edge),
        either_way("cheek", "places of its dowels and the block's", "place", moved),
        either_way("foot_block", "height of its cross dowels", "place", PLACE_MM / 2.0),
    )
    return Chain("cheek off the plate", "mm", FOOT_OFF_MM, links, 0.0, inf, why)


def _twist_chain(d: Dimensions) -> Chain:
    """By how much the rods of a pair, not equally long, turn the platform, deg."""
    per_mm = degrees(1.0 / d.forearm.width_mm)
    links = tuple(
        replace(link, what=f"{link.what}, rod {k}", share=sign * per_mm)
        for k, sign in ((1, 1.0), (2, -1.0))
        for link in _rod()
    )
    limit = degrees(TILT_MARGIN_RAD)
    why = "beyond, ball joints turn further than they are made for"
    return Chain("platform's twist", "deg", 0.0, links, -limit, limit, why)


def _level_chain(d: Dimensions) -> Chain:
    """By how much a cup turns about its rod in the jig, deg: until its lip meets the pad."""
    per_mm = degrees(1.0 / d.forearm.cup_radius_mm)
    links = (
        either_way("rod_jig", "depth of its seats", "stated", JIG_DEPTH_MM, per_mm),
        either_way("rod_jig", "radius of its cones' mouths", "stated", JIG_MOUTH_MM / 2, per_mm),
    )
    limit = degrees(TILT_MARGIN_RAD)
    why = (
        "beyond, ball joints turn further than they are made for; below, a lip lies on the pad and its seat on no ball"
    )
    return Chain("cup's turn in the jig", "deg", per_mm * LIP_ROOM_MM, links, 0.0, limit, why)


def deviation_mm(chain: Chain) -> float:
    """Computes the largest deviation of a chain's length from its nominal value, either way, mm."""
    low, high = chain.worst
    return max(high - chain.nominal, chain.nominal - low)


def largest_deviation_mm(d: Dimensions, general: str) -> float:
    """Computes the largest deviation of any length of the mechanism, mm: the d of README (43)."""
    return max(map(deviation_mm, length_chains(d, general)))


def place_mm(d: Dimensions, number: str) -> float:
    """Gives the zone for the axes of a part's fitted bores, by its process, mm."""
    return PRINTED_PLACE_MM if d.is_printed(number) else PLACE_MM


def _shoulder(d: Dimensions) -> list[Link]:
    """From the base plate to the shoulder's axis, across it."""
    place = place_mm(d, "motor_cheek") / 2.0
    links = [
        either_way("base_plate", "place of a dowel", "place", place_mm(d, "base_plate") / 2.0),
        either_way("foot_block", "dowels in the plate", "fit", DOWEL_PLAY_MM),
        either_way("foot_block", "cross dowels from the upright ones", "place", place_mm(d, "foot_block") / 2.0),
    ]
    if d.capstan is None:
        pilot = (deviations_um("H7", d.motor.pilot_diameter_mm)[1] + 18.0) / 2000.0
        links += [
            either_way("motor_cheek", "dowels in the block", "fit", DOWEL_PLAY_MM),
            either_way("motor_cheek", "pilot from its dowels", "place", place),
            either_way("motor", "pilot in its cheek", "fit", pilot),
        ]
        return links
    seat = (SEATS_MM[0] + RING_UM / 1000.0) / 2.0
    return [
        *links,
        either_way("motor_cheek", "dowels in the block", "fit", DOWEL_PLAY_MM),
        either_way("motor_cheek", "seat from its dowels", "place", place),
        either_way("bearing", "in its seat", "fit", seat),
        either_way("shoulder_shaft", "in its bearing", "fit", -deviations_um("h6", d.shaft.diameter_mm)[0] / 2000.0),
    ]


def _turned(d: Dimensions, radially: bool) -> list[Link]:
    """What the turn of block and cheek on their dowels adds to the places of these at the shoulder."""
    b = d.bracket
    first, second = ((u - b.shoulder_u_mm, b.cheek_screw_z_mm) for u in b.cheek_dowel_u_mm)
    way = np.array([[1.0, 0.0], [-1.0, 0.0]] if radially else [[0.0, 1.0], [0.0, -1.0]])
    place = place_mm(d, "motor_cheek")
    cheek = pair(first, second, place).shift_mm((0.0, 0.0), way) - place
    return [either_way("motor_cheek", "turned by its dowels' places", "place", cheek)]


def _along(d: Dimensions, zones: Zones) -> list[Link]:
    """From the base plate to the arm's elbow, along the shoulder's axis."""
    bore = d.layers.arm_mm[1] - (d.layers.arm_mm[0] if d.capstan is None else d.layers.bearings_mm[0][1])
    links = [
        tilted(ARM, zones, bore, d.arm.length_mm),
        either_way("base_plate", "place of a dowel", "place", place_mm(d, "base_plate") / 2.0),
        either_way("foot_block", "dowels in the plate", "fit", DOWEL_PLAY_MM),
        either_way("foot_block", "dowels from its middle", "place", place_mm(d, "foot_block") / 2.0),
        either_way("foot_block", "width", "stated", LENGTH_MM, 0.5),
    ]
    if d.capstan is None:
        return [*links, either_way("upper_arm", "clamped by a gauge", "set", 0.1)]
    return [
        *links,
        either_way("motor_cheek", "depth of the seat", "stated", LENGTH_MM),
        Link("bearing", "width, motor's side", "bought", -WIDTH_MM, 0.0, -1.0),
        either_way("sector", "from the arm to its collar", "stated", LENGTH_MM, -1.0),
    ]


def _bar_mm(d: Dimensions, number: str) -> float:
    """Radial play of a cross-bar that is bonded in a part, mm: it hardens anywhere in its bore."""
    bar = -deviations_um("h6", d.forearm.bar_diameter_mm)[0]
    return BAR_GLUE_MM + (bar_bore(d.is_printed(number))[0] + bar) / 2000.0


def _arm(d: Dimensions) -> list[Link]:
    bore, shaft = deviations_um("H7", d.arm.shaft_bore_mm)[1], -deviations_um("h6", d.arm.shaft_bore_mm)[0]
    return [
        either_way("upper_arm", "bar's bore from the shaft's", "place", place_mm(d, "upper_arm") / 2.0),
        either_way("upper_arm", "on its shaft", "fit", (bore + shaft) / 2000.0),
        *_ball_links(d, "upper_arm"),
    ]


def _ball_links(d: Dimensions, holder: str) -> list[Link]:
    """From a bar's bore to a ball's centre, across the bar: what the mean of both its ends is off at most."""
    f = d.forearm
    pin = -deviations_um("h7", f.pin_diameter_mm)[0] + EROSION_UM
    return [
        either_way("cross_bar", "in its bond", "set", _bar_mm(d, holder)),
        either_way("cross_bar", "studs off its middle", "place", TRUE_MM / 2.0),
        either_way("joint_ball", "on its stud, in its bond", "set", BALL_GLUE_MM + pin / 2000.0),
        either_way("joint_ball", "hole off its centre", "place", BALL_CENTRE_MM),
    ]


def _rod() -> list[Link]:
    """Both seats of a rod, bonded on the balls of its jig, each with the play of its clearance."""
    return [
        either_way("rod_jig", "places of its cones", "place", PLACE_MM),
        either_way("cup_shell", "both seats on the jig's balls", "stated", 2 * (CLEARANCE_MM + CLEARANCE_TOLERANCE_MM)),
    ]


def _wrist(d: Dimensions) -> list[Link]:
    return [
        either_way("platform", "place of a bar's bore", "place", place_mm(d, "platform") / 2.0),
        *_ball_links(d, "platform"),
    ]


def _adjacent(d: Dimensions) -> list[Link]:
    """A wrist along its axis, middle of a pair."""
    hole = d.forearm.pin_diameter_mm / 2 + BALL_GLUE_MM
    slope = hole / sqrt((d.forearm.ball_diameter_mm / 2) ** 2 - hole**2)
    rim = slope * EROSION_UM / 2000.0
    return [
        either_way("cross_bar", "set in its boss by a gauge", "set", _CENTRED_MM),
        either_way("cross_bar", "distance of its shoulders", "stated", LENGTH_MM, 0.5),
        either_way("joint_ball", "rim of its hole, one end", "bought", rim, 0.5),
        either_way("joint_ball", "rim of its hole, other end", "bought", rim, 0.5),
        Link("joint_ball", "edge of its hole, one end", "stated", -RIM_EDGE_MM, 0.0, 0.5 * slope),
        Link("joint_ball", "edge of its hole, other end", "stated", -RIM_EDGE_MM, 0.0, -0.5 * slope),
    ]


def machine_chains(d: Dimensions, general: str = REQUIRED) -> list[Chain]:
    """Lists the chains that have bounds; the three chains of a machine are alike."""
    own = [_foot_chain(d, general), _twist_chain(d), _level_chain(d)]
    return [*_shoulder_chains(d, general), *cable_chains(d, general), *own, *zero_chains(d, general)]


def loosest_class(d: Dimensions) -> str | None:
    """Finds the loosest general class with which every chain holds; None: not even the finest does."""
    holding = [name for name in CLASSES if all(chain.holds for chain in machine_chains(d, name))]
    return holding[-1] if holding else None


def general_class(d: Dimensions) -> str:
    """Chooses the general class that drawings state: the usual one, or a finer one where chains need it."""
    loosest = loosest_class(d)
    return REQUIRED if loosest is None or CLASSES.index(loosest) >= CLASSES.index(REQUIRED) else loosest
