"""Choices shared by several parts, each with its reason, and the error that says a part cannot be dimensioned."""

from __future__ import annotations

from math import radians

RUNNING_GAP_MM = 1.0  # between an arm and the cheeks beside it: room for 0.1 mm parts and a shim
STOP_MARGIN_RAD = radians(3.0)  # the stop pin is met this far outside the cube's shoulder angles
PRESS_DEPTH_MM = 1.0  # a bearing seat ends in a lip of this thickness


class DimensionError(ValueError):
    """A part cannot be given sound dimensions; says which part, which feature and which bound.

    Attributes:
        part: Part number.
        feature: What of the part.
    """

    def __init__(self, part: str, feature: str, message: str) -> None:
        self.part, self.feature = part, feature
        super().__init__(f"{part}, {feature}: {message}")


def require(holds: bool, part: str, feature: str, message: str) -> None:
    """Raises a DimensionError unless `holds`."""
    if not holds:
        raise DimensionError(part, feature, message)
