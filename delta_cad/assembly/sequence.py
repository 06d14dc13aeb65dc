"""The order in which a machine is put together: units on the bench, then the machine.

A step names what it brings in; the way to its seat was stated where the part is placed.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import ceil, degrees

from delta_cad import catalogue
from delta_cad.assembly.builder import DOWN, IN, OUT, AssemblyBuilder, SequenceWriter, straight, unit_of, whole_unit
from delta_cad.assembly.leads import lead_steps, sensor_lead_steps
from delta_cad.assembly.machine import Step, Unit
from delta_cad.assembly.panel import mounting_steps, panel_steps
from delta_cad.assembly.supplies import BAR_ADHESIVE
from delta_cad.dimensions.capstan import ROPE_FACTOR, SET_SCREW, TENSION_SCREW, CapstanDimensions, SET_TORQUE_N_m
from delta_cad.dimensions.forearm import TUBE_ADHESIVE
from delta_cad.dimensions.tolerances import END_TORQUE_N_m
from delta_cad.drive import drive_torque
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids.bought_parts import CORD_SLACK_MM
from delta_cad.solids.brackets import base_pin_mm
from delta_cad.solids.part import Supply

PRESS = "arbor press or vice with soft jaws"
PRIMED = "degreaser and primer"
SANDED = "sandpaper 240, acetone"
RUN_IN = 50  # full strokes after which a rope has settled; from memory: tension it until it stays
AS_ONE = (
    "Before the screws are tight, the shoulder's shaft goes through both bearings and the arm by hand, and out again."
)


def assembly_sequence(builder: AssemblyBuilder, supplies: Iterable[Supply]) -> tuple[Unit, ...]:
    """States how a machine is put together.

    Args:
        builder: With all its parts placed.
        supplies: What is bought beside them.

    Returns:
        The units in the order in which they are made, the machine last.
    """
    w, d = SequenceWriter(builder, supplies), builder.d
    made = [_arm, _motor_cheek, _encoder_cheek, _drive]
    if d.capstan is not None:
        made = [_pinion, _sector, *made]
        if d.sensed_at_shoulder:
            made.insert(-1, _shaft)
    units = [make(w, i) for make in made for i in CHAINS]
    units += [_rod(w, i, j) for i in CHAINS for j in SIDES]
    return (*units, _platform(w), _machine(w))


def _bars_bonded(w: SequenceWriter, first: str, bars: str, balls: str) -> list[Step]:
    """Steps that bond cross-bars in the bosses of a first part, then their balls."""
    retainer, f = catalogue.adhesive(BAR_ADHESIVE).description, w.d.forearm
    return [
        w.step(
            "Cross-bar" if len(w.named(bars)) == 1 else "Cross-bars",
            (
                f"Degrease bar and boss, prime both, wet the bar with {retainer} and turn it in.",
                "Set it so that both studs stand out equally far, and leave it until the compound is hard.",
            ),
            first,
            bars,
            tools=(PRIMED, "depth gauge"),
            supplies=("bar_adhesive",),
            checks=("Both shoulders are equally far from the boss, to 0.05 mm.",),
        ),
        w.step(
            "Balls on their studs",
            (f"Prime, wet the stud's pin with {retainer}, and push the ball on up to its shoulder.", "Wipe the ball."),
            balls,
            tools=(PRIMED, "calliper"),
            supplies=("bar_adhesive",),
            checks=(
                f"The balls' centres are {f.width_mm:.2f} mm apart: {f.width_mm + f.ball_diameter_mm:.2f} over both.",
            ),
        ),
    ]


def _arm(w: SequenceWriter, i: int) -> Unit:
    d, arm = w.d, f"upper_arm_{i}"
    steps = _bars_bonded(w, arm, f"cross_bar_{i}_elbow", f"joint_ball_{i}_?_elbow")
    if d.capstan is not None:
        steps.append(
            w.step(
                "Sector on the arm",
                ("Press both pins into the arm, then the sector on the pins until it lies flat.",),
                f"sector_dowel_{i}_?",
                whole_unit(f"sector {i}", OUT, arm),
                tools=(PRESS,),
                checks=("No light is seen between arm and sector; the shaft goes through both by hand.",),
            )
        )
        return unit_of(f"arm {i}", "Arm with its sector", *steps)
    out = f"{d.layers.arm_mm[0] - d.shaft.y_mm[0]:g} mm"
    magnet = ", then the magnet in the stub." if d.sensed_at_shoulder else "."
    steps.append(
        w.step(
            "Stub of the magnet",
            (f"Bond the stub in the arm's bore so that it stands out {out} on the encoder's side{magnet}",),
            f"shoulder_shaft_{i}",
            f"encoder_magnet_{i}",
            tools=(PRIMED, "depth gauge"),
            supplies=("bar_adhesive",),
            checks=(f"From the arm's face to the stub's end {out}: the gap before the sensor follows from it.",),
        )
    )
    return unit_of(f"arm {i}", "Arm", *steps)


def _sector(w: SequenceWriter, i: int) -> Unit:
    """The arm may lie before the carriage's pocket later."""
    step = w.step(
        "Carriage and tension screw in the sector",
        (
            "Lay the carriage into its pocket, from the side on which the arm will be, and screw the tension screw in "
            "by three turns.",
            "Leave it there: it is turned further when the cable is on.",
        ),
        f"sector_{i}",
        f"tension_carriage_{i}",
        f"tension_screw_{i}",
        tools=(f"hexagon key {catalogue.screw(TENSION_SCREW).socket_mm:g}",),
    )
    return unit_of(f"sector {i}", "Sector with its tension carriage", step)


