"""Published figures of devices on the market, each with the source that was read and the test method."""

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


@dataclass(frozen=True)
class PublishedDevice:
    """One figure of a device.

    Attributes:
        device: Maker and name.
        quantity: One of `LABELS`.
        value: The figure; None where it is text.
        bound: "<", ">", "~" or nothing before it.
        text: The text; empty where it is a figure.
        test: How it was tested, or "unknown".
        source: Where it is published; somebody of this project opened it.
    """

    device: str
    quantity: str
    value: float | None
    bound: str
    text: str
    test: str
    source: str

    @property
    def shown(self) -> str:
        """Text of the value in a table."""
        return self.text if self.value is None else f"{self.bound} {self.value:g}".strip()


def reference_devices() -> tuple[PublishedDevice, ...]:
    """Published figures of the data file, in its order."""
    with FILE.open(encoding="utf-8", newline="") as file:
        return tuple(
            PublishedDevice(
                device=row["device"],
                quantity=row["quantity"],
                value=float(row["value"]) if row["value"] else None,
                bound=row["bound"],
                text=row["text"],
                test=row["test"],
                source=row["source"],
            )
            for row in csv.DictReader(file, strict=True)
        )
