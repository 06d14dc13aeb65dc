"""Why a design's hardware is refused: all reasons in closed form, from sampled poses without solids.

Eight kinds: a platform that hangs below its elbows, after which nothing else is judged; parts that cannot be given
sound dimensions; a drive that gives too little or breaks its cable; an outline that elbows or motors alone exceed; a
height that the knob exceeds; feet on which it tips or slides; a cable whose plane or length no tolerances hold; loads
that parts or drives may not bear even if what moves weighed as little as it can. Each is necessary: what passes here
may still fail a check.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from math import cos

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.dimensions import DimensionError, Dimensions, Reason, dimensions
from delta_cad.dimensions.capstan import ROPE_FACTOR
from delta_cad.dimensions.platform import FACTOR, firmer_mounting, upset_forces_N
from delta_cad.dimensions.rules import (
    ARM,
    BASE,
    BOTTOM,
    FOREARM,
    HEIGHT,
    RATIO,
    SECTOR,
    Way,
    another,
    ceil_sig,
    larger,
    smaller,
)
from delta_cad.dimensions.sizes import largest_force_N
from delta_cad.dimensions.tolerances.general import CLASSES
from delta_cad.dimensions.tolerances.machine import plane_chain, travel_chain
from delta_cad.dimensions.tolerances.square import FINEST
from delta_cad.drive import drive_torque
from delta_cad.interference.reasons import INTERFERENCE_FORMS
from delta_cad.interference.static_obstacles import are_alike
from delta_cad.mechanism import direct_margin, joint_angles, reach_excess
from delta_cad.mechanism.inverse import forearm_vectors
from delta_cad.mechanism.placement import CHAINS, chain_stand
from delta_cad.structure.hardware.overloads import overloads
from delta_cad.structure.loads import sampled_mm

_PROVEN_MM = 0.2  # beyond clearance and meshes: with 0.16 proofs were still undecided
HEAVIER = 1.25  # times what `mass_lower_bound` gives: only small sectors and long rods were built heavier
_WEIGHT_MOST = 2.0  # times what stands on the base at least that a whole machine weighs at most
_COUNT = 5  # positions along an edge of the cube, its corners among them


@dataclass(frozen=True)
class Held:
    """What a machine is held to.

    Attributes:
        weighed: How many times what moves at least is taken to weigh; 0: nothing weighs anything.
        margin_mm: What is to be left between what passes, beyond the clearance.
    """

    weighed: float
    margin_mm: float


NECESSARY = Held(1.0, 0.0)
"""What no machine does without: what is refused would fail."""
SURE = Held(HEAVIER, _PROVEN_MM)
"""What a suggested design is held to, so that solids pass, too."""
LEARNT = Held(0.0, 0.0)
"""What a candidate is held to in a search that learns weights and distances from solids."""

_Form = Callable[[Dimensions, Held], Iterable[Reason]]


class Judged:
    """The closed-form results of one design; each is computed at its first use.

    Args:
        design: A design, each field within its own bounds.
        held: What it is held to.
    """

    def __init__(self, design: Design, held: Held = NECESSARY) -> None:
        self.design, self.held = design, held
        self._known: dict[str, tuple[Reason, ...]] = {}

    @cached_property
    def _dimensioned(self) -> Dimensions | tuple[Reason, ...]:
        try:
            return dimensions(self.design)
        except DimensionError as error:
            return error.reasons

    def of(self, form: str) -> tuple[Reason, ...] | None:
        """Gives the reasons of one form, by its name; None where it cannot be judged for what comes before it.

        Raises:
            UnreachableError: A point of the cube is out of reach.
        """
        if form == MODE:
            return self._once(form, lambda: _mode(self.design))
        if self.of(MODE):  # parts and loads would be about another machine than the forward kinematics'
            return None
        if form in ALONE:
            return self._once(form, lambda: ALONE[form](self.design))
        d = self._dimensioned
        if form == PARTS:
            return () if isinstance(d, Dimensions) else d
        return self._once(form, lambda: FORMS[form](d, self.held)) if isinstance(d, Dimensions) else None

    def _once(self, form: str, judge: Callable[[], Iterable[Reason]]) -> tuple[Reason, ...]:
        if form not in self._known:
            self._known[form] = tuple(judge())
        return self._known[form]

    def forms(self) -> Iterator[tuple[str, tuple[Reason, ...]]]:
        """Gives the reasons of form after form, by its name; those that cannot be judged are left out."""
        for form in (MODE, *ALONE, PARTS, *FORMS):
            if (found := self.of(form)) is not None:
                yield form, found


def refusals(design: Design, held: Held = NECESSARY) -> tuple[Reason, ...]:
    """Gives every reason why a design's hardware is refused; none where it may pass.

    Args:
        design: A validated design.
        held: What it is held to.

    Raises:
        UnreachableError: A point of the cube is out of reach.
    """
    found = dict(Judged(design, held).forms())
    first = found.pop(PARTS, ())  # what has no dimensions is listed first
    return (*first, *(reason for reasons in found.values() for reason in reasons))


def _mode(design: Design) -> tuple[Reason, ...]:
    """The assembly mode where it is not the machine's own, of a cube that can be reached."""
    positions = sampled_mm(design.workspace, _COUNT)
    margins = direct_margin(design.geometry, positions / MM_PER_M)
    if margins.min() > 0.0 or reach_excess(design.geometry, positions / MM_PER_M).max() > 0.0:
        return ()
    x, y, z = (round(float(v), 1) + 0.0 for v in positions[np.argmin(margins)])  # no -0.0
    message = (
        f"det S > 0, the platform above the elbows, is asked at every position, but is {margins.min():.3g} m^3 at "
        f"({x:.1f}, {y:.1f}, {z:.1f}) mm"
    )
    return (Reason("cube", "assembly mode", message, (larger(BOTTOM), larger(FOREARM))),)