def _pinion(w: SequenceWriter, i: int) -> Unit:
    step = w.step(
        "Set screws in the pinion",
        ("Screw both set screws into the collar until their tips stand just short of its bore.",),
        f"pinion_{i}",
        f"set_screw_{i}_?",
        tools=(f"hexagon key {catalogue.set_screw(SET_SCREW).socket_mm:g}",),
        checks=("A pin as thick as the motor's shaft passes the bore.",),
    )
    return unit_of(f"pinion {i}", "Pinion", step)


def _motor_cheek(w: SequenceWriter, i: int) -> Unit:
    d, cheek = w.d, f"motor_cheek_{i}"
    pressed = ["Press the stop pin in from inside until it stands out as drawn."]
    if d.capstan is not None:
        pressed.append("Push the bearing into its seat from inside, by its outer ring, up to the lip.")
    tools = PRESS, "sleeve that presses the outer ring alone"
    steps = [
        w.step("Motor's cheek", pressed, cheek, f"stop_pin_{i}_?", f"bearing_{i}_m", tools=tools),
        w.step(
            "Motor on its cheek",
            (
                "Put the motor's pilot into its bore from outside and screw it on from inside, one screw after the "
                "other in two rounds.",
                "Use no longer screws: they would end in the winding.",
            ),
            f"motor_{i}",
            f"motor_screw_{i}_*",
            checks=("The motor's face lies flat on the cheek; its shaft turns freely.",),
        ),
    ]
    if d.capstan is not None:
        off = d.layers.motor_cheek_mm[0] - d.capstan.pinion_y_mm[0]
        steps.append(
            w.step(
                "Pinion on the motor's shaft",
                (
                    "Push the pinion on the shaft from inside, its collar first, until its end stands "
                    f"{off:g} mm off the cheek's inner face.",
                    "The set screws are tightened in the finished drive, through the slot in the cheek's edge.",
                ),
                whole_unit(f"pinion {i}", IN, cheek),
                tools=("depth gauge",),
                checks=("The pinion turns with the motor and rubs nowhere.",),
            )
        )
    steps.append(
        w.step(
            "Foot block on the cheek",
            ("Press both pins into the cheek from inside, put the block on them, and screw it on from outside.",),
            f"cheek_dowel_{i}_m?",
            f"foot_block_{i}",
            f"cheek_screw_{i}_m?",
            tools=(PRESS,),
            checks=("The block's lower face and the cheek's are square: no light under a square.",),
        )
    )
    return unit_of(f"cheek {i}", "Motor's side of a drive", *steps)


