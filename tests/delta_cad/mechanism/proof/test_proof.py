"""The proof: true where it says proved, a real violation where it says refuted, and it says so when it cannot."""

import numpy as np
import pytest

from delta_cad.mechanism import (
    Cube,
    DeltaGeometry,
    MechanismError,
    conditioning,
    cube_grid,
    direct_margin,
    joint_angles,
)
from delta_cad.mechanism.limits import POSE_LIMITS, AssemblyMode, CoupleIndex, Kappa
from delta_cad.mechanism.proof import prove as proving
from delta_cad.mechanism.proof.prove import prove
from tests.delta_cad.mechanism.limits.proving import CUBE, around, extremes
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PUBLISHED
from tests.delta_cad.mechanism.proof.exact_oracle import exact_margins
from tests.delta_cad.mechanism.stated_limits import limits

HIDDEN, HIDDEN_CUBE = DeltaGeometry(0.03 + 0.016122, 0.03, 0.082, 0.094266), Cube(0.022648, 0.043363)


CONDITIONS = tuple(kind.name for kind in POSE_LIMITS)


def really_violates(g, cube, requested, finding):
    """The point lies in the cube, and one of the condition's exact margins there is negative."""
    p = np.array(finding.point)
    assert (p >= cube.lower).all()
    assert (p <= cube.upper).all()
    exact = exact_margins(g, requested, finding.point)
    return any(m < 0 for m in exact[type(requested[finding.condition])] if m is not None)


def test_the_published_design_a_thousandth_above_its_maxima():
    proof = prove(PUBLISHED, CUBE, around(extremes(), 1e-3))
    assert proof.verdict == "proved"
    assert [f.condition for f in proof.findings] == list(CONDITIONS)
    assert {f.verdict for f in proof.findings} == {"proved"}
    assert proof.boxes <= 5_000  # the budget; 1,391 when it was written


@pytest.mark.parametrize("share", [-1e-3, -1e-6])
@pytest.mark.parametrize("name", [n for n in CONDITIONS if n != "assembly_mode"])
def test_just_below_each_maximum_is_refuted_by_a_point_that_violates(name, share):
    requested = around(extremes(), share, name)
    proof = prove(PUBLISHED, CUBE, requested)
    assert proof.verdict == "refuted"
    (finding,) = (f for f in proof.findings if f.verdict == "refuted")
    assert finding.condition == name
    assert really_violates(PUBLISHED, CUBE, requested, finding)
    assert prove(PUBLISHED, CUBE, around(extremes(), -share, name)).verdict == "proved"


def test_the_planted_singularity_behind_eight_good_corners():
    assert conditioning(HIDDEN, cube_grid(HIDDEN_CUBE, 2)).max() <= 6.04
    assert (direct_margin(HIDDEN, cube_grid(HIDDEN_CUBE, 2)) > 0).all()
    requested = limits(force=3.0, torque_max=5.0, kappa_max=7.0)
    proof = prove(HIDDEN, HIDDEN_CUBE, requested)
    found = {f.condition: f for f in proof.findings}
    assert found["reach"].verdict == "proved"
    for name in ("assembly_mode", "torque", "kappa"):
        assert found[name].verdict == "refuted"
        assert really_violates(HIDDEN, HIDDEN_CUBE, requested, found[name])
    assert found["assembly_mode"].value < 0.0
    assert found["kappa"].value > 7.0


def test_a_hidden_unreachable_pocket_is_refuted():
    g, cube = DeltaGeometry(0.047, 0.04, 0.082, 0.16), Cube(0.077, 0.047)
    assert np.isfinite(joint_angles(g, cube_grid(cube, 2))).all()
    requested = limits()
    proof = prove(g, cube, requested)
    (finding,) = (f for f in proof.findings if f.verdict == "refuted")
    assert finding.condition == "reach"
    # too near on the axis: the forearm is longer than the upper arm and the way from shoulder to wrist
    assert finding.point == pytest.approx((0.0, 0.0, 0.077), abs=1e-12)
    assert finding.value == pytest.approx(np.hypot(0.007, 0.077) + 0.082 - 0.16, rel=1e-9)
    assert really_violates(g, cube, requested, finding)
    assert [f.verdict for f in proof.findings if f.condition != "reach"] == ["undecided"]


