"""Loads of every part for a force on the knob in its worst direction, with gravity, against the allowable loads.

For a force of any direction a load that is one number is `|g| F + |w|`, g its row for unit forces and w what the weight
makes of it; of two numbers at once (a bearing's radial load) the largest stretch of the two rows takes the place of
|g|, which is not below what is. Positions are sampled; the eight corners of the cube are among them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions.capstan import ROPE_FACTOR
from delta_cad.mechanism.inverse import forearm_vectors, inverse_kinematics
from delta_cad.mechanism.workspace import Cube, cube_grid
from delta_cad.structure.beam_model import BeamModel
from delta_cad.structure.bearing import dynamic_equivalent_N, life_hours, static_equivalent_N
from delta_cad.structure.modes import Moving
from delta_cad.structure.rod_end import bond_tilt_N_mm2, contact_N_mm2, spigot_bending_N_mm2
from delta_cad.structure.strength import LIFE_HOURS, STROKES_PER_S, Allowables
from delta_cad.structure.unit_loads import (
    UnitLoads,
    at_knob,
    bearing_map,
    blocks_loads,
    elbows_mm,
    shoulder_map,
    unit_loads,
)

GRID = 9  # positions along an edge of the cube
LEAST_MARGIN = 1.05
"""How many times its load each part must bear: every limit below is what it may bear over this.

