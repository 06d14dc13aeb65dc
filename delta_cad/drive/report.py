"""Torque of the drive at the joint, for ever and for a moment, and the load of its cable."""

from __future__ import annotations

from dataclasses import dataclass
from math import log2, pi
from typing import Literal

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design

_Verdict = Literal["continuous", "peak only", "insufficient"]

# Joint torque over ratio times motor torque. The cable rolls without slip; what is lost is the bending of the rope
# onto two drums and the friction of the bearings. Sources say "near-frictionless" (IEEE Robotics and Automation
# Magazine, March 2017, p. 71) and 90 to 95 % and more for cord drives; steel rope on smooth drums is at the upper end.
# An estimate, not a measurement: measure it on the first device.
CAPSTAN_EFFICIENCY = 0.96
DIRECT_EFFICIENCY = 1.0  # the motor's own friction is already taken off its nominal torque
# Least tension of a capstan's slack strand. Of a cable fixed at both ends one side loses half of the drive force; at 0
# it would go slack and bring backlash, and a new rope settles.
SLACK_N = 4.0
# Bending of the rope on the pinion, by Sava's tests: below 16 rope diameters a rope's life is "relatively low", and
# twice the diameter makes it up to 13 times as long (savacable.com/pages/applic_10.html, read 2026-11-22); for 7x7,
# whose advised ratio is 40, 16 is the share below. Crosby's table for hoists (30: 10, 20: 3.8, 16: 2.1) grows by less
# than 13 for twice the diameter: the exponent does not flatter a ratio below the advised one.
_BEND_LEAST_SHARE = 16.0 / 40.0
_BEND_LIFE_EXPONENT = log2(13.0)


@dataclass(frozen=True)
class DriveReport:
    """Torque, inertia and cable load of one joint's drive.

    Attributes:
        motor: Id in the catalogue.
        drive: "capstan" or "direct".
        ratio: Turns of the motor per turn of the arm.
        efficiency: Joint torque over ratio times motor torque.
        continuous_torque_N_m: At the joint, for ever, at 25 C ambient (thermal limit of the motor).
        peak_torque_N_m: At the joint for `peak_time_s`.
        peak_time_s: How long the peak may last.
        required_torque_N_m: The design's requirement, for ever.
        required_peak_N_m: What it asks for a moment; the same where it does not say.
        controlled_torque_N_m: What the controller lets the drive give: the required peak, or the drive's where that is
            less. The cable is tensioned for it.
        verdict: "continuous" when both are given; "peak only" when what is asked for ever is given for a moment alone;
            else "insufficient".
        reflected_inertia_kg_m2: The rotor's inertia seen at the joint (without the pinion).
        cable: Id in the catalogue; None, as all that follows, for a direct drive.
        cable_pretension_N: Pretension at which the unloaded side keeps `SLACK_N` at the controlled torque, either side
            taking half of it: an estimate before there are dimensions, `cable_setting` has what hands set.
        cable_tension_N: Largest tension of the loaded side there.
        cable_safety_factor: Breaking load over that tension.
        bend_ratio: Groove diameter of the pinion over cable diameter.
        bend_ratio_recommended: What the rope's makers advise for long life.
    """

    motor: str
    drive: str
    ratio: float
    efficiency: float
    continuous_torque_N_m: float
    peak_torque_N_m: float
    peak_time_s: float
    required_torque_N_m: float
    required_peak_N_m: float
    controlled_torque_N_m: float
    verdict: _Verdict
    reflected_inertia_kg_m2: float
    cable: str | None
    cable_pretension_N: float | None
    cable_tension_N: float | None
    cable_safety_factor: float | None
    bend_ratio: float | None
    bend_ratio_recommended: float | None

    @property
    def bend_ratio_least(self) -> float | None:
        """Bend ratio below which the cable's life is short, whatever its load; None for a direct drive."""
        return None if self.bend_ratio_recommended is None else _BEND_LEAST_SHARE * self.bend_ratio_recommended

    @property
    def bend_life_share(self) -> float | None:
        """Estimate of the cable's bending life over its life at the advised ratio; None for a direct drive."""
        if self.bend_ratio is None or self.bend_ratio_recommended is None:
            return None
        return (max(self.bend_ratio, 0.0) / self.bend_ratio_recommended) ** _BEND_LIFE_EXPONENT


def drive_torque(design: Design) -> DriveReport:
    """Computes what the design's motor and drive give at each joint; the verdict compares with the torque required."""
    hardware, required = design.hardware, design.requirements.joint_torque_N_m
    required_peak = design.requirements.peak_torque_N_m or required
    motor = catalogue.motor.chosen(hardware)
    capstan = hardware.drive == "capstan"
    ratio = hardware.capstan_ratio if capstan else 1.0
    efficiency = CAPSTAN_EFFICIENCY if capstan else DIRECT_EFFICIENCY
    continuous = ratio * efficiency * motor.nominal_torque_N_m
    peak = ratio * efficiency * motor.peak_torque_N_m
    controlled = min(peak, required_peak)
    verdict: _Verdict = "insufficient"
    if peak >= required_peak:
        verdict = "continuous" if continuous >= required else "peak only"
    pretension = tension = safety = bend = advised = None
    if capstan:
        cable = catalogue.cable.chosen(hardware)
        force = controlled / efficiency / (hardware.sector_radius_mm / MM_PER_M)
        pretension = SLACK_N + force / 2.0
        tension = pretension + force / 2.0
        safety = cable.breaking_load_N / tension
        groove_mm = 2.0 * hardware.sector_radius_mm / ratio - cable.diameter_mm
        bend, advised = groove_mm / cable.diameter_mm, cable.min_bend_ratio
    return DriveReport(
        motor=motor.id,
        drive=hardware.drive,
        ratio=ratio,
        efficiency=efficiency,
        continuous_torque_N_m=continuous,
        peak_torque_N_m=peak,
        peak_time_s=motor.peak_time_s,
        required_torque_N_m=required,
        required_peak_N_m=required_peak,
        controlled_torque_N_m=controlled,
        verdict=verdict,
        reflected_inertia_kg_m2=ratio**2 * motor.rotor_inertia_kg_m2,
        cable=hardware.cable if capstan else None,
        cable_pretension_N=pretension,
        cable_tension_N=tension,
        cable_safety_factor=safety,
        bend_ratio=bend,
        bend_ratio_recommended=advised,
    )


def joint_counts_per_turn(design: Design) -> float:
    """Computes the counts of a joint's encoder in a turn of the arm; at the motor, its own times the ratio."""
    hardware = design.hardware
    if hardware.encoder_at != "motor":
        return float(catalogue.encoder.chosen(hardware).counts_per_turn)
    counts = catalogue.motor.chosen(hardware).encoder_counts_per_turn
    assert counts is not None, "the design file refuses such a motor"
    return counts * drive_torque(design).ratio


def encoder_count_rad(design: Design) -> float:
    """Computes the turn of the arm for one count of its joint's encoder, rad."""
    return 2.0 * pi / joint_counts_per_turn(design)
