"""One record per family of bought parts and materials; the CSV columns are the fields.

Every length is in mm and every mass in g, as the field names say. `verified` is honest about where a row stands:
"yes: <where>" when all of it was confirmed, "partly: <what and where>; <the rest> no, from memory, check before
ordering", or "no, from memory, check before ordering".
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """What every row of the catalogue says.

    Attributes:
        id: Key in the design file, unique in its family, lower case.
        standard: Standard the part follows ("ISO 4762") or "".
        maker: Maker, or "any" for standard parts.
        order_code: What to order.
        description: One line for the bill of materials.
        source: Datasheet, catalogue or table the numbers come from.
        verified: "yes: ...", "partly: ..." or "no, ...".
    """

    id: str
    standard: str
    maker: str
    order_code: str
    description: str
    source: str
    verified: str


@dataclass(frozen=True)
class Motor(Row):
    """A motor with its mounting face at the front.

    Attributes:
        drives: Drive kinds it may be used with: "capstan", "direct".
        commutation: "brushed" or "brushless".
        diameter_mm: Body diameter.
        length_mm: Body length behind the mounting face.
        shaft_diameter_mm: Shaft diameter.
        shaft_length_mm: Shaft length in front of the mounting face.
        pilot_diameter_mm: Centring spigot diameter.
        pilot_height_mm: Centring spigot height.
        mount_thread: Thread of the mounting holes ("M3"), a size of the screws family.
        mount_circle_mm: Pitch circle diameter of the mounting holes.
        mount_count: Number of mounting holes, equally spaced.
        mass_g: Mass.
        nominal_voltage_V: Voltage of the stall and no-load figures.
        nominal_torque_N_m: Torque it can hold for ever at 25 C ambient (thermal limit).
        stall_torque_N_m: Torque at standstill on the nominal voltage; seconds only.
        peak_torque_N_m: Torque we allow for a short time; see `peak_reason`.
        peak_time_s: How long the peak may last.
        peak_reason: Why the peak is allowed.
        rotor_inertia_kg_m2: Rotor inertia.
        torque_constant_N_m_A: Torque per ampere (between phases for brushless motors).
        resistance_ohm: Terminal resistance (between phases for brushless motors) at 25 C.
        thermal_resistance_winding_housing_K_W: Or None when unknown.
        thermal_resistance_housing_ambient_K_W: Or None when unknown.
        thermal_time_constant_winding_s: Or None when unknown.
        max_winding_temperature_C: Or None when unknown.
    """

    drives: tuple[str, ...]
    commutation: str
    diameter_mm: float
    length_mm: float
    shaft_diameter_mm: float
    shaft_length_mm: float
    pilot_diameter_mm: float
    pilot_height_mm: float
    mount_thread: str
    mount_circle_mm: float
    mount_count: int
    mass_g: float
    nominal_voltage_V: float
    nominal_torque_N_m: float
    stall_torque_N_m: float
    peak_torque_N_m: float
    peak_time_s: float
    peak_reason: str
    rotor_inertia_kg_m2: float
    torque_constant_N_m_A: float
    resistance_ohm: float
    thermal_resistance_winding_housing_K_W: float | None
    thermal_resistance_housing_ambient_K_W: float | None
    thermal_time_constant_winding_s: float | None
    max_winding_temperature_C: float | None


@dataclass(frozen=True)
class Bearing(Row):
    """A deep groove ball bearing.

    Attributes:
        bore_mm: Bore of the inner ring.
        outer_mm: Outside diameter.
        width_mm: Width.
        inner_ring_outer_mm: Outside diameter of the inner ring's shoulder: a washer that touches only the inner ring
            stays below it.
        outer_ring_inner_mm: Inside diameter of the outer ring's shoulder.
        shaft_shoulder_min_mm: Smallest diameter of the shaft's abutment.
        housing_shoulder_max_mm: Largest bore of the housing's abutment.
        fillet_max_mm: Largest fillet of shaft and housing at the seat.
        mass_g: Mass.
        static_load_N: Basic static load rating C0.
        dynamic_load_N: Basic dynamic load rating C.
    """

    bore_mm: float
    outer_mm: float
    width_mm: float
    inner_ring_outer_mm: float
    outer_ring_inner_mm: float
    shaft_shoulder_min_mm: float
    housing_shoulder_max_mm: float
    fillet_max_mm: float
    mass_g: float
    static_load_N: float
    dynamic_load_N: float


@dataclass(frozen=True)
class Encoder(Row):
    """A magnetic angle sensor on a small board; the chip sits in the board's centre, over the shaft's magnet.

    Attributes:
        board_length_mm: Longer side of the board.
        board_width_mm: Shorter side.
        board_thickness_mm: Thickness of the bare board.
        chip_height_mm: Height of the chip over the board.
        hole_diameter_mm: Mounting hole.
        hole_spacing_length_mm: Hole pattern along the longer side.
        hole_spacing_width_mm: Hole pattern along the shorter side.
        hole_count: Number of mounting holes.
        magnet: Id of the magnet it is meant for.
        air_gap_min_mm: Smallest distance from chip to magnet.
        air_gap_max_mm: Largest distance.
        centring_mm: Largest offset of the magnet's axis from the chip's centre.
        counts_per_turn: Resolution.
        mass_g: Mass.
    """

    board_length_mm: float
    board_width_mm: float
    board_thickness_mm: float
    chip_height_mm: float
    hole_diameter_mm: float
    hole_spacing_length_mm: float
    hole_spacing_width_mm: float
    hole_count: int
    magnet: str
    air_gap_min_mm: float
    air_gap_max_mm: float
    centring_mm: float
    counts_per_turn: int
    mass_g: float


@dataclass(frozen=True)
class Screw(Row):
    """A hexagon socket head cap screw, with the holes that go with it.

    Attributes:
        diameter_mm: Thread diameter.
        pitch_mm: Coarse pitch.
        head_diameter_mm: Plain head, nominal (largest of a plain head).
        head_height_mm: Head height.
        socket_mm: Key size across flats.
        socket_depth_mm: Least depth of the socket.
        clearance_hole_mm: ISO 273 medium.
        counterbore_diameter_mm: Counterbore for the head.
        counterbore_depth_mm: Depth that buries the head.
        tap_drill_mm: Drill for the thread.
        lengths_mm: Stock lengths, ascending.
    """

    diameter_mm: float
    pitch_mm: float
    head_diameter_mm: float
    head_height_mm: float
    socket_mm: float
    socket_depth_mm: float
    clearance_hole_mm: float
    counterbore_diameter_mm: float
    counterbore_depth_mm: float
    tap_drill_mm: float
    lengths_mm: tuple[float, ...]


@dataclass(frozen=True)
class HexScrew(Row):
    """A hexagon head screw threaded to the head.

    Attributes:
        diameter_mm: Thread diameter.
        pitch_mm: Coarse pitch.
        across_flats_mm: Width across flats of the head.
        head_height_mm: Head height.
        tap_drill_mm: Drill for the thread.
        lengths_mm: Stock lengths, ascending.
    """

    diameter_mm: float
    pitch_mm: float
    across_flats_mm: float
    head_height_mm: float
    tap_drill_mm: float
    lengths_mm: tuple[float, ...]


@dataclass(frozen=True)
class HexNut(Row):
    """A hexagon nut.

    Attributes:
        diameter_mm: Thread diameter.
        across_flats_mm: Width across flats.
        height_mm: Height.
        tap_drill_mm: Core diameter of its thread.
    """

    diameter_mm: float
    across_flats_mm: float
    height_mm: float
    tap_drill_mm: float


@dataclass(frozen=True)
class Dowel(Row):
    """A hardened parallel pin, tolerance m6, pressed into an H7 hole.

    Attributes:
        diameter_mm: Nominal diameter.
        chamfer_mm: Length of the chamfered end.
        lengths_mm: Stock lengths, ascending.
    """

    diameter_mm: float
    chamfer_mm: float
    lengths_mm: tuple[float, ...]


@dataclass(frozen=True)
class Tube(Row):
    """A round tube, cut to length.

    Attributes:
        outer_mm: Outside diameter.
        inner_mm: Inside diameter.
        material: Id of its material.
    """

    outer_mm: float
    inner_mm: float
    material: str


@dataclass(frozen=True)
class Knob(Row):
    """A ball knob with a threaded hole.

    Attributes:
        diameter_mm: Ball diameter.
        height_mm: From the flat foot to the top.
        foot_diameter_mm: Diameter of the flat foot.
        thread: Thread of the hole ("M6").
        thread_depth_mm: Usable depth of the thread.
        mass_g: Mass.
    """

    diameter_mm: float
    height_mm: float
    foot_diameter_mm: float
    thread: str
    thread_depth_mm: float
    mass_g: float


@dataclass(frozen=True)
class Foot(Row):
    """A rubber foot under the base plate.

    Attributes:
        diameter_mm: Outside diameter.
        height_mm: Height without the stud.
        thread: Thread of the stud, or of the screw through its hole ("M4").
        stud_length_mm: Length of the stud; None when it has a hole.
        hole_diameter_mm: Through hole; None when it has a stud.
        mass_g: Mass.
    """

    diameter_mm: float
    height_mm: float
    thread: str
    stud_length_mm: float | None
    hole_diameter_mm: float | None
    mass_g: float


@dataclass(frozen=True)
class Magnet(Row):
    """A diametrically magnetised disc for a shaft encoder.

    Attributes:
        diameter_mm: Diameter.
        thickness_mm: Thickness.
        mass_g: Mass.
    """

    diameter_mm: float
    thickness_mm: float
    mass_g: float


@dataclass(frozen=True)
class Cable(Row):
    """A stainless steel wire rope for the capstan.

    Attributes:
        diameter_mm: Rope diameter.
        construction: Strands x wires ("7x19").
        breaking_load_N: Least breaking load.
        min_bend_ratio: Recommended least drum diameter over rope diameter for long life.
        mass_g_m: Mass per metre.
    """

    diameter_mm: float
    construction: str
    breaking_load_N: float
    min_bend_ratio: float
    mass_g_m: float


@dataclass(frozen=True)
class MaterialData(Row):
    """A material.

    Attributes:
        density_kg_m3: Density.
        red: Display colour, sRGB 0..1.
        green: Display colour, sRGB 0..1.
        blue: Display colour, sRGB 0..1.
        youngs_modulus_Pa: Young's modulus (along the fibre for CFRP).
        yield_strength_Pa: Yield or 0.2 % proof strength; strength for materials that do not yield; None when it has no
            use in design (magnets, electronics).
    """

    density_kg_m3: float
    red: float
    green: float
    blue: float
    youngs_modulus_Pa: float
    yield_strength_Pa: float | None

    @property
    def colour(self) -> tuple[float, float, float]:
        """Display colour, sRGB 0..1."""
        return (self.red, self.green, self.blue)
