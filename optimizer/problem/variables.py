"""The design variables: their names, their units, and the mechanism and the cube that they stand for."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import Cube, DeltaGeometry
from delta_cad.mechanism.geometry import THREE_FOLD, azimuth_cosine

# Names of the nine numbers of a design: the paper's L_A, L_B, R, r, H, L, then where chains and cube are placed:
# R_1 - R_0, the cosine of the azimuth of chain 1, and how far the cube's middle stands off the axis.
VARIABLES = (
    "upper_arm_length",
    "forearm_length",
    "base_radius",
    "platform_radius",
    "bottom_height",
    "half_side",
    "side_shift",
    "side_cosine",
    "centre_x",
)
SIDE, PLATFORM, COSINE = (VARIABLES.index(name) for name in ("half_side", "platform_radius", "side_cosine"))
LENGTHS = VARIABLES[:6]
"""The paper's variables, which a three-fold symmetric machine has alone."""
SYMMETRIC = {"side_shift": 0.0, "side_cosine": THREE_FOLD, "centre_x": 0.0}
"""Where chains and cube of a three-fold symmetric machine are placed."""
PER_SI = np.array([1.0 if name == "side_cosine" else MM_PER_M for name in VARIABLES])
"""(9,) how many of a file's units an SI unit is: mm for lengths, none for the cosine."""
PER_SI.flags.writeable = False
PLACEMENT = ("side_shift_mm", "azimuth_deg", "centre_x_mm")
"""Names of the placement in reports."""
_DECIMALS = 9  # of sums in mm and of azimuths in degrees, in a file: what is behind them is their rounding


def completed(designs: ArrayLike) -> np.ndarray:
    """Completes designs that are given by the paper's six variables: three-fold symmetric.

    Args:
        designs: (..., 6) or (..., 9), in any unit of length.

    Returns:
        (..., 9) in the order of `VARIABLES`.
    """
    designs = np.asarray(designs, dtype=float)
    if designs.shape[-1] == len(VARIABLES):
        return designs
    placed = np.broadcast_to(list(SYMMETRIC.values()), (*designs.shape[:-1], len(SYMMETRIC)))
    return np.concatenate([designs, placed], axis=-1)


def mechanism_of(design_mm: ArrayLike) -> tuple[DeltaGeometry, Cube]:
    """Makes the mechanism and the cube of a design.

    Args:
        design_mm: (9,) or (6,), mm.

    Raises:
        GeometryError: A length or the placement is none that a mechanism or a cube has.
    """
    L_A, L_B, R, r, H, L, shift, cosine, x = (float(v) for v in completed(design_mm) / PER_SI)
    return DeltaGeometry(R, r, L_A, L_B, shift, cosine), Cube(H, L, x)


def is_symmetric(design_mm: ArrayLike) -> bool:
    """Tells whether a design is placed as a three-fold symmetric machine with its cube on the axis."""
    return tuple(completed(design_mm)[len(LENGTHS) :]) == tuple(SYMMETRIC.values())


def azimuth_deg(cosine: float) -> float:
    """Computes the azimuth of chain 1, degrees; exactly 120 of a three-fold symmetric machine."""
    return 120.0 if cosine == THREE_FOLD else math.degrees(math.acos(cosine))


def named(design_mm: ArrayLike) -> dict[str, float]:
    """Names the variables of a design with their units, as reports have them; the placement where it is not symmetric.

    Args:
        design_mm: (9,) or (6,), mm.
    """
    values = dict(zip(VARIABLES, map(float, completed(design_mm)), strict=True))
    found = {f"{name}_mm": values[name] for name in LENGTHS}
    if not is_symmetric(design_mm):
        placed = values["side_shift"], azimuth_deg(values["side_cosine"]), values["centre_x"]
        found |= dict(zip(PLACEMENT, placed, strict=True))
    return found


def design_fields(design_mm: ArrayLike) -> tuple[dict[str, Any], dict[str, Any]]:
    """Gives the fields of a design file; the placement where it is not symmetric.

    Args:
        design_mm: (9,) or (6,), mm.

    Returns:
        Fields of `mechanism` but the parallelogram's width, and of `cube`.
    """
    values = dict(zip(VARIABLES, map(float, completed(design_mm)), strict=True))
    mechanism: dict[str, Any] = {f"{name}_mm": values[name] for name in LENGTHS[:4]}
    cube = {f"{name}_mm": values[name] for name in LENGTHS[4:]}
    shift, cosine, x = values["side_shift"], values["side_cosine"], values["centre_x"]
    if cosine != THREE_FOLD:
        azimuth = round(azimuth_deg(cosine), _DECIMALS)
        mechanism["azimuths_deg"] = [0.0, azimuth, -azimuth]
    if shift != 0.0:
        side = round(values["base_radius"] + shift, _DECIMALS)
        mechanism["base_radii_mm"] = [values["base_radius"], side, side]
    if x != 0.0:
        cube["centre_x_mm"] = x
    return mechanism, cube


def variables_mm(mechanism: dict[str, Any], cube: dict[str, Any]) -> tuple[float, ...]:
    """Reads the variables of a design from the fields of its file; inverse of `design_fields`.

    Args:
        mechanism: Fields of `mechanism`; None, too, where one is left out.
        cube: Fields of `cube`.

    Returns:
        (9) in the order of `VARIABLES`, mm.
    """
    lengths = [(mechanism if name in LENGTHS[:4] else cube)[f"{name}_mm"] for name in LENGTHS]
    azimuths, radii = mechanism.get("azimuths_deg"), mechanism.get("base_radii_mm")
    shift = 0.0 if radii is None else radii[1] - radii[0]
    cosine = THREE_FOLD if azimuths is None else azimuth_cosine(azimuths[1])
    return (*lengths, shift, cosine, cube.get("centre_x_mm") or 0.0)
