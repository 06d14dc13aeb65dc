"""Linear elastic solids: meshed by gmsh from the exact shape, solved by scikit-fem, quadratic tetrahedra."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cadquery as cq
import gmsh
import numpy as np
from scipy.sparse.linalg import splu
from skfem import (
    Basis,
    BilinearForm,
    ElementTetP2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshTet,
)
from skfem.helpers import ddot, sym_grad, trace

POISSON = 0.3
Where = Callable[[np.ndarray], np.ndarray]  # (3, n) points -> (n,) whether they lie there


def meshed(shape: cq.Shape, size_mm: float, folder: Path) -> MeshTet:
    """Tetrahedra of a solid; small features get the elements that they need."""
    file = folder / "shape.brep"
    shape.exportBrep(str(file))
    gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size_mm)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size_mm / 2)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", 8)
        gmsh.model.add("solid")
        gmsh.model.occ.importShapes(str(file))
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        tags, points, _ = gmsh.model.mesh.getNodes()
        kinds, _, nodes = gmsh.model.mesh.getElements(3)
        (corners,) = (list_ for kind, list_ in zip(kinds, nodes, strict=True) if kind == 4)
    finally:
        gmsh.finalize()
    place = {int(tag): k for k, tag in enumerate(tags)}
    cells = np.array([place[int(tag)] for tag in corners]).reshape(-1, 4)
    used, cells = np.unique(cells, return_inverse=True)
    return MeshTet(points.reshape(-1, 3)[used].T.copy(), cells.reshape(-1, 4).T.copy())


def flexibility(
    mesh: MeshTet, youngs_N_mm2: float, held: Where, loaded: Where, centre: np.ndarray, wrenches: np.ndarray
) -> np.ndarray:
    """Motions of a face by wrenches spread over it, (n, n): the work of load k on the displacements of load l.

    A force is an even traction, a moment one that grows with the distance from the centre.
    """
    element = ElementVector(ElementTetP2())
    basis = Basis(mesh, element, intorder=2)
    shear = youngs_N_mm2 / (2 * (1 + POISSON))
    lame = youngs_N_mm2 * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))

    @BilinearForm
    def energy(u, v, _):
        return 2 * shear * ddot(sym_grad(u), sym_grad(v)) + lame * trace(sym_grad(u)) * trace(sym_grad(v))

    matrix = energy.assemble(basis).tocsc()
    facets = mesh.facets_satisfying(loaded, boundaries_only=True)
    face = FacetBasis(mesh, element, facets=facets, intorder=4)
    assert len(facets)

    def resultant(weight: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        values = weight(np.asarray(face.global_coordinates()) - centre[:, None, None])
        return (values * face.dx).sum(axis=(-2, -1))

    area = resultant(np.ones_like)[0]
    # x -> (force, moment) of the tractions a + b cross x, made to be the wrench that is asked
    second = np.array([[resultant(lambda x, i=i, j=j: (x[i] * x[j])[None])[0] for j in range(3)] for i in range(3)])
    first = resultant(lambda x: x)
    inertia = np.trace(second) * np.eye(3) - second
    turning = np.array([[0, first[2], -first[1]], [-first[2], 0, first[0]], [first[1], -first[0], 0]])
    system = np.block([[area * np.eye(3), turning], [turning.T, inertia]])
    loads = []
    for wrench in wrenches:
        a, b = np.split(np.linalg.solve(system, wrench), 2)

        @LinearForm
        def work(v, w, a=a, b=b):
            x = w.x - centre[:, None, None]
            traction = a[:, None, None] + np.cross(b, x, axisb=0, axisc=0)
            return (traction * v).sum(axis=0)

        loads.append(work.assemble(face))
    load = np.array(loads).T
    fixed = basis.get_dofs(mesh.facets_satisfying(held, boundaries_only=True)).all()
    free = np.setdiff1d(np.arange(basis.N), fixed)
    solver = splu(
        matrix[free][:, free], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0
    )
    return load[free].T @ solver.solve(load[free])