def _encoder_cheek(w: SequenceWriter, i: int) -> Unit:
    """What lies in an encoder's cheek before it is put on."""
    cheek = f"encoder_cheek_{i}"
    if w.d.capstan is None:
        step = w.step("Encoder's cheek", ("The encoder's cheek is taken as it is: nothing lies in it.",), cheek)
    else:
        words = ("Lay the wave spring into the seat from inside, then push the bearing in by hand: it must slide.",)
        checks = ("The bearing springs back when it is pressed in.",)
        step = w.step("Bearing and spring", words, cheek, f"wave_spring_{i}", f"bearing_{i}_e", checks=checks)
    return unit_of(f"encoder cheek {i}", "Encoder's cheek", step)


def _shaft(w: SequenceWriter, i: int) -> Unit:
    step = w.step(
        "Magnet in the shaft's head",
        ("Degrease both, wet the magnet's rim with retaining compound, push it in to the bottom, wipe it.",),
        f"shoulder_shaft_{i}",
        f"encoder_magnet_{i}",
        tools=(PRIMED, "a pin that does not stick to the magnet"),
        supplies=("bar_adhesive",),
        checks=("The magnet's face is even with the shaft's, or below it.",),
    )
    return unit_of(f"shaft {i}", "Shoulder shaft with its magnet", step)


def _drive(w: SequenceWriter, i: int) -> Unit:
    """Both cheeks, the arm between them, cable and encoder."""
    d, block = w.d, f"foot_block_{i}"
    between = whole_unit(f"cheek {i}", IN, block), whole_unit(f"arm {i}", IN, block)
    if d.capstan is None:
        first = w.step(
            "Arm on the motor's shaft",
            ("Push the arm on the motor's shaft from inside, 1 mm off the cheek, and clamp it.",),
            *between,
            f"shoulder_clamp_{i}",
            tools=("feeler gauge 1 mm",),
            checks=("The arm turns from stop to stop and rubs nowhere.",),
        )
        steps = [first, _encoder_cheek_on(w, i)]
    else:
        first = w.step(
            "Arm beside the motor's cheek",
            (
                "Lay the motor's side down, its inner face up, and lay the arm in, the stop pin in the sector's "
                "slot, the sector's collar on the bearing's inner ring.",
                "Turn the arm a little against the pinion: the two nowhere touch.",
            ),
            *between,
        )
        c = d.capstan
        steps = [first, _anchor(w, c, i), _encoder_cheek_on(w, i), _shaft_in(w, i), _cable(w, c, i), _tension(w, c, i)]
    if d.sensed_at_shoulder:
        steps += [_board(w, i), *sensor_lead_steps(w, i)]
    return unit_of(f"drive {i}", "Drive", *steps)


def _encoder_cheek_on(w: SequenceWriter, i: int) -> Step:
    words = ["Press both pins into the block, put the cheek on them and screw it on."]
    if w.d.capstan is not None:
        words.append("Its bearing goes over the arm's collar: the inner ring stands on it.")
    return w.step(
        "Encoder's cheek",
        words,
        f"cheek_dowel_{i}_e?",
        whole_unit(f"encoder cheek {i}", IN, f"foot_block_{i}"),
        f"cheek_screw_{i}_e?",
        tools=(PRESS,),
        checks=(AS_ONE,) if w.d.capstan is not None else (),
    )


def _shaft_in(w: SequenceWriter, i: int) -> Step:
    d, shaft = w.d, f"shoulder_shaft_{i}"
    held = f"a spanner {d.shaft.flats_mm:g}" if d.shaft.flats_mm else "soft jaws"
    preload = "" if d.preload is None else f" The spring presses with {d.preload.force_N:.0f} N."
    return w.step(
        "Shoulder shaft",
        (
            "Push the shaft in from the encoder's side through bearing, arm, sector and bearing.",
            f"Put washer and screw in from the motor's side and hold the shaft's head by {held}.",
        ),
        whole_unit(f"shaft {i}", IN, f"foot_block_{i}") if d.sensed_at_shoulder else shaft,
        f"shoulder_washer_{i}",
        f"shoulder_screw_{i}",
        torque_N_m=END_TORQUE_N_m[d.shaft.end_screw],
        tools=(held, "thread lock of medium strength"),
        checks=(f"The arm turns freely from stop to stop, without play along or across its axis.{preload}",),
    )


