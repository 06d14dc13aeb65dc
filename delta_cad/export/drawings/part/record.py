"""The records of the content of a part's drawing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from delta_cad.export.drawings.part.controlled import Round
from delta_cad.export.drawings.part.faces import Face
from delta_cad.export.drawings.part.holes import HoleGroup, Slots

SAME_MM = 1e-3  # coordinates and sizes that are one: a micrometre is what is printed


@dataclass(eq=False)
class Place:
    """A coordinate that has to be told.

    Attributes:
        key: Unique name.
        along: (3,) unit vector along which it counts.
        value: The coordinate in the part's frame, mm.
        at: (3,) point where it is shown, mm.
        end_on: (3,) direction from which what it places is seen in its true shape; None: from any side along it.
        points: (n, 3) where it lies on the part: its extension line begins there.
    """

    key: str
    along: np.ndarray
    value: float
    at: np.ndarray
    end_on: np.ndarray | None
    points: np.ndarray


@dataclass(eq=False)
class Size:
    """A size that has to be told once, however many faces have it.

    Attributes:
        key: Unique name.
        text: What is told.
        faces: The faces that have it; [0] is shown.
        kind: "round", "ball", "ring" or "flat".
        tolerance: What is required of it; None: the general tolerance.
        pieces: Its faces, those that meet in one, where the text counts them; else none.
    """

    key: str
    text: str
    faces: list[Face]
    kind: str
    tolerance: Round | None = None
    pieces: list[list[Face]] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class Datum:
    """What tolerances count from: a plane, or the axis of what is round."""

    letter: str
    faces: tuple[Face, ...]

    @property
    def key(self) -> str:
        """Unique name."""
        return f"datum {self.letter}"


@dataclass(frozen=True, eq=False)
class Zone:
    """A geometric tolerance.

    Attributes:
        kind: "position", "perpendicularity" or "coaxiality", ISO 1101.
        value_mm: How wide its zone is.
        is_round: Whether the zone is a cylinder about an axis.
        faces: Of what is held in it, equal ones together.
        datums: Letters of what it counts from, in their order.
        key: Unique name.
        combined: Whether the zones of its faces keep their places to one another, ISO 5458: "CZ".
    """

    kind: str
    value_mm: float
    is_round: bool
    faces: tuple[Face, ...]
    datums: tuple[str, ...]
    key: str
    combined: bool = False


@dataclass(eq=False)
class Features:
    """All that has to be told of a part.

    Attributes:
        faces: Its faces.
        groups: Its holes.
        slots: Its slots.
        main: (3,) direction along which most of it is drawn: the axis of a turned part, else the way of its bores.
        turned: Whether it is a turned part.
        places: Coordinates.
        sizes: Diameters, radii.
        notes: Told in words, by key: chamfers, a pattern, curved faces.
        datum: (3,) coordinates that count as 0.
        datums: What tolerances count from.
        zones: Geometric tolerances.
        exact: Keys of coordinates that are theoretically exact, as a tolerance of position has its zone there.
    """

    faces: list[Face]
    groups: list[HoleGroup]
    slots: list[Slots]
    main: np.ndarray
    turned: bool
    places: list[Place] = field(default_factory=list)
    sizes: list[Size] = field(default_factory=list)
    notes: dict[str, str] = field(default_factory=dict)
    datum: np.ndarray = field(default_factory=lambda: np.zeros(3))
    datums: list[Datum] = field(default_factory=list)
    zones: list[Zone] = field(default_factory=list)
    exact: set[str] = field(default_factory=set)


def bores_of(zone: Zone, features: Features) -> int:
    """Counts the bores that a zone's faces are walls of."""
    walls = {id(face) for face in zone.faces}
    return sum(any(id(face) in walls for face in bore.faces) for group in features.groups for bore in group.bores)
