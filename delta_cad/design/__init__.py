"""The design file: what was asked for, the chosen dimensions and hardware; read, validated, written and hashed."""

from delta_cad.design.file import (
    DesignError,
    design_from_dict,
    design_hash,
    design_schema,
    design_to_dict,
    design_to_json,
    load_design,
)
from delta_cad.design.record import (
    GRAVITY_MAX,
    HARDWARE_FAMILIES,
    NAME_PATTERN,
    NAME_RULE,
    SCHEMA,
    Cube,
    Design,
    Hardware,
    Mechanism,
    Requirements,
)

__all__ = [
    "GRAVITY_MAX",
    "HARDWARE_FAMILIES",
    "NAME_PATTERN",
    "NAME_RULE",
    "SCHEMA",
    "Cube",
    "Design",
    "DesignError",
    "Hardware",
    "Mechanism",
    "Requirements",
    "design_from_dict",
    "design_hash",
    "design_schema",
    "design_to_dict",
    "design_to_json",
    "load_design",
]
