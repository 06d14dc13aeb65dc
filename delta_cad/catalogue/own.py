"""A user's own parts: a folder of CSV files, one a family, whose rows come beside ours and never in their place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from delta_cad.catalogue.reader import CatalogueError, Family, OwnParts, read_family
from delta_cad.catalogue.row import CatalogueRow


def read_own(
    folder: Path, families: Mapping[str, Family], shared: Callable[[str, OwnParts], Mapping[str, CatalogueRow]]
) -> OwnParts:
    """Reads the own parts of a folder; see `delta_cad.catalogue.own_parts`.

    Args:
        folder: The folder.
        families: Those it may have rows of, by name.
        shared: Gives all rows of a family, with own ones after ours.

    Raises:
        CatalogueError: The folder or a row is refused.
    """
    legal = ", ".join(f"{name}.csv" for name in families)
    try:
        files = sorted(path for path in folder.iterdir() if path.suffix.lower() == ".csv")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise CatalogueError(
            f"{folder.name}: cannot be read: {reason}; must be a folder with some of {legal}"
        ) from None
    if not files:
        raise CatalogueError(f"{folder.name}: holds no CSV file; must hold one or more of {legal}")
    rows: dict[str, dict[str, CatalogueRow]] = {}
    for path in files:
        name = path.name.removesuffix(".csv")
        if name not in families:
            raise CatalogueError(f"{path.name}: is called as no family; must be one of {legal}")
        family = families[name]
        rows[name] = dict(read_family(path, family.record, own=True, taken=family.rows))
    parts = OwnParts(folder, rows)
    for name, own in rows.items():
        for row in own.values():
            _require_partners(f"{name}.csv", row, parts, shared)
    return parts


def _require_partners(
    file: str, row: CatalogueRow, parts: OwnParts, shared: Callable[[str, OwnParts], Mapping[str, CatalogueRow]]
) -> None:
    """Refuses a row that names a thread, a magnet or a material which is not in the catalogue."""
    for column, family in row.partners.items():
        key, legal = getattr(row, column), shared(family, parts)
        if key not in legal:
            allowed = f"must be one of {', '.join(legal)}"
            raise CatalogueError(f"{file}: {row.id}: {column} = {key!r}: {allowed}")
