"""Loads against directions that are tried, weights against energies, figures against a study's."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import design_from_dict, load_design
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.mechanism import DeltaGeometry, jacobian
from delta_cad.mechanism.inverse import elbow_positions, forearm_vectors, inverse_kinematics
from delta_cad.mechanism.workspace import Cube
from delta_cad.structure.beam_model import BeamModel, beam_model
from delta_cad.structure.compliance import compliance
from delta_cad.structure.loads import LEAST_MARGIN, Load, PartLoads, largest, loads, part_loads, sampled_mm
from delta_cad.structure.modes import first_mode_Hz
from delta_cad.structure.strength import Allowables, allowables, screw_N, set_screws_N_mm, stack_N_mm, stud_stress_1_mm2
from delta_cad.structure.unit_loads import at_knob, unit_loads
from tests.committed import COMMITTED
from tests.delta_cad.structure.frame import axes_of
from tests.delta_cad.structure.machines import committed, design, knob_stiffness, places, table, what_moves

GRAVITY = np.array([0.0, 0.0, -9.81])
STUDY_GRID = 7


def directions(count: int) -> np.ndarray:
    found = np.random.default_rng(1).normal(size=(count, 3))
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


@pytest.mark.parametrize("components", [1, 2])
def test_no_direction_loads_more(components: int) -> None:
    random = np.random.default_rng(2)
    for _ in range(20):
        rows, weight = random.normal(size=(components, 3)), random.normal(size=components)
        tried = np.linalg.norm(3.0 * directions(4000) @ rows.T + weight, axis=-1).max()
        bound = largest(rows, 3.0, weight)
        assert tried <= bound * (1 + 1e-12)
        # one number is reached, two are when nothing hangs on them
        assert components == 2 or tried > 0.99 * bound
        bare = np.linalg.norm(3.0 * directions(4000) @ rows.T, axis=-1).max()
        assert bare > 0.99 * largest(rows, 3.0, 0.0 * weight)


@pytest.mark.parametrize("placed", [False, True])
def test_rods_hold_what_pulls_at_the_knob(placed: bool) -> None:
    machine = table(placed=placed)
    unit = unit_loads(machine, places())
    force = np.array([1.0, -2.0, 0.5])
    pulls = (unit.rods @ at_knob(machine.knob_mm) @ force)[..., None] * unit.along[..., None, :]
    np.testing.assert_allclose(pulls.sum(axis=(-3, -2)), np.broadcast_to(force, places().shape), atol=1e-9)
    # moments about the knob vanish: of wrists at their own places
    wrists = np.array(
        [
            [machine.geometry.platform_radius * MM_PER_M * out + s * machine.width_mm / 2 * across for s in (-1, 1)]
            for out, across in (axes_of(machine.geometry, i) for i in range(3))
        ]
    )
    arms = wrists - [0.0, 0.0, machine.knob_mm]
    np.testing.assert_allclose(np.cross(arms, pulls).sum(axis=(-3, -2)), 0.0, atol=1e-7)


@pytest.mark.parametrize("placed", [False, True])
def test_the_weights_torque_is_the_slope_of_the_energy(placed: bool) -> None:
    machine, what = table(placed=placed), what_moves()
    g = machine.geometry

    def energy(p: np.ndarray) -> float:
        theta = inverse_kinematics(g, p / MM_PER_M)
        elbows = elbow_positions(g, theta) * MM_PER_M
        heights = 0.0
        for i in range(3):
            c, s = np.cos(theta[i]), np.sin(theta[i])
            u, _ = axes_of(g, i)
            x, z = c * u + [0, 0, s], c * np.array([0, 0, 1.0]) - s * u
            centre = what.arm.centre_mm
            heights += what.arm.mass_kg * (x[2] * centre[0] + z[2] * centre[2])
            heights += what.rod_kg * (elbows[i][2] + p[2])  # two rods, each half at either end
        return 9.81 * (heights + what.platform.mass_kg * p[2])

    given = part_loads(machine, what, places(), 0.0, GRAVITY)
    step = 1e-3
    for k, p in enumerate(places()[:4]):
        slope = [(energy(p + d) - energy(p - d)) / (2 * step) for d in step * np.eye(3)]
        torque = jacobian(g, p / MM_PER_M).T @ slope * MM_PER_M
        np.testing.assert_allclose(given.torque[k], np.abs(torque), rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("placed", [False, True])
def test_rods_hold_the_weights_where_they_hang(placed: bool) -> None:
    """Six rods in balance with the platform's weight and with that of half of each rod at its own wrist."""
    machine = table(placed=placed)
    g, what = machine.geometry, replace(what_moves(), platform=replace(what_moves().platform, mass_kg=0.01))
    given = part_loads(machine, what, places(), 0.0, GRAVITY)
    for p, rod in zip(places(), given.rod, strict=True):
        elbows = elbow_positions(g, inverse_kinematics(g, p / MM_PER_M)) * MM_PER_M
        rows, weight = [], np.concatenate([what.platform.mass_kg * GRAVITY, 3 * [0.0]])
        weight[3:] += np.cross(what.platform.centre_mm, weight[:3])
        for i in range(3):
            out, across = axes_of(g, i)
            wrist = g.platform_radius * MM_PER_M * out
            along = (p + wrist - elbows[i]) / np.linalg.norm(p + wrist - elbows[i])
            for side in (-machine.width_mm / 2, machine.width_mm / 2):
                ball, half = wrist + side * across, what.rod_kg / 2 * GRAVITY
                rows.append(np.concatenate([along, np.cross(ball, along)]))
                weight += np.concatenate([half, np.cross(ball, half)])
        pulls = np.linalg.solve(np.transpose(rows), weight).reshape(3, 2)
        np.testing.assert_allclose(rod, np.abs(pulls).max(axis=1), rtol=1e-7, atol=1e-9)