def _turning(design: Design) -> Iterator[Reason]:
    """A constraint singularity inside the cube, where no rod holds the platform against turning: a higher cube."""
    g = design.geometry
    rods = forearm_vectors(g, sampled_mm(design.workspace) / MM_PER_M)
    (r1, r2, r3), (v1, v2, v3) = np.moveaxis((rods * g.radial).sum(axis=-1), -1, 0), np.moveaxis(rods[..., 2], -1, 0)
    # determinant of the couples that rods bear, README (48), over the sine between chains 0 and 1
    held = -2.0 * g.side_cosine * r1 * v2 * v3 + v1 * r2 * v3 + v1 * v2 * r3
    if held.min() <= 0.0 <= held.max():
        message = "somewhere in the cube rods let the platform turn"
        yield Reason("platform", "turning", message, (Way((BOTTOM,)),))


def _drive(design: Design) -> Iterator[Reason]:
    """Continuous and peak torque, the cable's strength and bend."""
    drive, h = drive_torque(design), design.hardware
    demand = (
        ("continuous", drive.continuous_torque_N_m, drive.required_torque_N_m),
        ("peak", drive.peak_torque_N_m, drive.required_peak_N_m),
    )
    for words, value, required in demand:
        if value < required:
            lasts = words == "continuous" or design.requirements.peak_torque_N_m is None
            less = smaller(f"requirements.{'joint' if lasts else 'peak'}_torque_N_m")
            geared = (larger(RATIO), larger(RATIO, SECTOR)) if h.drive == "capstan" else ()
            message = f"{value:.4g} of {required:.4g} N m at the joint, {words}"
            yield Reason("drive", f"{words} torque", message, (*geared, *another("motor"), less))
    tension, ratio, least = drive.cable_tension_N, drive.bend_ratio, drive.bend_ratio_least
    if tension is None or ratio is None or least is None:
        return
    if (safety := drive.cable_safety_factor) is not None and safety < ROPE_FACTOR:
        message = f"a breaking load of {safety:.3g} times its tension of {tension:.4g} N; at least {ROPE_FACTOR:g}"
        yield Reason("cable", "strength", message, (*another("cable"), larger(SECTOR)))
    if ratio < least:
        message = f"its groove on the pinion is {ratio:.4g} times as wide as the cable; at least {least:g}"
        yield Reason("cable", "bend ratio", message, (larger(SECTOR), smaller(RATIO), *another("cable")))


def least_outline_mm(d: Dimensions) -> np.ndarray:
    """Computes (2,) what a machine takes at least along x and y: elbows farthest out, ends of its motors, base plate.

    Args:
        d: Its dimensions.
    """
    g, half = d.design.geometry, d.forearm.bar_length_mm / 2
    u, face, radius = d.bracket.motor_axis_mm[0], d.layers.motor_face_mm, d.motor.diameter_mm / 2
    drive = [(u + side * radius, face + d.motor.length_mm) for side in (-1.0, 1.0)]
    for leads in d.leads:
        drive += [(u + out, face + d.motor.length_mm + behind) for out, behind in leads.outside_mm]
    found = []
    for i, angle in zip(CHAINS, _flattest_rad(d), strict=True):
        elbow, stand = d.bracket.shoulder_u_mm + d.arm.length_mm * cos(angle), chain_stand(g, i)
        arm = [(elbow, -half), (elbow, half), (elbow + d.arm.boss_radius_mm, 0.0)]
        found.append(np.array([*arm, *drive]) @ stand[:2, :2].T + stand[:2, 3])
    plates = np.transpose([d.base.reach_mm, *([] if d.bench is None else [(d.bench.x_mm, d.bench.y_mm)])], (0, 2, 1))
    placed = np.concatenate([*found, *plates])
    return np.ptp(placed, axis=0)


