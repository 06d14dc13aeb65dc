"""The paper's first step with the placement free: by eq. (7) written out for each chain's own azimuth and radius."""

from __future__ import annotations

import numpy as np
import pytest

from optimizer.paper.page import page, record
from optimizer.paper.placed import PlacedStep, placed_problem, section
from optimizer.paper.reproduction import Reproduction

LINE = np.linspace(-1.0, 1.0, 9)
GRID = np.stack(np.meshgrid(LINE, LINE, LINE, indexing="ij"), axis=-1).reshape(-1, 3)


def reach(design_mm: np.ndarray) -> np.ndarray:
    """(D,) largest h of eq. (7) over the cubes of (D, 9) designs, mm^2: at most 0 within the reach."""
    L_A, L_B, R, r, H, L, shift, c, centre = design_mm.T[:, :, None, None]
    phi = np.arccos(c) * np.array([0.0, 1.0, -1.0])
    R_i = R + shift * np.array([0.0, 1.0, 1.0])
    x, y, z = (GRID[:, k : k + 1] for k in range(3))  # (N, 1)
    x, y, z = centre + L * x, L * y, H + L * (1.0 + z)  # (D, N, 1)
    u = x * np.cos(phi) + y * np.sin(phi)
    A, B = 2.0 * L_A * (R_i - r - u), -2.0 * L_A * z
    C = L_A**2 - L_B**2 + (R_i - r) ** 2 + (x * x + y * y + z * z) - 2.0 * (R_i - r) * u
    return (C**2 - A**2 - B**2).max(axis=(1, 2))


def test_both_placements_are_proved_and_symmetry_costs_what_is_between(placed: PlacedStep) -> None:
    assert placed.symmetric.status == placed.placed.status == "proved"
    assert placed.placed.objective > placed.symmetric.bound
    assert placed.cost == pytest.approx(1.0 - 64.2021 / 66.81008, abs=1e-5)  # 64.25 is printed for the symmetric one
    assert placed.placed.gap <= 1e-5


def test_the_larger_cube_is_within_reach_by_eq_7(placed: PlacedStep) -> None:
    design = np.array([placed.placed.design_mm])
    assert reach(design)[0] <= 1e-5
    larger = design.copy()
    larger[0, 5] *= 1.001
    assert reach(larger)[0] > 1.0
    assert max(design[0, 2], design[0, 2] + design[0, 6]) + design[0, 0] <= 122.0


def test_no_random_design_beats_the_bound(placed: PlacedStep) -> None:
    """Half of them beside the optimum, all with the half side that is excluded; without it some are within reach."""
    problem, rng = placed_problem(), np.random.default_rng(7)
    near = problem.scaled(np.array(placed.placed.design_mm))
    x = rng.random((6000, len(near)))
    x[:3000] = np.clip(near + 10.0 ** rng.uniform(-6.0, -0.5, (3000, 1)) * rng.normal(size=(3000, len(near))), 0.0, 1.0)
    designs = problem.designs(x) * 1000.0
    designs[:, 7] /= 1000.0
    designs[:, 5] = placed.placed.bound
    assert (reach(designs) > 0.0).all()
    designs[:, 5] = 0.97 * placed.placed.bound
    assert (reach(designs) <= 0.0).any()


def test_page_and_record_tell_what_was_computed(placed: PlacedStep) -> None:
    facts = record([], Reproduction(), placed)
    assert facts["step_1_placed"]["placed"]["bound"] == placed.placed.bound
    text = page(facts)
    assert "## Step 1 with the placement free" in text
    assert f"| free | {placed.placed.objective:.4f} | {placed.placed.bound:.5f} |" in text
    assert f"Symmetry costs {100.0 * placed.cost:.2f} % of L at least" in text
    assert "placement free" not in page(record([], Reproduction()))
    nothing = facts["step_1_placed"] | {"placed": facts["step_1_placed"]["placed"] | {"objective": None}}
    assert section(nothing).startswith("No design was proved")
