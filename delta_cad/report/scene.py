"""What the page needs to move the machine: lengths, parts, how each leaves in the exploded view, cube, outline."""

from __future__ import annotations

from typing import Any

from delta_cad.common.units import G_PER_KG, MM_PER_M
from delta_cad.export.views.explode import exploded
from delta_cad.mechanism.placement import LinkPlacement
from delta_cad.report.fields import Handle
from delta_cad.report.subject import Subject, plain

DIGITS = 5  # of what is only looked at


def mechanism(placement: LinkPlacement, force_N: float, handle: Handle) -> dict[str, Any]:
    """Gathers what `assets/kinematics.js` takes, as JSON types: all doubles, so that its frames are the placement's."""
    g = placement.geometry
    inertia, friction, rubs = handle.inertia, handle.friction, None
    if friction is not None:
        rubs = {"drive_N_m": friction.drive, "upright_N": friction.upright, "level_N": friction.level}
    return plain(
        {
            "base_radius_mm": g.base_radius * MM_PER_M,
            "platform_radius_mm": g.platform_radius * MM_PER_M,
            "upper_arm_mm": g.upper_arm_length * MM_PER_M,
            "forearm_mm": g.forearm_length * MM_PER_M,
            "width_mm": placement.parallelogram_width_mm,
            "pinion_mm": placement.pinion_centre_mm,
            "ratio": placement.drive_ratio,
            "springs_mm": placement.springs_mm,
            "eye_inside_mm": placement.eye_inside_mm,
            "force_N": force_N,
            "inertia": {
                "carried_kg": inertia.carried_mass,
                "elbow_kg": inertia.elbow_mass,
                "cross_kg": inertia.cross_mass,
                "joint_kg_m2": inertia.joint_inertia,
            },
            "friction": rubs,
            "encoder_count_rad": handle.encoder_count_rad,
        }
    )


def scene(s: Subject, handle: Handle) -> dict[str, Any]:
    """Gathers the machine as JSON types, lengths in mm.

    Returns:
        `mechanism`; `parts`, what a person reads of each; `occurrences`, link, part and (3,) way in the exploded view
        of each; `home_mm`, `cube`, `outline`.
    """
    moves, numbers = exploded(s.assembly, s.meshes), {part.number: k for k, part in enumerate(s.assembly.parts)}
    return {
        "mechanism": mechanism(s.assembly.placement, s.design.requirements.force_N, handle),
        "parts": [
            {
                "number": part.piece_of or part.number,
                "description": part.description,
                "material": part.material.name,
                "make": part.make,
                "mass_g": plain(G_PER_KG * s.masses["parts"][part.number]["mass_kg"], 4),
            }
            for part in s.assembly.parts
        ],
        "occurrences": {
            o.name: [o.link, numbers[o.part.number], plain(moves[o.name], DIGITS)] for o in s.assembly.occurrences
        },
        "home_mm": plain(s.assembly.home_mm),
        "cube": {"bottom_mm": s.limits.bottom_height_mm, "half_mm": s.limits.half_side_mm},
        "outline": {"centre_mm": plain(s.stage.envelope_centre_mm), "size_mm": plain(s.stage.envelope_mm)},
    }
