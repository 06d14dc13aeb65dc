"""The order of what is put together on the bench: arm with sector, motor's cheek with motor, pinion."""

from __future__ import annotations

from delta_cad import catalogue
from delta_cad.assembly.order.record import Bring, Leg, Step, Unit
from delta_cad.assembly.supplies import BAR_ADHESIVE
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import SET_SCREW, TENSION_SCREW
from delta_cad.mechanism.placement import SIDES

IN, OUT = (Leg((0.0, 1.0, 0.0)),), (Leg((0.0, -1.0, 0.0)),)
"""Along the shoulder's axis, towards the motor and away from it."""
DRIVEN = (Leg((0.0, 0.0, -1.0)),)
"""A screw or a pin along its own axis."""
PRESS = "arbor press or vice with soft jaws"


def named(names: tuple[str, ...], start: str) -> tuple[str, ...]:
    """Gives the names that begin so."""
    return tuple(name for name in names if name.startswith(start))


def bar_bonded(d: Dimensions, bars: tuple[str, ...], balls: tuple[tuple[str, str, int], ...]) -> list[Step]:
    """Gives the steps that bond cross-bars in their bosses, then their balls: (ball, bar, side) each."""
    retainer = catalogue.adhesive(BAR_ADHESIVE).description
    f = d.forearm
    return [
        Step(
            "Cross-bar" if len(bars) == 1 else "Cross-bars",
            (
                f"Degrease bar and boss, prime both, wet the bar with {retainer} and turn it in.",
                "Set it so that both studs stand out equally far, and leave it until the compound is hard.",
            ),
            tuple(Bring((bar,), OUT) for bar in bars),
            tools=("degreaser and primer", "depth gauge"),
            supplies=("bar_adhesive",),
            checks=("Both shoulders are equally far from the boss, to 0.05 mm.",),
        ),
        Step(
            "Balls on their studs",
            (f"Prime, wet the stud's pin with {retainer}, and push the ball on up to its shoulder.", "Wipe the ball."),
            tuple(Bring((ball,), IN if side == 0 else OUT, bar) for ball, bar, side in balls),
            tools=("degreaser and primer", "calliper"),
            supplies=("bar_adhesive",),
            checks=(
                f"The balls' centres are {f.width_mm:.2f} mm apart: {f.width_mm + f.ball_diameter_mm:.2f} over both.",
            ),
        ),
    ]


def arm_unit(d: Dimensions, names: tuple[str, ...], i: int) -> Unit:
    """States how an arm is put together with its cross-bar and its sector."""
    arm, bar = f"upper_arm_{i}", f"cross_bar_{i}_elbow"
    balls = tuple((f"joint_ball_{i}_{j}_elbow", bar, j) for j in SIDES)
    bonded = bar_bonded(d, (bar,), balls)
    first = bonded[0]
    steps = [
        Step(
            first.title,
            first.words,
            (Bring((arm,)), *first.brings),
            (),
            None,
            first.tools,
            first.supplies,
            first.checks,
        )
    ]
    steps.append(bonded[1])
    if d.capstan is None:
        out = f"{d.layers.arm_mm[0] - d.shaft.y_mm[0]:g} mm"
        stub = [f"shoulder_shaft_{i}", *(f"encoder_magnet_{i}" for _ in range(d.sensed_at_shoulder))]
        steps.append(
            Step(
                "Stub of the magnet",
                (
                    f"Bond the stub in the arm's bore so that it stands out {out} on the encoder's side"
                    + (", then the magnet in the stub." if d.sensed_at_shoulder else "."),
                ),
                tuple(Bring((one,), IN, arm) for one in stub),
                tools=("degreaser and primer", "depth gauge"),
                supplies=("bar_adhesive",),
                checks=(f"From the arm's face to the stub's end {out}: the gap before the sensor follows from it.",),
            )
        )
        return Unit(f"arm {i}", "arm", "Arm", tuple(steps))
    steps += [
        Step(
            "Sector on the arm",
            ("Press both pins into the arm, then the sector on the pins until it lies flat.",),
            (
                *(Bring((pin,), DRIVEN) for pin in named(names, f"sector_dowel_{i}_")),
                Bring((), OUT, arm, (f"sector {i}",)),
            ),
            tools=(PRESS,),
            checks=("No light is seen between arm and sector; the shaft goes through both by hand.",),
        ),
    ]
    return Unit(f"arm {i}", "arm", "Arm with its sector", tuple(steps))


