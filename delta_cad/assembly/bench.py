"""The bench on which a machine is put together: parts made once, occurrences placed, fits noted."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.rules import require
from delta_cad.mechanism.placement import frames
from delta_cad.solids.bought import fasteners
from delta_cad.solids.part import Fit, Occurrence, Part

ROUNDING_MM = 1e-9  # sums of a few lengths of 10 mm
CONTACT_MM3 = 0.01  # common volume of two faces that touch: the kernel's noise, not a fit
BESIDE_MM = 0.8  # least gap of what turns beside a cheek: 1 mm by design less play and the meshes' deviation
Progress = Callable[[str], None]


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    """(4, 4) translation."""
    moved = np.eye(4)
    moved[:3, 3] = (x, y, z)
    return moved


HALF_TURN = np.diag([-1.0, -1.0, 1.0, 1.0])  # about z
UPRIGHT = np.array([[0.0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]])  # x down: rods pass beside the board


def pointing(direction: Sequence[float], x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    """(4, 4) frame at a point whose z axis is the direction: how screws, dowels and sleeves are placed."""
    axis = np.asarray(direction, dtype=float)
    axis = axis / np.linalg.norm(axis)
    aside = np.cross([0.0, 1.0, 0.0] if abs(axis[1]) < 0.9 else [1.0, 0.0, 0.0], axis)
    first = aside / np.linalg.norm(aside)
    return frames(first, np.cross(axis, first), np.array([x, y, z]))


def longest(size: str, available_mm: float) -> float:
    """Longest stock length of a cap screw, such as "M3", that fits from under its head to the end of the thread, mm.

    Raises:
        DimensionError: The shortest one is longer.
    """
    return _longest(catalogue.screw(size).lengths_mm, available_mm, f"screw_{size}", " under the head")


def longest_dowel(key: str, available_mm: float) -> float:
    """Longest stock length of a dowel, such as "3", that does not exceed the depth of its bores together, mm.

    Raises:
        DimensionError: The shortest one is longer.
    """
    return _longest(catalogue.dowel(key).lengths_mm, available_mm, f"dowel_{key}")


def longest_set_screw(size: str, available_mm: float) -> float:
    """Longest stock length of a set screw that stays below the surface, mm.

    Raises:
        DimensionError: The shortest one is longer.
    """
    return _longest(catalogue.set_screw(size).lengths_mm, available_mm, f"set_screw_{size}")


def _longest(lengths_mm: tuple[float, ...], available_mm: float, part: str, where: str = "") -> float:
    fitting = [length for length in lengths_mm if length <= available_mm + ROUNDING_MM]
    shortest = f"{available_mm:.2f} mm are available{where}; the shortest has {min(lengths_mm):g} mm"
    require(bool(fitting), part, "length", shortest)
    return max(fitting)


class Bench:
    """Collects occurrences; makes each part once."""

    def __init__(self, d: Dimensions, progress: Progress) -> None:
        self.d = d
        self.progress = progress
        self.parts: dict[str, Part] = {}
        self.occurrences: list[Occurrence] = []
        self.fits: list[Fit] = []

    def once(self, key: str, make: Callable[[], Part]) -> Part:
        """Makes the part of a key the first time it is asked for."""
        if key not in self.parts:
            self.progress(key)
            self.parts[key] = make()
        return self.parts[key]

    def screw(self, size: str, length: float) -> Part:
        """Gives the cap screw of a size and a length."""
        return self.once(f"screw_{size}x{length:g}", lambda: fasteners.make_cap_screw(size, length))

    def dowel(self, key: str, length: float) -> Part:
        """Gives the dowel of a diameter and a length."""
        return self.once(f"dowel_{key}x{length:g}", lambda: fasteners.make_dowel(key, length))

    def put(self, name: str, part: Part, link: str, placement: np.ndarray) -> str:
        """Places a part on a link in its frame there."""
        self.occurrences.append(Occurrence(name, part, link, placement))
        return name

    def touch(self, a: str, b: str, reason: str, guides: bool = True, overlap_mm3: float = CONTACT_MM3) -> None:
        """Notes two parts that touch by design, in a joint's seat or elsewhere."""
        self.fits.append(Fit(a, b, "contact", overlap_mm3=overlap_mm3, reason=reason, guides=guides))

    def piece(self, a: str, b: str) -> None:
        """Notes two pieces that one part is drawn in."""
        self.fits.append(Fit(a, b, "piece", reason="one part, drawn in pieces"))

    def gap(self, a: str, b: str, gap_mm: float, reason: str, gap_max_mm: float | None = None) -> None:
        """Notes two parts on different links that come closer than others by design."""
        self.fits.append(Fit(a, b, "running gap", gap_mm=gap_mm, reason=reason, gap_max_mm=gap_max_mm))
