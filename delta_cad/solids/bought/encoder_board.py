"""The encoder's board."""

from __future__ import annotations

from delta_cad.dimensions import Dimensions
from delta_cad.solids.making import bought_part
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import THROUGH_MM, bore_y, box, cut, feature, fuse


def make_encoder_board(d: Dimensions) -> Part:
    """Encoder board: chip side towards +y, board from y = -thickness to 0, chip over the origin."""
    e = d.encoder
    half_x, half_z = e.board_length_mm / 2, e.board_width_mm / 2
    board = box((-half_x, -e.board_thickness_mm, -half_z), (half_x, 0.0, half_z))
    chip = box((-2.2, -THROUGH_MM, -2.5), (2.2, e.chip_height_mm, 2.5))
    plug = box((half_x - 5.0, -e.board_thickness_mm - 4.0, -5.0), (half_x - 1.0, -e.board_thickness_mm + 0.2, 5.0))
    holes = [
        bore_y(
            e.hole_diameter_mm,
            (sx * e.hole_spacing_length_mm / 2, sz * e.hole_spacing_width_mm / 2),
            (-e.board_thickness_mm - 1, 1),
        )
        for sx in (-1, 1)
        for sz in (-1, 1)
    ]
    shape = feature("encoder_board", "board", "hardware.encoder", lambda: cut(fuse(board, chip, plug), holes))
    hole = Hole(e.hole_diameter_mm, e.hole_count, f"{e.hole_diameter_mm:g} through, screws")
    extent = (-half_x, half_x), (-e.board_thickness_mm - 4.0, e.chip_height_mm), (-half_z, half_z)
    return bought_part("encoder_board", e, shape, "fr4", extent, e.mass_g, holes=(hole,))
