"""Machining of a part: stock, removed volume, areas, bores, threads, setups, and their cost."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.printing import inserts_of
from delta_cad.common.units import MM_PER_M
from delta_cad.export.shop.cost.rates import (
    OTHER,
    PLATE_MATERIALS,
    PLATES_MM,
    PRINTED_EUR_KG,
    PRINTS,
    STOCKS,
    Rates,
    Stock,
)
from delta_cad.solids.part import Part

_ROUND_SHARE = 0.6  # of a part's area that turns about one axis, or is square to it, from which on it is turned
_SAME_MM, _ALONG = 1e-3, 1e-6
MINUTES = 60.0
_FLAT_SHARE = 0.8  # of a plate's mean section, that either of its faces keeps as bought
_CUT_FROM_SHEET = "cut from sheet"
_TURNED_OVER = 2  # clampings of a block at least: where it is held the first time it is cut the second


@dataclass(frozen=True)
class Work:
    """What there is to do for one piece.

    Attributes:
        stock: "bar", "block", "plate" whose faces stay as bought, "sheet" cut by a beam, or "as bought".
        stock_mm3: Volume of the stock.
        removed_mm3: That is cut off; none of stock as bought.
        finished_mm2: Area of the part; of a plate its sides, of sheet none.
        drilled: Bores, those of threads and fits included.
        threads: Of these.
        fits: Of these.
        tools: Different diameters, and one a clamping.
        clampings: Of a piece.
        anodised: Whether it goes to be anodised.
        eroded: Whether its holes are eroded.
        beam_mm2: Area that a beam cuts; none but of sheet.
        contours: That it cuts.
    """

    stock: str
    stock_mm3: float
    removed_mm3: float
    finished_mm2: float
    drilled: int
    threads: int
    fits: int
    tools: int
    clampings: int
    anodised: bool = False
    eroded: bool = False
    beam_mm2: float = 0.0
    contours: int = 0


@dataclass(frozen=True)
class Making:
    """What it costs.

    Attributes:
        material_EUR: Stock of a piece.
        piece_min: Time of a piece.
        batch_min: Time of a batch, whatever its size.
        piece_EUR: Treatment of a piece.
        batch_EUR: Treatment of a batch.
    """

    material_EUR: float
    piece_min: float
    batch_min: float
    piece_EUR: float
    batch_EUR: float

    def of_one(self, pieces: int, rates: Rates) -> float:
        """Computes what one piece of a batch costs, EUR."""
        minute = rates.hour_EUR / MINUTES
        batch = self.batch_min * minute + self.batch_EUR
        return self.material_EUR + self.piece_min * minute + self.piece_EUR + batch / pieces


def printing(part: Part, material: str) -> Making:
    """Computes what a printed part of a material of the catalogue, by its id, costs: of a piece and of a batch."""
    own, grams = PRINTS[part.material.process], part.solid.Volume() * part.material.density_kg_m3 / 1e6
    bores = [bore for hole in part.holes for bore in hole.bores]
    minutes = own.handle_min + own.insert_min * len(inserts_of(part)) + own.ream_min * sum(bool(b.fit) for b in bores)
    minute = own.work_EUR_h / MINUTES
    hours = float(part.solid.Volume()) / own.volume_mm3_h
    stuff = grams / 1e3 * PRINTED_EUR_KG[material] * (1.0 + own.waste_share)
    return Making(stuff, 0.0, 0.0, minutes * minute + hours * own.hour_EUR, own.prepare_min * minute)


def work_of(part: Part, clampings: int, rates: Rates) -> Work:
    """Reads what there is to do off a made part, whose bores and inner corners take so many clampings."""
    solid = part.solid
    box = solid.BoundingBox(1e-4)
    edges = np.array([box.xlen, box.ylen, box.zlen])
    axis = _turned_about(solid, edges)
    bought, sheet = bool(part.order_code), _CUT_FROM_SHEET in part.description
    thin, rolled_mm2 = _plate(solid, edges)
    rolled_mm2 = rolled_mm2 if material_id(part) in PLATE_MATERIALS else 0.0
    if bought:
        kind, stock_mm3 = "as bought", float(solid.Volume())
    elif axis is not None:
        diameter = float(np.delete(edges, axis).max()) + 2 * rates.allowance_mm
        length = float(edges[axis]) + 2 * rates.allowance_mm
        kind, stock_mm3 = "bar", pi / 4 * diameter**2 * length
    elif sheet or rolled_mm2:
        kind = "sheet" if sheet else "plate"
        added = np.where(np.arange(3) == thin, 0.0, 2 * rates.allowance_mm)
        stock_mm3 = float(np.prod(edges + added))
    else:
        kind, stock_mm3 = "block", float(np.prod(edges + 2 * rates.allowance_mm))
    if kind == "block" or (kind == "plate" and _from_both_faces(part, thin)):
        clampings = max(clampings, _TURNED_OVER)
    bores = [bore for hole in part.holes for bore in hole.bores]
    drilled = sum(hole.count for hole in part.holes)
    sizes = {round(bore.diameter_mm, 3) for bore in bores} | {round(hole.diameter_mm, 3) for hole in part.holes}
    return Work(
        stock=kind,
        stock_mm3=stock_mm3,
        removed_mm3=0.0 if bought or sheet else stock_mm3 - float(solid.Volume()),
        finished_mm2=0.0 if bought or sheet else float(solid.Area()) - rolled_mm2,
        drilled=0 if sheet or (bought and not _eroded(part)) else drilled,
        threads=sum(bool(bore.thread) for bore in bores),
        fits=sum(bore.deviations_um is not None for bore in bores) + sum(len(hole.slots) for hole in part.holes),
        tools=clampings + len(sizes),
        clampings=clampings,
        anodised=bool(coat_of(part)),
        eroded=_eroded(part),
        beam_mm2=_sides_mm2(solid, thin) if sheet else 0.0,
        contours=1 + drilled if sheet else 0,
    )


def making(work: Work, material: str, rates: Rates) -> Making:
    """Computes what a piece of a material of the catalogue, by its id, costs.

    Returns:
        The cost, without the price of stock that is bought by the piece or metre.
    """
    stock = _stock_of(material)
    density = catalogue.material(material).density_kg_m3 / MM_PER_M**3  # kg/mm^3
    paid = 0.0 if work.stock == "as bought" else work.stock_mm3 * density * stock.price_EUR_kg
    cut = work.removed_mm3 / stock.removal_mm3_min + work.finished_mm2 / rates.finish_mm2_min
    cut += work.drilled * (rates.erode_min if work.eroded else rates.drill_min)
    cut += work.threads * rates.thread_min + work.fits * rates.fit_min
    if work.stock == "as bought":
        piece = (cut if work.eroded else rates.saw_min) + rates.handle_min
        return Making(0.0, piece, rates.setup_min, 0.0, 0.0)
    if work.stock == "sheet":
        beam = work.beam_mm2 * rates.beam_EUR_mm2 + work.contours * rates.pierce_EUR
        return Making(paid, rates.handle_min + rates.deburr_min, 0.0, beam, rates.beam_lot_EUR)
    piece = cut * (1.0 + rates.idle_share) + work.tools * rates.tool_min
    piece += work.clampings * rates.handle_min + rates.deburr_min
    batch = rates.program_min + work.clampings * rates.setup_min
    coat = (rates.anodise_EUR, rates.anodise_lot_EUR) if work.anodised else (0.0, 0.0)
    return Making(paid, piece, batch, *coat)


def coat_of(part: Part) -> str:
    """Gives the coat of a made part: "hard anodised", "anodised" or ""."""
    return next((coat for coat in ("hard anodised", "anodised") if part.make and coat in part.description), "")


def _stock_of(material: str) -> Stock:
    """Gives how a material is bought and cut."""
    return STOCKS.get(material, OTHER)


def material_id(part: Part) -> str:
    """Finds the id of a part's material in the catalogue, by its name."""
    return next(key for key, row in catalogue.material.rows.items() if row.description == part.material.name)


