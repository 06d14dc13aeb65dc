"""Updates of the corrections after a refusal or a failed check: a bound, another part, or `InconclusiveError`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.design.feel_defaults import COUPLE_INDEX
from delta_cad.design.stands import gaps_of
from delta_cad.dimensions import DimensionError
from delta_cad.dimensions.capstan import rim_y_mm
from delta_cad.dimensions.rules import ARM, BASE, HEIGHT, WIDTH
from delta_cad.mechanism.limits import Outline
from optimizer.codesign.candidate import Candidate, outline_arguments
from optimizer.codesign.corrections import (
    COUPLE_MOST,
    KNOB_MM,
    REAR_PAIR,
    SECTORS,
    SIDE_PAIR,
    TORQUE_MARGIN_N_M,
    ChainReach,
    Corrections,
    apart_by,
    as_symmetric,
    folds,
    placed_sides,
)
from optimizer.codesign.estimates import ELBOW_FIELD, ENVELOPE, LENGTHS, SIZES, SWING_FIELD, Estimate
from optimizer.codesign.hardware import Selection, default_of
from optimizer.problem.brief import DesignBrief
from optimizer.problem.variables import SIDE, VARIABLES, completed

if TYPE_CHECKING:
    from delta_cad.design import Design
    from delta_cad.solids.primitive import BuildError

_SHIFT = VARIABLES.index("side_shift")
_NO_LENGTHS = (0.0,) * _SHIFT
_SWUNG_INWARDS = ("sector", "pinion")  # parts that a neighbour's base radius gives room, too
_INWARDS_STEP_MM = 0.6
_PARTS = ("tube", "cable", "bearing", "knob", "foot", "magnet")
_SIZE_STEP = 10.0  # tenths of a mm: bounds that follow from one another creep otherwise
UNFOLDED = 0.85  # of what was asked of arms that folded: it is asked anew where it still has to be
_GROWTH = 1.25  # of a length at once: what asks for more may be met by what another reason asks for
COUPLE_STEP = 0.03
LEVER_STEPS = 1.03, 1.4  # factor of the couple index for each mm of a knob's lever, least and largest at once
_LITTLE = 1e-3  # of a load that is borne: none at all has no power
LEVER_EXPONENT = 0.7  # of the share that is borne: a part of a load is not the lever's
_ELBOW_LEAST_DEG, ELBOW_STEP_DEG = 0.5, 2.0
_PARTED_MM, _PROVEN_MM = (
    0.08,
    0.03,
)  # by which eyes part from their arm for a degree more, others by more; for the proof
_DOUBLINGS = 3  # of the step of a length that was not enough the last time
_REACHED = ("tool access", "parts come off", "assembly order", "assembly keys")
_REACHED_STEP_MM = 1.0  # of chains in the way of one another
PULLED = "motor shaft"  # part that refusals name, and check: "structure motor shaft, peak"
_SOLID = "solid "  # checks of what the kernel made, with a part's number
_APART = "chains apart"  # check: what a base radius lacks for keys, or leaves
_UNKNOWN_MM = 0.5  # that a length is taken to be short by where a check gives no figure
_CREEP_MM = 0.4
# By which a drive is longer or shorter: what follows from less is learnt with the outline. Arms and what holds them
# follow from one another, so that a drive which is a little shorter is left as it is.
_SAME_MM, _SHORTER_MM = 0.3, 0.6
_NEARER_MM, _FAR_MM = 4.0, 1000.0  # base radii that show how a drive follows them
_BEYOND_MM = 0.15  # of an outline beyond what its chains reach: proofs state it so much larger
_LEFT_MM = 2.0  # of a base radius that closed forms are asked about
_ROUNDED_MM = 0.002  # to which lengths are rounded, and a little
_KERNEL, KERNEL_TRIES, _KERNEL_STEP_MM = "CAD kernel", 3, 0.13  # of a base radius at which a solid cannot be made
MARGIN_MM = 0.05  # of an outline, over what the last machine took too much
_MARGIN = 0.998  # of what a machine just missed
_SHARES = {"effective mass": "mass_share", "friction": "friction_share", "position step": "step_share"}
"""Check -> the required fraction of its limit."""
_GRAVITY_CHECK = "torque with gravity"


MOUNTING = "hardware.mounting"


class NoProgressError(Exception):
    """No further candidate of a choice is left to try: limits, closed forms or parts refuse it, and which."""


class InconclusiveError(NoProgressError):
    """A candidate failed in a way that shows nothing of others: the search has no next one, but there may be some."""


def from_refusals(
    brief: DesignBrief,
    choice: Selection,
    corrections: Corrections,
    reasons: Sequence[Estimate],
    lengths_mm: Sequence[float] = _NO_LENGTHS,
) -> tuple[Selection, Corrections]:
    """Learns from the closed forms that refuse a candidate.

    Args:
        brief: What the customer asks.
        choice: Hardware that was refused.
        corrections: What was known.
        reasons: Why; all that can be met are.
        lengths_mm: (9) of the candidate that was refused; of use behind a panel, and of a placed machine.

    Returns:
        What to try next.

    Raises:
        NoProgressError: None of them can be.
    """
    before = choice, corrections
    if choice.placed:
        reasons = [_of_stands(reason, choice, lengths_mm) for reason in reasons]
    radii = [one.bound for one in reasons if one.field == BASE and one.bound is not None]
    room = _room_for_arm_mm(brief, choice, corrections, radii, completed(lengths_mm))
    reasons = [_by_angle(reason, room) for reason in reasons]
    overloads: list[tuple[float, str]] = []
    if tipping := [reason for reason in reasons if reason.field == MOUNTING]:
        raise NoProgressError(f"{tipping[0]}")  # no ratio, width or length of this hardware makes it stand
    for reason in reasons:
        field, bound = reason.field, reason.bound
        entry = field.rpartition(".")[2]
        if entry in ENVELOPE and reason.part == "base_plate":
            continue  # shorter arms, which a smaller outline asks for, put its feet farther out
        if field in LENGTHS and isinstance(bound, float):
            now = reason.value if isinstance(reason.value, float) else bound
            least = math.ceil(min(bound, max(_GROWTH * now, now + _CREEP_MM)) * _SIZE_STEP) / _SIZE_STEP
            name = SECTORS if choice.placed and field == BASE and reason.part in _SWUNG_INWARDS else LENGTHS[field]
            if corrections.least(name) > 0.0:  # again: what it rests on gives way as it grows
                least += _CREEP_MM
            corrections = corrections.raised(name, least, str(reason))
        elif field == WIDTH and isinstance(bound, float):
            away = math.ceil if bound > choice.width_mm else math.floor
            choice = choice.with_(width_mm=away(bound * _SIZE_STEP) / _SIZE_STEP)
        elif entry in SIZES and isinstance(bound, float) and entry not in brief.hardware:
            away = math.floor if isinstance(reason.value, float) and bound < reason.value else math.ceil
            choice = choice.with_entry(entry, away(bound * _SIZE_STEP) / _SIZE_STEP)
        elif entry in _PARTS:
            choice = _another(brief, choice, entry)
        elif entry in ENVELOPE and isinstance(bound, float) and isinstance(reason.value, float):
            # an outline that is free is posed in whole millimetres: by less it may stay as it is
            more = bound - reason.value + MARGIN_MM if brief.outline_mm else float(math.ceil(bound - reason.value))
            over = list(corrections.beyond_mm(choice.placed))
            for k in _sides(brief, choice, corrections, entry, reason.value, lengths_mm):
                over[k] += more
            corrections = corrections.with_beyond(choice.placed, (over[0], over[1]), str(reason))
        elif field == HEIGHT and isinstance(bound, float) and isinstance(reason.value, float):
            more = corrections.height_beyond_mm + bound - reason.value
            corrections = corrections.updated(str(reason), height_beyond_mm=more)
        elif field == ELBOW_FIELD and isinstance(bound, float):
            least = math.ceil(bound * _SIZE_STEP) / _SIZE_STEP
            known = corrections.least_mm.items()
            eased = {name: mm if name.endswith(("radius", "pair")) else UNFOLDED * mm for name, mm in known}
            corrections = corrections.updated(str(reason), elbow_angle_deg=least, least_mm=eased)
        elif field == SWING_FIELD and isinstance(bound, float):
            least = max(corrections.shoulder_low_deg, math.ceil(bound * _SIZE_STEP) / _SIZE_STEP)
            corrections = corrections.updated(str(reason), shoulder_low_deg=least)
        elif (field.startswith("requirements.") or not field) and brief.panel is not None:
            overloads.append((reason.reason.margin or 1.0, str(reason)))
        elif field.startswith("requirements.") or not field:
            corrections = _stiffer(corrections, brief.couple_index_min, str(reason))
    if overloads:
        corrections = _levered(corrections, brief.couple_index_min, 2.0 * lengths_mm[SIDE], *min(overloads))
    if (choice, corrections) == before:
        raise NoProgressError("; ".join(str(reason) for reason in reasons))
    return choice, corrections


def _sides(
    brief: DesignBrief,
    choice: Selection,
    corrections: Corrections,
    entry: str,
    size_mm: float,
    lengths_mm: Sequence[float],
) -> tuple[int, ...]:
    """The sides of a machine, 0 along y and 1 along x, of which one lies along a side of the outline.

    Its longer side lies along the outline's; in a square either may.
    """
    sides = brief.outline_mm or (math.inf, 0.0)
    if sides[0] == sides[1]:
        return 0, 1
    shorter = size_mm < max(brief.outline_mm or (0.0, 0.0)) or entry == ENVELOPE[1]
    along_y, along_x = _sides_mm(choice, corrections, lengths_mm)
    return (int(shorter == bool(along_y >= along_x)),)


def _room_for_arm_mm(
    brief: DesignBrief,
    choice: Selection,
    corrections: Corrections,
    radii_mm: Sequence[float],
    lengths_mm: np.ndarray,
) -> float:
    """The longest upper arm within an outline for the required base radius, as the chains are placed."""
    if brief.outline_mm is None:
        return math.inf
    shift, cosine = lengths_mm[_SHIFT : _SHIFT + 2].tolist()
    outline = Outline(*brief.outline_mm, choice.width_mm, corrections.overhead_mm)
    reach = outline.largest_reach_mm(shift, cosine) + min(shift, 0.0)
    return reach - max([corrections.least_radius_mm(choice.width_mm), *radii_mm])


def _of_stands(reason: Estimate, choice: Selection, lengths_mm: Sequence[float]) -> Estimate:
    """An estimate of chain 0's base radius by that of all chains of a placed machine, which moves with it.

    What swings inwards gets room by its base radius, in steps where other reasons leave no threshold of it.
    """
    inwards = reason.part in _SWUNG_INWARDS
    now = float(min(as_symmetric(completed(lengths_mm), choice.width_mm)[SECTORS if inwards else "shoulders"]))
    if inwards and reason.field != BASE and reason.field in LENGTHS:
        return replace(reason, field=BASE, value=now, bound=now + _INWARDS_STEP_MM, angle=None)
    if reason.field != BASE or reason.bound is None or not isinstance(reason.value, float):
        return reason
    ahead = reason.value - now
    return replace(reason, value=now, bound=reason.bound - ahead)


def _by_angle(reason: Estimate, room_mm: float) -> Estimate:
    """An estimate of a length that an angle ends as well, which other lengths may give: with that.

    An arm that swings too low may be longer, too, where there is room.
    """
    if reason.angle is None:
        return reason
    field, least = reason.angle
    if field == SWING_FIELD and reason.field == ARM and reason.bound is not None and reason.bound <= room_mm:
        return reason
    return replace(reason, field=field, value=None, bound=least)


def _another(brief: DesignBrief, choice: Selection, entry: str) -> Selection:
    """Takes the next row of a family that the brief allows."""
    rows = brief.choices[entry]
    first = rows[0] if entry in brief.hardware else default_of(entry)  # as `DesignBrief.hardware_from` takes it
    now = choice.entries.get(entry, first)
    after = rows.index(now) + 1 if now in rows else 0
    return choice if after == len(rows) else choice.with_entry(entry, rows[after])


def too_soft(design: Design) -> tuple[float, float] | None:
    """Computes the least stiffness at the knob of a design, in closed form.

    Returns:
        That stiffness and what is asked, N/mm; None where it is stiff enough or nothing is asked.
    """
    from delta_cad.dimensions import dimensions
    from delta_cad.structure.report import stiffness

    requested = design.requirements.stiffness_min_N_mm
    if requested is None:
        return None
    least = stiffness(dimensions(design)).least_N_mm
    return None if least >= requested else (least, requested)


def utilisation(one: Estimate | CheckResult) -> float:
    """Load over the allowable load, from the ratio of a reason or the value and limit of a check."""
    if isinstance(one, CheckResult):
        return (one.value or 0.0) / (one.limit or 1.0)
    return 1.0 / (one.reason.margin or 1.0)


def from_cable_pull(corrections: Corrections, design: Design, torque_N_m: float, share: float) -> Corrections:
    """Corrects the allowable cable force on a motor's shaft, to which the peak joint torque contributes."""
    pull = _MARGIN * torque_N_m / share / (design.hardware.sector_radius_mm / MM_PER_M)
    return corrections.updated(f"motor shaft: {100.0 * share:.3g} % of what it bears", pull_N=pull)


