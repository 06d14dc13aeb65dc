"""Why walls differ from the paper's: limits that the formula explains, and sentences that say no more than they.

Figures 14 to 16 under other assumptions: what shakes is what the eigenvalues say, and sentences say no more.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.mechanism import inverse_jacobian
from haptics.commands.cli import main
from haptics.gravity.published import STIFFNESS_N_PER_MM
from haptics.loop.assumptions import CURRENT_LAG, default_estimator, joint_friction
from haptics.loop.choice import BOARD, DAMPED, PAPER
from haptics.loop.discrete import Timing, linear_model, sampled_loop
from haptics.loop.hardware import real_plant
from haptics.loop.linear import linearise
from haptics.loop.wall_trial import LEAN, WallBench
from haptics.loop.walls import search
from haptics.model.hands import HANDS
from haptics.scenes.bench import GUIDE, PERIOD, Assumed
from haptics.scenes.differs import (
    MILD,
    FigureCase,
    WallCase,
    _limit,
    cases,
    damping_needed,
    discussion,
    figure_cases,
    figure_discussion,
)
from haptics.scenes.resistance import resistance
from tests.committed import BEST
from tests.haptics.scene_machine import scene_machine


@pytest.mark.slow
def test_one_assumption_at_a_time_moves_the_limits_as_the_formula_says(best: Design) -> None:
    found = {one.name: one.limits_N_per_mm for one in cases(scene_machine(best), "medium", 0.5e-3, 0)}
    own = found.pop("as simulated")
    assert all(3.5 < limit < 6.5 for limit in own.values())
    for axis, limit in own.items():
        assert found["firm hand"][axis] < found["light hand"][axis] < limit  # as the dampers of their grasps
        assert found["least friction"][axis] < limit < found["largest friction"][axis]
        # damping of all there is over T/2 + delay + lag: delay alone moves a limit by the ratio of the sums
        longer = (0.5e-3 + 1.0e-3 + CURRENT_LAG) / (0.5e-3 + 0.5e-3 + CURRENT_LAG)
        assert found["a period of delay"][axis] == pytest.approx(limit / longer, rel=0.2)
        # the arm on the handle itself: its damping and the friction's share, which is what bears the wall otherwise
        rigid = HANDS["medium"].damping / (0.5e-3 + 0.5e-3 + CURRENT_LAG) / 1e3
        assert rigid < found["arm rigid on the handle"][axis] < rigid + 1.3 * limit
        assert found[BOARD.label][axis] > 5.0 * limit
        assert found[DAMPED.label][axis] > 5.0 * limit


def test_sentences_follow_from_the_cases() -> None:
    here = WallCase("as simulated", {"x": 2.25, "y": 2.0, "z": 2.5}, (), 1.8)
    soft = WallCase("light hand", {"x": 1.0, "y": 1.5, "z": 9.0}, (), 1.8)
    hard = WallCase("no delay", dict.fromkeys("xyz", 6.0), ("z",), 1.8)
    said = " ".join(discussion([here, soft, hard], "medium", 0.5e-3))
    assert "x 2.2, y 2.0, z 2.5 N/mm where the paper has x 4.9, y 5.1, z 4.5" in said
    assert "from the softest axis on y, x, z here, z, x, y there" in said
    assert "every axis with: no delay." in said
    assert "light hand: x 1.0, y 1.5, z 9.0; no delay: x 6.0, y 6.0, z 6.0 and more" in said
    assert not any("every axis with" in one for one in discussion([here, soft], "medium", 0.5e-3))
    stuck = WallCase("largest friction", {"x": 9.0, "y": 9.0, "z": math.nan}, (), 0.72)
    said = " ".join(discussion([here, stuck], "medium", 0.5e-3))
    assert "largest friction: x 9.0, y 9.0, z -" in said
    assert "no figure along z: friction holds the handle before the wall against the hand's 0.72 N" in said
    assert damping_needed(STIFFNESS_N_PER_MM["x"], 0.5e-3) == pytest.approx(4.9 * 1.2)


def test_a_wall_that_friction_keeps_the_hand_from_has_no_limit(best: Design) -> None:
    """Coulomb friction of the joints at the handle, `c sum |G_i . n|`, on either side of the force of the hand."""
    machine = scene_machine(best)
    friction = joint_friction(machine).coulomb[2] * np.abs(inverse_jacobian(machine.geometry, machine.centre)).sum(0)[2]
    found = []
    for share in (0.8, 3.0):
        requirements = machine.design.requirements.model_copy(update={"force_N": share * friction / LEAN})
        weak = replace(machine, design=machine.design.model_copy(update={"requirements": requirements}))
        bench = WallBench(weak, "z", HANDS["medium"], "largest")
        assert bench.lean == pytest.approx(share * friction)
        found.append(_limit(bench, search(bench.stands, step=4000.0, ceiling=9100.0, tolerance=4000.0)))
    assert math.isnan(found[0])
    assert found[1] > 0.0


DELAY = 0.5e-3


@pytest.mark.parametrize(("most", "stands"), [(np.inf, False), (MILD, True)])
def test_what_gives_way_bears_an_eighth_of_the_damping(best: Design, most: float, stands: bool) -> None:
    """The scene against the eigenvalues of the device in the guide, in the corner, with damping in all directions."""
    machine = scene_machine(best)
    scene = resistance(machine, delay=DELAY, assumed=Assumed(gives=True, damping=most))
    applied = scene.facts["settings"]["k0.4"]["damping_applied_N_s_per_m"]
    assert applied <= most
    assert scene.kept is stands
    deviation = scene.facts["settings"]["k0.4"]["rms_deviation_N"]
    assert deviation < 0.02 if stands else deviation > 1.0
    here = linearise(real_plant(machine, PAPER), machine.centre + machine.half_side)
    body, _ = here.body(GUIDE)
    estimator = linear_model(default_estimator(PERIOD))
    loop = sampled_loop(body, Timing(PERIOD, DELAY, CURRENT_LAG), estimator, here.ports(np.eye(3), len(body.mass)))
    assert (float(loop.radius(0.0, applied)) < 1.0) is stands


@pytest.mark.slow
def test_friction_moves_the_way_home(best: Design) -> None:
    found = {one.name: one.figures for one in figure_cases(scene_machine(best), "home", DELAY, 0)}
    overshoot = [found[name]["b5"]["overshoot_mm"] for name in ("largest friction", "as simulated", "least friction")]
    assert overshoot == sorted(overshoot)
    assert found["noise"]["b5"]["settling_s"] == pytest.approx(found["as simulated"]["b5"]["settling_s"], rel=0.05)
    assert all("limit cycle" in figures["b500_uncapped"]["verdict"] for figures in found.values())


def test_sentences_of_figures_follow_from_the_cases() -> None:
    led = {"k0.4": {"least_corner_force_N": 3.0, "rms_deviation_N": 0.01}}
    said = figure_discussion("resistance", [FigureCase("as simulated", led, True), FigureCase("noise", led, False)])
    assert "as simulated 3.00 (0.01); noise 3.00 (0.01)" in said[0]
    assert said[1].endswith("with: noise.")
    ways = {
        "b5": {"settling_s": None, "capped": True, "verdict": "creeps"},
        "b500_uncapped": {"settling_s": 5.0, "capped": False, "verdict": "comes home, limit cycle"},
    }
    said = figure_discussion("home", [FigureCase("as simulated", ways, True)])
    assert "as simulated -." in said[0]
    assert said[1] == "Promises are kept in all of them."
    assert said[2].endswith("with: as simulated.")


def test_noise_is_none_of_the_paper_s(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "--design", str(BEST), "--scene", "noise", "--differs"]) == 2
    assert "--differs" in capsys.readouterr().err
