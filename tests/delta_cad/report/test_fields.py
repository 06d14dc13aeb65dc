"""Figures over the cube: what is drawn where, which end is bad, and what the checks say of the same machine."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from delta_cad.checks.clearance.clearance import MAP_CELLS
from delta_cad.checks.limits import SLICES
from delta_cad.design import Design
from delta_cad.mechanism.statics import conditioning, worst_joint_torque
from delta_cad.report.fields import CELLS, Field
from tests.committed import Built
from tests.delta_cad.report.reading import Page


@pytest.fixture(scope="module")
def slices(page: Page) -> dict[str, Any]:
    return page.data()["slices"]


def test_a_map_is_its_figure_at_its_place(slices: dict[str, Any], best: Design) -> None:
    maps = {one["name"]: one for one in slices["maps"]}
    assert list(maps) == ["kappa", "effective_mass", "friction", "stiffness", "torque", "clearance"]
    x, z = maps["kappa"]["x_mm"], slices["z_mm"]
    assert (len(x), len(z)) == (CELLS, SLICES)
    low = best.cube.bottom_height_mm
    assert (z[0], z[-1]) == pytest.approx((low, low + 2.0 * best.cube.half_side_mm))
    for k, j, i in ((0, 0, 0), (1, 3, 12), (4, 16, 2)):
        p = np.array([x[i], x[j], z[k]]) / 1000.0
        assert maps["kappa"]["values"][k][j][i] == pytest.approx(float(conditioning(best.geometry, p)), rel=1e-3)
        force = worst_joint_torque(best.geometry, p, best.requirements.force_N).max()
        assert maps["torque"]["values"][k][j][i] > force - 0.1
    for one in maps.values():
        values = np.array(one["values"])
        cells = MAP_CELLS if one["name"] == "clearance" else CELLS
        assert values.shape == (SLICES, cells, cells)
        assert (one["x_mm"][0], one["x_mm"][-1]) == pytest.approx((x[0], x[-1]))
        if one["name"] in ("kappa", "effective_mass", "friction"):  # motors stand on one side of an arm
            assert values[:, ::-1, :] == pytest.approx(values, rel=2e-3)  # the mirror in the plane of x and z


def test_the_worst_of_the_maps_is_that_of_the_checks(slices: dict[str, Any], built: Built) -> None:
    checks = {c["name"]: c for c in json.loads((built.folder / "checks.json").read_text())["checks"]}
    maps = {one["name"]: one for one in slices["maps"]}
    for name, check in (
        ("kappa", "kappa"),
        ("stiffness", "structure stiffness at the knob"),
        ("torque", "torque with gravity"),
    ):
        values, one = np.array(maps[name]["values"]), checks[check]
        worst = values.max() if maps[name]["upper"] else values.min()
        assert worst == pytest.approx(one["value"], rel=2e-3)  # both grids have the corners, where these are worst
        assert maps[name]["limit"] == one["limit"]


def test_the_map_of_clearance_names_two_bodies_and_is_no_less_than_the_check(page: Page, built: Built) -> None:
    checks = {c["name"]: c for c in json.loads((built.folder / "checks.json").read_text())["checks"]}
    one = next(one for one in page.data()["slices"]["maps"] if one["name"] == "clearance")
    values, pairs = np.array(one["values"]), np.array(one["pairs"])
    assert pairs.shape == values.shape
    assert set(pairs.flat) == set(range(len(one["names"])))
    for name in one["names"]:
        a, b = name.split(" / ")
        assert {a, b} <= set(page.data()["occurrences"])
    assert values.min() >= checks["clearance"]["value"] - 0.1  # single joints and other positions may have less
    assert f"of all bodies {checks['clearance']['value']:.3g} mm" in one["note"]
    least = {one["names"][k] for k in pairs[values == values.min()]}  # values are rounded: several may have the least
    assert any(f"Closest: {pair};" in one["note"] for pair in least)
    assert one["limit"] == checks["clearance"]["limit"]


def test_the_feel_of_the_structure_is_that_of_its_file(page: Page, built: Built) -> None:
    structure = json.loads((built.folder / "structure.json").read_text())
    reported = {row[0]: row for row in page.rows("feel")[1:]}
    centre, (new, settled) = structure["centre"], structure["band_N_mm"]
    assert float(reported["Stiffness at the knob"][1].split()[0]) == pytest.approx(centre["softest_new_N_mm"], rel=1e-3)
    assert float(reported["Stiffness at the knob"][2].split()[0]) == pytest.approx(new, rel=1e-3)
    assert settled == structure["softest"]["softest_N_mm"] > new
    assert float(reported["First mode"][1].split()[0]) == pytest.approx(centre["first_mode_Hz"], rel=1e-3)
    assert float(reported["First mode"][2].split()[0]) == pytest.approx(structure["slowest"]["first_mode_Hz"], rel=1e-3)
    masses = json.loads((built.folder / "mass_properties.json").read_text())
    assert float(reported["Moving mass"][2].split()[0]) == pytest.approx(1000.0 * masses["moving_mass_kg"], rel=1e-3)


@pytest.mark.parametrize(("upper", "value", "place"), [(True, 9.0, 3.0), (False, 0.0, 0.0)])
def test_the_worst_is_at_the_bad_end(upper: bool, value: float, place: float) -> None:
    sampled = np.array([[x, 0.0, 0.0] for x in (-2.0, 0.0, 3.0)])
    field = Field("f", "f", "", upper, None, lambda p: p[:, 0] ** 2, False, "", sampled)
    assert field.worst()[0] == value
    assert field.worst()[1] == pytest.approx([place, 0.0, 0.0])
