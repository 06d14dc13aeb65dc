"""The design file read, validated, written and hashed.

A file that is refused says which field, its value and what is allowed, in one line (`DesignError`).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from delta_cad import catalogue
from delta_cad.common.reading import ReadError, read_json
from delta_cad.common.refusal import RefusedError, bounds_of, not_finite, short
from delta_cad.design.record import (
    GRAVITY_MAX,
    HARDWARE_FAMILIES,
    NAME_RULE,
    SCHEMA,
    Design,
    DesignCube,
    DesignRequirements,
    Hardware,
    Mechanism,
)
from delta_cad.design.sums import impossible_sum

MOST_BYTES = 4_000_000  # of a design file; ours have a thousandth of it, and who keeps more in `provenance` some more
UNITS = {
    "_N_mm": "N/mm",
    "_mm": "mm",
    "_deg": "deg",
    "_N_m": "N m",
    "_N": "N",
    "_m_s2": "m/s^2",
    "_kg": "kg",
    "_kg_m2": "kg m^2",
}


class DesignError(RefusedError):
    """A design that is refused."""


def load_design(path: str | Path) -> Design:
    """Reads and validates a design file.

    Args:
        path: JSON file, UTF-8, schema `delta-design/1`.

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
    return design_from_dict(data, path.name)


def design_from_dict(data: object, file: str = "design") -> Design:
    """Validates a design given as plain data.

    Args:
        data: What the JSON file holds: nested dicts, lists, numbers, strings.
        file: Name that error messages start with.

    Returns:
        The design, with all defaults filled in.

    Raises:
        DesignError: Wrong schema, a missing or unknown field, a wrong type, a number that is not finite or out of
            bounds, a name that is not safe as a file name, a part that is not in the catalogue, a motor that does not
            suit the drive, or lengths that cannot go together.
    """
    try:
        return _validated(data, file)
    except RecursionError:
        raise DesignError(file, "", "", "is nested too deep") from None


def _validated(data: object, file: str) -> Design:
    """See `design_from_dict`."""
    if not isinstance(data, Mapping):
        raise DesignError(file, "", short(data), "must be an object")
    if "schema" in data and data["schema"] != SCHEMA:
        raise DesignError(file, "schema", short(data["schema"]), _allowed(("schema",)))
    if (bad := not_finite(data)) is not None:
        raise DesignError(file, bad[0], short(bad[1]), "must be finite")
    try:
        design = Design.model_validate(dict(data))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise _explained(file, first["type"], first["loc"], first["input"], first["msg"]) from None
    _check_catalogue(design, file)
    fault = impossible_sum(design)
    if fault is not None:
        raise DesignError(file, fault.field, short(fault.value), fault.allowed)
    return design


def design_schema() -> dict[str, Any]:
    """Makes the JSON Schema of the design file, with bounds, defaults and descriptions."""
    schema = Design.model_json_schema(by_alias=True)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = SCHEMA
    entries = schema["$defs"]["Hardware"]["properties"]
    for entry in HARDWARE_FAMILIES:
        entries[entry]["enum"] = list(catalogue.family(entry))
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
    """Computes the SHA-256 (64 hex digits) of the canonical JSON: sorted keys, no blanks, ASCII, all defaults."""
    text = json.dumps(design_to_dict(design), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def _model_at(loc: tuple[int | str, ...]) -> type[BaseModel]:
    """The record that holds the field at a location."""
    sections: dict[str, type[BaseModel]] = {
        "mechanism": Mechanism,
        "cube": DesignCube,
        "requirements": DesignRequirements,
        "hardware": Hardware,
    }
    return sections[str(loc[0])] if len(loc) > 1 and loc[0] in sections else Design


def _allowed(loc: tuple[int | str, ...]) -> str:
    """States the values that a field may hold, from its declaration."""
    model, name = _model_at(loc), str(loc[min(1, len(loc) - 1)])
    if name == "name":
        return NAME_RULE
    if name == "gravity_m_s2":
        return f"must be a list of 3 numbers, each >= {-GRAVITY_MAX:g} and <= {GRAVITY_MAX:g} m/s^2"
    if name == "schema":
        return f"must be {json.dumps(SCHEMA)}"
    if name == "drive":
        return 'must be "capstan" or "direct"'
    if name in HARDWARE_FAMILIES and model is Hardware:
        return f"must be one of {', '.join(catalogue.family(name))}"
    info = model.model_fields.get(name)
    bounds = bounds_of(info.metadata if info else [])
    if not bounds:
        return "must be an object"
    unit = next((unit for suffix, unit in UNITS.items() if name.endswith(suffix)), "")
    return f"must be a number {bounds} {unit}".rstrip()


def _explained(file: str, kind: str, loc: tuple[int | str, ...], value: object, message: str) -> DesignError:
    """Turns the first finding of the validator into our error."""
    field = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc).lstrip(".")
    if kind == "extra_forbidden":
        model = _model_at(loc)
        known = ", ".join(info.alias or name for name, info in model.model_fields.items())
        return DesignError(file, field, short(value), f"unknown key; known here: {known}")
    if kind == "missing":
        return DesignError(file, field, "", f"is missing; {_allowed(loc)}")
    if kind in {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}:
        return DesignError(file, field, short(value), _allowed(loc).replace("a number ", ""))
    if loc[0] == "provenance" and len(loc) > 1:
        return DesignError(file, field, short(value), f"must be plain JSON: {message}")
    return DesignError(file, field, short(value), _allowed(loc))


def _check_catalogue(design: Design, file: str) -> None:
    """Refuses parts that are not in the catalogue and motors that do not suit the drive."""
    for entry in HARDWARE_FAMILIES:
        key, rows = getattr(design.hardware, entry), catalogue.family(entry)
        if key not in rows:
            raise DesignError(file, f"hardware.{entry}", short(key), f"must be one of {', '.join(rows)}")
    drive = design.hardware.drive
    if drive not in catalogue.motor(design.hardware.motor).drives:
        legal = [key for key in catalogue.family("motor") if drive in catalogue.motor(key).drives]
        value = short(design.hardware.motor)
        allowed = f"is not for the {drive} drive; must be one of {', '.join(legal)}"
        raise DesignError(file, "hardware.motor", value, allowed)