def _flattest_rad(d: Dimensions) -> list[float]:
    """Angle of each chain's arm nearest to level that occurs, rad; of chains that are not alike of those sampled."""
    if are_alike(d.design):
        return [min(max(0.0, d.extremes.shoulder_min.value), d.extremes.shoulder_max.value)] * len(CHAINS)
    theta = joint_angles(d.design.geometry, sampled_mm(d.design.workspace) / MM_PER_M)
    return np.clip(0.0, theta.min(axis=0), theta.max(axis=0)).tolist()


def _outline(d: Dimensions) -> list[Reason]:
    """Outline of the outermost bodies, in the orientation that fits best."""
    required, least = d.design.requirements, least_outline_mm(d)
    plate = np.ptp(d.base.reach_mm, axis=1)
    demand = {"envelope_width_mm": required.envelope_width_mm, "envelope_depth_mm": required.envelope_depth_mm}
    ways = ([*zip(demand, least, strict=True)], [*zip(demand, least[::-1], strict=True)])
    best = min(ways, key=lambda way: max(float(size) - demand[name] for name, size in way))
    inwards = smaller(ARM), smaller(BASE)
    what = "its feet stand", "elbows and motors reach"
    return [
        Reason(
            "base_plate" if size in plate else "assembly",
            name.replace("_mm", "").replace("_", " "),
            f"{what[size not in plate]} over {ceil_sig(size)} mm; at most {demand[name]:g}",
            (*inwards, larger(f"requirements.{name}")),
        )
        for name, size in best
        if size > demand[name]
    ]


def _height(d: Dimensions) -> Iterator[Reason]:
    """A knob that rises higher than allowed at the cube's top."""
    most = d.design.requirements.height_max_mm
    if most is not None and d.height_mm > most:
        message = f"its knob rises {ceil_sig(d.height_mm)} mm over the mounting surface; at most {most:g}"
        ways = smaller(BOTTOM), smaller("cube.half_side_mm"), larger(HEIGHT)
        yield Reason("assembly", "height", message, ways)


def _stability(d: Dimensions) -> Iterator[Reason]:
    """Feet on which a machine would tip or slide even if it weighed `_WEIGHT_MOST` times what stands on its base."""
    if d.design.hardware.mounting != "feet":
        return
    force = FACTOR * largest_force_N(d.design.requirements)
    least = _WEIGHT_MOST * min(upset_forces_N(d, np.array(d.feet_mm), d.floor_mm))
    if least < force:
        message = (
            f"{least:.3g} N at the knob tip or slide it on its feet, with parts of {_WEIGHT_MOST:g} times their least "
            f"weight; it is to bear {force:g}, {FACTOR:g} times the largest force; {firmer_mounting(d)}"
        )
        yield Reason("base_plate", "standing", message, another("mounting"))


def _cable_plane(d: Dimensions) -> Iterator[Reason]:
    """A pinion so small that its groove's own climb leaves nothing of the fleet angle to tolerances."""
    if d.capstan is None or (chain := plane_chain(d, d.capstan, CLASSES[0], FINEST)).holds:
        return
    message = f"it leaves its plane by {chain.rss[1]:.3f} mm with the finest tolerances; at most {chain.high:.3f}"
    yield Reason("cable", "plane", message, (larger(SECTOR), smaller(RATIO), *another("cable")))


def _cable_travel(d: Dimensions) -> Iterator[Reason]:
    """A cable so long that what it stretches and what sector and pinion are off leave its carriage no travel."""
    if d.capstan is None or travel_chain(d, d.capstan, CLASSES[0]).holds:
        return
    message = f"a cable of {d.capstan.cable_length_mm:.0f} mm stretches and differs by more than its carriage goes"
    yield Reason("cable", "travel", message, (smaller(SECTOR), *another("cable")))


MODE, PARTS = "assembly mode", "dimensions"
ALONE: dict[str, Callable[[Design], Iterable[Reason]]] = {"turning": _turning, "drive": _drive}
"""Forms that need no dimensions of parts."""
FORMS: dict[str, _Form] = {
    "outline": lambda d, _: _outline(d),
    "height": lambda d, _: _height(d),
    "standing": lambda d, _: _stability(d),
    "cable plane": lambda d, _: _cable_plane(d),
    "cable travel": lambda d, _: _cable_travel(d),
    **{name: lambda d, held, form=form: form(d, held.margin_mm) for name, form in INTERFERENCE_FORMS.items()},
    "overloads": lambda d, held: overloads(d, held.weighed),
}
"""Forms of a machine that has dimensions, in the order in which reasons are listed."""
