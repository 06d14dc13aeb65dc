"""Why walls differ from the paper's: limits that the formula explains, and sentences that say no more than they."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.mechanism import inverse_jacobian
from haptics.gravity.published import STIFFNESS_N_PER_MM
from haptics.loop.assumptions import CURRENT_LAG, joint_friction
from haptics.loop.choice import BOARD, DAMPED
from haptics.loop.wall_trial import LEAN, WallBench
from haptics.loop.walls import search
from haptics.model.hands import HANDS
from haptics.scenes.wall_differs import WallCase, _limit, cases, damping_needed, discussion
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