def from_stiffness(corrections: Corrections, least: float, requested: float, design: Design) -> Corrections:
    """Learns from a knob that is too soft.

    Raises:
        NoProgressError: More hold against turning is not to be had.
    """
    why, index = f"stiffness at the knob {least:.3g} N/mm, {requested:g} asked", _index_min(design)
    if design.panel is not None:
        return _levered(corrections, index, 2.0 * design.cube.half_side_mm, math.sqrt(least / requested), why)
    found = _stiffer(corrections, index, why)
    if found is corrections:
        raise NoProgressError(
            f"the knob has {least:.3g} N/mm at a rotational stiffness index of {COUPLE_MOST:g}; {requested:g} asked"
        )
    return found


def _index_min(design: Design) -> float:
    """The least rotational stiffness index of a candidate: the set limit, or the default."""
    return design.requirements.couple_index_min or COUPLE_INDEX


def _stiffer(corrections: Corrections, required: float, why: str) -> Corrections:
    """Raises the rotational stiffness index over what is required: rods' forces fall, and the knob becomes stiffer."""
    known = max(required, corrections.couple_index_min)
    index = min(known + COUPLE_STEP, COUPLE_MOST)
    return corrections if index <= known else corrections.updated(why, couple_index_min=index)


def _levered(corrections: Corrections, required: float, side_mm: float, share: float, why: str) -> Corrections:
    """Raises the couple index per mm of a knob's lever behind a panel, by a part's ratio of load to allowable load."""
    least, most = LEVER_STEPS
    now = max(corrections.couple_per_mm, max(required, corrections.couple_index_min) / (side_mm + KNOB_MM))
    return corrections.updated(why, couple_per_mm=now * max(min(most, max(share, _LITTLE) ** -LEVER_EXPONENT), least))


