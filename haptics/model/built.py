"""Structure of a device as its build computed it from the parts: `structure.json`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from delta_cad.common.reading import ReadError, read_json
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design, design_hash

FILE, _SCHEMA = "structure.json", "delta-structure/1"


@dataclass(frozen=True, eq=False)
class BuiltStructure:
    """Stiffness at the knob, motors held, cable included.

    Attributes:
        places: Coordinates of the grid along x, y and z, m, each (n,).
        flexibility: (n, n, n, 3, 3) way over force at the knob on that grid, m/N.
        centre: Least stiffness of all directions in the cube's centre, N/m.
        softest: The same at the softest of the build's positions, N/m.
        mode: First mode in the centre, nobody at the knob, Hz.
        slowest: The lowest over the cube, Hz.
    """

    places: tuple[np.ndarray, np.ndarray, np.ndarray]
    flexibility: np.ndarray
    centre: float
    softest: float
    mode: float
    slowest: float

    def at(self, p: np.ndarray) -> np.ndarray:
        """Flexibility at a position (3,) of the cube, m: (3, 3) m/N, linear between the positions of the grid."""
        found = self.flexibility
        for places, place in zip(self.places, p, strict=True):
            k = int(np.clip(np.searchsorted(places, place, side="right") - 1, 0, len(places) - 2))
            share = np.clip((place - places[k]) / (places[k + 1] - places[k]), 0.0, 1.0)
            found = (1.0 - share) * found[k] + share * found[k + 1]
        return found


def built_structure(folder: Path, design: Design) -> BuiltStructure | None:
    """Reads `structure.json` of a design's build; None where it is missing, of another design, or cannot be read."""
    try:
        data = read_json(folder / FILE)
        if data["schema"] != _SCHEMA or data["input_sha256"] != design_hash(design):
            return None
        points = np.array([row["position_mm"] for row in data["stiffness_N_mm"]], dtype=float) / MM_PER_M
        stiffness = MM_PER_M * np.array([row["matrix"] for row in data["stiffness_N_mm"]], dtype=float)
        at: list[float] = [MM_PER_M * float(data[place]["softest_N_mm"]) for place in ("centre", "softest")]
        at += [float(data[place]["first_mode_Hz"]) for place in ("centre", "slowest")]
        grid, indices = zip(*(np.unique(column, return_inverse=True) for column in points.T), strict=True)
        flexibility = np.full((*map(len, grid), 3, 3), np.nan)
        flexibility[indices] = np.linalg.inv((stiffness + np.swapaxes(stiffness, -1, -2)) / 2.0)
        if not (np.array(at) > 0.0).all() or not (np.linalg.eigvalsh(flexibility) > 0.0).all():
            return None  # a NaN or a position that is missing is no figure, either
        return BuiltStructure((grid[0], grid[1], grid[2]), flexibility, *at)
    except (ReadError, KeyError, TypeError, ValueError, IndexError, np.linalg.LinAlgError):
        return None