A ball joint's angle and preload do not change as its load does: they hold under this times the load.
"""


@dataclass(frozen=True)
class Load:
    """The largest load of a part over the cube.

    Attributes:
        name: What bears it.
        value: In `unit`; the least value of a life.
        limit: What it may be, with `LEAST_MARGIN`; the least it may be where `least`.
        unit: Unit of both.
        position_mm: Where it occurs.
        chain: On which chain.
        source: How it is computed and what the limit comes from.
        least: Whether value must be at least the limit, not at most.
    """

    name: str
    value: float
    limit: float
    unit: str
    position_mm: tuple[float, float, float]
    chain: int
    source: str
    least: bool = False

    @property
    def holds(self) -> bool:
        """Decides whether the load is allowable."""
        return self.value >= self.limit if self.least else self.value <= self.limit

    @property
    def margin(self) -> float:
        """How many times the load could be: limit over load."""
        return self.value / self.limit if self.least else self.limit / self.value if self.value else np.inf


@dataclass(frozen=True)
class PartLoads:
    """Loads of each part, (..., 3 chains) unless stated; forces N, moments N mm.

    Attributes:
        rod: Force of the worse rod.
        radial: (..., 3, 2) of both bearings, encoder's side first; of a direct drive both the motor's shaft's.
        axial: Along the shoulder axis.
        cable: Difference between the strands, or what would be at 1 mm for a direct drive: the torque.
        hub: Moment that tilts the arm on its shaft.
        elbow: Moment that tilts the cross-bar in the arm.
        elbow_along: Force along the cross-bar.
        torque: About the shoulder axis.
    """

    rod: np.ndarray
    radial: np.ndarray
    axial: np.ndarray
    cable: np.ndarray
    hub: np.ndarray
    elbow: np.ndarray
    elbow_along: np.ndarray
    torque: np.ndarray


def sampled_mm(cube: Cube, count: int = GRID) -> np.ndarray:
    """Gives the sampled positions of a cube, corners included, (count^3, 3) mm."""
    return cube_grid(cube, count) * MM_PER_M


def largest(rows: np.ndarray, force_N: float, weight: np.ndarray) -> np.ndarray:
    """Computes the largest length of a load over all directions of a force, or a bound on it.

    Args:
        rows: (..., k, 3) its k components for unit forces.
        force_N: The force.
        weight: (..., k) what the weight makes of it.

    Returns:
        (...) exact for k = 1.
    """
    squares = np.linalg.eigvalsh(rows @ np.swapaxes(rows, -1, -2))[..., -1]
    return np.sqrt(np.maximum(squares, 0.0)) * force_N + np.linalg.norm(weight, axis=-1)


def part_loads(table: BeamModel, what: Moving, p_mm: np.ndarray, force_N: float, gravity_m_s2: np.ndarray) -> PartLoads:
    """Computes the largest loads for a force on the knob.

    Args:
        table: The machine.
        what: What moves, for its weight.
        p_mm: (..., 3) platform's centre, mm.
        force_N: On the knob, in any direction.
        gravity_m_s2: (3,) in the base frame.
    """
    unit = unit_loads(table, p_mm)
    lift, weight = at_knob(table.knob_mm), _platform_weight(table, what, gravity_m_s2)
    rods = (unit.rods @ lift)[..., None, :]
    rod = largest(rods, force_N, (unit.rods @ weight)[..., None]).max(axis=-1)
    elbow_rows = unit.elbows @ lift
    elbow_weight = unit.elbows @ weight + _turned_weight(unit, what.rod_kg, np.zeros(3), gravity_m_s2)
    lever = shoulder_map(table)
    rows = lever @ elbow_rows
    at_shoulder = (lever @ elbow_weight[..., None])[..., 0]
    at_shoulder = at_shoulder + _turned_weight(unit, what.arm.mass_kg, what.arm.centre_mm, gravity_m_s2)

    def over(which: list[int], rows: np.ndarray = rows, weight: np.ndarray = at_shoulder) -> np.ndarray:
        return largest(rows[..., which, :], force_N, weight[..., which])

    if table.shoulder is None:
        radial = np.stack([over([0, 2])] * 2, axis=-1)
        cable = over([4])
    else:
        held = bearing_map(table, unit.turned)
        on_bearings, by_weight = held @ rows, (held @ at_shoulder[..., None])[..., 0]
        radial = np.stack([over(pair, on_bearings, by_weight) for pair in ([0, 1], [2, 3])], axis=-1)
        cable = over([5], on_bearings, by_weight)
    return PartLoads(
        rod=rod,
        radial=radial,
        axial=over([1]),
        cable=cable,
        hub=over([3, 5]),
        elbow=over([3, 5], elbow_rows, elbow_weight),
        elbow_along=over([1], elbow_rows, elbow_weight),
        torque=over([4]),
    )


def loads(
    table: BeamModel, limits: Allowables, p_mm: np.ndarray, given: PartLoads, between: PartLoads | None = None
) -> list[Load]:
    """Compares the largest loads with the allowable ones.

    Args:
        table: The machine.
        limits: What its parts may bear.
        p_mm: (n, 3) positions.
        given: Loads there.
        between: Loads that last, where the given ones are those of a peak.
    """
    found: list[Load] = []

    def add(
        name: str, value: np.ndarray, limit: float, unit: str, source: str, least: bool = False, in_load: bool = False
    ) -> None:
        pose, chain = np.unravel_index(np.argmin(value) if least else np.argmax(value), value.shape)
        x, y, z = (float(v) for v in p_mm[pose])
        margin = 1.0 if in_load else LEAST_MARGIN
        bound = limit * margin if least else limit / margin
        found.append(Load(name, float(value[pose, chain]), bound, unit, (x, y, z), int(chain), source, least))

    h = limits
    add("rod buckling", given.rod, h.buckling_N, "N", "a third of Euler's load between the balls")
    _add_ends(add, table, h, p_mm, given)
    bond = "even shear on the spigot; epoxy on sanded aluminium, a tenth of what it bears at once"
    add("rod bond", given.rod / h.bond_mm2, h.bond_N_mm2, "N/mm^2", bond)
    root = "bending 32 F a / (pi d^3) in pin or neck, the rod square to the stud (Roark); proof stress of 7075"
    add("stud", given.rod * h.stud_1_mm2, h.stud_N_mm2, "N/mm^2", root)
    how = "F b / 6" if table.stub is not None else "F (Ro^2 + Ri^2) / (4 Ro)"
    add("shoulder seat", given.hub, h.hub_N_mm, "N mm", f"opens at one edge at {how}, F of a stainless screw, VDI 2230")
    sheared = given.elbow * h.bar_1_mm3 + given.elbow_along / h.bar_mm2
    glued = "tilt 6 M / (d b^2) and force along it, retaining compound on primed aluminium"
    add("cross-bar bond", sheared, h.bar_N_mm2, "N/mm^2", glued)
    layers = "across the layers of the print, for ever: a quarter of their strength"
    if h.arm_1_mm3 is not None:
        bent = given.hub * h.arm_1_mm3[0] + given.torque * h.arm_1_mm3[1]
        add("printed arm", bent, h.arm_N_mm2, "N/mm^2", f"tilt and torque in its root, 6 M / (b h^2); {layers}")
    if h.grip_N_mm is not None:
        add(
            "printed arm's grip",
            given.torque,
            h.grip_N_mm,
            "N mm",
            "torque on the motor's shaft; what of the clamp is left after creep, friction of its two halves, F mu d",
        )
    if h.spoke_1_mm3 is not None:
        bent = (given.elbow + given.rod * 2.0 * table.spoke_up_mm) * h.spoke_1_mm3
        bent = bent + given.rod * 2.0 * table.geometry.platform_radius * MM_PER_M * h.spoke_1_mm3
        add("printed platform", bent, h.spoke_N_mm2, "N/mm^2", f"both rods' forces at the hub, 6 M / (b h^2); {layers}")
    lasts = "of its row, else RE 30's 28 N by the area; at peaks the mean of ISO 281 with what lasts between them"
    if (
        h.bearing is None
        or table.cable is None
        or h.setting is None
        or h.cable_N is None
        or h.sector_mm is None
        or h.pinion_N is None
    ):
        across = given.radial[..., 0]
        rest = across if between is None else between.radial[..., 0]
        add("motor shaft", _lasting(h, across, rest), h.motor_N, "N", f"the arm's whole load; {lasts}")
        if h.stub_mm is not None:
            stress = 32.0 * (given.hub + across * h.stub_lever_mm) / (np.pi * h.stub_mm**3)
            add(
                "motor shaft bending", stress, h.stub_N_mm2, "N/mm^2", "tilt and load at the motor's face; proof stress"
            )
    else:
        psi, turned = table.cable.across_rad, inverse_kinematics(table.geometry, p_mm / MM_PER_M) - h.middle_rad

        def strands(of: PartLoads) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            """Tight strand; what both pull sector and pinion together by; what the pinion's shaft bears across."""
            slack, tight = h.setting.strands_N(turned, of.cable)  # type: ignore[union-attr]
            together = (slack + tight) * np.sin(psi)
            return tight, together, np.hypot(together, of.cable * np.cos(psi))

        tight, together, across = strands(given)
        rest = across if between is None else strands(between)[2]
        add("motor shaft", _lasting(h, across, rest), h.motor_N, "N", f"both strands at their tightest; {lasts}")
        tilt = across * h.motor_mm / (h.motor_screws * h.motor_edge_mm)
        how = "tilt over the motor's edge by the strands, and slip by its torque; clamping force, VDI 2230"
        add("motor screw", tilt + given.cable * h.motor_slip, h.motor_screw_N, "N", how)
        grip = "difference of the strands; friction of both tips on the shaft by the torque that the manual states"
        add("pinion's set screws", given.cable, h.pinion_N, "N", grip)
        how = "tight strand of the tightest setting, by friction along its drums"
        add("cable", tight, h.cable_N, "N", f"{how}; breaking load over {ROPE_FACTOR}")
        counts = given.cable * h.setting.proven_N / h.setting.held_N(turned)
        how = "difference of the strands, referred to the angle at which the cable is set; limit: what setting proves"
        add("cable's slip", counts, h.setting.proven_N, "N", how)
        pin = given.torque / (h.sector_mm * h.sector_pins)
        add("sector dowel", pin, h.sector_N, "N", "the torque on the dowels alone; half the proof stress of 6082")
        static_by = given.axial[..., None]
        radial = given.radial + together[..., None]  # the strands press the shoulder, too
        static = np.vectorize(static_equivalent_N)(radial, static_by).max(axis=-1)
        add("shoulder bearing", static, h.bearing.static_N, "N", "ISO 76 static equivalent load; C0 of its row")
        add("shoulder preload", given.axial, h.preload_N, "N", "axial load; above it one bearing runs free")
        dynamic = np.vectorize(dynamic_equivalent_N)(radial, static_by).max(axis=-1)
        life = np.vectorize(lambda p: life_hours(h.bearing, p, h.stroke_rad, STROKES_PER_S))(dynamic)  # type: ignore[arg-type]
        duty = f"ISO 281 L10, {STROKES_PER_S:g} full strokes a second at the worst place under the whole force"
        add("shoulder bearing life", life, LIFE_HOURS, "h", duty, least=True)
        worst = radial.max(axis=-1)
        pins = worst * (h.foot_mm / h.foot_pins_mm + 0.5)
        add(
            "cheek dowel", pins, h.foot_pin_N, "N", "the radial load's moment on the dowels alone; half of proof stress"
        )
    side = given.axial * h.foot_mm / (2.0 * h.foot_edge_mm)
    add(
        "cheek screw",
        side,
        h.foot_screw_N,
        "N",
        "tilt over the block's edge by the axial load; clamping force, VDI 2230",
    )
    total = given.radial.sum(axis=-1)
    base = total * h.base_mm / (2.0 * h.base_edge_mm)
    add("base screw", base, h.base_screw_N, "N", "tilt over the foot's end by both bearings; clamping force, VDI 2230")
    return found