def _outcome(result: CheckResult) -> str:
    """A check that failed in one line: its name, what was measured and what was allowed."""
    value, limit = (None if v is None else f"{v:.4g} {result.unit}".strip() for v in (result.value, result.limit))
    return f"{result.name}: {value or 'not proved'}" + (f", limit {limit}" if limit else "")


def from_kernel(
    corrections: Corrections, lengths_mm: tuple[float, ...], error: BuildError | DimensionError
) -> Corrections:
    """Learns that a solid cannot be made: what the kernel does not give here it may give a little farther out.

    Returns:
        What is known now.

    Raises:
        InconclusiveError: A stock length ends there, chains cannot be farther apart, or that failed as often.
    """
    if isinstance(error, DimensionError):
        raise InconclusiveError(str(error)) from error
    return _farther_out(corrections, lengths_mm, str(error))


def _farther_out(corrections: Corrections, lengths_mm: tuple[float, ...], why: str) -> Corrections:
    """Asks for chains a little farther out, so often as that may help; raises `InconclusiveError`."""
    radius = lengths_mm[VARIABLES.index("base_radius")] + min(0.0, float(completed(lengths_mm)[_SHIFT]))
    failed = sum(one.startswith(_KERNEL) for one in corrections.why)
    if failed >= KERNEL_TRIES or corrections.least("base_radius") > radius + _ROUNDED_MM:
        raise InconclusiveError(why)
    return corrections.raised("base_radius", radius + _KERNEL_STEP_MM, f"{_KERNEL}: {why}")


