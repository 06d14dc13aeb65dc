"""Haptics of the delta device; `open` connects other programs to a device."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from haptics.devices.api import open_device as open  # the field's word for it: haptics.open

__all__ = ["open"]


def __getattr__(name: str) -> Any:
    """Loads `open`, which needs numba, where it is used."""
    if name != "open":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from haptics.devices.api import open_device

    return open_device
