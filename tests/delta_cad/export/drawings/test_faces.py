"""Faces as the drawings read them."""

from __future__ import annotations

import cadquery as cq
import numpy as np

from delta_cad.export.drawings.part.faces import faces_of


def test_a_face_reaches_as_far_when_it_carries_a_mesh() -> None:
    """A coarse mesh of a cylinder lies within it: its end would be nowhere near where the part declares it."""
    solid = cq.Solid.makeCylinder(5.0, 8.0)
    before = [face.box for face in faces_of(solid)]
    solid.tessellate(1.0, 1.0)
    assert np.array_equal([face.box for face in faces_of(solid)], before)
    assert max(box[1, 0] for box in before) >= 5.0