def from_checks(candidate: Candidate, corrections: Corrections, results: Iterable[CheckResult]) -> Corrections:
    """Learns from the checks of a machine that was made.

    Returns:
        What is known now.

    Raises:
        InconclusiveError: A check failed that teaches nothing.
    """
    results = list(results)
    failed = [result for result in results if not result.passed]
    before, corrections = corrections, with_outline(candidate, corrections, results)
    for result in failed:
        short = _UNKNOWN_MM if result.value is None else abs(result.value - (result.limit or 0.0))
        why = _outcome(result)
        if (share := _SHARES.get(result.name)) is not None:
            over = (result.value or 1.0) / (result.limit or 1.0) if result.limit else 1.0
            corrections = corrections.updated(why, **{share: getattr(corrections, share) * _MARGIN / max(over, 1.0)})
        elif result.name == _GRAVITY_CHECK:
            more = corrections.torque_margin_N_m + (short if result.limit else 0.0) + TORQUE_MARGIN_N_M
            corrections = corrections.updated(why, torque_margin_N_m=more)
        elif result.name.startswith("structure") and candidate.design.panel is not None:
            per_mm = max(corrections.couple_per_mm, candidate.corrections.couple_per_mm)
            known = replace(corrections, couple_per_mm=per_mm)
            corrections = _levered(known, _index_min(candidate.design), candidate.side_mm, 1.0, why)
        elif result.name.startswith("structure"):
            corrections = _stiffer(corrections, _index_min(candidate.design), why)
        elif result.name in _REACHED:
            corrections = _chains_apart(candidate, corrections, _REACHED_STEP_MM, why, result.worst_pair or ())
        elif result.name == _APART:
            corrections = _chains_apart(candidate, corrections, short, why, result.worst_pair or ())
        elif result.name.startswith(_SOLID):
            if corrections.least("base_radius") == before.least("base_radius"):  # once a build
                corrections = _farther_out(corrections, candidate.lengths_mm, f"{result.name}: {result.detail}")
        elif result.name.startswith(("clearance", "running gap")) or result.name == "overlap on one link":
            pair = " beside ".join(sorted({_kind(name) for name in result.worst_pair or ()}))
            named = f", {pair}" if pair else ""
            why = f"{why}{named}"
            earlier = [line for line in corrections.why if line.startswith(f"{result.name}:") and line.endswith(named)]
            again = 2.0 ** min(len(earlier), _DOUBLINGS)
            if folds(result.worst_pair or ()):
                step = ELBOW_STEP_DEG
                if result.unit == "mm" and result.value is not None:
                    step = min(max((short + _PROVEN_MM) / _PARTED_MM, _ELBOW_LEAST_DEG), ELBOW_STEP_DEG)
                least = candidate.elbow_deg + step * again
                corrections = corrections.updated(why, elbow_angle_deg=max(least, corrections.elbow_angle_deg))
                continue
            length, step = apart_by(result.worst_pair or (), candidate.choice.placed)
            if result.unit == "mm" and result.value is not None:
                step = max(step, short)
            now = dict(zip(VARIABLES, candidate.lengths_mm, strict=False)) | candidate.radii_mm
            corrections = corrections.raised(length, now[length] + step * again, why)
    if failed and corrections == before:
        raise InconclusiveError("; ".join(f"{r.name} {r.detail or r.value}" for r in failed))
    return corrections