def test_loads_are_linear_in_the_force() -> None:
    one, three = (part_loads(table(), what_moves(), places(), force, 0.0 * GRAVITY) for force in (1.0, 3.0))
    for field in fields(one):
        np.testing.assert_allclose(getattr(three, field.name), 3.0 * getattr(one, field.name), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("lengths_mm", "low_mm", "side_mm", "expected"),
    [
        ((40.0, 30.0, 82.0, 122.346), 47.73, 84.094, {"rod": 6.1, "radial": 13.1, "axial": 0.61, "cable": 2.63}),
        ((35.0, 23.2, 87.0, 140.6), 68.8, 82.4, {"rod": 1.65, "radial": 3.6, "axial": 0.52, "cable": 2.83}),
    ],
)
def test_two_machines_bear_what_a_study_found(
    lengths_mm: tuple[float, ...], low_mm: float, side_mm: float, expected: dict[str, float]
) -> None:
    """Per newton, 45 mm over the wrists, 7^3 positions, without weight: the figures of a study by other code."""
    machine = table(45.0)
    assert machine.shoulder is not None
    assert machine.cable is not None
    machine = replace(
        machine,
        geometry=DeltaGeometry(*(one / MM_PER_M for one in lengths_mm)),
        shoulder=replace(machine.shoulder, y_mm=(-7.5, 13.5)),
        cable=replace(machine.cable, radius_mm=40.0, y_mm=7.0, direction_rad=np.radians(-125.0)),
    )
    cube = Cube(low_mm / MM_PER_M, side_mm / 2 / MM_PER_M)
    given = part_loads(machine, what_moves(), sampled_mm(cube, STUDY_GRID), 1.0, 0.0 * GRAVITY)
    found = {name: float(getattr(given, name).max()) for name in expected}
    assert found == pytest.approx(expected, rel=0.01)


def weakest(limits: Allowables, force_N: float = 3.0, machine: BeamModel | None = None) -> dict[str, bool]:
    made = machine or beam_model(committed())
    given = part_loads(made, what_moves(), places(), force_N, GRAVITY)
    return {load.name: load.holds for load in loads(made, limits, places(), given)}


