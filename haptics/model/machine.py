"""One device: its design file, and masses and structure from its build."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design, DesignError, load_design
from delta_cad.drive import DriveReport, drive_torque
from delta_cad.drive.masses import MassError, Masses, load_masses
from delta_cad.mechanism import DeltaGeometry, closure_margin, direct_margin
from delta_cad.mechanism.workspace import CubeSearch
from haptics.model.built import BuiltStructure, built_structure

FILE = "mass_properties.json"
GRID = 15  # points along an edge from which the search over the cube starts: reach and det S are smooth


@dataclass(frozen=True)
class MachineModel:
    """A design with its masses.

    Attributes:
        design: The design.
        masses: Masses of the moving bodies, rotor and pinion included.
        drive: What the drive gives at the joint.
        structure: Of the build that wrote the masses; None where that is not at hand.
    """

    design: Design
    masses: Masses
    drive: DriveReport
    structure: BuiltStructure | None = field(default=None, compare=False)

    @property
    def geometry(self) -> DeltaGeometry:
        """The mechanism's lengths in metres."""
        return self.design.geometry

    @property
    def half_side(self) -> float:
        """L, half the side of the cube workspace, m."""
        return self.design.cube.half_side_mm / MM_PER_M

    @property
    def centre(self) -> np.ndarray:
        """(3,) centre of the cube workspace in the base frame, m."""
        return np.array(cube_centre_mm(self.design)) / MM_PER_M


def cube_centre_mm(design: Design) -> tuple[float, float, float]:
    """Gives the centre of a design's cube in the base frame, mm; its height is the sum of two lengths in mm."""
    cube = design.cube
    return (cube.centre_x_mm or 0.0, 0.0, cube.bottom_height_mm + cube.half_side_mm)


def _masses_file(design: Design) -> Path:
    """Gives where the build of a design writes its masses by default."""
    return Path("out") / design.name / FILE


def load_machine(design_file: Path, masses: Path | None = None, own_parts: Path | None = None) -> MachineModel:
    """Reads a device.

    Args:
        design_file: Design file, `delta-design/1`.
        masses: `mass_properties.json` of its build; None for `out/<name>/mass_properties.json`. `structure.json` is
            read from the same folder where it is of this design.
        own_parts: Folder of the user's own parts, in place of the one that the design names.

    Raises:
        DesignError: The design file is refused, or the cube holds a position out of reach or of another assembly mode.
        MassError: The masses are refused, missing, or of a build of another design.
    """
    design = load_design(design_file, own_parts)
    require_assembled(design, design_file)
    path = masses if masses is not None else _masses_file(design)
    if masses is None and not path.exists():
        raise MassError(
            str(path),
            "",
            "",
            f"is missing; run `python -m delta_cad build --design {design_file}` or give --mass-properties",
        )
    return MachineModel(design, load_masses(path, design), drive_torque(design), built_structure(path.parent, design))


def require_assembled(design: Design, file: Path) -> None:
    """Refuses a cube in which the forward kinematics would return another position than the handle's.

    Args:
        design: The design.
        file: Its file, which the message names.

    Raises:
        DesignError: The cube holds a position out of reach or of another assembly mode.
    """
    search = CubeSearch(design.workspace, GRID)
    reach = search(lambda p: closure_margin(design.geometry, p).min(axis=-1), +1.0)
    mode = search(lambda p: direct_margin(design.geometry, p), +1.0)
    if reach.value >= 0.0 and mode.value > 0.0:
        return
    x, y, z = (round(v * MM_PER_M, 1) + 0.0 for v in (reach if reach.value < 0.0 else mode).position)  # no -0.0
    must = "be within reach" if reach.value < 0.0 else "have the assembly mode det S > 0, platform above elbows,"
    where = f"must {must} at every position, also at ({x:.1f}, {y:.1f}, {z:.1f}) mm"
    raise DesignError(file.name, "cube.bottom_height_mm", str(design.cube.bottom_height_mm), where)
