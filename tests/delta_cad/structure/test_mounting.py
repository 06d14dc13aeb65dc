"""What the machine stands on: plate against a solid model and a closed form, tipping against feet that only push."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import linprog

from delta_cad.checks.structure import check_structure
from delta_cad.design import design_from_dict, design_to_dict
from delta_cad.dimensions import DimensionError, Dimensions, dimensions, link_placement
from delta_cad.dimensions.platform import (
    FACTOR,
    FOOT_FRICTION,
    corners_of_cube_mm,
    fixed_mass,
    knob_centre_mm,
)
from delta_cad.solids.base_plate import make_base_plate
from delta_cad.structure.beam_model import beam_model, moduli_N_mm2
from delta_cad.structure.compliance import compliance
from delta_cad.structure.hardware.refusals import least_outline_mm, refusals
from delta_cad.structure.loads import screw_pull_N
from delta_cad.structure.modes import Moving, MovingBody, first_mode_Hz
from delta_cad.structure.mounting import _Plate, mounting, rubber_N_mm, supports, upset
from delta_cad.structure.report import stiffness
from delta_cad.structure.section import POISSON
from tests.delta_cad.structure.machines import committed, design, places, table, what_moves
from tests.delta_cad.structure.solid_model import flexibility, meshed

GRAVITY = 9.81


def on(kind: str, **requirements: float) -> Dimensions:
    data = design_to_dict(design())
    data["hardware"]["mounting"] = kind
    data["requirements"] |= requirements
    return dimensions(design_from_dict(data))


def bodies() -> dict[str, dict[str, object]]:
    """A machine of 2 kg, most of it in the base, as a mass report has it."""
    found: dict[str, dict[str, object]] = {
        "base": {"mass_kg": 1.5, "centre_m": [0.004, -0.003, -0.05]},
        "platform": {"mass_kg": 0.05, "centre_m": [0.0, 0.0, 0.01]},
    }
    turned = {"upper_arm": (0.1, [0.03, 0.0, 0.0]), "pinion": (0.05, [0.0, 0.0, 0.0])}
    for i in range(3):
        found |= {f"{name}_{i}": {"mass_kg": mass, "centre_m": at} for name, (mass, at) in turned.items()}
    return found


def test_a_round_plate_that_is_held_at_its_rim_sinks_as_the_closed_form_says() -> None:
    """Simply supported all around, an even load on all of it: `w = (5 + nu) q a^4 / (64 (1 + nu) D)` in the middle."""
    radius, rigidity, load = 80.0, 3e6, 1e-3
    plate = _Plate(((0.0, 0.0, radius),), [], rigidity)
    angle = np.linspace(0.0, 2.0 * np.pi, 240, endpoint=False)
    rim = plate.deflections(radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    side = np.linspace(-radius, radius, 161)
    points = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    work = plate.deflections(points[np.hypot(*points.T) <= radius]).sum(axis=0) * (side[1] - side[0]) ** 2 * load
    held = np.linalg.solve(plate.stiffness[3:, 3:] + 1e6 * rim.T @ rim, work)
    middle = float(plate.deflections(np.zeros((1, 2)))[0] @ held)
    assert middle == pytest.approx((5.0 + POISSON) * load * radius**4 / (64.0 * (1.0 + POISSON) * rigidity), rel=0.02)


@pytest.mark.slow
def test_the_plate_gives_as_its_solid_model(tmp_path: Path) -> None:
    """Clamped in its mounting holes; the load on one foot block's place. Found: 0.71 to 1.21."""
    d = committed()
    b, k, layers, i = d.base, d.bracket, d.layers, 0
    mounts = np.array(b.mounts_mm)
    back = np.linalg.inv(d.stand(i))

    def held(x: np.ndarray) -> np.ndarray:
        away = np.hypot(x[0] - mounts[:, :1], x[1] - mounts[:, 1:])
        return (away < b.mount_hole_mm / 2 + 0.05).any(axis=0)

    def loaded(x: np.ndarray) -> np.ndarray:
        u, v = (back[row, :3] @ x + back[row, 3] for row in (0, 1))
        inside = (u > k.foot_u_mm[0]) & (u < k.foot_u_mm[1])
        return inside & (v > layers.encoder_cheek_mm[1]) & (v < layers.motor_cheek_mm[0]) & (x[2] > b.top_mm - 1e-6)

    made = mounting(d)
    picked = [2, 3, 4]  # across the plate, and the two turns that bend it
    solid = flexibility(
        meshed(make_base_plate(d).solid, 7.0, tmp_path),
        moduli_N_mm2("aluminium-6082")[0],
        held,
        loaded,
        made.blocks_mm[i],
        np.eye(6)[picked],
    )
    ritz = np.diag(sum(made.shares.values()))[picked]
    assert (np.abs(ritz / np.diag(solid) - 1.0) < 0.35).all()


