"""Hardware of a candidate: motor, ratio, sector, width of the parallelograms, and the derived values and price."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design, DesignError, design_from_dict, design_to_dict
from delta_cad.design.record import Hardware
from delta_cad.dimensions import dimensions
from delta_cad.drive.friction import coulomb_N_m
from delta_cad.drive.report import CAPSTAN_EFFICIENCY, DIRECT_EFFICIENCY
from delta_cad.export.shop.cost.bought import row_price
from delta_cad.mechanism import UnreachableError
from delta_cad.mechanism.placement import CHAINS
from delta_cad.structure.hardware.suggestion import suggestion
from delta_cad.structure.report import stiffness
from optimizer.problem.brief import DesignBrief
from optimizer.problem.variables import VARIABLES

_RATIOS = (3.0, 12.0)  # of a capstan: below, a pinion is as large as the sector; above, its rope bends too sharply
_RATIO_COUNT = 3  # ratios that are estimated first
PINION_MM = 7.8  # radius of a pinion on a shaft of 6 mm with a rope of 0.54 mm: 28 rope diameters to bend over
_SHAFT_MM = 6.0
SECTORS_MM = (28.0, 70.0)  # radius: below, no screws fit between shaft and rim; above, none was built
WIDTHS = (50.0, 36.0)  # mm, of parallelograms, the likeliest first: refining goes on from there
BASE_ENTRIES: Mapping[str, Any] = {"arm_thickness_mm": 5.0, "ball_diameter_mm": 6.0, "leads": "bent"}
"""What candidates begin with where nothing is stated: the least sizes, for loads may ask more; wires are drawn."""
SECTOR_ROOM_MM = 10.0  # see `delta_cad.dimensions.capstan.base_radius_min_mm`
SECTOR = "sector_radius_mm"
_RATIO_STEP, _WIDTH_STEP_MM, _WIDER_STEP_MM = (
    0.15,
    6.0,
    0.8,
)  # of a choice's neighbours: share of the ratio, width, pinion
SMALL = 3  # halvings from which on steps are small
TORQUE_DIGITS = 4  # decimals of a torque that a design states, N m
_MADE_EUR = {"capstan": 2145.0, "direct": 1606.0}
"""Drive -> made parts of one machine, but for what grows with its lengths: batches that must be set up anyway."""
_PRINTED_EUR = 800.0
"""The same of a direct drive of which all is printed that can be: what is still cut, and 100 EUR of prints."""
_MADE_EUR_mm2 = 0.94e-3
"""Of (R + L_A + L_B)^2: of machines of 272 and 479 mm, 2197 and 2343 EUR by their solids."""
_COUNTS = {"encoder": 3, "magnet": 3, "bearing": 6, "knob": 1, "foot": 3}
"""Entry of the hardware -> how many a machine has, of what is bought by the piece."""
_CAPSTAN_ONLY = ("bearing",)
_SHOULDER_ONLY = ("encoder", "magnet")
_ROPE_MM = 400.0  # about what a chain takes of rope
_REST_EUR = 110.0  # springs, balls, screws, dowels, adhesives
_STRONG = 0.8  # of the torque that a joint needs, from which on a motor may serve: lengths change
_COARSE = 5  # positions along an edge of the cube at which an alternative's stiffness is computed
_SIZED = ("upper_arm_length", "forearm_length", "base_radius")


@dataclass(frozen=True)
class Selection:
    """A selection of hardware: a candidate without its lengths.

    Attributes:
        motor: Id in the catalogue.
        drive: "capstan" or "direct".
        ratio: Turns of the motor per turn of the arm; 1 for a direct drive.
        width_mm: Width of the parallelograms.
        entries: Other entries of a design's hardware, by name.
        wider_mm: Of a pinion's radius beyond the least: a cable pulls the less at the motor's shaft.
        placed: Whether azimuths and base radii of the chains and the cube's place are free; else it is three-fold
            symmetric.
    """

    motor: str
    drive: str
    ratio: float
    width_mm: float
    entries: Mapping[str, Any] = field(default_factory=dict)
    wider_mm: float = 0.0
    placed: bool = False

    def with_(self, **changes: Any) -> Selection:
        """The same with other fields."""
        return replace(self, **changes)

    def with_entry(self, name: str, value: Any) -> Selection:
        """The same with another entry of the hardware."""
        return replace(self, entries={**self.entries, name: value})

    @property
    def base_radius_mm(self) -> float:
        """About the least base radius at which sectors pass one another, mm; refusals raise it."""
        return SECTOR_ROOM_MM + (PINION_MM + self.wider_mm) * self.ratio / 2.0 if self.drive == "capstan" else 0.0

    def hardware(self, row: catalogue.Motor) -> dict[str, Any]:
        """Gives the entries of a design's hardware; the size of the sector follows from the pinion."""
        entries: dict[str, Any] = {"motor": self.motor, "drive": self.drive}
        if self.drive == "capstan":
            pinion = PINION_MM + max(row.shaft_diameter_mm - _SHAFT_MM, 0.0) / 2 + self.wider_mm
            wanted = min(max(pinion * self.ratio, SECTORS_MM[0]), SECTORS_MM[1])
            entries |= {"capstan_ratio": self.ratio, SECTOR: round(wanted, 1)}
        return entries | dict(self.entries)

    def sector_mm(self, brief: DesignBrief) -> float:
        """Gives the radius of a capstan's sector: chosen or stated, else from pinion and ratio."""
        stated = self.stated(brief, SECTOR) if SECTOR in brief.hardware else None
        return float(stated or self.hardware(motor_of(brief, self.motor))[SECTOR])

    def count_deg(self, brief: DesignBrief) -> float:
        """Computes the turn of a joint for one count of its encoder, deg."""
        if self.stated(brief, "encoder_at") != "motor":
            row = catalogue.family("encoder", brief.own_parts)[self.stated(brief, "encoder")]
            return 360.0 / float(cast(catalogue.Encoder, row).counts_per_turn)
        counts = motor_of(brief, self.motor).encoder_counts_per_turn
        return 360.0 / (counts * self.ratio) if counts else 180.0

    def stated(self, brief: DesignBrief, entry: str) -> Any:
        """Gives an entry of the hardware: chosen, else the first of what the brief states, else its default."""
        rows = brief.choices.get(entry, ())
        return self.entries.get(entry, rows[0] if entry in brief.hardware and rows else default_of(entry))

    def peak_torque_N_m(self, row: catalogue.Motor) -> float:
        """Computes what a joint gives for a moment, N m."""
        efficiency = CAPSTAN_EFFICIENCY if self.drive == "capstan" else DIRECT_EFFICIENCY
        return self.ratio * efficiency * row.peak_torque_N_m

    def torque_N_m(self, row: catalogue.Motor) -> float:
        """Computes the continuous torque of a joint, rounded down to the digits of a design file, N m."""
        efficiency = CAPSTAN_EFFICIENCY if self.drive == "capstan" else DIRECT_EFFICIENCY
        digits = 10**TORQUE_DIGITS
        return int(self.ratio * efficiency * row.nominal_torque_N_m * digits) / digits


