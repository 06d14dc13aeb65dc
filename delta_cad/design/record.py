"""The records of a design: the requirements, the chosen dimensions and hardware, with the bounds of every field."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field, JsonValue, PrivateAttr, ValidationError, create_model, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from delta_cad.catalogue import CHOSEN, OwnParts
from delta_cad.common.units import DOWN, MM_PER_M
from delta_cad.design.stands import home_x
from delta_cad.design.task import Gravity, Section, Task, limit_fields
from delta_cad.mechanism.geometry import (
    AZIMUTH_MAX_DEG,
    AZIMUTH_MIN_DEG,
    THREE_FOLD,
    DeltaGeometry,
    azimuth_cosine,
)
from delta_cad.mechanism.workspace import Cube

SCHEMA = "delta-design/1"
NAME_LONGEST = 64
NAME_PATTERN = rf"^[A-Za-z0-9](?:[A-Za-z0-9_-]{{0,{NAME_LONGEST - 2}}}[A-Za-z0-9])?$"
NAME_RULE = (
    f"must be 1 to {NAME_LONGEST} letters, digits, - and _, starting and ending with a letter or digit, so that it is "
    "safe as a file name"
)
IN_WORDS = "in_words"  # kind of a fault whose message is what the field must be
_CAPSTAN_RATIO_LEAST = 2.0
_CAPSTAN_RATIO_MOST = 30.0  # no pinion makes more on the largest sector
_SECTOR_LEAST_MM = 15.0
_SECTOR_MOST_MM = 120.0
_CHAINS = 3
_LARGEST_RADIUS_MM = 1000.0
_EVEN_DEG = 120.0
_MIRRORED_DEG = 1e-9  # within which azimuths of chains 1 and 2 mirror each other


def _in_words(must: str) -> PydanticCustomError:
    return PydanticCustomError(IN_WORDS, "{must}", {"must": must})


def _mirrored(azimuths: tuple[float, float, float]) -> tuple[float, float, float] | None:
    first, second, third = azimuths
    begins, mirrored = (abs(_within_half_turn(one)) <= _MIRRORED_DEG for one in (first, second + third))
    exchanged = mirrored and not _is_side(second)
    side = _within_half_turn(third) if exchanged else second
    if not _is_side(side) or not (begins or mirrored):
        raise ValueError
    write = f"write [0, {side:.12g}, {-side:.12g}]"
    if exchanged:
        raise _in_words(f"chains 1 and 2 are exchanged: {write}")
    if not mirrored:
        raise _in_words(f"the second and third must be mirror images: {write}")
    if not begins:
        raise _in_words(f"the first must be 0, chain 0 standing on the x axis: {write}")
    return None if second == _EVEN_DEG else (0.0, second, -second)


def _within_half_turn(angle_deg: float) -> float:
    return (angle_deg + 180.0) % 360.0 - 180.0


def _is_side(azimuth_deg: float) -> bool:
    return AZIMUTH_MIN_DEG <= azimuth_deg <= AZIMUTH_MAX_DEG


def _is_radius(value: object) -> bool:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return number and 0.0 < float(str(value)) <= _LARGEST_RADIUS_MM


def _alike(radii: tuple[float, float, float]) -> tuple[float, float, float] | None:
    if not 0.0 < min(radii) <= max(radii) <= _LARGEST_RADIUS_MM:
        raise ValueError
    if radii[1] != radii[2]:
        raise _in_words(f"the second and third must be equal: write [{radii[0]}, {radii[1]}, {radii[1]}]")
    return None if radii[0] == radii[1] else radii


_Triple = tuple[float, float, float]
Azimuths = Annotated[_Triple, Field(strict=False), AfterValidator(_mirrored)]
BaseRadii = Annotated[_Triple, Field(strict=False), AfterValidator(_alike)]
PRINT_MATERIAL = "petg-fdm"  # of printed parts where a design names none
FOLDER_LONGEST = 1000  # characters of the name of a folder of own parts


class Mechanism(Section):
    """The lengths of the mechanism, mm, and where its chains stand."""

    base_radius_mm: float = Field(
        gt=0,
        le=1000,
        description="R: base centre to shoulder axis; where base_radii_mm is given equal to its first, or left out",
    )
    platform_radius_mm: float = Field(gt=0, le=1000, description="r: platform centre to wrist")
    upper_arm_length_mm: float = Field(gt=0, le=1000, description="L_A: shoulder to elbow")
    forearm_length_mm: float = Field(gt=0, le=2000, description="L_B: elbow to wrist")
    parallelogram_width_mm: float = Field(gt=0, le=500, description="L_c: distance of the two rods of a forearm")
    azimuths_deg: Azimuths | None = Field(
        default=None,
        description="azimuths of the chains, [0, phi, -phi] with phi within "
        f"{AZIMUTH_MIN_DEG:g} and {AZIMUTH_MAX_DEG:g}; left out: [0, 120, -120]",
    )
    base_radii_mm: BaseRadii | None = Field(
        default=None,
        description="R of each chain, those of chains 1 and 2 equal; left out: three times base_radius_mm",
    )

    @model_validator(mode="before")
    @classmethod
    def _first_radius(cls, data: Any) -> Any:
        """Takes the base radius of chain 0 as `base_radius_mm` where that is left out, and refuses another."""
        if not isinstance(data, Mapping) or data.get("base_radii_mm") is None:
            return data
        radii, own = data["base_radii_mm"], data.get("base_radius_mm", _LARGEST_RADIUS_MM)
        if not isinstance(radii, (list, tuple)) or len(radii) != _CHAINS or not all(map(_is_radius, radii)):
            return {**data, "base_radius_mm": own}  # the rule of the radii says so
        if "base_radius_mm" not in data:
            return {**data, "base_radius_mm": radii[0]}
        if not _is_radius(own) or own == radii[0]:
            return data  # of no radius its own rule says so
        words = f"must equal base_radii_mm[0] = {radii[0]}, or be left out; base_radii_mm decides"
        fault = InitErrorDetails(type=_in_words(words), loc=("base_radius_mm",), input=own)
        raise ValidationError.from_exception_data(cls.__name__, [fault])


class DesignCube(Section):
    """The cube workspace: x in [x_c - L, x_c + L], y in [-L, L], z in [H, H + 2 L], mm."""

    bottom_height_mm: float = Field(gt=0, le=2000, description="H: bottom face over the plane of the shoulder axes")
    half_side_mm: float = Field(gt=0, le=1000, description="L: half the side")
    centre_x_mm: Annotated[float | None, AfterValidator(lambda x: x or None)] = Field(
        default=None, ge=-1000, le=1000, description="x_c: the cube's middle along the x axis; left out: 0"
    )


_Limited: Any = create_model("_Limited", __base__=Task, **limit_fields())


class DesignRequirements(_Limited):
    """The customer's requirements; an optional entry that is given is checked and certified."""

    clearance_min_mm: float = Field(default=1.0, ge=0, le=100, description="between bodies that are not neighbours")
    gravity_m_s2: Gravity = DOWN