def _anchor(w: SequenceWriter, c: CapstanDimensions, i: int) -> Step:
    slack, tolerance = c.bench_mm
    pull = 10 * ceil(w.d.cable.breaking_load_N / ROPE_FACTOR / 10)
    return w.step(
        "Cable in its anchor",
        (
            f"On the bench, crimp both sleeves on the cable, {slack:.1f} mm +-{tolerance:g} mm between their backs, "
            f"and pull each by {pull} N, what the cable may bear: it must not move.",
            "Lay the first sleeve behind the anchor's wall at the sector's inner end, the cable through its slot and "
            "round the nose, and let the rest hang: the encoder's cheek will cover the anchor.",
        ),
        f"crimp_sleeve_{i}_0",
        tools=("crimping tool", f"spring balance {pull} N"),
    )


def _cable(w: SequenceWriter, c: CapstanDimensions, i: int) -> Step:
    pieces = ("inner_end", "inner", "strand_inner", "turns", "strand_outer", "outer", "outer_end")
    return w.step(
        "Cable",
        (
            "Lay the cable from the anchor's nose on to the rim.",
            f"Go from the rim to the pinion and lay {c.run.turns:g} turns into its groove, from the inner end towards "
            "the outer one, no turn over another.",
            "Go back to the rim, lay the cable along its other half, and the second sleeve into the carriage.",
        ),
        f"crimp_sleeve_{i}_1",
        w.laid(*(f"capstan_cable_{i}_{piece}" for piece in pieces)),
        tools=("tweezers with smooth jaws",),
        checks=("Either strand leaves the groove where it is nearest to its own half of the rim; none crosses.",),
        unseen=_before_cable(w, i),
    )


def _tension(w: SequenceWriter, c: CapstanDimensions, i: int) -> Step:
    d = w.d
    force = drive_torque(d.design).cable_pretension_N
    assert force is not None
    row = catalogue.screw(TENSION_SCREW)
    if d.cable.axial_stiffness_N is None:
        turned = "by quarter turns until the strands are taut"
    else:
        stretch = force / d.cable.axial_stiffness_N * c.cable_length_mm
        turned = f"by {stretch / row.pitch_mm:.1f} turns more, which stretch the settled cable by {stretch:.2f} mm"
    key, grubs = catalogue.set_screw(SET_SCREW), w.named(f"set_screw_{i}_?")
    return w.step(
        "Tension of the cable, set screws",
        (
            f"Hold the arm and turn the tension screw until the motor's shaft no longer turns by hand, then {turned}: "
            f"{force:.1f} N in either strand.",
            f"Move the arm from stop to stop {RUN_IN} times; a rope settles. Slacken the screw, and tension it again.",
            "Turn the arm until a set screw faces the slot in the motor cheek's edge and tighten it; then the other.",
        ),
        tightened=grubs,
        torque_N_m=SET_TORQUE_N_m,
        supplies=("pinion_key",),
        tools=(f"hexagon key {row.socket_mm:g}", f"hexagon key {key.socket_mm:g}, long"),
        checks=(
            "With the arm on a stop and the motor at its largest torque, the pinion does not turn under its cable.",
            "The screw's head still stands on its lug, and the carriage has travel left.",
        ),
        shown=(f"tension_screw_{i}", *grubs),
        unseen=_before_cable(w, i),
    )


