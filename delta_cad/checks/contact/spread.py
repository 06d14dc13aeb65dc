"""How much farther from the base's centre chains must stand for keys to reach the screws that stand still."""

from __future__ import annotations

import re

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.contact.access import SWING_RAD, Scene, key_swing, up_and_down
from delta_cad.checks.contact.features import FeatureLibrary
from delta_cad.checks.limits import CheckLimits
from delta_cad.mechanism.placement import chain_frame

MOST_MM, TOLERANCE_MM = 16.0, 0.25  # of the base radius: how far is looked, and how closely
HEIGHT_STEP = 64  # of the handle's heights one in so many
CHAIN = re.compile(r"_(\d)(?:_|$)")  # in an occurrence's name


def missing_spread_mm(assembly: Assembly, limits: CheckLimits, meshes: Meshes) -> float:
    """Computes what the base radius lacks for keys to reach all screws that stand still.

    Each chain goes outwards as it is, the platform stays: a longer base radius, as far as keys see it.

    Args:
        assembly: The machine.
        limits: Its cube.
        meshes: Of its parts.

    Returns:
        Millimetres: 0 where nothing is in the way, `MOST_MM` where that much more or something else is needed.
    """
    scene, library = Scene(assembly, meshes, up_and_down(limits)[::HEIGHT_STEP]), FeatureLibrary()
    still = [one for one in assembly.reached if one.screw in scene.index and scene.stands[scene.index[one.screw]]]
    held = [one for one in still if key_swing(one, scene, library) < SWING_RAD]
    out = np.zeros((len(scene.occurrences), 3))
    for k, occurrence in enumerate(scene.occurrences):
        if (chain := CHAIN.search(occurrence.name)) is not None:
            out[k] = chain_frame(int(chain[1]))[:3, 0]
    home = scene.frames.copy()

    def free(more_mm: float) -> bool:
        scene.frames[..., :3, 3] = home[..., :3, 3] + more_mm * out
        return all(key_swing(one, scene, library) >= SWING_RAD for one in held)

    low, high = 0.0, MOST_MM
    if not held or not free(high):
        return low if not held else high
    while high - low > TOLERANCE_MM:
        middle = (low + high) / 2.0
        low, high = (low, middle) if free(middle) else (middle, high)
    return high
