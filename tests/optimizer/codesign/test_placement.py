"""Chains placed for the outline: lengths, what is kept of a symmetric machine, what is learnt, and what it bought.

10 to 26 s of processor: lengths of four outlines are optimised, symmetric and placed.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from delta_cad.checks.report import CheckResult
from delta_cad.design import Design, design_from_dict, design_to_dict
from delta_cad.dimensions import dimensions
from optimizer.codesign import search as module
from optimizer.codesign.bound import Bound, Kind, excluded
from optimizer.codesign.candidate import Candidate, design_for, outline_arguments
from optimizer.codesign.corrections import (
    REAR_PAIR,
    SECTORS,
    SIDE_PAIR,
    ChainReach,
    Corrections,
    as_symmetric,
    placed_sides,
    reference,
)
from optimizer.codesign.estimates import Estimate
from optimizer.codesign.hardware import Selection
from optimizer.codesign.lengths import Found, PlacedProblem, best_lengths, lengths_problem, to_requirements
from optimizer.codesign.report import facts_of, placement_of
from optimizer.codesign.search import Search
from optimizer.codesign.updates import from_checks, from_refusals, with_outline, with_reach
from optimizer.problem.brief import DesignBrief, brief_from_dict
from optimizer.problem.evaluator import half_surface
from optimizer.problem.variables import PER_SI, completed, is_symmetric, mechanism_of, variables_mm

MOTOR = "maxon-re30-310007"
SYMMETRIC = Selection(MOTOR, "capstan", 4.8, 50.0)
PLACED = SYMMETRIC.with_(placed=True)
KNOWN = Corrections(replace(reference(), own=True), overhead_mm=(9.6, 13.2)).raised("base_radius", 31.18, "keys")
PHI = 116.3
LENGTHS = (94.4, 148.4, 31.19, 22.55, 75.8, 43.4, 7.26, math.cos(math.radians(PHI)), 11.1)


def brief(width: float = 270.0, depth: float = 220.0, **tables: Any) -> DesignBrief:
    room = {"envelope_width_mm": width, "envelope_depth_mm": depth} | tables.pop("requirements", {})
    felt = {"kappa_max": 2.27, "effective_mass_max_kg": 0.4}
    hardware = {"motor": MOTOR, "drive": "capstan"}
    return brief_from_dict({"name": "b", "requirements": room, "feel": felt, "hardware": hardware} | tables)


def candidate(choice: Selection = PLACED, lengths: tuple[float, ...] = LENGTHS, **more: Any) -> Candidate:
    return Candidate(design_for(brief(), choice, lengths, KNOWN), choice, lengths, KNOWN, 2.0 * lengths[5], **more)


def polar(radius: float, degrees: float) -> np.ndarray:
    return radius * np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])


def bars(radii: tuple[float, ...], phi: float, half: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """Ends of a bar of each chain, along its shoulder axis, at a radius."""
    ways = (0.0, phi, -phi)
    return [
        (polar(r, a) - polar(half, a + 90.0), polar(r, a) + polar(half, a + 90.0))
        for r, a in zip(radii, ways, strict=True)
    ]


def test_neighbours_are_measured_by_the_radii_of_a_symmetric_machine_that_are_as_far_apart() -> None:
    """By points in the plane: the nearest ends, square to the plane half-way between; less than 0 where they cross."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        phi, width = rng.uniform(95.0, 145.0), rng.uniform(30.0, 60.0)
        base, platform, shift = rng.uniform(30.0, 60.0), rng.uniform(30.0, 50.0), rng.uniform(-10.0, 20.0)
        row = np.array([90.0, 140.0, base, platform, 70.0, 40.0, shift, math.cos(math.radians(phi)), 3.0])
        found = as_symmetric(row, width)

        def alike(distance: float, width: float = width) -> float:
            """Radius of a symmetric machine, sqrt(3) R - L_c / 2 between its nearest ends."""
            return (distance + width / 2.0) / math.sqrt(3.0)

        squares = polar(1.0, phi / 2.0 + 90.0), polar(1.0, 270.0)
        wrists = bars((platform,) * 3, phi, width / 2.0)
        apart = wrists[1][0] - wrists[0][1], wrists[2][0] - wrists[1][1]
        expected = [alike(float(one @ square)) for one, square in zip(apart, squares, strict=True)]
        assert list(found["wrists"]) == pytest.approx(expected)
        stands = bars((base, base + shift, base + shift), phi, width / 2.0)
        apart = stands[1][0] - stands[0][1], stands[2][0] - stands[1][1]
        expected = [alike(float(one @ square)) for one, square in zip(apart, squares, strict=True)]
        assert [found[SIDE_PAIR][0], found[REAR_PAIR][0]] == pytest.approx(expected)
        assert found["shoulders"] == (base, base + shift)
    even = as_symmetric(completed((90.0, 140.0, 33.0, 22.0, 70.0, 40.0)), 50.0)
    assert np.allclose(np.concatenate([*even.values()]), [33.0] * 6 + [22.0] * 2, atol=1e-12)