class Hardware(Section):
    """The bought parts and the thicknesses of the made ones; every entry has a default but `catalogue`."""

    catalogue: str | None = Field(
        default=None,
        min_length=1,
        max_length=FOLDER_LONGEST,
        description="folder of own parts, relative to that of this file; their ids may be named beside ours",
    )
    motor: str = Field(default="maxon-re30-310007", description="id in the catalogue of motors")
    drive: Literal["capstan", "direct"] = Field(default="capstan", description="cable capstan or motor on the shaft")
    capstan_ratio: float = Field(
        default=9.85,
        ge=_CAPSTAN_RATIO_LEAST,
        le=_CAPSTAN_RATIO_MOST,
        description="turns of the motor per turn of the arm",
    )
    sector_radius_mm: float = Field(
        default=40.0, ge=_SECTOR_LEAST_MM, le=_SECTOR_MOST_MM, description="pitch radius of the capstan sector"
    )
    cable: str = Field(default="steel-0.54-7x7", description="id in the catalogue of cables")
    encoder_at: Literal["shoulder", "motor"] | None = Field(
        default=None, description="motor: the motor's own encoder; shoulder, as where it is left out: board and magnet"
    )
    encoder: str = Field(default="mt6835-board", description="id in the catalogue of encoders")
    bearing: str = Field(default="688", description="id in the catalogue of bearings")
    tube: str = Field(default="cfrp-5x3", description="id in the catalogue of tubes: the rods")
    knob: str = Field(default="din319-25", description="id in the catalogue of knobs: the handle")
    foot: str = Field(default="foot-m4-stud-15x8", description="id in the catalogue of feet")
    magnet: str = Field(default="ndfeb-6x2.5-diametric", description="id in the catalogue of magnets")
    base_plate_thickness_mm: float = Field(default=8.0, ge=4, le=30, description="base plate")
    arm_thickness_mm: float = Field(
        default=8.0, ge=5, le=20, description="upper arm plate, at least: loads may ask more"
    )
    platform_thickness_mm: float = Field(default=10.0, ge=5, le=30, description="moving platform")
    ball_diameter_mm: float = Field(default=8.0, ge=4, le=15, description="balls of the ball joints")
    mounting: Literal["feet", "plate", "screws", "both"] | None = Field(
        default=None,
        description="what holds the base; left out: screws; both: screwed down with its feet on; plate: it stands free "
        "on a steel plate as large and heavy as it takes; feet: on three feet under the base plate",
    )
    leads: Literal["bent", "none"] | None = Field(
        default=None, description="bent: the leads of motors and encoders are drawn as they bend, inside the outline"
    )
    process: Literal["machined", "printed"] | None = Field(
        default=None, description="of the parts that can be printed; left out: machined"
    )
    processes: dict[str, Literal["machined", "printed"]] | None = Field(
        default=None, description="part number -> its process, where it is another than that of the rest"
    )
    print_material: str | None = Field(
        default=None, description="id in the catalogue of materials of what is printed; left out: petg-fdm"
    )
    _own_parts: OwnParts | None = PrivateAttr(default=None)

    def model_post_init(self, context: Any, /) -> None:
        """Keeps the user's own parts, which who validates the record has read for it."""
        self._own_parts = context

    @property
    def print_material_id(self) -> str:
        """Id of the material of what is printed."""
        return self.print_material or PRINT_MATERIAL

    @property
    def own_parts(self) -> OwnParts | None:
        """The user's own parts, whose ids may be named beside ours; they were read with the design."""
        return self._own_parts