def neighbours(brief: DesignBrief, now: Selection, halved: int) -> list[Selection]:
    """Lists the hardware near by: another ratio and width of the parallelograms, or pinion, each by itself.

    Small steps leave the width as it is, for which solids told what room keys need, and go to other pinions instead,
    and to other ratios with the same sector.
    """
    step, wide, wider = (one / 2.0**halved for one in (_RATIO_STEP, _WIDTH_STEP_MM, _WIDER_STEP_MM))
    found: list[Selection] = []
    if brief.limits.parallelogram_width_mm is None and halved < SMALL:
        found += [now.with_(width_mm=now.width_mm + w) for w in (-wide, wide) if now.width_mm + w > 0.0]
    if now.drive == "capstan":
        low, high = ratios_of(brief)
        around = (round(min(max(now.ratio * factor, low), high), 2) for factor in (1.0 / (1.0 + step), 1.0 + step))
        ratios = [ratio for ratio in around if ratio != now.ratio]
        found += [now.with_(ratio=ratio) for ratio in ratios]
        if halved >= SMALL and SECTOR not in (*brief.hardware, *now.entries):
            same = [
                now.with_(ratio=ratio, wider_mm=(PINION_MM + now.wider_mm) * now.ratio / ratio - PINION_MM)
                for ratio in ratios
            ]
            others = [*same, *(now.with_(wider_mm=max(now.wider_mm + more, 0.0)) for more in (-wider, wider))]
            found += [one for one in others if one.wider_mm >= 0.0 and one != now]
    return found


