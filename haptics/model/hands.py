"""Hands that hold the handle: five parameters each, a grasp before an arm, with their sources; light, medium, firm.

The arm's mass hangs on the handle through the grasp's spring and damper, and on the person through the arm's. Above
some 8 Hz (575 N/m on 0.21 kg) a loop feels the grasp and hardly the arm, so that a fast loop gets little from hands:
at 8 kHz the worst corner of their ranges bears 2 % less of a wall than a handle let go of, and results are told
with nobody first. Importing this module loads numba.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from haptics.model.plant import Hand

FU = (
    "M. J. Fu, M. C. Cavusoglu, Human-arm-and-hand-dynamic model with variability analyses for a stylus-based haptic "
    "interface, IEEE Trans. SMC-B 42(6), 2012: third order, 15 subjects, grips of 1 to 3 N, x, y and z"
)
CONFIRMED = (
    "partly: abstract and first page opened on 2026-11-23 (dokumen.tips, IEEE Transactions Systems, Man, and "
    "Cybernetics); its tables II and III were not: the figures are those that the public research notes of a "
    "handwriting pen transcribe (grasp 380 to 770, range 230 to 1040 N/m and 0.8 to 1.8, range 0 to 4.6 N s/m; mass "
    "0.20 to 0.22, range 0.02 to 0.57 kg; arm 79 to 272, range 63 to 533 N/m and 4.6 to 18, range 3.7 to 27.6 N s/m)"
)


@dataclass(frozen=True)
class HandModel:
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
HAND_MODELS: dict[str, HandModel] = {
    "light": HandModel(
        Hand(mass=0.20, damping=4.6, stiffness=79.0, grasp_stiffness=380.0, grasp_damping=0.8),
        "a loose grip of a slack arm: the low ends of the baseline",
        FU,
        CONFIRMED,
    ),
    "medium": HandModel(
        Hand(mass=0.21, damping=11.3, stiffness=175.0, grasp_stiffness=575.0, grasp_damping=1.3),
        "the middle of the baseline",
        FU,
        CONFIRMED,
    ),
    "firm": HandModel(
        Hand(mass=0.22, damping=18.0, stiffness=272.0, grasp_stiffness=770.0, grasp_damping=1.8),
        "a tight grip of a tense arm: the high ends of the baseline",
        FU,
        CONFIRMED,
    ),
}

HANDS: dict[str, Hand] = {name: model.hand for name, model in HAND_MODELS.items()}  # The set as the plant takes it

# Least and largest of each parameter over subjects, grips and axes, in the order of `Hand`.
RANGES = ((0.02, 0.57), (3.7, 27.6), (63.0, 533.0), (230.0, 1040.0), (0.0, 4.6))
# All corners of the ranges: 32 hands, by their places such as "01101".
CORNERS: dict[str, Hand] = {
    "".join(map(str, places)): Hand(*(ends[place] for ends, place in zip(RANGES, places, strict=True)))
    for places in product((0, 1), repeat=len(RANGES))
}
