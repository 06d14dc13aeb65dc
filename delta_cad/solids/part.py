"""The records that solids, assembly, checks and export share: material, bore, part, occurrence, joint, fit, contact.

Loads no geometry kernel on import: `Part.solid` is a `cadquery.Solid` that only `solids` makes.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from delta_cad.common.memoize import digest, memoize

if TYPE_CHECKING:
    import cadquery as cq


Span = tuple[float, float]
Extent = tuple[Span | None, Span | None, Span | None]
"""What a part reaches along its x, y and z, lowest and highest, mm; None along an axis where nothing is declared."""


@dataclass(frozen=True)
class Material:
    """Material of a part: name as ordered, density in kg/m^3, display colour as sRGB in 0..1.

    `process` is how parts of it are printed, "fdm" or "sls"; "" where they are cut.
    """

    name: str
    density_kg_m3: float
    colour: tuple[float, float, float]
    process: str = ""


Triple = tuple[float, float, float]


FOR_WHAT_IT_STANDS_ON = "mounting from below"
"""In the callout of threads whose screws come from what the machine stands on: no part of the machine fills them."""


@dataclass(frozen=True)
class Bore:
    """One bore of a part: where it is and how it is made, as a machinist sets it up.

    Attributes:
        start_mm: Where its axis enters what is bored, part's frame.
        direction: Unit vector along the axis, into the material.
        diameter_mm: Of the bore: a thread's tap drill, a fit's nominal diameter.
        depth_mm: Of the full diameter, without the tip; of a through bore as far as it goes.
        through: Whether it comes out.
        tip_deg: Point angle of the drill at a blind end; 0: flat, milled or bored.
        thread: Such as "M4", or "".
        thread_mm: Usable depth of the thread from the start.
        fit: ISO 286 tolerance class, such as "H7", or "".
        deviations_um: Lower and upper deviation of the diameter; None: the general tolerance.
        surface_um: Roughness Ra of its wall; None: the general one.
        is_counterbore: Whether a head is sunk in it.
        zone_mm: Diameter of the zone for its axis; 0: a datum, from which others have their places; None: the general
            tolerance.
        square_mm: Diameter of the zone in which its axis is square to the part's seat; 0: the general tolerance.
        reamed_with: Number of the part together with which it is reamed at assembly, or "".
        predrilled_mm: Diameter to which it is drilled before that; 0: it is drilled through the other part.
        callout: What the drawing says of it and its likes.
    """

    start_mm: Triple
    direction: Triple
    diameter_mm: float
    depth_mm: float
    through: bool = False
    tip_deg: float = 0.0
    thread: str = ""
    thread_mm: float = 0.0
    fit: str = ""
    deviations_um: tuple[float, float] | None = None
    surface_um: float | None = None
    is_counterbore: bool = False
    zone_mm: float | None = None
    square_mm: float = 0.0
    reamed_with: str = ""
    predrilled_mm: float = 0.0
    callout: str = ""


@dataclass(frozen=True)
class Slot:
    """A milled slot in which a pin is held across it and has play along it.

    Attributes:
        start_mm: Its middle where it enters what is milled, part's frame.
        direction: Unit vector into the material.
        along: Unit vector along it.
        width_mm: Nominal width, that of the pin.
        long_mm: From end to end.
        depth_mm: From the start to its floor.
        fit: ISO 286 tolerance class of its width.
        deviations_um: Lower and upper deviation of its width.
        zone_mm: Width of the zone for its middle plane.
    """

    start_mm: Triple
    direction: Triple
    along: Triple
    width_mm: float
    long_mm: float
    depth_mm: float
    fit: str
    deviations_um: tuple[float, float]
    zone_mm: float


@dataclass(frozen=True)
class Hole:
    """A group of equal bores of one part, as a machinist reads them.

    Attributes:
        diameter_mm: Modelled bore diameter (tap drill for a thread).
        count: Number of distinct bore axes with a concave cylinder of this diameter.
        callout: What the drawing says, such as "M3 x 8" or "16 H7 x 5".
        is_slot: Whether it is a slot of that width, between two planes, and not a bore.
        bores: Each bore of the group; two that are made from either side may share an axis.
        slots: Each slot of a group of slots for pins.
    """

    diameter_mm: float
    count: int
    callout: str
    is_slot: bool = False
    bores: tuple[Bore, ...] = ()
    slots: tuple[Slot, ...] = ()


@dataclass(frozen=True)
class Part:
    """One kind of part in its own frame, millimetres.

    Attributes:
        number: Part number, unique, safe as a file name ("upper_arm", "screw_M3x8").
        description: One line for the bill of materials.
        solid: Exactly one valid solid at the part's own origin.
        material: Material, also of bought parts (for colour; mass may come from the catalogue).
        make: True when we machine or print it, False when it is bought.
        to_drawing: Whether what is bought is in no stock: a maker of springs, boards or turned parts makes it by our
            drawing, for a price by the piece; the rules of our shop do not hold for it.
        notes: What its drawing says beside its shape.
        holes: Declared bores, checked against the solid.
        mass_g: Catalogue mass of a bought part; None: volume times density.
        standard: Standard of a bought part ("ISO 4762") or "".
        order_code: Supplier and order code or "".
        source: Where its data come from or "".
        extent_mm: Declared reach along the part's axes, checked against the solid; None: not declared.
        piece_of: Number of the part that it is drawn as a piece of, and ordered with; "" for a part of its own.
    """

    number: str
    description: str
    solid: cq.Solid
    material: Material
    make: bool
    holes: tuple[Hole, ...] = ()
    mass_g: float | None = None
    standard: str = ""
    order_code: str = ""
    source: str = ""
    extent_mm: Extent | None = None
    piece_of: str = ""
    to_drawing: bool = False
    notes: tuple[str, ...] = ()

    @property
    def is_drawn(self) -> bool:
        """Whether it has a drawing: whoever makes it makes it by that."""
        return self.make or self.to_drawing


@dataclass(frozen=True)
class Occurrence:
    """One placed copy of a part, fixed to a link (a rigid body of the mechanism).

    Attributes:
        name: Unique in the assembly: part number and where it sits ("upper_arm_0", "socket_1_0_wrist").
        part: The part, shared by all its occurrences.
        link: Name of the rigid body that carries it (see `placement.LINKS`).
        placement: (4, 4) homogeneous transform from the part's frame to the link's frame, mm.
    """

    name: str
    part: Part
    link: str
    placement: np.ndarray


def location_of(frame: np.ndarray) -> Any:
    """Gives the kernel's location, a `TopLoc_Location`, of a (4, 4) rigid transform in mm."""
    from OCP.gp import gp_Trsf
    from OCP.TopLoc import TopLoc_Location

    transform = gp_Trsf()
    transform.SetValues(*np.asarray(frame, dtype=float)[:3].ravel().tolist())
    return TopLoc_Location(transform)


