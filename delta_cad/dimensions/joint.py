"""The ball joints as machine elements: preload, clearance, stiffness, friction, and the rod force they hold.

An open cup is pressed from outside upon a ball on a stud along the shoulder axis by a spring across the pair of rods.
The preload is square to the rod and closes all play: no force that the joint holds finds a gap to move through.

A rod ends in aluminium with a thin shell of plastic in its cup. A cup with its neck and spigot of solid PEEK gave 665
N/mm along the rod by finite elements, the joint with it 368; and the spring bends the spigot for ever, with 41 N/mm^2,
of which PEEK creeps. A thicker neck ends at the stud it leans beside, a 4 mm spigot asks for a 6x4 tube (12 g more on
the machine) and still bends. Of metal, end and spigot are ten times as stiff and do not creep, and the plastic that the
ball slides on is the same: friction, tilt and outside stay, mass grows by 8 g, and a shell is one more part to turn.
Bronze upon steel rubs twice as much; a rod end as bought has play.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, hypot, isfinite, sin
from typing import Any

import numpy as np

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.dimensions.rules import WIDTH, DimensionError, larger, require, smaller
from delta_cad.dimensions.sizes import largest_force_N
from delta_cad.drive import drive_friction_N_m, encoder_count_rad
from delta_cad.mechanism.limits import HandleFriction
from delta_cad.mechanism.proof.ball_friction import ball_friction

CLEARANCE_MM = 0.0075  # radial, of the finished seat on its ball: 6.015 on 6
CLEARANCE_TOLERANCE_MM = 0.0025  # radial, either way: what ball and paste hold and a gauge tells
FRICTION_RANGE = (0.05, 0.08, 0.15)  # PEEK or POM with PTFE upon polished steel, least, nominal, largest
FRICTION = FRICTION_RANGE[1]
CUP_MATERIAL, _BALL_MATERIAL = "peek-bearing", "steel"
LINER_MM = 0.6  # of the plastic shell in a cup: as thin as one turns it; the metal behind it is half of the cup's wall
POCKET_MM = 0.6  # diameter of the hole at the shell's pole: holds grease, keeps the ball off a cutter's centre
EYE_MM = 0.8  # a spring's eye inside its rod's axis: holds the rod's turn about itself
_PRELOAD_N = (8.0, 13.0)  # less lets a rod of 3 N at the handle slip, more is friction for nothing
_PRELOAD_PER_N = 1.05  # by which the least grows with a larger force: see `spring_range_N`
_LEAST_N = 1e-3  # a load below this rubs in an arm that no longer shrinks: nothing to speak of, and no division by 0
_MARGIN_RANGE = 8.0  # times the preload, within which the preload that a load needs is looked for
HALVINGS = 40
POISSON = 0.35  # of the plastic; of steel 0.3 changes the modulus of the pair by less than 1 %
SPRING_SHARE = 0.1  # of a spring's force by which it may be weaker than told: DIN 2097, grade 2
_SPRING_LEAN_MM = 1.0  # the eyes lie inside the rods' axes: so much longer the spring may become when the rods lean


@dataclass(frozen=True)
class JointDimensions:
    """What a ball joint bears, and how it yields; how it rubs is `sliding_torques_N_mm`.

    Attributes:
        spring_N: Force of one spring at no lean.
        preload_N: What presses the cup on its ball where that is less: at the elbow, as a rule.
        preload_max_N: What presses it at the other end.
        spring_max_N: Force of a spring at the largest lean, where the eyes are farthest apart.
        ball_radius_mm: Radius R of the ball.
        clearance_mm: Largest radial clearance c of the cup on its ball; no play, but the ball rolls in it.
        wrap_rad: Angle beta of the lip from the cup's axis.
        pair_N_mm2: Modulus of the contact, `1 / E* = sum (1 - nu^2) / E`.
        bed_N_mm3: Pressure that dents the plastic shell by 1 mm, held at its back and sides.
        stiffness_radial_N_mm: Square to the cup's axis at rest, pressed by `preload_N`, with the largest clearance; the
            cup's metal is left out.
    """

    spring_N: float
    preload_N: float
    preload_max_N: float
    spring_max_N: float
    ball_radius_mm: float
    clearance_mm: float
    wrap_rad: float
    pair_N_mm2: float
    bed_N_mm3: float
    stiffness_radial_N_mm: float

    @property
    def pressed_max_N(self) -> float:
        """What presses a ball most without a rod force: at the end nearer to the springs, at the largest lean, N."""
        return self.preload_max_N * self.spring_max_N / self.spring_N

    def edge_rad(self, force_N: np.ndarray, lean_rad: np.ndarray, preload_N: np.ndarray | None = None) -> np.ndarray:
        """Computes how far from its cup's axis the contact reaches under a rod force.

        The load on the ball, preload along the shoulder axis and rod force along the rod, points so far from the cup's
        axis, which leans by the lean; half the contact's angle is added, with the least clearance, which spreads it
        most, and away from the grease pocket. The sign of the force that is the worse of both is taken.

        Args:
            force_N: (...) rod force, tension or compression.
            lean_rad: (...) lean of the rod.
            preload_N: (...) preload; None: `preload_N` of the joint.

        Returns:
            (...) angle, rad; the ball holds while it is below `wrap_rad`.
        """
        preload = self.preload_N if preload_N is None else preload_N
        across = np.abs(force_N) + preload * np.abs(np.sin(lean_rad))
        along = preload * np.cos(lean_rad)
        load = np.hypot(across, along)
        clearance = self.clearance_mm - 2 * CLEARANCE_TOLERANCE_MM
        half = patch_angle_rad(self.ball_radius_mm, load, self.pair_N_mm2, self.bed_N_mm3, clearance)
        return np.arctan2(across, along) + half

    def margin_preload_N(self, force_N: np.ndarray, lean_rad: np.ndarray) -> np.ndarray:
        """Computes by how much the preload exceeds that with which the contact would reach the lip, (...) N.

        Args:
            force_N: (...) rod force, tension or compression.
            lean_rad: (...) lean of the rod.

        Returns:
            (...) preload left; negative where more is needed than there is, down to `1 - SPARE_RANGE` times it.
        """
        low = np.zeros(np.broadcast_shapes(np.shape(force_N), np.shape(lean_rad)))
        high = np.full_like(low, _MARGIN_RANGE * self.preload_N)
        for _ in range(HALVINGS):
            middle = (low + high) / 2.0
            holds = self.edge_rad(force_N, lean_rad, middle) <= self.wrap_rad
            low, high = np.where(holds, low, middle), np.where(holds, middle, high)
        return self.preload_N - high


def spring_range_N(force_N: float) -> tuple[float, float]:
    """Gives the least and the largest preload of a pair's springs for the largest force at the handle, N.

    A rod takes some 2 N per N, which its cup of 86 degrees holds up to a lean of 28 degrees with 0.9 N; what the handle
    itself weighs, 0.3 kg beside 10 N in the machine of a 150 mm cube, makes it 1.05.
    """
    least = max(_PRELOAD_N[0], _PRELOAD_PER_N * force_N)
    return least, _PRELOAD_N[1] / _PRELOAD_N[0] * least


def force_most_N() -> float:
    """Gives the largest force at the handle for which the catalogue has a spring that is strong enough, N."""
    rows: Mapping[str, catalogue.TensionSpring] = catalogue.tension_spring.rows
    return max(row.force_N(row.length_max_mm - _SPRING_LEAN_MM) for row in rows.values()) / _PRELOAD_PER_N


def chosen_spring(between_eyes_mm: float, eye_mm: float, force_N: float = 0.0) -> catalogue.TensionSpring:
    """Chooses the tension spring that gives a pair its preload at a distance of its eyes.

    Args:
        between_eyes_mm: Distance between the insides of the loops at no lean, mm.
        eye_mm: Distance of an eye from its rod's axis, mm, for the message.
        force_N: Largest force at the handle, N.

    Returns:
        Of those within their own length and the preload's bounds the one with the least force: friction goes with it.

    Raises:
        DimensionError: None is.
    """
    rows: Mapping[str, catalogue.TensionSpring] = catalogue.tension_spring.rows
    low, high = spring_range_N(force_N)

    def span(row: catalogue.TensionSpring) -> tuple[float, float]:
        shortest = row.free_length_mm + (low - row.initial_tension_N) / row.rate_N_mm
        longest = row.free_length_mm + (high - row.initial_tension_N) / row.rate_N_mm
        return shortest, min(longest, row.length_max_mm - _SPRING_LEAN_MM)

    spans = {key: (a, b) for key, row in rows.items() for a, b in [span(row)] if a <= b}
    fitting = [rows[key] for key, (a, b) in spans.items() if a <= between_eyes_mm <= b]
    if not fitting:
        ends = [end + 2 * eye_mm for both in spans.values() for end in both]
        width = between_eyes_mm + 2 * eye_mm
        most = force_most_N()
        require(
            bool(ends),
            "rod_spring",
            "force",
            f"for {force_N:g} N at the handle springs must give {low:g} N, the catalogue's strongest give "
            f"{most * _PRELOAD_PER_N:.3g}",
            smaller("requirements.force_N"),
        )
        ends = ends or [width]
        forces = "requirements.peak_force_N", "requirements.force_N"
        require(
            False,
            "rod_spring",
            "length",
            f"at a width of {width:g} mm the catalogue has no spring of {low:g} to {high:g} N",
            larger(WIDTH),
            smaller(WIDTH),
            *map(smaller, forces),
            smaller(*forces),
        )
        return min(rows.values(), key=lambda row: abs(row.free_length_mm - between_eyes_mm))  # in a search of reasons
    return min(fitting, key=lambda row: row.force_N(between_eyes_mm))


def _pair_N_mm2(cup: catalogue.MaterialData, ball: catalogue.MaterialData) -> float:
    """Computes the modulus of a contact of two materials, `1 / E* = sum (1 - nu^2) / E`, N/mm^2."""
    per_pascal = MM_PER_M**2  # N/mm^2 in Pa
    return 1.0 / sum((1.0 - POISSON**2) * per_pascal / row.youngs_modulus_Pa for row in (cup, ball))


def _bed_N_mm3(liner: catalogue.MaterialData) -> float:
    """Computes the pressure that dents the plastic shell of a cup by 1 mm, N/mm^3.

    Source:
        K. L. Johnson, Contact Mechanics, section 5.8, a layer bonded to a rigid base and wide against its thickness h:
        `(1 - nu) E / ((1 + nu) (1 - 2 nu) h)`.
    """
    young = liner.youngs_modulus_Pa / MM_PER_M**2
    return (1.0 - POISSON) * young / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON) * LINER_MM)


def _hertz_radius_mm(ball_radius_mm: float, load_N: float, pair_N_mm2: float, clearance_mm: float) -> float:
    """Computes the radius of the contact of a ball in a whole cup, a plastic as thick as one likes, mm."""
    effective = ball_radius_mm * (ball_radius_mm + clearance_mm) / clearance_mm
    return (3.0 * load_N * effective / (4.0 * pair_N_mm2)) ** (1.0 / 3.0)


def patch_angle_rad(
    ball_radius_mm: float, load_N: np.ndarray, pair_N_mm2: float, bed_N_mm3: float, clearance_mm: float
) -> np.ndarray:
    """Computes half the angle of the contact of a ball in a whole cup, seen from its centre.

    Args:
        ball_radius_mm: Radius R of the ball.
        load_N: (...) what presses it.
        pair_N_mm2: Modulus E* of the contact.
        bed_N_mm3: Pressure K that dents the plastic by 1 mm.
        clearance_mm: Radial clearance c.

    Returns:
        (...) rad. Of Hertz's contact, whose plastic is thick, and that of a thin layer,
        `load = pi K R^2 c angle^4 / 4`, the smaller: either leaves out something that stiffens.
    """
    load = np.maximum(load_N, 0.0)
    thin = (4.0 * load / (np.pi * bed_N_mm3 * ball_radius_mm**2 * clearance_mm)) ** 0.25
    effective = ball_radius_mm * (ball_radius_mm + clearance_mm) / clearance_mm
    thick = (3.0 * load * effective / (4.0 * pair_N_mm2)) ** (1.0 / 3.0) / ball_radius_mm
    return np.minimum(thin, np.arcsin(np.minimum(thick, 1.0)))


def _turning_arm_mm(whole_mm: np.ndarray) -> np.ndarray:
    """Computes the mean radius at which a ball that turns about its cup's axis rubs, mm.

    Args:
        whole_mm: (...) radius of the contact that the load would have in a cup without pocket.

    Returns:
        (...) arm of the friction, mm.

    Source:
        Hertz's pressure outside the pocket, `a^2 = a_whole^2 + a_pocket^2`, times the radius; without pocket
        `3 pi a / 16` (Johnson, Contact Mechanics, section 3.8).
    """
    outer = np.hypot(whole_mm, POCKET_MM / 2)
    q = POCKET_MM / 2 / outer
    return 3.0 * outer**4 / (8.0 * whole_mm**3) * (np.arccos(q) + q * np.sqrt(1.0 - q**2) * (1.0 - 2.0 * q**2))


def sliding_torques_N_mm(ball_mm: float, load_N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Computes the friction of balls that lean in their cups and that turn about the cups' axes, nominal coefficient.

    Args:
        ball_mm: Diameter of the balls.
        load_N: (...) what presses a ball in its cup: preload and rod force together.

    Returns:
        lean: (...) `mu N R`, N mm.
        turn: (...) `mu N` times `_turning_arm_mm`, N mm.
    """
    load, radius = np.asarray(load_N, dtype=float), ball_mm / 2
    pair = _pair_N_mm2(catalogue.material(CUP_MATERIAL), catalogue.material(_BALL_MATERIAL))
    effective = radius * (radius + CLEARANCE_MM) / CLEARANCE_MM
    whole = np.cbrt(3.0 * np.maximum(load, _LEAST_N) * effective / (4.0 * pair))
    return FRICTION * load * radius, FRICTION * load * _turning_arm_mm(whole)