def test_supports_bear_what_is_on_the_plate() -> None:
    made, d = mounting(committed()), committed()
    at = supports(d).places_mm
    for i in range(3):
        x, y, _ = made.blocks_mm[i]
        up, about_x, about_y = (made.reactions[:, 6 * i + k] for k in (2, 3, 4))
        assert -up.sum() == pytest.approx(1.0, rel=1e-6)
        assert -(up @ at[:, 0]) == pytest.approx(x, rel=1e-5)
        assert -(up @ at[:, 1]) == pytest.approx(y, rel=1e-5)
        assert -(about_x @ at[:, 1]) == pytest.approx(1.0, rel=1e-5)
        assert about_y @ at[:, 0] == pytest.approx(1.0, rel=1e-5)


def test_a_foot_is_as_stiff_as_rubber() -> None:
    upright, sideways = rubber_N_mm(15.0, 8.0, 50.0)
    area, shape = np.pi / 4 * 15.0**2, 15.0 / 32.0
    youngs = upright * 8.0 / area / (1 + 2 * shape**2)
    assert 2.2 < youngs < 2.7  # N/mm^2 at 50 Shore A in the tables of rubber makers
    assert sideways == pytest.approx(youngs / 3 * area / 8.0)


def test_feet_make_it_soft_and_screws_do_not() -> None:
    rigid = stiffness(committed()).softest.stiffness_N_mm.min()
    on_feet = stiffness(on("feet")).softest
    assert on_feet.stiffness_N_mm.min() < rigid / 3
    assert on_feet.shares["supports"].min() > 0.4
    assert stiffness(on("screws")).softest.shares["supports"].max() < 0.05
    assert committed().is_screwed_down


def least_tipping_N(
    d: Dimensions,
    position: np.ndarray,
    knob_mm: float,
    directions: np.ndarray,
    weighed: dict[str, dict[str, object]] | None = None,
) -> float:
    """Largest force, by linear programming, under which feet that only push, and cannot slide, keep the balance."""
    feet = np.array([[x, y, d.floor_mm] for x, y in d.feet_mm])
    frames = link_placement(d)(position)
    weights, moments = np.zeros(3), np.zeros(3)
    for link, body in (bodies() if weighed is None else weighed).items():
        force = np.array([0.0, 0.0, -GRAVITY * float(str(body["mass_kg"]))])
        at = frames[link][:3, :3] @ np.array(body["centre_m"]) * 1e3 + frames[link][:3, 3]
        weights += force
        moments += np.cross(at, force)
    knob, least = position + np.array([0.0, 0.0, knob_mm]), np.inf
    count = len(feet)
    forces = np.tile(np.eye(3), count)  # of each foot on the machine
    turning = np.concatenate([np.cross(foot, np.eye(3), axisa=0, axisb=0, axisc=0) for foot in feet], axis=1)
    for way in directions:
        push = np.concatenate([way, np.cross(knob, way)])[:, None]
        balance = np.concatenate([np.concatenate([forces, turning]), push], axis=1)
        bounds = [(None, None), (None, None), (0.0, None)] * count + [(0.0, None)]
        found = linprog(
            [0.0] * 3 * count + [-1.0],
            A_eq=balance,
            b_eq=-np.concatenate([weights, moments]),
            bounds=bounds,
            method="highs",
        )
        least = min(least, float(found.x[-1])) if found.status == 0 else least
    return least


def test_a_machine_tips_when_its_feet_would_have_to_pull() -> None:
    d, p = on("feet"), places()[[5]]
    knob = stiffness(d).table.knob_mm
    found = upset(d, bodies(), p, knob, 8.0)
    angle, rise = np.meshgrid(np.linspace(0.0, 2 * np.pi, 73)[:-1], np.linspace(-1.4, 1.4, 15))
    ways = np.stack([np.cos(rise) * np.cos(angle), np.cos(rise) * np.sin(angle), np.sin(rise)], axis=-1).reshape(-1, 3)
    least = least_tipping_N(d, p[0], knob, ways)
    assert found.tips_N <= least * (1 + 1e-9)
    assert found.tips_N == pytest.approx(least, rel=0.02)  # the directions are 5 degrees apart


