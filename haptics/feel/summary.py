"""The figures of the sheet: name, unit, better direction, and values over the cube."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Quantity:
    """A figure of the sheet: its name, unit and what is better.

    Attributes:
        name: As `feel_at` names it, or "wall".
        label: Text for a person.
        unit: Unit that a person sees.
        factor: From SI to that unit.
        digits: Decimals after the point.
        small: Whether less is better.
    """

    name: str
    label: str
    unit: str
    factor: float
    digits: int
    small: bool

    @property
    def key(self) -> str:
        """Name of the figure with its unit, for files."""
        unit = self.unit.replace(" ", "_").replace("/", "_per_").replace("^", "")
        return f"{self.name}_{unit}" if unit else self.name


WALL = Quantity("wall", "wall that is rendered, worst direction", "N/mm", 1e-3, 1, False)
QUANTITIES = (
    Quantity("mass_max", "effective mass, heaviest direction", "g", 1e3, 0, True),
    Quantity("mass_min", "effective mass, lightest direction", "g", 1e3, 0, True),
    Quantity("mass_x", "effective mass along x", "g", 1e3, 0, True),
    Quantity("mass_y", "effective mass along y", "g", 1e3, 0, True),
    Quantity("mass_z", "effective mass along z", "g", 1e3, 0, True),
    Quantity("isotropy", "isotropy of mass, lightest over heaviest", "", 1.0, 2, False),
    Quantity("friction_max", "friction at the handle, worst direction", "N", 1.0, 2, True),
    Quantity("friction_min", "friction at the handle, best direction", "N", 1.0, 2, True),
    Quantity("force_step", "force step of the command", "mN", 1e3, 0, True),
    Quantity("ripple_still", "torque ripple, weight alone held", "N", 1.0, 3, True),
    Quantity("ripple_force", "torque ripple, at the continuous torque", "N", 1.0, 2, True),
    Quantity("position_step", "handle's way for one count", "um", 1e6, 2, True),
    Quantity("force_continuous", "force in every direction, continuous", "N", 1.0, 1, False),
    Quantity("force_peak", "force in every direction, peak", "N", 1.0, 1, False),
    Quantity("force_motor", "force in every direction, motor's own limit", "N", 1.0, 1, False),
    Quantity("force_peak_best", "force in the best direction, peak", "N", 1.0, 1, False),
    Quantity("dynamic_range", "dynamic range, continuous force over friction", "", 1.0, 1, False),
    Quantity("acceleration", "acceleration in every direction, peak", "m/s^2", 1.0, 0, False),
    WALL,
    Quantity("gravity", "gravity torque, largest joint", "mN m", 1e3, 0, True),
)


@dataclass(frozen=True)
class Summary:
    """A figure over the cube, SI.

    Attributes:
        quantity: The quantity.
        centre: In the cube's centre.
        best: The best value, and its position (3,), m.
        worst: The worst value, and its position (3,), m.
    """

    quantity: Quantity
    centre: float
    best: tuple[float, np.ndarray]
    worst: tuple[float, np.ndarray]


def summarise(quantity: Quantity, middle: float, values: np.ndarray, positions: np.ndarray) -> Summary:
    """Best and worst value of a quantity with their positions.

    Args:
        quantity: The quantity.
        middle: Value in the centre.
        values: (...) SI.
        positions: (..., 3) m.
    """
    flat, places = values.reshape(-1), positions.reshape(-1, 3)
    least, most = int(np.argmin(flat)), int(np.argmax(flat))
    best, worst = (least, most) if quantity.small else (most, least)
    return Summary(quantity, middle, (float(flat[best]), places[best]), (float(flat[worst]), places[worst]))
