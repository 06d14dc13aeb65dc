"""A space frame by the stiffness method: 12-dof Timoshenko beams, springs and rigid offsets; the oracle of the room.

It shares the table's sections with the closed form, but neither its statics nor its flexibilities.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import splu

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.geometry import VERTICAL, DeltaGeometry
from delta_cad.mechanism.inverse import inverse_kinematics
from delta_cad.structure.beam import Beam
from delta_cad.structure.beam_model import BeamModel
from delta_cad.structure.compliance import cable_mm_N
from delta_cad.structure.modes import Moving

GROUND = -1


def offset(arm: np.ndarray) -> np.ndarray:
    """Motion of a point held rigidly by a node at `arm` from it, (6, 6)."""
    x, y, z = arm
    moved = np.eye(6)
    moved[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return moved


def beam_stiffness(length: float, e: float, g: float, s) -> np.ndarray:
    """Stiffness of a beam between two nodes along x (Przemieniecki, Theory of Matrix Structural Analysis, 5.116)."""
    k = np.zeros((12, 12))

    def add(rows: list[int], block: np.ndarray) -> None:
        k[np.ix_(rows, rows)] += block

    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    add([0, 6], e * s.area_mm2 / length * pair)
    add([3, 9], g * s.torsion_mm4 / length * pair)
    for second, shear, rows, sign in (
        (s.about_z_mm4, s.shear_y_mm2, [1, 5, 7, 11], 1.0),
        (s.about_y_mm4, s.shear_z_mm2, [2, 4, 8, 10], -1.0),
    ):
        phi = 12.0 * e * second / (g * shear * length**2)
        h, l2 = sign * 6.0 * length, length**2
        block = np.array(
            [
                [12.0, h, -12.0, h],
                [h, (4.0 + phi) * l2, -h, (2.0 - phi) * l2],
                [-12.0, -h, 12.0, -h],
                [h, (2.0 - phi) * l2, -h, (4.0 + phi) * l2],
            ]
        )
        add(rows, e * second / (length**3 * (1.0 + phi)) * block)
    return k


@dataclass
class Frame:
    """Nodes and their stiffness and mass."""

    nodes: int = 0
    triplets: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = field(default_factory=list)
    masses: list[tuple[int, np.ndarray]] = field(default_factory=list)

    def node(self) -> int:
        self.nodes += 1
        return self.nodes - 1

    def add(self, a: int, b: int, k: np.ndarray) -> None:
        ends = [(n, range(6 * i, 6 * i + 6)) for i, n in enumerate((a, b)) if n != GROUND]
        rows = np.concatenate([np.arange(6 * n, 6 * n + 6) for n, _ in ends])
        local = np.concatenate([np.array(r) for _, r in ends])
        i, j = np.meshgrid(rows, rows, indexing="ij")
        self.triplets.append((i.ravel(), j.ravel(), k[np.ix_(local, local)].ravel()))

    def held(self, nodes: list[int], k: np.ndarray) -> None:
        """Holds nodes against the ground by a stiffness that couples them."""
        rows = np.concatenate([np.arange(6 * n, 6 * n + 6) for n in nodes])
        i, j = np.meshgrid(rows, rows, indexing="ij")
        self.triplets.append((i.ravel(), j.ravel(), k.ravel()))

    def spring(self, a: int, at_a: np.ndarray, b: int, at_b: np.ndarray, direction: np.ndarray, k: float) -> None:
        """A spring between two points, each held rigidly by a node."""
        row = np.concatenate([-direction @ offset(at_a)[:3], direction @ offset(at_b)[:3]])
        self.add(a, b, k * np.outer(row, row))

    def bar(self, root: int, at_root: np.ndarray, axes: np.ndarray, beam: Beam) -> int:
        """A beam that begins at a point of a node; returns the node at its tip. `axes` are x, y, z as rows."""
        turn = np.kron(np.eye(4), axes)
        last, arm = root, at_root
        for piece in beam.slices:
            tip = self.node()
            soft = 1.0 / beam.factor
            k = beam_stiffness(piece.length_mm, soft * piece.youngs_N_mm2, soft * piece.shear_N_mm2, piece.section)
            hold = np.eye(12)
            hold[:6, :6] = offset(arm)
            self.add(last, tip, hold.T @ turn.T @ k @ turn @ hold)
            last, arm = tip, np.zeros(3)
        return last

    def matrix(self) -> csc_matrix:
        rows, columns, values = (np.concatenate(part) for part in zip(*self.triplets, strict=True))
        return coo_matrix((values, (rows, columns)), shape=(6 * self.nodes, 6 * self.nodes)).tocsc()


@dataclass
class Built:
    """A machine as a frame."""

    frame: Frame
    hub: int
    knob: int
    bosses: list[int]
    elbows: list[int]
    shafts: list[int]
    balls: list[tuple[int, int]]

    def flexibility(self, node: int) -> np.ndarray:
        """Displacements of a node by unit forces on it, (3, 3)."""
        solver = splu(self.frame.matrix())
        load = np.zeros((6 * self.frame.nodes, 3))
        load[6 * node : 6 * node + 3] = np.eye(3)
        return solver.solve(load)[6 * node : 6 * node + 3]


def axes_of(g: DeltaGeometry, i: int) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors outwards and along the shoulder axis of a chain, by its azimuth."""
    c, s = np.cos(g.azimuths[i]), np.sin(g.azimuths[i])
    return np.array([c, s, 0.0]), np.array([-s, c, 0.0])


