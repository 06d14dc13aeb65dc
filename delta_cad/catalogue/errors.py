"""What can be wrong with the catalogue."""

from __future__ import annotations


class CatalogueError(Exception):
    """A part that is not in the catalogue, or a row that breaks the catalogue's rules."""
