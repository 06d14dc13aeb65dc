"""The live page itself: a server that shows the machine, takes the dragged handle and the sliders, tells figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np

from delta_cad.assembly.tessellation import Meshes
from delta_cad.common.units import M_PER_MM, MM_PER_M
from delta_cad.design import Design
from delta_cad.mechanism.limits import HandleInertia
from delta_cad.report.live.lengths import Lengths, readings, skeleton

if TYPE_CHECKING:
    from viser import ViserServer

    from delta_cad.assembly.machine import Assembly

SLIDERS = {
    "upper_arm_length_mm": "upper arm L_A",
    "forearm_length_mm": "forearm L_B",
    "base_radius_mm": "base radius R",
    "platform_radius_mm": "platform radius r",
    "bottom_height_mm": "cube's floor H",
    "half_side_mm": "cube's half side",
}
RANGE = 0.4  # share of a length by which its slider goes either way
COLOURS = {"base": (60, 66, 76), "arms": (224, 108, 30), "rods": (30, 32, 36), "platform": (30, 100, 190)}
CUBE_COLOUR = (47, 111, 208)
THICK_PX, THIN_PX = 5.0, 1.5
SAME_MM = 1e-3  # what the handle is off where it is left to who drags it
STYLE = "<div style='font-size:0.8rem;padding:0 0.75rem'>"
HANDLE = "/handle"


class LivePage:
    """What all viewers of one server see; the last one who moves something is right.

    Args:
        server: A viser server.
        design: The design.
    """

    def __init__(self, server: ViserServer, design: Design) -> None:
        self._server, self._design, self._lock = server, design, RLock()
        self.own = self.lengths = Lengths.of(design)
        self.handle_mm = self.lengths.centre_mm
        self._inertia: HandleInertia | None = None
        self._assembly: Assembly | None = None
        self._frames: dict[str, Any] = {}
        self._drawn: dict[str, tuple[np.ndarray, Any]] = {}
        self._begin()

    def _begin(self) -> None:
        server = self._server
        server.scene.set_up_direction("+z")
        # sharing would go by another's server
        server.gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")
        far = M_PER_MM * 2.6 * (self.own.forearm_length_mm + self.own.base_radius_mm)
        server.initial_camera.position = (0.45 * far, -0.75 * far, 0.6 * far)
        server.initial_camera.look_at = tuple(M_PER_MM * self.own.centre_mm * 0.4)
        self._told = server.gui.add_html("")
        with server.gui.add_folder("Lengths, mm"):
            self._sliders = {name: self._slider(name, words) for name, words in SLIDERS.items()}
            server.gui.add_button("as designed").on_click(lambda _: self.change(self.own))
        server.gui.add_button("centre of the cube").on_click(lambda _: self.move(self.lengths.centre_mm))
        self._solids = server.gui.add_checkbox("solids", True, disabled=True, hint="as designed only")
        self._solids.on_update(lambda _: self._show())
        self._grip = server.scene.add_transform_controls(HANDLE, scale=0.06, disable_rotations=True, depth_test=False)
        self._grip.on_update(lambda event: self.move(MM_PER_M * np.asarray(event.target.position)))
        self.move(self.handle_mm)

    def _slider(self, name: str, words: str) -> Any:
        value = float(getattr(self.own, name))
        room = RANGE * value
        slider = self._server.gui.add_slider(
            words, round(value - room, 1), round(value + room, 1), 0.1, round(value, 1)
        )
        slider.on_update(lambda event: self._slid(name, event))
        return slider

    def _slid(self, name: str, event: Any) -> None:
        if event.client is not None:  # not what `change` sets
            self.change(replace(self.lengths, **{name: float(event.target.value)}))

    def solids(self, assembly: Assembly, meshes: Meshes, inertia: HandleInertia) -> None:
        """Shows the solids of the design's own machine, which move as long as the lengths are its own.

        Args:
            assembly: The machine.
            meshes: Part number -> mesh, mm.
            inertia: What moves.
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
                scene.add_mesh_simple(
                    name, points, mesh.faces, color=colour, flat_shading=True, wxyz=turn, position=tuple(at)
                )
            self._assembly, self._inertia = assembly, inertia
            self._solids.disabled = False
            self._show()

    def move(self, p_mm: np.ndarray) -> None:
        """Moves the handle to the position of the cube that is nearest to one, (3,) mm, if the chains reach it."""
        with self._lock:
            within = self.lengths.within(np.asarray(p_mm, dtype=float))
            if self.lengths.reaches(within):
                self.handle_mm = within
            if not np.allclose(MM_PER_M * np.asarray(self._grip.position), self.handle_mm, atol=SAME_MM):
                self._grip.position = tuple(M_PER_MM * self.handle_mm)
            self._show()

    def change(self, lengths: Lengths) -> None:
        """Makes the mechanism anew with other lengths."""
        with self._lock:
            self.lengths = lengths
            for name, slider in self._sliders.items():
                if slider.value != (value := round(float(getattr(lengths, name)), 1)):
                    slider.value = value
            self.move(self.handle_mm)

    def _show(self) -> None:
        """Puts everything where it belongs, in one message."""
        reached = self.lengths.reaches(self.handle_mm)
        solid = self._assembly is not None and self.lengths == self.own and self._solids.value
        lines = {}
        if reached and not solid:
            lines = skeleton(self.lengths, self._design.mechanism.parallelogram_width_mm, self.handle_mm)
        with self._server.atomic():
            for link, frame in self._poses(solid and reached).items():
                handle = self._frames[link]
                handle.wxyz, handle.position = quaternion(frame[:3, :3]), tuple(M_PER_MM * frame[:3, 3])
            for handle in self._frames.values():
                handle.visible = solid
            for name, colour in COLOURS.items():
                self._lines(name, lines.get(name), colour, THICK_PX)
            self._lines("cube", self.lengths.cube_edges(), CUBE_COLOUR, THIN_PX)
            self._told.content = self._table(reached)

    def _poses(self, wanted: bool) -> Mapping[str, np.ndarray]:
        if not wanted or self._assembly is None:
            return {}
        frames = self._assembly.placement(self.handle_mm)
        return {link: frames[link] for link in self._frames}

    def _lines(self, name: str, ends: np.ndarray | None, colour: tuple[int, int, int], thick_px: float) -> None:
        """Draws lines (n, 2, 3) in mm anew, or hides those of that name; what is drawn already stays."""
        drawn, known = self._drawn.get(name, (None, None))
        if ends is None:
            if known is not None:
                known.visible = False
            return
        if known is None or drawn is None or not np.array_equal(drawn, ends):
            known = self._server.scene.add_line_segments(
                f"/skeleton/{name}", M_PER_MM * ends, colour, thickness=thick_px, thickness_units="screen"
            )
            self._drawn[name] = (ends, known)
        known.visible = True

    def _table(self, reached: bool) -> str:
        x, y, z = self.handle_mm
        head = f"{STYLE}handle {x:.1f}, {y:.1f}, {z:.1f} mm"
        if not reached:
            return f"{head}<br><b>out of reach</b></div>"
        rows = readings(self.lengths, self._design.requirements.force_N, self._inertia, self.handle_mm)
        cells = "".join(f"<tr><td>{r.words}</td><td>{r.here}</td><td>{r.worst}</td></tr>" for r in rows)
        note = "" if self.lengths == self.own else "masses as designed; the solids are those of the design alone"
        heads = "<tr><th></th><th align=left>here</th><th align=left>worst in the cube</th></tr>"
        return f"{head}<table width=100%>{heads}{cells}</table>{note}</div>"


def quaternion(rotation: np.ndarray) -> tuple[float, float, float, float]:
    """Computes the unit quaternion (w, x, y, z) of a (3, 3) rotation."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return float(w), float(x), float(y), float(z)
