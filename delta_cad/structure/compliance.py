"""Stiffness at platform and knob with locked actuators: each part's flexibility under its share of a unit load.

`C = sum G_e^T c_e G_e` (unit load method, Timoshenko and Gere): c_e is the flexibility of element e, G_e what it bears
for a unit wrench. No play, small motions, a loaded joint as stiff in tension as in compression.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from delta_cad.structure.beam import Beam, flexibility, flexibility_by_kind
from delta_cad.structure.beam_model import BeamModel, CableSpring
from delta_cad.structure.unit_loads import (
    UnitLoads,
    at_knob,
    bearing_map,
    blocks_loads,
    elbows_mm,
    shoulder_map,
    unit_loads,
)

ELEMENTS = (
    "joints",
    "rods",
    "studs and bars",
    "arm torsion",
    "arm lateral",
    "arm in plane",
    "bearings",
    "cheeks",
    "shaft",
    "cable",
    "platform",
    "base plate",
    "bench plate",
    "supports",
    "stem",
)
_KINDS = {"arm torsion": [3], "arm lateral": [1, 5], "arm in plane": [0, 2, 4]}  # of `beam.AXES`


@dataclass(frozen=True)
class Compliance:
    """Flexibility of the machine at positions of the platform.

    Attributes:
        parts: Element -> (..., 6, 6) its share of the platform's flexibility, about the wrists' plane's centre, base
            axes; the stem's is not in it.
        knob_mm: Height of the knob over the wrists.
        stem: (3, 3) what the stem adds at the knob, mm/N.
        elbows: (..., 3, 6, 6) motion of each elbow's middle by a unit wrench on the platform, arm's axes.
        blocks: (..., 18, 6) motion of the foot blocks likewise, base axes; zeros on a rigid base.
    """

    parts: dict[str, np.ndarray]
    knob_mm: float
    stem: np.ndarray
    elbows: np.ndarray
    blocks: np.ndarray

    @property
    def platform(self) -> np.ndarray:
        """(..., 6, 6) flexibility of the platform, mm/N, rad/N, rad/(N mm)."""
        return np.sum(list(self.parts.values()), axis=0)

    @np.errstate(invalid="ignore")
    def at_knob(self) -> dict[str, np.ndarray]:
        """Computes each element's share of the flexibility at the knob, (..., 3, 3) mm/N."""
        lift = at_knob(self.knob_mm)
        shares = {name: lift.T @ part @ lift for name, part in self.parts.items()}
        first = next(iter(shares.values()))
        return shares | {"stem": np.broadcast_to(self.stem, first.shape)}


@dataclass(frozen=True)
class Softest:
    """The softest direction at positions.

    Attributes:
        stiffness_N_mm: (...) force over displacement in the direction that gives most; 0 where nothing holds.
        direction: (..., 3) that direction, a unit vector in the base frame.
        shares: Element -> (...) its share of what gives, 0 to 1.
    """

    stiffness_N_mm: np.ndarray
    direction: np.ndarray
    shares: dict[str, np.ndarray]


def cable_mm_N(cable: CableSpring, turned: np.ndarray) -> np.ndarray:
    """Computes how far the rim moves along the cable for 1 N of difference between its strands, mm/N.

    Both strands are held by the pinion's wraps and by their lugs: two springs E A / L side by side, then rim and
    motor's shaft.

    Args:
        cable: The cable.
        turned: (..., 2) cosine and sine of the shoulder angle.
    """
    theta = np.arctan2(turned[..., 1], turned[..., 0])
    low, high = cable.ends_rad
    middle = (low + high) / 2.0
    pinion = middle + np.mod(cable.direction_rad - theta - middle + np.pi, 2.0 * np.pi) - np.pi
    first = cable.radius_mm * (pinion - low) + cable.beyond_mm[0]
    second = cable.radius_mm * (high - pinion) + cable.beyond_mm[1]
    return 1.0 / (cable.rope_N * (1.0 / first + 1.0 / second)) + cable.sector_mm_N + cable.motor_mm_N


