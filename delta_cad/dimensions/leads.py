"""The leads of motors and encoders' boards, drawn as far as they bend.

A motor's leave its back along the axis and bend inwards beside it, their ends free: level, for an outline's rectangle
has the motors' backs at its edge, and a bend down would stand out there. They leave it as far inside of the axis as
keeps their bends within the motor's own outer corner, seen from behind the machine. A board's is plugged in at its
lower edge and goes in two bends on to the outer face of the encoder's leg, where a tie holds it: from there on it lies
on what stands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import acos, hypot, pi, sin, sqrt

import numpy as np

from delta_cad import catalogue
from delta_cad.design import Design
from delta_cad.design.stands import Gap, gaps_of, other_stands
from delta_cad.dimensions.bracket import PLUG_MM as ROOM_MM
from delta_cad.dimensions.bracket import BracketDimensions
from delta_cad.dimensions.layers import Layers
from delta_cad.dimensions.rules import FARTHER_OUT, another, require, tenths_above

LEAD_MM = 2.3  # outside diameter of a silicone lead of 0.5 mm^2; makers' tables: 2.1 to 2.3; from memory
LEAD_G_M = 9.0  # 4.5 of copper, the rest silicone
BEND = 3.0  # least inner radius, in diameters, of a flexible lead that is laid once: DIN VDE 0298-3; from memory
PLUG_MM = 3.0  # straight behind the motor: a push-on plug, or solder under its sleeve
TAIL_MM = 5.0  # straight after the bend
EDGE_MM = 0.5  # of a motor's back beside a lead, beyond half the lead itself
_APART_MM = 5.0  # of neighbouring leads
_COUNTS = {"brushed": 2, "brushless": 3}  # of a motor's phases

SENSOR_MM = 3.0  # six wires of 0.8 about a seventh's room are 2.4, a sleeve of 0.3 around them
SENSOR_G_M = 14.0  # six of AWG 28 with their insulation 1.5 each, the rest sleeve; an estimate
PLUGGED_MM = (8.0, 3.0, 2.5)  # across, over the board, and what stands out of the header, of six poles 1 mm apart
"""Header and housing of JST's series SH: 2.95 high with its entry from the side, for wires of 0.4 to 0.8 mm outside, on
the maker's sheet (pdf.elecfans.com/p/10625074.html, read 2026-11-24). No row's board has a header that a source shows:
width and what stands out are estimates, and a board with another one, or with wires soldered to it, has its room."""
STRAIGHT_MM = 3.0  # of the cable behind its plug: it must not bend at the crimps
CLIP_MM = (12.7, 3.5)  # side and height of a base that is glued on; half an inch; from memory
TIE_MM = (2.5, 1.2)  # width and thickness of its tie; the least that is in stock: 2.5; thickness from memory
_SADDLE_MM = 0.2  # by which a lead lies in its base
TIED_MM = CLIP_MM[1] + SENSOR_MM / 2.0 - _SADDLE_MM
APART_LEAST_MM = 0.1  # of a motor, as it is drawn off its cheek, from what is flexible
LINE = 40  # points of a bend
STEPS = 40  # in which the place of a tie settles, to a micrometre
LONG_MM = 500.0  # of any lead as it is ordered: to a controller within half a metre; cut on the machine


@dataclass(frozen=True)
class LeadDimensions:
    """Leads of one kind behind one motor.

    Attributes:
        number: Of the part.
        diameter_mm: Of a lead.
        bend_mm: Radius of its middle line.
        across_mm: Where they leave the motor's back, across its axis and upright.
        inside_mm: How far inside of the motor's axis they leave its back.
        square: Directions (outwards, behind) that are square to a side of the outline, of length 1.
    """

    number: str
    diameter_mm: float
    bend_mm: float
    across_mm: tuple[float, ...]
    inside_mm: float
    square: tuple[tuple[float, float], ...]

    @property
    def behind_mm(self) -> float:
        """How far they reach behind the motor's back."""
        return PLUG_MM + self.bend_mm + self.diameter_mm / 2.0

    @property
    def outside_mm(self) -> list[tuple[float, float]]:
        """Where, seen from above, a lead stands out farthest from the motor's axis: outwards, behind its back."""
        outer, centre = self.bend_mm + self.diameter_mm / 2.0, -self.inside_mm - self.bend_mm
        bend = [(outer * out + centre, outer * behind + PLUG_MM) for out, behind in self.square]
        return [*bend, (centre - TAIL_MM, self.behind_mm)]

    @property
    def length_mm(self) -> float:
        """Length of what is drawn of one."""
        return PLUG_MM + pi / 2.0 * self.bend_mm + TAIL_MM


