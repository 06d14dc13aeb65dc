"""What is bought beside the parts that are placed: cords in the springs across the rods, adhesives, grease."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from delta_cad import catalogue
from delta_cad.assembly.printing import inserts_of
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import SET_SCREW
from delta_cad.dimensions.forearm import TUBE_ADHESIVE
from delta_cad.dimensions.layers import KEYS_MM, LONG_MM, cut_key_mm
from delta_cad.dimensions.platform import MOUNT_SCREW
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids.bought_parts import CORD_MM, CORD_SLACK_MM, cord_mm
from delta_cad.solids.brackets import key_way_mm
from delta_cad.solids.making import ordered
from delta_cad.solids.part import Consumable, Part

BAR_ADHESIVE = "loctite-638"
_KEY_OUT_MM = 3.0  # of a key's bend beyond the cheeks' edge, at least
_CORD_SOURCE = (
    "a line of 20 kg or more; verified: yes: 2026-11-24, Dyneema breaks at 3000 to 4000 N/mm^2 "
    "(workshop.boardway.org/Kiteleinen-Unglaubliches-Material_1) and a knot leaves a quarter or more of it "
    "(rund-ums-tauwerk.de/info/faserkunde): 50 N of 20 kg, more than the spring that it replaces has"
)
_GREASE_SOURCE = (
    "verified: yes: 2026-11-24, silicones suit most plastics, synthetic hydrocarbons (PAO) all, PTFE helps at starts "
    "(machinedesign.com, ensuring plastic and lubricant compatibility; docslib.org/doc/7013340)"
)
_KEY_SOURCE = (
    "verified: yes: 2026-11-24, both legs in FsData/iso2936def.csv (github: shaise/FreeCAD_FastenersWB, commit "
    "ae90a86) and as JIS B 4648 gives them (mikipulley.co.jp, tech13)"
)


def supplies(d: Dimensions) -> tuple[Consumable, ...]:
    """Lists cords, adhesives and grease of a design; a cord is weighed with its spring."""
    each = len(CHAINS) * 2
    ends = each * len(SIDES)
    free, cord = cord_mm(d.forearm)
    bond, bar = catalogue.adhesive(TUBE_ADHESIVE), catalogue.adhesive(BAR_ADHESIVE)
    plastic = d.is_printed("upper_arm") or d.is_printed("platform")  # on which an anaerobic does not harden
    in_bosses = f", {each} cross-bars in their printed bosses" if plastic else ""
    by_bar = f"{ends} balls on their studs" + ("" if plastic else f", {each} cross-bars in their bosses")
    return (
        Consumable(
            "rod_cord",
            f"cord {CORD_MM:g} inside each spring, knotted in both eyes to {free:g} mm: {CORD_SLACK_MM:g} mm slack",
            each,
            "UHMW polyethylene",
            0.0,
            "",
            f"braided polyethylene cord {CORD_MM:g}, {cord:g} mm",
            _CORD_SOURCE,
        ),
        Consumable(
            "tube_adhesive",
            f"{bond.description}: {ends} spigots in their tubes, {ends} shells in their cups{in_bosses}, "
            "both sides sanded",
            1,
            "Epoxy",
            0.0,
            **ordered(bond),
        ),
        Consumable(
            "bar_adhesive",
            f"{bar.description}: {by_bar}; with primer",
            1,
            "",
            0.0,
            **ordered(bar),
        ),
        Consumable(
            "joint_grease",
            f"grease for plastic upon steel, a drop in each of {ends} cups",
            1,
            "",
            0.0,
            "",
            "silicone or PAO grease with PTFE",
            _GREASE_SOURCE,
        ),
        *drive_boards(d),
        *keys(d),
        *mounts(d),
    )


def drive_boards(d: Dimensions) -> tuple[Consumable, ...]:
    """Lists the drive boards that are bought with the motors; none where their row names none."""
    if not d.motor.drive_board:
        return ()
    row = catalogue.drive_board(d.motor.drive_board)
    return (Consumable("drive_board", row.description, len(CHAINS), "", 0.0, **ordered(row)),)


def inserts(parts: Iterable[tuple[Part, int]]) -> tuple[Consumable, ...]:
    """Lists the inserts of printed parts; they are weighed with the parts, as the plastic in whose place they are.

    Args:
        parts: Parts of a machine, each with its quantity.
    """
    counts = Counter[str]()
    for part, quantity in parts:
        for _, row in inserts_of(part):
            counts[row.id] += quantity
    rows = ((catalogue.insert(key), count) for key, count in sorted(counts.items()))
    return tuple(
        Consumable(f"insert_{row.thread}", row.description, count, "Brass", 0.0, **ordered(row)) for row, count in rows
    )


def keys(d: Dimensions) -> tuple[Consumable, ...]:
    """Lists keys that a common set has not: of motors' screws and of set screws, deep between the cheeks."""
    if d.capstan is None:
        return ()
    found = []
    flats = d.motor.mount_screw.socket_mm
    if flats in KEYS_MM:
        inside, handle = cut_key_mm(flats)
        text = f"hexagon key {flats:g}, legs cut to {inside:.0f} and {handle:.0f} mm, for the motors' screws"
        order, source = f"hexagon key {flats:g}", f"cut from a stock key; {_KEY_SOURCE}"
        found.append(Consumable("motor_key", text, 1, "", 0.0, "ISO 2936", order, source))
    flats = catalogue.set_screw(SET_SCREW).socket_mm
    if key_way_mm(d, d.capstan) - d.capstan.collar_radius_mm > KEYS_MM[flats][0] - _KEY_OUT_MM:
        text = f"hexagon key {flats:g}, long type of {LONG_MM[flats]:g} mm, for the pinions' set screws"
        order = f"hexagon key {flats:g}, long type"
        found.append(Consumable("pinion_key", text, 1, "", 0.0, "ISO 2936", order, f"stock key; {_KEY_SOURCE}"))
    return tuple(found)


def mounts(d: Dimensions) -> tuple[Consumable, ...]:
    """Lists what holds the base down and the boot on its stem."""
    found = []
    if d.is_screwed_down and d.bench is None:
        into = d.base.thickness_mm + d.sleeve_mm
        text = (
            f"screw {MOUNT_SCREW} from below into the base plate, as long as what it stands on and {into:g} mm at most"
        )
        row = ordered(catalogue.screw(MOUNT_SCREW))
        found.append(Consumable("mount_screw", text, len(d.base.mounts_mm), "", 0.0, **row))
    if d.panel is not None:
        text = "cable tie 2.5 around the boot's collar"
        found.append(Consumable("boot_tie", text, 1, "Polyamide", 0.0, "", "cable tie 2.5 x 100", "stock tie"))
    return tuple(found)
