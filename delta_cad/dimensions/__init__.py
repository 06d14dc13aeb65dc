"""Design -> every dimension of every part, in millimetres.

One record a group of parts, each in a file of its own with the function that derives it; `dimensions` derives all.
No CAD kernel is loaded here.

Frames: the chain's (u, t, z) is radial, tangential (along the shoulder axis), up, from the base centre; the arm's
(x, y, z) is along the arm, along the shoulder axis, square to both, from the shoulder.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import pi

import numpy as np

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.design.process import is_printed, material_of
from delta_cad.design.stands import EVEN, Gap, gaps_of
from delta_cad.dimensions.arm import ArmDimensions, ShaftDimensions, arm_dimensions, shaft_dimensions
from delta_cad.dimensions.bracket import (
    BOARD_EDGE_MM,
    MESHES_MM,
    STOP_PIN_MM,
    BracketDimensions,
    Circle,
    board_screw,
    bracket_dimensions,
    key_rad,
    require_room_for_board,
    require_room_for_boss,
)
from delta_cad.dimensions.cable_run import CableRun
from delta_cad.dimensions.capstan import (
    CapstanDimensions,
    cable_run,
    capstan_dimensions,
    pinion_places,
    rim_y_mm,
    turns_end_mm,
)
from delta_cad.dimensions.direction import (
    INMOST_RAD,
    farther_out_rad,
    pinion_direction_rad,
    pinion_room_mm,
    sleeve_direction_rad,
)
from delta_cad.dimensions.forearm import BAR_GLUE_MM, CROSS_BAR_MM, ForearmDimensions, forearm_dimensions
from delta_cad.dimensions.layers import (
    BOARD_SPACER_WALLS_MM,
    BOARD_STAND_OFF_MM,
    SET_SCREWS_RAD,
    Layers,
    layers,
    set_screws_rad,
)
from delta_cad.dimensions.leads import (
    LeadDimensions,
    SensorLeadDimensions,
    lead_dimensions,
    sensor_lead_dimensions,
    tie_shortfall_mm,
)
from delta_cad.dimensions.panel import PanelDimensions, panel_dimensions, sleeve_mm
from delta_cad.dimensions.platform import (
    BaseDimensions,
    BenchDimensions,
    PlatformDimensions,
    base_dimensions,
    bench_dimensions,
    platform_dimensions,
)
from delta_cad.dimensions.rules import (
    BOTTOM,
    FOREARM,
    STOP_MARGIN_RAD,
    DimensionError,
    Reason,
    Way,
    all_reasons,
    another,
    larger,
    reasons_of,
    require,
    smaller,
    tenths_above,
)
from delta_cad.dimensions.sizes import bar_mm, growth, largest_force_N, plate_mm
from delta_cad.dimensions.tolerances import preload_range_N
from delta_cad.mechanism import UnreachableError, joint_angles
from delta_cad.mechanism.placement import LinkPlacement, chain_stand, chain_turn
from delta_cad.mechanism.workspace import Cube, CubeExtremes, cube_extremes

PRELOAD_N = 10.0  # of the shoulder's bearings, nearest to which a spring is chosen that is strong enough
PRELOAD_PER_N = 0.6  # its least over the tolerances, by the largest force: some 0.5 N along the shaft per N and weight
ARM_PLATE_MM = 6.0  # of an upper arm that is stiff enough, where the least sizes are
UP_AND_DOWN = 65  # heights of the handle in the middle, at which the range of an arm is looked at
CLEARANCE_MOST_MM = 2.4  # that nothing of a drive is made closer than: 2.44 from a sector's dowels to a bearing
NEXT_TO_MOTORS = {  # reasons that motors farther out do away with
    ("encoder_cheek", "leg"),
    ("encoder_board", "beside the neighbour's motor"),
    ("sensor_lead", "beside the neighbour's motor"),
}
HOME_DEG = 1e-6  # by which the arms differ where the machine is drawn: roundings

__all__ = ["DimensionError", "Dimensions", "Reason", "dimensions"]


@dataclass(frozen=True)
class Dimensions:
    """All dimensions of a design, and the motion and catalogue rows they were derived from.

    `set_screws_rad` are the directions of a pinion's set screws in its frame, from x towards z. `travel` are the
    extremes over all that the arms' stops leave free: of the cube, or of what a panel's bezel leaves around it.
    """

    design: Design
    extremes: CubeExtremes
    travel: CubeExtremes
    layers: Layers
    arm: ArmDimensions
    capstan: CapstanDimensions | None
    bracket: BracketDimensions
    shaft: ShaftDimensions
    forearm: ForearmDimensions
    platform: PlatformDimensions
    base: BaseDimensions
    bench: BenchDimensions | None
    panel: PanelDimensions | None
    leads: tuple[LeadDimensions, ...]
    sensor_lead: SensorLeadDimensions | None
    sleeve_mm: float
    motor: catalogue.Motor
    bearing: catalogue.Bearing
    preload: catalogue.WaveSpring | None
    encoder: catalogue.Encoder
    cable: catalogue.Cable
    tube: catalogue.Tube
    knob: catalogue.Knob
    foot: catalogue.Foot
    magnet: catalogue.Magnet
    set_screws_rad: tuple[float, float]

    @property
    def home_rad(self) -> float:
        """Shoulder angle of all three arms in the position in which the machine is exported."""
        return float(joint_angles(self.design.geometry, self.design.home_mm / MM_PER_M)[0])

    @property
    def outs_mm(self) -> tuple[float, float, float]:
        """How much farther out than chain 0 each chain stands."""
        out = gaps_of(self.design.geometry)[0].next_out_mm
        return 0.0, out, out

    def stand(self, i: int) -> np.ndarray:
        """(4, 4) frame of what stands on the base of chain i, see `chain_stand`."""
        return chain_stand(self.design.geometry, i)

    def turn(self, i: int) -> np.ndarray:
        """(4, 4) frame of what the platform carries of chain i, see `chain_turn`."""
        return chain_turn(self.design.geometry, i)

    @property
    def sensed_at_shoulder(self) -> bool:
        """Whether the shoulder carries an encoder's board and magnet; else the motors have encoders of their own."""
        return self.design.hardware.encoder_at != "motor"

    def is_printed(self, number: str) -> bool:
        """Decides whether a part, by its number, is printed."""
        return is_printed(self.design.hardware, number)

    def material_of(self, number: str) -> str:
        """Gives the id of the material of a part that may be printed."""
        return material_of(self.design.hardware, number)

    @property
    def board_screws_mm(self) -> list[tuple[float, float]]:
        """(x, z) of the encoder board's screws in the shoulder's frame, the board upright, its plug down; or none."""
        half_x, half_z = self.encoder.hole_spacing_width_mm / 2, self.encoder.hole_spacing_length_mm / 2
        return [(sx * half_x, sz * half_z) for sx in (-1, 1) for sz in (-1, 1) if self.sensed_at_shoulder]

    @property
    def board_spacer(self) -> catalogue.Spacer | None:
        """The catalogue's spacer under the encoder's board; None: one has to be turned."""
        screw = catalogue.screw(board_screw(self.encoder))
        wide = screw.clearance_hole_mm + 1.5, screw.clearance_hole_mm + BOARD_SPACER_WALLS_MM
        return catalogue.stock_spacer(screw.id, BOARD_STAND_OFF_MM, wide)

    @property
    def board_spacer_mm(self) -> tuple[float, float]:
        """Outside diameter and bore of the spacer under the encoder's board."""
        if (row := self.board_spacer) is not None:
            return row.outer_mm, row.inner_mm
        bore = catalogue.screw(board_screw(self.encoder)).clearance_hole_mm
        return bore + BOARD_SPACER_WALLS_MM, bore

    @property
    def encoder_head_circles_mm(self) -> list[Circle]:
        """Circles (x, z, radius) in the shoulder's frame, whose hull the encoder cheek's head is."""
        return [(0.0, 0.0, self.bracket.head_radius_mm), *((x, z, BOARD_EDGE_MM) for x, z in self.board_screws_mm)]

    @property
    def has_feet(self) -> bool:
        """Whether it has feet; else its plate lies flat on what it is screwed to."""
        return self.design.hardware.mounting in ("feet", "both")

    @property
    def is_screwed_down(self) -> bool:
        """Whether screws hold its base plate down, on what it is mounted on or on its bench plate; else it has feet."""
        return self.design.hardware.mounting != "feet"

    @property
    def stands_free(self) -> bool:
        """Whether only its weight holds it in its place."""
        return self.design.hardware.mounting in ("feet", "plate")

    @property
    def feet_mm(self) -> list[tuple[float, float]]:
        """(x, y) of what a machine stands on that stands free."""
        return self.base.feet_mm if self.bench is None else self.bench.pads_mm

    @property
    def floor_mm(self) -> float:
        """Height of the surface on which it is mounted over the shoulder axes; negative."""
        if self.bench is not None:
            return self.bench.ground_mm
        return self.base.top_mm - self.base.thickness_mm - (self.foot.height_mm if self.has_feet else 0.0)

    @property
    def height_mm(self) -> float:
        """Height from there to the knob's top, with the handle at the top of the cube."""
        cube, p = self.design.cube, self.platform
        knob = p.boss_diameter_mm / 2.0 + p.stem_length_mm + self.knob.height_mm
        return cube.bottom_height_mm + 2.0 * cube.half_side_mm + knob - self.floor_mm

    @property
    def stops_rad(self) -> tuple[float, float]:
        """Shoulder angles at which the stop pins are met."""
        return (
            self.travel.shoulder_min.value - STOP_MARGIN_RAD,
            self.travel.shoulder_max.value + STOP_MARGIN_RAD,
        )


