"""Dimensions of a part's drawing: sizes of its faces, and the coordinates that locate them.

The faces of a solid are all there is to dimension. A plane is placed by one coordinate, a bore or a boss by two, a
body of revolution by the ends of its steps; a cylinder has a diameter or a radius, a ball its own. A plane that joins
two arcs as their tangent, and a small face at 45 degrees, a chamfer, have no coordinate. Of three equal arms about an
axis one is told.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees

import numpy as np

from delta_cad.export.drawings.part.controlled import Controlled, Round, signed
from delta_cad.export.drawings.part.faces import Face, is_across, is_along
from delta_cad.export.drawings.part.holes import hole_groups, slots
from delta_cad.export.drawings.part.places import place_bores, place_faces, place_steps
from delta_cad.export.drawings.part.record import SAME_MM, Features, Size
from delta_cad.export.drawings.part.shape import (
    chamfer_leg,
    goes_round,
    is_coaxial,
    is_floor,
    is_of_first_arm,
    is_slot_floor,
    is_slot_side,
    is_slot_wall,
    is_threefold,
    main_direction,
    turning_axis,
    unit,
)
from delta_cad.export.drawings.part.zones import add_zones
from delta_cad.export.drawings.sheet_io.lettering import SURFACE
from delta_cad.solids.part import Part


def features_of(part: Part, faces: list[Face], controlled: Controlled) -> Features:
    """Reads from a part's faces and holes all that its drawing has to tell.

    Raises:
        HoleError: The declared bores are not there.
    """
    groups = hole_groups(part, faces)
    axis = turning_axis(faces, groups)
    main = axis if axis is not None else main_direction(faces, groups)
    found = Features(faces, groups, slots(part), main, axis is not None)
    walls = {id(face) for group in groups for bore in group.bores for face in bore.faces}
    own = [
        face for face in faces if id(face) not in walls and not is_floor(face, walls) and not is_slot_wall(face, found)
    ]
    own = [face for face in own if not is_slot_side(face, walls) and not is_slot_floor(face, found)]
    found.notes |= {f"edge {n}": edge.text for n, edge in enumerate(controlled.edges)}
    third, whole = is_threefold(faces, main), len(own)
    own = [face for face in own if not third or is_of_first_arm(face, main)]
    if len(own) < whole:
        found.notes["pattern"] = "Three equal arms at 120° about the centre, one is dimensioned"
    chamfers = [face for face in own if chamfer_leg(face) is not None]
    own = [face for face in own if chamfer_leg(face) is None]
    _tell_chamfers(found, chamfers)
    _tell_rounds(found, own, controlled)
    found.datum = _datum(found, part, controlled)
    place_bores(found, third)
    if found.turned:
        place_steps(found, own)
    else:
        place_faces(found, own)
    add_zones(found, part, controlled)
    return found


def _tell_chamfers(found: Features, chamfers: Iterable[Face]) -> None:
    legs = sorted({round(leg, 2) for face in chamfers if (leg := chamfer_leg(face)) is not None})
    for leg in legs:
        found.notes[f"chamfer {leg:g}"] = f"{leg:g} x 45°"


def _tell_rounds(found: Features, own: Iterable[Face], controlled: Controlled) -> None:
    """Diameters and radii of all round faces that are no bores, once each."""
    groups: dict[tuple[str, float], list[Face]] = {}
    for face in own:
        if face.kind == "cylinder":
            whole = goes_round([f for f in found.faces if f.hollow == face.hollow and is_coaxial(f, face)])
            groups.setdefault(("Ø" if whole else "R", round(face.radius, 3)), []).append(face)
        elif face.kind == "sphere":
            groups.setdefault(("SØ", round(face.radius, 3)), []).append(face)
        elif face.kind == "torus":
            groups.setdefault(("ring R", round(face.radius, 3)), []).append(face)
        elif face.kind == "cone":
            groups.setdefault(("cone ", round(degrees(abs(face.half_angle)), 2)), []).append(face)
        elif face.kind == "other":
            found.notes["curved"] = "Curved faces: see the notes and the STEP file"
    for (sign, radius), faces in sorted(groups.items(), key=lambda item: -item[0][1]):
        value = 2 * faces[0].radius if "Ø" in sign else 2 * radius if sign == "cone " else faces[0].radius
        held = controlled.round_of(2 * faces[0].radius) if sign in ("Ø", "SØ", "R") else None
        text = f"{sign}{round(value, 3):g}" + ("°" if sign == "cone " else "")
        if held is not None:
            text = _held(text, held, is_radius=sign == "R")
        kind = {"SØ": "ball", "ring R": "ring"}.get(sign, "round")
        key = f"{sign.strip()} {round(value, 3):g}"
        counted = sign == "R" or (sign == "Ø" and held is not None)  # what is held closer, at each place that it is
        pieces = _pieces(faces) if counted else []
        text = f"{len(pieces)}x {text}" if len(pieces) > 1 else text
        found.sizes.append(Size(key, text, faces, kind, held, pieces))


def _pieces(faces: Iterable[Face]) -> list[list[Face]]:
    """Sorts faces of one radius; those of one axis that meet, be it in a point, belong together."""
    groups: list[list[Face]] = []
    for face in faces:
        joined = [g for g in groups if any(is_coaxial(face, other) and _meet(face, other) for other in g)]
        groups = [g for g in groups if g not in joined] + [[face, *(other for g in joined for other in g)]]
    return groups


def _meet(face: Face, other: Face) -> bool:
    """Decides whether an end, or a point between, of the edges of two faces is one."""
    apart = face.corners[:, None, :] - other.corners[None, :, :]
    return bool((np.linalg.norm(apart, axis=-1) < SAME_MM).any())


def _held(text: str, held: Round, is_radius: bool) -> str:
    """A diameter, or a radius, with what is asked of it."""
    if held.thread:
        return held.thread
    if held.fit and held.deviations_mm:
        lower, upper = (signed(one) for one in held.deviations_mm)
        text += f" {held.fit} ({upper}/{lower})"
    elif held.either_mm:
        text += f" ±{held.either_mm / (2.0 if is_radius else 1.0):g}"
    text = f"{text} {held.where}" if held.where else text
    return text if held.surface_um is None else f"{text} {SURFACE}Ra {held.surface_um:g}"


def _datum(found: Features, part: Part, controlled: Controlled) -> np.ndarray:
    """Where each axis counts from: as a tolerance does, or the middle of what is round or alike, or the lowest face."""
    box = part.solid.BoundingBox(1e-4)
    low, high = np.array([box.xmin, box.ymin, box.zmin]), np.array([box.xmax, box.ymax, box.zmax])
    datum = np.zeros(3)
    for k in range(3):
        along = unit(k)
        given = controlled.datum(k)
        if given is not None:
            datum[k] = given
            continue
        if found.turned and is_along(along, found.main):
            balls = [f for f in found.faces if f.kind == "sphere"]
            datum[k] = balls[0].point[k] if balls else low[k]
            continue
        centred = any(
            abs(bore.point[k]) < SAME_MM and is_across(bore.axis, along) for g in found.groups for bore in g.bores
        ) or any(
            abs(f.point[k]) < SAME_MM and (f.kind == "sphere" or (f.kind == "cylinder" and is_across(f.axis, along)))
            for f in found.faces
        )
        datum[k] = 0.0 if centred or abs(low[k] + high[k]) < SAME_MM else low[k]
    return datum