def test_a_placed_machine_takes_what_its_elbows_and_its_drives_take() -> None:
    """Against points on all circles of all chains in the plane, whose drives move along with the base radius."""
    rng = np.random.default_rng(2)
    elbow, drive = ((-25.0, 4.7), (25.0, 4.7), (0.0, 7.0)), ((-35.0, 88.0), (-5.0, 91.0), (-28.0, 100.0))
    reach = ChainReach(elbow, drive, base_radius_mm=45.0, per_mm=0.6, nearest_mm=3.0)
    around = np.linspace(0.0, 360.0, 721)
    for _ in range(200):
        phi, base, shift, arm = rng.uniform(95.0, 145.0), rng.uniform(30, 60), rng.uniform(-10, 20), rng.uniform(70, 99)
        row = np.array([arm, 140.0, base, 22.0, 70.0, 40.0, shift, math.cos(math.radians(phi)), 3.0])
        farther = max(0.6 * (45.0 - base), -3.0)
        circles = [(arm, t, radius) for t, radius in elbow] + [(u, t + farther, 0.0) for u, t in drive]
        points = []
        for angle, out in ((0.0, base), (phi, base + shift), (-phi, base + shift)):
            for u, t, radius in circles:
                middle = polar(out + u, angle) + polar(t, angle + 90.0)
                points += [middle + polar(radius, turn) for turn in around]
        along_y, along_x = placed_sides(row, 50.0, reach)
        assert (max(along_x), max(along_y)) == pytest.approx(tuple(np.ptp(points, axis=0)), abs=2e-3)


@pytest.mark.parametrize(
    ("width", "depth", "gain"), [(270.0, 220.0, 3.5), (220.0, 270.0, 3.5), (300.0, 200.0, 6.5), (240.0, 240.0, 2.0)]
)
def test_placed_lengths_keep_every_limit_and_have_a_larger_cube(width: float, depth: float, gain: float) -> None:
    """Drives left out; the limits on 41 x 41 points of a face, the room of the chains by `as_symmetric`."""
    task = brief(width, depth)
    symmetric = best_lengths(task, SYMMETRIC, KNOWN)
    assert symmetric is not None
    assert is_symmetric(symmetric.lengths_mm)
    found = best_lengths(task, PLACED, KNOWN, symmetric.lengths_mm)
    assert found is not None
    assert found.side_mm > symmetric.side_mm + gain
    inertia = KNOWN.mass_estimate.inertia(found.lengths_mm[0], found.lengths_mm[1], PLACED.ratio)
    problem = lengths_problem(to_requirements(task, PLACED, KNOWN, inertia), PLACED, KNOWN)
    row = np.array(found.lengths_mm)[None] / PER_SI
    margins = problem.point_margins(problem.figures(row, half_surface(41)))
    assert min(float(one.min()) for one in margins.values()) >= -3e-3  # the masses are those of other lengths
    assert min(float(one[0]) for one in problem.design_margins(row).values()) >= -5e-5  # a micrometre of 20 mm
    room = as_symmetric(completed(found.lengths_mm), 50.0)
    assert min(float(min(room[name])) for name in (SECTORS, SIDE_PAIR, REAR_PAIR)) >= 31.18 - 1e-3
    sides = [
        float(max(side)) + over
        for side, over in zip(placed_sides(row[0] * PER_SI, 50.0, None), (9.6, 13.2), strict=True)
    ]
    assert any(a <= width + 1e-2 and b <= depth + 1e-2 for a, b in (sides, sides[::-1]))


