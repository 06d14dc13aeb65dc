"""Files of a study: its rows as CSV, its record as JSON."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from delta_cad.common.refusal import as_cell


def csv_text(columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """Writes rows as CSV; a list becomes its members with "; " between them, what a row has not an empty cell."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(row.get(name)) for name in columns] for row in rows)
    return out.getvalue()


def _cell(value: Any) -> Any:
    return "" if value is None else "; ".join(value) if isinstance(value, list) else as_cell(value)


def json_text(record: Mapping[str, Any]) -> str:
    """Writes a record as JSON; numbers have all their digits."""
    return json.dumps(record, indent=1, allow_nan=False) + "\n"
