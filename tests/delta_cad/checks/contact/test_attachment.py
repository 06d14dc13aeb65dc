"""Parts that float, screws that hold nothing, and tapped or reamed holes left empty are refused."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.contact.attachment import SEAT_MM, check_attachment
from delta_cad.checks.contact.screws import check_screws
from delta_cad.checks.report import CheckResult
from delta_cad.mechanism.placement import chain_turn
from delta_cad.solids.part import Hole, Occurrence, Part
from tests.delta_cad.checks.machines import GEOMETRY, at, box, changed, machine, part, rod

MACHINE = machine()
MESHES = MeshLibrary(MACHINE.parts)


def of(parts: list[tuple[str, Part, np.ndarray]]) -> Assembly:
    """Parts on the base, nothing else."""
    return replace(MACHINE, occurrences=tuple(Occurrence(n, p, "base", f) for n, p, f in parts), joints=(), fits=())


def checked(a: Assembly) -> dict[str, CheckResult]:
    return {r.name: r for r in check_screws(a, MeshLibrary(a.parts))}


def test_the_machine_holds_together() -> None:
    result = check_attachment(MACHINE, MESHES)
    assert result.passed, result.detail
    assert result.value == 0.0


def test_a_motor_off_the_plate_is_refused_by_name_and_distance() -> None:
    lifted = changed(MACHINE, "motor_1", placement=chain_turn(GEOMETRY, 1) @ at(40.0, 0.0, -43.5 + 2.0))
    result = check_attachment(lifted, MESHES)
    assert not result.passed
    assert result.worst_pair == ("motor_1",)
    assert result.value == pytest.approx(2.0)


def test_a_group_that_floats_is_named_whole() -> None:
    away = replace(
        MACHINE,
        occurrences=tuple(
            replace(o, placement=at(0.0, 0.0, 0.5) @ o.placement)
            if o.name in ("wrist_bar_2", "stud_2_0_wrist", "stud_2_1_wrist")
            else o
            for o in MACHINE.occurrences
        ),
    )
    # the lug is 4 mm high and the platform 10, so that half a millimetre is no gap; outwards it is
    assert check_attachment(away, MESHES).passed
    outwards = np.eye(4)
    outwards[:3, 3] = 0.5 * chain_turn(GEOMETRY, 2)[:3, 0]
    names = ("wrist_bar_2", "stud_2_0_wrist", "stud_2_1_wrist")
    moved = tuple(replace(o, placement=outwards @ o.placement) if o.name in names else o for o in MACHINE.occurrences)
    result = check_attachment(replace(MACHINE, occurrences=moved), MESHES)
    assert not result.passed
    assert set(result.worst_pair or ()) == set(names)


@pytest.mark.parametrize(("play", "good"), [(SEAT_MM - 1e-3, True), (SEAT_MM + 1e-3, False)])
def test_where_meshes_cannot_tell_the_solids_do(play: float, good: bool) -> None:
    # polygons of a cylinder of 40 mm are coarser than what is asked, and no vertices lie across from one another
    sleeve = part("sleeve", rod(25, (0, 0, 0), (0, 10, 0)).cut(rod(20 + play, (0, -1, 0), (0, 11, 0))))
    core = part("core", rod(20, (0, 1, 0), (0, 9, 0)))
    a = of([("sleeve", sleeve, np.eye(4)), ("core", core, np.eye(4))])
    result = check_attachment(a, MeshLibrary(a.parts))
    assert result.passed == good
    assert "1 distances measured on the exact solids" in result.detail


@pytest.mark.parametrize(("play", "exact"), [(SEAT_MM - 1e-3, 0), (SEAT_MM + 1e-3, 1)])
def test_points_of_both_surfaces_close_together_need_no_exact_distance(play: float, exact: int) -> None:
    """A core as long as its sleeve, polygons coarse: the rims' vertices lie across from one another."""
    sleeve = part("sleeve", rod(25, (0, 0, 0), (0, 10, 0)).cut(rod(20 + play, (0, -1, 0), (0, 11, 0))))
    core = part("core", rod(20, (0, 0, 0), (0, 10, 0)))
    a = of([("sleeve", sleeve, np.eye(4)), ("core", core, np.eye(4))])
    result = check_attachment(a, MeshLibrary(a.parts, 0.5, 0.5))
    assert result.passed == (exact == 0)
    assert f"{exact} distances measured on the exact solids" in result.detail


def m3(length: float = 10.0) -> Part:
    return part(f"screw_M3x{length:g}", rod(2.75, (0, 0, 0), (0, 0, 3)).fuse(rod(1.23, (0, 0, -length), (0, 0, 1))))


def block(tap: float = 1.25) -> Part:
    tapped = box((-8, -8, -20), (8, 8, 0)).cut(rod(tap, (0, 0, -12), (0, 0, 1)))
    return part("block", tapped, (Hole(2.0 * tap, 1, "M3 x 12"),))