def test_what_is_proved_is_what_the_file_has() -> None:
    """Numbers of a search, through a design and its text, are the same to the last bit."""
    found = best_lengths(brief(), PLACED, KNOWN, LENGTHS, rounds=1)
    assert found is not None
    design = design_for(brief(), PLACED, found.lengths_mm, KNOWN)
    again = design_from_dict(design_to_dict(design))
    m = again.mechanism
    assert variables_mm(m.model_dump(), again.cube.model_dump()) == found.lengths_mm
    geometry, cube = mechanism_of(found.lengths_mm)
    assert again.geometry.side_cosine == geometry.side_cosine
    assert again.geometry.side_shift == pytest.approx(geometry.side_shift, abs=1e-17)
    assert again.workspace == cube
    assert m.azimuths_deg is not None
    assert m.azimuths_deg[1] == round(m.azimuths_deg[1], 4)
    even = design_for(brief(), SYMMETRIC, LENGTHS[:6], KNOWN)
    assert (even.mechanism.azimuths_deg, even.mechanism.base_radii_mm, even.cube.centre_x_mm) == (None, None, None)


@pytest.mark.parametrize(
    ("pair", "raised"),
    [
        (("motor_0", "encoder_board_1"), SIDE_PAIR),
        (("motor_2", "encoder_board_0"), SIDE_PAIR),
        (("motor_1", "encoder_board_2"), REAR_PAIR),
        (("motor_1", "base_plate"), "base_radius"),
        (("rod_cup_0_1_wrist", "rod_cup_1_0_wrist"), "platform_radius"),
    ],
)
def test_chains_that_collide_go_apart_by_themselves(pair: tuple[str, str], raised: str) -> None:
    one = candidate()
    learnt = from_checks(one, KNOWN, [CheckResult("clearance", False, 1.2, 2.0, "mm", worst_pair=pair)])
    assert learnt.least(raised) == pytest.approx(one.radii_mm[raised] + 0.8)
    assert {name for name in learnt.least_mm if learnt.least(name) > KNOWN.least(name)} == {raised}
    posed = lengths_problem(
        to_requirements(brief(), PLACED, learnt, learnt.mass_estimate.inertia(94.0, 148.0, 4.8)), PLACED, learnt
    )
    (margin,) = posed.design_margins(np.array(LENGTHS)[None] / PER_SI)["outline"]
    assert margin == pytest.approx(one.radii_mm[raised] / learnt.least(raised) - 1.0, abs=1e-9)


def test_keys_between_placed_chains_and_a_refusal_of_the_base_radius_move_their_stands() -> None:
    nearer = (*LENGTHS[:6], -4.0, *LENGTHS[7:])
    one = candidate(lengths=nearer)
    keys = CheckResult("chains apart", False, 1.5, 0.0, "mm", worst_pair=("motor_key_1", "motor_2"))
    assert from_checks(one, KNOWN, [keys]).least(REAR_PAIR) == pytest.approx(one.radii_mm[REAR_PAIR] + 1.5)
    unnamed = from_checks(one, Corrections(reference()), [replace(keys, worst_pair=())])
    assert unnamed.least_radius_mm(50.0) == pytest.approx(27.19 + 1.5)
    reason = cast(Any, SimpleNamespace(part="motor_screw", margin=None, key=("motor_screw", "key")))
    refused = Estimate(reason, "mechanism.base_radius_mm", 31.19, 33.19)  # all chains 2 mm farther out
    _, learnt = from_refusals(brief(), PLACED, Corrections(reference()), [refused], nearer)
    assert learnt.least("base_radius") == pytest.approx(29.2)


@pytest.mark.parametrize("turned", [False, True])
def test_what_the_outline_takes_beyond_points_is_learnt_along_y_and_x_by_themselves(turned: bool) -> None:
    one = candidate()
    known = replace(KNOWN, reach=ChainReach(((-25.0, 4.7), (25.0, 4.7)), ((-30.0, 90.0),)))
    along_y, along_x = (float(max(side)) for side in placed_sides(np.array(LENGTHS), 50.0, known.reach))
    built = {"envelope width": along_y + 8.0, "envelope depth": along_x + 11.0}
    if turned:
        built = dict(zip(built, reversed(built.values()), strict=True))
    results = [CheckResult(name, True, mm, 300.0, "mm") for name, mm in built.items()]
    learnt = with_outline(one, known, results)
    assert learnt.beyond_mm(placed=True) == pytest.approx((8.05, 11.05))
    assert learnt.beyond_mm(placed=False) == known.overhead_mm


