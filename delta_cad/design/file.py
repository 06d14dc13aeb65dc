"""The design file read, validated, written and hashed.

A file that is refused says which field, its value and what is allowed, in one line (`DesignError`).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from delta_cad import catalogue
from delta_cad.common.reading import ReadError, read_json
from delta_cad.common.refusal import RefusedError, bounds_of, meant, not_finite, short, unknown_key
from delta_cad.design.cross_field_rules import contradictions
from delta_cad.design.process import process_fault
from delta_cad.design.record import (
    FOLDER_LONGEST,
    HARDWARE_FAMILIES,
    IN_WORDS,
    NAME_RULE,
    REVISION_RULE,
    SCHEMA,
    Design,
    DesignCube,
    DesignRequirements,
    Hardware,
    Loop,
    Mechanism,
    Panel,
)
from delta_cad.design.task import GRAVITY_MAX
from delta_cad.mechanism.geometry import AZIMUTH_MAX_DEG, AZIMUTH_MIN_DEG

MOST_BYTES = 4_000_000  # of a design file; ours have a thousandth of it, and who keeps more in `provenance` some more
Record = TypeVar("Record", bound=BaseModel)
SECTIONS: dict[str, type[BaseModel]] = {
    "mechanism": Mechanism,
    "cube": DesignCube,
    "requirements": DesignRequirements,
    "hardware": Hardware,
    "panel": Panel,
    "loop": Loop,
}
_COLLARS = (
    "is of no machine here: its rods begin in the joints' axes; `inspect --kinematics` takes collar_elbow_mm and "
    "collar_wrist_mm of another delta"
)
UNITS = {
    "_N_mm": "N/mm",
    "_mm": "mm",
    "_deg": "deg",
    "_N_m": "N m",
    "_N": "N",
    "_m_s2": "m/s^2",
    "_kg": "kg",
    "_kg_m2": "kg m^2",
    "_N_s_m": "N s/m",
    "_Hz": "Hz",
    "_ticks": "ticks",
}


class DesignError(RefusedError):
    """A design that is refused.

    Attributes:
        design: The design, where each field is within its bounds and only together they cannot be; else None.
    """

    design: Design | None = None


def load_design(path: str | Path, own_parts: Path | None = None) -> Design:
    """Reads and validates a design file.

    Args:
        path: JSON file, UTF-8, schema `delta-design/1`.
        own_parts: Folder of the user's own parts, in place of the one that `hardware.catalogue` names beside the file.

    Returns:
        The design, with all defaults filled in.

    Raises:
        DesignError: Refused by `read_json` or `design_from_dict`.
    """
    path = Path(path)
    try:
        data = read_json(path, MOST_BYTES, finite=False)
    except ReadError as error:
        raise DesignError(error.file, error.field, error.value, error.allowed) from None
    return design_from_dict(data, path.name, path.parent, own_parts)


def design_from_dict(
    data: object, file: str = "design", folder: Path = Path(), own_parts: Path | None = None
) -> Design:
    """Validates a design given as plain data.

    Args:
        data: What the JSON file holds: nested dicts, lists, numbers, strings.
        file: Name that error messages start with.
        folder: Folder that `hardware.catalogue` starts from.
        own_parts: Folder of the user's own parts, in place of that one.

    Returns:
        The design, with all defaults filled in.

    Raises:
        DesignError: Wrong schema, a missing or unknown field, a wrong type, a number that is not finite or out of
            bounds, a name that is not safe as a file name, own parts that `catalogue.own_parts` refuses, a part that is
            in no catalogue, a motor that does not suit the drive, or lengths that cannot go together.
    """
    try:
        design = record_of(
            Design, SECTIONS, data, file, lambda known: _own_parts(known.get("hardware"), file, folder, own_parts)
        )
    except RecursionError:
        raise DesignError(file, "", "", "is nested too deep") from None
    _check_catalogue(design.hardware, file)
    _check_drive(design.hardware, file)
    _check_process(design.hardware, file)
    if faults := contradictions(design):
        first, *more = [DesignError(file, fault.field, short(fault.value), fault.allowed) for fault in faults]
        first.more, first.design = tuple(map(str, more)), design
        raise first
    return design


def record_of(
    kind: type[Record],
    sections: Mapping[str, type[BaseModel]],
    data: object,
    file: str,
    context: Callable[[Mapping[str, Any]], object] = lambda _: None,
) -> Record:
    """Validates plain data as a record, each field by itself.

    Args:
        kind: The record.
        sections: Records of its sections by name.
        data: The data.
        file: Name that error messages start with.
        context: The data -> what the record's validators read beside them.

    Raises:
        DesignError: As `design_from_dict` refuses a single field.
    """
    if not isinstance(data, Mapping):
        raise DesignError(file, "", short(data), "must be an object")
    if "schema" in data and data["schema"] != SCHEMA:
        raise DesignError(file, "schema", short(data["schema"]), _allowed(("schema",)))
    if (bad := not_finite(data)) is not None:
        raise DesignError(file, bad[0], short(bad[1]), "must be finite")
    try:
        return kind.model_validate(dict(data), context=context(data))
    except ValidationError as error:
        first = _first(error)
        raise _explained(file, first["type"], first["loc"], first["input"], first["msg"], sections) from None


def _own_parts(hardware: object, file: str, folder: Path, given: Path | None) -> catalogue.OwnParts | None:
    """Reads the user's own parts, of the folder given or of the one that the design names."""
    field, value = "--catalogue", str(given)
    if given is None:
        named = hardware.get("catalogue") if isinstance(hardware, Mapping) else None
        if not isinstance(named, str) or not 0 < len(named) <= FOLDER_LONGEST:
            return None  # none, or the validator tells what is wrong
        field, value, given = "hardware.catalogue", named, folder / named
        if Path(named).is_absolute():
            allowed = "must start from the design file's folder, so that the design builds elsewhere, too"
            raise DesignError(file, field, short(value), allowed)
    try:
        return catalogue.own_parts(given)
    except catalogue.CatalogueError as error:
        raise DesignError(file, field, short(value), str(error)) from None


