"""The ball joints as machine elements: preload, clearance, stiffness, friction, and the rod force they hold.

An open cup is pressed from outside upon a ball on a stud along the shoulder axis by a spring across the pair of rods.
The preload is square to the rod and closes all play: no force that the joint holds finds a gap to move through.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, hypot, pi, sin, tan

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions.rules import require

CLEARANCE_MM = 0.0075  # radial, of the finished seat on its ball: 6.015 on 6
CLEARANCE_TOLERANCE_MM = 0.0025  # radial, either way: what ball and paste hold and a gauge tells
FRICTION_RANGE = (0.05, 0.08, 0.15)  # PEEK or POM with PTFE upon polished steel, least, nominal, largest
FRICTION = FRICTION_RANGE[1]
CUP_MATERIAL, BALL_MATERIAL = "peek-bearing", "steel"
EYE_MM = 0.8  # a spring's eye inside its rod's axis: holds the rod's turn about itself, see `return_N_mm`
PRELOAD_N = (8.0, 13.0)  # less lets a rod of 3 N at the handle slip, more is friction for nothing
PRELOAD_PER_N = 0.9  # by which the least grows with a larger force: 2 N in a rod per N, over tan(75 deg) less the lean
POISSON = 0.35  # of the plastic; of steel 0.3 changes the modulus of the pair by less than 1 %
SPRING_LEAN_MM = 1.0  # the eyes lie inside the rods' axes: so much longer the spring may become when the rods lean


@dataclass(frozen=True)
class JointDimensions:
    """What a ball joint bears, and how it yields and rubs.

    Attributes:
        spring_N: Force of one spring at no lean.
        preload_N: What presses the cup on its ball where that is less: at the elbow, as a rule.
        preload_max_N: What presses it at the other end.
        spring_max_N: Force of a spring at the largest lean, where the eyes are farthest apart.
        ball_radius_mm: Radius R of the ball.
        clearance_mm: Largest radial clearance c of the cup on its ball; no play, but the ball rolls in it.
        wrap_rad: Angle beta of the lip from the cup's axis.
        patch_radius_mm: Radius a of the contact under `preload_N`, as all that follows but the friction.
        pressure_N_mm2: Largest pressure in it.
        stiffness_axial_N_mm: Along the cup's axis, under the preload.
        stiffness_radial_N_mm: Square to it at rest, with the largest clearance.
        friction: Coefficient mu that the next two are stated for.
        friction_lean_N_mm: Torque of a ball that leans in its cup, `mu P R`, mean of both ends.
        friction_turn_N_mm: Torque of a ball that turns about the cup's axis, `3 pi mu P a / 16`.
        return_N_mm: Torque of a pair's two springs on the lean, per sine of the lean: the eyes lie inside the axes.
    """

    spring_N: float
    preload_N: float
    preload_max_N: float
    spring_max_N: float
    ball_radius_mm: float
    clearance_mm: float
    wrap_rad: float
    patch_radius_mm: float
    pressure_N_mm2: float
    stiffness_axial_N_mm: float
    stiffness_radial_N_mm: float
    friction: float
    friction_lean_N_mm: float
    friction_turn_N_mm: float
    return_N_mm: float

    def held_force_N(self, lean_rad: float) -> float:
        """Computes the rod force, tension or compression, at which the ball reaches the lip of its cup.

        Without friction, the contact lies where the sum of preload and rod force points: at beta from the cup's axis
        when `F = P (cos(lean) tan(beta) - sin(lean))`. The preload acts along the shoulder axis, from which the cup's
        axis leans; its part along the rod is added to the force.

        Args:
            lean_rad: Lean of the rod.

        Returns:
            Force, N.
        """
        return self.preload_N * (cos(lean_rad) * tan(self.wrap_rad) - sin(lean_rad))

    def yield_mm(self, force_N: float) -> float:
        """Computes how far a rod's end moves along the rod under a force: the ball rolls up its cup.

        The contact lies at `asin(F / sqrt(P^2 + F^2))` from the cup's axis, so that the centres, `c` apart, move by
        `c F / sqrt(P^2 + F^2)`. Elastic deformation is `stiffness_axial_N_mm`'s.

        Args:
            force_N: Rod force, N.

        Returns:
            Displacement, mm; below `clearance_mm` whatever the force.
        """
        return self.clearance_mm * force_N / hypot(self.preload_N, force_N)


def preload_range_N(force_N: float) -> tuple[float, float]:
    """Gives the least and the largest preload of a pair's springs for the largest force at the handle, N."""
    least = max(PRELOAD_N[0], PRELOAD_PER_N * force_N)
    return least, PRELOAD_N[1] / PRELOAD_N[0] * least