def _elbow_flexibility(table: BeamModel, turned: np.ndarray) -> dict[str, np.ndarray]:
    """Computes the flexibility of an elbow, the motor held, by what gives.

    Args:
        table: The machine.
        turned: (..., 2) cosine and sine of the shoulder angle.

    Returns:
        Element -> (..., 6, 6) motion of the elbow's middle by a wrench on it, arm's axes.
    """
    shape = turned.shape[:-1]
    kinds = flexibility_by_kind(table.arm)
    found = {name: np.broadcast_to(kinds[picked].sum(axis=0), (*shape, 6, 6)) for name, picked in _KINDS.items()}
    lever = shoulder_map(table)
    if table.stub is not None:
        # the motor's shaft: a bar along y from the motor, its x, y, z along y, x, -z of the arm
        axes = np.zeros((6, 6))
        for block in (0, 3):
            axes[block, block + 1], axes[block + 1, block], axes[block + 2, block + 2] = -1.0, 1.0, 1.0
        stub = axes.T @ flexibility(table.stub) @ axes
        found |= {"shaft": np.broadcast_to(lever.T @ stub @ lever, (*shape, 6, 6))}
        if table.motor_cheek is None:
            return found
        to_cheek = _to_motor_cheek(turned, table.motor_cheek_mm) @ lever
        return found | {"cheeks": np.swapaxes(to_cheek, -1, -2) @ flexibility(table.motor_cheek) @ to_cheek}
    shoulder, cable = table.shoulder, table.cable
    assert shoulder is not None
    assert cable is not None
    held = bearing_map(table, turned) @ lever
    cheeks = np.stack([flexibility(cheek) for cheek in shoulder.cheeks])  # x up, y along the axis, z inwards
    up, aside, inwards = cheeks[:, 0, 0], cheeks[:, 1, 1], cheeks[:, 2, 2]

    def squares(weights: np.ndarray) -> np.ndarray:
        return np.swapaxes(held, -1, -2) @ (weights[..., None] * held)

    def diagonal(radial: tuple[float, float], axial: float, along_cable: np.ndarray) -> np.ndarray:
        weights = np.array([radial[0], radial[0], radial[1], radial[1], axial, 0.0])
        weights = np.broadcast_to(weights, (*shape, 6)).copy()
        weights[..., 5] = along_cable
        return weights

    zero = np.zeros(shape)
    # along the axis the two cheeks stand side by side, each behind its bearing; the share of either is by force squared
    each = 1.0 / (1.0 / shoulder.axial_N_mm + aside)
    carried = each / each.sum()
    by_bearing = float((carried**2).sum() / shoulder.axial_N_mm)
    by_cheek = float((carried**2 * aside).sum())
    one = 1.0 / shoulder.radial_N_mm
    found["bearings"] = squares(diagonal((one, one), by_bearing, zero))
    found["shaft"] = squares(diagonal(shoulder.shaft_mm_N, 0.0, zero))
    found["cable"] = squares(diagonal((0.0, 0.0), 0.0, cable_mm_N(cable, turned)))
    # across the axis a cheek's head gives up and inwards: turned from the arm's axes to the chain's
    cosine, sine = turned[..., 0], turned[..., 1]
    across = np.zeros((*shape, 6, 6))
    for k in range(2):
        x, z = 2 * k, 2 * k + 1
        across[..., x, x] = inwards[k] * cosine**2 + up[k] * sine**2
        across[..., z, z] = inwards[k] * sine**2 + up[k] * cosine**2
        across[..., x, z] = across[..., z, x] = (up[k] - inwards[k]) * sine * cosine
    across[..., 4, 4] = by_cheek
    found["cheeks"] = np.swapaxes(held, -1, -2) @ across @ held
    return found


def _to_motor_cheek(turned: np.ndarray, along_mm: float) -> np.ndarray:
    """Moves a wrench on the arm's hub to the cheek of a direct drive's motor, (..., 6, 6).

    Args:
        turned: (..., 2) cosine and sine of the shoulder angle.
        along_mm: From the arm's middle to the cheek's along the shoulder axis.

    Returns:
        From arm's axes to x up, y along the shoulder axis, z inwards.
    """
    cosine, sine, zero = turned[..., 0], turned[..., 1], np.zeros(turned.shape[:-1])
    rows = [[sine, zero, cosine], [zero, zero + 1.0, zero], [-cosine, zero, sine]]
    turn = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    found = np.zeros((*turn.shape[:-2], 6, 6))
    found[..., :3, :3] = found[..., 3:, 3:] = turn
    lever = np.array([[0.0, 0.0, -along_mm], [0.0, 0.0, 0.0], [along_mm, 0.0, 0.0]])  # (0, -along, 0) x force
    found[..., 3:, :3] = turn @ lever
    return found