@memoize
def boundary(solid: Any) -> bytes:
    """Gives the boundary of a `cadquery.Solid` at the first call: later some of the kernel's algorithms write to it."""
    return solid.__getstate__()[0].getvalue()


@memoize
def solid_digest(solid: Any) -> str:
    """Computes the digest of a `cadquery.Solid`, by its boundary to the last bit."""
    return digest(boundary(solid))


@memoize
def part_digest(part: Part) -> str:
    """Computes the digest of all that a part is: its record and its solid."""
    return digest(solid_digest(part.solid), [getattr(part, one.name) for one in fields(part) if one.name != "solid"])


@dataclass(frozen=True)
class Joint:
    """A moving joint between two links, as one frame on each; both frames must agree at every pose.

    Frames are (4, 4) in their link's frame, mm: origin at the joint's centre, y along the joint's axis.
    `revolute`: origins and y axes coincide. `ball`: origins coincide, the angle between the y axes is the tilt.

    Attributes:
        name: Such as "shoulder_0", "elbow_1_0", "wrist_2_1".
        kind: "revolute" or "ball".
        link_a: Link that carries `frame_a`.
        link_b: Link that carries `frame_b`.
        frame_a: Joint frame in link a.
        frame_b: Joint frame in link b.
        tilt_limit_rad: Free tilt of a ball joint; None for a revolute joint.
    """

    name: str
    kind: str
    link_a: str
    link_b: str
    frame_a: np.ndarray
    frame_b: np.ndarray
    tilt_limit_rad: float | None = None


