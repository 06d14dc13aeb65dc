"""Motors."""

from __future__ import annotations

from math import pi
from typing import ClassVar

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.families.drive_board import drive_board
from delta_cad.catalogue.families.fasteners.screws import Screw, low_screw, screw
from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Count, MaybeText, NotNegative, Quantity, Text, Texts, outside

# What no motor is, whoever makes it: beyond, a number is in another unit than its column. Ours have 3.1 to 5.4 g/cm^3
# and lose 10 to 52 W/kg in their windings at the nominal torque.
_DENSITY_g_cm3 = 0.5, 9.0  # copper, of which no motor is whole
_LOSS_W_kg = 0.5, 2000.0  # from a motor that nothing warms to one in a gale
_MOUNT_COUNT = 2, 12
_RIPPLE = 0.0, 1.0


@dataclass(frozen=True, kw_only=True, config=ROW)
class Motor(CatalogueRow):
    """A motor with its mounting face at the front.

    Attributes:
        drives: Drive kinds it may be used with: "capstan", "direct"; "none" where nothing we make holds on it.
        commutation: "brushed" or "brushless".
        diameter_mm: Body diameter.
        length_mm: Body length behind the mounting face.
        shaft_length_mm: Shaft length in front of the mounting face.
        pilot_diameter_mm: Centring spigot diameter; it and the height are 0 for a motor without one.
        pilot_height_mm: Centring spigot height.
        mount_thread: Thread of the mounting holes ("M3"), a size of the screws family.
        mount_circle_mm: Pitch circle diameter of the mounting holes.
        mount_count: Number of mounting holes, equally spaced.
        nominal_voltage_V: Voltage of the stall and no-load figures.
        nominal_torque_N_m: Torque it can hold for ever at 25 C ambient (thermal limit).
        stall_torque_N_m: Torque at standstill on the nominal voltage; seconds only.
        peak_torque_N_m: Torque we allow for a short time; see `peak_reason`.
        peak_time_s: How long the peak may last.
        peak_reason: Why the peak is allowed.
        torque_constant_N_m_A: Torque per ampere (between phases for brushless motors).
        resistance_ohm: Terminal resistance (between phases for brushless motors) at 25 C.
        thermal_resistance_winding_housing_K_W: As all that follows, None when unknown.
        max_radial_load_N: Largest lasting load across the shaft, at `radial_load_distance_mm` from the mounting face.
        max_axial_load_N: Largest lasting load along the shaft.
        no_load_current_A: Current at `nominal_voltage_V` without a load: its torque is what idles away.
        cogging_torque_N_m: Largest torque with which the magnets hold the rotor, without a current; 0 for windings
            without iron.
        torque_ripple: Largest deviation of its torque from that of its current, as a share.
        commutator_segments: Of a brushed motor's commutator: its torque ripples once a segment and brush.
        encoder_counts_per_turn: Counts of the encoder on the motor's rear end, which length and mass include; None
            where it has none.
        drive_board: Id of the drive board that is bought with it; "": it is driven by what the user has.
    """

    partners: ClassVar = {"mount_thread": "screw"}
    derived: ClassVar = {
        "stall_torque_N_m": lambda cell: (
            cell("nominal_voltage_V") * cell("torque_constant_N_m_A") / cell("resistance_ohm")
        ),
        "peak_torque_N_m": lambda cell: cell("nominal_torque_N_m"),
    }

    drives: Texts = ("capstan",)
    commutation: Text = "brushed"
    diameter_mm: Quantity
    length_mm: Quantity
    shaft_diameter_mm: Quantity
    shaft_length_mm: Quantity
    pilot_diameter_mm: NotNegative
    pilot_height_mm: NotNegative
    mount_thread: Text
    mount_circle_mm: Quantity
    mount_count: Count
    mass_g: Quantity
    nominal_voltage_V: Quantity = 24.0
    nominal_torque_N_m: Quantity
    stall_torque_N_m: Quantity
    peak_torque_N_m: Quantity
    peak_time_s: Quantity = 1.0
    peak_reason: Text = "no peak is stated: the continuous torque"
    rotor_inertia_kg_m2: Quantity
    torque_constant_N_m_A: Quantity
    resistance_ohm: Quantity
    thermal_resistance_winding_housing_K_W: Quantity | None = None
    thermal_resistance_housing_ambient_K_W: Quantity | None = None
    thermal_time_constant_winding_s: Quantity | None = None
    max_winding_temperature_C: Quantity | None = None
    max_radial_load_N: Quantity | None = None
    radial_load_distance_mm: Quantity | None = None
    max_axial_load_N: Quantity | None = None
    no_load_current_A: Quantity | None = None
    cogging_torque_N_m: NotNegative | None = None
    torque_ripple: NotNegative | None = None
    commutator_segments: Count | None = None
    encoder_counts_per_turn: Count | None = None
    drive_board: MaybeText = ""

    @property
    def mount_screw(self) -> Screw:
        """The screw that holds it by its face: with a low head, for it stands near the arm, if its thread has one."""
        return low_screw.rows.get(f"low-{self.mount_thread}") or screw(self.mount_thread)

    def fault(self) -> str:
        """Says which size, mass or figure cannot be, or that a drive is not known."""
        if self.drives != ("none",) and not set(self.drives) <= {"capstan", "direct"}:
            return f"drives = {';'.join(self.drives)}: must be capstan, direct or both, or none"
        if (self.pilot_diameter_mm == 0.0) != (self.pilot_height_mm == 0.0):
            return "must have both or neither of pilot_diameter_mm and pilot_height_mm; both 0: the motor has no pilot"
        within = self.pilot_diameter_mm or (self.shaft_diameter_mm + self.mount_circle_mm) / 2.0
        if not self.shaft_diameter_mm < within < self.mount_circle_mm < self.diameter_mm:
            order = "shaft_diameter_mm < pilot_diameter_mm < mount_circle_mm < diameter_mm"
            return f"must have {order}; a motor without a pilot has 0 as its diameter and height"
        if self.drive_board and self.drive_board not in drive_board.rows:
            return f"drive_board = {self.drive_board}: must be empty or one of {', '.join(drive_board.rows)}"
        if self.peak_torque_N_m < self.nominal_torque_N_m:
            return f"peak_torque_N_m = {self.peak_torque_N_m:g}: must be >= nominal_torque_N_m"
        if (self.max_radial_load_N is None) != (self.radial_load_distance_mm is None):
            return "must have both or neither of max_radial_load_N and radial_load_distance_mm"
        return (
            outside("mount_count", self.mount_count, _MOUNT_COUNT, "holes")
            or outside("torque_ripple", self.torque_ripple or 0.0, _RIPPLE, "as a share")
            or self._mass_fault()
        )

    def _mass_fault(self) -> str:
        """Says that the mass is not that of a motor of this size, inertia and torque."""
        mass_kg, volume_cm3 = self.mass_g / 1e3, pi / 4.0 * self.diameter_mm**2 * self.length_mm / 1e3
        density = "mass_g over the volume of diameter_mm and length_mm"
        if fault := outside(density, self.mass_g / volume_cm3, _DENSITY_g_cm3, "g/cm^3"):
            return fault
        if self.rotor_inertia_kg_m2 >= (ring := mass_kg * (self.diameter_mm / 2e3) ** 2):
            inertia = f"rotor_inertia_kg_m2 = {self.rotor_inertia_kg_m2:g}"
            return f"{inertia}: must be < {ring:.3g}, that of all its mass at its rim"
        loss_W = (self.nominal_torque_N_m / self.torque_constant_N_m_A) ** 2 * self.resistance_ohm
        reported = "(nominal_torque_N_m / torque_constant_N_m_A)^2 resistance_ohm over mass_g"
        return outside(reported, loss_W / mass_kg, _LOSS_W_kg, "W/kg")


motor = Family("motor", "motors.csv", Motor)
