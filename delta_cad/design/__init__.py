"""The design file: requirements, chosen dimensions and hardware; read, validated, written and hashed."""
# ruff: noqa: F401  the names are for those who import the package

from delta_cad.design.file import (
    DesignError,
    design_from_dict,
    design_hash,
    design_schema,
    design_to_dict,
    design_to_json,
    hardware_from_dict,
    load_design,
)
from delta_cad.design.record import (
    HARDWARE_FAMILIES,
    NAME_LONGEST,
    NAME_PATTERN,
    NAME_RULE,
    SCHEMA,
    Design,
    DesignCube,
    DesignRequirements,
    Hardware,
    Loop,
    Mechanism,
)