def plate(half: float = 8.0) -> Part:
    return part("plate", box((-half, -half, 0), (half, half, 5)).cut(rod(1.7, (0, 0, -1), (0, 0, 6))))


def joint(gap: float = 0.0, lift: float = 0.0, tap: float = 1.25, length: float = 10.0, half: float = 8.0) -> Assembly:
    """A plate screwed on a block, `gap` between the two, the head `lift` over the plate."""
    return of(
        [
            ("block", block(tap), np.eye(4)),
            ("plate", plate(half), at(0.0, 0.0, gap)),
            ("bolt", m3(length), at(0.0, 0.0, 5.0 + gap + lift)),
        ]
    )


def test_a_screw_that_clamps_passes() -> None:
    found = checked(joint())
    assert all(r.passed for r in found.values()), found
    assert found["screws engaged"].value == pytest.approx(5.0 / 3.0)
    assert found["screws seated"].value == pytest.approx(0.0, abs=1e-9)
    moved = chain_turn(GEOMETRY, 1) @ at(3.0, 4.0)
    turned = replace(joint(), occurrences=tuple(replace(o, placement=moved @ o.placement) for o in joint().occurrences))
    assert all(r.passed for r in checked(turned).values())


@pytest.mark.parametrize(
    ("spoiled", "name"),
    [
        (lambda: joint(gap=0.2), "screws seated"),
        (lambda: joint(lift=0.2), "screws seated"),
        (lambda: joint(half=2.0), "screws seated"),  # the head overhangs a plate as wide as its hole
        (lambda: joint(length=7.0), "screws engaged"),
        (lambda: joint(tap=1.5), "screws engaged"),  # a shank loose in a hole
        (lambda: joint(gap=2.5), "screws engaged"),
    ],
)
def test_a_screw_that_does_not_hold_is_refused(spoiled: Callable[[], Assembly], name: str) -> None:
    result = checked(spoiled())[name]
    assert not result.passed
    assert result.worst_pair == ("bolt",)


def test_the_slit_of_a_clamp_is_no_gap() -> None:
    jaw = box((-8, -8, -20), (8, 8, 5)).cut(rod(1.25, (0, 0, -12), (0, 0, 6))).cut(rod(1.7, (0, 0, -1), (0, 0, 6)))
    clamp = part("clamp", jaw.cut(box((-4, -9, -1), (9, 9, 0))))
    a = of([("clamp", clamp, np.eye(4)), ("bolt", m3(), at(0.0, 0.0, 5.0))])
    assert all(r.passed for r in checked(a).values())


def test_a_tapped_hole_without_its_screw_is_refused() -> None:
    bare = replace(joint(), occurrences=joint().occurrences[:2])
    result = checked(bare)["holes filled"]
    assert not result.passed
    assert result.worst_pair == ("block",)
    assert result.value == 1.0
    other = replace(block(), holes=(Hole(2.5, 1, "2.5 through"),))  # no thread: nobody misses the screw
    assert checked(of([("block", other, np.eye(4))]))["holes filled"].passed


def shifted(a: Assembly, name: str, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Assembly:
    placed = next(o for o in a.occurrences if o.name == name).placement
    return changed(a, name, placement=placed @ at(x, y, z))


@pytest.mark.slow
def test_the_committed_machine_is_screwed_together_and_its_spoiled_copies_are_refused(best_assembly: Assembly) -> None:
    meshes = MeshLibrary(best_assembly.parts)

    def failed(a: Assembly) -> dict[str, tuple[str, ...]]:
        results = [check_attachment(a, meshes), *check_screws(a, meshes)]
        return {r.name: r.worst_pair or () for r in results if not r.passed}

    def without(prefix: str) -> Assembly:
        kept = tuple(o for o in best_assembly.occurrences if not o.name.startswith(prefix))
        assert len(kept) < len(best_assembly.occurrences)
        return replace(best_assembly, occurrences=kept)

    assert failed(best_assembly) == {}
    assert failed(shifted(best_assembly, "knob", z=30.0))["parts attached"] == ("knob",)
    assert failed(shifted(best_assembly, "encoder_board_2", x=300.0))["parts attached"] == ("encoder_board_2",)
    assert "screws seated" in failed(shifted(best_assembly, "motor_1", y=2.0))
    assert any(
        name.startswith("motor_screw_1_") for name in failed(shifted(best_assembly, "motor_1", y=2.0))["screws seated"]
    )
    assert failed(without("cheek_screw_0_"))["holes filled"] == ("foot_block_0",)
    assert failed(without("base_screw_0"))["holes filled"] == ("foot_block_0",)
    assert "screws engaged" in failed(shifted(best_assembly, "tension_screw_1", z=30.0))