# part -> the number of what it may bear that is made too small
WEAK = {
    "rod buckling": {"buckling_N": 3.0},
    "ball joint preload": {"preload_reserve_N": 8.0},
    "cup shell": {"plastic_N_mm2": 3.0},
    "rod end bending": {"end_N_mm2": 20.0},
    "rod bond, tilt": {"tilt_N_mm2": 2.0},
    "rod bond": {"bond_mm2": 1.0},
    "stud": {"stud_1_mm2": 200.0},
    "shoulder seat": {"hub_N_mm": 100.0},
    "cross-bar bond": {"bar_N_mm2": 0.1},
    "motor shaft": {"motor_N": 5.0},
    "motor screw": {"motor_screw_N": 1.0},
    "pinion's set screws": {"pinion_N": 5.0},
    "cable": {"cable_N": 15.0},
    "sector dowel": {"sector_N": 5.0},
    "shoulder preload": {"preload_N": 1.0},
    "cheek dowel": {"foot_pins_mm": 0.5},
    "cheek screw": {"foot_screw_N": 2.0},
    "base screw": {"base_screw_N": 20.0},
}


def test_the_committed_machine_bears_its_force() -> None:
    found = weakest(allowables(committed()))
    assert all(found.values())
    adjacent = {"ball joint", "cable's slip", "shoulder bearing", "shoulder bearing life"}
    assert set(WEAK) | adjacent == set(found)


@pytest.mark.parametrize("part", WEAK)
def test_a_weak_part_fails_alone(part: str) -> None:
    found = weakest(replace(allowables(committed()), **WEAK[part]))  # type: ignore[arg-type]
    assert [name for name, held in found.items() if not held] == [part]


def test_a_small_bearing_and_a_loose_cable_fail() -> None:
    limits = allowables(committed())
    assert limits.bearing is not None
    small = replace(limits, bearing=replace(limits.bearing, static_N=10.0))
    assert not weakest(small)["shoulder bearing"]
    short = replace(limits, bearing=replace(limits.bearing, dynamic_N=30.0))
    assert [name for name, held in weakest(short).items() if not held] == ["shoulder bearing life"]
    assert limits.setting is not None
    loose = replace(limits, setting=replace(limits.setting, pull_N=(3.0, 3.5)))
    assert [name for name, held in weakest(loose).items() if not held] == ["cable's slip"]
    tight = replace(limits, setting=replace(limits.setting, pull_N=(20.0, 40.0)))
    assert not weakest(tight)["cable"]
    assert weakest(tight)["cable's slip"]


def test_nothing_bears_a_thousand_newtons() -> None:
    assert not any(weakest(allowables(committed()), 1000.0).values())


def direct() -> Dimensions:
    data = design().model_dump(mode="json", by_alias=True, exclude_none=True)
    data["hardware"] |= {"drive": "direct", "motor": "maxon-ec60flat-625858", "arm_thickness_mm": 10.0}
    data["mechanism"]["base_radius_mm"] = 60.0
    data["mechanism"]["platform_radius_mm"] = 50.0
    data["cube"]["bottom_height_mm"] += 12.0  # rods do not fold onto the motor at their own shoulder
    return dimensions(design_from_dict(data))


def test_a_direct_drive_hangs_on_its_motors_shaft() -> None:
    d = direct()
    machine = beam_model(d)
    found = compliance(machine, places())
    assert "cable" not in found.parts
    assert "bearings" not in found.parts
    stiff = knob_stiffness(machine, places())
    assert (stiff > 0.0).all()
    thick = replace(machine, stub=replace(machine.stub, factor=1e-9))  # type: ignore[type-var]
    assert (knob_stiffness(thick, places()) > stiff).all()
    limits = allowables(d)
    names = set(weakest(limits, machine=machine))
    assert {"motor shaft", "rod buckling", "stud"} <= names
    assert not {"cable", "shoulder bearing", "sector dowel"} & names
    assert not weakest(replace(limits, motor_N=1.0), machine=machine)["motor shaft"]
    thin = weakest(replace(limits, stub_mm=2.0), machine=machine)
    assert [name for name, held in thin.items() if not held] == ["motor shaft bending"]
    assert (first_mode_Hz(machine, what_moves(), places()) > 0.0).all()


def test_a_clamped_ring_opens_at_its_core() -> None:
    """Stress of force and moment on a ring: at the opening moment the far edge bears nothing, by the section's own."""
    outer, inner = 9.75, 8.0
    moment = stack_N_mm("M4", outer, inner)
    area, modulus = np.pi / 4 * (outer**2 - inner**2), np.pi / 32 * (outer**4 - inner**4) / outer
    assert screw_N(catalogue.screw("M4")) / area - moment / modulus == pytest.approx(0.0, abs=1e-9)


