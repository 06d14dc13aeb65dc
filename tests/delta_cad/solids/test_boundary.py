"""Results are kept by a solid's first boundary: what the kernel writes to a solid afterwards changes no key."""

from __future__ import annotations

from typing import Any, cast

import cadquery as cq
from OCP.BRepMesh import BRepMesh_IncrementalMesh

from delta_cad.common.memoize import digest
from delta_cad.export.drawings.write import _handed_over
from delta_cad.solids.part import boundary, solid_digest


def test_a_solid_that_the_kernel_wrote_to_is_drawn_as_it_was_made() -> None:
    solid = cast(cq.Solid, cq.Workplane().cylinder(10.0, 4.0).val())
    made = solid_digest(solid)
    BRepMesh_IncrementalMesh(solid.wrapped, 0.1)  # leaves its triangles in the solid
    now = cast(Any, solid.__getstate__()[0]).getvalue()
    assert now != boundary(solid)
    assert digest(now) != made
    drawn = _handed_over(cast(Any, [solid]))[0]
    assert isinstance(drawn, cq.Solid)
    assert solid_digest(drawn) == made
    assert solid_digest(solid) == made