def hardware_from_dict(
    data: Mapping[str, Any],
    file: str = "design",
    folder: Path = Path(),
    own_parts: Path | None = None,
    *,
    drive_fits: bool = True,
) -> Hardware:
    """Validates the hardware of a design given as plain data.

    Args:
        data: Its entries; what is left out has its default.
        file: Name that error messages start with.
        folder: Folder that the entry `catalogue` starts from.
        own_parts: Folder of the user's own parts, in place of that one.
        drive_fits: Whether to refuse a motor that does not suit the drive.

    Returns:
        The hardware, with all defaults filled in.

    Raises:
        DesignError: As `design_from_dict` refuses the hardware of a design.
    """
    own = _own_parts(data, file, folder, own_parts)
    try:
        hardware = Hardware.model_validate(dict(data), context=own)
    except ValidationError as error:
        first = _first(error)
        raise _explained(file, first["type"], ("hardware", *first["loc"]), first["input"], first["msg"]) from None
    _check_catalogue(hardware, file)
    if drive_fits:
        _check_drive(hardware, file)
        _check_process(hardware, file)
    return hardware


def design_schema(own_parts: Path | None = None) -> dict[str, Any]:
    """Makes the JSON Schema of the design file, with bounds, defaults and descriptions.

    Args:
        own_parts: Folder of the user's own parts, whose ids are legal, too, where the design names a folder.

    Raises:
        CatalogueError: The own parts are refused.
    """
    own = None if own_parts is None else catalogue.own_parts(own_parts)
    schema = Design.model_json_schema(by_alias=True)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = SCHEMA
    mechanism = schema["$defs"]["Mechanism"]
    mechanism["required"].remove("base_radius_mm")
    radii = {"required": ["base_radii_mm"], "properties": {"base_radii_mm": {"type": "array"}}}
    mechanism["anyOf"] = [{"required": ["base_radius_mm"]}, radii]
    legal = {entry: {"enum": list(catalogue.family(entry))} for entry in HARDWARE_FAMILIES}
    named = {"required": ["catalogue"], "properties": {"catalogue": {"type": "string"}}}
    schema["$defs"]["Hardware"] |= {"if": named, "else": {"properties": legal}}
    if own is not None:
        more = {entry: {"enum": list(catalogue.family(entry, own))} for entry in HARDWARE_FAMILIES}
        schema["$defs"]["Hardware"] |= {"then": {"properties": more}}
    return schema


def design_to_dict(design: Design) -> dict[str, Any]:
    """Gives the design as plain data: all defaults spelled out, optional requirements that are not given left out."""
    return design.model_dump(mode="json", by_alias=True, exclude_none=True) | {
        "provenance": dict(design.provenance)  # null is a value in there
    }


def design_to_json(design: Design) -> str:
    """Writes the text of the design file; `load_design` gives the same design back, to the last bit of each number."""
    return json.dumps(design_to_dict(design), indent=2, allow_nan=False) + "\n"


def design_hash(design: Design) -> str:
    """Computes the SHA-256 (64 hex digits) of the canonical JSON: sorted keys, no blanks, ASCII, all defaults.

    Of the user's own parts the rows count that the design names, not the folder that they stand in. The controller's
    loop does not count: a build is the same with any.
    """
    data = design_to_dict(design)
    data.pop("loop", None)
    data["hardware"].pop("catalogue", None)
    if rows := _own_rows(design):
        data["own_parts"] = {entry: asdict(row) for entry, row in rows.items()}
    text = json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def _own_rows(design: Design) -> dict[str, catalogue.CatalogueRow]:
    """Gives the rows of the user's own parts that a design names, by the entry of its hardware."""
    own = design.hardware.own_parts
    chosen = {} if own is None else {e: own.rows.get(e, {}).get(getattr(design.hardware, e)) for e in HARDWARE_FAMILIES}
    return {entry: row for entry, row in chosen.items() if row is not None}


_Sections = Mapping[str, type[BaseModel]]


def _model_at(loc: tuple[int | str, ...], sections: _Sections) -> type[BaseModel]:
    """The record that holds the field at a location."""
    return sections[str(loc[0])] if len(loc) > 1 and loc[0] in sections else Design


