"""A machine whose chains are placed for a rectangle: three equal chains, each where its azimuth and radius say."""

from __future__ import annotations

from collections import Counter
from itertools import product
from math import cos, radians, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.design import Design, design_from_dict
from delta_cad.dimensions import DimensionError, Dimensions, dimensions
from delta_cad.export.step import write_assembly_step
from delta_cad.mechanism import joint_angles
from delta_cad.solids.part import Occurrence
from tests.delta_cad.assembly.test_assemble_step import Exported, read
from tests.designs import placed

AZIMUTHS_DEG, RADII_MM, SQUARE_MM = (0.0, 116.3, -116.3), (30.8, 38.45, 38.45), 1e-9


def chain(name: str) -> int:
    return next(int(word) for word in name.split("_") if word.isdigit())


def turned(i: int, x: float, y: float, out_mm: float) -> np.ndarray:
    """What lies at (x, y) of chain 0, in the stand of chain i, by sine and cosine."""
    c, s = cos(radians(AZIMUTHS_DEG[i])), sin(radians(AZIMUTHS_DEG[i]))
    return np.array([(x + out_mm) * c - y * s, (x + out_mm) * s + y * c])


def test_only_base_plate_and_platform_know_the_placement(placed_assembly: Assembly) -> None:
    """As many part numbers as of the symmetric machine of the same lengths, made ones and bought ones."""
    data = placed()
    del data["mechanism"]["azimuths_deg"], data["mechanism"]["base_radii_mm"]
    data["mechanism"]["base_radius_mm"], data["cube"]["centre_x_mm"] = 38.45, 0.0
    data["cube"]["half_side_mm"] = 38.0
    from delta_cad.assembly.assemble import assemble

    even = assemble(dimensions(design_from_dict(data)))
    made, of_even = ({part.number for part in machine.parts if part.make} for machine in (placed_assembly, even))
    assert made == of_even
    uses = [
        Counter(o.part.piece_of or o.part.number for o in machine.occurrences) for machine in (placed_assembly, even)
    ]
    assert len(uses[0]) == len(uses[1])
    for number in made - {"base_plate", "platform"}:
        assert uses[0][number] == uses[1][number], number
        assert uses[0][number] % 3 == 0 or number in {"handle_stem", "panel", "bezel", "boot", "boot_collar"}, number


def test_what_stands_on_the_base_is_that_of_chain_0_turned_and_moved_out(placed_assembly: Assembly) -> None:
    stands = [
        o for o in placed_assembly.occurrences if o.link == "base" and any(w.isdigit() for w in o.name.split("_"))
    ]
    names = {o.name: o for o in stands}
    followed = 0
    for o in stands:
        if o.name.startswith(("foot_", "foot_screw", "bezel", "mount")) and not o.name.startswith("foot_block"):
            continue
        if chain(o.name) != 0:
            continue
        for i in (1, 2):
            words = o.name.split("_")
            words[next(k for k, word in enumerate(words) if word.isdigit())] = str(i)
            other: Occurrence = names["_".join(words)]
            assert other.part is o.part
            at, there = o.placement[:3, 3], other.placement[:3, 3]
            assert np.abs(there[:2] - turned(i, at[0], at[1], RADII_MM[i] - RADII_MM[0])).max() < SQUARE_MM, o.name
            assert there[2] == pytest.approx(at[2], abs=SQUARE_MM)
            first = [turned(i, way[0], way[1], 0.0) for way in o.placement[:3, :3].T]
            assert np.abs(np.array(first) - other.placement[:2, :3].T).max() < SQUARE_MM
            followed += 1
    assert followed > 60


def test_the_machine_is_drawn_where_its_arms_stand_alike(
    placed_assembly: Assembly, placed_dimensions: Dimensions
) -> None:
    design, home = placed_dimensions.design, placed_assembly.home_mm
    angles = joint_angles(design.geometry, home / 1000.0)
    assert np.ptp(angles) < 1e-12
    cube = design.cube
    assert abs(home[0] - 11.1) < cube.half_side_mm
    assert home[1:] == pytest.approx([0.0, cube.bottom_height_mm + cube.half_side_mm])
    arms = [RADII_MM[i] - 22.55 + 94.4 * np.cos(angles[i]) for i in range(3)]  # elbows less the platform's radius
    elbows = np.array([[*turned(i, out, 0.0, 0.0), 94.4 * np.sin(angles[i])] for i, out in enumerate(arms)])
    assert np.linalg.norm(home - elbows, axis=1) == pytest.approx([148.4] * 3, abs=1e-9)


def test_a_cube_in_which_the_arms_nowhere_stand_alike_is_refused() -> None:
    data = placed()
    data["cube"] = {"bottom_height_mm": 110.0, "half_side_mm": 5.0, "centre_x_mm": 25.0}
    del data["panel"]
    with pytest.raises(DimensionError) as refused:
        dimensions(design_from_dict(data))
    (reason,) = [one for one in refused.value.reasons if one.feature == "home"]
    assert "x = 20 mm" in reason.message
    assert reason.field == "cube.centre_x_mm"


