"""Lengths of anybody's delta, for figures without any hardware, in the conventions of other projects.

The file is a design file of which `mechanism` and `cube` are enough, with lengths of up to 3 m. In `mechanism` sides of
triangles may stand for radii, R - r for both of them, and collars may lie between the joints and the bars.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from typing import Any

from pydantic import BaseModel, Field, create_model

from delta_cad.common.reading import ReadError, read_json
from delta_cad.common.refusal import short
from delta_cad.common.units import MM_PER_M
from delta_cad.design.cross_field_rules import contradictions
from delta_cad.design.file import MOST_BYTES, SECTIONS, DesignError, record_of
from delta_cad.design.record import NAME_PATTERN, SCHEMA, Design, DesignCube, DesignRequirements, Mechanism
from delta_cad.design.task import LEAST

MOST_MM = 3000.0
_FREE_MM, FREE_TORQUE_N_M = 5000.0, 100.0  # limits that are not stated: so wide that they bound nothing
_CORNERS, _MIDDLES = sqrt(3.0) / 3.0, sqrt(3.0) / 6.0  # of a triangle's side: from its centre to corners and middles
_AT = {"corners": _CORNERS, "middles": _MIDDLES}
_DIFFERENCE = "radius_difference_mm"
_LEAST_RADIUS_MM = 1.0  # radius at least of what stands for a difference
_LEFT_OUT = ("hardware", "panel", "loop", "revision", "provenance")


def _length(description: str, **changes: Any) -> Any:
    """A length of up to 3 m, or a number with other bounds."""
    return float, Field(**({"gt": 0.0, "le": MOST_MM, "description": description} | changes))


def _with(kind: type[BaseModel], **fields: Any) -> Any:
    """A record with other bounds and defaults of some fields, and with more of them."""
    return create_model(f"_{kind.__name__}", __base__=kind, **fields)


_Mechanism = _with(
    Mechanism,
    base_radius_mm=_length("R: base centre to shoulder axis"),
    platform_radius_mm=_length("r: platform centre to wrist"),
    upper_arm_length_mm=_length("L_A: shoulder to elbow"),
    forearm_length_mm=_length("L_B: of the bars of the parallelogram"),
    parallelogram_width_mm=_length("L_c: bounds nothing", default=1.0),
    collar_elbow_mm=_length("from the elbow's axis to the bars", default=0.0, gt=None, ge=0.0),
    collar_wrist_mm=_length("from the bars to the wrist's axis", default=0.0, gt=None, ge=0.0),
)
_Cube = _with(
    DesignCube,
    bottom_height_mm=_length("H: bottom face over the plane of the shoulder axes"),
    half_side_mm=_length("L: half the side"),
)
_Requirements = _with(
    DesignRequirements,
    envelope_width_mm=_length("not looked at", default=_FREE_MM, le=_FREE_MM),
    envelope_depth_mm=_length("not looked at", default=_FREE_MM, le=_FREE_MM),
    force_N=_length("at the handle, any direction", default=1.0, gt=None, ge=LEAST, le=1000.0),
    joint_torque_N_m=_length("of each joint", default=FREE_TORQUE_N_M, gt=None, ge=LEAST, le=FREE_TORQUE_N_M),
)
_Design = _with(
    Design,
    name=(str, Field(default="delta", pattern=NAME_PATTERN, description="name of the delta")),
    mechanism=(_Mechanism, ...),
    cube=(_Cube, ...),
    requirements=(_Requirements, Field(default_factory=_Requirements)),
)
_SECTIONS = {**SECTIONS, "mechanism": _Mechanism, "cube": _Cube, "requirements": _Requirements}


@dataclass(frozen=True)
class Lengths:
    """A delta of which lengths are known.

    Attributes:
        design: Those of its mechanism and the cube; the rest is left out or bounds nothing.
        collars_m: d + e: how much farther apart elbow and wrist are than the ends of the bars, in the arm's plane, m.
        difference_mm: R - r, where that is all that is known of both; else None.
    """

    design: Design
    collars_m: float
    difference_mm: float | None


def load_lengths(path: Path) -> Lengths:
    """Reads and validates a file of lengths.

    Args:
        path: JSON file, UTF-8; a design file is one, too.

    Raises:
        DesignError: Unreadable, a length that is missing, unknown, out of its bounds or stated twice, or lengths that
            cannot go together.
    """
    try:
        data = read_json(path, MOST_BYTES, finite=False)
    except ReadError as error:
        raise DesignError(error.file, error.field, error.value, error.allowed) from None
    return lengths_from_dict(data, path.name)


def lengths_from_dict(data: object, file: str = "lengths") -> Lengths:
    """Validates lengths given as plain data; errors as those of `load_lengths`."""
    difference = None
    if isinstance(data, Mapping):
        data = {"schema": SCHEMA, **{key: value for key, value in data.items() if key not in _LEFT_OUT}}
        if isinstance(stated := data.get("requirements"), Mapping):
            free = ("envelope_width_mm", "envelope_depth_mm")
            data["requirements"] = {key: value for key, value in stated.items() if key not in free}
        if isinstance(lengths := data.get("mechanism"), Mapping):
            data["mechanism"], difference = _by_radii(lengths, file)
    design: Any = record_of(_Design, _SECTIONS, data, file)
    m = design.mechanism
    collars = (m.collar_elbow_mm + m.collar_wrist_mm) / MM_PER_M
    # with collars the closed forms of a sphere do not hold: who computes figures finds a point out of reach
    if not collars and (faults := contradictions(design, kinematics=True)):
        first, *more = [DesignError(file, fault.field, short(fault.value), fault.allowed) for fault in faults]
        first.more = tuple(map(str, more))
        raise first
    return Lengths(design, collars, difference)


def _by_radii(stated: Mapping[str, Any], file: str) -> tuple[dict[str, Any], float | None]:
    """Gives a mechanism with its radii for what other projects have in their place, and R - r where that is all."""
    found = dict(stated)
    for part in ("base", "platform"):
        side, at, radius = f"{part}_side_mm", f"{part}_joints_at", f"{part}_radius_mm"
        where = found.pop(at, None)
        if side not in found:
            if where is not None:
                raise DesignError(file, f"mechanism.{at}", short(where), f"needs mechanism.{side}, the triangle's side")
            continue
        _alone(found, side, (radius, *(("base_radii_mm",) if part == "base" else ())), file)
        if where not in _AT:
            must = f'"corners" or "middles", where the joints stand on the triangle of {side}'
            allowed = f"is missing; must be {must}" if where is None else f"must be {must}"
            raise DesignError(file, f"mechanism.{at}", "" if where is None else short(where), allowed)
        length = _number(found.pop(side), side, MOST_MM / _AT[where], file)
        found[radius] = length * _AT[where]
    if _DIFFERENCE not in found:
        return found, None
    _alone(found, _DIFFERENCE, ("base_radius_mm", "platform_radius_mm", "base_radii_mm"), file)
    difference = _number(
        found.pop(_DIFFERENCE), _DIFFERENCE, MOST_MM - _LEAST_RADIUS_MM, file, low=_LEAST_RADIUS_MM - MOST_MM
    )
    platform = _LEAST_RADIUS_MM + max(0.0, -difference)
    return found | {"platform_radius_mm": platform, "base_radius_mm": platform + difference}, difference


def _alone(found: Mapping[str, Any], field: str, others: tuple[str, ...], file: str) -> None:
    """Refuses a length that stands beside another for the same."""
    for other in others:
        if other in found:
            allowed = f"stands for mechanism.{other} = {short(found[other])}: leave one of both out"
            raise DesignError(file, f"mechanism.{field}", short(found[field]), allowed)


def _number(value: object, field: str, most: float, file: str, low: float = 0.0) -> float:
    """Reads a length; refuses what is no number within its bounds."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and low < value <= most:
        return float(value)
    raise DesignError(file, f"mechanism.{field}", short(value), f"must be a number > {low:g} and <= {most:.6g} mm")