def preload_N(width_mm: float, force_N: float = 0.0) -> float:
    """Computes what the spring across a pair of rods presses each of its balls with, N; both ends alike.

    Args:
        width_mm: Distance of the two rods along the shoulder axis.
        force_N: Largest force at the handle, which the spring is chosen for, N.
    """
    between = width_mm - 2 * EYE_MM
    return chosen_spring(between, EYE_MM, force_N).force_N(between)


def ball_preload_N(design: Design) -> float:
    """Computes what presses each ball of a design's rods in its cup while the handle bears nothing, N."""
    return preload_N(design.mechanism.parallelogram_width_mm, largest_force_N(design.requirements))


def known_joints(design: Design, *, friction: bool = True) -> dict[str, Any]:
    """Gathers what limits on the feel need to know of a design's joints, coefficients of friction nominal.

    Args:
        design: The design.
        friction: Whether that is bounded over the cube, which takes a quarter of a second.

    Returns:
        `friction`: what rubs, the ball joints bounded over the cube under their preload alone; None where no spring
        fits, the cube is out of reach, or it is not asked for. `encoder_count`: turn of a joint for one count of its
        encoder, rad.
    """
    known: dict[str, Any] = {"friction": None, "encoder_count": encoder_count_rad(design)}
    if not friction:
        return known
    try:
        preload = ball_preload_N(design)
    except DimensionError:
        return known
    torques = sliding_torques_N_mm(design.hardware.ball_diameter_mm, np.array(preload))
    lean, turn = (2.0 * float(torque) / MM_PER_M for torque in torques)  # both rods of a chain
    upright, level = ball_friction(design.geometry, design.workspace, lean, turn)
    if isfinite(upright + level):
        known["friction"] = HandleFriction(drive_friction_N_m(design)[1], upright, level)
    return known