def _allowed(loc: tuple[int | str, ...], sections: _Sections = SECTIONS) -> str:
    """States the values that a field may hold, from its declaration."""
    model, name = _model_at(loc, sections), str(loc[min(1, len(loc) - 1)])
    if name == "name":
        return NAME_RULE
    if name == "revision":
        return REVISION_RULE
    if name == "gravity_m_s2":
        return f"must be a list of 3 numbers, each >= {-GRAVITY_MAX:g} and <= {GRAVITY_MAX:g} m/s^2"
    if name == "azimuths_deg":
        return f"must be [0, phi, -phi] with phi >= {AZIMUTH_MIN_DEG:g} and <= {AZIMUTH_MAX_DEG:g} deg"
    if name == "base_radii_mm":
        return "must be a list of 3 numbers > 0 and <= 1000 mm, the second and the third equal"
    if name == "schema":
        return f"must be {json.dumps(SCHEMA)}"
    if name == "catalogue":
        return f"must be a folder's name, relative to that of this file, of at most {FOLDER_LONGEST} characters"
    if name == "drive":
        return 'must be "capstan" or "direct"'
    if name == "mounting":
        return 'must be "screws", "both", "plate" or "feet"'
    if name == "leads":
        return 'must be "bent" or "none"'
    if name == "encoder_at":
        return 'must be "shoulder" or "motor"'
    if name in ("process", "processes"):
        return 'must be "machined" or "printed"' if name == "process" else 'must be {"PART": "machined" or "printed"}'
    if name in HARDWARE_FAMILIES and model is Hardware:
        return f"must be one of {', '.join(catalogue.family(name))}"
    info = model.model_fields.get(name)
    bounds = bounds_of(info.metadata if info else [])
    if not bounds:
        return "must be an object"
    unit = next((unit for suffix, unit in UNITS.items() if name.endswith(suffix)), "")
    return f"must be a number {bounds} {unit}".rstrip()


def _first(error: ValidationError) -> Any:
    """Picks the finding that is told: a field that is missing is often there under a wrong name, which comes first."""
    return min(error.errors(include_url=False), key=lambda one: one["type"] == "missing")


def _explained(
    file: str, kind: str, loc: tuple[int | str, ...], value: object, message: str, sections: _Sections = SECTIONS
) -> DesignError:
    """Turns the first finding of the validator into our error."""
    field = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc).lstrip(".")
    if kind == "extra_forbidden":
        known = [info.alias or name for name, info in _model_at(loc, sections).model_fields.items()]
        other = [f"{section}.{name}" for section, model in sections.items() for name in model.model_fields]
        if "collar" in str(loc[-1]):
            return DesignError(file, field, short(value), _COLLARS)
        return DesignError(file, field, short(value), unknown_key(str(loc[-1]), known, other))
    if kind == "missing":
        return DesignError(file, field, "", f"is missing; {_allowed(loc, sections)}")
    if kind in {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}:
        return DesignError(file, field, short(value), _allowed(loc, sections).replace("a number ", ""))
    if kind == IN_WORDS:
        return DesignError(file, field, short(value), message)
    if loc[0] == "provenance" and len(loc) > 1:
        return DesignError(file, field, short(value), f"must be plain JSON: {message}")
    return DesignError(file, field, short(value), _allowed(loc, sections))


def _check_catalogue(hardware: Hardware, file: str) -> None:
    """Refuses parts that are in no catalogue."""
    for entry in HARDWARE_FAMILIES:
        key, rows = getattr(hardware, entry), catalogue.family(entry, hardware.own_parts)
        if key not in rows:
            hint = f"; did you mean {found}?" if (found := meant(key, rows)) else ""
            raise DesignError(file, f"hardware.{entry}", short(key), f"must be one of {', '.join(rows)}{hint}")


def _check_drive(hardware: Hardware, file: str) -> None:
    """Refuses a motor that does not suit the drive."""
    if hardware.drive not in catalogue.motor.chosen(hardware).drives:
        motors = catalogue.family("motor", hardware.own_parts).items()
        legal = [key for key, row in motors if isinstance(row, catalogue.Motor) and hardware.drive in row.drives]
        allowed = f"is not for the {hardware.drive} drive; must be one of {', '.join(legal)}"
        raise DesignError(file, "hardware.motor", short(hardware.motor), allowed)
    if hardware.encoder_at == "motor" and catalogue.motor.chosen(hardware).encoder_counts_per_turn is None:
        motors = catalogue.family("motor", hardware.own_parts).items()
        sensed = [
            key
            for key, row in motors
            if isinstance(row, catalogue.Motor) and hardware.drive in row.drives and row.encoder_counts_per_turn
        ]
        allowed = f"has no encoder of its own, which hardware.encoder_at = motor asks for; {', '.join(sensed)} have"
        raise DesignError(file, "hardware.motor", short(hardware.motor), allowed)


def _check_process(hardware: Hardware, file: str) -> None:
    """Refuses a process that a part cannot be made by, and a material that is not printed."""
    if (fault := process_fault(hardware)) is not None:
        field, value, allowed = fault
        raise DesignError(file, field, short(value), allowed)