def dominated(brief: DesignBrief, choice: Selection, failed: Iterable[Selection]) -> bool:
    """Decides whether hardware is dominated by hardware without lengths: no torque, rotor or count is better."""
    feel, own = brief.feel, motor_of(brief, choice.motor)
    for other in failed:
        row = motor_of(brief, other.motor)
        if (
            (choice.drive, choice.ratio, choice.width_mm) == (other.drive, other.ratio, other.width_mm)
            and row.nominal_torque_N_m >= own.nominal_torque_N_m
            and (feel.effective_mass_max_kg is None or row.rotor_inertia_kg_m2 <= own.rotor_inertia_kg_m2)
            and (feel.friction_max_N is None or coulomb_N_m(row, 1.0) <= coulomb_N_m(own, 1.0))
            and (feel.position_step_max_mm is None or other.count_deg(brief) <= choice.count_deg(brief))
        ):
            return True
    return False


def motor_of(brief: DesignBrief, motor: str) -> catalogue.Motor:
    """Finds the row of a motor that the brief allows."""
    return cast(catalogue.Motor, catalogue.family("motor", brief.own_parts)[motor])


def ratios_of(brief: DesignBrief) -> tuple[float, float]:
    """Gives the least and the largest ratio of a capstan that the brief allows."""
    stated = [float(v) for v in brief.choices.get("capstan_ratio", ())]
    return (min(stated), max(stated)) if stated else _RATIOS


def first_ratios(brief: DesignBrief, drive: str) -> list[float]:
    """Gives the ratios of a drive that are estimated first."""
    low, high = ratios_of(brief) if drive == "capstan" else (1.0, 1.0)
    return np.geomspace(low, high, _RATIO_COUNT + 2)[1:-1].round(2).tolist() if high > low else [low]


def widths_of(brief: DesignBrief) -> tuple[float, ...]:
    """Gives the widths of parallelograms that are estimated."""
    stated = brief.limits.parallelogram_width_mm
    return WIDTHS if stated is None else (stated,)


def unlikely(brief: DesignBrief, hardware: tuple[str, str]) -> float:
    """Orders motor and drive so that the first has lengths, from which the others begin: the lightest or strongest."""
    motor, drive = hardware
    row, (least, most) = motor_of(brief, motor), ratios_of(brief) if drive == "capstan" else (1.0, 1.0)
    if brief.feel.effective_mass_max_kg is None:
        return -row.nominal_torque_N_m * most
    return row.rotor_inertia_kg_m2 * least**2


def drives(brief: DesignBrief) -> Iterator[tuple[str, str]]:
    """Lists the pairs of motor and drive that the brief allows and the catalogue offers."""
    for motor in brief.choices["motor"]:
        for drive in brief.choices["drive"]:
            if drive in motor_of(brief, motor).drives:
                yield motor, drive


def default_of(entry: str) -> Any:
    """Gives the value that an entry of the hardware begins with where none is stated."""
    return BASE_ENTRIES.get(entry, Hardware.model_fields[entry].default)


def price_EUR(brief: DesignBrief, choice: Selection, lengths_mm: Sequence[float]) -> float:
    """Estimates the price of one machine of (6) lengths in the order of `VARIABLES`, EUR."""
    size, row = sum(lengths_mm[VARIABLES.index(name)] for name in _SIZED), motor_of(brief, choice.motor)
    motors = len(CHAINS) * row_price("motor", row).one_EUR
    if row.drive_board:
        motors += len(CHAINS) * row_price("drive_board", catalogue.drive_board(row.drive_board)).one_EUR
    bought = motors + _rows_EUR(brief, choice, lengths_mm) + _REST_EUR
    if choice.drive == "direct" and choice.stated(brief, "process") == "printed":
        return bought + _PRINTED_EUR
    return bought + _MADE_EUR[choice.drive] + _MADE_EUR_mm2 * size**2


def cheapest(brief: DesignBrief) -> Mapping[str, Any]:
    """Chooses the cheapest row of every entry of which the brief states several."""
    found = {}
    for entry in (*_COUNTS, "cable", "tube"):
        rows = brief.choices.get(entry, ())
        if entry in brief.hardware and len(rows) > 1:
            found[entry] = min(rows, key=lambda row, entry=entry: _row_EUR(brief, entry, row))
    return found


