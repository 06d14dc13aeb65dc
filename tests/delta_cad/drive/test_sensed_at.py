"""The encoder at the motor in place of the shoulder: what is refused, what a count is worth, which parts are there."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import pytest

from delta_cad import catalogue
from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.machine import Assembly
from delta_cad.design import Design, DesignError, design_from_dict
from delta_cad.dimensions import dimensions
from delta_cad.drive import joint_counts_per_turn
from tests.committed import changed
from tests.delta_cad.assembly.expected.comparing import make_faults, part_faults
from tests.delta_cad.catalogue.offered import machine, offered

SENSED = "maxon-re30-310009-500"
BOARD = ("encoder_board", "encoder_magnet", "board_spacer", "board_screw")


@pytest.fixture(scope="module")
def design() -> Design:
    return machine(offered()[f"motor {SENSED}"])


@pytest.fixture(scope="module")
def assembly(design: Design) -> Assembly:
    return assemble(dimensions(design))


def test_a_count_at_the_motor_is_worth_the_less_the_higher_the_ratio(best: Design, design: Design) -> None:
    """500 lines in four edges each, times the ratio, beside 2^21 counts on the shoulder's shaft."""
    assert joint_counts_per_turn(best) == 2**21
    ratio = design.hardware.capstan_ratio
    assert joint_counts_per_turn(design) == 500 * 4 * ratio
    hardware = design.hardware.model_copy(update={"capstan_ratio": 2 * ratio})
    assert joint_counts_per_turn(design.model_copy(update={"hardware": hardware})) == 2 * joint_counts_per_turn(design)


def test_the_controller_and_the_simulation_take_it_through_the_ratio(best: Design, design: Design) -> None:
    from haptics.loop.assumptions import encoder_count
    from haptics.model.machine import MachineModel

    class Known:
        def __init__(self, design: Design) -> None:
            self.design = design

    for known, counts in ((best, 2.0**21), (design, 2000.0 * design.hardware.capstan_ratio)):
        model: MachineModel = Known(known)  # type: ignore[assignment]
        assert encoder_count(model) == pytest.approx(2.0 * pi / counts)


def test_a_motor_without_an_encoder_is_refused_with_those_that_have_one() -> None:
    with pytest.raises(DesignError, match=rf"^design: hardware\.motor = .*310007.*: has no encoder .* {SENSED} have$"):
        design_from_dict(changed(hardware__encoder_at="motor"))
    with pytest.raises(DesignError, match=r'hardware\.encoder_at = "elbow": must be "shoulder" or "motor"'):
        design_from_dict(changed(hardware__encoder_at="elbow"))


def test_left_out_and_at_the_shoulder_are_one_machine(best: Design) -> None:
    stated = design_from_dict(changed(hardware__encoder_at="shoulder"))
    assert joint_counts_per_turn(stated) == joint_counts_per_turn(best)
    assert dimensions(stated).sensed_at_shoulder


@pytest.mark.slow
def test_no_part_of_the_shoulder_s_encoder_is_left_and_no_hole_for_it(assembly: Assembly) -> None:
    assert not [o.name for o in assembly.occurrences if o.name.startswith(BOARD)]
    assert not [fit for fit in assembly.fits if fit.a.startswith(BOARD) or fit.b.startswith(BOARD)]
    parts = {part.number: part for part in assembly.parts}
    words = " ".join(hole.callout for name in ("encoder_cheek", "shoulder_shaft") for hole in parts[name].holes)
    assert "magnet" not in words
    assert "board" not in words
    assert catalogue.motor(SENSED).length_mm > catalogue.motor("maxon-re30-310009").length_mm


@pytest.mark.slow
def test_a_board_that_is_there_all_the_same_and_a_missing_motor_are_noticed(design: Design, assembly: Assembly) -> None:
    d = dimensions(design)
    assert part_faults(assembly, d) == make_faults(assembly, d) == []
    without = replace(assembly, occurrences=[o for o in assembly.occurrences if o.name != "motor_1"])
    (missing,) = part_faults(without, d)
    assert "motor_1" in missing
    motor = next(o for o in assembly.occurrences if o.name == "motor_1")
    extra = replace(assembly, occurrences=[*assembly.occurrences, replace(motor, name="encoder_board_1")])
    (more,) = part_faults(extra, d)
    assert "encoder_board_1" in more