def _kind(name: str) -> str:
    """A part in words, whichever of the alike it is: "rod cup wrist" of rod_cup_0_1_wrist."""
    return " ".join(word for word in name.split("_") if not word.isdigit())


def _chains_apart(
    candidate: Candidate, corrections: Corrections, short_mm: float, why: str, pair: Sequence[str]
) -> Corrections:
    """Moves the chains apart by the shortfall of a candidate's base radius; of a placed machine the two it is about."""
    radii, (length, _) = candidate.radii_mm, apart_by(pair, candidate.choice.placed)
    if length in (SIDE_PAIR, REAR_PAIR):
        return corrections.raised(length, radii[length] + short_mm, why)
    return corrections.with_chains_apart(candidate.choice.width_mm, radii["base_radius"], short_mm, why)


def by_weight(check: str) -> bool:
    """Whether a check depends on masses, inertias and joint friction."""
    return check == _GRAVITY_CHECK or check in _SHARES


def _sides_mm(choice: Selection, corrections: Corrections, lengths_mm: Sequence[float]) -> tuple[float, float]:
    """What points and bars of a machine take along y and along x, mm; of a placed one its drives, too."""
    if choice.placed:
        along_y, along_x = placed_sides(completed(lengths_mm), choice.width_mm, corrections.reach)
        return float(max(along_y)), float(max(along_x))
    width, depth = Outline(0.0, 0.0, choice.width_mm).size_mm(*outline_arguments(lengths_mm))
    return float(width), float(depth)