def test_the_panel_lies_about_the_middle_of_the_cube(placed_assembly: Assembly, placed_dimensions: Dimensions) -> None:
    centre = placed_dimensions.design.workspace.centre[:2] * 1000.0
    assert centre == pytest.approx([11.1, 0.0])
    for name in ("panel", "boot", "bezel"):
        (o,) = [o for o in placed_assembly.occurrences if o.name == name]
        box = o.part.solid.BoundingBox()
        assert o.placement[:2, 3] + [box.center.x, box.center.y] == pytest.approx(centre, abs=1e-6), name
    screws = [o.placement[:2, 3] for o in placed_assembly.occurrences if o.name.startswith("bezel_screw")]
    assert np.mean(screws, axis=0) == pytest.approx(centre)


def test_the_base_plate_carries_its_blocks_with_a_rim(placed_assembly: Assembly, placed_dimensions: Dimensions) -> None:
    """Each block's corners lie at least 4 mm inside the solid plate; its screws and pins go through bores of it."""
    import cadquery as cq

    d = placed_dimensions
    plate: Any = next(part.solid for part in placed_assembly.parts if part.number == "base_plate")
    z = d.base.top_mm - d.base.thickness_mm / 2
    wide = max(-d.layers.encoder_cheek_mm[0], d.layers.motor_cheek_mm[1])
    for i, side, way in product(range(3), (-1.0, 1.0), np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)):
        x, y = turned(i, d.bracket.foot_u_mm[1], side * wide, RADII_MM[i] - RADII_MM[0])
        at = cq.Vector(x + 3.99 * np.cos(way), y + 3.99 * np.sin(way), z)
        assert plate.isInside(at, 1e-6) or abs(x) < d.base.centre_hole_mm, (i, side, way)
    through = [o for o in placed_assembly.occurrences if o.name.startswith(("base_screw", "base_dowel", "foot_screw"))]
    assert len(through) == 12
    for o in through:
        assert not plate.isInside(cq.Vector(o.placement[0, 3], o.placement[1, 3], z), 1e-6), o.name


def test_step_read_back_has_the_stands_where_the_placement_says(
    placed_assembly: Assembly, placed_dimensions: Dimensions, tmp_path: Path
) -> None:
    """Fitted to faces that another reader took from the file: shoulders' axes, motors' axes, wrists' bosses."""
    d = placed_dimensions
    write_assembly_step(placed_assembly, tmp_path / "assembly.step")
    exported: Exported = read(tmp_path / "assembly.step", {"shoulder_shaft", "motor", "platform"})
    axes = [
        ("shoulder_shaft", d.bearing.bore_mm, 0.0, RADII_MM[0]),
        ("motor", d.motor.diameter_mm, d.bracket.motor_axis_mm[1], d.bracket.motor_axis_mm[0]),
    ]
    for number, diameter, height, out in axes:
        assert len(exported[number]) == 3
        near = []
        for solid in exported[number]:
            fits = [(c, w) for kind, c, w, wide in solid if kind == "Cylinder" and abs(wide - diameter) < 0.03]
            assert fits, number
            for i in range(3):
                tangent = np.array([*turned(i, 0.0, 1.0, 0.0), 0.0])
                stand = np.array([*turned(i, out, 0.0, RADII_MM[i] - RADII_MM[0]), height])
                off = [
                    np.linalg.norm(np.cross(c - stand, tangent)) + np.linalg.norm(np.cross(w, tangent)) for c, w in fits
                ]
                near += [i] if min(off) < 1e-6 else []
        assert sorted(near) == [0, 1, 2], number
    (solid,) = exported["platform"]
    bores = [(c, w) for kind, c, w, wide in solid if kind == "Cylinder" and abs(wide - d.platform.bar_bore_mm) < 1e-6]
    for i in range(3):
        tangent = np.array([*turned(i, 0.0, 1.0, 0.0), 0.0])
        wrist = placed_assembly.home_mm + np.array([*turned(i, 22.55, 0.0, 0.0), 0.0])
        assert min(np.linalg.norm(np.cross(c - wrist, tangent)) for c, w in bores if abs(w @ tangent) > 0.9999) < 1e-6


def test_the_order_of_assembly_says_where_the_panel_and_the_arms_stand(placed_assembly: Assembly) -> None:
    steps = [step for unit in placed_assembly.order for step in unit.steps]
    words = " ".join(text for step in steps for text in (*step.words, *step.checks))
    assert "The opening's middle is 11.1 mm from the base's axis, towards arm 0" in words
    design: Design = design_from_dict(placed())
    first, side, _ = np.degrees(joint_angles(design.geometry, design.workspace.centre))
    assert f"{first:.2f} deg are shown at shoulder 0, {side:.2f} deg at shoulders 1 and 2" in words


@pytest.mark.parametrize("machine", ["best", "placed"])
def test_the_wrist_that_belongs_to_chain_0_is_marked_where_the_platform_fits_once(
    machine: str, request: pytest.FixtureRequest
) -> None:
    assembly: Assembly = request.getfixturevalue(f"{machine}_assembly")
    words = " ".join(text for unit in assembly.order for step in unit.steps for text in step.words)
    parts = {one.part.number: one.part.description for one in assembly.occurrences}
    fits_once = machine == "placed"
    assert ("Wrist 0, marked 0, is over arm 0" in words) is fits_once
    assert ("the one at 0 dimensioned and marked 0" in parts["platform"]) is fits_once
    plate = "shoulder of chain 0 at R 30.8, of chains 1, 2 at R 38.45, at azimuths 0, 116.3, 243.7 deg"
    assert (plate in parts["base_plate"]) is fits_once
