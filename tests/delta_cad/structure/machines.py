"""The committed design's table, as it is and with the figures of joints that the study used."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import cos, radians

import numpy as np

from delta_cad.design import Design, load_design
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.structure.beam_model import BeamModel, beam_model
from delta_cad.structure.compliance import compliance, softest
from delta_cad.structure.modes import Moving, MovingBody
from tests.committed import ROOT

STUDY_JOINT_N_mm = 500.0  # joints as the study took them; in our design a declared figure


@cache
def design() -> Design:
    return load_design(ROOT / "examples" / "synthesized.json")


@cache
def committed() -> Dimensions:
    return dimensions(design())


def table(knob_mm: float | None = None, joint_N_mm: float = STUDY_JOINT_N_mm, placed: bool = False) -> BeamModel:
    made = beam_model(committed())
    g = made.geometry
    if placed:  # the same chains elsewhere: azimuths of 116.3 degrees, shoulders of chains 1 and 2 by 5 mm farther out
        g = replace(g, side_shift=0.005, side_cosine=cos(radians(116.3)))
    changed = replace(made, joint_N_mm=joint_N_mm, geometry=g)
    if knob_mm is None:
        return changed
    # the stem is as long as the knob stands over the platform's top
    (stem,) = made.stem.slices
    longer = replace(stem, length_mm=stem.length_mm + knob_mm - made.knob_mm)
    return replace(changed, knob_mm=knob_mm, stem=replace(made.stem, slices=(longer,)))


def places(aside_mm: float = 0.0) -> np.ndarray:
    """(12, 3) centre, corners and three places inside the committed cube, mm, all of it aside along x."""
    cube = design().cube
    side, low = cube.half_side_mm, cube.bottom_height_mm
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    inside = np.array([[0.0, 0.0, 0.0], [0.9, 0.2, -1.0], [-0.3, -0.7, 0.4], [0.1, 0.6, -0.8]])
    return np.concatenate([inside, signs]) * side + [aside_mm, 0.0, low + side]


def what_moves() -> Moving:
    """Masses of the committed machine, rounded: what a build weighs is tested elsewhere."""
    platform = MovingBody(0.0654, np.array([0.0, 0.0, 8.4]), np.diag([34.2, 34.2, 29.4]))
    arm = MovingBody(
        0.0964, np.array([22.7, 3.0, -4.4]), np.array([[19.9, -0.1, 2.5], [-0.1, 186.7, 3.8], [2.5, 3.8, 183.0]])
    )
    return Moving(platform, arm, (0.00136, 0.00058, 0.00136))


def knob_stiffness(machine: BeamModel, p_mm: np.ndarray) -> np.ndarray:
    """Least stiffness at the knob over all directions of a force, (...) N/mm; 0 where nothing holds."""
    return softest(compliance(machine, p_mm).at_knob()).stiffness_N_mm