def _rows_EUR(brief: DesignBrief, choice: Selection, lengths_mm: Sequence[float]) -> float:
    """What is bought by rows of the catalogue other than the motors."""
    total, forearm = 0.0, lengths_mm[VARIABLES.index("forearm_length")]
    sensed = choice.stated(brief, "encoder_at") != "motor"
    for entry, count in _COUNTS.items():
        if (entry in _CAPSTAN_ONLY and choice.drive != "capstan") or (entry in _SHOULDER_ONLY and not sensed):
            continue
        total += count * _row_EUR(brief, entry, choice.stated(brief, entry))
    rope = len(CHAINS) * _ROPE_MM if choice.drive == "capstan" else 0.0
    for entry, length in (("tube", 2 * len(CHAINS) * forearm), ("cable", rope)):
        total += length / MM_PER_M * _row_EUR(brief, entry, choice.stated(brief, entry))
    return total


def _row_EUR(brief: DesignBrief, entry: str, row: str) -> float:
    return row_price(entry, cast(catalogue.CatalogueRow, catalogue.family(entry, brief.own_parts)[row])).one_EUR


def with_direct_drive(design: Design, row: catalogue.Motor) -> Design:
    """Makes a design with its motors on the shoulders' shafts, all else the same; its torques are that drive's.

    Raises:
        DesignError: The design file refuses it.
    """
    data, torque = design_to_dict(design), DIRECT_EFFICIENCY * row.nominal_torque_N_m
    kept = {
        name: value for name, value in data["hardware"].items() if name not in ("capstan_ratio", "sector_radius_mm")
    }
    data["hardware"] = kept | {"motor": row.id, "drive": "direct"}
    if row.encoder_counts_per_turn is None:
        data["hardware"].pop("encoder_at", None)
    data["requirements"] |= {"joint_torque_N_m": round(torque, TORQUE_DIGITS)}
    if "peak_torque_N_m" in data["requirements"]:
        data["requirements"]["peak_torque_N_m"] = round(DIRECT_EFFICIENCY * row.peak_torque_N_m, TORQUE_DIGITS)
    return design_from_dict(data, design.name)


def direct_alternative(brief: DesignBrief, design: Design) -> str:
    """States whether a direct drive would serve in place of a capstan: its price and stiffness, by closed forms.

    Of each motor for a direct drive the smallest change of the machine is searched with which every closed form passes;
    cube and requirements stay. The cheapest motor that serves is reported. Nothing is built.

    Args:
        brief: The requirements.
        design: The machine that was found.

    Returns:
        One sentence; "" where the machine has a direct drive.
    """
    if design.hardware.drive == "direct":
        return ""
    motors = catalogue.family("motor", brief.own_parts).values()
    rows, needed = [cast(catalogue.Motor, row) for row in motors], design.requirements.joint_torque_N_m
    strong = (row for row in rows if "direct" in row.drives and row.nominal_torque_N_m >= _STRONG * needed)
    for row in sorted(strong, key=lambda row: row_price("motor", row).one_EUR):
        try:
            other = suggestion(with_direct_drive(design, row))
        except (DesignError, UnreachableError):
            continue
        if other is None:
            continue
        machine, m = other.design, other.design.mechanism
        sizes = {"upper_arm_length": m.upper_arm_length_mm, "forearm_length": m.forearm_length_mm}
        sizes |= {"base_radius": m.base_radius_mm}
        choice = Selection(row.id, "direct", 1.0, m.parallelogram_width_mm)
        price = price_EUR(brief, choice, [sizes.get(name, 0.0) for name in VARIABLES])
        held = stiffness(dimensions(machine), _COARSE).least_N_mm
        changed = "".join(f", {field} {value:.4g}" for field, value in other.values.items() if isinstance(value, float))
        return (
            f"A direct drive is simpler and serves, too: with {row.id} about {price:.0f} EUR and {held:.3g} N/mm at "
            f"the knob, by closed forms, not built{changed}."
        )
    return "A direct drive does not serve: closed forms refuse every motor of the catalogue near these lengths."
