"""The order of rods, platform and handle, and how a pair of rods is hung between an arm and the platform."""

from __future__ import annotations

from delta_cad import catalogue
from delta_cad.assembly.order.record import Bring, Leg, Step, Unit
from delta_cad.assembly.order.shoulder import DRIVEN, IN, OUT, bar_bonded
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import TUBE_ADHESIVE
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids.bought.spring import CORD_SLACK_MM

TOWARDS_ELBOW = (Leg((-1.0, 0.0, 0.0)),)
SANDED = "sandpaper 240, acetone"


def rod_unit(d: Dimensions, i: int, j: int) -> Unit:
    """States how a rod is put together in its jig."""
    f, tube, glue = d.forearm, f"rod_tube_{i}_{j}", catalogue.adhesive(TUBE_ADHESIVE).description
    cups = [f"rod_cup_{i}_{j}_{end}" for end in ("elbow", "wrist")]
    shells = [f"cup_shell_{i}_{j}_{end}" for end in ("elbow", "wrist")]
    poles = IN if j else OUT
    eyes = [f"rod_eye_{i}_{j}_{k}" for k in range(2)]
    steps = (
        Step(
            "Rod's end, tube and eyes",
            (
                f"Sand and wipe the spigot and the tube's bore, wet both with {glue}, and push the tube on to its "
                "shoulder with a turn.",
                f"Slide both eyes on, over wet rings, {f.eyes_x_mm[0]:.1f} and {f.eyes_x_mm[1]:.1f} mm from the middle "
                "of the cup's seat, the first aside away from the arm, the second towards it.",
            ),
            (
                Bring((cups[0],)),
                Bring((tube,), TOWARDS_ELBOW),
                *(Bring((eye,), TOWARDS_ELBOW, tube) for eye in eyes),
            ),
            tools=(SANDED, "rod jig"),
            supplies=("tube_adhesive",),
        ),
        Step(
            "Rod's other end, in the jig",
            (
                "Wet spigot and bore likewise and push the second end in.",
                f"Lay the rod into the jig: its two balls hold the seats {f.length_mm:.3f} mm apart, both cups open to "
                "the same side. All six rods harden in the same jig.",
            ),
            (Bring((cups[1],), TOWARDS_ELBOW, tube),),
            tools=(SANDED, "rod jig"),
            supplies=("tube_adhesive",),
            checks=("All six rods are equally long to 0.02 mm: hang them in turn on the same two balls.",),
        ),
        Step(
            "Shells in their cups",
            (
                f"Sand and wipe, wet with {glue}, push each shell in to its rim.",
                "When it is hard, lap the seat with a ball and paste until the gauge passes, and wash the paste out.",
            ),
            tuple(Bring((shell,), poles, tube) for shell in shells),
            tools=(SANDED, "ball and lapping paste", "gauge of the seat"),
            supplies=("tube_adhesive",),
            checks=("A ball turns in its seat without a catch and does not rock.",),
        ),
    )
    return Unit(f"rod {i}{j}", "rod", "Rod", steps)


def platform_unit(d: Dimensions) -> Unit:
    """States how the platform gets its cross-bars, balls and handle."""
    bars = {i: f"cross_bar_{i}_wrist" for i in CHAINS}
    balls = tuple((f"joint_ball_{i}_{j}_wrist", bars[i], j) for i in CHAINS for j in SIDES)
    first, second = bar_bonded(d, tuple(bars.values()), balls)
    first = Step(
        first.title,
        first.words,
        (Bring(("platform",)), *first.brings),
        tools=first.tools,
        supplies=first.supplies,
        checks=first.checks,
    )
    handle = Step(
        "Handle",
        ("Screw the stem into the platform, then the knob on the stem; hold the stem by its flats.",),
        (Bring(("handle_stem",), DRIVEN), Bring(("knob",), DRIVEN)),
        tools=("spanner on the stem's flats", "thread lock of medium strength"),
        checks=("The stem stands on the platform without a gap.",),
    )
    return Unit("platform", "platform", "Platform with its handle", (first, second, handle))


def pair_step(d: Dimensions, i: int) -> Step:
    """States how a pair of rods is hung on its balls and held by its springs."""
    f = d.forearm
    rods = tuple(Bring((), OUT if j else IN, f"rod_tube_{i}_{j}", (f"rod {i}{j}",)) for j in SIDES)
    springs = tuple(f"rod_spring_{i}_{k}" for k in range(2))
    return Step(
        f"Rods of chain {i}",
        (
            "Put a drop of grease in each cup and press both rods on their balls from outside, the first eye at the "
            "elbow.",
            f"Draw a cord through each spring, hook both springs into their eyes, {f.between_eyes_mm:.1f} mm apart, "
            f"and knot the cord in both eyes with {CORD_SLACK_MM:g} mm of slack.",
        ),
        (*rods, Bring(springs, is_laid=True)),
        tools=("spring hook",),
        supplies=("joint_grease", "rod_cord"),
        checks=(f"Each spring pulls {f.joint.spring_N:.1f} N; either rod, pushed off its ball by hand, snaps back.",),
    )