def on_plate() -> Dimensions:
    return on("plate", force_N=3.0, peak_force_N=8.0)


def with_plate(d: Dimensions) -> dict[str, dict[str, object]]:
    """What `fixed_mass` finds of the base, with its bench plate, and nothing that moves."""
    assert d.bench is not None
    (mass, centre), own = fixed_mass(d), d.bench.mass_kg
    middle = np.array([sum(d.bench.x_mm) / 2, sum(d.bench.y_mm) / 2, d.bench.top_mm - d.bench.thickness_mm / 2])
    whole = (mass * centre + own * middle) / (mass + own) / 1e3
    return {"base": {"mass_kg": mass + own, "centre_m": whole.tolist()}}


def test_a_bench_plate_holds_what_it_was_sized_for_and_a_smaller_one_does_not() -> None:
    """The balance of four feet that only push, by linear programming, on the plate and on those next below it."""
    d = on_plate()
    bench, force = d.bench, FACTOR * 8.0
    assert bench is not None
    corner = [p for p in corners_of_cube_mm(d) if p[2] == corners_of_cube_mm(d)[:, 2].max()]
    angle, rise = np.meshgrid(np.arange(4) * np.pi / 2, np.linspace(0.0, 1.0, 9))  # across the plate's edges, and up
    ways = np.stack([np.cos(rise) * np.cos(angle), np.cos(rise) * np.sin(angle), np.sin(rise)], axis=-1).reshape(-1, 3)

    def least(one: Dimensions) -> float:
        return min(least_tipping_N(one, p, knob_centre_mm(d), ways, with_plate(one)) for p in corner)

    assert least(d) >= force
    assert bench.tips_N == pytest.approx(least(d), rel=0.005)  # the directions are 7 degrees apart
    (x0, x1), (y0, y1) = bench.x_mm, bench.y_mm
    size = np.prod(bench.size_mm)
    smaller = replace(bench, x_mm=(x0 + 2.0, x1 - 2.0), y_mm=(y0 + 2.0, y1 - 2.0))
    smaller = replace(smaller, mass_kg=bench.mass_kg * float(np.prod(smaller.size_mm) / size))
    thinner = replace(bench, thickness_mm=bench.thickness_mm - 2.0)
    thinner = replace(thinner, mass_kg=bench.mass_kg * thinner.thickness_mm / bench.thickness_mm)
    for one in (smaller, thinner):
        assert least(replace(d, bench=one)) < force


def test_a_bench_plate_stays_inside_the_outline_that_the_machine_takes_anyway() -> None:
    d = on_plate()
    assert (least_outline_mm(d) == least_outline_mm(on("screws", force_N=3.0, peak_force_N=8.0))).all()


def test_no_plate_holds_a_machine_in_a_small_outline_or_without_gravity() -> None:
    with pytest.raises(DimensionError, match=r"bench_plate, standing: 90 N at the knob.* the largest, .* x 20 mm"):
        on("plate", force_N=3.0, peak_force_N=60.0)
    data = design_to_dict(on("screws").design)
    data["hardware"]["mounting"], data["requirements"]["gravity_m_s2"] = "plate", [0.0, 0.0, 0.0]
    with pytest.raises(DimensionError, match="tips at 0 N and slides at 0 N"):
        dimensions(design_from_dict(data))


def test_feet_are_refused_before_any_solid_is_made_and_the_plate_is_named_with_its_size() -> None:
    def of_stability(d: Dimensions) -> list[str]:
        return [reason.message for reason in refusals(d.design) if reason.key == ("base_plate", "standing")]

    (message,) = of_stability(on("feet", force_N=3.0, peak_force_N=8.0))
    bench = on_plate().bench
    assert bench is not None
    x, y = bench.size_mm
    assert f'"plate": a steel plate of {x:g} x {y:g} x {bench.thickness_mm:g} mm, {bench.mass_kg:.1f} kg' in message
    assert 'hardware.mounting = "screws" holds it' in message
    assert not of_stability(
        on("feet", force_N=0.2, peak_force_N=0.3)
    )  # a machine that is that feeble stands on its feet
    assert not of_stability(on_plate())
    assert not of_stability(on("screws", force_N=3.0, peak_force_N=8.0))


