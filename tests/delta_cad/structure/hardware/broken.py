"""Designs of every family with numbers spoiled until closed forms refuse them, and what ends each refusal."""

from __future__ import annotations

import json
from copy import deepcopy
from functools import cache

import numpy as np

from delta_cad.design import Design, DesignError, design_from_dict, design_to_json
from delta_cad.mechanism import MechanismError
from delta_cad.structure.hardware.refusals import refusals
from delta_cad.structure.hardware.thresholds import Refused, refused
from tests.committed import ROOT

FAMILIES = (
    "tests/references/symmetric-83.json",
    "docs/gallery/desk-150.json",
    "docs/gallery/direct-83.json",
    "docs/gallery/pocket-40.json",
    "docs/gallery/published-75.json",
    "examples/synthesized.json",
    "examples/dashboard-panel.json",
)
LENGTHS = tuple(f"{name}_mm" for name in ("base_radius", "platform_radius", "upper_arm_length", "forearm_length"))
SPOILED = {
    **{f"mechanism.{name}": (0.8, 1.25) for name in LENGTHS},
    "mechanism.parallelogram_width_mm": (0.7, 1.4),
    "cube.bottom_height_mm": (0.85, 1.2),
    "hardware.sector_radius_mm": (0.6, 1.7),
    "hardware.capstan_ratio": (0.5, 2.0),
    "hardware.platform_thickness_mm": (0.6, 2.0),
    "hardware.arm_thickness_mm": (0.7, 1.5),
    "requirements.force_N": (1.1, 2.5),
    "requirements.joint_torque_N_m": (0.7, 2.0),
    "requirements.envelope_depth_mm": (0.85, 1.0),
}
"""Field -> shares of its value between which it is drawn."""


def of_family(path: str) -> Design:
    """A design of the gallery, the examples or the committed one, as it is."""
    return design_from_dict(json.loads((ROOT / path).read_text()))


@cache
def broken(number: int) -> Design:
    """The design of a number: one to three fields are drawn anew until it is refused."""
    data = json.loads((ROOT / FAMILIES[number % len(FAMILIES)]).read_text())
    rng = np.random.default_rng(number)
    while True:
        spoiled = deepcopy(data)
        for field in rng.choice([*SPOILED], int(rng.integers(1, 4)), replace=False):
            section, _, name = str(field).partition(".")
            if name in spoiled[section]:
                spoiled[section][name] = round(spoiled[section][name] * float(rng.uniform(*SPOILED[field])), 3)
        try:
            design = design_from_dict(spoiled)
            if refusals(design):
                return design
        except (DesignError, MechanismError):
            continue


@cache
def _refused(text: str) -> dict[str, Refused]:
    return {f"{one.reason.part}, {one.reason.feature}": one for one in refused(design_from_dict(json.loads(text)))}


def ended(design: Design) -> dict[str, Refused]:
    """Every reason against a design with the changes that end it, by part and feature; found once a session."""
    return _refused(design_to_json(design))


def enough(one: Refused, *fields: str) -> float:
    """The value of the first of some fields at which a reason is gone, where they change together and nothing else."""
    (found,) = (t.enough[fields[0]] for t in one.thresholds if tuple(t.enough) == fields)
    assert isinstance(found, float)
    return found
