"""Published figures of devices on the market, with their sources and whether those were opened."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

FILE = Path(__file__).with_name("reference_devices.csv")
LABELS = {
    "workspace_mm": "workspace, mm",
    "force_continuous_N": "force, continuous, N",
    "force_peak_N": "force, peak, N",
    "stiffness_N_per_mm": "stiffest wall, N/mm",
    "apparent_mass_g": "apparent mass, g",
    "friction_N": "friction, N",
    "resolution_mm": "position resolution, mm",
}
BOUNDS = ("", "<", ">", "~")


class ReferenceDeviceError(ValueError):
    """A data file that is refused; the message names its line, field and value."""


@dataclass(frozen=True)
class PublishedDevice:
    """One figure of a device.

    Attributes:
        device: Maker and name.
        quantity: One of `LABELS`.
        value: The figure; None where it is text.
        bound: "<", ">", "~" or nothing before it.
        text: The text; empty where it is a figure.
        confirmed: Whether the source was opened; if not, the figure is from memory.
        source: Where it is published.
    """

    device: str
    quantity: str
    value: float | None
    bound: str
    text: str
    confirmed: bool
    source: str

    @property
    def shown(self) -> str:
        """Text of the value in a table; a question mark marks what was not confirmed."""
        said = self.text if self.value is None else f"{self.bound} {self.value:g}".strip()
        return said if self.confirmed else f"{said} (?)"


def reference_devices(path: Path = FILE) -> tuple[PublishedDevice, ...]:
    """The published figures.

    Args:
        path: Data file.

    Returns:
        In the file's order.

    Raises:
        ReferenceDeviceError: A line that cannot be.
    """
    devices = []
    with path.open(encoding="utf-8", newline="") as file:
        for number, row in enumerate(csv.DictReader(file, strict=True), 2):
            at = f"{path.name}, line {number}"
            if row["quantity"] not in LABELS:
                raise ReferenceDeviceError(
                    f"{at}: quantity is {row['quantity']!r}; it must be one of {', '.join(LABELS)}"
                )
            if row["bound"] not in BOUNDS or row["confirmed"] not in ("yes", "no"):
                raise ReferenceDeviceError(f"{at}: bound is {row['bound']!r}, confirmed {row['confirmed']!r}")
            if not row["device"] or not row["source"] or bool(row["value"]) == bool(row["text"]):
                raise ReferenceDeviceError(f"{at}: needs a device, a source, and either a value or a text")
            try:
                value = float(row["value"]) if row["value"] else None
            except ValueError:
                raise ReferenceDeviceError(f"{at}: value is {row['value']!r}; it must be a number") from None
            confirmed = row["confirmed"] == "yes"
            devices.append(
                PublishedDevice(
                    row["device"], row["quantity"], value, row["bound"], row["text"], confirmed, row["source"]
                )
            )
    return tuple(devices)
