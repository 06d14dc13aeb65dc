"""The live page on its server: what follows the handle and the sliders, and by a mouse."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import AbstractContextManager, nullcontext, redirect_stdout
from dataclasses import replace
from io import StringIO
from typing import Any

import numpy as np
import pytest

from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.bodies import DistanceEngine
from delta_cad.checks.clearance.pairing import by_several_joints, clearance_pairs
from delta_cad.checks.clearance.sampled import TOLERANCE_MM, Sampler
from delta_cad.design import Design
from delta_cad.mechanism import jacobian
from delta_cad.mechanism.geometry import THREE_FOLD, directions
from delta_cad.mechanism.limits import HandleInertia
from delta_cad.report.live import page as live_page
from delta_cad.report.live.guard import Guard, guarded_server
from delta_cad.report.live.nearest import Nearest, Neighbours
from delta_cad.report.live.page import (
    ARROW_MM_N,
    FLOOR,
    FLOOR_N_MM,
    FREE,
    HANDLE,
    NEAR_COLOUR,
    RESISTANCE,
    RESISTANCE_N_S_MM,
    LivePage,
    felt,
    quaternion,
)
from delta_cad.report.subject import Subject
from tests.delta_cad.checks.machines import LIMITS, machine

DRAWN_MS, PICTURE_MS, TRIES = 120_000, 500, 20  # a processor draws a picture in a second or so
WEIGHT_N = np.array([0.0, 0.0, 2.5])
INERTIA = HandleInertia(0.071, 0.0043, 0.0011, 3.1e-4)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as found:
        return found.getsockname()[1]


@pytest.fixture
def guard() -> Guard:
    return Guard("127.0.0.1", free_port(), print)


@pytest.fixture
def page(best: Design, guard: Guard) -> Iterator[LivePage]:
    server = guarded_server(guard, "test")
    page = LivePage(server, best)
    guard.begin(page.ranges(), HANDLE, page.nearest_m)
    yield page
    page.close()
    with redirect_stdout(StringIO()):
        server.stop()


class Two(Neighbours):
    """Two bodies, always the same."""

    def __init__(self, *names: str) -> None:
        self.limit_mm, self.found = 2.0, Nearest((names[0], names[1]), 1.25, np.array([[0.0, 0, 90], [0, 1.25, 90]]))

    def at(self, p_mm: np.ndarray) -> Nearest:
        del p_mm
        return self.found


def show_solids(page: LivePage, subject: Subject, weight_N: np.ndarray) -> list[str]:
    """Gives the page its solids, of which two are close; their names."""

    def weight(p_mm: np.ndarray) -> np.ndarray:
        return jacobian(page.own.geometry, p_mm / 1000.0).T @ weight_N

    names = [o.name for o in subject.assembly.occurrences][:2]
    page.solids(subject.assembly, subject.meshes, INERTIA, weight, Two(*names))
    return names


def drawn(page: LivePage) -> dict[str, bool]:
    return {name: handle.visible for name, (_, handle) in page._drawn.items()}


class Camera:
    """What a viewer's camera is asked and told, looking along y at something."""

    def __init__(self, width: int, height: int) -> None:
        self.image_width, self.image_height, self.fov = width, height, 1.3
        self.position, self.look_at, self.client = (0.0, -0.5, 0.3), (0.0, 0.0, 0.05), self

    def atomic(self) -> AbstractContextManager[None]:
        return nullcontext()

    def sees(self, point: np.ndarray) -> np.ndarray:
        """(2,) where a point stands on the screen: right and up from -1 to 1."""
        ahead = np.subtract(self.look_at, self.position)
        ahead /= np.linalg.norm(ahead)
        right = np.cross(ahead, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        off = point - np.asarray(self.position)
        scale = off @ ahead * np.tan(self.fov / 2.0)
        return np.array([off @ right * self.image_height / self.image_width, off @ np.cross(right, ahead)]) / scale


def test_on_a_phone_the_machine_stands_over_the_controls(page: LivePage) -> None:
    phone, screen = Camera(390, 844), Camera(1440, 900)
    before = screen.position, screen.look_at
    page.frame(screen)
    assert (screen.position, screen.look_at) == before
    page.frame(phone)
    wide = page.own.base_radius_mm + page.own.upper_arm_length_mm
    ends = [(x, y, z) for x in (-wide, wide) for y in (-wide, wide) for z in (0.0,)]
    cube = page.own.cube_edges().reshape(-1, 3)
    for point in np.concatenate([ends, cube]) / 1000.0:
        x, y = phone.sees(point)
        assert abs(x) < 1.0
        assert 1.0 - 2.0 * 0.4 < y < 1.0, point  # viser's panel ends at six tenths of the height


def test_the_handle_is_led_back_into_the_cube(page: LivePage) -> None:
    page.move(page.lengths.centre_mm + np.array([20.0, 0.0, 500.0]))
    top = page.lengths.centre_mm + np.array([20.0, 0.0, page.lengths.half_side_mm])
    assert page.handle_mm == pytest.approx(top)
    assert np.asarray(page._grip.position) * 1000.0 == pytest.approx(top, abs=1e-3)
    assert f"handle {top[0]:.1f}, {top[1]:.1f}, {top[2]:.1f} mm" in page._reported.content


def test_a_slider_makes_the_mechanism_anew(page: LivePage) -> None:
    before = page._reported.content
    assert all(drawn(page).values())
    page.change(replace(page.own, upper_arm_length_mm=100.0))
    assert page._sliders["upper_arm_length_mm"].value == 100.0
    arms, _ = page._drawn["arms"]
    assert np.linalg.norm(arms[:, 1] - arms[:, 0], axis=1) == pytest.approx([100.0] * 3)
    assert page._reported.content != before
    page.change(replace(page.own, forearm_length_mm=10.0))
    assert "out of reach" in page._reported.content
    assert drawn(page) == {"base": False, "arms": False, "rods": False, "platform": False, "cube": True}
    page.change(page.own)
    assert page._reported.content == before


def test_solids_move_with_the_handle_and_are_the_designs_alone(page: LivePage, subject: Subject) -> None:
    show_solids(page, subject, np.zeros(3))
    skeleton = {name: shown for name, shown in drawn(page).items() if name != "near"}
    assert skeleton == {"base": False, "arms": False, "rods": False, "platform": False, "cube": True}
    assert "effective mass" in page._reported.content
    page.move(page.own.centre_mm + np.array([12.0, -7.0, 9.0]))
    frames = subject.assembly.placement(page.handle_mm)
    assert set(page._frames) == {o.link for o in subject.assembly.occurrences}
    for link, handle in page._frames.items():
        assert handle.visible
        assert np.asarray(handle.position) * 1000.0 == pytest.approx(frames[link][:3, 3], abs=1e-6)
        assert turned(handle.wxyz) == pytest.approx(frames[link][:3, :3], abs=1e-9)
    page.change(replace(page.own, base_radius_mm=33.0))
    assert not any(handle.visible for handle in page._frames.values())
    assert drawn(page)["arms"]
    assert "masses as designed" in page._reported.content


def test_the_two_that_are_closest_are_marked_and_reported(page: LivePage, subject: Subject) -> None:
    names = show_solids(page, subject, np.zeros(3))
    page.measure()
    assert f"1.25 mm, {' / '.join(names)}</td>" in page._reported.content
    red = {name for name, (handle, _) in page._bodies.items() if tuple(handle.color) == NEAR_COLOUR}
    assert red == set(names)
    assert drawn(page)["near"]
    page.change(replace(page.own, base_radius_mm=33.0))
    assert not drawn(page)["near"]
    assert "1.25 mm" not in page._reported.content
    assert not any(tuple(handle.color) == NEAR_COLOUR for handle, _ in page._bodies.values())


def test_what_the_hand_feels_is_an_arrow_at_the_handle(
    page: LivePage, subject: Subject, monkeypatch: pytest.MonkeyPatch
) -> None:
    show_solids(page, subject, WEIGHT_N)
    ends, _ = page._drawn["weight"]
    assert ends[0] - page.handle_mm == pytest.approx(np.array([np.zeros(3), -ARROW_MM_N * WEIGHT_N]), abs=1e-9)
    assert "2.50 N" in page._reported.content
    page._scene.value = FLOOR
    page.move(page.own.centre_mm + np.array([0.0, 0.0, -1.5]))
    ends, arrow = page._drawn["felt"]
    assert ends[0, 1] - ends[0, 0] == pytest.approx([0.0, 0.0, ARROW_MM_N * 1.5 * FLOOR_N_MM])
    top = [subject.meshes[o.part.number].vertices for o in subject.assembly.occurrences if o.link == "platform"]
    assert ends[0, 0] - page.handle_mm == pytest.approx([0.0, 0.0, np.concatenate(top)[:, 2].max()], abs=1e-6)
    assert arrow.visible
    assert drawn(page)["floor"]
    page._scene.value = RESISTANCE
    times = iter((50.0, 50.1))
    monkeypatch.setattr(live_page, "monotonic", lambda: next(times, 60.0))
    page.move(page.own.centre_mm)
    page.move(page.own.centre_mm + np.array([4.0, 0.0, 0.0]))
    ends, _ = page._drawn["felt"]
    assert ends[0, 1] - ends[0, 0] == pytest.approx([-ARROW_MM_N * RESISTANCE_N_S_MM * 40.0, 0.0, 0.0])
    page.rest()
    assert not drawn(page)["felt"]


def test_a_scene_gives_no_more_than_the_machine_has_for_ever() -> None:
    v = np.array([30.0, -40.0, 0.0])
    assert felt(FREE, 3.0, -5.0, v) == pytest.approx([0.0, 0.0, 0.0])
    assert felt(FLOOR, 3.0, 2.0, v) == pytest.approx([0.0, 0.0, 0.0])
    assert felt(FLOOR, 3.0, -2.0, v) == pytest.approx([0.0, 0.0, 2.0 * FLOOR_N_MM])
    assert felt(FLOOR, 3.0, -20.0, v) == pytest.approx([0.0, 0.0, 3.0])
    assert felt(RESISTANCE, 3.0, 0.0, v) == pytest.approx(-RESISTANCE_N_S_MM * v)
    assert felt(RESISTANCE, 3.0, 0.0, 1000.0 * v) == pytest.approx([-1.8, 2.4, 0.0])


def test_the_neighbours_are_those_of_measuring_everything() -> None:
    assembly, engine = machine(), DistanceEngine()
    meshes = MeshLibrary(assembly.parts, 0.2, 0.6)
    neighbours = Neighbours(assembly, LIMITS, meshes)
    pairs = [p for p in clearance_pairs(assembly, LIMITS, meshes) if by_several_joints(p, assembly.placement)]
    for p_mm in LIMITS.corners_mm[::3]:
        frames = Sampler(assembly.placement, p_mm[None, :], engine).frames
        placed = [[frames[b.link][0] @ b.placement for b in (p.a, p.b)] for p in pairs]
        least = min(engine.distance(p.a, p.b, *two) for p, two in zip(pairs, placed, strict=True))
        found = neighbours.at(p_mm)
        assert found is not None
        assert np.linalg.norm(found.ends_mm[1] - found.ends_mm[0]) == pytest.approx(least, abs=TOLERANCE_MM)
        assert least - 1.0 < found.distance_mm <= least  # less both deviations


@pytest.mark.slow
def test_a_mouse_drags_the_handle_along_one_axis(page: LivePage, guard: Guard, chromium: Any) -> None:
    viewer = chromium.new_page(viewport={"width": 1000, "height": 700})
    required: list[str] = []
    viewer.on("request", lambda request: required.append(request.url))
    viewer.goto(guard.url)
    viewer.get_by_text("conditioning").wait_for(timeout=DRAWN_MS)
    start = page.handle_mm
    for _ in range(TRIES):  # until the picture is drawn there is nothing to take hold of
        viewer.mouse.move(500, 245)  # the arrow along z, above the handle
        viewer.wait_for_timeout(PICTURE_MS)
        viewer.mouse.down()
        for k in range(1, 6):
            viewer.mouse.move(500, 245 + 8 * k)
            viewer.wait_for_timeout(PICTURE_MS)
        viewer.mouse.up()
        if (page.handle_mm != start).any():
            break
    assert page.handle_mm[:2] == pytest.approx(start[:2], abs=1e-6)
    assert page.lengths.bottom_height_mm - 1e-6 <= page.handle_mm[2] < start[2] - 5.0
    assert viewer.get_by_text(f"{page.handle_mm[2]:.1f} mm").count() == 1
    host = f"http://127.0.0.1:{page._server.get_port()}/"
    assert {url for url in required if not url.startswith((guard.url, "blob:" + host, "data:"))} == set()
    assert guard.refusals.count == 0
    viewer.close()


def turned(wxyz: Any) -> np.ndarray:
    """Rotation of a unit quaternion, written out."""
    w, x, y, z = wxyz
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_a_quaternion_turns_as_its_rotation() -> None:
    for i in range(3):
        radial, tangential = (along[i] for along in directions(THREE_FOLD))
        rotation = np.stack([radial, tangential, [0.0, 0.0, 1.0]], axis=1) @ np.array(
            [[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]]
        )
        assert turned(quaternion(rotation)) == pytest.approx(rotation)
