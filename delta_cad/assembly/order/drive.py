"""The order in which a drive is put together: both cheeks, the arm between them, cable and encoder."""

from __future__ import annotations

from math import ceil, cos, degrees, sin

from delta_cad import catalogue
from delta_cad.assembly.leads import sensor_lead_steps
from delta_cad.assembly.order.record import Bring, Leg, Step, Unit
from delta_cad.assembly.order.shoulder import DRIVEN, IN, OUT, PRESS, named
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.cable.rim_ends import SLEEVE_OVER_MM
from delta_cad.dimensions.capstan import (
    ROPE_FACTOR,
    SET_SCREW,
    TENSION_SCREW,
    CapstanDimensions,
    SET_TORQUE_N_m,
)
from delta_cad.dimensions.tolerances import END_TORQUE_N_m
from delta_cad.drive import drive_torque
from delta_cad.interference.ferrule_insertion import second_way_rad

AS_ONE = (
    "Before the screws are tight, the shoulder's shaft goes through both bearings and the arm by hand, and out again."
)
RUN_IN = 50  # full strokes after which a rope has settled; from memory: tension it until it stays


def drive_unit(d: Dimensions, names: tuple[str, ...], i: int) -> Unit:
    """States how a drive is put together."""
    block = f"foot_block_{i}"
    steps: list[Step] = []
    if d.capstan is None:
        clamp = f"shoulder_clamp_{i}"
        steps.append(
            Step(
                "Arm on the motor's shaft",
                ("Push the arm on the motor's shaft from inside, 1 mm off the cheek, and clamp it.",),
                (
                    Bring((), IN, block, (f"cheek {i}",)),
                    Bring((), IN, block, (f"arm {i}",)),
                    Bring((clamp,), DRIVEN),
                ),
                (clamp,),
                tools=("feeler gauge 1 mm",),
                checks=("The arm turns from stop to stop and rubs nowhere.",),
            )
        )
    else:
        steps.append(
            Step(
                "Arm beside the motor's cheek",
                (
                    "Lay the motor's side down, its inner face up, and lay the arm in, the stop pin in the sector's "
                    "slot, the sector's collar on the bearing's inner ring.",
                    "Turn the arm a little against the pinion: the two nowhere touch.",
                ),
                (
                    Bring((), IN, block, (f"cheek {i}",)),
                    Bring((), IN, block, (f"arm {i}",)),
                ),
            )
        )
    if d.capstan is not None:
        steps.append(_anchor(d, d.capstan, i))
    steps.append(_encoder_cheek(d, names, i, block))
    if d.capstan is not None:
        steps += [_shaft(d, i, block), _cable(d, d.capstan, names, i), _tension(d, d.capstan, names, i)]
    if d.sensed_at_shoulder:
        steps += [_board(d, names, i, block), *sensor_lead_steps(d, i)]
    return Unit(f"drive {i}", "drive", "Drive", tuple(steps))


def _encoder_cheek(d: Dimensions, names: tuple[str, ...], i: int, block: str) -> Step:
    pins, screws = named(names, f"cheek_dowel_{i}_e"), named(names, f"cheek_screw_{i}_e")
    words = ["Press both pins into the block, put the cheek on them and screw it on."]
    if d.capstan is not None:
        words.append("Its bearing goes over the arm's collar: the inner ring stands on it.")
    return Step(
        "Encoder's cheek",
        tuple(words),
        (
            *(Bring((pin,), DRIVEN) for pin in pins),
            Bring((), IN, block, (f"encoder cheek {i}",)),
            *(Bring((screw,), DRIVEN) for screw in screws),
        ),
        screws,
        tools=(PRESS,),
        checks=(AS_ONE,) if d.capstan is not None else (),
    )


def encoder_cheek_unit(d: Dimensions, names: tuple[str, ...], i: int) -> Unit:
    """States what lies in an encoder's cheek before it is put on."""
    del names
    cheek, brings = f"encoder_cheek_{i}", [Bring((f"encoder_cheek_{i}",))]
    step = Step("Encoder's cheek", ("The encoder's cheek is taken as it is: nothing lies in it.",), tuple(brings))
    if d.capstan is not None:
        brings += [Bring((f"wave_spring_{i}",), OUT, cheek), Bring((f"bearing_{i}_e",), OUT, cheek)]
        words = ("Lay the wave spring into the seat from inside, then push the bearing in by hand: it must slide.",)
        checks = ("The bearing springs back when it is pressed in.",)
        step = Step("Bearing and spring", words, tuple(brings), checks=checks)
    return Unit(f"encoder cheek {i}", "encoder cheek", "Encoder's cheek", (step,))