def test_a_stud_bends_most_where_it_is_thinnest_for_its_lever() -> None:
    f = committed().forearm
    worst = stud_stress_1_mm2(f)
    for lever, diameter in ((f.ball_diameter_mm / 2, f.pin_diameter_mm), (f.stand_off_mm, f.neck_diameter_mm)):
        assert worst >= 0.85 * lever / (np.pi / 32 * diameter**3)  # the pin's lever ends at the rim of its hole
    assert stud_stress_1_mm2(replace(f, neck_diameter_mm=2.0)) == pytest.approx(f.stand_off_mm / (np.pi / 32 * 2.0**3))


def test_a_screw_clamps_as_its_stress_area_says() -> None:
    # M3: stress area 5.03 mm^2 (ISO 898-1)
    assert screw_N(catalogue.screw("M3")) == pytest.approx(0.7 * 450.0 * 5.03, rel=2e-3)


def test_a_low_head_bears_less_than_its_thread_and_a_usual_one_more() -> None:
    """M3 by hand: a socket of 2 counts as a circle of 2.10; below it a cone of 0.450 by 0.5 mm to the shank of 3.

    Its area is pi x 2.55 x 0.673 = 5.39 mm^2; it bears sqrt(0.450^2 + 3 x 0.5^2) / 0.673 = 1.450 times the stress.
    """
    assert screw_N(catalogue.low_screw("low-M3")) == pytest.approx(0.7 * 450.0 * 5.39 / 1.450, rel=2e-3)
    for row in catalogue.low_screw.rows.values():
        assert 0.7 < screw_N(row) / screw_N(catalogue.screw(f"M{row.diameter_mm:g}")) < 0.85
    for row in catalogue.screw.rows.values():
        stressed = np.pi / 4 * (row.diameter_mm - 0.9382 * row.pitch_mm) ** 2
        assert screw_N(row) == pytest.approx(0.7 * 450.0 * stressed)


def test_a_pinions_set_screws_hold_what_their_torque_presses() -> None:
    """By hand, M3 x 0.5 at 0.4 N m: 400 / (0.0795 + 0.14 (0.577 x 2.675 + 1.25)) N each, on a shaft of 5 mm."""
    pressed = 400.0 / (0.0795 + 0.14 * (0.577 * 2.675 + 1.25))
    assert set_screws_N_mm(committed()) == pytest.approx(2 * 0.12 * pressed * 2.5, rel=1e-3)
    capstan, limits = committed().capstan, allowables(committed())
    assert capstan is not None
    assert limits.pinion_N == pytest.approx(set_screws_N_mm(committed()) / (38.7 / 4.8), rel=1e-6)
    stall = committed().motor.peak_torque_N_m * 1e3
    assert set_screws_N_mm(committed()) > stall  # whatever the motor does, its pinion stays


def with_joint(d: Dimensions, **changes: float) -> Dimensions:
    return replace(d, forearm=replace(d.forearm, joint=replace(d.forearm.joint, **changes)))


def test_springs_too_weak_let_the_contact_reach_the_lip() -> None:
    """Springs of 4 N lose their preload at 6 N, the machine's own at 12 N; these hold at 3 N and at 5.5 N."""
    names = ("ball joint", "ball joint preload")
    strong, weak = allowables(committed()), allowables(with_joint(committed(), preload_N=4.0))
    for force in (3.0, 5.5):
        assert all(weakest(strong, force)[name] for name in names)
    assert not any(weakest(weak, 6.0)[name] for name in names)
    assert not any(weakest(strong, 12.0)[name] for name in names)


