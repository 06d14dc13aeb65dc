"""A ball on its seat in an elastic rod's end of two materials: finite elements and unilateral contact, no friction.

The end is held on its spigot and halved in its plane of symmetry, z = 0. Its flexibility for forces square to the seat,
node by node, is what the elements give; the contact is then the linear complementarity of gaps and pressures under a
ball that no one turns and that cannot be dented: the ball's own elasticity, of steel, is a fiftieth of the plastic's.
Gaps are those of two spheres, taken by the nodes' directions, so that the flat sides of elements do not roughen a
clearance of some micrometres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import cadquery as cq
import gmsh
import numpy as np
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementTetP2, ElementVector, MeshTet
from skfem.helpers import ddot, sym_grad, trace

ROUNDS = 200  # of the active set, which settles in some ten
NEWTON_STEP_MM = 1e-5


def meshed_together(
    shapes: Sequence[cq.Shape], size_mm: Callable[[float, float, float], float], folder: Path
) -> tuple[MeshTet, np.ndarray]:
    """Tetrahedra of solids that are bonded where they touch, and for each the number of its solid."""
    files = []
    for k, shape in enumerate(shapes):
        files.append(folder / f"shape_{k}.brep")
        shape.exportBrep(str(files[-1]))
    gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
        gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
        gmsh.model.add("bonded")
        made = [gmsh.model.occ.importShapes(str(file)) for file in files]
        _, parents = gmsh.model.occ.fragment(made[0], [one for group in made[1:] for one in group])
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.setSizeCallback(lambda _d, _t, x, y, z, _s: size_mm(x, y, z))
        gmsh.model.mesh.generate(3)
        tags, points, _ = gmsh.model.mesh.getNodes()
        cells, owner = [], []
        for k, pieces in enumerate(parents):
            for _, tag in pieces:
                kinds, _, nodes = gmsh.model.mesh.getElements(3, tag)
                (corners,) = (list_ for kind, list_ in zip(kinds, nodes, strict=True) if kind == 4)
                cells.append(corners.reshape(-1, 4))
                owner.append(np.full(len(cells[-1]), k))
    finally:
        gmsh.finalize()
    place = np.zeros(int(tags.max()) + 1, dtype=int)
    place[tags.astype(int)] = np.arange(len(tags))
    used, numbered = np.unique(place[np.concatenate(cells).astype(int)], return_inverse=True)
    return MeshTet(points.reshape(-1, 3)[used].T.copy(), numbered.reshape(-1, 4).T.copy()), np.concatenate(owner)


class Seat:
    """A seat about the origin, its pole along +y; of it the half z >= 0, the loads in the plane z = 0.

    Args:
        mesh: Tetrahedra of the whole end.
        moduli: (elements, 2) Young's modulus, N/mm^2, and Poisson's ratio of each.
        radius_mm: Of the seat.
        within_rad: Nodes of the seat so far from the pole may bear.
        held: (3, n) points -> (n,) whether they are held.
    """

    def __init__(
        self,
        mesh: MeshTet,
        moduli: np.ndarray,
        radius_mm: float,
        within_rad: float,
        held: Callable[[np.ndarray], np.ndarray],
    ) -> None:
        element = ElementVector(ElementTetP2())
        basis = Basis(mesh, element, intorder=2)
        young, poisson = moduli.T[..., None]
        shear, lame = young / (2 * (1 + poisson)), young * poisson / ((1 + poisson) * (1 - 2 * poisson))

        @BilinearForm
        def energy(u, v, w):
            return 2 * w.shear * ddot(sym_grad(u), sym_grad(v)) + w.lame * trace(sym_grad(u)) * trace(sym_grad(v))

        points = np.ones((1, basis.dx.shape[1]))
        matrix = energy.assemble(basis, shear=shear * points, lame=lame * points).tocsc()
        facets = mesh.facets_satisfying(
            lambda x: (np.abs(np.linalg.norm(x, axis=0) - radius_mm) < 0.05) & (x[1] > 0.0), boundaries_only=True
        )
        on_seat = basis.get_dofs(facets)
        components = [on_seat.all(f"u^{k}") for k in (1, 2, 3)]
        at = basis.doflocs[:, components[0]]
        directions = at / np.linalg.norm(at, axis=0)
        near = directions[1] > np.cos(within_rad)
        self.directions = directions[:, near].T
        dofs = np.array(components)[:, near]
        load = np.zeros((basis.N, dofs.shape[1]))
        for k in range(3):
            load[dofs[k], np.arange(dofs.shape[1])] = self.directions[:, k]
        fixed = basis.get_dofs(mesh.facets_satisfying(held, boundaries_only=True)).all()
        plane = basis.get_dofs(mesh.facets_satisfying(lambda x: np.abs(x[2]) < 1e-6, boundaries_only=True)).all("u^3")
        free = np.setdiff1d(np.arange(basis.N), np.concatenate([fixed, plane]))
        solver = splu(
            matrix[free][:, free], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0
        )
        self.flexibility = load[free].T @ solver.solve(load[free])

    def forces(self, moved_mm: np.ndarray, clearance_mm: float) -> np.ndarray:
        """Forces of the half's nodes, N, where the ball has moved by (2,) mm along x and y from the seat's centre."""
        wanted = self.directions[:, :2] @ moved_mm - clearance_mm  # by how much a node must give way, at least
        bears = wanted > 0
        for _ in range(ROUNDS):
            force = np.zeros(len(wanted))
            if bears.any():
                force[bears] = np.linalg.solve(self.flexibility[np.ix_(bears, bears)], wanted[bears])
            gives = self.flexibility @ force
            settled = (bears & (force > 0)) | (~bears & (gives < wanted - 1e-12))
            if (settled == bears).all():
                return force
            bears = settled
        raise AssertionError("the contact does not settle")

    def resting_mm(self, load_N: np.ndarray, clearance_mm: float, start_mm: np.ndarray) -> np.ndarray:
        """Place of the ball, (2,) mm from the seat's centre, at which both halves bear a load on it, (2,) N."""
        moved = np.array(start_mm, dtype=float)

        def carried_load(at: np.ndarray) -> np.ndarray:
            return 2.0 * self.directions[:, :2].T @ self.forces(at, clearance_mm)

        for _ in range(50):
            here = carried_load(moved)
            missing = load_N - here
            if np.linalg.norm(missing) < 1e-6 * np.linalg.norm(load_N):
                return moved
            slope = np.stack(
                [(carried_load(moved + NEWTON_STEP_MM * e) - here) / NEWTON_STEP_MM for e in np.eye(2)], axis=1
            )
            step = np.linalg.solve(slope, missing)
            moved = moved + step * min(1.0, 0.3 * clearance_mm / np.abs(step).max())
        raise AssertionError("the ball does not come to rest")