def test_a_rigid_machine_on_pads_moves_as_a_body_on_springs() -> None:
    """Plates of 400 mm, which do not bend: four springs at the pads, and the screws in line with them."""
    thick, d = 400.0, on_plate()
    assert d.bench is not None
    rigid = replace(
        d,
        base=replace(d.base, thickness_mm=thick, top_mm=0.0),
        bench=replace(d.bench, thickness_mm=thick, top_mm=-thick),
    )
    made = mounting(rigid)
    axial, lateral = rubber_N_mm(30.0, 6.0)
    screws = supports(rigid)

    def of(places: list[tuple[float, float]], height: float, rates: tuple[float, float]) -> np.ndarray:
        found = np.zeros((6, 6))
        for x, y in places:
            moved = np.concatenate([np.eye(3), [[0.0, -height, y], [height, 0.0, -x], [-y, x, 0.0]]]).T
            found += moved.T @ np.diag([rates[0], rates[0], rates[1]]) @ moved
        return found

    soft = np.linalg.inv(of(d.bench.pads_mm, -2.0 * thick - 6.0, (lateral, axial)))
    soft += np.linalg.inv(of(d.base.mounts_mm, -thick, (screws.lateral_N_mm, screws.axial_N_mm)))
    total = np.sum(list(made.shares.values()), axis=0)
    for i, (x, y, z) in enumerate(made.blocks_mm):
        to = np.eye(6)
        to[3:, :3] = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
        held = to.T @ soft @ to
        assert np.diag(total[6 * i : 6 * i + 6, 6 * i : 6 * i + 6]) == pytest.approx(np.diag(held), rel=0.004)


def test_a_plate_makes_it_nearly_as_stiff_as_screws_and_feet_do_not() -> None:
    screwed, plate, feet = (stiffness(on(kind, force_N=3.0, peak_force_N=8.0)) for kind in ("screws", "plate", "feet"))
    assert feet.least_N_mm < 0.5 * plate.least_N_mm < 0.5 * screwed.least_N_mm
    assert plate.least_N_mm > 0.85 * screwed.least_N_mm


def test_the_mass_of_the_base_lowers_the_first_mode_of_a_machine_on_feet() -> None:
    """All roots of a rigid platform on the machine's springs on a rigid base on its feet: twelve coordinates."""
    d = on("feet")
    d = replace(d, base=replace(d.base, thickness_mm=60.0))  # does not bend
    machine, p = beam_model(d), places()[0]
    base = MovingBody(1.5, np.array([4.0, -3.0, -50.0]), np.diag([8000.0, 8000.0, 9000.0]))
    nothing = MovingBody(0.0, np.zeros(3), np.zeros((3, 3)))
    what = Moving(what_moves().platform, nothing, (0.0, 0.0, 0.0), base)

    def turning(x: float, y: float, z: float) -> np.ndarray:
        return np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])

    def rigid(body: MovingBody) -> np.ndarray:
        aside = body.mass_kg * turning(*body.centre_mm)
        return np.block([[body.mass_kg * np.eye(3), aside], [aside.T, body.inertia_kg_mm2]])

    feet, under = np.zeros((6, 6)), supports(d)
    for x, y in under.places_mm:
        moved = np.concatenate([np.eye(3), turning(x, y, d.base.top_mm - 30.0 - under.below_mm)], axis=1)
        feet += moved.T @ np.diag([under.lateral_N_mm, under.lateral_N_mm, under.axial_N_mm]) @ moved
    held = np.linalg.inv(compliance(replace(machine, mounting=None), p).platform)
    carried = np.block([[np.eye(3), turning(*p)], [np.zeros((3, 3)), np.eye(3)]])
    springs = np.block([[held, -held @ carried], [-carried.T @ held, carried.T @ held @ carried + feet]])
    masses = np.block([[rigid(what.platform), np.zeros((6, 6))], [np.zeros((6, 6)), rigid(base)]])
    lowest = float(np.sqrt(1e3 * eigh(springs, masses, eigvals_only=True)[0]) / (2.0 * np.pi))
    found, light = (float(first_mode_Hz(machine, one, p)) for one in (what, replace(what, base=None)))
    assert lowest * (1.0 - 1e-3) <= found < 1.1 * lowest  # what is taken to follow a force is no lower
    assert light > 1.3 * lowest