def test_the_preload_left_is_what_springs_may_lose(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("delta_cad.structure.loads.LEAST_MARGIN", 1.0)
    made, limits = beam_model(committed()), allowables(committed())
    given = part_loads(made, what_moves(), places(), 6.0, GRAVITY)
    (left,) = [one for one in loads(made, limits, places(), given) if one.name == "ball joint preload"]
    joint = committed().forearm.joint
    for lost, holding in ((left.value - 1e-3, True), (left.value + 1e-3, False)):
        less = allowables(with_joint(committed(), preload_N=joint.preload_N - lost))
        assert weakest(less, 6.0)["ball joint"] is holding


def test_at_its_peak_the_weakest_springs_hold_the_load_and_not_quite_the_margin() -> None:
    """What docs/limits.md says of best.json, whose peak takes the most of its joints; for ever nothing touches."""
    best = load_design(COMMITTED)
    made, joint, peak = (
        beam_model(dimensions(best)),
        dimensions(best).forearm.joint,
        best.requirements.peak_force_N,
    )
    positions = sampled_mm(best.workspace, 5)
    along = forearm_vectors(made.geometry, positions / MM_PER_M) / made.geometry.forearm_length
    lean, weakest_N = np.arcsin((along * best.geometry.tangential).sum(axis=-1)), np.array(0.9 * joint.preload_N)
    assert peak is not None

    def within_deg(force_N: float, times: float) -> float:
        rod = times * part_loads(made, what_moves(), positions, force_N, GRAVITY).rod
        return float(np.degrees(joint.wrap_rad - joint.edge_rad(rod, lean, weakest_N).max()))

    assert within_deg(peak, 1.0) == pytest.approx(0.4, abs=0.2)
    assert within_deg(peak, LEAST_MARGIN) == pytest.approx(-0.7, abs=0.2)
    assert within_deg(best.requirements.force_N, LEAST_MARGIN) == pytest.approx(18.7, abs=1.0)
    rod = LEAST_MARGIN * part_loads(made, what_moves(), positions, peak, GRAVITY).rod
    points = np.arctan2(rod + weakest_N * np.abs(np.sin(lean)), weakest_N * np.cos(lean)).max()
    assert np.degrees(joint.wrap_rad - points) == pytest.approx(25.0, abs=1.0)


def test_pose_by_pose_is_less_than_both_worsts_together() -> None:
    made = beam_model(committed())
    given = part_loads(made, what_moves(), places(), 6.0, GRAVITY)
    (edge,) = [one for one in loads(made, allowables(committed()), places(), given) if one.name == "ball joint"]
    joint, lean, rod = committed().forearm.joint, np.radians(24.4), LEAST_MARGIN * given.rod.max()
    assert edge.value <= np.degrees(joint.edge_rad(rod, lean)) + 1e-9
    assert edge.value >= np.degrees(joint.edge_rad(rod, np.array(0.0)))


def test_a_motors_shaft_bears_peaks_by_the_cubes_of_what_lasts() -> None:
    """By hand, half of the time: the cube root of the mean of both cubes; and no more than what lasts by itself."""
    limits = replace(allowables(committed()), peak_share=0.5)
    made = beam_model(committed())
    rest, peak = (part_loads(made, what_moves(), places(), force, GRAVITY) for force in (3.0, 9.0))

    def shaft(*given: PartLoads) -> float:
        (load,) = [one for one in loads(made, limits, places(), *given) if one.name == "motor shaft"]
        return load.value

    assert shaft(peak, rest) == pytest.approx(((shaft(peak) ** 3 + shaft(rest) ** 3) / 2.0) ** (1.0 / 3.0))
    assert shaft(rest, rest) == pytest.approx(shaft(rest))


@pytest.mark.parametrize("margin", [1.0, 1.05, 1.2])
def test_the_least_margin_is_taken_off_every_limit_or_put_on_the_load(
    monkeypatch: pytest.MonkeyPatch, margin: float
) -> None:
    """A ball joint's angle and preload do not change as its load does: they are those of all forces times it."""
    made, limits = beam_model(committed()), allowables(committed())
    given = part_loads(made, what_moves(), places(), 3.0, GRAVITY)
    more = PartLoads(**{one.name: margin * getattr(given, one.name) for one in fields(PartLoads)})

    def at(least: float, loaded: PartLoads) -> dict[str, Load]:
        monkeypatch.setattr("delta_cad.structure.loads.LEAST_MARGIN", least)
        return {load.name: load for load in loads(made, limits, places(), loaded)}

    before, scaled = at(1.0, given), at(1.0, more)
    for load in at(margin, given).values():
        if load.name.startswith("ball joint"):
            assert load.limit == before[load.name].limit
            assert load.value == pytest.approx(scaled[load.name].value)
        else:
            assert load.margin == pytest.approx(before[load.name].margin / margin)
            assert load.value == before[load.name].value