class Panel(Section):
    """The dashboard's panel over the machine, which the handle's stem passes: opening, bezel and boot follow."""

    thickness_mm: float = Field(default=2.0, ge=1, le=10, description="of the panel's sheet")
    limit_mm: float = Field(
        default=3.0, ge=1, le=10, description="how far outside the cube, aside, the stem meets the bezel"
    )


class Loop(Section):
    """The sampled loop of the controller; what is left out is as in the board loop of `haptics/loop/choice.py`."""

    rate_Hz: float | None = Field(default=None, ge=100, le=1e5, description="ticks of the controller a second")
    delay_ticks: float | None = Field(
        default=None,
        ge=0,
        le=4,
        description="nominal delay from reading to torque; it ranges from half to 1.5 times that",
    )
    damping_N_s_m: float | None = Field(
        default=None, ge=0, le=100, description="damping of every virtual wall, computed by the controller"
    )
    drive_damping: float | None = Field(
        default=None,
        ge=0,
        le=1,
        description="share of the motors' short-circuit damping that the amplifiers add while a wall is touched, "
        "without delay; 0: none, as amplifiers on sale",
    )


FIRST_REVISION = "A"
REVISION_RULE = "must be 1 to 8 letters, digits, dots, underscores or hyphens, the first a letter or digit"


class Design(Section):
    """One design: everything the CAD, the checks, the optimiser and the controller start from."""

    schema_id: Literal["delta-design/1"] = Field(alias="schema", description="version of this format")
    name: str = Field(pattern=NAME_PATTERN, description="name of the design and of its output directory")
    mechanism: Mechanism
    cube: DesignCube
    requirements: DesignRequirements
    hardware: Hardware = Field(default_factory=Hardware)
    panel: Panel | None = Field(default=None, description="left out: there is none over the machine")
    loop: Loop | None = Field(default=None, description="left out: the board loop; no part of what is built")
    revision: str | None = Field(
        default=None,
        pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,7}$",
        description=f"of drawings and STEP files; left out: {FIRST_REVISION}",
    )
    provenance: dict[str, JsonValue] = Field(default_factory=dict, description="where the dimensions come from")

    @property
    def drawn_revision(self) -> str:
        """Revision that drawings and STEP files state."""
        return self.revision or FIRST_REVISION

    @property
    def geometry(self) -> DeltaGeometry:
        """The mechanism's lengths in metres."""
        m = self.mechanism
        return DeltaGeometry(
            base_radius=m.base_radius_mm / MM_PER_M,
            platform_radius=m.platform_radius_mm / MM_PER_M,
            upper_arm_length=m.upper_arm_length_mm / MM_PER_M,
            forearm_length=m.forearm_length_mm / MM_PER_M,
            side_shift=0.0 if m.base_radii_mm is None else (m.base_radii_mm[1] - m.base_radii_mm[0]) / MM_PER_M,
            side_cosine=THREE_FOLD if m.azimuths_deg is None else azimuth_cosine(m.azimuths_deg[1]),
        )

    @property
    def azimuths_deg(self) -> tuple[float, float, float]:
        """Azimuths of the chains, anticlockwise from chain 0, within 0 and 360 deg."""
        side = 120.0 if self.mechanism.azimuths_deg is None else self.mechanism.azimuths_deg[1]
        return 0.0, side, 360.0 - side

    @property
    def home_mm(self) -> np.ndarray:
        """(3,) handle position in which the machine is drawn and its files are written, see `home_x`."""
        x = home_x(self.geometry, self.workspace) * MM_PER_M
        return np.array([x, 0.0, self.cube.bottom_height_mm + self.cube.half_side_mm])

    @property
    def workspace(self) -> Cube:
        """The cube in metres."""
        cube = self.cube
        centre_x = 0.0 if cube.centre_x_mm is None else cube.centre_x_mm / MM_PER_M
        return Cube(cube.bottom_height_mm / MM_PER_M, cube.half_side_mm / MM_PER_M, centre_x)


# Entries of `hardware` that name a bought part: each is called as its family in the catalogue.
HARDWARE_FAMILIES = tuple(name for name in Hardware.model_fields if name in CHOSEN)