@pytest.mark.parametrize("nearer_mm", [3.0, 0.0, -3.0, -20.0])
def test_the_drives_of_a_placed_machine_stand_where_its_dimensions_have_them(best: Design, nearer_mm: float) -> None:
    """Also at other base radii, as far in as they have room; nothing changes a second time."""
    choice = PLACED.with_(width_mm=best.mechanism.parallelogram_width_mm)
    learnt = with_reach(choice, KNOWN, best)
    assert learnt.reach is not None
    assert with_reach(choice, learnt, best) is learnt
    base = best.mechanism.base_radius_mm - nearer_mm
    mechanism = best.mechanism.model_copy(update={"base_radius_mm": base})
    d = dimensions(best.model_copy(update={"mechanism": mechanism}), inwards=True)
    end = d.layers.motor_face_mm + d.motor.length_mm
    farther = float(learnt.reach.farther_mm(np.array(base)))
    assert max(t for _, t in learnt.reach.drive_mm[:2]) + farther == pytest.approx(end, abs=0.2)  # whole tenths, twice
    if nearer_mm == 0.0:
        out = d.bracket.motor_axis_mm[0] - base + d.motor.diameter_mm / 2.0
        assert max(u for u, _ in learnt.reach.drive_mm[:2]) == pytest.approx(out)
        assert out <= dimensions(best).bracket.motor_axis_mm[0] - base + d.motor.diameter_mm / 2.0


def searched(monkeypatch: pytest.MonkeyPatch, placed: float, **tables: Any) -> Search:
    """A search of paper: 83 mm with symmetric chains, and so much with placed ones."""
    search = Search(brief(**tables))

    def fixed_point(choice: Selection, *_: object, **__: object) -> Candidate:
        search.corrections.setdefault((choice.motor, choice.drive), KNOWN)
        score = placed if choice.placed else 83.0
        lengths = LENGTHS if choice.placed else LENGTHS[:6]
        return Candidate(cast(Design, None), choice, lengths, KNOWN, score)

    monkeypatch.setattr(search, "fixed_point", fixed_point)
    monkeypatch.setattr(search, "_climbed", lambda one, _: one)
    return search