def with_reach(choice: Selection, corrections: Corrections, design: Design) -> Corrections:
    """Learns how far a chain of a placed machine reaches, of which all but `_BEYOND_MM` of its outline follows.

    Returns:
        What is known now; the same of parts that have no dimensions, which a refusal tells.
    """
    from delta_cad.dimensions import dimensions

    try:
        d = dimensions(design)
    except DimensionError:
        return corrections
    inwards = d
    with suppress(DimensionError):
        inwards = dimensions(design, inwards=True)
    end = d.layers.motor_face_mm + d.motor.length_mm
    known, base = corrections.reach, d.bracket.shoulder_u_mm
    out, radius = inwards.bracket.motor_axis_mm[0] - base, d.motor.diameter_mm / 2.0
    points = [(out + side * radius, end) for side in (-1.0, 1.0)]
    points += [(out + u, end + behind) for leads in d.leads for u, behind in leads.outside_mm]
    half = choice.width_mm / 2.0
    elbow = (-half, d.forearm.cup_radius_mm), (half, d.forearm.cup_radius_mm), (0.0, d.arm.boss_radius_mm)
    found = ChainReach(elbow, tuple(points), base)
    if (c := d.capstan) is not None:
        clear, gaps, arm = design.requirements.clearance_min_mm, gaps_of(design.geometry), d.layers.arm_mm
        farther, at, nearest = (
            rim_y_mm(c.run, c.cable_diameter_mm, arm[1] - arm[0], base + more, clear, gaps)[0]
            for more in (-_NEARER_MM, 0.0, _FAR_MM)
        )
        found = replace(found, per_mm=(farther - at) / _NEARER_MM, nearest_mm=at - nearest)
    if known is not None:
        longer = found.longest_mm(base) - known.longest_mm(base)
        if -_SHORTER_MM <= longer.min() <= longer.max() <= _SAME_MM:
            return corrections
    found = replace(found, beyond_mm=(_BEYOND_MM, _BEYOND_MM) if known is None else known.beyond_mm)
    return corrections.updated(f"drives reach {end:.1f} mm along their shoulder axes", reach=found)