@np.errstate(invalid="ignore")
def compliance(table: BeamModel, p_mm: np.ndarray) -> Compliance:
    """Computes the flexibility of the machine.

    Args:
        table: The machine.
        p_mm: (..., 3) platform's centre, mm.
    """
    unit = unit_loads(table, p_mm)
    elbow = _elbow_flexibility(table, unit.turned)
    parts = _rods(table, unit)
    for name, part in elbow.items():
        parts[name] = _sum(unit.elbows, part)
    spoke = flexibility(table.spoke)
    lift = np.eye(6)
    lift[3, 1], lift[4, 0] = table.spoke_up_mm, -table.spoke_up_mm  # from the wrists' plane up to the spoke's
    parts["platform"] = _sum(lift @ unit.wrists, spoke)
    moved = np.sum(list(elbow.values()), axis=0) @ unit.elbows
    blocks = np.zeros((*unit.elbows.shape[:-3], 18, 6))
    if table.mounting is not None:
        to_blocks = table.mounting.to_blocks(elbows_mm(table, unit), unit.arms)
        loads = blocks_loads(to_blocks, unit)
        for name, share in table.mounting.shares.items():
            parts[name] = np.swapaxes(loads, -1, -2) @ share @ loads
        blocks = np.sum(list(table.mounting.shares.values()), axis=0) @ loads
        moved = moved + np.swapaxes(to_blocks, -1, -2) @ blocks.reshape(unit.elbows.shape)
    stem = flexibility(table.stem)[:3, :3][np.ix_([1, 2, 0], [1, 2, 0])]  # the bar's x is up
    named = {name: parts[name] for name in ELEMENTS if name in parts}
    return Compliance(named, table.knob_mm, stem, moved, blocks)


def _sum(g: np.ndarray, c: np.ndarray) -> np.ndarray:
    """G^T c G summed over the chains, (..., 6, 6)."""
    return (np.swapaxes(g, -1, -2) @ c @ g).sum(axis=-3)


def _rods(table: BeamModel, unit: UnitLoads) -> dict[str, np.ndarray]:
    """Joints, rods and studs, each (..., 6, 6): all bear a multiple of the rod's force."""
    tension = unit.rods
    squares = (tension[..., None] * tension[..., None, :]).sum(axis=-3)  # (..., 3, 6, 6), both rods
    along = (unit.along * unit.arms[..., 1, :]).sum(axis=-1) ** 2  # square of the cosine against the studs' axis
    elbow = flexibility(Beam((*table.elbow_bar.slices, *table.stud.slices)))
    wrist = flexibility(Beam((*table.wrist_bar.slices, *table.stud.slices)))
    across, axial = elbow[1, 1] + wrist[1, 1], elbow[0, 0] + wrist[0, 0]
    stud = across * (1.0 - along) + axial * along
    total = squares.sum(axis=-3)
    return {
        "joints": 2.0 / table.joint_N_mm * total,
        "rods": flexibility(table.rod)[0, 0] * total,
        "studs and bars": (stud[..., None, None] * squares).sum(axis=-3),
    }


@np.errstate(invalid="ignore")
def softest(parts: dict[str, np.ndarray]) -> Softest:
    """Finds the softest direction for forces.

    Args:
        parts: Element -> (..., 3, 3) its share of a flexibility, mm/N.
    """
    total = np.sum(list(parts.values()), axis=0)
    sound = np.isfinite(total).all(axis=(-2, -1))
    values, vectors = np.linalg.eigh(np.where(sound[..., None, None], total, np.eye(3)))
    direction, most = vectors[..., :, 2], values[..., 2]
    shares = {
        name: (direction[..., None, :] @ part @ direction[..., None])[..., 0, 0] / most for name, part in parts.items()
    }
    return Softest(np.where(sound, 1.0 / most, 0.0), direction, shares)
