"""Springs: tension springs that hold a pair of rods together, wave springs that preload bearings."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Count, Quantity, Text


@dataclass(frozen=True, kw_only=True, config=ROW)
class TensionSpring(CatalogueRow):
    """A helical tension spring with loops, as DIN 2097 describes them.

    Attributes:
        wire_mm: Diameter of the wire.
        mean_diameter_mm: Mean diameter of the coils.
        active_coils: Coils that stretch.
        free_length_mm: Unloaded length between the insides of the loops, L0.
        initial_tension_N: Force at which the coils begin to part, F0.
        rate_N_mm: Force a millimetre beyond it, R.
        length_max_mm: Largest length between the loops, Ln.
        force_max_N: Force there, Fn.
        shear_modulus_Pa: Of the wire.
        loops: Form of the loops.
        mass_g: Mass of one; None when unknown.
    """

    wire_mm: Quantity
    mean_diameter_mm: Quantity
    active_coils: Quantity
    free_length_mm: Quantity
    initial_tension_N: Quantity
    rate_N_mm: Quantity
    length_max_mm: Quantity
    force_max_N: Quantity
    shear_modulus_Pa: Quantity
    loops: Text
    mass_g: Quantity | None = None

    def force_N(self, length_mm: float) -> float:
        """Computes the force at a length between the loops, within L0 to Ln."""
        return self.initial_tension_N + self.rate_N_mm * (length_mm - self.free_length_mm)

    def fault(self) -> str:
        """Says that the wire does not fit its coils or the spring cannot stretch."""
        if not self.wire_mm < self.mean_diameter_mm:
            return "must have wire_mm < mean_diameter_mm"
        if not self.free_length_mm < self.length_max_mm:
            return "must have free_length_mm < length_max_mm"
        return "" if self.initial_tension_N < self.force_max_N else "must have initial_tension_N < force_max_N"


_BORE_PLAY_MM = 0.3  # of diameter, by which a wave spring is smaller than its bore: it grows when it is pressed flat


@dataclass(frozen=True, kw_only=True, config=ROW)
class WaveSpring(CatalogueRow):
    """A wave spring or wave washer that presses on a bearing's ring.

    Attributes:
        housing_mm: Bore that it works in: the outside diameter of the bearing.
        inner_mm: Smallest inside diameter: the shaft passes freely.
        thickness_mm: Of the strip.
        waves: Number of waves in a turn; None when the source does not say.
        free_height_mm: Unloaded.
        work_height_mm: At which the force is stated.
        force_N: Force there.
        rate_N_mm: Force a millimetre around there; None when the source does not say.
    """

    housing_mm: Quantity
    inner_mm: Quantity
    thickness_mm: Quantity
    waves: Count | None = None
    free_height_mm: Quantity
    work_height_mm: Quantity
    force_N: Quantity
    rate_N_mm: Quantity | None = None

    @property
    def outer_mm(self) -> float:
        """Outside diameter, unloaded."""
        return self.housing_mm - _BORE_PLAY_MM

    def fault(self) -> str:
        """Says that it has no width or no stroke."""
        if not self.inner_mm < self.housing_mm:
            return "must have inner_mm < housing_mm"
        if not self.thickness_mm < self.work_height_mm < self.free_height_mm:
            return "must have thickness_mm < work_height_mm < free_height_mm"
        return ""


tension_spring = Family("tension_spring", "tensionsprings.csv", TensionSpring)
wave_spring = Family("wave_spring", "wavesprings.csv", WaveSpring)
