"""Every part is made of what the design states, or ordered as it states, and weighs what it must."""

from __future__ import annotations

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.checks.report import CheckResult
from delta_cad.solids.part import Make, Part

SHARE = 1e-6  # by which a mass may differ from what is stated: roundings
KG_M3_PER_G_MM3 = 1e6
SHOWN = 8  # faults that a report names; their number is told


def check_makes(assembly: Assembly) -> CheckResult:
    """Holds material, order and mass of every part against what the design states of its number.

    Returns:
        `parts made as stated`: the number of faults, each named in the detail: a part of another material or density,
        made instead of bought, of another order code or standard, a piece of something else, of a mass that its maker
        does not state or that its volume does not have; a number of which nothing is stated.
    """
    stated = {make.number: make for make in assembly.makes}
    faults: list[tuple[str, str]] = []
    every = {id(o.part): o.part for o in assembly.occurrences}  # two of one number may differ
    for part in every.values():
        make = stated.get(part.number)
        told = ["nothing is stated of its number"] if make is None else _faults(part, make)
        faults += [(part.number, f"{part.number}: {text}") for text in told]
    detail = f"material, order and mass of {len(every)} kinds of parts"
    if faults:
        detail = f"{len(faults)} faults: {'; '.join(text for _, text in faults[:SHOWN])}; {detail}"
    names = tuple(dict.fromkeys(number for number, _ in faults[:SHOWN])) or None
    return CheckResult("parts made as stated", not faults, len(faults), 0, "", worst_pair=names, detail=detail)


def _faults(part: Part, make: Make) -> list[str]:
    """Says what of a part is not as it is stated."""
    material, faults = catalogue.material(make.material), []
    if part.material.name != material.description:
        faults.append(f"of {part.material.name}, stated is {material.description}")
    elif part.material.density_kg_m3 != material.density_kg_m3:
        density = part.material.density_kg_m3
        faults.append(f"its density is {density:g} kg/m^3, that of its material {material.density_kg_m3:g}")
    if part.make != make.make:
        faults.append(f"it is {'made' if part.make else 'bought'}, stated is {'made' if make.make else 'bought'}")
    if part.order_code != make.order_code:
        faults.append(f"ordered as {part.order_code or 'nothing'}, stated is {make.order_code or 'nothing'}")
    if part.standard != make.standard:
        faults.append(f"it follows {part.standard or 'no standard'}, stated is {make.standard or 'none'}")
    if part.piece_of != make.piece_of:
        faults.append(f"drawn as a piece of {part.piece_of or 'nothing'}, stated is {make.piece_of or 'nothing'}")
    volume_g = float(part.solid.Volume()) * material.density_kg_m3 / KG_M3_PER_G_MM3
    mass_g = volume_g if part.mass_g is None else part.mass_g
    least, most = (share * volume_g for share in make.fill) if make.mass_g is None else (make.mass_g, make.mass_g)
    if not least * (1.0 - SHARE) <= mass_g <= most * (1.0 + SHARE):
        faults.append(
            f"its mass is {mass_g:.4g} g, stated is {least:.4g}" + (f" to {most:.4g}" if most > least else "")
        )
    return faults