@pytest.mark.parametrize(
    ("tables", "score", "chosen"),
    [
        ({}, 87.0, True),
        ({}, 83.8, False),  # less than 1 %
        ({"placement": "rectangle"}, 83.8, True),
        ({"placement": "symmetric"}, 87.0, False),
        ({"limits": {"outline_radius_max_mm": 122.0}}, 87.0, False),
    ],
)
def test_chains_are_placed_where_that_pays_or_is_required(
    tables: dict[str, Any], score: float, chosen: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = searched(monkeypatch, score, **tables)
    found = search.refined(SYMMETRIC)
    assert found is not None
    assert found.choice.placed is chosen
    assert (search.symmetric != {}) is chosen
    tried = [f"{score:.2f} mm of cube with placed chains, 83.00 mm of cube" in line for line in search.log.placed]
    assert tried == [True] * search.brief.placeable
    assert search.corrections[MOTOR, "capstan"] is KNOWN


def test_what_cannot_be_built_with_placed_chains_is_built_with_symmetric_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    search, built, least = searched(monkeypatch, 87.0), list[bool](), list[float]()

    def build(first: Candidate, score: float) -> Any:
        built.append(first.choice.placed)
        least.append(score)
        return None if first.choice.placed else (first, None)

    monkeypatch.setattr(search, "built", build)
    refined = search.refined(SYMMETRIC)
    assert refined is not None
    found = search._built_or_symmetric(refined, -math.inf)
    assert found is not None
    assert (built, found[0].choice.placed) == ([True, False], False)
    assert least == [83.0 * 1.01, -math.inf]


def test_where_symmetric_chains_have_no_lengths_placed_ones_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    def lengths(_brief: object, choice: Selection, *_: object) -> Found | None:
        return Found(LENGTHS, 86.8) if choice.placed else None

    monkeypatch.setattr(module, "best_lengths", lengths)
    for placement, count in ((None, 1), ("symmetric", 0)):
        search = Search(brief().model_copy(update={"placement": placement}))
        found = search._rough()
        assert [choice.placed for _, choice in found] == [True] * count
        assert bool(search.log.no_progress) is (count == 0)


def test_a_small_outline_is_excluded_by_proof_for_symmetric_chains_and_by_search_for_placed_ones() -> None:
    symmetric, placed = excluded(brief(80.0, 70.0, placement="symmetric")), excluded(brief(80.0, 70.0))
    assert "120 degrees" in symmetric
    assert "120 degrees" in placed
    assert "no proof" not in symmetric
    assert placed.endswith("finds none: no proof")
    assert excluded(brief(120.0, 100.0)) == ""


def test_what_placement_bought_is_the_difference_of_both_machines() -> None:
    task, one = brief(), candidate()
    before = replace(candidate(SYMMETRIC, LENGTHS[:6]), score=83.08, weighed=True)
    said = placement_of(task, replace(one, score=87.88), before)
    assert said is not None
    assert said["bought"] == (
        "+4.8 mm over the symmetric machine of the same search (83.08 mm of cube, weighed, not built)"
    )
    assert said["symmetric_side_mm"] == before.side_mm
    assert said["base_radii_mm"] == [31.19, 38.45, 38.45]
    assert said["azimuths_deg"] == [0.0, PHI, -PHI]
    assert said["centre_x_mm"] == 11.1
    alone = placement_of(task, one, None)
    assert alone is not None
    assert (alone["symmetric_side_mm"], alone["bought"]) == (None, "no three-fold symmetric machine was found")
    assert placement_of(task, candidate(SYMMETRIC, LENGTHS[:6]), before) is None


def test_a_room_of_which_nothing_is_known_bounds_nothing() -> None:
    known, task = Corrections(replace(reference(), own=True)), brief()
    direct = PLACED.with_(drive="direct")  # no sector, whose radius would say something
    inertia = known.mass_estimate.inertia(LENGTHS[0], LENGTHS[1], direct.ratio)
    problem = lengths_problem(to_requirements(task, direct, known, inertia), direct, known)
    assert isinstance(problem, PlacedProblem)
    assert all(least > 0.0 for _, least in problem.least_mm)
    assert np.isfinite(problem.design_margins(np.array([LENGTHS]) / PER_SI)["outline"]).all()


def test_a_bound_of_symmetric_machines_is_none_of_a_placed_one(monkeypatch: pytest.MonkeyPatch) -> None:
    one = candidate()
    monkeypatch.setattr("optimizer.codesign.report.results_of", lambda _: {})
    masses = {"moving_mass_kg": 0.4, "total_mass_kg": 2.0}
    outcome: Any = SimpleNamespace(
        design=one.design, results=[], masses=masses, folder=None, passed=True, cost_EUR=None, poor=[]
    )
    bound = Bound(83.8, 0.009, 12, Kind(50.0, "motors", "limits"), ())
    search = Search(brief())
    own = facts_of(brief(), outcome, search.log, bound)
    assert (own["bound_mm"], own["gap"]) == (83.8, 0.009)
    assert "0.9 % more than this one's" in own["bound"]
    placed = facts_of(brief(), outcome, search.log, replace(bound, placed_mm=87.88), {"bought": "+4.8 mm"})
    assert (placed["bound_mm"], placed["gap"], placed["placement"]) == (None, None, {"bought": "+4.8 mm"})
    assert "120 degrees" in placed["bound"]
    assert "87.88 mm" in placed["bound"]
    assert "more than this one's" not in placed["bound"]
    assert "none is larger than this one" in placed["bound"]
    larger = facts_of(brief(), outcome, search.log, replace(bound, placed_mm=83.0), {"bought": "+4.8 mm"})
    assert "none is larger" not in larger["bound"]
    assert outline_arguments(LENGTHS) == (LENGTHS[0] + LENGTHS[2], LENGTHS[6], LENGTHS[7])