def _plate(solid: object, edges: np.ndarray) -> tuple[int, float]:
    """The axis across which a solid is thinnest, and the area of its faces that a plate of that thickness has already.

    None of it where no such plate is in stock, or where the faces are not most of what is seen from there.
    """
    thin = int(edges.argmin())
    box = solid.BoundingBox(1e-4)
    ends = np.array([[box.xmin, box.ymin, box.zmin], [box.xmax, box.ymax, box.zmax]])[:, thin]
    lying = 0.0
    for face in solid.Faces():
        at = face.Center().toTuple()[thin]
        flat = face.geomType() == "PLANE" and abs(face.normalAt().toTuple()[thin]) > 1.0 - _ALONG
        if flat and np.abs(ends - at).min() < _SAME_MM:
            lying += face.Area()
    stock = np.abs(np.array(PLATES_MM) - edges[thin]).min() < _SAME_MM
    return thin, lying if stock and lying >= _FLAT_SHARE * 2.0 * float(solid.Volume()) / edges[thin] else 0.0


def _from_both_faces(part: Part, thin: int) -> bool:
    """Whether something is bored or milled into either face of a plate, or into its edges."""
    ways = {round(bore.direction[thin], 3) for hole in part.holes for bore in hole.bores if not bore.through}
    return len(ways) > 1 or not ways <= {-1.0, 1.0}


def _sides_mm2(solid: object, thin: int) -> float:
    """Area of the faces that run through a sheet."""
    flat = (f for f in solid.Faces() if f.geomType() == "PLANE" and abs(f.normalAt().toTuple()[thin]) > 1.0 - _ALONG)
    return float(solid.Area()) - sum(face.Area() for face in flat)


def _eroded(part: Part) -> bool:
    return "eroded" in part.description


def _turned_about(solid: object, edges: np.ndarray) -> int | None:
    """The axis about which most of a solid is round, or None."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface

    for axis in range(3):
        across = np.delete(edges, axis)
        if abs(across[0] - across[1]) > _SAME_MM * max(across):
            continue
        area = 0.0
        for face in solid.Faces():
            surface = BRepAdaptor_Surface(face.wrapped)
            kind = face.geomType()
            turned = {"CYLINDER": "Cylinder", "CONE": "Cone", "TORUS": "Torus", "PLANE": "Plane"}.get(kind)
            if kind == "SPHERE":
                area += face.Area()
            elif turned:
                direction = getattr(surface, turned)().Axis().Direction()
                along = np.abs([direction.X(), direction.Y(), direction.Z()])
                area += face.Area() if along[axis] > 1.0 - _ALONG else 0.0
        if area >= _ROUND_SHARE * solid.Area():
            return axis
    return None
