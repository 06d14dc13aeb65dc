"""The live page itself: a server that shows the machine, takes the dragged handle and the sliders, tells figures."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from html import escape
from threading import Condition, Event, RLock, Thread
from time import monotonic
from typing import TYPE_CHECKING, Any

import numpy as np

from delta_cad.assembly.tessellation import Meshes
from delta_cad.common.units import M_PER_MM, MM_PER_M
from delta_cad.design import Design
from delta_cad.mechanism import MechanismError, jacobian
from delta_cad.mechanism.limits import HandleInertia
from delta_cad.report.live.guard import one_of, within
from delta_cad.report.live.lengths import Lengths, readings, skeleton

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from viser import ViserServer

    from delta_cad.assembly.machine import Assembly
    from delta_cad.report.live.earlier import Earlier
    from delta_cad.report.live.nearest import Nearest, Neighbours


# What the handle gives the hand in the scenes of the live page: forces as they are asked for, without the loop.
FREE, FLOOR, RESISTANCE = "none, weight held", "floor at half height", "viscous resistance"
SCENES = (FREE, FLOOR, RESISTANCE)
FLOOR_N_MM = 1.0  # 3 N at 3 mm: seen in the picture, and less than any loop of ours bears
RESISTANCE_N_S_MM = 0.02  # 2 N at 100 mm/s, a quick move of a hand


def felt(scene: str, most_N: float, above_mm: float, v_mm_s: np.ndarray) -> np.ndarray:
    """Computes the force on the hand.

    Args:
        scene: One of `SCENES`.
        most_N: Continuous force of the machine; more than that is not given.
        above_mm: Height of the handle over the cube's centre.
        v_mm_s: (3,) velocity of the handle.

    Returns:
        (3,) force in the base frame, N.
    """
    force = np.zeros(3)
    if scene == FLOOR:
        force[2] = FLOOR_N_MM * max(-above_mm, 0.0)
    elif scene == RESISTANCE:
        force = -RESISTANCE_N_S_MM * np.asarray(v_mm_s)
    size = float(np.linalg.norm(force))
    return force * (most_N / size) if size > most_N else force


SLIDERS = {
    "upper_arm_length_mm": "upper arm L_A",
    "forearm_length_mm": "forearm L_B",
    "base_radius_mm": "base radius R",
    "platform_radius_mm": "platform radius r",
    "bottom_height_mm": "cube's floor H",
    "half_side_mm": "cube's half side",
}
_RANGE = 0.4  # share of a length by which its slider goes either way
_COLOURS = {"base": (60, 66, 76), "arms": (224, 108, 30), "rods": (30, 32, 36), "platform": (30, 100, 190)}
_CUBE_COLOUR = (47, 111, 208)
_THICK_PX, _THIN_PX = 5.0, 1.5
NEAR_COLOUR, _FELT_COLOUR, _WEIGHT_COLOUR = (225, 30, 30), (205, 20, 120), (20, 130, 60)
ARROW_MM_N = 15.0  # length of a force: 3 N are half a cube
_SHAFT_M = 0.0018  # radius of an arrow
_LEAST_N = 0.01  # less is no arrow
_REST_S = 0.25  # after which a handle that nobody moved stands still
_SAME_MM = 1e-3  # what the handle is off where it is left to who drags it
_NARROW = 0.8  # width of a screen over its height below which its controls cover its lower part
_ROOM = 1.35  # of what is shown about the middle, to the radius of the elbows: knob, motors, what is near looks larger
_COVERED = 0.6  # of its height, by viser's own panel
_FAINT = 0.35  # opacity of the solids of another design
_STYLE = "<div style='font-size:0.8rem;padding:0 0.75rem'>"
HANDLE = "/handle"
_LEVEL = 1e-6  # length of what of the vertical a camera sees that looks along it


class LivePage:
    """What all viewers of one server see; the last one who moves something is right."""

    def __init__(self, server: ViserServer, design: Design) -> None:
        self._server, self._design, self._lock = server, design, RLock()
        self.own = self.lengths = Lengths.of(design)
        self.handle_mm = self.lengths.centre_mm
        self._inertia: HandleInertia | None = None
        self._assembly: Assembly | None = None
        self._frames: dict[str, Any] = {}
        self._drawn: dict[str, tuple[np.ndarray, Any]] = {}
        self._bodies: dict[str, tuple[Any, tuple[int, ...]]] = {}
        self._earlier: Earlier | None = None
        self._earlier_frames: dict[str, Any] = {}
        self._knob_mm = 0.0  # height of its top over the handle's position, the platform's centre
        self._weight_N_m: Callable[[np.ndarray], np.ndarray] | None = None
        self._neighbours: Neighbours | None = None
        self._near: tuple[np.ndarray, Nearest | None] | None = None  # and where the handle was
        self._velocity, self._moved_at, self._moved = np.zeros(3), monotonic(), Event()
        self._wanted: dict[str, Callable[[], None]] = {}
        self._wanting, self._closed = Condition(), False
        self._begin()
        self._threads = [Thread(target=work, daemon=True) for work in (self._follow, self._act)]
        for thread in self._threads:
            thread.start()

    def _begin(self) -> None:
        server = self._server
        server.scene.set_up_direction("+z")
        # sharing would go by another's server
        server.gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")
        far = M_PER_MM * 2.6 * (self.own.forearm_length_mm + self.own.farthest_mm)
        server.initial_camera.position = (0.45 * far, -0.75 * far, 0.6 * far)
        server.initial_camera.look_at = tuple(M_PER_MM * self.own.centre_mm * 0.4)
        server.on_client_connect(lambda client: self.frame(client.camera))
        self._doing = server.gui.add_html("")
        self._reported = server.gui.add_html("")
        with server.gui.add_folder("Lengths, mm"):
            self._sliders = {name: self._slider(name, words) for name, words in SLIDERS.items()}
            original = server.gui.add_button("original lengths")
        centre = server.gui.add_button("centre of the cube")
        self._buttons = original, centre
        self._solids = server.gui.add_checkbox("solids", True, disabled=True, hint="for the original lengths only")
        self._scene = server.gui.add_dropdown("virtual contact", SCENES)
        self._grip = server.scene.add_transform_controls(HANDLE, scale=0.06, disable_rotations=True, depth_test=False)
        original.on_click(self._later("lengths", lambda _: partial(self.change, self.own)))
        centre.on_click(self._later("handle", lambda _: self._centre))
        for shown in (self._solids, self._scene):
            shown.on_update(self._later("show", lambda _: self._show))
        self._grip.on_update(
            self._later("handle", lambda event: partial(self.move, MM_PER_M * np.asarray(event.target.position)))
        )
        self.move(self.handle_mm)

    def _slider(self, name: str, words: str) -> Any:
        value = float(getattr(self.own, name))
        room = _RANGE * value
        low = value - room
        if name == "base_radius_mm":  # moves all chains; those nearer than chain 0 stay outside the axis
            low = max(low, 1.0 - min(self.own.side_shift_mm, 0.0))
        slider = self._server.gui.add_slider(words, round(low, 1), round(value + room, 1), 0.1, round(value, 1))
        slider.on_update(self._later(name, lambda event: partial(self._slid, name, float(event.target.value))))
        return slider

    def _later(
        self, what: str, wish: Callable[[Any], Callable[[], None]]
    ) -> Callable[[Any], Coroutine[Any, Any, None]]:
        """Makes the callback of a control: the page follows the latest of each kind, however many come meanwhile.

        Args:
            what: The kind.
            wish: Gives what is to be done for an event; called at once, as the control's value may be another later.
        """

        async def wanted(event: Any) -> None:
            if event.client_id is None:  # what the page itself sets
                return
            with self._wanting:
                self._wanted[what] = wish(event)
                self._wanting.notify()

        return wanted

    def _act(self) -> None:
        """Does what viewers want, one after the other."""
        while True:
            with self._wanting:
                self._wanting.wait_for(lambda: self._wanted or self._closed)
                if self._closed:
                    return
                act = self._wanted.pop(next(iter(self._wanted)))
            act()

    def _slid(self, name: str, value_mm: float) -> None:
        self.change(replace(self.lengths, **{name: value_mm}))

    def _centre(self) -> None:
        self.move(self.lengths.centre_mm)

    def frame(self, camera: Any) -> None:
        """Shows the machine over the panel of controls where the screen is narrow, whose lower part that covers."""
        if camera.image_width >= _NARROW * camera.image_height:
            return
        at = M_PER_MM * self.own.centre_mm * 0.4
        away = np.asarray(camera.position) - np.asarray(camera.look_at)
        away /= np.linalg.norm(away)
        up = np.array([0.0, 0.0, 1.0]) - away[2] * away
        if (length := np.linalg.norm(up)) < _LEVEL:  # it looks straight down
            return
        up /= length
        shown, half = 1.0 - _COVERED, _ROOM * M_PER_MM * (self.own.farthest_mm + self.own.upper_arm_length_mm)
        share = min(shown, camera.image_width / camera.image_height)  # of the screen's height, which is free
        far = half / (share * np.tan(camera.fov / 2.0))
        lower = _COVERED * far * np.tan(camera.fov / 2.0)  # brings what was in the middle to the middle of what is free
        with camera.client.atomic():
            camera.position = tuple(at + far * away - lower * up)
            camera.look_at = tuple(at - lower * up)

    def say(self, words: str) -> None:
        """Shows a sentence on what is being done over all else; "" for nothing."""
        self._doing.content = f"{_STYLE}<b>{escape(words)}</b></div>" if words else ""

    def show_earlier(self, machine: Earlier) -> None:
        """Shows the solids of the last build until `solids` gives others; faint where it is of another design."""
        scene, opacity = self._server.scene, None if machine.same else _FAINT
        with self._lock:
            for link in {body.link for body in machine.bodies}:
                self._earlier_frames[link] = scene.add_frame(f"/earlier/{link}", show_axes=False)
            for body in machine.bodies:
                name = f"/earlier/{body.link}/{body.name}"
                settings = {"color": body.colour, "flat_shading": True, "opacity": opacity}
                scene.add_mesh_simple(name, body.points_m, body.faces, **settings)
            self._earlier = machine
            self._show()

    def solids(
        self,
        assembly: Assembly,
        meshes: Meshes,
        inertia: HandleInertia,
        weight_N_m: Callable[[np.ndarray], np.ndarray],
        neighbours: Neighbours,
    ) -> None:
        """Shows the solids of the design's own machine, which move as long as the lengths are its own.

        Args:
            assembly: The machine.
            meshes: Part number -> mesh, mm.
            inertia: What moves.
            weight_N_m: Handle position (3,), mm -> (3,) torque of each joint that holds what moves.
            neighbours: What may come close.
        """
        scene = self._server.scene
        with self._lock:
            for link in {o.link for o in assembly.occurrences}:
                self._frames[link] = scene.add_frame(f"/machine/{link}", show_axes=False)
            for o in assembly.occurrences:
                mesh, turn = meshes[o.part.number], quaternion(o.placement[:3, :3])
                colour = np.round(255.0 * np.array(o.part.material.colour)).astype(np.uint8)
                points, at = M_PER_MM * mesh.vertices, M_PER_MM * o.placement[:3, 3]
                name = f"/machine/{o.link}/{o.name}"
                known = scene.add_mesh_simple(
                    name, points, mesh.faces, color=colour, flat_shading=True, wxyz=turn, position=tuple(at)
                )
                self._bodies[o.name] = known, tuple(colour.tolist())
                if o.link == "platform":
                    self._knob_mm = max(
                        self._knob_mm, float((mesh.vertices @ o.placement[2, :3]).max() + o.placement[2, 3])
                    )
            self._assembly, self._inertia = assembly, inertia
            self._weight_N_m, self._neighbours = weight_N_m, neighbours
            self._solids.disabled = False
            self._earlier = None
            for frame in self._earlier_frames.values():
                frame.remove()
            self._earlier_frames.clear()
            self._show()
        self._moved.set()

    def move(self, p_mm: np.ndarray) -> None:
        """Moves the handle to the position of the cube that is nearest to one, (3,) mm, if the chains reach it."""
        with self._lock:
            within, now = self.lengths.within(np.asarray(p_mm, dtype=float)), monotonic()
            if self.lengths.reaches(within):
                took = now - self._moved_at
                self._velocity = (within - self.handle_mm) / took if 0.0 < took < _REST_S else np.zeros(3)
                self.handle_mm, self._moved_at = within, now
            if not np.allclose(MM_PER_M * np.asarray(self._grip.position), self.handle_mm, atol=_SAME_MM):
                self._grip.position = tuple(M_PER_MM * self.handle_mm)
            self._show()
        self._moved.set()

    def _follow(self) -> None:
        """Looks for what is closest whenever the handle was moved, and for when it stands still."""
        while True:
            moved = self._moved.wait(_REST_S if self._velocity.any() else None)
            if self._closed:
                return
            if moved:
                self._moved.clear()
                self.measure()
            else:
                self.rest()

    def close(self) -> None:
        """Ends what goes on beside the server, which may stop then."""
        with self._wanting:
            self._closed = True
            self._wanting.notify()
        self._moved.set()
        for thread in self._threads:
            thread.join()

    def ranges(self) -> dict[str, Callable[[Any], Any]]:
        """Gives what each control may be set to: id of the control -> see `guard.Guard.controls`."""
        found = [(slider, within(slider.min, slider.max)) for slider in self._sliders.values()]
        found += [(button, one_of(True)) for button in self._buttons]
        found += [(self._solids, one_of(True, False)), (self._scene, one_of(*SCENES))]
        return {control._impl.uuid: legal for control, legal in found}

    def nearest_m(self, position_m: tuple[float, float, float]) -> tuple[float, float, float]:
        """Gives the position within the cube that is nearest to one, m."""
        x, y, z = M_PER_MM * self.lengths.within(MM_PER_M * np.asarray(position_m))
        return float(x), float(y), float(z)

    def rest(self) -> None:
        """Lets the handle stand still."""
        with self._lock:
            self._velocity = np.zeros(3)
            self._show()

    def measure(self) -> None:
        """Finds what is closest where the handle is, and shows it."""
        at, neighbours = self.handle_mm, self._neighbours
        if neighbours is None or self.lengths != self.own:
            return
        found = neighbours.at(at)
        with self._lock:
            self._near = at, found
            self._show()

    def change(self, lengths: Lengths) -> None:
        """Makes the mechanism anew with other lengths."""
        with self._lock:
            self.lengths = lengths
            for name, slider in self._sliders.items():
                value = round(float(getattr(lengths, name)), 1)
                if name not in self._wanted and slider.value != value:
                    slider.value = value
            self.move(self.handle_mm)

    def _show(self) -> None:
        """Puts everything where it belongs, in one message."""
        with self._lock, self._server.atomic():
            reached = self.lengths.reaches(self.handle_mm)
            solid = self._assembly is not None and self.lengths == self.own and self._solids.value
            lines: dict[str, np.ndarray] = {}
            if reached and not solid and not self._place_earlier():
                lines = skeleton(self.lengths, self._design.mechanism.parallelogram_width_mm, self.handle_mm)
            for link, frame in self._poses(solid and reached).items():
                handle = self._frames[link]
                handle.wxyz, handle.position = quaternion(frame[:3, :3]), tuple(M_PER_MM * frame[:3, 3])
            for handle in self._frames.values():
                handle.visible = solid
            for name, colour in _COLOURS.items():
                self._lines(name, lines.get(name), colour, _THICK_PX)
            self._lines("cube", self.lengths.cube_edges(), _CUBE_COLOUR, _THIN_PX)
            self._show_near(solid and reached)
            force, held = self._forces(reached)
            self._arrow("felt", force, _FELT_COLOUR, self._knob_mm if solid else 0.0)
            self._arrow("weight", -held, _WEIGHT_COLOUR)
            self._lines("floor", self._floor() if self._scene.value == FLOOR else None, _FELT_COLOUR, _THIN_PX)
            self._reported.content = self._table(reached, force, held)

    def _place_earlier(self) -> bool:
        """Moves the solids of the last build, hidden out of their reach; whether they stand for the mechanism."""
        earlier, frames = self._earlier, dict[str, np.ndarray]()
        if earlier is not None and self.lengths == self.own:
            with suppress(MechanismError):
                frames = dict(earlier.placement(self.handle_mm))
        for link, frame in self._earlier_frames.items():
            frame.visible = link in frames
            if link in frames:
                frame.wxyz, frame.position = quaternion(frames[link][:3, :3]), tuple(M_PER_MM * frames[link][:3, 3])
        return earlier is not None and earlier.same and bool(frames)

    def _floor(self) -> np.ndarray:
        """(4, 2, 3) edges of the floor that is felt, mm."""
        corners = self.lengths.centre_mm + self.lengths.half_side_mm * np.array(
            [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
        )
        return np.stack([corners, np.roll(corners, 1, axis=0)], axis=1)

    def _near_here(self) -> Nearest | None:
        """What is closest where the handle is; None while that is looked for."""
        return self._near[1] if self._near and np.array_equal(self._near[0], self.handle_mm) else None

    def _show_near(self, wanted: bool) -> None:
        """Marks the two bodies that are closest, and where; those of the last position while the handle is moved."""
        near = self._near[1] if self._near and wanted else None
        for name, (handle, colour) in self._bodies.items():
            shown = NEAR_COLOUR if near and name in near.names else colour
            if tuple(handle.color) != shown:
                handle.color = shown
        here = self._near_here() if wanted else None
        self._lines("near", None if here is None else here.ends_mm[None], NEAR_COLOUR, _THICK_PX)

    def _forces(self, reached: bool) -> tuple[np.ndarray, np.ndarray]:
        """The force on the hand, and the one at the handle that holds what moves, (3,) N each."""
        above = float((self.handle_mm - self.lengths.centre_mm)[2])
        force = felt(self._scene.value, self._design.requirements.force_N, above, self._velocity)
        if not reached or self._weight_N_m is None or self.lengths != self.own:
            return force if reached else np.zeros(3), np.zeros(3)
        to_joints = jacobian(self.lengths.geometry, self.handle_mm / MM_PER_M).T
        return force, np.linalg.solve(to_joints, self._weight_N_m(self.handle_mm))

    def _arrow(self, name: str, force_N: np.ndarray, colour: tuple[int, int, int], above_mm: float = 0.0) -> None:
        """Draws a force at the handle, or above it."""
        ends = self.handle_mm + [0.0, 0.0, above_mm] + ARROW_MM_N * np.array([[np.zeros(3), force_N]])
        self._lines(name, ends if np.linalg.norm(force_N) >= _LEAST_N else None, colour, arrow=True)

    def _poses(self, wanted: bool) -> Mapping[str, np.ndarray]:
        if not wanted or self._assembly is None:
            return {}
        frames = self._assembly.placement(self.handle_mm)
        return {link: frames[link] for link in self._frames}

    def _lines(
        self,
        name: str,
        ends: np.ndarray | None,
        colour: tuple[int, int, int],
        thick_px: float = _THICK_PX,
        arrow: bool = False,
    ) -> None:
        """Draws lines or arrows (n, 2, 3) in mm anew, or hides those of that name; what is drawn already stays."""
        drawn, known = self._drawn.get(name, (None, None))
        if ends is None:
            if known is not None:
                known.visible = False
            return
        if known is None or drawn is None or not np.array_equal(drawn, ends):
            scene, path, points = self._server.scene, f"/skeleton/{name}", M_PER_MM * ends
            if arrow:
                known = scene.add_arrows(
                    path, points, colour, shaft_radius=_SHAFT_M, head_radius=3.0 * _SHAFT_M, head_length=7.0 * _SHAFT_M
                )
            else:
                known = scene.add_line_segments(path, points, colour, thickness=thick_px, thickness_units="screen")
            self._drawn[name] = (ends, known)
        known.visible = True

    def _table(self, reached: bool, force_N: np.ndarray, held_N: np.ndarray) -> str:
        x, y, z = self.handle_mm
        head = f"{_STYLE}handle {x:.1f}, {y:.1f}, {z:.1f} mm"
        if not reached:
            return f"{head}<br><b>out of reach</b></div>"
        rows = readings(self.lengths, self._design.requirements.force_N, self._inertia, self.handle_mm)
        cells = "".join(f"<tr><td>{r.words}</td><td>{r.here}</td><td>{r.worst}</td></tr>" for r in rows)
        reported = [("rendered force", f"{np.linalg.norm(force_N):.2f} N")]
        if held_N.any():
            motors = jacobian(self.lengths.geometry, self.handle_mm / MM_PER_M).T @ (force_N + held_N)
            reported += [("weight, held by the motors", f"{np.linalg.norm(held_N):.2f} N")]
            reported += [("joint torques for both", ", ".join(f"{one:.3f}" for one in motors) + " N m")]
        if self._neighbours is not None and self.lengths == self.own:
            near, waits = self._near and self._near[1], "" if self._near_here() else " ..."
            where = f"{near.distance_mm:.2f} mm, {' / '.join(near.names)}{waits}" if near else waits
            reported += [(f"clearance, required {self._neighbours.limit_mm:g} mm", where)]
        cells += "".join(f"<tr><td>{words}</td><td colspan=2>{value}</td></tr>" for words, value in reported)
        note = "" if self.lengths == self.own else "masses as designed; solids are shown for the original lengths only"
        heads = "<tr><th></th><th align=left>here</th><th align=left>worst in the cube</th></tr>"
        return f"{head}<table width=100%>{heads}{cells}</table>{note}</div>"


def quaternion(rotation: np.ndarray) -> tuple[float, float, float, float]:
    """Computes the unit quaternion (w, x, y, z) of a (3, 3) rotation."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return float(w), float(x), float(y), float(z)