def _shaft(d: Dimensions, i: int, block: str) -> Step:
    shaft, screw = f"shoulder_shaft_{i}", f"shoulder_screw_{i}"
    held = f"a spanner {d.shaft.flats_mm:g}" if d.shaft.flats_mm else "soft jaws"
    words = [
        "Push the shaft in from the encoder's side through bearing, arm, sector and bearing.",
        f"Put washer and screw in from the motor's side and hold the shaft's head by {held}.",
    ]
    brings = [Bring((shaft,), IN, block)]
    if d.sensed_at_shoulder:
        brings = [Bring((), IN, block, (f"shaft {i}",))]
    preload = "" if d.preload is None else f" The spring presses with {d.preload.force_N:.0f} N."
    return Step(
        "Shoulder shaft",
        tuple(words),
        (*brings, Bring((f"shoulder_washer_{i}",), OUT, block), Bring((screw,), DRIVEN)),
        (screw,),
        END_TORQUE_N_m[d.shaft.end_screw],
        tools=(held, "thread lock of medium strength"),
        checks=(f"The arm turns freely from stop to stop, without play along or across its axis.{preload}",),
    )


def shaft_unit(d: Dimensions, names: tuple[str, ...], i: int) -> Unit:
    """States how the magnet comes into the shaft's head."""
    del d, names
    shaft = f"shoulder_shaft_{i}"
    step = Step(
        "Magnet in the shaft's head",
        ("Degrease both, wet the magnet's rim with retaining compound, push it in to the bottom, wipe it.",),
        (Bring((shaft,)), Bring((f"encoder_magnet_{i}",), IN, shaft)),
        tools=("degreaser and primer", "a pin that does not stick to the magnet"),
        supplies=("bar_adhesive",),
        checks=("The magnet's face is even with the shaft's, or below it.",),
    )
    return Unit(f"shaft {i}", "shaft", "Shoulder shaft with its magnet", (step,))


def _anchor(d: Dimensions, c: CapstanDimensions, i: int) -> Step:
    slack, tolerance = c.bench_mm
    pull = 10 * ceil(d.cable.breaking_load_N / ROPE_FACTOR / 10)
    return Step(
        "Cable in its anchor",
        (
            f"On the bench, crimp both sleeves on the cable, {slack:.1f} mm +-{tolerance:g} mm between their backs, "
            f"and pull each by {pull} N, what the cable may bear: it must not move.",
            "Lay the first sleeve behind the anchor's wall at the sector's inner end, the cable through its slot and "
            "round the nose, and let the rest hang: the encoder's cheek will cover the anchor.",
        ),
        (Bring((f"crimp_sleeve_{i}_0",), IN, f"upper_arm_{i}"),),
        tools=("crimping tool", f"spring balance {pull} N"),
    )


def _over(d: Dimensions, c: CapstanDimensions) -> tuple[Leg, Leg]:
    """The second sleeve's way: from outside over its carriage, beside the arm and the foot block, then into it."""
    way = second_way_rad(d, c)
    return Leg((-cos(way), 0.0, -sin(way))), Leg((0.0, 1.0, 0.0), SLEEVE_OVER_MM)


def _cable(d: Dimensions, c: CapstanDimensions, names: tuple[str, ...], i: int) -> Step:
    name = f"capstan_cable_{i}"
    pieces = ("inner_end", "inner", "strand_inner", "turns", "strand_outer", "outer", "outer_end")
    return Step(
        "Cable",
        (
            "Lay the cable from the anchor's nose on to the rim.",
            f"Go from the rim to the pinion and lay {c.run.turns:g} turns into its groove, from the inner end towards "
            "the outer one, no turn over another.",
            "Go back to the rim, lay the cable along its other half, and the second sleeve into the carriage.",
        ),
        (
            Bring((f"crimp_sleeve_{i}_1",), _over(d, c), f"tension_carriage_{i}"),
            Bring(tuple(f"{name}_{piece}" for piece in pieces), is_laid=True),
        ),
        tools=("tweezers with smooth jaws",),
        checks=("Either strand leaves the groove where it is nearest to its own half of the rim; none crosses.",),
        unseen=_before_cable(names, i),
    )