def preload_spring(bearing: catalogue.Bearing, force_N: float = 0.0) -> catalogue.WaveSpring:
    """Chooses the wave spring that presses on a bearing's outer ring alone, nearest to the preload that is wanted.

    Args:
        bearing: Row of the catalogue.
        force_N: Largest force at the handle: weaker springs are left out, unless all are.

    Raises:
        DimensionError: The catalogue has none for the bearing's bore.
    """
    rows = [
        row
        for row in catalogue.wave_spring.rows.values()
        if row.housing_mm == bearing.outer_mm and row.inner_mm > bearing.inner_ring_outer_mm
    ]
    housings = sorted({row.housing_mm for row in catalogue.wave_spring.rows.values()})
    require(
        bool(rows),
        "shoulder",
        "preload",
        f"the catalogue has no wave spring for an outside diameter of {bearing.outer_mm:g} mm; for "
        f"{', '.join(f'{v:g}' for v in housings)} mm it has",
        *another("bearing"),
    )
    rows = rows or list(catalogue.wave_spring.rows.values())  # in a search of reasons
    least = PRELOAD_PER_N * force_N
    strong = [row for row in rows if preload_range_N(row)[0] >= least]
    return (
        min(strong, key=lambda row: abs(row.force_N - PRELOAD_N)) if strong else max(rows, key=lambda row: row.force_N)
    )


