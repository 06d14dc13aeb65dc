"""Hands that hold the handle: five parameters each, a grasp before an arm, as measured; light, medium, firm.

The arm's mass hangs on the handle through the grasp's spring and damper, and on the person through the arm's. The three
are those of one study along its three directions, by the stiffness of their arms; here each acts alike in all
directions, as a hand that nobody has, so that they are ends and a middle and not persons. By grip the study has a table
that was not transcribed; the notes call the dependence small (470 to 671 N/m of one grasp from 1 to 3 N). The firmest
arm has the grasp that damps least, the middle one that which damps most. The study fits best up to 20 Hz, to 2.4 mm.

Above 7 to 10 Hz, where arms ring on their grasps, a loop feels the grasp and hardly the arm, so that a fast loop gets
little from hands: at 8 kHz the worst corner of their ranges bears 1 % less of a wall than a handle let go of, and
results are told with nobody first. Importing this module loads numba.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from haptics.model.plant import Hand

_FU = (
    "M. J. Fu, M. C. Cavusoglu, Human-arm-and-hand-dynamic model with variability analyses for a stylus-based haptic "
    "interface, IEEE Trans. SMC-B 42(6), 2012: third order, 15 subjects, grips of 1 to 3 N, x, y and z"
)
_CONFIRMED = (
    "partly: abstract and first page opened on 2026-11-23 (dokumen.tips, IEEE Transactions Systems, Man, and "
    "Cybernetics); tables II and III as research notes transcribe them from the authors' text, opened on 2026-11-27 "
    "(github: adambickerdike/Stabilisation_Pen, docs/research/ledger/HAP_guidance_impedance.csv, row HAP-26, and the "
    "same figures in sim2/myo.py): held like a pen, elbow and arm in the air, 15 subjects, forces of 0.6 to 30 Hz"
)


@dataclass(frozen=True)
class _HandModel:
    """A hand with where it comes from.

    Attributes:
        hand: Arm's mass (kg), damping (N s/m), stiffness (N/m), the grasp's stiffness (N/m) and damping (N s/m).
        meaning: Who holds how.
        source: Publication.
        confirmed: What of it was seen where; what is from memory says so.
    """

    hand: Hand
    meaning: str
    source: str
    confirmed: str


# Others, not used: the form of five parameters, "below 20 to 30 Hz" (J. E. Speich, L. Shao, M. Goldfarb, Mechatronics
# 15, 2005; its first page was seen by a study of this project); stiffness and damping that rise with the grip (C. J.
# Hasser, M. R. Cutkosky 2002, abstract opened). One trial lies near: 0.554 kg, 6.45 N s/m, 135 N/m (caption of figure
# 3 of Scientific Reports 5, 18004, 2015, opened).
HAND_MODELS: dict[str, _HandModel] = {
    "light": _HandModel(
        Hand(mass=0.218, damping=4.645, stiffness=78.75, grasp_stiffness=379.5, grasp_damping=1.839),
        "the softest arm that was measured: pushed across",
        _FU,
        _CONFIRMED,
    ),
    "medium": _HandModel(
        Hand(mass=0.269, damping=6.430, stiffness=105.3, grasp_stiffness=552.4, grasp_damping=3.609),
        "the middle one: pushed up and down",
        _FU,
        _CONFIRMED,
    ),
    "firm": _HandModel(
        Hand(mass=0.204, damping=18.06, stiffness=271.7, grasp_stiffness=769.9, grasp_damping=0.776),
        "the stiffest arm and grasp: pushed to and fro",
        _FU,
        _CONFIRMED,
    ),
}

HANDS: dict[str, Hand] = {name: model.hand for name, model in HAND_MODELS.items()}  # The set as the plant takes it

# 95 % limits of each parameter over subjects and grips, of the softest and the stiffest direction, in the order of
# `Hand`; the middle one's were not transcribed, its own figures lie within.
RANGES = ((0.016, 0.57), (3.68, 27.6), (63.0, 533.0), (228.0, 1043.0), (0.0, 4.56))
# All corners of the ranges: 32 hands, by their places such as "01101".
CORNERS: dict[str, Hand] = {
    "".join(map(str, places)): Hand(*(ends[place] for ends, place in zip(RANGES, places, strict=True)))
    for places in product((0, 1), repeat=len(RANGES))
}
