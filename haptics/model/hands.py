"""Hands that hold the handle: light, medium and firm, each a mass, damper and spring to ground, with their sources.

A grip is softer than the arm behind it. Above some 8 Hz (a grasp of 575 N/m on 0.21 kg) a loop feels the grasp and
hardly the arm, so the light hand is the grasp alone. Medium and firm hands hold so tightly that arm and handle move
as one; real hands lie between. That is why results are given as an interval over the set. Importing this module loads
numba.
"""

from __future__ import annotations

from dataclasses import dataclass

from haptics.model.plant import Hand

FU = (
    "M. J. Fu, M. C. Cavusoglu, Human-arm-and-hand-dynamic model with variability analyses for a stylus-based haptic "
    "interface, IEEE Trans. SMC-B 42(6), 2012, tables II and III"
)
TRANSCRIBED = (
    "partly: read in the public research notes of a handwriting pen, which transcribe the tables (grasp 380 to 770, "
    "range 230 to 1040 N/m and 0.8 to 1.8, range 0 to 4.6 N s/m; mass 0.20 to 0.22, range 0.02 to 0.57 kg; arm 79 to "
    "272, range 63 to 533 N/m and 4.6 to 18, range 3.7 to 27.6 N s/m); the paper itself was not opened"
)


@dataclass(frozen=True)
class HandModel:
    """A hand with where it comes from.

    Attributes:
        hand: Mass (kg), damping (N s/m), stiffness (N/m).
        meaning: Who holds how.
        source: Publication.
        confirmed: What of it was seen where; what is from memory says so.
    """

    hand: Hand
    meaning: str
    source: str
    confirmed: str


# The set. Further figures, from memory and not used: fingertips 3.5 to 8.7 g, 4 to 7.4 N s/m, 210 to 1150 N/m (A. Z.
# Hajian, R. D. Howe, J. Biomech. Eng. 119, 1997); arms up to 1.5 kg, 5 to 30 N s/m, 100 to 600 N/m (N. Hogan 1989; J.
# E. Speich, L. Shao, M. Goldfarb, Mechatronics 15, 2005); stiffness and damping that rise with the force of the grip
# (K. J. Kuchenbecker, J. G. Park, G. Niemeyer, IMECE 2003; also C. J. Hasser, M. R. Cutkosky 2002, whose abstract was
# seen).
HAND_MODELS: dict[str, HandModel] = {
    "light": HandModel(
        Hand(mass=0.02, damping=0.8, stiffness=380.0),
        "fingertips: the grasp alone at the low end of its baseline, with the smallest mass of the range",
        FU,
        TRANSCRIBED,
    ),
    "medium": HandModel(
        Hand(mass=0.21, damping=11.3, stiffness=175.0),
        "a grip that moves with the arm: the middle of the arm's baseline",
        FU,
        TRANSCRIBED + ". One trial of another group lies near: 0.554 kg, 6.45 N s/m, 135 N/m, seen in the caption of "
        "figure 3 of Scientific Reports 5, 18004 (2015)",
    ),
    "firm": HandModel(
        Hand(mass=0.57, damping=27.6, stiffness=533.0),
        "a tight grip and a tense arm: the upper end of the ranges",
        FU,
        TRANSCRIBED,
    ),
}

HANDS: dict[str, Hand] = {name: model.hand for name, model in HAND_MODELS.items()}  # The set as the plant takes it