def dimensions(design: Design, inwards: bool = False) -> Dimensions:
    """Derives all dimensions of a design.

    Args:
        design: The design.
        inwards: Whether its motors stand as far in as they have room, rather than as far out as the outline lets them.

    Raises:
        UnreachableError: A point of the cube is out of reach.
        DimensionError: Parts cannot be given sound dimensions; it holds every reason that was found.
    """
    with all_reasons():
        extremes = cube_extremes(design.geometry, design.workspace, design.requirements.force_N)
        _require_home(design)
        travel = extremes if design.panel is None else _travel(design, design.panel.limit_mm, extremes)
        return _dimensions(design, extremes, travel, inwards)


def link_placement(d: Dimensions) -> LinkPlacement:
    """Gives the place of every link of a machine at a position of its handle."""
    f = d.forearm
    springs = (f.eyes_x_mm[0], -f.eye_z_mm), (f.eyes_x_mm[1], f.eye_z_mm)
    ratio = 1.0 if d.capstan is None else d.capstan.ratio
    return LinkPlacement(d.design.geometry, f.width_mm, d.bracket.motor_axis_mm, ratio, springs, f.eye_y_mm)


def _dimensions(design: Design, extremes: CubeExtremes, travel: CubeExtremes, inwards: bool) -> Dimensions:
    mechanism, hardware, gaps = design.mechanism, design.hardware, gaps_of(design.geometry)
    shoulder = (travel.shoulder_min.value, travel.shoulder_max.value)
    motor, bearing = catalogue.motor.chosen(hardware), catalogue.bearing.chosen(hardware)
    encoder, magnet = catalogue.encoder.chosen(hardware), catalogue.magnet.chosen(hardware)
    cable, tube = catalogue.cable.chosen(hardware), catalogue.tube.chosen(hardware)
    knob = catalogue.knob.chosen(hardware)
    run = rim = None
    grown = growth(design)
    arm_mm = max(hardware.arm_thickness_mm, plate_mm(ARM_PLATE_MM, growth(design, "upper_arm")))
    if hardware.drive == "capstan":
        run = cable_run(hardware.sector_radius_mm, hardware.capstan_ratio, shoulder, cable)
        clear = design.requirements.clearance_min_mm
        rim = rim_y_mm(run, cable.diameter_mm, arm_mm, mechanism.base_radius_mm, clear, gaps)
    preload = None if rim is None else preload_spring(bearing, largest_force_N(design.requirements))
    spring_mm = 0.0 if preload is None else preload.work_height_mm
    apart = design.requirements.clearance_min_mm + MESHES_MM
    stacked = partial(
        layers,
        arm_thickness_mm=arm_mm,
        rim_mm=rim,
        bearing=bearing,
        preload_mm=spring_mm,
        encoder=encoder,
        motor=motor,
        grown=growth(design, "motor_cheek"),
    )
    place = None
    if run is None or rim is None:
        stack = stacked(pinion_end_mm=0.0)
    else:
        place, at_motor = pinion_places(run, rim, cable.diameter_mm, motor, apart)
        turns_end = turns_end_mm(run, rim, cable.diameter_mm, motor)
        stack = stacked(pinion_end_mm=place.pinion_mm[1], turns_end_mm=turns_end)
        if stack.motor_face_mm - motor.shaft_length_mm > place.tips_mm:  # a shaft that does not reach so far
            place, stack = at_motor, stacked(pinion_end_mm=at_motor.pinion_mm[1], turns_end_mm=turns_end)
    shaft_mm = bearing.bore_mm if hardware.drive == "capstan" else motor.shaft_diameter_mm
    bar = bar_mm(CROSS_BAR_MM, grown)
    bar_bore = bar + 2 * BAR_GLUE_MM
    arm = arm_dimensions(mechanism.upper_arm_length_mm, shaft_mm, bar_bore, hardware.drive, stack, bearing, apart)
    required = design.requirements
    forearm = forearm_dimensions(
        length_mm=mechanism.forearm_length_mm,
        width_mm=mechanism.parallelogram_width_mm,
        ball_mm=hardware.ball_diameter_mm,
        boss_width_mm=stack.elbow_boss_mm[1] - stack.elbow_boss_mm[0],
        arm=arm,
        fold_rad=pi - travel.forearm_angle_max.value,
        tube=tube,
        force_N=required.force_N,
        lean_max_deg=required.lean_max_deg,
        clearance_mm=required.clearance_min_mm,
        bar_mm=bar,
        peak_N=largest_force_N(required),
        wrist_boss_mm=hardware.platform_thickness_mm,
        gaps=gaps,
        printed_eyes=is_printed(hardware, "rod_eye"),
    )
    behind = _behind_mm(gaps, mechanism.base_radius_mm + mechanism.upper_arm_length_mm)
    behind += gaps[0].sine / 2 * mechanism.parallelogram_width_mm + forearm.cup_radius_mm
    face = stack.motor_face_mm
    half_width = max(-stack.encoder_cheek_mm[0], stack.motor_cheek_mm[1])

    def bracket_on(capstan: CapstanDimensions | None, leg_least_mm: float) -> BracketDimensions:
        return bracket_dimensions(
            base_radius_mm=mechanism.base_radius_mm,
            shoulder_rad=shoulder,
            lowest_elbow_mm=travel.elbow_z_min.value * MM_PER_M,
            base_thickness_mm=hardware.base_plate_thickness_mm,
            half_width_mm=half_width,
            leg_mm=-stack.encoder_cheek_mm[0],
            arm=arm,
            capstan=capstan,
            bearing=bearing,
            motor=motor,
            clearance_mm=design.requirements.clearance_min_mm,
            leg_least_mm=leg_least_mm,
            gaps=gaps,
            printed=is_printed(hardware, "foot_block") or is_printed(hardware, "base_plate"),
        )

    def drive_at(run: CableRun | None, direction: float) -> tuple[CapstanDimensions | None, BracketDimensions]:
        capstan = None
        if run is not None and place is not None:
            capstan = capstan_dimensions(
                run=run,
                ratio=hardware.capstan_ratio,
                shoulder_rad=shoulder,
                layers=stack,
                cable=cable,
                motor=motor,
                stop_pin_mm=STOP_PIN_MM,
                slot_radius_mm=arm.flange_radius_mm + STOP_PIN_MM / 2 + 6.0,
                direction_rad=direction,
                place=place,
            )
        bracket = bracket_on(capstan, 0.0)
        while (shortfall := tie_shortfall_mm(design, stack, bracket, encoder)) > 0.0:
            bracket = bracket_on(capstan, shortfall - bracket.base_top_mm - bracket.foot_height_mm)
        if hardware.encoder_at != "motor":
            require_room_for_board(mechanism.base_radius_mm, bracket.motor_axis_mm, stack, motor, encoder, gaps)
        return capstan, bracket

    def has_room(direction: float) -> bool:
        """Whether what stands beside the neighbours' motors and pinions has room."""
        room = list[float]()

        def made() -> None:
            capstan, bracket = drive_at(run, direction)
            if capstan is not None:
                room.append(pinion_room_mm(capstan, bracket, stack, gaps))
            sensor_lead_dimensions(design, stack, bracket, encoder, motor)

        narrow = any(reason.key in NEXT_TO_MOTORS for reason in reasons_of(made))
        return not narrow and all(one >= apart for one in room)

    direction = 0.0
    if run is not None:
        most = sleeve_direction_rad(run, shoulder, arm, stack)
        direction = pinion_direction_rad(run, mechanism.base_radius_mm, behind, motor, face, most, gaps[0])
        direction = INMOST_RAD if inwards else direction
        if inwards or gaps != EVEN:
            direction = farther_out_rad(direction, has_room)
    capstan, bracket = drive_at(run, direction)
    screws = SET_SCREWS_RAD if capstan is None else _set_screws(design, key_rad(capstan, bracket, motor))
    shaft = shaft_dimensions(shaft_mm, hardware.drive, stack, bearing, encoder, magnet)
    require(
        required.clearance_min_mm <= CLEARANCE_MOST_MM,
        "assembly",
        "clearance",
        f"{required.clearance_min_mm:g} mm are asked; set screws, dowels and shafts keep {CLEARANCE_MOST_MM:g} mm off "
        "what moves beside them, whatever the lengths",
        smaller("requirements.clearance_min_mm"),
    )
    if capstan is None:  # no bearing's lip: as wide as the stub that turns in it asks for
        bracket = replace(bracket, passage_mm=max(bracket.passage_mm, tenths_above(shaft.head_diameter_mm + 2 * apart)))
    if capstan is None:
        at_shoulder = hardware.encoder_at != "motor"
        halves = encoder.hole_spacing_width_mm / 2, encoder.hole_spacing_length_mm / 2
        board = (*halves, BOARD_EDGE_MM) if at_shoulder else (0.0, 0.0, 0.0)
        require_room_for_boss(arm, bracket, shoulder, stack, board)
    motors_behind = _behind_mm(gaps, bracket.motor_axis_mm[0] + motor.diameter_mm / 2)
    motors_behind += gaps[0].sine * (face + motor.length_mm)
    platform = platform_dimensions(
        mechanism.platform_radius_mm,
        hardware.platform_thickness_mm,
        forearm,
        knob,
        growth(design, "platform"),
        grown,
    )
    if (panel := panel_dimensions(design, platform, forearm.cup_radius_mm)) is not None:
        platform = replace(platform, stem_length_mm=panel.stem_length_mm)
    base = base_dimensions(
        bracket, hardware.base_plate_thickness_mm, half_width, max(behind, motors_behind), gaps, design.azimuths_deg
    )
    foot = catalogue.foot.chosen(hardware)
    found = Dimensions(
        design=design,
        extremes=extremes,
        travel=travel,
        layers=stack,
        arm=arm,
        capstan=capstan,
        bracket=bracket,
        shaft=shaft,
        forearm=forearm,
        platform=platform,
        base=base,
        bench=None,
        panel=panel,
        leads=lead_dimensions(design, motor),
        sensor_lead=sensor_lead_dimensions(design, stack, bracket, encoder, motor),
        sleeve_mm=sleeve_mm(design, foot, base.mount_circle_mm, base.mount_spread_rad, base.mount_hole_mm),
        motor=motor,
        bearing=bearing,
        preload=preload,
        encoder=encoder,
        cable=cable,
        tube=tube,
        knob=knob,
        foot=foot,
        magnet=magnet,
        set_screws_rad=screws,
    )
    return replace(found, bench=bench_dimensions(found)) if hardware.mounting == "plate" else found


