"""Tightest limits that are proved, against extremes given wrong on purpose."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from delta_cad.design import load_design
from delta_cad.mechanism import Cube, DeltaGeometry, conditioning
from delta_cad.mechanism.limits import Limits
from delta_cad.mechanism.proof.extremes import WorstFigure, worst_figures
from optimizer.certify.bounds import bounds
from optimizer.certify.certificate import values_of
from tests.optimizer.certify.designs import changed


def searched(tmp_path: Path) -> tuple[DeltaGeometry, Cube, dict[str, WorstFigure]]:
    design = load_design(changed(tmp_path))
    g, cube = design.geometry, design.workspace
    return g, cube, {one.figure.name: one for one in worst_figures(g, cube, Limits.measured(values_of(design)))}


def test_a_bound_moves_on_to_the_point_that_refutes_its_extreme(tmp_path: Path) -> None:
    """Told of too small a kappa, the prover finds points beyond it until none is left that a bound near by excludes."""
    g, cube, worst = searched(tmp_path)
    true = worst["kappa"].value
    (found,) = bounds(g, cube, [worst["kappa"]._replace(value=true * 0.9, position=(0.0, 0.0, 0.0))])
    assert found.figure.name == "kappa"
    assert float(conditioning(g, np.array(found.point))) == found.attained
    assert found.proved is not None
    assert found.attained <= true * (1.0 + 1e-12)  # the true extreme lies in a corner, which both find
    assert true <= found.proved <= found.attained * (1.0 + 1.001e-5)


def test_a_figure_without_bound_has_no_row_of_numbers(tmp_path: Path) -> None:
    """Limits beyond what the prover takes, and figures without an end, are left out."""
    g, cube, worst = searched(tmp_path)
    odd = {
        "torque": 2e6,
        "kappa": np.inf,
        "lean": np.pi / 2.0,
        "shoulder_min": -np.pi,
        "shoulder_max": np.pi,
    }
    reported = [one._replace(value=odd.get(name, one.value), position=(0.0, 0.0, 0.1)) for name, one in worst.items()]
    found = {b.figure.name: b.proved for b in bounds(g, cube, reported) if b.figure.threshold}
    assert "kappa" not in found
    assert [name for name, proved in found.items() if proved is None] == [
        "torque", "lean", "shoulder_min", "shoulder_max",
    ]  # fmt: skip