def _tension(d: Dimensions, c: CapstanDimensions, names: tuple[str, ...], i: int) -> Step:
    force = drive_torque(d.design).cable_pretension_N
    assert force is not None
    row = catalogue.screw(TENSION_SCREW)
    if d.cable.axial_stiffness_N is None:
        turned = "by quarter turns until the strands are taut"
    else:
        stretch = force / d.cable.axial_stiffness_N * c.cable_length_mm
        turned = f"by {stretch / row.pitch_mm:.1f} turns more, which stretch the settled cable by {stretch:.2f} mm"
    key = catalogue.set_screw(SET_SCREW)
    return Step(
        "Tension of the cable, set screws",
        (
            f"Hold the arm and turn the tension screw until the motor's shaft no longer turns by hand, then {turned}: "
            f"{force:.1f} N in either strand.",
            f"Move the arm from stop to stop {RUN_IN} times; a rope settles. Slacken the screw, and tension it again.",
            "Turn the arm until a set screw faces the slot in the motor cheek's edge and tighten it; then the other.",
        ),
        tightened=named(names, f"set_screw_{i}_"),
        torque_N_m=SET_TORQUE_N_m,
        supplies=("pinion_key",),
        tools=(f"hexagon key {row.socket_mm:g}", f"hexagon key {key.socket_mm:g}, long"),
        checks=(
            "With the arm on a stop and the motor at its largest torque, the pinion does not turn under its cable.",
            "The screw's head still stands on its lug, and the carriage has travel left.",
        ),
        shown=(f"tension_screw_{i}", *named(names, f"set_screw_{i}_")),
        unseen=_before_cable(names, i),
    )


def _before_cable(names: tuple[str, ...], i: int) -> tuple[str, ...]:
    """What hides a cable when it is seen from the encoder's side."""
    return (
        *(f"{part}_{i}" for part in ("encoder_cheek", "wave_spring", "upper_arm")),
        *(f"{part}_{i}{end}" for part, end in (("bearing", "_e"), ("cross_bar", "_elbow"))),
        *(name for name in named(names, f"joint_ball_{i}_") if name.endswith("_elbow")),
        *named(names, f"cheek_screw_{i}_e"),
        *named(names, f"cheek_dowel_{i}_e"),
    )


def _board(d: Dimensions, names: tuple[str, ...], i: int, block: str) -> Step:
    spacers, screws = named(names, f"board_spacer_{i}_"), named(names, f"board_screw_{i}_")
    low, high = (degrees(stop) for stop in d.stops_rad)
    counts = (high - low) / 360.0 * d.encoder.counts_per_turn
    return Step(
        "Encoder",
        (
            "Put the board on its spacers, its sensor over the magnet, and screw it on.",
            f"Zero: hold the arm gently on its lower stop and note the reading; there the arm's angle is {low:.2f} deg "
            "from level, positive upwards. The reading at 0 deg follows; it is stored for this shoulder.",
            f"Then hold it on the upper stop, at {high:.2f} deg: between both lie {high - low:.2f} deg, {counts:.0f} "
            f"of {d.encoder.counts_per_turn} counts.",
            "If the reading falls while the arm rises, the sensor's sense is stored as negative.",
        ),
        (
            *(Bring((spacer,), IN, block) for spacer in spacers),
            Bring((f"encoder_board_{i}",), IN, block),
            *(Bring((screw,), DRIVEN) for screw in screws),
        ),
        screws,
        tools=("feeler gauge of plastic", "the controller, which shows the reading"),
        checks=(
            f"Between magnet and sensor {d.encoder.air_gap_min_mm:g} to {d.encoder.air_gap_max_mm:g} mm.",
            f"The travel told by the encoder is right to {max(0.5, 720.0 / d.encoder.counts_per_turn):g} deg.",
        ),
    )
