"""What three-fold symmetry costs the published problem: its first step with the placement of the chains free.

The paper's formulas hold for each chain with its own azimuth and base radius. L_A and the largest R + L_A stay as
table 1 has them, for every chain; L_B, r and H have the bounds of table 3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from optimizer.globalopt.optimum import Now, Proven, prove_optimum
from optimizer.paper.published import problem_of, published_runs
from optimizer.problem.requirements import AngleBounds
from optimizer.problem.step import Problem, step_problem
from optimizer.problem.variables import named
from optimizer.search.result import finite

_TABLE = 4  # of the runs of step 1 with the bounds of table 3
_AZIMUTH_DEG = (60.0, 150.0)
_NARROWEST_MM = 20.0  # R of chains 1 and 2 at least; at most that of chain 0
_CENTRE_MM = 30.0  # how far the cube's middle may stand off the axis, either way


@dataclass(frozen=True)
class PlacedStep:
    """Step 1 with both placements, each with its proof.

    Attributes:
        symmetric: As the paper has it.
        placed: With azimuths, base radius of chains 1 and 2, and the cube's offset free.
    """

    symmetric: Proven
    placed: Proven

    @property
    def cost(self) -> float:
        """Share of the half side that symmetry costs at least: by what is certified placed, and proved symmetric."""
        return 1.0 - self.symmetric.bound / self.placed.objective

    def record(self) -> dict[str, Any]:
        """Gathers the facts as plain data for JSON."""
        names = ("objective", "bound", "gap")
        both = {
            name: {
                **{key: finite(getattr(proven, key)) for key in names},
                "status": proven.status,
                "boxes": proven.boxes,
                "variables": named(proven.design_mm) if proven.design_mm else None,
            }
            for name, proven in (("symmetric", self.symmetric), ("placed", self.placed))
        }
        bounds = {"azimuth_deg": _AZIMUTH_DEG, "base_radius_of_1_and_2_mm": (_NARROWEST_MM, problem().lower[2])}
        return {"bounds": {**bounds, "centre_x_mm": (-_CENTRE_MM, _CENTRE_MM)}, **both, "cost": finite(self.cost)}


def problem() -> Problem:
    """Poses the published step 1, symmetric."""
    return problem_of(published_runs((_TABLE,))[0])[0]


def placed_problem() -> Problem:
    """Poses the same with the placement free."""
    given = problem().requirements
    shift = (_NARROWEST_MM - given.bounds_mm.base_radius[0], 0.0)
    bounds = given.bounds_mm.model_copy(update={"side_shift": shift, "centre_x": (-_CENTRE_MM, _CENTRE_MM)})
    azimuth = AngleBounds(azimuth=_AZIMUTH_DEG)
    return step_problem(given.model_copy(update={"bounds_mm": bounds, "bounds_deg": azimuth}), 1)


def placed_step(gap: float, seed: int, seconds: float, report: Callable[[str], None] = lambda _: None) -> PlacedStep:
    """Proves both optima.

    Args:
        gap: Gap at which each proof ends.
        seed: Of the starts of SQP.
        seconds: Time after which each of them ends with what it reached.
        report: Called with a line that says what is being done.
    """

    def tell(now: Now) -> None:
        report(f"step 1 with the placement free: {now.boxes:,} boxes")

    symmetric, placed = (
        prove_optimum(one, gap=gap, seed=seed, seconds=seconds, report=tell) for one in (problem(), placed_problem())
    )
    return PlacedStep(symmetric, placed)


def section(facts: dict[str, Any]) -> str:
    """Writes the section of the page in Markdown, from what `PlacedStep.record` gives."""
    symmetric, placed, bounds = facts["symmetric"], facts["placed"], facts["bounds"]
    if placed["objective"] is None or symmetric["objective"] is None:
        return f"No design was proved: {placed['status']}; no larger cube than {placed['bound']:.4f} mm of half side."
    at, (near, far) = placed["variables"], bounds["base_radius_of_1_and_2_mm"]
    (low, high), off = bounds["azimuth_deg"], bounds["centre_x_mm"][1]
    azimuth, centre, shift = at.get("azimuth_deg", 120.0), at.get("centre_x_mm", 0.0), at.get("side_shift_mm", 0.0)
    rows = []
    for name, one in (("three-fold symmetric", symmetric), ("free", placed)):
        cells = f"{one['objective']:.4f}", f"{one['bound']:.5f}", f"{one['gap']:.1e}"
        rows.append(f"| {name} | {' | '.join(cells)} | {one['status']} |")
    return "\n".join(
        [
            "Free beside L_B, r and H: the azimuths of chains 1 and 2, "
            f"{low:g} to {high:g} degrees from chain 0 on either side, their base radius, {near:g} to {far:g} mm, so "
            f"that the paper's limit of R + L_A holds for every chain, and the cube's middle, up to {off:g} mm off the "
            "axis. Reach is that of eq. (7), with each chain's own azimuth and radius.",
            "",
            "| placement | L, mm | no design above, mm | gap | status |",
            "| --- | --- | --- | --- | --- |",
            *rows,
            "",
            f"The largest cube has azimuths of {azimuth:.2f} degrees; its middle is {abs(centre):.2f} mm off the axis, "
            f"base radii differ by {abs(shift):.2f} mm. Symmetry costs {100.0 * facts['cost']:.2f} % of L at least. "
            "Step 1 asks for reach and outline alone.",
        ]
    )