def built(table: BeamModel, p_mm: np.ndarray) -> Built:
    """Makes the frame of a machine with a capstan at one position."""
    frame, g = Frame(), table.geometry
    assert table.shoulder is not None
    assert table.cable is not None
    theta = inverse_kinematics(g, p_mm / MM_PER_M)
    length = g.upper_arm_length * MM_PER_M
    wrist_radius, half = g.platform_radius * MM_PER_M, table.width_mm / 2
    hub = frame.node()
    up = np.array([VERTICAL, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    knob = frame.bar(hub, (table.knob_mm - table.stem.length_mm) * VERTICAL, up, table.stem)
    made = Built(frame, hub, knob, [], [], [], [])
    zero, blocks = np.zeros(3), [GROUND] * 3
    if table.mounting is not None:
        blocks = [frame.node() for _ in range(3)]
        given = np.sum(list(table.mounting.shares.values()), axis=0)
        # in its plane the plate is rigid: without what is added here, nothing has an inverse
        frame.held(blocks, np.linalg.inv(given + np.diag(3 * [*3 * [1e-12], *3 * [1e-17]])))
    for i in range(3):
        u, t = axes_of(g, i)
        rise = table.spoke_up_mm * VERTICAL
        boss = frame.bar(
            hub, (wrist_radius - table.spoke.length_mm) * u + rise, np.array([u, t, VERTICAL]), table.spoke
        )
        c, s = np.cos(theta[i]), np.sin(theta[i])
        x, z = c * u + s * VERTICAL, c * VERTICAL - s * u
        shaft = frame.node()
        elbow = frame.bar(shaft, (length - table.arm.length_mm) * x, np.array([x, t, z]), table.arm)
        shoulder_at = (g.base_radius + (g.side_shift if i else 0.0)) * MM_PER_M * u
        along = p_mm + wrist_radius * u - shoulder_at - length * x
        along = along / np.linalg.norm(along)
        for side in (-1.0, 1.0):
            out = np.array([side * t, u, np.cross(side * t, u)])
            tips = []
            for held, at, bar in ((elbow, zero, table.elbow_bar), (boss, -rise, table.wrist_bar)):
                whole = Beam((*bar.slices, *table.stud.slices))
                tips.append(frame.bar(held, side * (half - whole.length_mm) * t + at, out, whole))
            ball, wrist = tips
            (tube,) = table.rod.slices
            rod = tube.length_mm / (tube.youngs_N_mm2 * tube.section.area_mm2)
            frame.spring(ball, zero, wrist, zero, along, 1.0 / (2.0 / table.joint_N_mm + rod))
            made.balls.append((ball, wrist))
        from_block = zero if table.mounting is None else shoulder_at - table.mounting.blocks_mm[i]
        upright = np.array([VERTICAL, t, np.cross(VERTICAL, t)])
        for k, cheek in enumerate(table.shoulder.cheeks):
            y = table.shoulder.y_mm[k] * t
            head = frame.bar(blocks[i], from_block + y - cheek.length_mm * VERTICAL, upright, cheek)
            across = 1.0 / (1.0 / table.shoulder.radial_N_mm + table.shoulder.shaft_mm_N[k])
            for axis, stiffness in ((u, across), (VERTICAL, across), (t, table.shoulder.axial_N_mm)):
                frame.spring(head, zero, shaft, y, axis, stiffness)
        cable = table.cable
        d = cable.direction_rad
        pinion = cable.radius_mm * (np.cos(d) * u + np.sin(d) * VERTICAL)
        tangent = np.cross(t, pinion) / cable.radius_mm
        stiffness = 1.0 / float(cable_mm_N(cable, np.array([c, s])))
        pinion = pinion + cable.y_mm * t
        frame.spring(blocks[i], from_block + pinion, shaft, pinion, tangent, stiffness)
        made.bosses.append(boss)
        made.elbows.append(elbow)
        made.shafts.append(shaft)
    return made


def first_mode_Hz(made: Built, what: Moving, table: BeamModel, p_mm: np.ndarray) -> float:
    """First natural frequency of the frame with its masses lumped at hub, shafts, elbow and wrist balls."""
    frame = made.frame
    size = 6 * frame.nodes
    mass = np.zeros((size, size))

    def put(node: int, block: np.ndarray) -> None:
        mass[6 * node : 6 * node + 6, 6 * node : 6 * node + 6] += block

    def body(m: float, centre: np.ndarray, inertia: np.ndarray) -> np.ndarray:
        hold = offset(centre)
        at_centre = inertia - m * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        block = np.zeros((6, 6))
        block[:3, :3], block[3:, 3:] = m * np.eye(3), at_centre
        return hold.T @ block @ hold

    put(made.hub, body(what.platform.mass_kg, what.platform.centre_mm, what.platform.inertia_kg_mm2))
    theta = inverse_kinematics(table.geometry, p_mm / MM_PER_M)
    for i, shaft in enumerate(made.shafts):
        u, t = axes_of(table.geometry, i)
        x = np.cos(theta[i]) * u + np.sin(theta[i]) * VERTICAL
        axes = np.array([x, t, np.cross(x, t)])
        centre = axes.T @ what.arm.centre_mm
        inertia = axes.T @ what.arm.inertia_kg_mm2 @ axes
        put(shaft, body(what.arm.mass_kg, centre, inertia))
    for ball, wrist in made.balls:
        for node in (ball, wrist):
            put(node, np.diag([what.rod_kg / 2] * 3 + [0.0] * 3))
    loaded = np.flatnonzero(np.diag(mass))  # the rest has no mass: its forces vanish
    unit = np.zeros((size, len(loaded)))
    unit[loaded, np.arange(len(loaded))] = 1.0
    flexible = splu(frame.matrix()).solve(unit)[loaded] @ mass[np.ix_(loaded, loaded)]
    return float(np.sqrt(1000.0 / np.abs(np.linalg.eigvals(flexible)).max()) / (2.0 * np.pi))