def lead_dimensions(design: Design, motor: catalogue.Motor) -> tuple[LeadDimensions, ...]:
    """Dimensions the leads behind a motor, its own encoder's after those of its phases; none where none are drawn."""
    if design.hardware.leads != "bent":
        return ()
    gap = gaps_of(design.geometry)[0]
    along, aside = abs(gap.cosine), gap.sine
    square = (1.0, 0.0), (aside, along), (along, aside), (0.0, 1.0)

    def leads(number: str, diameter_mm: float, across_mm: tuple[float, ...]) -> LeadDimensions:
        bend = (BEND + 0.5) * diameter_mm
        inside = _inside_mm(motor, gap, bend, diameter_mm, max(map(abs, across_mm)))
        return LeadDimensions(number, diameter_mm, bend, across_mm, inside, square)

    count = _COUNTS[motor.commutation]
    across = tuple(_APART_MM * (k - (count - 1) / 2.0) for k in range(count))
    phases = leads("motor_lead", LEAD_MM, across)
    if design.hardware.encoder_at != "motor":
        return (phases,)
    return phases, leads("encoder_lead", SENSOR_MM, (across[-1] + _APART_MM,))


def _inside_mm(motor: catalogue.Motor, gap: Gap, bend_mm: float, diameter_mm: float, across_mm: float) -> float:
    """Chooses how far inside of a motor's axis its leads leave its back, mm: no farther than the back's edge lets them.

    Behind the machine the motor of chain 1 ends with its outer corner, its radius r out from its axis. In that
    direction, (c, s) out and behind in its chain, a lead reaches `R + d / 2 + s PLUG_MM - c (inside + R)`, the corner
    `c r`. Where chain 1 itself does not stand behind (c <= 0), the corner shields nothing.

    Args:
        motor: Row of the catalogue; where its terminals are is in no row, so its leads leave it anywhere on its back.
        gap: That of chains 0 and 1.
        bend_mm: Radius of a lead's middle line, R.
        diameter_mm: Of a lead, d.
        across_mm: How far across the axis the outermost one leaves.
    """
    if gap.cosine >= 0.0:
        return 0.0
    radius = motor.diameter_mm / 2.0
    reach = (bend_mm + diameter_mm / 2.0 + PLUG_MM * gap.sine) / -gap.cosine
    edge = sqrt(max((radius - diameter_mm - EDGE_MM) ** 2 - across_mm**2, 0.0))
    return min(max(tenths_above(reach - bend_mm - radius), 0.0), edge)


@dataclass(frozen=True)
class SensorLeadDimensions:
    """Lead of an encoder's board, in the shoulder's frame.

    Attributes:
        plug_mm: (x, y, z) where its housing begins, in the middle of the header's lower face.
        bend_mm: Radius of its middle line.
        way_mm: (x, y) from the plug to the line on which it is tied.
        leg_y_mm: Outer face of the encoder's leg, on which its tie stands.
    """

    plug_mm: tuple[float, float, float]
    bend_mm: float
    way_mm: tuple[float, float]
    leg_y_mm: float

    @property
    def turn_rad(self) -> float:
        """How far it bends either way, a quarter of a turn at most."""
        return _turn_rad(self.bend_mm, hypot(*self.way_mm))

    @property
    def level_mm(self) -> float:
        """Straight piece between both bends, where a quarter of a turn is not enough."""
        return max(0.0, hypot(*self.way_mm) - 2.0 * self.bend_mm)

    @property
    def clip_z_mm(self) -> float:
        """Height of the tie's middle."""
        low = PLUGGED_MM[2] + STRAIGHT_MM + 2.0 * self.bend_mm * sin(self.turn_rad)
        return self.plug_mm[2] - low - CLIP_MM[0] / 2.0

    @property
    def length_mm(self) -> float:
        """Length of what is drawn of it, from the plug on."""
        return STRAIGHT_MM + 2.0 * self.bend_mm * self.turn_rad + self.level_mm + CLIP_MM[0] + TAIL_MM

    @property
    def line_mm(self) -> np.ndarray:
        """Points of its middle line down to its drawn end, (n, 3), shoulder's frame, some half a millimetre apart."""
        turns = np.linspace(0.0, self.turn_rad, LINE)
        bent, low = self.bend_mm * (1.0 - np.cos(turns)), self.bend_mm * np.sin(turns)
        aside = hypot(*self.way_mm)
        tied = np.linspace(0.0, CLIP_MM[0] + TAIL_MM, LINE)
        way = np.concatenate([np.zeros(2), bent, aside - bent[::-1], np.full(LINE, aside)])
        start, end = PLUGGED_MM[2] + STRAIGHT_MM, PLUGGED_MM[2] + STRAIGHT_MM + 2.0 * low[-1]
        down = np.concatenate([[PLUGGED_MM[2], start], start + low, end - low[::-1], end + tied])
        along = np.array([*self.way_mm, 0.0]) / aside
        return np.array(self.plug_mm) + way[:, None] * along - down[:, None] * np.array([0.0, 0.0, 1.0])


