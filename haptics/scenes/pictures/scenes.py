"""The pictures of a scene."""

from __future__ import annotations

from pathlib import Path

from haptics.model.machine import MachineModel
from haptics.scenes.pictures.home import home_picture
from haptics.scenes.pictures.resistance import resistance_picture
from haptics.scenes.pictures.style import save
from haptics.scenes.pictures.wall import wall_picture
from haptics.scenes.record import Scene

DRAW = {"resistance": resistance_picture, "home": home_picture, "wall": wall_picture}


def pictures(scene: Scene, machine: MachineModel, folder: Path) -> list[str]:
    """Draws a scene.

    Args:
        scene: What was simulated.
        machine: On which device.
        folder: Where the files go.

    Returns:
        The files' names.
    """
    name = f"{scene.name}.png"
    save(DRAW[scene.name](scene, machine.design.name), folder / name)
    return [name]
