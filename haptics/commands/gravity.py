"""`gravity`: the torques that hold the handle at a position."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import Any

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, print_result, refuse
from delta_cad.common.options import JSON, Option, reader, settle_design
from delta_cad.common.units import MM_PER_M
from haptics.commands.device import DEVICE_OPTIONS

NAME = "gravity"
TEXT = "holding torques at a position, in N m"
_LARGEST = 1e6  # Largest coordinate in mm and largest mass in g: a kilometre, a ton


def _three(meaning: str, low: float) -> Callable[[str], tuple[float, ...]]:
    def read(text: str) -> tuple[float, ...]:
        numbers = tuple(float(part) for part in text.split(","))
        if len(numbers) != 3 or not all(math.isfinite(n) and low <= n <= _LARGEST for n in numbers):
            raise ValueError
        return numbers

    return reader(meaning, read)


def _settle(command: argparse.ArgumentParser, given: argparse.Namespace) -> None:
    if not given.published:
        settle_design(command, given)


OPTIONS = (
    DEVICE_OPTIONS[0].but(settle=_settle),
    *DEVICE_OPTIONS[1:],
    Option(
        "--at",
        type=_three("a position such as 0,0,95", -_LARGEST),
        metavar="X,Y,Z",
        help="position in the base frame, mm; default: centre of the cube",
    ),
    Option(
        "--point-masses",
        type=_three("masses such as 60,50,20", 0.0),
        metavar="G,G,G",
        help="masses m1, m2, m3 of the paper, g, instead of those of the solids",
    ),
    Option("--published", action="store_true", help="fit the masses to the torques of the paper; needs no design"),
    JSON,
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    if given.published:
        facts = _published()
        print_result(given, facts, lambda: _print_published(facts))
        return DONE
    from delta_cad.mechanism import MechanismError

    try:
        facts = _facts(given)
    except MechanismError as error:
        return refuse(f"--at {','.join(f'{x:g}' for x in given.at)}: {error}", BAD_INPUT)
    print_result(given, facts, lambda: _print(facts))
    return DONE if max(map(abs, facts["holding_torque_N_m"])) <= facts["continuous_torque_N_m"] else NOT_MET


def _facts(given: argparse.Namespace) -> dict[str, Any]:
    import numpy as np

    from delta_cad.design import load_design
    from delta_cad.drive import drive_torque
    from delta_cad.drive.masses import PointMasses
    from haptics.gravity import gravity_torque
    from haptics.model.machine import cube_centre_mm, load_machine, require_assembled

    if given.point_masses is not None:
        design = load_design(given.design, given.catalogue)
        require_assembled(design, given.design)
        masses, source = PointMasses(*(mass / 1000.0 for mass in given.point_masses)), "point masses as given"
    else:
        machine = load_machine(given.design, given.mass_properties, given.catalogue)
        design, masses, source = machine.design, machine.masses, "from the solids"
    if given.at is None:
        given.at = cube_centre_mm(design)
    gravity, position = design.requirements.gravity_m_s2, np.array(given.at) / MM_PER_M
    torque = gravity_torque(design.geometry, masses, position, gravity)
    return {
        "name": design.name,
        "position_mm": list(given.at),
        "gravity_m_s2": list(gravity),
        "masses": source,
        "holding_torque_N_m": torque.tolist(),
        "continuous_torque_N_m": drive_torque(design).continuous_torque_N_m,
    }


def _print(facts: dict[str, Any]) -> None:
    x, y, z = facts["position_mm"]
    print(f"{facts['name']} at {x:g}, {y:g}, {z:g} mm, masses: {facts['masses']}")
    for i, torque in enumerate(facts["holding_torque_N_m"]):
        print(f"  joint {i}: {torque:9.5f} N m")
    print(f"  of {facts['continuous_torque_N_m']:.3f} N m that the drive gives continuously")


def _published() -> dict[str, Any]:
    from haptics.gravity.identify import identify

    fit = identify()
    return {
        "at_wrists_g": fit.at_wrists_kg * 1e3,
        "at_elbow_g": fit.at_elbow_kg * 1e3,
        "origin_height_mm": fit.origin_height_m * MM_PER_M,
        "fitted_mN_m": (fit.torques_N_m * 1e3).tolist(),
        "published_mN_m": (fit.published_N_m * 1e3).tolist(),
        "rms_mN_m": fit.rms_N_m * 1e3,
        "spread_at_origin_mN_m": fit.spread_N_m * 1e3,
        "masses": 3,
        "identifiable": fit.rank,
    }


def _print_published(facts: dict[str, Any]) -> None:
    print("Published holding torques [RCIM2018], fitted with the two mass sums that torques at rest can tell:")
    print(f"  m1 + 3 m3 / 2 = {facts['at_wrists_g']:.1f} g on the wrists")
    print(f"  (m2 + m3) / 2 = {facts['at_elbow_g']:.1f} g on each elbow")
    print(f"  origin of the handle's travel {facts['origin_height_mm']:.1f} mm over the base plane")
    print(f"  rms misfit {facts['rms_mN_m']:.2f} mN m; the three torques at the origin, equal by symmetry, are spread")
    print(f"  by {facts['spread_at_origin_mN_m']:.2f} mN m. Of 3 masses {facts['identifiable']} sums show:")
    print("  moving mass from platform and upper arms into the forearms changes no torque at any position.")
    for name in ("published", "fitted"):
        print(f"  {name:9s}", *(f"{torque:7.2f}" for row in facts[f"{name}_mN_m"] for torque in row), "mN m")
