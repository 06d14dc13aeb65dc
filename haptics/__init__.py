"""Haptics of the delta device; `open` gives a device to programs of others."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from haptics.devices.api import HapticDevice


def open(  # the field's word for it: haptics.open
    design: str | Path,
    device: str = "simulated",
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    recording: str | Path | None = None,
    calibration: str | Path | None = None,
    masses: str | Path | None = None,
    rate_Hz: float = 1000.0,
    allow_remote: bool = False,
) -> HapticDevice:
    """Opens a haptic device.

        with haptics.open("best.json", "socket", port=5005) as device:
            while True:
                device.set_force(-300.0 * (device.position() - centre))

    Args:
        design: Design file.
        device: "simulated", "socket" for a board, "recorded".
        host: Numeric address of a board.
        port: Its port.
        recording: File of a recorded device.
        calibration: `calibration.json` of this one device.
        masses: `mass_properties.json`; None for `out/<name>/mass_properties.json`.
        rate_Hz: Ticks a second of a simulated device; a board has its own, a recording the one given.
        allow_remote: Whether the board may be at the end of a cable, not on this machine: the protocol has no password,
            so use a cable of its own.

    Returns:
        The device, a context manager, its force on.

    Raises:
        DesignError, MassError, CalibrationError, RecordingError: A file is refused.
        ValueError: An argument is.
        DeviceError: No board answers, or it refuses.
    """
    from haptics.devices.api import open_device

    return open_device(
        design,
        device,
        host=host,
        port=port,
        recording=recording,
        calibration=calibration,
        masses=masses,
        rate_Hz=rate_Hz,
        allow_remote=allow_remote,
    )
