"""Placing exact solids for the checks that use the CAD kernel."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from typing import Any

import numpy as np


def located(solid: Any, frame: np.ndarray) -> Any:
    """The OCC shape of a solid, moved without copying its geometry.

    Args:
        solid: A `cadquery.Shape`.
        frame: (4, 4) rigid transform, mm.

    Returns:
        The moved `TopoDS_Shape`.
    """
    from OCP.gp import gp_Trsf
    from OCP.TopLoc import TopLoc_Location

    transform = gp_Trsf()
    transform.SetValues(*frame[:3].ravel().tolist())
    return solid.wrapped.Moved(TopLoc_Location(transform))