def test_the_mass_that_is_named_is_the_least_that_holds() -> None:
    d, force = on("feet"), 8.0
    knob, mass = stiffness(d).table.knob_mm, bodies()
    found = upset(d, mass, places(), knob, FACTOR * force)
    assert found.added_kg > 0.0
    feet = np.array(d.base.feet_mm).mean(axis=0)
    for share, stands in ((1.001, True), (0.99, False)):
        more = {"mass_kg": share * found.added_kg, "centre_m": [*(feet / 1e3), -0.05]}
        base = mass["base"]
        total = float(str(base["mass_kg"])) + float(str(more["mass_kg"]))
        centre = (
            float(str(base["mass_kg"])) * np.array(base["centre_m"])
            + float(str(more["mass_kg"])) * np.array(more["centre_m"])
        ) / total
        again = upset(d, mass | {"base": {"mass_kg": total, "centre_m": centre}}, places(), knob, FACTOR * force)
        assert (min(again.tips_N, again.slides_N) >= FACTOR * force) == stands


@pytest.mark.parametrize("gravity", [[0.0, 0.0, 0.0], [0.0, 0.0, 9.81], [0.0, 9.81, 0.0]])
def test_feet_hold_nothing_where_gravity_does_not_press_them_down(gravity: list[float]) -> None:
    data = design_to_dict(on("feet").design)
    data["requirements"]["gravity_m_s2"] = gravity
    d = dimensions(design_from_dict(data))
    found = upset(d, bodies(), places(), 45.0, 3.0)
    assert (found.tips_N, found.slides_N, found.added_kg) == (0.0, 0.0, np.inf)


def test_it_slides_where_friction_ends() -> None:
    d = on("feet")
    found, weight = upset(d, bodies(), places(), 45.0, 3.0), 2.0 * GRAVITY
    rise = np.linspace(0.0, np.pi / 2, 2001)[:-1]
    # the horizontal part of a force against the friction of what weight it leaves
    least = (FOOT_FRICTION * weight / (np.cos(rise) + FOOT_FRICTION * np.sin(rise))).min()
    assert found.slides_N == pytest.approx(least, rel=1e-5)


def test_checks_refuse_a_machine_that_tips_and_one_that_pulls_its_screws_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("delta_cad.structure.report.moving", lambda *_: what_moves())
    d = on("feet", force_N=3.0, peak_force_N=8.0)
    results = {r.name: r for r in check_structure(d, bodies())}
    for name in ("structure tipping", "structure sliding"):
        assert not results[name].passed
        assert results[name].limit == pytest.approx(FACTOR * 8.0)
        assert 'hardware.mounting = "screws" holds it' in results[name].detail
    assert "structure mounting screw" not in results
    heavy = {name: body | {"mass_kg": 20.0 * float(str(body["mass_kg"]))} for name, body in bodies().items()}
    results = {r.name: r for r in check_structure(d, heavy)}
    assert results["structure tipping"].passed
    assert results["structure sliding"].passed

    d = on_plate()
    results = {r.name: r for r in check_structure(d, with_plate(d) | bodies())}  # 1.5 kg of base in all
    assert not results["structure tipping"].passed
    assert 'hardware.mounting = "screws" holds it, or ' in results["structure tipping"].detail
    assert results["structure mounting screw"].passed
    results = {r.name: r for r in check_structure(d, bodies() | with_plate(d))}
    assert results["structure tipping"].passed
    assert results["structure sliding"].passed

    screwed = on("screws", force_N=3.0, peak_force_N=8.0)
    (result,) = (r for r in check_structure(screwed, bodies()) if r.name == "structure mounting screw")
    assert result.passed
    assert result.value is not None
    monkeypatch.setattr("delta_cad.checks.structure.screw_N", lambda _: 0.99 * result.value)
    (result,) = (r for r in check_structure(screwed, bodies()) if r.name == "structure mounting screw")
    assert not result.passed


def test_a_screws_pull_is_of_the_worst_direction() -> None:
    machine, p = table(), places()[5]
    assert machine.mounting is not None
    pull = float(screw_pull_N(machine, p, 12.0, 20.0))
    twice = float(screw_pull_N(machine, p, 24.0, 20.0))
    assert twice - pull == pytest.approx(pull - 20.0)
    softer = replace(machine, mounting=replace(machine.mounting, reactions=0.5 * machine.mounting.reactions))
    assert float(screw_pull_N(softer, p, 24.0, 20.0)) == pytest.approx(pull)
