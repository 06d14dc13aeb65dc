"""Cross-sections of bars: area, shear areas, second moments and torsion constant, mm, of the shapes that parts have.

A section's plane is (y, z); the bar runs along x.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

_SHEAR_RECTANGLE = 5.0 / 6.0  # Timoshenko's shear area over the area, Poisson's ratio neglected (the low, safe side)
_SHEAR_CIRCLE = 0.9
_SHEAR_TUBE = 0.5
POISSON = 0.3  # of every metal here


@dataclass(frozen=True)
class Section:
    """A cross-section.

    Attributes:
        area_mm2: A.
        shear_y_mm2: Area that carries a shear force along y.
        shear_z_mm2: Area that carries a shear force along z.
        torsion_mm4: Saint-Venant's torsion constant J.
        about_y_mm4: Second moment about y: of bending by a force along z.
        about_z_mm4: Second moment about z: of bending by a force along y.
    """

    area_mm2: float
    shear_y_mm2: float
    shear_z_mm2: float
    torsion_mm4: float
    about_y_mm4: float
    about_z_mm4: float


def rectangle_torsion_mm4(b: float, h: float) -> float:
    """Computes the torsion constant of a solid rectangle of any side ratio, mm^4.

    Source:
        Roark's Formulas for Stress and Strain, torsion of a solid rectangle, half sides a >= b:
        `a b^3 [16/3 - 3.36 (b/a) (1 - b^4 / (12 a^4))]`, at most 4 % off.
    """
    long, short = max(b, h) / 2.0, min(b, h) / 2.0
    return long * short**3 * (16.0 / 3.0 - 3.36 * short / long * (1.0 - short**4 / (12.0 * long**4)))


def rectangle(b: float, h: float) -> Section:
    """Computes a solid rectangle, b along y and h along z, mm."""
    area = b * h
    shear = _SHEAR_RECTANGLE * area
    return Section(area, shear, shear, rectangle_torsion_mm4(b, h), b * h**3 / 12.0, h * b**3 / 12.0)


def circle(d: float) -> Section:
    """Computes a solid circle of a diameter, mm."""
    area, second = pi * d**2 / 4.0, pi * d**4 / 64.0
    return Section(area, _SHEAR_CIRCLE * area, _SHEAR_CIRCLE * area, 2.0 * second, second, second)


def ring(outer: float, inner: float) -> Section:
    """Computes a round tube by its two diameters, mm."""
    area, second = pi * (outer**2 - inner**2) / 4.0, pi * (outer**4 - inner**4) / 64.0
    return Section(area, _SHEAR_TUBE * area, _SHEAR_TUBE * area, 2.0 * second, second, second)


def stepped_plate(b: float, h: float, deep: float, slotted: float) -> Section:
    """Computes a plate, b thick (y) and h wide (z), of which a part of the width is cut into from one face, mm.

    Args:
        b: Thickness along y.
        h: Width along z.
        deep: Depth of the cut.
        slotted: Width that it takes.

    Source:
        Sums of both parts' own, each about its own middle along y: over a short cut they do not bend as one, which
        leaves Steiner's terms out, the low, safe side.
    """
    whole, thin = rectangle(b, h - slotted), rectangle(b - deep, slotted)
    area = whole.area_mm2 + thin.area_mm2
    return Section(
        area_mm2=area,
        shear_y_mm2=_SHEAR_RECTANGLE * area,
        shear_z_mm2=_SHEAR_RECTANGLE * area,
        torsion_mm4=whole.torsion_mm4 + thin.torsion_mm4,
        about_y_mm4=area * h**2 / 12.0,
        about_z_mm4=whole.about_z_mm4 + thin.about_z_mm4,
    )


def ribs(b: float, thickness: float, gap: float, length: float) -> Section:
    """Computes a plate with a window, mm: two equal ribs along x between two parts that do not bend.

    Args:
        b: Width of both ribs together, along y.
        thickness: Of the plate, along z.
        gap: Between the ribs.
        length: Of the window along x.

    Source:
        Vierendeel's frame of two posts (Timoshenko and Young, Theory of Structures): a shift d of one end bends each
        rib with `12 E I d / l^3`. Twisted by phi the ribs shift by phi e / 2 up and down, which adds `6 E I e^2 / l^2`
        to G J; sheared along y they shift together, which takes `24 E I / l^2` in series with the shear of the plate.
    """
    one, elastic = b / 2.0, 2.0 * (1.0 + POISSON)
    area, apart = b * thickness, gap + b / 2.0
    up, aside = one * thickness**3 / 12.0, thickness * one**3 / 12.0
    shear = _SHEAR_RECTANGLE * area
    return Section(
        area_mm2=area,
        shear_y_mm2=1.0 / (1.0 / shear + length**2 / (24.0 * elastic * aside)),
        shear_z_mm2=shear,
        torsion_mm4=2.0 * rectangle_torsion_mm4(one, thickness) + 6.0 * elastic * up * (apart / length) ** 2,
        about_y_mm4=2.0 * up,
        about_z_mm4=2.0 * aside + area * (apart / 2.0) ** 2,
    )