def _add_ends(add: Callable[..., None], table: BeamModel, h: Allowables, p_mm: np.ndarray, given: PartLoads) -> None:
    """Adds what the ball joints and the rods' ends bear, pose by pose with the lean that each rod has there."""
    f, rod = h.forearm, given.rod
    along = forearm_vectors(table.geometry, p_mm / MM_PER_M) / table.geometry.forearm_length
    lean = np.arcsin(np.clip((along * table.geometry.tangential).sum(axis=-1), -1.0, 1.0))
    j, most = f.joint, LEAST_MARGIN * rod
    add(
        "ball joint",
        np.degrees(j.edge_rad(most, lean)),
        float(np.degrees(j.wrap_rad)),
        "deg",
        f"where {LEAST_MARGIN:g} times the load points in its cup, and half of the contact; the cup's lip",
        in_load=True,
    )
    left = "preload less that with which the contact would reach the cup's lip; a tenth, which springs may lack"
    preload = j.margin_preload_N(most, lean)
    add("ball joint preload", preload, h.preload_reserve_N, "N", left, least=True, in_load=True)
    pressed = j.pressed_max_N + rod
    shell = "Hertz, preload and rod force in one line; a quarter of the plastic's yield stress, for ever"
    add("cup shell", contact_N_mm2(f, pressed), h.plastic_N_mm2, "N/mm^2", shell)
    bending = "the springs' preload for ever, 32 P x / (pi d^3) at the tube, and the rod's force; half of proof stress"
    add("rod end bending", spigot_bending_N_mm2(f, rod), h.end_N_mm2, "N/mm^2", bending)
    tilt = "the preload's moment, 6 M / (d b^2), and the rod's force; a quarter of the epoxy's strength, for ever"
    add("rod bond, tilt", bond_tilt_N_mm2(f, rod), h.tilt_N_mm2, "N/mm^2", tilt)


