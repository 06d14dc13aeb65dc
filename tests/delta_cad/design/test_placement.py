"""Where chains and cube stand, as a design file says it: read, left out, refused with field, value and bound."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from delta_cad.design import DesignError, design_from_dict, design_hash, design_to_dict, design_to_json
from delta_cad.mechanism.geometry import THREE_FOLD
from tests.designs import minimal

RADII, AZIMUTHS = [31.19, 38.45, 38.45], [0.0, 116.3, -116.3]


def placed(**values: Any) -> dict[str, Any]:
    data = minimal()
    if "base_radii_mm" in values:
        del data["mechanism"]["base_radius_mm"]
    for name, value in values.items():
        data["cube" if name == "centre_x_mm" else "mechanism"][name] = value
    return data


def test_chains_and_cube_stand_where_the_file_says() -> None:
    design = design_from_dict(placed(azimuths_deg=AZIMUTHS, base_radii_mm=RADII, centre_x_mm=11.1))
    g, cube = design.geometry, design.workspace
    np.testing.assert_allclose(np.degrees(g.azimuths), [0.0, 116.3, 360.0 - 116.3], rtol=1e-14)
    np.testing.assert_allclose(g.base_radii, np.array(RADII) / 1e3, rtol=1e-15)
    assert design.mechanism.base_radius_mm == 31.19  # that of chain 0
    assert cube.centre[0] == 0.0111
    shoulders = g.base_radii[:, None] * g.radial
    expected = [(31.19, 0.0), *((38.45 * math.cos(a), 38.45 * math.sin(a)) for a in np.radians(AZIMUTHS[1:]))]
    np.testing.assert_allclose(1e3 * shoulders[:, :2], expected, atol=1e-13)
    assert not g.three_fold


def test_what_is_left_out_is_not_written_and_changes_no_hash() -> None:
    data = minimal()
    design = design_from_dict(data)
    assert design.geometry.three_fold
    assert design.workspace.centre_x == 0.0
    assert not any(name in design_to_json(design) for name in ("azimuths_deg", "base_radii_mm", "centre_x_mm"))
    given = design_from_dict(placed(azimuths_deg=AZIMUTHS, base_radii_mm=RADII, centre_x_mm=11.1))
    again = design_from_dict(json.loads(design_to_json(given)))
    assert (again.geometry, again.workspace) == (given.geometry, given.workspace)
    assert design_to_dict(again) == design_to_dict(given)
    assert len({design_hash(one) for one in (design, given)}) == 2


@pytest.mark.parametrize("azimuths", [[0, 120, -120], [0.0, 120.0, 240.0], [360.0, 120.0, 240.0]])
def test_a_hundred_and_twenty_degrees_are_exact(azimuths: list[float]) -> None:
    g = design_from_dict(placed(azimuths_deg=azimuths, base_radii_mm=[40.0, 40.0, 40.0])).geometry
    assert g.side_cosine == THREE_FOLD
    assert g == design_from_dict(minimal()).geometry


@pytest.mark.parametrize(
    ("field", "value", "allowed"),
    [
        ("azimuths_deg", [1.0, 116.3, -116.2], "[0, phi, -phi]"),
        ("azimuths_deg", [0.0, 200.0, -116.2], ">= 60 and <= 150 deg"),
        ("azimuths_deg", [0.0, 59.9, -59.9], ">= 60 and <= 150 deg"),
        ("azimuths_deg", [0.0, 150.1, -150.1], ">= 60 and <= 150 deg"),
        ("azimuths_deg", [0.0, 116.3], "[0, phi, -phi]"),
        ("azimuths_deg", "120", "[0, phi, -phi]"),
        ("azimuths_deg", [0.0, "116.3", -116.3], "[0, phi, -phi]"),
        ("base_radii_mm", [31.19, 0.0, 1.0], "the second and the third equal"),
        ("base_radii_mm", [31.19, 0.0, 0.0], "> 0 and <= 1000 mm"),
        ("base_radii_mm", [31.19, 1001.0, 1001.0], "> 0 and <= 1000 mm"),
        ("base_radii_mm", [31.19, 38.45], "3 numbers"),
        ("centre_x_mm", 1000.5, "<= 1000"),
        ("centre_x_mm", "11", "number"),
    ],
)
def test_a_placement_that_cannot_be_is_refused(field: str, value: Any, allowed: str) -> None:
    with pytest.raises(DesignError) as caught:
        design_from_dict(placed(**{field: value}))
    section = "cube" if field == "centre_x_mm" else "mechanism"
    assert caught.value.field.startswith(f"{section}.{field}")
    assert allowed in caught.value.allowed, caught.value.allowed


@pytest.mark.parametrize(
    ("field", "value", "words", "write"),
    [
        ("azimuths_deg", [0, 120.7, -119], "the second and third must be mirror images", [0, 120.7, -120.7]),
        ("azimuths_deg", [0.0, 116.3, 243.8], "the second and third must be mirror images", [0, 116.3, -116.3]),
        ("azimuths_deg", [0, -120.73, 120.73], "chains 1 and 2 are exchanged", [0, 120.73, -120.73]),
        ("azimuths_deg", [0, 243.7, 116.3], "chains 1 and 2 are exchanged", [0, 116.3, -116.3]),
        ("azimuths_deg", [1.0, 116.3, -116.3], "the first must be 0", [0, 116.3, -116.3]),
        ("base_radii_mm", [25.576, 41.674, 42], "the second and third must be equal", [25.576, 41.674, 41.674]),
    ],
)
def test_entries_that_do_not_mirror_are_named_with_what_to_write(
    field: str, value: list[float], words: str, write: list[float]
) -> None:
    with pytest.raises(DesignError) as caught:
        design_from_dict(placed(**{field: value}))
    assert caught.value.field == f"mechanism.{field}"
    assert words in caught.value.allowed
    assert caught.value.allowed.endswith(f": write {write}")
    design_from_dict(placed(**{field: write}))


@pytest.mark.parametrize(
    ("written", "plain"),
    [
        ({"azimuths_deg": [0, 120, 240], "base_radii_mm": [40.0, 40.0, 40.0], "centre_x_mm": 0.0}, {}),
        ({"azimuths_deg": [360.0, 116.3, 243.7]}, {"azimuths_deg": AZIMUTHS}),
        ({"base_radii_mm": RADII}, {"base_radii_mm": RADII, "base_radius_mm": 31.19}),
    ],
)
def test_equal_machines_have_one_hash(written: dict[str, Any], plain: dict[str, Any]) -> None:
    one, other = design_from_dict(placed(**written)), design_from_dict(placed(**plain))
    assert design_to_json(one) == design_to_json(other)
    assert design_hash(one) == design_hash(other)


@pytest.mark.parametrize("own", [-1.0, "x", True])
def test_a_base_radius_is_refused_by_its_own_rule_where_those_of_the_chains_stand(own: Any) -> None:
    with pytest.raises(DesignError, match=r"mechanism\.base_radius_mm = .* must be"):
        design_from_dict(placed(base_radii_mm=RADII, base_radius_mm=own))


def test_a_base_radius_that_is_not_that_of_chain_0_is_refused() -> None:
    """Dropped, it left a machine whose file said another radius than the one that was judged."""
    with pytest.raises(DesignError) as caught:
        design_from_dict(placed(base_radii_mm=RADII, base_radius_mm=30), "some.json")
    assert str(caught.value) == (
        "some.json: mechanism.base_radius_mm = 30: must equal base_radii_mm[0] = 31.19, or be left out; "
        "base_radii_mm decides"
    )
    with pytest.raises(DesignError, match=r"mechanism\.base_radius_mm = 41\.0: must equal base_radii_mm\[0\] = 40\.0"):
        design_from_dict(placed(base_radii_mm=[40.0, 40.0, 40.0], base_radius_mm=41.0))


@pytest.mark.parametrize("radii", [[], [31.0, 38.0], [True, 38.0, 38.0], 5])
def test_wrong_radii_are_named_where_no_base_radius_stands(radii: Any) -> None:
    data = placed(base_radii_mm=radii)
    with pytest.raises(DesignError, match=r"mechanism\.base_radii_mm"):
        design_from_dict(data)
