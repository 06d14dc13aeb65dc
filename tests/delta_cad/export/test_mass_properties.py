"""Mass properties against closed forms: box, cylinder, sphere, parallel axes, catalogue masses, whole machine."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.export.mass_properties import (
    MassProperties,
    MassPropertiesError,
    combined,
    link_mass_properties,
    mass_report,
    part_mass_properties,
)
from delta_cad.mechanism.placement import LINKS
from delta_cad.solids.part import Occurrence, Part
from tests.delta_cad.export.machine import ALUMINIUM, ARM_MM, STEEL, VOLUMES_MM3, make_assembly, one_solid, translation

EXACT = 1e-9
"""Relative: the kernel integrates planes, cylinders and spheres by Gauss rules that are exact up to rounding."""
TINY = 1e-18
"""kg m^2: nine decades below the smallest inertia in these tests."""


def box() -> Part:
    import cadquery as cq

    solid = one_solid(cq.Workplane().box(20.0, 30.0, 50.0).translate((7.0, -3.0, 11.0)))
    return Part("box", "Box", solid, ALUMINIUM, True)


def test_box() -> None:
    found = part_mass_properties(box())
    mass = 2810.0 * 0.02 * 0.03 * 0.05
    assert found.mass_kg == pytest.approx(mass, rel=EXACT)
    np.testing.assert_allclose(found.centre_m, [0.007, -0.003, 0.011], rtol=EXACT)
    expected = mass / 12 * np.diag([0.03**2 + 0.05**2, 0.02**2 + 0.05**2, 0.02**2 + 0.03**2])
    np.testing.assert_allclose(found.inertia_kg_m2, expected, rtol=EXACT, atol=TINY)


def test_cylinder() -> None:
    import cadquery as cq

    part = Part("pin", "Pin", one_solid(cq.Workplane().circle(4.0).extrude(30.0)), STEEL, True)
    found = part_mass_properties(part)
    mass = 7900.0 * math.pi * 0.004**2 * 0.03
    across = mass * (3 * 0.004**2 + 0.03**2) / 12
    np.testing.assert_allclose(found.centre_m, [0, 0, 0.015], rtol=EXACT, atol=1e-15)
    np.testing.assert_allclose(
        found.inertia_kg_m2, np.diag([across, across, mass * 0.004**2 / 2]), rtol=EXACT, atol=TINY
    )


def test_sphere_with_a_catalogue_mass_keeps_its_shape() -> None:
    import cadquery as cq

    ball = Part("ball", "Ball", cq.Solid.makeSphere(4.0, angleDegrees1=-90), STEEL, False, mass_g=2.5)
    found = part_mass_properties(ball)
    assert found.mass_kg == 0.0025
    np.testing.assert_allclose(found.inertia_kg_m2, 0.4 * 0.0025 * 0.004**2 * np.eye(3), rtol=EXACT, atol=TINY)


def test_products_of_inertia_have_the_sign_of_the_tensor() -> None:
    a = MassProperties(1.0, np.array([1.0, 1.0, 0.0]), np.zeros((3, 3)))
    b = MassProperties(1.0, np.array([-1.0, -1.0, 0.0]), np.zeros((3, 3)))
    np.testing.assert_array_equal(combined([a, b]).inertia_kg_m2, [[2, -2, 0], [-2, 2, 0], [0, 0, 4]])


def test_a_skew_solid_has_the_tensor_of_its_points() -> None:
    """A box turned about z, against the rotated closed form: this sees a transposed rotation or a wrong sign."""
    import cadquery as cq

    solid = one_solid(cq.Workplane().box(10.0, 40.0, 4.0).rotate((0, 0, 0), (0, 0, 1), 30.0))
    found = part_mass_properties(Part("bar", "Bar", solid, STEEL, True))
    mass = 7900.0 * 0.01 * 0.04 * 0.004
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    straight = mass / 12 * np.diag([0.04**2 + 0.004**2, 0.01**2 + 0.004**2, 0.01**2 + 0.04**2])
    np.testing.assert_allclose(found.inertia_kg_m2, turn @ straight @ turn.T, rtol=EXACT, atol=TINY)
    frame = np.eye(4)
    frame[:3, :3] = turn.T
    np.testing.assert_allclose(found.moved(frame).inertia_kg_m2, straight, rtol=EXACT, atol=TINY)


def test_two_halves_make_the_whole_box() -> None:
    import cadquery as cq

    half = Part("half", "Half", one_solid(cq.Workplane().box(10.0, 30.0, 50.0)), ALUMINIUM, True)
    whole = Part("whole", "Whole", one_solid(cq.Workplane().box(20.0, 30.0, 50.0)), ALUMINIUM, True)
    a = part_mass_properties(half)
    found = combined([a.moved(translation(-5.0, 0, 0)), a.moved(translation(5.0, 0, 0))])
    expected = part_mass_properties(whole)
    assert found.mass_kg == pytest.approx(expected.mass_kg, rel=EXACT)
    np.testing.assert_allclose(found.centre_m, expected.centre_m, atol=1e-15)
    np.testing.assert_allclose(found.inertia_kg_m2, expected.inertia_kg_m2, rtol=EXACT, atol=TINY)


def test_links_carry_their_parts_in_their_own_frame(machine: Assembly) -> None:
    links = link_mass_properties(machine)
    assert list(links) == [link for link in LINKS if not link.startswith(("pinion", "spring"))]
    arm, ball = VOLUMES_MM3["upper_arm"] * 2.81e-6, 0.00205
    for i in range(3):
        found = links[f"upper_arm_{i}"]
        assert found.mass_kg == pytest.approx(arm + 2 * ball, rel=EXACT)
        along = (arm * ARM_MM / 2 + 2 * ball * ARM_MM) / (arm + 2 * ball) * 1e-3
        np.testing.assert_allclose(found.centre_m, [along, 0, 0], atol=1e-12)
    np.testing.assert_allclose(links["rod_0_0"].centre_m, [0.112079 / 2, 0, 0], atol=1e-12)


def test_the_whole_hangs_together(machine: Assembly) -> None:
    report = json.loads(json.dumps(mass_report(machine)))
    masses = {number: entry["mass_kg"] for number, entry in report["parts"].items()}
    assert report["total_mass_kg"] == pytest.approx(sum(masses[o.part.number] for o in machine.occurrences), rel=EXACT)
    assert report["moving_mass_kg"] == pytest.approx(report["total_mass_kg"] - report["bodies"]["base"]["mass_kg"])
    poses = machine.poses(machine.home_mm)
    centre = sum(
        masses[o.part.number]
        * (poses[o.name] @ [*(1000 * np.array(report["parts"][o.part.number]["centre_m"])), 1.0])[:3]
        for o in machine.occurrences
    )
    np.testing.assert_allclose(
        np.array(report["assembly"]["centre_m"]) * 1000, centre / report["total_mass_kg"], atol=1e-9
    )
    assert report["parts"]["ball_8"]["mass_source"] == "catalogue"
    assert report["parts"]["platform"]["volume_m3"] == pytest.approx(VOLUMES_MM3["platform"] * 1e-9)
    for entry in (*report["parts"].values(), *report["bodies"].values()):
        principal = np.linalg.eigvalsh(entry["inertia_kg_m2"])
        assert principal[0] > 0
        assert principal[2] <= principal[0] + principal[1]  # triangle inequality of every real body


def test_mass_does_not_depend_on_the_pose() -> None:
    machine = make_assembly()
    away = replace(machine, home_mm=np.array([20.0, -15.0, 110.0]))
    for link, body in link_mass_properties(machine).items():
        np.testing.assert_array_equal(body.inertia_kg_m2, link_mass_properties(away)[link].inertia_kg_m2)


def test_a_spring_weighs_half_on_either_rod_and_moves_as_it_does() -> None:
    """Kinetic energy of a steady motion by the spring's own middle, by differences, against the rods' points."""
    machine = make_assembly()
    suspended = replace(machine.placement, springs_mm=((30.0, -5.5), (80.0, 5.5)), eye_inside_mm=0.8)
    spring = replace(box(), mass_g=10.0)
    bare = link_mass_properties(replace(machine, placement=suspended))
    placed = Occurrence("spring", spring, "spring_1_0", np.eye(4))
    heavy = replace(machine, placement=suspended, occurrences=(*machine.occurrences, placed))
    links = link_mass_properties(heavy)
    assert set(links) == set(bare)
    for link, body in links.items():
        more = body.mass_kg - bare[link].mass_kg
        assert more == pytest.approx(0.005 if link.startswith("rod_1") else 0.0, abs=1e-15)
        if more > 1e-6:
            moment = body.mass_kg * body.centre_m - bare[link].mass_kg * bare[link].centre_m
            np.testing.assert_allclose(moment, [0.005 * 0.030, 0.0, 0.0], atol=1e-15)
    report = mass_report(heavy)
    assert report["total_mass_kg"] == pytest.approx(mass_report(machine)["total_mass_kg"] + 0.010)
    p, way = machine.home_mm + np.array([5.0, -9.0, 4.0]), np.array([0.3, -0.5, 0.2])
    before, after = (suspended(p + s * 1e-3 * way) for s in (-1.0, 1.0))
    speed = np.linalg.norm(after["spring_1_0"][:3, 3] - before["spring_1_0"][:3, 3])
    point = np.array([30.0, 0.0, 0.0, 1.0])
    for side in range(2):
        lumped = np.linalg.norm(((after[f"rod_1_{side}"] - before[f"rod_1_{side}"]) @ point)[:3])
        assert lumped == pytest.approx(speed, rel=0.1)  # 5.5 mm of 30 mm from the elbow, where it moves least


def test_an_inside_out_solid_is_refused() -> None:
    import cadquery as cq

    part = box()
    inside_out = cq.Shape.cast(part.solid.wrapped.Reversed())
    with pytest.raises(MassPropertiesError, match=r"box .* -30000 mm"):
        part_mass_properties(replace(part, solid=inside_out))  # type: ignore[arg-type]


def test_a_part_without_mass_is_refused() -> None:
    with pytest.raises(MassPropertiesError, match=r"box .* 0 kg"):
        part_mass_properties(replace(box(), mass_g=0.0))


def test_nothing_cannot_be_combined() -> None:
    with pytest.raises(MassPropertiesError):
        combined([])
