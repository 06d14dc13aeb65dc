"""The parts of every machine and what is bought besides, by kind: names, counts, numbers, links and materials."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from delta_cad import catalogue
from delta_cad.assembly.supplies import BAR_ADHESIVE, keys
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import END_MATERIAL, TUBE_ADHESIVE
from delta_cad.dimensions.joint import CUP_MATERIAL
from delta_cad.mechanism.placement import CHAINS, SIDES

PARTS = """
all          base_plate                       1          base_plate                  base
all          platform                         1          platform                    platform
all          handle_stem                      1          handle_stem                 platform
all          knob                             1          knob                        platform
feet         foot_?                           3          foot                        base
foot_screws  foot_screw_?                     3          screw_{foot}x*              base
sleeves      mount_sleeve_?                   {mounts}   mount_sleeve                base
bench        bench_plate                      1          bench_plate                 base
bench        bench_pad_?                      4          bench_pad                   base
bench        mount_screw_?                    {mounts}   screw_low-M5x{mount_mm}     base
panel        panel                            1          panel                       base
panel        boot                             1          boot                        base
panel        bezel                            1          bezel                       base
panel        bezel_screw_?                    {bezel}    screw_M3x{bezel_mm}         base
panel        boot_collar                      1          boot_collar                 platform
all          motor_cheek_{i}                  1          motor_cheek                 base
all          encoder_cheek_{i}                1          encoder_cheek               base
all          foot_block_{i}                   1          foot_block                  base
all          cheek_screw_{i}_m?               2          screw_M3x*                  base
all          cheek_screw_{i}_e?               2          screw_M3x*                  base
all          cheek_dowel_{i}_m?               2          dowel_3x*                   base
all          cheek_dowel_{i}_e?               2          dowel_3x*                   base
all          base_screw_{i}_?                 2          screw_M4x*                  base
all          base_dowel_{i}_?                 2          dowel_3x*                   base
all          upper_arm_{i}                    1          upper_arm                   upper_arm_{i}
all          shoulder_shaft_{i}               1          shoulder_shaft              upper_arm_{i}
all          cross_bar_{i}_elbow              1          cross_bar                   upper_arm_{i}
all          cross_bar_{i}_wrist              1          cross_bar                   platform
all          motor_{i}                        1          motor                       base
all          motor_screw_{i}_?                {motor}    screw_{motor_screw}x*      base
direct       stop_pin_{i}_?                   2          dowel_4x*                   base
direct       shoulder_clamp_{i}               1          screw_M3x*                  upper_arm_{i}
capstan      stop_pin_{i}_?                   1          dowel_4x*                   base
capstan      bearing_{i}_?                    2          bearing                     base
capstan      wave_spring_{i}                  1          wave_spring                 base
capstan      shoulder_washer_{i}              1          shoulder_washer             upper_arm_{i}
capstan      shoulder_screw_{i}               1          screw_{end}x*               upper_arm_{i}
capstan      pinion_{i}                       1          pinion                      pinion_{i}
capstan      sector_{i}                       1          sector                      upper_arm_{i}
capstan      sector_dowel_{i}_?               2          dowel_3x*                   upper_arm_{i}
capstan      set_screw_{i}_?                  2          set_screw_M3x*              pinion_{i}
capstan      capstan_cable_{i}_outer          1          capstan_cable               upper_arm_{i}
capstan      capstan_cable_{i}_inner          1          capstan_cable_inner         upper_arm_{i}
capstan      capstan_cable_{i}_outer_end      1          capstan_cable_outer_end     upper_arm_{i}
capstan      capstan_cable_{i}_inner_end      1          capstan_cable_inner_end     upper_arm_{i}
capstan      capstan_cable_{i}_turns          1          capstan_cable_turns         base
capstan      capstan_cable_{i}_strand_inner   1          capstan_cable_strand_inner  base
capstan      capstan_cable_{i}_strand_outer   1          capstan_cable_strand_outer  base
capstan      tension_carriage_{i}             1          tension_carriage            upper_arm_{i}
capstan      tension_screw_{i}                1          tension_screw_M3x*          upper_arm_{i}
capstan      crimp_sleeve_{i}_?               2          crimp_sleeve                upper_arm_{i}
sensor       encoder_magnet_{i}               1          encoder_magnet              upper_arm_{i}
sensor       encoder_board_{i}                1          encoder_board               base
sensor       board_spacer_{i}_?               {board}    board_spacer                base
sensor       board_screw_{i}_?                {board}    screw_M2.5x*                base
leads        motor_lead_{i}_?                 {phases}   motor_lead                  base
own_lead     encoder_lead_{i}_?               1          encoder_lead                base
sensor_lead  sensor_lead_{i}                  1          sensor_lead                 base
sensor_lead  lead_clip_{i}                    1          lead_clip                   base
all          joint_ball_{i}_{j}_elbow         1          joint_ball                  upper_arm_{i}
all          rod_cup_{i}_{j}_elbow            1          rod_cup                     rod_{i}_{j}
all          cup_shell_{i}_{j}_elbow          1          cup_shell                   rod_{i}_{j}
all          rod_tube_{i}_{j}                 1          rod_tube                    rod_{i}_{j}
all          rod_eye_{i}_{j}_?                2          rod_eye                     rod_{i}_{j}
all          rod_cup_{i}_{j}_wrist            1          rod_cup                     rod_{i}_{j}
all          cup_shell_{i}_{j}_wrist          1          cup_shell                   rod_{i}_{j}
all          joint_ball_{i}_{j}_wrist         1          joint_ball                  platform
all          rod_spring_{i}_{j}               1          rod_spring                  spring_{i}_{j}
"""
"""When, names (`?` for any letter), how many, part number (`*` for any length), link."""
MACHINED = {
    "base_plate": "aluminium-6082",
    "motor_cheek": "aluminium-6082",
    "encoder_cheek": "aluminium-6082",
    "foot_block": "aluminium-6082",
    "upper_arm": "aluminium-7075",
    "shoulder_shaft": "stainless-1.4305",
    "cross_bar": "aluminium-7075",
    "sector": "aluminium-7075",
    "pinion": "aluminium-7075",
    "tension_carriage": "brass",
    "rod_cup": END_MATERIAL,
    "cup_shell": CUP_MATERIAL,
    "rod_eye": "aluminium-6082",
    "platform": "aluminium-7075",
    "handle_stem": "aluminium-6082",
}
"""Number of a part that is made from plate or bar -> its material."""


@dataclass(frozen=True)
class ExpectedPart:
    """Patterns of names, and of the part number, of as many occurrences on a link."""

    names: str
    count: int
    number: str
    link: str


@dataclass(frozen=True)
class ExpectedSupply:
    """What must be bought besides: its number, how many, and a pattern of its order code."""

    number: str
    quantity: int
    order_code: str


def expected_parts(d: Dimensions) -> tuple[ExpectedPart, ...]:
    """Counts the parts of frame, shoulders, drives, sensors, rods, handle and panel of a design."""
    hardware = d.design.hardware
    bent = hardware.leads == "bent"
    when = {
        "all": True,
        "feet": hardware.mounting in ("feet", "both"),
        "foot_screws": hardware.mounting in ("feet", "both") and d.foot.stud_length_mm is None,
        "sleeves": hardware.mounting == "both",
        "bench": hardware.mounting == "plate",
        "panel": d.panel is not None,
        "direct": hardware.drive == "direct",
        "capstan": hardware.drive == "capstan",
        "sensor": hardware.encoder_at != "motor",
        "leads": bent,
        "own_lead": bent and hardware.encoder_at == "motor",
        "sensor_lead": bent and hardware.encoder_at != "motor",
    }
    values = {
        "foot": d.foot.thread,
        "mounts": len(d.base.mounts_mm),
        "mount_mm": 0.0 if d.bench is None else f"{d.bench.screw_mm:g}",
        "bezel": 0 if d.panel is None else len(d.panel.screw_places()),
        "bezel_mm": 0.0 if d.panel is None else f"{d.panel.screw_mm:g}",
        "motor": len(d.bracket.motor_screws_rad),
        "motor_screw": d.motor.mount_thread if d.motor.mount_thread.startswith("M2") else f"low-{d.motor.mount_thread}",
        "end": d.shaft.end_screw,
        "board": d.encoder.hole_count,
        "phases": 3 if d.motor.commutation == "brushless" else 2,
    }
    found = {}
    for condition, *columns in map(str.split, PARTS.strip().splitlines()):
        for i, j in product(CHAINS, SIDES) if when[condition] else ():
            names, count, number, link = (text.format(i=i, j=j, **values) for text in columns)
            found[names] = ExpectedPart(names, int(count), number, link)
    return tuple(found.values())


def expected_supplies(d: Dimensions) -> tuple[ExpectedSupply, ...]:
    """Counts cords, adhesives, grease, keys, and what holds the machine down."""
    tubes, bars = (catalogue.adhesive(name) for name in (TUBE_ADHESIVE, BAR_ADHESIVE))
    found = [
        ExpectedSupply("rod_cord", len(CHAINS) * len(SIDES), "braided polyethylene cord *"),
        ExpectedSupply("tube_adhesive", 1, f"{tubes.maker} {tubes.order_code}"),
        ExpectedSupply("bar_adhesive", 1, f"{bars.maker} {bars.order_code}"),
        ExpectedSupply("joint_grease", 1, "silicone or PAO grease*"),
        *(ExpectedSupply(key.number, 1, "hexagon key *") for key in keys(d)),
    ]
    if d.design.hardware.mounting not in ("feet", "plate"):
        found.append(ExpectedSupply("mount_screw", len(d.base.mounts_mm), "ISO 4762 M*"))
    if d.panel is not None:
        found.append(ExpectedSupply("boot_tie", 1, "cable tie *"))
    return tuple(found)
