"""Writes report.html: gathers the figures, puts them, the model and the scripts into one file.

Whatever comes from a design, a catalogue or another file is escaped where it stands. The page's own policy lets no
script run but those whose hashes it names, and nothing be asked of any other place.
"""

from __future__ import annotations

import hashlib
import json
from base64 import b64encode
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from delta_cad.common.reading import read_json
from delta_cad.design import design_to_json
from delta_cad.report.fields import fields, handle_of, maps
from delta_cad.report.figures import binding, every, feel, headline, lengths, requirements
from delta_cad.report.making import cost, tolerances
from delta_cad.report.outline import outline
from delta_cad.report.scene import scene
from delta_cad.report.statements import assumptions, certificate, proof, provenance
from delta_cad.report.subject import Subject

FILE_NAME = "report.html"
SOUGHT = "design.html"  # which `design` writes beside what it found
CERTIFICATE = "certificate.json"  # which only some builds have beside them
MANUAL = "manual/manual.html"  # which a build may be asked to leave out
ASSETS = Path(__file__).parent / "assets"
VENDOR = Path(__file__).parent / "vendor"
SCRIPTS = ("kinematics.js", "viewer.js", "maps.js", "main.js")
# Columns of the bill of materials that come first; others that a build may write follow. Sources stand with what is
# described.
COLUMNS = (
    "item", "part_number", "description", "quantity", "make_or_buy", "specification", "unit_mass_g", "total_mass_g",
    "unit_cost_EUR", "total_cost_EUR",
)  # fmt: skip
SPECIFIED = ("material", "standard", "order_code")  # told in one column, which a page is wide enough for
SOURCES = ("source", "cost_source")


def write_report(s: Subject, folder: Path, versions: Mapping[str, str], poor: str = "") -> Path:
    """Writes the page of a build into its folder, where all other files but the manifest are.

    Args:
        s: The machine and its checks.
        folder: Holds `assembly.glb` and `bom.json`; its files are linked.
        versions: Program -> version, as the manifest tells them.
        poor: In what a machine that passes is poor; "" for nothing.

    Returns:
        The file.

    Raises:
        OSError, ReadError: A file cannot be read or written.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    handle = handle_of(s)
    over = fields(s, handle) if s.reachable else []
    data = scene(s, handle) | {"slices": maps(s, over)}
    scripts = [_script(VENDOR / "three.js"), *(_script(ASSETS / name) for name in SCRIPTS)]
    style = (ASSETS / "page.css").read_text(encoding="utf-8")
    tidy = {"trim_blocks": True, "lstrip_blocks": True, "undefined": StrictUndefined}
    environment = Environment(loader=FileSystemLoader(ASSETS), autoescape=True, **tidy)
    rows = [_specified(row) for row in read_json(folder / "bom.json")["items"]]
    files = _files(folder)
    certified = certificate(s.design, folder / CERTIFICATE)
    text = environment.get_template("page.html").render(
        name=s.design.name,
        poor=poor,
        passed=all(result.passed for result in s.results),
        counted=(sum(result.passed for result in s.results), len(s.results)),
        headline=headline(s, over),
        lengths=lengths(s),
        asked=requirements(s.results),
        binding=binding(s.results),
        checks=every(s.results),
        feel=feel(s, over),
        reachable=s.reachable,
        cube=data["cube"],
        outline=outline(s),
        bom={"columns": _columns(rows), "rows": rows},
        cost=cost(folder),
        tolerances=tolerances(folder),
        certificate=certified,
        proof=certified if certified["found"] else proof(s),
        assumptions=assumptions(s),
        provenance=provenance(s, dict(versions)),
        design=design_to_json(s.design),
        manual=MANUAL if (folder / MANUAL).is_file() else "",
        files=files,
        drawn={name for group, names in files if group == "drawings" for name, _ in names},
        sought=SOUGHT if (folder / SOUGHT).is_file() else "",
        policy=page_policy(scripts, style),
        style=Markup(style),
        scripts=[Markup(script) for script in scripts],
        licence=Markup((VENDOR / "three.LICENSE").read_text(encoding="utf-8").strip()),
        data=Markup(_json(data)),
        model=Markup(b64encode((folder / "assembly.glb").read_bytes()).decode("ascii")),
    )
    path = folder / FILE_NAME
    path.write_text(text, encoding="utf-8")
    return path


def _script(path: Path) -> str:
    """A script that no tag within ends."""
    return path.read_text(encoding="utf-8").replace("</script", "<\\/script")


def _json(data: Any) -> str:
    """JSON that no tag within ends, whatever names it holds."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def page_policy(scripts: Sequence[str], style: str) -> str:
    """Tells what a page may do: run these scripts, take this style, show pictures that it holds itself."""

    def hashed(*texts: str) -> str:
        digests = (b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii") for text in texts)
        return " ".join(f"'sha256-{digest}'" for digest in digests)

    return (
        f"default-src 'none'; script-src {hashed(*scripts)}; style-src {hashed(style)}; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'"
    )


def _specified(row: Mapping[str, Any]) -> dict[str, Any]:
    """A line of the bill of materials with material, standard and order code in one."""
    stated = [str(row[key]) for key in SPECIFIED if row.get(key) not in ("", None)]
    rest = {key: value for key, value in row.items() if key not in SPECIFIED}
    return rest | ({"specification": "; ".join(dict.fromkeys(stated))} if stated else {})


def _columns(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    found = {key for row in rows for key, value in row.items() if value not in ("", None)}
    return [key for key in COLUMNS if key in found] + sorted(found - {*COLUMNS, *SOURCES})


def _files(folder: Path) -> list[tuple[str, list[tuple[str, int]]]]:
    """Sub-folder -> its files with their sizes in bytes, those of the folder itself first."""
    groups: dict[str, list[tuple[str, int]]] = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name != FILE_NAME:
            name = path.relative_to(folder).as_posix()
            groups.setdefault(name.rpartition("/")[0], []).append((name, path.stat().st_size))
    return sorted(groups.items())