def _lasting(h: Allowables, load: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """Mean of a load at peaks and the largest of what lasts between them, which a ball bearing's life counts as equal.

    Source: ISO 281, cube root of the mean of the cubes; peaks last as long as the motor's winding bears them.
    """
    return np.cbrt(h.peak_share * load**3 + (1.0 - h.peak_share) * max(rest.max(), 0.0) ** 3)


def _platform_weight(table: BeamModel, what: Moving, gravity_m_s2: np.ndarray) -> np.ndarray:
    """Wrench of the platform's weight, with the rods' halves at its wrists, (6,) N and N mm."""
    own, halves = what.platform.mass_kg * gravity_m_s2, what.rod_kg * gravity_m_s2
    wrists = table.geometry.platform_radius * MM_PER_M * table.geometry.radial.sum(axis=0)
    moment = np.cross(what.platform.centre_mm, own) + np.cross(wrists, halves)
    return np.concatenate([own + 3.0 * halves, moment])


def _turned_weight(unit: UnitLoads, mass_kg: float, at_mm: np.ndarray, gravity_m_s2: np.ndarray) -> np.ndarray:
    """Wrench of a weight about the origin of the arm's axes it is fixed to, (..., 3, 6)."""
    force = unit.arms @ (mass_kg * gravity_m_s2)
    return np.concatenate([force, np.cross(np.broadcast_to(at_mm, force.shape), force)], axis=-1)


def screw_pull_N(table: BeamModel, p_mm: np.ndarray, force_N: float, weight_N: float) -> np.ndarray:
    """Computes the largest pull on one of the screws that hold the base down, (...) N.

    Args:
        table: A machine that is screwed down.
        p_mm: (..., 3) platform's centre.
        force_N: Force at the knob, in its worst direction.
        weight_N: Weight of the machine, all of which this screw is taken to bear.
    """
    assert table.mounting is not None
    unit = unit_loads(table, p_mm)
    loads = blocks_loads(table.mounting.to_blocks(elbows_mm(table, unit), unit.arms), unit) @ at_knob(table.knob_mm)
    return force_N * np.linalg.norm(table.mounting.reactions @ loads, axis=-1).max(axis=-1) + weight_N