def with_outline(candidate: Candidate, corrections: Corrections, results: Iterable[CheckResult]) -> Corrections:
    """Learns what a machine takes beyond eq. (1) of its outline, more or less than was thought."""
    named = {result.name: result.value for result in results}
    width, depth = (named.get(f"envelope {way}") for way in ("width", "depth"))
    if width is None or depth is None:
        return corrections
    points = _sides_mm(candidate.choice, corrections, candidate.lengths_mm)
    ways = [
        tuple(size + MARGIN_MM - own for size, own in zip(sizes, points, strict=True))
        for sizes in ((width, depth), (depth, width))
    ]
    known = corrections.beyond_mm(candidate.choice.placed)
    over = min(ways, key=lambda way: max(abs(a - b) for a, b in zip(way, known, strict=True)))
    if max(abs(a - b) for a, b in zip(over, known, strict=True)) < MARGIN_MM:
        return corrections
    of = "eq. (1)" if known is corrections.overhead_mm else "what its chains reach"
    why = f"outline {width:.2f} x {depth:.2f} mm: {over[0]:.2f} and {over[1]:.2f} mm beyond {of}"
    return corrections.with_beyond(candidate.choice.placed, (over[0], over[1]), why)


def with_room(
    candidate: Candidate, corrections: Corrections, results: Iterable[CheckResult]
) -> tuple[Corrections, float]:
    """Learns how much less of a base radius keys need, where that is what it was made for.

    Returns:
        What is known, and by how much the base radius may be shorter, mm.
    """
    radius, width = candidate.radii_mm["base_radius"], candidate.choice.width_mm
    left = -min((one.value or 0.0 for one in results if one.name == _APART), default=0.0)
    requested = corrections.least_radius_mm(width)
    if left <= 0.0 or radius > requested + _UNKNOWN_MM or requested <= corrections.least("base_radius"):
        return corrections, 0.0
    return corrections.with_chains_apart(width, radius, -left, f"{_APART}: {left:.2f} mm more than keys need"), left


def with_least_radius(candidate: Candidate, corrections: Corrections) -> Corrections:
    """Learns how much less of a base radius closed forms would let a machine's hardware have.

    Returns:
        What is known now; nothing more where they ask for no base radius within `_LEFT_MM` of the machine's.
    """
    from delta_cad.structure.hardware.refusals import LEARNT, refusals

    design, width = candidate.design, candidate.choice.width_mm
    radius = candidate.radii_mm["base_radius"]

    def passes(shorter_mm: float) -> bool:
        mechanism, radii = design.mechanism, design.mechanism.base_radii_mm
        shorter = {
            "base_radius_mm": mechanism.base_radius_mm - shorter_mm,
            "base_radii_mm": radii and tuple(one - shorter_mm for one in radii),
        }
        nearer = mechanism.model_copy(update=shorter)
        reasons = refusals(design.model_copy(update={"mechanism": nearer}), LEARNT)
        return not any(reason.field == BASE for reason in reasons)

    if passes(_LEFT_MM):
        return corrections
    left, most = 0.0, _LEFT_MM
    while most - left > MARGIN_MM:
        middle = (left + most) / 2.0
        left, most = (middle, most) if passes(middle) else (left, middle)
    return corrections.with_chains_apart(
        width, radius, -most, f"closed forms ask for {radius - most:.2f} mm of base radius"
    )