def _travel(design: Design, limit_mm: float, within: CubeExtremes) -> CubeExtremes:
    """Extremes over the cube that is larger than the design's by the limit on every side; `within`: over its own."""
    low, half = design.cube.bottom_height_mm - limit_mm, design.cube.half_side_mm + limit_mm
    wider = Cube(low / MM_PER_M, half / MM_PER_M, design.workspace.centre_x)
    try:
        return cube_extremes(design.geometry, wider, design.requirements.force_N)
    except UnreachableError as error:
        ways = smaller("panel.limit_mm"), larger(FOREARM), larger(BOTTOM)
        words = f"outside the cube by {limit_mm:g} mm, {error}"
        require(False, "bezel", "limit", words, *ways)
        return within  # in a search of reasons


def _require_home(design: Design) -> None:
    """Refuses a cube in which the three arms stand alike nowhere half-way up: cables are drawn at one angle."""
    first, side, _ = np.degrees(joint_angles(design.geometry, design.home_mm / MM_PER_M))
    require(
        abs(first - side) <= HOME_DEG,
        "assembly",
        "home",
        f"at the nearest place of the cube's middle level, x = {design.home_mm[0]:.4g} mm, arm 0 stands at {first:.2f} "
        f"and arms 1 and 2 at {side:.2f} deg; the machine is drawn where the three stand alike, inside the cube",
        Way(("cube.centre_x_mm",)),
        larger("cube.half_side_mm"),
    )


def _behind_mm(gaps: Sequence[Gap], out_mm: float) -> float:
    """How far what is so far out in chain 0's stand reaches behind the base in the stand of chain 1, in its plane."""
    return -gaps[0].cosine * (out_mm + gaps[0].next_out_mm)


def _set_screws(design: Design, key_rad: float) -> tuple[float, float]:
    """Directions of a pinion's set screws, of the turns that all three make: the pinion turns against the arm."""
    cube, up = design.workspace, np.zeros((UP_AND_DOWN, 3))
    up[:, 0] = cube.centre_x
    up[:, 2] = np.linspace(cube.bottom_height, cube.bottom_height + 2.0 * cube.half_side, UP_AND_DOWN)
    arm, ratio = joint_angles(design.geometry, up), design.hardware.capstan_ratio
    low, high = float(arm.min(axis=0).max()), float(arm.max(axis=0).min())
    require(
        low < high,
        "pinion",
        "set screws",
        "while the handle goes up and down in the cube's middle, no angle of the arm is common to the three chains, so "
        "that no pinion's set screws come to face their key in all of them",
    )
    if low >= high:  # in a search of reasons
        return SET_SCREWS_RAD
    return set_screws_rad(key_rad, (-ratio * high, -ratio * low))
