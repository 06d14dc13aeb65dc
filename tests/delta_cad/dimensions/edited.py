"""Dimensions of the published optimum with some of its numbers changed."""

from __future__ import annotations

from copy import deepcopy

from delta_cad.design import design_from_dict
from delta_cad.dimensions import Dimensions, dimensions
from tests.committed import PUBLISHED_DATA


def edited(**changes: float | str) -> Dimensions:
    """Dimensions of the published optimum with some of its numbers changed, by their last name."""
    data = deepcopy(PUBLISHED_DATA)
    for name, value in changes.items():
        (section,) = [s for s in ("mechanism", "cube", "hardware") if name in data[s]]
        data[section][name] = value
    return dimensions(design_from_dict(data))
