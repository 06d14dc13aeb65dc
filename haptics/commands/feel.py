"""`feel`: the feel sheet of a design, a page with maps."""

from __future__ import annotations

import argparse
import json

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, ProgressLine, refuse
from delta_cad.common.options import JSON, OUT_FOLDER
from haptics.commands.device import DEVICE_OPTIONS, LOOP_OPTIONS

NAME = "feel"
TEXT = "predict the feel over the cube: mass, friction, force, resolution, walls; writes OUT/NAME-feel"
OPTIONS = (*DEVICE_OPTIONS, *LOOP_OPTIONS, OUT_FOLDER, JSON)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code: 1 if the joints lack the design's force, or the default wall oscillates."""
    from delta_cad.common.files import require_room, whole_folder
    from delta_cad.mechanism import MechanismError
    from haptics.feel.loops import loop_sheet
    from haptics.feel.page import MAPS, feel_facts, feel_markdown, feel_text, map_values
    from haptics.feel.sheet import feel
    from haptics.feel.summary import QUANTITIES
    from haptics.loop.choice import chosen_loop
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.mass_properties, given.catalogue)
    loop = chosen_loop(machine.design, given.rate, given.damping, given.drive_damping)
    place = given.out / f"{machine.design.name}-feel"
    require_room(place, folder=True)
    try:
        with ProgressLine() as line:
            sheet = feel(machine, lambda m: loop_sheet(m, loop, line.show), line.show)
            facts = json.dumps(feel_facts(sheet), indent=1)
            from haptics.feel.pictures import feel_map, impedance, z_width
            from haptics.scenes.pictures import save

            line.show("maps")
            with whole_folder(place) as folder:
                (folder / "feel.json").write_text(facts + "\n", encoding="utf-8")
                (folder / "feel.md").write_text(feel_markdown(sheet), encoding="utf-8")
                for quantity in QUANTITIES:
                    if quantity.name in MAPS:
                        label = ", ".join(filter(None, (quantity.label, quantity.unit)))
                        title = f"{machine.design.name}: {quantity.label}"
                        figure = feel_map(title, label, *map_values(sheet, quantity), small=quantity.small)
                        save(figure, folder / f"{quantity.name}.png")
                for draw in (z_width, impedance):
                    save(draw(sheet.loop, machine.design.name), folder / f"{draw.__name__}.png")
    except MechanismError as error:
        return refuse(f"{given.design}: cube: {error}", BAD_INPUT)
    except ValueError as error:
        return refuse(f"{given.design}: {error}; a higher --rate, or --drive-damping, may bear one", BAD_INPUT)
    print(facts if given.json else feel_text(sheet))
    force, wanted = sheet.summaries["force_continuous"].worst[0], machine.design.requirements.force_N
    if force < wanted:
        return refuse(
            f"the joints give {force:.2f} N continuously in every direction, {wanted:g} N are required", NOT_MET
        )
    if sheet.loop.unstable_cases:
        says = ", ".join(f"{axis} with the {hand} hand" for axis, hand in sheet.loop.unstable_cases)
        return refuse(f"the default wall oscillates: {says}", NOT_MET)
    return DONE