def limit_values(design: Design, masses: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Gathers what every limit of a design is made from, by whatever command.

    Args:
        design: The design.
        masses: What is known of them, as `known_masses` gives it; None: nothing.

    Returns:
        Fields of its requirements, `known_joints`, and `inertia` and `held_masses`, None where they are not known.
    """
    unknown = {"inertia": None, "held_masses": None}
    return design.requirements.model_dump() | known_joints(design) | unknown | dict(masses or {})


def joint_dimensions(
    *,
    ball_mm: float,
    wrap_rad: float,
    spring: catalogue.TensionSpring,
    width_mm: float,
    eye_mm: float,
    lever: float,
    lean_rad: float,
    cup: catalogue.MaterialData,
    ball: catalogue.MaterialData,
) -> JointDimensions:
    """Computes preload and stiffness of a ball joint.

    The contact is that of Hertz between a ball of radius R and a cup of radius R + c, of effective radius
    `R_e = R (R + c) / c` and modulus E*, without what its pressure would bear on the grease pocket of radius a_p: the
    whole one's radius a_w, `a_w^3 = 3 P R_e / (4 E*)`, becomes `a^2 = a_w^2 + a_p^2`. Square to the axis the ball rolls
    up the cup, which tilts the pressure as it does under a flat stamp: `4 E* a^3 / (3 R^2)` less the pocket's share,
    `(4 E* / (3 R^2)) a_w (a^2 + a_p^2 / 2)`; without pocket that is P / c. Finite elements of the cup with its shell
    find this within 5 % where the shell is half as thick as the contact is wide.

    Args:
        ball_mm: Diameter of the ball.
        wrap_rad: Angle of the lip from the cup's axis.
        spring: The pair's springs.
        width_mm: Distance of the two rods along the shoulder axis.
        eye_mm: Distance of the springs' eyes from the rods' axes, inwards.
        lever: Sum of both eyes' distances from the elbow as a share of the rod's length, less 1: 0 where they press
            both cups alike.
        lean_rad: Largest lean.
        cup: Material of the cup.
        ball: Material of the ball.

    Returns:
        The joint.

    Source:
        K. L. Johnson, Contact Mechanics, 1985, eqs. (4.22) to (4.24), section 5.3 (tilted stamp) and section 3.8
        (torque of a turning contact). The pocket is our own: pressures beside it as if it were not there.
    """
    radius, worst = ball_mm / 2, CLEARANCE_MM + CLEARANCE_TOLERANCE_MM

    def eyes(lean: float) -> float:
        return hypot(width_mm * cos(lean) - 2 * eye_mm, width_mm * sin(lean))

    pull = spring.force_N(eyes(0.0))
    preload = pull * (1.0 - abs(lever))
    pair = _pair_N_mm2(cup, ball)
    widest, pocket = _hertz_radius_mm(radius, preload, pair, worst), POCKET_MM / 2
    return JointDimensions(
        spring_N=pull,
        preload_N=preload,
        preload_max_N=pull * (1.0 + abs(lever)),
        spring_max_N=spring.force_N(eyes(lean_rad)),
        ball_radius_mm=radius,
        clearance_mm=worst,
        wrap_rad=wrap_rad,
        pair_N_mm2=pair,
        bed_N_mm3=_bed_N_mm3(cup),
        stiffness_radial_N_mm=4.0 * pair / (3.0 * radius**2) * widest * (widest**2 + 1.5 * pocket**2),
    )