@pytest.mark.slow
def test_many_points_do_not_violate_a_proved_design():
    requested = around(extremes(), 1e-3)
    assert prove(PUBLISHED, CUBE, requested).verdict == "proved"
    rng, n = np.random.default_rng(1), 300_000
    unit = rng.uniform(-1.0, 1.0, (n, 3))
    face = rng.integers(0, 3, n // 2)
    unit[np.arange(n // 2), face] = np.sign(unit[np.arange(n // 2), face])  # half of them on the surface
    unit[: n // 10] = np.sign(unit[: n // 10]) * np.abs(unit[: n // 10]) ** 0.01  # and some close to the corners
    p = np.clip(np.array([0.0, 0.0, BOTTOM + HALF]) + HALF * unit, CUBE.lower, CUBE.upper)
    for limit in requested:
        for figure in limit.figures:
            found, bound = figure.worst(limit, PUBLISHED, p), limit.bound(figure)
            worst = found.max() if figure.upper else found.min()
            assert figure.stricter(worst, bound) == worst
            assert not figure.threshold or abs(worst - bound) < 0.02 * max(abs(bound), 1.0)  # the search came near


@pytest.mark.slow
def test_random_designs_are_all_decided():
    rng = np.random.default_rng(1)
    decided = 0
    while decided < 25:
        a, lb, bottom, half = rng.uniform([-0.02, 0.06, 0.02, 0.01], [0.04, 0.25, 0.2, 0.06])
        g, cube = DeltaGeometry(a + 0.05, 0.05, 0.082, lb), Cube(bottom, half)
        try:
            e = extremes(g, cube, 15)
        except MechanismError:
            proof = prove(g, cube, limits())
            assert proof.verdict == "refuted"
            assert really_violates(g, cube, limits(), proof.findings[0])
            continue
        if e[AssemblyMode.figures[0]] < 0.0:
            refuted = {f.condition: f for f in prove(g, cube, limits()).findings if f.verdict == "refuted"}
            assert really_violates(g, cube, limits(), refuted.pop("assembly_mode"))
            assert not refuted
            continue
        if e[Kappa.figures[0]] > 20.0:  # what is nearly singular takes seconds; a longer run has it
            continue
        if (
            e[CoupleIndex.figures[0]] < 1e-6
        ):  # the rod pairs lose their hold inside: the search ends beside a 0 that nothing can prove
            zero = prove(g, cube, limits(couple_index_min=1e-3))
            assert [f.condition for f in zero.findings if f.verdict == "refuted"] == ["couple_index"]
            assert really_violates(g, cube, limits(couple_index_min=1e-3), zero.findings[-1])
            continue
        assert prove(g, cube, around(e, 1e-3)).verdict == "proved"
        requested = around(e, -0.01, "torque")
        refuted = [f for f in prove(g, cube, requested).findings if f.verdict == "refuted"]
        assert [f.condition for f in refuted] == ["torque"]
        assert really_violates(g, cube, requested, refuted[0])
        decided += 1


def test_the_leaves_cover_half_the_cube_and_contain_what_they_prove():
    requested = around(extremes(), 1e-3)
    proof = prove(PUBLISHED, CUBE, requested)
    k = proof.leaves[:, ::2]
    assert (2.0 ** -k.sum(axis=1)).sum() == 1.0  # exact: powers of two
    assert ((proof.leaves[:, 1::2] >= 0) & (proof.leaves[:, 1::2] < 2**k)).all()
    # each point of a fine grid over y >= 0 lies in exactly one leaf once shared faces are avoided
    p = cube_grid(Cube(BOTTOM, HALF), 12) * [0.999, 1.0, 1.0] + [1e-5, 0.0, 0.0]
    p = p[(p[:, 1] > 0) & (p[:, 1] < HALF) & (p[:, 2] < BOTTOM + 2 * HALF) & (p[:, 2] > BOTTOM)]
    unit = (p - [-HALF, 0.0, BOTTOM]) / [2 * HALF, HALF, 2 * HALF]
    index = np.floor(unit[:, None, :] * 2.0**k)
    assert (((index == proof.leaves[:, 1::2]).all(axis=-1)).sum(axis=1) == 1).all()


def test_who_watches_a_proof_can_end_it(monkeypatch):
    monkeypatch.setattr(proving, "CHUNK", 10)
    requested, seen = around(extremes(), 1e-5), []
    proof = prove(PUBLISHED, CUBE, requested, progress=lambda n, share: seen.append((n, share)) or len(seen) == 2)
    assert proof.verdict == "undecided"
    assert len(seen) == 2
    assert proof.boxes == seen[-1][0] == 20


def test_what_cannot_be_decided_is_said_with_its_box():
    requested = around(extremes(), 1e-5)
    seen = []
    proof = prove(PUBLISHED, CUBE, requested, max_boxes=50, progress=lambda n, share: seen.append((n, share)))
    assert proof.verdict == "undecided"
    assert proof.boxes == 50
    assert seen[-1][0] == 50
    assert 0.0 < seen[-1][1] < 1.0
    for finding in proof.findings:
        if finding.verdict == "undecided":
            low, high = map(np.array, finding.box)
            assert ((low < high) & (low >= CUBE.lower - 1e-15) & (high <= CUBE.upper + 1e-15)).all()


def test_a_limit_that_is_met_exactly_is_neither_proved_nor_refuted():
    top = Cube(0.08, 0.0)  # one point
    kappa = float(conditioning(PUBLISHED, [0.0, 0.0, 0.08]))
    # the double nearest to kappa is closer to it than any enclosure in double arithmetic
    (finding,) = (f for f in prove(PUBLISHED, top, limits(kappa_max=kappa)).findings if f.condition == "kappa")
    assert finding.verdict == "undecided"
    assert prove(PUBLISHED, top, limits(kappa_max=kappa * (1 + 1e-9))).verdict == "proved"
    assert prove(PUBLISHED, top, limits(kappa_max=kappa * (1 - 1e-9))).verdict == "refuted"


def test_a_singular_centre_is_refuted_next_to_it():
    crossing = 0.02484985440601211  # height on the axis at which the determinant of HIDDEN changes sign
    assert abs(direct_margin(HIDDEN, [0.0, 0.0, crossing])) < 1e-15
    cube = Cube(HIDDEN_CUBE.bottom_height, crossing - HIDDEN_CUBE.bottom_height)
    proof = prove(HIDDEN, cube, limits())
    (finding,) = (f for f in proof.findings if f.condition == "assembly_mode")
    assert finding.verdict == "refuted"
    assert really_violates(HIDDEN, cube, limits(), finding)


def test_a_singularity_that_is_touched_but_not_crossed_is_undecided():
    g = DeltaGeometry(0.0625, 0.125, 0.0625, 0.125)  # level arms under their wrists: singular at z = 0.125
    proof = prove(g, Cube(0.125 - 0.0078125, 0.0078125), limits(), max_boxes=2_000)
    (finding,) = (f for f in proof.findings if f.condition == "assembly_mode")
    assert finding.verdict == "undecided"
