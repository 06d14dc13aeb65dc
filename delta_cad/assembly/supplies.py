"""What is bought beside the parts that are placed: springs across the rods, cords in them, adhesives, grease."""

from __future__ import annotations

from math import pi

from delta_cad import catalogue
from delta_cad.assembly.exchange import CUT, KEYS_MM
from delta_cad.dimensions import Dimensions
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids.making import ordered
from delta_cad.solids.part import Supply

CORD_MM = 0.5
CORD_SLACK_MM = 1.0  # a ball leaves its cup at more than 2 mm: the cord keeps it in when a spring breaks, or at a blow
CORD_KNOTS_MM = 30.0
CORD_DENSITY_G_MM3 = 0.97e-3
TUBE_ADHESIVE, BAR_ADHESIVE = "araldite-2011", "loctite-638"
UNVERIFIED = "verified: no, from memory, check before ordering"


def supplies(d: Dimensions) -> tuple[Supply, ...]:
    """Lists springs, cords, adhesives and grease of a design; a pair of rods has a spring near either end."""
    f, each = d.forearm, len(CHAINS) * 2
    spring, ends = f.spring, each * len(SIDES)
    mass = spring.mass_g
    if mass is None:
        mass = pi**2 / 4 * spring.wire_mm**2 * spring.mean_diameter_mm * (spring.active_coils + 2) * 7.85e-3
    free = f.between_eyes_mm + CORD_SLACK_MM
    cord = free + CORD_KNOTS_MM
    bond, bar = catalogue.adhesive(TUBE_ADHESIVE), catalogue.adhesive(BAR_ADHESIVE)
    return (
        Supply(
            "rod_spring",
            f"{spring.description}: {f.joint.spring_N:.1f} N at {f.between_eyes_mm:g} mm between the eyes of two rods",
            each,
            "Spring wire",
            mass,
            **ordered(spring),
        ),
        Supply(
            "rod_cord",
            f"cord {CORD_MM:g} inside each spring, knotted in both eyes to {free:g} mm: {CORD_SLACK_MM:g} mm slack",
            each,
            "UHMW polyethylene",
            pi / 4 * CORD_MM**2 * cord * CORD_DENSITY_G_MM3,
            "",
            f"braided polyethylene cord {CORD_MM:g}, {cord:g} mm",
            f"fishing line of 20 kg or more; {UNVERIFIED}",
        ),
        Supply(
            "tube_adhesive",
            f"{bond.description}: {ends} spigots in their tubes, both sides sanded",
            1,
            "Epoxy",
            0.0,
            **ordered(bond),
        ),
        Supply(
            "bar_adhesive",
            f"{bar.description}: {ends} balls on their studs, {each} cross-bars in their bosses; with primer",
            1,
            "",
            0.0,
            **ordered(bar),
        ),
        Supply(
            "joint_grease",
            f"grease for plastic upon steel, a drop in each of {ends} cups",
            1,
            "",
            0.0,
            "",
            "silicone or PAO grease with PTFE",
            f"as makers of plastic bearings advise; {UNVERIFIED}",
        ),
        *_motor_key(d),
    )


def _motor_key(d: Dimensions) -> tuple[Supply, ...]:
    """The key that turns between the cheeks, where the motor's screws are; a direct drive's are reached otherwise."""
    flats = catalogue.screw(d.motor.mount_thread).socket_mm
    if d.capstan is None or flats not in KEYS_MM:
        return ()
    text = f"hexagon key {flats:g}, short leg cut to {CUT * KEYS_MM[flats][1]:.0f} mm, for the motors' screws"
    return (Supply("motor_key", text, 1, "", 0.0, "ISO 2936", f"hexagon key {flats:g}", "cut from a stock key"),)