def _before_cable(w: SequenceWriter, i: int) -> tuple[str, ...]:
    """What hides a cable when it is seen from the encoder's side."""
    hiding = ("encoder_cheek_{}", "wave_spring_{}", "upper_arm_{}", "bearing_{}_e", "cross_bar_{}_elbow")
    hiding += ("joint_ball_{}_?_elbow", "cheek_screw_{}_e?", "cheek_dowel_{}_e?")
    return w.named(*(pattern.format(i) for pattern in hiding))


def _board(w: SequenceWriter, i: int) -> Step:
    d = w.d
    low, high = (degrees(stop) for stop in d.stops_rad)
    counts = (high - low) / 360.0 * d.encoder.counts_per_turn
    return w.step(
        "Encoder",
        (
            "Put the board on its spacers, its sensor over the magnet, and screw it on.",
            f"Zero: hold the arm gently on its lower stop and note the reading; there the arm's angle is {low:.2f} deg "
            "from level, positive upwards. The reading at 0 deg follows; it is stored for this shoulder.",
            f"Then hold it on the upper stop, at {high:.2f} deg: between both lie {high - low:.2f} deg, {counts:.0f} "
            f"of {d.encoder.counts_per_turn} counts.",
            "If the reading falls while the arm rises, the sensor's sense is stored as negative.",
        ),
        f"board_spacer_{i}_?",
        f"encoder_board_{i}",
        f"board_screw_{i}_?",
        tools=("feeler gauge of plastic", "the controller, which shows the reading"),
        checks=(
            f"Between magnet and sensor {d.encoder.air_gap_min_mm:g} to {d.encoder.air_gap_max_mm:g} mm.",
            f"The travel told by the encoder is right to {max(0.5, 720.0 / d.encoder.counts_per_turn):g} deg.",
        ),
    )


def _rod(w: SequenceWriter, i: int, j: int) -> Unit:
    """A rod in its jig."""
    f, glue = w.d.forearm, catalogue.adhesive(TUBE_ADHESIVE).description
    rod, bonds = f"{i}_{j}", ("tube_adhesive",)
    return unit_of(
        f"rod {i}{j}",
        "Rod",
        w.step(
            "Rod's end, tube and eyes",
            (
                f"Sand and wipe the spigot and the tube's bore, wet both with {glue}, and push the tube on to its "
                "shoulder with a turn.",
                f"Slide both eyes on, over wet rings, {f.eyes_x_mm[0]:.1f} and {f.eyes_x_mm[1]:.1f} mm from the middle "
                "of the cup's seat, the first aside away from the arm, the second towards it.",
            ),
            f"rod_cup_{rod}_elbow",
            f"rod_tube_{rod}",
            f"rod_eye_{rod}_?",
            tools=(SANDED, "rod jig"),
            supplies=bonds,
        ),
        w.step(
            "Rod's other end, in the jig",
            (
                "Wet spigot and bore likewise and push the second end in.",
                f"Lay the rod into the jig: its two balls hold the seats {f.length_mm:.3f} mm apart, both cups open to "
                "the same side. All six rods harden in the same jig.",
            ),
            f"rod_cup_{rod}_wrist",
            tools=(SANDED, "rod jig"),
            supplies=bonds,
            checks=("All six rods are equally long to 0.02 mm: hang them in turn on the same two balls.",),
        ),
        w.step(
            "Shells in their cups",
            (
                f"Sand and wipe, wet with {glue}, push each shell in to its rim.",
                "When it is hard, lap the seat with a ball and paste until the gauge passes, and wash the paste out.",
            ),
            f"cup_shell_{rod}_*",
            tools=(SANDED, "ball and lapping paste", "gauge of the seat"),
            supplies=bonds,
            checks=("A ball turns in its seat without a catch and does not rock.",),
        ),
    )


def _platform(w: SequenceWriter) -> Unit:
    handle = w.step(
        "Handle",
        ("Screw the stem into the platform, then the knob on the stem; hold the stem by its flats.",),
        "handle_stem",
        "knob",
        tools=("spanner on the stem's flats", "thread lock of medium strength"),
        checks=("The stem stands on the platform without a gap.",),
    )
    bonded = _bars_bonded(w, "platform", "cross_bar_?_wrist", "joint_ball_?_?_wrist")
    return unit_of("platform", "Platform with its handle", *bonded, handle)