def _turn_rad(bend_mm: float, aside_mm: float) -> float:
    return acos(max(1.0 - aside_mm / (2.0 * bend_mm), 0.0))


def sensor_lead_dimensions(
    design: Design, stack: Layers, bracket: BracketDimensions, encoder: catalogue.Encoder, motor: catalogue.Motor
) -> SensorLeadDimensions | None:
    """Dimensions the lead of an encoder's board; None where the design draws none, or has no board.

    Its tie stands on the line from the middle of the leg's head to the middle of its foot, around which the leg is
    nowhere narrower than the tie's base.

    Args:
        design: The design.
        stack: Stack of a chain along the shoulder axis.
        bracket: Its chain's.
        encoder: Row of the catalogue; its board stands upright, its plug at its lower edge.
        motor: Row of the catalogue.

    Raises:
        DimensionError: A motor runs into the lead.
    """
    found = _tied(design, stack, bracket, encoder)
    if found is not None:
        _require_room(found, bracket, stack, motor, gaps_of(design.geometry))
    return found


def tie_shortfall_mm(design: Design, stack: Layers, bracket: BracketDimensions, encoder: catalogue.Encoder) -> float:
    """Computes by how much an encoder's leg is too short for the tie of its board's lead over its foot; 0: it is not.

    Arguments as of `sensor_lead_dimensions`.
    """
    lead = _tied(design, stack, bracket, encoder)
    if lead is None:
        return 0.0
    return max(0.0, bracket.base_top_mm + bracket.foot_height_mm - (lead.clip_z_mm - CLIP_MM[0] / 2.0))


def _tied(
    design: Design, stack: Layers, bracket: BracketDimensions, encoder: catalogue.Encoder
) -> SensorLeadDimensions | None:
    """The lead of a board with its tie where it belongs; None where there is none."""
    if design.hardware.leads != "bent" or design.hardware.encoder_at == "motor":
        return None
    bend, face = (BEND + 0.5) * SENSOR_MM, stack.encoder_cheek_mm[0]
    plug = 0.0, stack.encoder_board_mm[0] - ROOM_MM[1] / 2.0, 1.0 - encoder.board_length_mm / 2.0
    inwards = face - TIED_MM - plug[1]
    foot = sum(bracket.foot_u_mm) / 2.0 - bracket.shoulder_u_mm, bracket.base_top_mm + bracket.foot_height_mm / 2.0
    head = bracket.leg_circle_mm if design.hardware.drive == "capstan" else (0.0, 0.0, bracket.head_radius_mm)
    found = SensorLeadDimensions(plug, bend, (head[0], inwards), face)
    for _ in range(STEPS):  # further aside is further down
        along = found.clip_z_mm / foot[1]
        found = SensorLeadDimensions(plug, bend, (head[0] + along * (foot[0] - head[0]), inwards), face)
    return found


def _require_room(
    lead: SensorLeadDimensions, b: BracketDimensions, stack: Layers, motor: catalogue.Motor, gaps: Sequence[Gap]
) -> None:
    """Refuses a base on which a neighbour's motor, or its way off its cheek, runs into a board's lead."""
    points, radius = lead.line_mm + np.array([b.shoulder_u_mm, 0.0, 0.0]), (SENSOR_MM + motor.diameter_mm) / 2.0
    found = np.inf
    for lead_stand in other_stands(gaps):  # as seen from that of a neighbour's motor
        own = points @ lead_stand[:3, :3].T + lead_stand[:3, 3]
        beyond = stack.motor_face_mm - own[:, 1]  # before its mounting face there is no motor
        off = np.hypot(own[:, 0] - b.motor_axis_mm[0], own[:, 2] - b.motor_axis_mm[1]) - radius
        found = min(found, float(np.maximum(off, beyond - SENSOR_MM / 2.0).min()))
    require(
        found >= APART_LEAST_MM,
        "sensor_lead",
        "beside the neighbour's motor",
        f"the motors come within {found:.2f} mm of the leads of the encoders beside them; at least {APART_LEAST_MM:g}",
        *FARTHER_OUT,
        *another("motor", "leads"),
    )
