"""Grid files: spread out in order, and refused with field, value and what is allowed."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from optimizer.problem.requirements import RequirementsError, load_requirements
from optimizer.study.grid import MACHINES, SETS_MAX, VALUES_MAX, Grid, GridError, grid_from_dict, load_grid
from tests.optimizer.messages import holds

JOYSTICK = Path(__file__).parents[2] / "references" / "joystick.toml"
BASE = tomllib.loads(JOYSTICK.read_text())
TORQUE, OUTLINE = "requirements.joint_torque_N_m", "limits.outline_radius_max_mm"


def grid(axes: Any = None, **more: Any) -> Grid:
    return grid_from_dict({"base": BASE, "axes": {TORQUE: [0.4, 0.8]} if axes is None else axes} | more, "g.toml")


def test_every_combination_and_every_seed_is_a_set_the_last_axis_fastest() -> None:
    found = grid({OUTLINE: [118, 122], TORQUE: [0.4, 0.6, 0.8]}, seeds=[3, 1], method="sqp", steps=[1, 2])
    assert [axis.field for axis in found.axes] == [OUTLINE, TORQUE]
    assert [one.index for one in found.sets] == list(range(12))
    reported = [(one.inputs[OUTLINE], one.inputs[TORQUE], one.seed) for one in found.sets]
    assert reported[:4] == [(118, 0.4, 3), (118, 0.4, 1), (118, 0.6, 3), (118, 0.6, 1)]
    assert len(set(reported)) == 12
    last = found.sets[-1]
    assert last.requirements["limits"]["outline_radius_max_mm"] == 122
    assert last.requirements["requirements"]["joint_torque_N_m"] == 0.8
    assert last.requirements["bounds_mm"] == BASE["bounds_mm"]
    assert (last.method, last.steps, last.population, last.generations) == ("sqp", (1, 2), None, 100)
    assert found.name == "dashboard-joystick"


def test_the_base_is_left_as_it_is() -> None:
    before = tomllib.loads(JOYSTICK.read_text())
    grid({TORQUE: [0.3]})
    assert before == BASE


def test_axes_are_lists_or_spaces_quoted_or_nested_numbers_or_pairs(tmp_path: Path) -> None:
    (tmp_path / "base.toml").write_text(JOYSTICK.read_text())
    (tmp_path / "g.toml").write_text(
        """
        name = "four-axes"
        base = "base.toml"
        [axes]
        requirements.joint_torque_N_m = {geomspace = [0.2, 0.8, 3]}
        "limits.outline_radius_max_mm" = {linspace = [110, 122, 4]}
        limits.kappa_max = [2.5]
        bounds_mm.forearm_length = [[80, 130], [80, 180]]
        """
    )
    found = load_grid(tmp_path / "g.toml")
    values = {axis.field: axis.values for axis in found.axes}
    np.testing.assert_allclose(values[TORQUE], [0.2, 0.4, 0.8], rtol=1e-15)
    assert values[OUTLINE] == (110.0, 114.0, 118.0, 122.0)
    assert values["limits.kappa_max"] == (2.5,)
    assert values["bounds_mm.forearm_length"] == ([80, 130], [80, 180])
    assert len(found.sets) == 24
    assert found.name == "four-axes"


def test_hash_changes_with_all_that_decides_the_results() -> None:
    hashes = {
        found.sha256
        for found in (
            grid(), grid(seeds=[1]), grid(method="ga"), grid(steps=[1]), grid(population=20), grid(generations=7),
            grid({TORQUE: [0.4, 0.81]}), grid({OUTLINE: [118, 122]}), grid(name="other"),
        )
    }  # fmt: skip
    assert len(hashes) == 9
    assert grid().sha256 in hashes


LONG = list(range(VALUES_MAX + 1))
WIDE = {TORQUE: {"linspace": [0.3, 0.8, 101]}, OUTLINE: {"linspace": [110, 122, 100]}}
REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"axis": {}}, 'axis = {}: '),
    ({"base": None}, "base = null: "),
    ({"base": 3}, "base = 3: "),
    ({"base": "none.toml"}, "none.toml: "),
    ({"base": {"name": "x"}}, "requirements: "),
    ({"name": "../x"}, 'name = "../x": '),
    ({"name": 5}, "name = 5: "),
    ({"method": "magic"}, 'method = "magic": '),
    ({"seeds": []}, "seeds = []: 1 1000 0"),
    ({"seeds": [1, 1]}, "seeds = [1, 1]: "),
    ({"seeds": [True]}, "seeds = [true]: "),
    ({"seeds": [-1]}, "seeds = [-1]: "),
    ({"seeds": 3}, "seeds = 3: "),
    ({"seeds": LONG}, "seeds = [0, 1, 2"),
    ({"steps": [2, 1]}, "steps = [2, 1]: 1 2 3"),
    ({"steps": [4]}, "steps = [4]: "),
    ({"steps": [3]}, "steps = [3]: 3 2 step_3.half_side_mm"),
    ({"population": 3}, "population = 3: 4 100,000"),
    ({"population": 8.0}, "population = 8.0: "),
    ({"generations": 0}, "generations = 0: 1"),
    ({"axes": []}, "axes = []: "),
    ({"axes": {}}, "axes = {}: "),
    ({"axes": {"limits": {}}}, 'axes = {"limits": '),
    ({"axes": {"name": [1]}}, "axes.name: requirements.envelope_width_mm"),
    ({"axes": {"limits.depth": [1]}}, "axes.limits.depth: limits.outline_radius_max"),
    ({"axes": {TORQUE: [0.4], "requirements": {"joint_torque_N_m": [0.5]}}}, f"axes.{TORQUE}: "),
    ({"axes": {TORQUE: 0.4}}, f"axes.{TORQUE} = 0.4: 1 1000"),
    ({"axes": {TORQUE: []}}, f"axes.{TORQUE} = []: 1"),
    ({"axes": {TORQUE: LONG}}, f"axes.{TORQUE} = [0, 1"),
    ({"axes": {TORQUE: [0.4, math.nan]}}, f"axes.{TORQUE}[1] = NaN: "),
    ({"axes": {TORQUE: [math.inf]}}, f"axes.{TORQUE}[0] = Infinity: "),
    ({"axes": {TORQUE: ["0.4"]}}, f'axes.{TORQUE}[0] = "0.4": '),
    ({"axes": {TORQUE: [True]}}, f"axes.{TORQUE}[0] = true: "),
    ({"axes": {TORQUE: [10**400]}}, f"axes.{TORQUE}[0]"),
    ({"axes": {TORQUE: [[[1]]]}}, f"axes.{TORQUE}[0] = [[1]]: "),
    ({"axes": {TORQUE: [0.4, 0.8, 0.4]}}, f"axes.{TORQUE}[2] = 0.4: "),
    ({"axes": {TORQUE: {"linspace": [1, 2, 3], "geomspace": [1, 2, 3]}}}, f"axes.{TORQUE} = {{"),
    ({"axes": {TORQUE: {"logspace": [1, 2, 3]}}}, f"axes.{TORQUE} = {{"),
    ({"axes": {TORQUE: {"linspace": [1, 2]}}}, f"axes.{TORQUE}.linspace = [1, 2]: "),
    ({"axes": {TORQUE: {"linspace": [1, 2, 1]}}}, f"axes.{TORQUE}.linspace = [1, 2, 1]: 2 1000"),
    ({"axes": {TORQUE: {"linspace": [1, 2, 2.5]}}}, f"axes.{TORQUE}.linspace = [1, 2, 2.5]: 2 1000"),
    ({"axes": {TORQUE: {"linspace": [math.nan, 2, 3]}}}, f"axes.{TORQUE}.linspace"),
    ({"axes": {TORQUE: {"linspace": 3}}}, "linspace = 3: "),
    ({"axes": {TORQUE: {"geomspace": [0, 2, 3]}}}, f"axes.{TORQUE}.geomspace = [0, 2, 3]: 0"),
    ({"axes": {TORQUE: {"linspace": [0.5, 0.5, 3]}}}, f"axes.{TORQUE}[1] = 0.5: "),
    ({"axes": WIDE}, "axes: 10,100 10,000"),
    # what a requirements file refuses, a set refuses in its words
    ({"axes": {TORQUE: [-0.4]}}, f"{TORQUE} = -0.4: 1e-06 100"),
    ({"axes": {"limits.gravity_torque_N_m": [0.1, 0.9]}}, "limits.gravity_torque_N_m = 0.9: "),
    ({"axes": {"bounds_mm.half_side": [[50, 40]]}}, "bounds_mm.half_side = [50.0, 40.0]: "),
    ({"axes": {"bounds_mm.half_side": [[1, 2, 3]]}}, "bounds_mm.half_side"),
    ({"axes": {TORQUE: [[0.4, 0.8]]}}, f"{TORQUE} = [0.4, 0.8]: "),
]  # fmt: skip


@pytest.mark.parametrize(("change", "words"), REFUSED, ids=[words[:40] for _, words in REFUSED])
def test_what_is_wrong_is_refused_in_one_line(change: dict[str, Any], words: str) -> None:
    with pytest.raises(RequirementsError) as caught:
        grid(**change)
    text = str(caught.value)
    assert holds(text, words)
    assert "\n" not in text
    assert len(text) < 700
    if not str(change.get("base")).endswith(".toml"):
        assert text.startswith("g.toml: ")


def test_missing_base_and_axes_are_reported() -> None:
    for data, field in (({"axes": {}}, "base"), ({"base": BASE}, "axes")):
        with pytest.raises(GridError) as caught:
            grid_from_dict(data, "g")
        assert (caught.value.file, caught.value.field, caught.value.value) == ("g", field, "")


@pytest.mark.parametrize("content", [b"a = [", b"\xff", None])
def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "g.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(GridError) as caught:
        load_grid(path)
    assert (caught.value.file, caught.value.field) == ("g.toml", "")


@pytest.mark.slow
def test_the_largest_atlas_is_taken() -> None:
    axes = {TORQUE: {"linspace": [0.3, 0.8, 100]}, OUTLINE: {"linspace": [110, 122, 100]}}
    assert len(grid(axes).sets) == SETS_MAX


def test_a_set_is_what_the_requirements_file_would_be() -> None:
    (one,) = grid({TORQUE: [0.8]}).sets
    from optimizer.problem.requirements import requirements_from_dict

    assert requirements_from_dict(one.requirements) == load_requirements(JOYSTICK)


BRIEF = {"name": "b", "requirements": {"envelope_width_mm": 270, "envelope_depth_mm": 220}}


def test_a_grid_of_machines_has_briefs_and_may_vary_what_is_felt_and_the_hardware() -> None:
    motors = ["maxon-re30-310007", "maxon-re50-370354"]
    axes = {"feel.friction_max_N": [0.5, 0.8], "hardware.motor": motors}
    found = grid_from_dict({"base": BRIEF, "axes": axes, "method": MACHINES}, "g.toml")
    reported = [
        (one.requirements["feel"]["friction_max_N"], one.requirements["hardware"]["motor"]) for one in found.sets
    ]
    assert reported == [(0.5, motors[0]), (0.5, motors[1]), (0.8, motors[0]), (0.8, motors[1])]
    assert all(Path(one.folder).is_absolute() for one in found.sets)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"steps": [1]}, 'steps = [1]: is of the paper\'s method: method = "design" has none'),
        ({"axes": {"hardware.motor": ["none-such"]}}, "hardware.motor"),
        ({"axes": {"feel.friction": [0.5]}}, "axes.feel.friction"),
        ({"axes": {"step_3.half_side_mm": [30.0]}}, "axes.step_3.half_side_mm"),
        ({"base": {"name": "b"}}, "must state an outline"),
    ],
)
def test_a_grid_of_machines_that_is_refused_says_why(more: dict[str, Any], message: str) -> None:
    given = {"base": BRIEF, "axes": {"requirements.force_N": [2, 3]}, "method": MACHINES} | more
    with pytest.raises(RequirementsError) as reported:
        grid_from_dict(given, "g.toml")
    assert message in "\n".join(reported.value.lines)