@dataclass(frozen=True)
class Fit:
    """A pair of occurrences that is meant to be closer than the general clearance; it is checked, never exempted.

    Attributes:
        a: Occurrence name.
        b: Occurrence name.
        kind: "running gap": the two are on different links and must keep `gap_mm` at every pose.
            "contact": they touch by design (bearing on shaft, ball in socket); their common volume must not
            exceed `overlap_mm3` at any checked pose. "piece": pieces that one part is drawn in, see `Part.piece_of`;
            one body does not run into itself.
        gap_mm: Smallest distance of a running gap, mm.
        gap_max_mm: Largest distance of a running gap that must not get wider either, mm; None: not limited.
        overlap_mm3: Largest common volume of a contact, mm^3.
        reason: Why the two may be this close, a few words.
        guides: Whether a contact across the links of a joint is a seat of that joint.
    """

    a: str
    b: str
    kind: str
    gap_mm: float = 0.0
    overlap_mm3: float = 0.0
    reason: str = ""
    gap_max_mm: float | None = None
    guides: bool = True


@dataclass(frozen=True)
class Contact:
    """A pair of occurrences of which one holds, guides or carries the other: how much of it, and how closely.

    Attributes:
        a: Occurrence name; the inner one: shaft, pin, core of a thread, ball, cable.
        b: Occurrence name; the outer one, or the one that `a` stands on.
        kind: "cylinder": `a` in a bore of `b`; "plane": flat faces upon one another; "ball": `a` in a spherical seat of
            `b`; "cable": `a` lies on round outer faces of `b`; "tip": the flat end of `a` presses on a shaft of `b`;
            "end": pieces of one cable, of which either goes on where the other ends.
        least: Least engaged length of a cylinder, a cable or a tip, mm; least common area of planes or of a ball's
            seat, least area of an end, mm^2.
        gap_mm: Largest gap, mm: of radii and between the axes, along the normal of planes, of cable and face, of tip
            and shaft, between the middles of ends.
        reason: What the contact is for, a few words.
    """

    a: str
    b: str
    kind: str
    least: float
    gap_mm: float
    reason: str


@dataclass(frozen=True)
class Stop:
    """An end of a joint's travel: two occurrences, one on each of its links, meet there and not before.

    Attributes:
        joint: Name of a revolute joint.
        a: Occurrence name, on the joint's link a.
        b: Occurrence name, on the joint's link b.
        angle_rad: Angle of link b about the joint, from its x towards its z, at which they meet.
        sense: Where they meet, towards smaller (-1) or larger (1) angles.
        least_mm: Least length along the joint's axis over which they meet.
    """

    joint: str
    a: str
    b: str
    angle_rad: float
    sense: int
    least_mm: float


@dataclass(frozen=True)
class ToolAccess:
    """A screw that a hexagon key must reach in the finished machine.

    Attributes:
        screw: Occurrence name; its socket opens along z of its frame.
        way_mm: How far it must come out along its axis before it lets go of what it holds.
        reason: What it is loosened for, a few words.
    """

    screw: str
    way_mm: float
    reason: str


@dataclass(frozen=True)
class Removal:
    """A part that comes off the finished machine in a straight line.

    Attributes:
        name: Occurrence name.
        along: Unit vector in the part's frame, the way it goes.
        loose: Names of the occurrences that are loosened or taken off first.
        reason: What it comes off for, a few words.
    """

    name: str
    along: tuple[float, float, float]
    loose: tuple[str, ...]
    reason: str


@dataclass(frozen=True)
class Consumable:
    """What is bought for a design and has no place of its own in the assembly: adhesive, cord, a spring that swings.

    Attributes:
        number: Unique among parts and supplies.
        description: One line for the bill of materials.
        quantity: How many.
        material: Name of its material, or "".
        unit_mass_g: Mass of one that stays in the machine, g.
        standard: Standard or "".
        order_code: Supplier and order code or "".
        source: Where its data come from, and what of them was verified.
    """

    number: str
    description: str
    quantity: int
    material: str
    unit_mass_g: float
    standard: str
    order_code: str
    source: str
