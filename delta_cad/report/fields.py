"""Figures that differ from one position of the cube to another: their worst, their centre's, and maps of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from delta_cad.checks.clearance.clearance import MAP_CELLS
from delta_cad.checks.range.holding import holding_torque, moving_bodies
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.dimensions.joint import known_joints
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import masses_from_dict
from delta_cad.mechanism.limits import HandleFriction, HandleInertia
from delta_cad.mechanism.limits.effective_mass import effective_mass
from delta_cad.mechanism.limits.friction import friction
from delta_cad.mechanism.limits.position_step import position_step
from delta_cad.mechanism.statics import conditioning, worst_joint_torque
from delta_cad.report.subject import Subject, plain
from delta_cad.structure.beam_model import beam_model, with_new_rope
from delta_cad.structure.compliance import compliance, softest
from delta_cad.structure.loads import GRID, sampled_mm
from delta_cad.structure.modes import first_mode_Hz, moving

CELLS = 17  # positions along an edge of a slice, both edges among them
_DIGITS = 4  # significant digits in a map


@dataclass(frozen=True)
class Field:
    """A figure over the cube.

    Attributes:
        name: Key in the page.
        words: What a person reads.
        unit: Unit; "" for none.
        upper: Whether large is bad.
        limit: What is asked of it; None if nothing is.
        values: (n, 3) positions in mm -> (n,) figures in `unit`.
        drawn: Whether a map of it is drawn.
        note: How it is meant.
        sampled_mm: (m, 3) positions at which its worst is sought.
    """

    name: str
    words: str
    unit: str
    upper: bool
    limit: float | None
    values: Callable[[np.ndarray], np.ndarray]
    drawn: bool
    note: str
    sampled_mm: np.ndarray

    def worst(self) -> tuple[float, np.ndarray]:
        """Computes the worst of the sampled values, and finds its position, mm; what has no value is worst."""
        values = self.values(self.sampled_mm)
        values = np.where(np.isnan(values), np.inf if self.upper else -np.inf, values)
        k = int(np.argmax(values) if self.upper else np.argmin(values))
        return float(values[k]), self.sampled_mm[k]


@dataclass(frozen=True)
class Handle:
    """What the figures at the handle need to know of a machine.

    Attributes:
        inertia: What moves.
        friction: What rubs; None where it is not known.
        encoder_count_rad: Turn of a joint for one count of its encoder.
    """

    inertia: HandleInertia
    friction: HandleFriction | None
    encoder_count_rad: float | None


def handle_of(s: Subject) -> Handle:
    """Gathers what the figures at the handle need."""
    design: Design = s.design
    masses = masses_from_dict(s.masses, design.geometry.forearm_length, drive_torque(design))
    known: dict[str, Any] = known_joints(design)
    return Handle(masses.handle_inertia, known["friction"], known["encoder_count"])


def fields(s: Subject, handle: Handle) -> list[Field]:
    """Lists the figures of a machine whose whole cube is within reach; one that is not known is left out."""
    g, required, limits = s.design.geometry, s.design.requirements, s.limits
    table, what = beam_model(s.dimensions), moving(s.masses["bodies"], g.forearm_length)
    new = with_new_rope(table)
    bodies, gravity = moving_bodies(s.masses), np.array(required.gravity_m_s2)
    all_mm = limits.poses_mm()
    coarse_mm = sampled_mm(limits.workspace, GRID)

    def torque(p: np.ndarray) -> np.ndarray:
        held = np.abs(holding_torque(s.assembly, bodies, p, gravity))
        return (held + worst_joint_torque(g, p / MM_PER_M, required.force_N)).max(axis=-1)

    def stiffness(p: np.ndarray) -> np.ndarray:
        return softest(compliance(new, p).at_knob()).stiffness_N_mm

    found = [
        Field(
            "kappa", "Conditioning", "", True, required.kappa_max, lambda p: conditioning(g, p / MM_PER_M), True,
            "Condition number of the Jacobian: 1 where forces and motions are alike in all directions.", all_mm,
        ),
        Field(
            "effective_mass", "Effective mass", "kg", True, required.effective_mass_max_kg,
            lambda p: effective_mass(g, p / MM_PER_M, handle.inertia), True,
            "What the hand accelerates, in its heaviest direction.", all_mm,
        ),
        Field(
            "stiffness", "Stiffness at the knob", "N/mm", False, required.stiffness_min_N_mm, stiffness, True,
            f"Softest direction, {table.knob_mm:g} mm over the wrists, actuators held, cables new.", coarse_mm,
        ),
        Field(
            "torque", "Joint torque", "N m", True, required.joint_torque_N_m, torque, True,
            f"{required.force_N:g} N in the worst direction and the weight, at the joint that takes most.", all_mm,
        ),
        Field(
            "first_mode", "First mode", "Hz", False, None, lambda p: first_mode_Hz(table, what, p), False,
            "Actuators held, no hand.", coarse_mm,
        ),
    ]  # fmt: skip
    rubs, count = handle.friction, handle.encoder_count_rad
    if rubs is not None:
        found.insert(2, Field(
            "friction", "Friction", "N", True, required.friction_max_N, lambda p: friction(g, p / MM_PER_M, rubs), True,
            "At most, nominal coefficients; the ball joints' share is bounded over the whole cube.", all_mm,
        ))  # fmt: skip
    if count is not None:
        found.append(Field(
            "position_step", "Position step", "mm", True, required.position_step_max_mm,
            lambda p: MM_PER_M * position_step(g, p / MM_PER_M, count), False,
            "How far the handle may move unseen by the encoders.", all_mm,
        ))  # fmt: skip
    return found


def maps(s: Subject, over: list[Field]) -> dict[str, Any]:
    """Samples the drawn figures over slices of the cube, as JSON types.

    Returns:
        `z_mm` (SLICES,), and `maps`: of each figure its words, `x_mm` (n,), of y the same, and `values`, (SLICES, n
        along y, n along x); of the clearance what is closest, too.
    """
    slices = s.limits.slices_mm(CELLS)
    positions = slices.reshape(-1, 3)
    found = [
        {
            "name": field.name,
            "words": field.words,
            "unit": field.unit,
            "upper": field.upper,
            "limit": field.limit,
            "note": field.note,
            "x_mm": plain(slices[0, 0, :, 0], 6),
            "y_mm": plain(slices[0, :, 0, 1], 6),
            "values": plain(field.values(positions).reshape(slices.shape[:3]), _DIGITS),
        }
        for field in over
        if field.drawn
    ]
    return {"z_mm": plain(slices[:, 0, 0, 2], 6), "maps": [*found, *_clearance(s)] if over else []}


def _clearance(s: Subject) -> list[dict[str, Any]]:
    """The map of what is closest, where the checks told it: `pairs` beside `values` are indices of `names`."""
    if not s.near:
        return []
    slices = s.limits.slices_mm(MAP_CELLS)
    names = list(dict.fromkeys(" / ".join(one.names) for one in s.near))
    least = min(s.near, key=lambda one: one.distance_mm)
    reported = (
        "Least distance of two bodies that more than one joint moves against each other, rods turned as far as they go."
    )
    whole = next((f"; of all bodies {r.value:.3g} mm" for r in s.results if r.name == "clearance" and r.value), "")
    return [
        {
            "name": "clearance",
            "words": "Clearance",
            "unit": "mm",
            "upper": False,
            "limit": s.limits.clearance_min_mm,
            "note": f"{reported} Closest: {' / '.join(least.names)}{whole}.",
            "x_mm": plain(slices[0, 0, :, 0], 6),
            "y_mm": plain(slices[0, :, 0, 1], 6),
            "values": plain(np.reshape([one.distance_mm for one in s.near], slices.shape[:3]), _DIGITS),
            "names": names,
            "pairs": np.reshape([names.index(" / ".join(one.names)) for one in s.near], slices.shape[:3]).tolist(),
        }
    ]
