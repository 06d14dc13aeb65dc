"""`schema`: the JSON Schema of the requirements file."""

from __future__ import annotations

import argparse
import json

from delta_cad.common.console import BAD_INPUT, DONE, refuse
from delta_cad.common.options import REQUIREMENTS_CATALOGUE

NAME = "schema"
TEXT = "JSON Schema of the requirements file"
OPTIONS = (REQUIREMENTS_CATALOGUE,)  # whose ids the schema then knows


def run(given: argparse.Namespace) -> int:
    """Prints the schema."""
    import tomllib

    from delta_cad.catalogue import CatalogueError, own_parts
    from optimizer.commands.init import PRESETS, preset_text
    from optimizer.problem.schema import brief_schema

    try:
        own = None if given.catalogue is None else own_parts(given.catalogue)
    except CatalogueError as error:
        return refuse(f"--catalogue {given.catalogue}: {error}", BAD_INPUT)
    examples = [tomllib.loads(preset_text(preset)) for preset in PRESETS]
    print(json.dumps(brief_schema(own) | {"examples": examples}, indent=2))
    return DONE
