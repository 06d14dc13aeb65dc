"""Grid files: spread out in order, and refused with field, value and what is allowed."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from optimizer.atlas.grid import SETS_MAX, VALUES_MAX, Grid, GridError, grid_from_dict, load_grid
from optimizer.problem.requirements import RequirementsError, load_requirements

JOYSTICK = Path(__file__).parents[3] / "joystick.toml"
BASE = tomllib.loads(JOYSTICK.read_text())
TORQUE, OUTLINE = "requirements.joint_torque_N_m", "limits.outline_radius_max_mm"


def grid(axes: Any = None, **more: Any) -> Grid:
    return grid_from_dict({"base": BASE, "axes": {TORQUE: [0.4, 0.8]} if axes is None else axes} | more, "g.toml")


def test_every_combination_and_every_seed_is_a_set_the_last_axis_fastest() -> None:
    found = grid({OUTLINE: [118, 122], TORQUE: [0.4, 0.6, 0.8]}, seeds=[3, 1], method="sqp", steps=[1, 2])
    assert [axis.field for axis in found.axes] == [OUTLINE, TORQUE]
    assert [one.index for one in found.sets] == list(range(12))
    told = [(one.inputs[OUTLINE], one.inputs[TORQUE], one.seed) for one in found.sets]
    assert told[:4] == [(118, 0.4, 3), (118, 0.4, 1), (118, 0.6, 3), (118, 0.6, 1)]
    assert len(set(told)) == 12
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
    ({"axis": {}}, 'axis = {}: unknown key; known here: name, base, axes, method, seeds, steps'),
    ({"base": None}, "base = null: must be the path of a requirements file, or its tables"),
    ({"base": 3}, "base = 3: must be the path"),
    ({"base": "none.toml"}, "none.toml: cannot be read: No such file"),
    ({"base": {"name": "x"}}, "g.toml: base: requirements: is missing"),
    ({"name": "../x"}, 'name = "../x": '),
    ({"name": 5}, "name = 5: "),
    ({"method": "magic"}, 'method = "magic": must be one of ga, sqp, ga+sqp'),
    ({"seeds": []}, "seeds = []: must be a list of 1 to 1000 different whole numbers >= 0"),
    ({"seeds": [1, 1]}, "seeds = [1, 1]: "),
    ({"seeds": [True]}, "seeds = [true]: "),
    ({"seeds": [-1]}, "seeds = [-1]: "),
    ({"seeds": 3}, "seeds = 3: "),
    ({"seeds": LONG}, "seeds = [0, 1, 2"),
    ({"steps": [2, 1]}, "steps = [2, 1]: must be a list of 1, 2, 3, each once at most, in order"),
    ({"steps": [4]}, "steps = [4]: "),
    ({"steps": [3]}, "steps = [3]: step 3 needs step 2 or step_3.half_side_mm"),
    ({"population": 3}, "population = 3: must be a whole number >= 4 and <= 100,000"),
    ({"population": 8.0}, "population = 8.0: "),
    ({"generations": 0}, "generations = 0: must be a whole number >= 1"),
    ({"axes": []}, "axes = []: must be a table of dotted fields"),
    ({"axes": {}}, "axes = {}: must hold at least one dotted field"),
    ({"axes": {"limits": {}}}, 'axes = {"limits": {}}: must hold at least one'),
    ({"axes": {"name": [1]}}, "axes.name: is no field that can vary; known: requirements.envelope_width_mm"),
    ({"axes": {"limits.depth": [1]}}, "axes.limits.depth: is no field that can vary; known: limits.outline_radius_max"),
    ({"axes": {TORQUE: [0.4], "requirements": {"joint_torque_N_m": [0.5]}}}, f"axes.{TORQUE}: is given twice"),
    ({"axes": {TORQUE: 0.4}}, f"axes.{TORQUE} = 0.4: must be a list of 1 to 1000 values, or {{linspace = "),
    ({"axes": {TORQUE: []}}, f"axes.{TORQUE} = []: must be a list of 1"),
    ({"axes": {TORQUE: LONG}}, f"axes.{TORQUE} = [0, 1"),
    ({"axes": {TORQUE: [0.4, math.nan]}}, f"axes.{TORQUE}[1] = NaN: must be a finite number, or a list of such"),
    ({"axes": {TORQUE: [math.inf]}}, f"axes.{TORQUE}[0] = Infinity: "),
    ({"axes": {TORQUE: ["0.4"]}}, f'axes.{TORQUE}[0] = "0.4": '),
    ({"axes": {TORQUE: [True]}}, f"axes.{TORQUE}[0] = true: "),
    ({"axes": {TORQUE: [10**400]}}, f"axes.{TORQUE}[0] = 1000"),
    ({"axes": {TORQUE: [[[1]]]}}, f"axes.{TORQUE}[0] = [[1]]: "),
    ({"axes": {TORQUE: [0.4, 0.8, 0.4]}}, f"axes.{TORQUE}[2] = 0.4: is there twice"),
    ({"axes": {TORQUE: {"linspace": [1, 2, 3], "geomspace": [1, 2, 3]}}}, "must hold one key, linspace or geomspace"),
    ({"axes": {TORQUE: {"logspace": [1, 2, 3]}}}, "must hold one key, linspace or geomspace"),
    ({"axes": {TORQUE: {"linspace": [1, 2]}}}, f"axes.{TORQUE}.linspace = [1, 2]: must be [first, last, count]"),
    ({"axes": {TORQUE: {"linspace": [1, 2, 1]}}}, "2 to 1000 of them"),
    ({"axes": {TORQUE: {"linspace": [1, 2, 2.5]}}}, "2 to 1000 of them"),
    ({"axes": {TORQUE: {"linspace": [math.nan, 2, 3]}}}, "finite numbers"),
    ({"axes": {TORQUE: {"linspace": 3}}}, "linspace = 3: must be [first"),
    ({"axes": {TORQUE: {"geomspace": [0, 2, 3]}}}, f"axes.{TORQUE}.geomspace = [0, 2, 3]: both ends must be > 0"),
    ({"axes": {TORQUE: {"linspace": [0.5, 0.5, 3]}}}, f"axes.{TORQUE}[1] = 0.5: is there twice"),
    ({"axes": WIDE}, "axes: 10,100 sets, seeds included; at most 10,000 are solved at once"),
    # what a requirements file refuses, a set refuses in its words
    ({"axes": {TORQUE: [-0.4]}}, f"{TORQUE} = -0.4: must be a number > 0 and <= 100 N m"),
    ({"axes": {"limits.gravity_torque_N_m": [0.1, 0.9]}}, "limits.gravity_torque_N_m = 0.9: must be < "),
    ({"axes": {"bounds_mm.half_side": [[50, 40]]}}, "bounds_mm.half_side = [50.0, 40.0]: bounds are swapped"),
    ({"axes": {"bounds_mm.half_side": [[1, 2, 3]]}}, "bounds_mm.half_side"),
    ({"axes": {TORQUE: [[0.4, 0.8]]}}, f"{TORQUE} = [0.4, 0.8]: must be a number"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "words"), REFUSED, ids=[words[:40] for _, words in REFUSED])
def test_what_is_wrong_is_refused_in_one_line(change: dict[str, Any], words: str) -> None:
    with pytest.raises(RequirementsError) as caught:
        grid(**change)
    text = str(caught.value)
    assert words in text
    assert "\n" not in text
    assert len(text) < 700
    if not str(change.get("base")).endswith(".toml"):
        assert text.startswith("g.toml: ")


def test_missing_base_and_axes_are_told() -> None:
    with pytest.raises(GridError, match=r"^g: base: is missing; it must be the path"):
        grid_from_dict({"axes": {}}, "g")
    with pytest.raises(GridError, match=r"^g: axes: must be a table of dotted fields"):
        grid_from_dict({"base": BASE}, "g")


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"a = [", "is not TOML we can read"), (b"\xff", "is not UTF-8 text"), (None, "cannot be read: No such file")],
)
def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path, content: bytes | None, words: str) -> None:
    path = tmp_path / "g.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(GridError, match=rf"^g\.toml: {words}"):
        load_grid(path)


def test_the_largest_atlas_is_taken() -> None:
    axes = {TORQUE: {"linspace": [0.3, 0.8, 100]}, OUTLINE: {"linspace": [110, 122, 100]}}
    assert len(grid(axes).sets) == SETS_MAX


def test_a_set_is_what_the_requirements_file_would_be() -> None:
    (one,) = grid({TORQUE: [0.8]}).sets
    from optimizer.problem.requirements import requirements_from_dict

    assert requirements_from_dict(one.requirements) == load_requirements(JOYSTICK)