def _machine(w: SequenceWriter) -> Unit:
    d = w.d
    if d.foot.stud_length_mm is None:
        turned = "Turn the machine on its back, on something soft, and screw the feet on."
    else:
        turned = "Turn the machine on its back, on something soft, and screw the feet in by hand."
    steps = [
        w.step(
            "Base plate",
            ("Lay the plate on two blocks, high enough to reach under it, its counterbores below.",),
            "base_plate",
            checks=("Its upper side is clean and without burrs.",),
        ),
        *(_drive_on(w, i) for i in CHAINS),
    ]
    if d.has_feet:
        checks = ("The machine stands on a flat table and does not rock.",)
        steps.append(w.step("Feet", (turned,), "foot_?", "foot_screw_?", checks=checks))
    steps += [
        w.step(
            "Platform over the arms",
            (
                "Hold the platform over the arms at the height of the cube's middle, "
                f"{d.design.cube.bottom_height_mm + d.design.cube.half_side_mm:.0f} mm above the shoulders' axes, on a "
                "block or by a clamp on the knob.",
                "Wrist 0 is over arm 0.",
            ),
            whole_unit("platform", DOWN, "base_plate"),
            tools=("a block or a stand that holds the platform",),
        ),
        *(_pair(w, i) for i in CHAINS),
        *mounting_steps(w),
        *lead_steps(w),
        *panel_steps(w),
        _last(w),
    ]
    return unit_of("machine", "The machine", *steps)


def _drive_on(w: SequenceWriter, i: int) -> Step:
    under = w.d.base.thickness_mm - base_pin_mm(w.d)[0]
    return w.step(
        f"Drive {i} on the plate",
        (
            "Slide the drive in on the plate from outside, along its own radius: its neighbour's head reaches "
            "over it, so that it cannot come down from above.",
            f"Tap both pins through the plate into the foot block from below, until they stand {under:.1f} mm "
            "deep in the plate, and screw it down from below.",
        ),
        whole_unit(f"drive {i}", straight(-1.0, 0.0, 0.0), f"foot_block_{i}"),
        f"base_dowel_{i}_?",
        f"base_screw_{i}_?",
        tools=("drift 3 mm and a light hammer", "feeler gauge 0.05 mm"),
        checks=("No light is seen under the foot block.",),
    )


def _pair(w: SequenceWriter, i: int) -> Step:
    """A pair of rods hung on its balls and held by its springs."""
    f = w.d.forearm
    return w.step(
        f"Rods of chain {i}",
        (
            "Put a drop of grease in each cup and press both rods on their balls from outside, the first eye at the "
            "elbow.",
            f"Draw a cord through each spring, hook both springs into their eyes, {f.between_eyes_mm:.1f} mm apart, "
            f"and knot the cord in both eyes with {CORD_SLACK_MM:g} mm of slack.",
        ),
        *(whole_unit(f"rod {i}{j}", OUT if j else IN, f"rod_tube_{i}_{j}") for j in SIDES),
        w.laid(f"rod_spring_{i}_?"),
        tools=("spring hook",),
        supplies=("joint_grease", "rod_cord"),
        checks=(f"Each spring pulls {f.joint.spring_N:.1f} N; either rod, pushed off its ball by hand, snaps back.",),
    )


def _last(w: SequenceWriter) -> Step:
    words = ["Connect motors and sensors; let all wires hang free of what moves."]
    if w.d.capstan is not None:
        words.append(
            "Keep the cut key and the long one with the machine: they reach the motors' and the pinions' screws when a "
            "motor is exchanged, the rest of the machine as it stands."
        )
    return w.step(
        "The whole machine",
        words,
        supplies=("motor_key", "pinion_key"),
        checks=(
            "The handle goes to every corner of the cube without a catch.",
            "At each shoulder the angle shown is that of the drawing where the handle stands in the cube's middle: "
            f"{degrees(w.d.home_rad):.2f} deg, all three within 0.5 deg.",
        ),
    )