def sector_unit(d: Dimensions, names: tuple[str, ...], i: int) -> Unit:
    """States how a sector gets the carriage that tensions its cable: the arm may lie before its pocket later."""
    del d, names
    sector = f"sector_{i}"
    step = Step(
        "Carriage and tension screw in the sector",
        (
            "Lay the carriage into its pocket, from the side on which the arm will be, and screw the tension screw in "
            "by three turns.",
            "Leave it there: it is turned further when the cable is on.",
        ),
        (Bring((sector,)), Bring((f"tension_carriage_{i}",), IN, sector), Bring((f"tension_screw_{i}",), DRIVEN)),
        tools=(f"hexagon key {catalogue.screw(TENSION_SCREW).socket_mm:g}",),
    )
    return Unit(f"sector {i}", "sector", "Sector with its tension carriage", (step,))


def cheek_unit(d: Dimensions, names: tuple[str, ...], i: int) -> Unit:
    """States how a motor's cheek is put together with its motor."""
    cheek, block = f"motor_cheek_{i}", f"foot_block_{i}"
    stops, screws = named(names, f"stop_pin_{i}_"), named(names, f"motor_screw_{i}_")
    pressed = ["Press the stop pin in from inside until it stands out as drawn."]
    brings = [Bring((cheek,)), *(Bring((pin,), DRIVEN) for pin in stops)]
    if d.capstan is not None:
        pressed.append("Push the bearing into its seat from inside, by its outer ring, up to the lip.")
        brings.append(Bring((f"bearing_{i}_m",), IN, cheek))
    steps = [
        Step("Motor's cheek", tuple(pressed), tuple(brings), tools=(PRESS, "sleeve that presses the outer ring alone")),
        Step(
            "Motor on its cheek",
            (
                "Put the motor's pilot into its bore from outside and screw it on from inside, one screw after the "
                "other in two rounds.",
                "Use no longer screws: they would end in the winding.",
            ),
            (Bring((f"motor_{i}",), OUT), *(Bring((screw,), DRIVEN) for screw in screws)),
            screws,
            checks=("The motor's face lies flat on the cheek; its shaft turns freely.",),
        ),
    ]
    if d.capstan is not None:
        off = d.layers.motor_cheek_mm[0] - d.capstan.pinion_y_mm[0]
        steps.append(
            Step(
                "Pinion on the motor's shaft",
                (
                    "Push the pinion on the shaft from inside, its collar first, until its end stands "
                    f"{off:g} mm off the cheek's inner face.",
                    "The set screws are tightened in the finished drive, through the slot in the cheek's edge.",
                ),
                (Bring((), IN, cheek, (f"pinion {i}",)),),
                tools=("depth gauge",),
                checks=("The pinion turns with the motor and rubs nowhere.",),
            )
        )
    pins, into = named(names, f"cheek_dowel_{i}_m"), named(names, f"cheek_screw_{i}_m")
    steps.append(
        Step(
            "Foot block on the cheek",
            ("Press both pins into the cheek from inside, put the block on them, and screw it on from outside.",),
            (
                *(Bring((pin,), (Leg((0.0, 0.0, 1.0)),)) for pin in pins),
                Bring((block,), IN),
                *(Bring((screw,), DRIVEN) for screw in into),
            ),
            into,
            tools=(PRESS,),
            checks=("The block's lower face and the cheek's are square: no light under a square.",),
        )
    )
    return Unit(f"cheek {i}", "cheek", "Motor's side of a drive", tuple(steps))


def pinion_unit(d: Dimensions, names: tuple[str, ...], i: int) -> Unit:
    """States how a pinion gets its set screws."""
    del d
    step = Step(
        "Set screws in the pinion",
        ("Screw both set screws into the collar until their tips stand just short of its bore.",),
        (Bring((f"pinion_{i}",)), *(Bring((grub,), DRIVEN) for grub in named(names, f"set_screw_{i}_"))),
        tools=(f"hexagon key {catalogue.set_screw(SET_SCREW).socket_mm:g}",),
        checks=("A pin as thick as the motor's shaft passes the bore.",),
    )
    return Unit(f"pinion {i}", "pinion", "Pinion", (step,))