def chosen_spring(between_eyes_mm: float, eye_mm: float, force_N: float = 0.0) -> catalogue.TensionSpring:
    """Chooses the tension spring that gives a pair its preload at a distance of its eyes.

    Args:
        between_eyes_mm: Distance between the insides of the loops at no lean, mm.
        eye_mm: Distance of an eye from its rod's axis, mm, for the message.
        force_N: Largest force at the handle, N.

    Returns:
        Of those within their own length and the preload's bounds the one with the least force: friction goes with it.

    Raises:
        DimensionError: None is; the message names the nearest parallelogram width for which one is.
    """
    rows: Mapping[str, catalogue.TensionSpring] = catalogue.tension_spring.rows
    low, high = preload_range_N(force_N)

    def span(row: catalogue.TensionSpring) -> tuple[float, float]:
        shortest = row.free_length_mm + (low - row.initial_tension_N) / row.rate_N_mm
        longest = row.free_length_mm + (high - row.initial_tension_N) / row.rate_N_mm
        return shortest, min(longest, row.length_max_mm - SPRING_LEAN_MM)

    spans = {key: (a, b) for key, row in rows.items() for a, b in [span(row)] if a <= b}
    fitting = [rows[key] for key, (a, b) in spans.items() if a <= between_eyes_mm <= b]
    if not fitting:
        ends = [end + 2 * eye_mm for both in spans.values() for end in both]
        width = between_eyes_mm + 2 * eye_mm
        strongest = max(row.force_max_N for row in rows.values())
        require(
            bool(ends),
            "rod_spring",
            "force",
            f"force_N or peak_force_N = {force_N:g} must be at most {strongest / PRELOAD_PER_N:.3g} N: springs must "
            f"give {low:g} N, the catalogue's strongest {strongest:g}",
            "requirements.force_N",
            force_N,
            strongest / PRELOAD_PER_N,
        )
        ends = ends or [width]
        nearest = min(ends, key=lambda end: abs(end - width))
        bound = f"at least {nearest:.1f}" if nearest > width else f"at most {nearest:.1f}"
        require(
            False,
            "rod_spring",
            "length",
            f"parallelogram_width_mm = {width:g} must be {bound} mm for a spring of {low:g} to {high:g} N",
            "mechanism.parallelogram_width_mm",
            width,
            nearest,
        )
        return min(rows.values(), key=lambda row: abs(row.free_length_mm - between_eyes_mm))  # in a search of reasons
    return min(fitting, key=lambda row: row.force_N(between_eyes_mm))


def pair_N_mm2(cup: catalogue.MaterialData, ball: catalogue.MaterialData) -> float:
    """Computes the modulus of a contact of two materials, `1 / E* = sum (1 - nu^2) / E`, N/mm^2."""
    per_pascal = MM_PER_M**2  # N/mm^2 in Pa
    return 1.0 / sum((1.0 - POISSON**2) * per_pascal / row.youngs_modulus_Pa for row in (cup, ball))


def patch_radius_mm(ball_radius_mm: float, preload_N: float, pair_N_mm2: float) -> float:
    """Computes the radius of the contact of a ball in its cup, see `joint_dimensions`."""
    effective = ball_radius_mm * (ball_radius_mm + CLEARANCE_MM) / CLEARANCE_MM
    return (3.0 * preload_N * effective / (4.0 * pair_N_mm2)) ** (1.0 / 3.0)


def sliding_torques_N_mm(width_mm: float, ball_mm: float, force_N: float = 0.0) -> tuple[float, float]:
    """Computes the friction of a ball that leans in its cup and of one that turns about the cup's axis, nominal, N mm.

    The spring's whole force counts as preload: what one end of a rod has less the other has more.

    Args:
        width_mm: Distance of the two rods along the shoulder axis.
        ball_mm: Diameter of the balls.
        force_N: Largest force at the handle, which the springs are chosen for, N.
    """
    between, radius = width_mm - 2 * EYE_MM, ball_mm / 2
    pull = chosen_spring(between, EYE_MM, force_N).force_N(between)
    pair = pair_N_mm2(catalogue.material(CUP_MATERIAL), catalogue.material(BALL_MATERIAL))
    return FRICTION * pull * radius, 3.0 * pi / 16.0 * FRICTION * pull * patch_radius_mm(radius, pull, pair)


def joint_dimensions(
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
    """Computes preload, stiffness and friction of a ball joint.

    The contact is that of Hertz between a ball of radius R and a cup of radius R + c, of effective radius
    `R (R + c) / c` and modulus `1 / E* = (1 - nu^2) / E_1 + (1 - nu^2) / E_2`: `a^3 = 3 P R_e / (4 E*)`, largest
    pressure `3 P / (2 pi a^2)`, stiffness `2 a E*`. The patch is half the ball's radius wide: a is right within some
    10 %. Square to the axis the ball rolls up the cup: P / c in series with the stiffness of the contact.

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
        K. L. Johnson, Contact Mechanics, 1985, eqs. (4.22) to (4.24) and section 3.8 (torque of a turning contact).
    """
    radius, worst = ball_mm / 2, CLEARANCE_MM + CLEARANCE_TOLERANCE_MM

    def eyes(lean: float) -> float:
        return hypot(width_mm * cos(lean) - 2 * eye_mm, width_mm * sin(lean))

    pull = spring.force_N(eyes(0.0))
    preload = pull * (1.0 - abs(lever))
    pair = pair_N_mm2(cup, ball)
    patch = patch_radius_mm(radius, preload, pair)
    axial = 2.0 * patch * pair
    return JointDimensions(
        spring_N=pull,
        preload_N=preload,
        preload_max_N=pull * (1.0 + abs(lever)),
        spring_max_N=spring.force_N(eyes(lean_rad)),
        ball_radius_mm=radius,
        clearance_mm=worst,
        wrap_rad=wrap_rad,
        patch_radius_mm=patch,
        pressure_N_mm2=3.0 * preload / (2.0 * pi * patch**2),
        stiffness_axial_N_mm=axial,
        stiffness_radial_N_mm=1.0 / (worst / preload + 1.0 / axial),
        friction=FRICTION,
        friction_lean_N_mm=FRICTION * pull * radius,
        friction_turn_N_mm=3.0 * pi / 16.0 * FRICTION * preload * patch,
        return_N_mm=2.0 * pull * 2.0 * eye_mm * width_mm / eyes(0.0),
    )
