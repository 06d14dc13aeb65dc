"""The structural results of one design: stiffness, first mode and loads over the cube, and `structure.json`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.structure.beam_model import BeamModel, beam_model, with_new_rope
from delta_cad.structure.compliance import Compliance, Softest, compliance, softest
from delta_cad.structure.loads import GRID, Load, loads, part_loads, sampled_mm
from delta_cad.structure.modes import Moving, first_mode_Hz, moving
from delta_cad.structure.strength import LIFE_HOURS, STROKES_PER_S, allowables

_SCHEMA = "delta-structure/1"
_REPORTED = 5  # positions along an edge in the file
_DIGITS = 6  # significant digits in the file
LEFT_OUT = "what the machine stands on, faces of screw joints, slits of clamps, play"  # of the stiffness


@dataclass(frozen=True)
class KnobStiffness:
    """Stiffness over the sampled cube.

    Attributes:
        table: The machine.
        positions_mm: (n, 3) sampled, the centre last.
        given: Flexibility there.
        softest: Least stiffness at the knob there, with its direction and shares, its cables settled.
        new: The same with new cables, by which a limit is judged.
    """

    table: BeamModel
    positions_mm: np.ndarray
    given: Compliance
    softest: Softest
    new: Softest

    @property
    def worst(self) -> int:
        """Number of the softest position."""
        return int(np.argmin(self.softest.stiffness_N_mm))

    @property
    def least_N_mm(self) -> float:
        """Least stiffness over the cube, with new cables: the lower end of the band that limits are judged by."""
        return float(self.new.stiffness_N_mm.min())

    def at(self, k: int) -> dict[str, Any]:
        """Tells the stiffness at a position as JSON types."""
        s = self.softest
        return {
            "position_mm": _plain(self.positions_mm[k]),
            "softest_N_mm": _plain(s.stiffness_N_mm[k]),
            "softest_new_N_mm": _plain(self.new.stiffness_N_mm[k]),
            "direction": _plain(s.direction[k]),
            "shares": {name: _plain(share[k]) for name, share in s.shares.items()},
        }


def stiffness(d: Dimensions, count: int = GRID) -> KnobStiffness:
    """Computes the stiffness at the knob over the cube; needs no solids.

    Args:
        d: Dimensions of the design.
        count: Positions along an edge of the cube; its corners are among them.
    """
    table, cube = beam_model(d), d.design.workspace
    positions = np.concatenate([sampled_mm(cube, count), [cube.centre * MM_PER_M]])
    given = compliance(table, positions)
    settled = softest(given.at_knob())
    new = settled if table.cable is None else softest(compliance(with_new_rope(table), positions).at_knob())
    return KnobStiffness(table, positions, given, settled, new)


@dataclass(frozen=True)
class StructureReport:
    """Structural results of a machine.

    Attributes:
        stiffness: Over the cube.
        modes_Hz: (n,) first mode at the positions of `stiffness`, nothing held in the hand.
        cases: Load case, "for ever" or "peak" -> its force in N and the loads.
    """

    stiffness: KnobStiffness
    modes_Hz: np.ndarray
    cases: dict[str, tuple[float, list[Load]]]


def structure_report(d: Dimensions, bodies: Mapping[str, Any]) -> StructureReport:
    """Computes stiffness, first mode and loads of a design.

    Args:
        d: Its dimensions.
        bodies: `bodies` of its mass report.
    """
    over, required = stiffness(d), d.design.requirements
    what: Moving = moving(bodies, d.design.geometry.forearm_length)
    limits, gravity = allowables(d), np.array(required.gravity_m_s2)
    forces = {"for ever": required.force_N}
    if required.peak_force_N is not None:
        forces["peak"] = required.peak_force_N
    cases, lasting = {}, None
    for case, force in forces.items():
        given = part_loads(over.table, what, over.positions_mm, force, gravity)
        found = loads(over.table, limits, over.positions_mm, given, lasting)
        lasting = given
        # life is of what lasts, and so is what springs may lack: at a peak the contact may touch its cup's lip, from
        # which the load itself points more than 20 degrees away (`ball joint`, judged at a peak, too)
        cases[case] = (force, [load for load in found if case == "for ever" or not load.least])
    return StructureReport(over, first_mode_Hz(over.table, what, over.positions_mm), cases)


def structure_record(d: Dimensions, whole: StructureReport) -> dict[str, Any]:
    """Gives the structural results as JSON types: `structure.json`."""
    over = whole.stiffness
    coarse = stiffness(d, _REPORTED)
    matrices = np.linalg.inv(np.sum(list(coarse.given.at_knob().values()), axis=0))
    worst, centre = over.worst, len(over.positions_mm) - 1
    slowest = int(np.argmin(whole.modes_Hz))
    return {
        "schema": _SCHEMA,
        "knob_over_wrists_mm": _plain(over.table.knob_mm),
        "grid": GRID,
        "assumed": {
            "joint_N_mm": over.table.joint_N_mm,
            "left_out": LEFT_OUT,
        },
        "centre": over.at(centre) | {"first_mode_Hz": _plain(whole.modes_Hz[centre])},
        "softest": over.at(worst),
        "band_N_mm": [_plain(over.least_N_mm), _plain(over.softest.stiffness_N_mm[worst])],
        "slowest": {
            "position_mm": _plain(over.positions_mm[slowest]),
            "first_mode_Hz": _plain(whole.modes_Hz[slowest]),
        },
        "stiffness_N_mm": [
            {"position_mm": _plain(p), "matrix": _plain(k)} for p, k in zip(coarse.positions_mm, matrices, strict=True)
        ],
        "duty": {"life_hours": LIFE_HOURS, "strokes_per_s": STROKES_PER_S},
        "loads": [
            {"case": case, "force_N": force}
            | {key: _plain(value) for key, value in asdict(load).items() if key != "least"}
            | {"margin": _plain(load.margin), "holds": bool(load.holds)}
            for case, (force, all_) in whole.cases.items()
            for load in all_
        ],
    }


def _plain(value: Any) -> Any:
    """Numbers and arrays as JSON types with few digits; text as it is."""
    if isinstance(value, str):
        return value
    if np.ndim(value):
        return [_plain(one) for one in value]
    return value if isinstance(value, int) else float(f"{float(value):.{_DIGITS}g}")
