"""What holds a moving part holds every point of it, no more than it must, and proves no way free that is not."""

from __future__ import annotations

from math import inf

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.tessellation import MeshLibrary, tessellate
from delta_cad.checks.contact import fits, shared_volume
from delta_cad.checks.contact.fits import _Overlaps
from delta_cad.checks.contact.order import swept_bodies
from delta_cad.checks.contact.order.paths import Ways
from delta_cad.checks.contact.order.swept_bodies import SolidExtents, turned_solid
from delta_cad.checks.contact.poses import Turning
from delta_cad.checks.contact.shared_volume import common_volume, volume
from delta_cad.solids.part import Part
from tests.delta_cad.checks.contact.order.blocks import on_base, pin, plate
from tests.delta_cad.checks.machines import at, ball, box, part, rod

RNG = np.random.default_rng(11)
Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])  # its y axis is z
Z = np.array([0.0, 0.0, 1.0])
TWISTED = cq.Solid.extrudeLinearWithRotation(
    cq.Wire.makePolygon([(2, 2), (8, 2), (8, 5), (2, 2)]), [], (0, 0, 0), (0, 0, 9), 70
)


def lug() -> cq.Shape:
    """A disc of 10 mm radius with a lug to 14 mm along x, 4 mm wide, 5 mm high."""
    return rod(10, (0, 0, 0), (0, 0, 5)).fuse(box((0, -2, 0), (14, 2, 5)))


def turned_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]])


SHAPES = {
    "plate": plate().solid,
    "lug": lug(),
    "ball": ball(4.0).translate((1, 2, 3)),
    "torus": cq.Solid.makeTorus(8, 2),
    "cone": cq.Solid.makeCone(5, 0, 7),
    "slanted": rod(3, (1, 0, 0), (5, 6, 9)),
    "cut askew": rod(5, (0, 0, 0), (0, 0, 20)).cut(rod(3, (-9, 2, 10), (9, 2, 13))),
    "twisted": TWISTED,
}


@pytest.mark.parametrize("name", SHAPES)
def test_an_outline_holds_its_solid_in_every_direction(name: str) -> None:
    shape = SHAPES[name]
    directions = np.concatenate([np.eye(3), RNG.normal(size=(60, 3))])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    low, high = SolidExtents(shape).extents(directions)
    heights = tessellate(shape, 0.01, 0.1).vertices @ directions.T
    assert (low <= heights.min(axis=0) + 1e-6).all()
    assert (high >= heights.max(axis=0) - 1e-6).all()


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("slides", [(0.0, 0.0), (-3.0, 8.0)])
def test_discs_hold_a_solid_at_every_turn_and_slide(name: str, slides: tuple[float, float]) -> None:
    frame = at(0.5, -0.5, 1.0) @ Y_UP
    discs = SolidExtents(SHAPES[name]).discs(frame, slides)
    points = (tessellate(SHAPES[name], 0.01, 0.1).vertices - frame[:3, 3]) @ frame[:3, :3]
    for slid in np.linspace(*slides, 7):
        for radius, place in zip(np.hypot(points[:, 0], points[:, 2]), points[:, 1] + slid, strict=True):
            assert any(low - 1e-6 <= place <= high + 1e-6 and radius <= out + 1e-6 for low, high, out in discs)


def test_discs_are_as_wide_as_the_solid_where_it_is_round() -> None:
    stepped = rod(3, (0, 0, 0), (0, 0, 5)).fuse(rod(6, (0, 0, 5), (0, 0, 7)))
    discs = SolidExtents(stepped).discs(Y_UP)
    assert np.array(discs) == pytest.approx(np.array([(0, 5, 3), (5, 7, 6)]), abs=1e-9)
    assert volume(turned_solid(discs, Y_UP)) == pytest.approx(np.pi * (9 * 5 + 36 * 2), rel=1e-9)
    assert turned_solid([(0, 1, 2), (2, 3, 2)], Y_UP) is None  # nothing holds them together


