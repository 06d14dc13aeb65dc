"""`schema`: the JSON Schema of the design file."""

from __future__ import annotations

import argparse
import json

from delta_cad.common.console import BAD_INPUT, DONE, refuse
from delta_cad.common.options import CATALOGUE

NAME = "schema"
TEXT = "JSON Schema of the design file"
OPTIONS = (CATALOGUE,)  # whose ids the schema then knows


def run(given: argparse.Namespace) -> int:
    """Prints the schema."""
    from delta_cad.catalogue import CatalogueError
    from delta_cad.design import design_schema

    try:
        schema = design_schema(given.catalogue)
    except CatalogueError as error:
        return refuse(f"--catalogue {given.catalogue}: {error}", BAD_INPUT)
    print(json.dumps(schema, indent=2))
    return DONE
