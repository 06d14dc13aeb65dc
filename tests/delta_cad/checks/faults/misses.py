"""Faults that no check refuses, and why that may be: each a pattern of names and a reason."""

from __future__ import annotations

from fnmatch import fnmatchcase

MISSES = {
    "*_dowel_*: shifted by 0.5 mm along z": "dowels are pressed in by hand, to no better than that along their axis",
    "stop_pin_*: shifted by 0.5 mm along z": "the pin still meets what it stops over more than is asked",
    "encoder_board*: turned half way about y": "its plug looks up instead of down: a matter of wiring",
    "encoder_board: mirrored along x": "its plug looks up instead of down: a matter of wiring",
    "*screw_*: turned a quarter about z": "a screw's socket stands as it was tightened",
    "shoulder_clamp_*: turned a quarter about z": "a screw's socket stands as it was tightened",
    "handle_stem: turned a quarter about z": "only the flats for a spanner turn, which may stand anyhow",
    "shoulder_shaft_*: turned a quarter about y": "only the flats for a spanner turn, which may stand anyhow",
    "sector: of another bearing": "only its collar is wider, on a ring that is no wider",
    "foot_block: sawn*": "short and thick: no bar of the structure's table lies in it, and what it is held by is whole",
    "boot_collar: shifted by 0.5 mm along z": "tied on the stem by hand, to no better than that",
    "lead_clip_*: shifted by 0.5 mm along z": "glued on by hand, to no better than that along its lead",
    "*_lead_[012]_*: shifted by 0.5 mm along [xz]": "put on its motor's back by hand, to no better than that",
    "motor_lead_*: turned half way about y": "bent outwards instead of inwards: outline and clearance hold, too",
    "motor_lead: mirrored along z": "bent outwards instead of inwards: outline and clearance hold, too",
    "mount_sleeve_*: shifted by 0.5 mm along [xy]": "slipped on its screw by hand, in which it has so much play",
    "board_spacer: sawn*": "pressed flat by its screw; the structure has no bar in it",
    "cross_bar: sawn half through at 0.5 of y": "in the middle of its boss, to which it is bonded on either side",
    "tension_carriage: sawn half through at 0.[35] of x": "a block in compression; the structure has no bar in it",
    "tension_carriage: mirrored along y": "the same carriage the other way up in its pocket",
    "rod_cup: sawn*": "the structure takes a cup's stiffness from finite elements and has no bar in it",
    "rod_eye: sawn half through at 0.[57] of z": "a ring bonded on its tube; the structure has no bar in it",
    "sector: sawn*": "the structure takes its web as a whole ring, and all that holds it is whole",
    "motor: of a larger pinion": "the same motor, its screw holes turned by less than the screws' clearance",
    "motor: of shorter forearms": "the same motor, its screw holes turned by less than the screws' clearance",
    "motor: of a wider platform": "the same motor, its screw holes turned by less than the screws' clearance",
    "capstan_cable_turns: of shorter forearms": "the same turns 5 um further along the pinion",
    "capstan_cable_turns: of a wider platform": "the same turns 10 um further along the pinion",
    "capstan_cable_strand_*: of shorter forearms": "the same strand 5 um further along the pinion",
    "capstan_cable_strand_*: of a wider platform": "the same strand 10 um further along the pinion",
    "platform: turned half way about x": "its webs lie below instead of above: as strong, and as free",
    "platform: mirrored along z": "its webs lie below instead of above: as strong, and as free",
    "direct-83/shoulder_shaft: sawn*": "a stub that carries a magnet and no load; the structure has no bar in it",
}
"""Pattern of a fault's name, of one machine alone after the machine's name -> why."""


def excuse(name: str, machine: str = "") -> str | None:
    """The pattern that a fault of this name may be missed by, of a machine; None where it may not."""
    return next((one for one in MISSES if fnmatchcase(name, one) or fnmatchcase(f"{machine}/{name}", one)), None)
