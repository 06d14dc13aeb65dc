"""How each made part is made, and of what: cut from metal, or printed; the same parts either way.

`hardware.process` says it of all that can be printed, `hardware.processes` of single parts. What is not in `PRINTABLE`
is cut anyway: it turns or slides in a fit of a hundredth, or bears what plastics creep under.
"""

from __future__ import annotations

from delta_cad import catalogue
from delta_cad.design.record import Hardware

CUT_FROM = {
    "base_plate": "aluminium-6082",
    "motor_cheek": "aluminium-6082",
    "encoder_cheek": "aluminium-6082",
    "foot_block": "aluminium-6082",
    "upper_arm": "aluminium-7075",
    "platform": "aluminium-7075",
    "rod_eye": "aluminium-6082",
}
"""Part number -> id of the material that it is cut from, of parts that may be printed instead."""
PRINTABLE = tuple(CUT_FROM)
NOT_WITH_CAPSTAN = ("motor_cheek", "encoder_cheek", "foot_block", "upper_arm")
"""Of these, what carries a capstan's bearings, or stands in the stack that its wave spring presses."""


def is_printed(hardware: Hardware, number: str) -> bool:
    """Decides whether a part is printed.

    Args:
        hardware: Of a design.
        number: Part number, any.
    """
    if number not in PRINTABLE or (hardware.drive == "capstan" and number in NOT_WITH_CAPSTAN):
        return False
    single = (hardware.processes or {}).get(number)
    return (single or hardware.process or "machined") == "printed"


def any_printed(hardware: Hardware) -> bool:
    """Decides whether any part is printed."""
    return any(is_printed(hardware, number) for number in PRINTABLE)


def material_of(hardware: Hardware, number: str) -> str:
    """Gives the id of the material of a part that may be printed."""
    return hardware.print_material_id if is_printed(hardware, number) else CUT_FROM[number]


def softer(hardware: Hardware, number: str) -> float:
    """Computes how many times softer a part's material is than what it is cut from otherwise, both as designs count."""
    chosen, cut = material_of(hardware, number), CUT_FROM[number]
    return catalogue.material(cut).design_modulus_Pa / catalogue.material(chosen).design_modulus_Pa


def process_fault(hardware: Hardware) -> tuple[str, str, str] | None:
    """Finds an entry that no part can be made by: field, value and what is allowed; None: there is none."""
    for number, process in (hardware.processes or {}).items():
        field = f"hardware.processes.{number}"
        if number not in PRINTABLE:
            return field, process, f"is no part that can be printed; these can: {', '.join(PRINTABLE)}"
        if process == "printed" and hardware.drive == "capstan" and number in NOT_WITH_CAPSTAN:
            return (
                field,
                process,
                "carries the capstan's bearings and is cut; with hardware.drive = direct it may be printed",
            )
    rows = {key: row for key, row in catalogue.material.rows.items() if row.process}
    if hardware.print_material_id not in rows:
        return "hardware.print_material", hardware.print_material_id, f"must be one of {', '.join(rows)}"
    return None