def test_within_angles_only_what_is_there_counts() -> None:
    """The lug lies along x: from z towards x of the frame, whose y axis is up, at 90 degrees."""
    outline = SolidExtents(lug())
    assert max(r for *_, r in outline.discs(Y_UP)) == pytest.approx(np.hypot(14, 2), rel=0.01)
    clear, hit = (outline.discs(Y_UP, within_rad=w) for w in ((-2.0, 0.5), (0.5, 2.0)))
    assert max(r for *_, r in hit) > 14.0
    assert max(r for *_, r in clear) == pytest.approx(10.0, abs=1e-9)


@pytest.mark.parametrize("range_rad", [(-0.6, 0.5), (-2.2, 0.2), (-0.2, 2.2), None])
@pytest.mark.parametrize("swapped", [False, True])
def test_no_turn_is_called_free_at_which_parts_meet(range_rad: tuple[float, float] | None, swapped: bool) -> None:
    """A pin beside the disc, 90 degrees from the lug: it is met where the turn takes it there, and at no other."""
    disc, post = part("disc", lug()), part("post", rod(1.5, (0, 12, 0), (0, 12, 5)))
    span = (-np.pi, np.pi) if range_rad is None else range_rad
    a, b = (post, disc) if swapped else (disc, post)
    solver = _Overlaps(MeshLibrary([disc, post], 0.1, 0.5))
    bound = solver._at_any_turn(a, b, Turning(Y_UP, Y_UP, range_rad))
    turns = [Y_UP @ _about_y(angle) @ np.linalg.inv(Y_UP) for angle in np.linspace(*span, 41)]
    worst = max(common_volume(a.solid, b.solid, turn) or 0.0 for turn in turns)
    assert bound is not None
    assert bound >= worst - 1e-6
    assert (bound <= fits.OVERLAP_MM3) == (worst <= fits.OVERLAP_MM3)  # here the bound decides as the solids do


def _about_y(angle: float) -> np.ndarray:
    return np.linalg.inv(Y_UP) @ turned_z(angle) @ Y_UP


@pytest.mark.parametrize("moved", ["pin", "plate"])
def test_a_way_in_a_bore_is_proven_free_at_once(moved: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whichever of the two comes in: 20 mm of a fit would else take ten pairs of solids."""
    required: list[object] = []
    common = shared_volume.common_size
    for module in (shared_volume, swept_bodies):
        monkeypatch.setattr(module, "common_size", lambda *given: required.append(given) or common(*given))
    assert met(moved, pin(20.0)) is None
    assert 1 <= len(required) <= 2


@pytest.mark.parametrize("moved", ["pin", "plate"])
def test_a_collar_behind_the_bore_is_met_all_the_same(moved: str) -> None:
    """On the side to which the pin leaves it cannot pass; on the other one it goes along and meets nothing."""
    shank = rod(3, (0, 0, 0), (0, 0, 20))
    behind, before = (part("pin", shank.fuse(rod(4, (0, 0, z), (0, 0, z + 3)))) for z in (-3.0, 12.0))
    assert met(moved, behind) is not None
    assert met(moved, before) is None


def test_a_key_on_a_round_pin_is_met_where_its_way_has_no_room() -> None:
    """The keyway ends: what the discs cannot prove free the solids decide, here that it is not."""
    keyed = part("pin", rod(3, (0, 0, 0), (0, 0, 10)).fuse(box((2, -0.5, 0), (4, 0.5, 3))))
    slot = box((2, -0.5, 0), (4, 0.5, 3))
    slotted = part("plate", plate().solid.cut(slot))
    a = on_base(keyed, slotted)
    assert Ways(a, MeshLibrary(a.parts)).met(["pin"], ["plate"], [(-Z, inf)]) is not None
    assert Ways(a, MeshLibrary(a.parts)).met(["pin"], ["plate"], [(Z, inf)]) is None  # out of the open end


def met(moved: str, one: Part) -> object:
    a = on_base(one, plate())
    other = "plate" if moved == "pin" else "pin"
    along = -Z if moved == "pin" else Z
    return Ways(a, MeshLibrary(a.parts)).met([moved], [other], [(along, inf)])
