"""Figures 14 to 16 under other assumptions: what shakes is what the eigenvalues say, and sentences say no more."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import Design
from haptics.commands.cli import main
from haptics.loop.assumptions import CURRENT_LAG, default_estimator
from haptics.loop.choice import PAPER
from haptics.loop.discrete import Timing, linear_models, sampled_loop
from haptics.loop.hardware import real_plant
from haptics.loop.linear import linearise
from haptics.scenes.bench import GUIDE, PERIOD, Assumed
from haptics.scenes.figures_differ import MILD, FigureCase, figure_cases, figure_discussion
from haptics.scenes.resistance import resistance
from tests.committed import BEST
from tests.haptics.scene_machine import scene_machine

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
    (estimator,) = linear_models(default_estimator(PERIOD))
    loop = sampled_loop(body, Timing(PERIOD, DELAY, CURRENT_LAG), estimator, here.ports(np.eye(3), len(body.mass)))
    assert (float(loop.radius(0.0, applied)) < 1.0) is stands


@pytest.mark.slow
def test_friction_moves_the_way_home(best: Design) -> None:
    found = {one.name: one.figures for one in figure_cases(scene_machine(best), "home", DELAY, 0)}
    overshoot = [found[name]["b5"]["overshoot_mm"] for name in ("largest friction", "as simulated", "least friction")]
    assert overshoot == sorted(overshoot)
    assert found["noise"]["b5"]["settling_s"] == pytest.approx(found["as simulated"]["b5"]["settling_s"], rel=0.05)
    assert all("limit cycle" in figures["b500_uncapped"]["verdict"] for figures in found.values())


def test_sentences_follow_from_the_cases() -> None:
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
