"""`schema`: the JSON Schema of the design file."""

from __future__ import annotations

import argparse
import json

from delta_cad.common.console import DONE

NAME = "schema"
TEXT = "JSON Schema of the design file"


def arguments(_command: argparse.ArgumentParser) -> None:
    """It takes none."""


def run(_given: argparse.Namespace) -> int:
    """Prints the schema."""
    from delta_cad.design import design_schema

    print(json.dumps(design_schema(), indent=2))
    return DONE
