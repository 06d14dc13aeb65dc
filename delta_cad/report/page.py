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
from typing import TYPE_CHECKING, Any

from delta_cad.common.reading import read_json
from delta_cad.common.units import G_PER_KG, MM_PER_M
from delta_cad.design import design_to_json
from delta_cad.export.folder import ARCHIVE
from delta_cad.export.views.explode import exploded
from delta_cad.mechanism.placement import LinkPlacement
from delta_cad.report.built import PAGE
from delta_cad.report.fields import Handle, fields, handle_of, maps
from delta_cad.report.figures import binding, failures, feel, headline, kinds, lengths, requirements, with_unit
from delta_cad.report.outline import outline
from delta_cad.report.statements import assumptions, certificate, proof, provenance
from delta_cad.report.subject import Subject, plain

if TYPE_CHECKING:
    from jinja2 import Environment

# Tables of the page about making: what the machine costs, and what its tolerances do, from the files beside it.
_COST, _TOLERANCES = "cost.json", "tolerances.json"
_DECIDES = {"worst": "worst case", "rss": "statistically"}
_DEAREST = 10  # lines that are told, of what is made and bought together


def cost(folder: Path) -> dict[str, Any] | None:
    """Gives the sums and the dearest lines of `cost.json` in a folder as text; None where it is not there."""
    if not (folder / _COST).is_file():
        return None
    record: Mapping[str, Any] = read_json(folder / _COST)
    lines = sorted(record["lines"], key=lambda line: -line["quantity"] * line["unit_EUR"][0])
    sums = (("made parts", "made_EUR"), ("bought parts", "bought_EUR"), ("one machine", "total_EUR"))
    return {
        "machines": record["machines"],
        "sums": [(words, [_euro(v) for v in record[key]]) for words, key in sums],
        "lines": [
            (
                f"{line['quantity']} × {line['part_number']}",
                [_euro(line["quantity"] * one) for one in line["unit_EUR"]],
                line["source"],
            )
            for line in lines[:_DEAREST]
        ],
        "left_out": record["assumed"]["left_out"],
        "hour": _euro(record["assumed"]["shop"]["hour_EUR"]),
    }


def tolerances(folder: Path) -> dict[str, Any] | None:
    """Gives the chains of `tolerances.json` in a folder as text; None where it is not there."""
    if not (folder / _TOLERANCES).is_file():
        return None
    record: Mapping[str, Any] = read_json(folder / _TOLERANCES)
    return {
        "general": record["general_class"],
        "assumed": record["assumed"],
        "chains": [_chain(chain) for chain in (*record["chains"], *record["lengths"])],
    }


def _chain(chain: Mapping[str, Any]) -> dict[str, Any]:
    low, high = chain["allowed"]
    unit = chain["unit"]
    bounded = low is not None or high is not None
    return {
        "name": chain["name"],
        "nominal": with_unit(chain["nominal"], unit),
        "worst": _range(chain["worst"], unit),
        "rss": _range(chain["rss"], unit),
        "allowed": _allowed(low, high, unit),
        "decides": _DECIDES.get(chain["decided_by"], chain["decided_by"]) if bounded else "",
        "holds": chain["holds"] if bounded else None,
        "why": chain["why"],
        "links": [
            f"{link['part']}, {link['what']} ({link['kind']}): {_range(link['adds'], unit)}" for link in chain["links"]
        ],
    }


def _allowed(low: float | None, high: float | None, unit: str) -> str:
    """Bounds as text; "" where there is none."""
    if low is not None and high is not None:
        return _range((low, high), unit)
    return f"≥ {with_unit(low, unit)}" if low is not None else f"≤ {with_unit(high, unit)}" if high is not None else ""


def _range(ends: Any, unit: str) -> str:
    low, high = ends
    return f"{with_unit(low)} … {with_unit(high, unit)}"


def _euro(value: float) -> str:
    return f"{value:,.2f}" if value < 100.0 else f"{value:,.0f}"


# What the page needs to move the machine: lengths, parts, how each leaves in the exploded view, cube, outline.
_DIGITS = 5  # of what is only looked at


def mechanism(placement: LinkPlacement, force_N: float, handle: Handle) -> dict[str, Any]:
    """Gathers what `assets/kinematics.js` takes, as JSON types: all doubles, so that its frames are the placement's."""
    g = placement.geometry
    inertia, friction, rubs = handle.inertia, handle.friction, None
    if friction is not None:
        rubs = {"drive_N_m": friction.drive, "upright_N": friction.upright, "level_N": friction.level}
    return plain(
        {
            "base_radius_mm": g.base_radius * MM_PER_M,
            "outs_mm": (g.base_radii - g.base_radius) * MM_PER_M,
            "radial": g.radial,
            "tangential": g.tangential,
            "platform_radius_mm": g.platform_radius * MM_PER_M,
            "upper_arm_mm": g.upper_arm_length * MM_PER_M,
            "forearm_mm": g.forearm_length * MM_PER_M,
            "width_mm": placement.parallelogram_width_mm,
            "pinion_mm": placement.pinion_centre_mm,
            "ratio": placement.drive_ratio,
            "springs_mm": placement.springs_mm,
            "eye_inside_mm": placement.eye_inside_mm,
            "force_N": force_N,
            "inertia": {
                "carried_kg": inertia.carried_mass,
                "elbow_kg": inertia.elbow_mass,
                "cross_kg": inertia.cross_mass,
                "joint_kg_m2": inertia.joint_inertia,
            },
            "friction": rubs,
            "encoder_count_rad": handle.encoder_count_rad,
        }
    )


def scene(s: Subject, handle: Handle) -> dict[str, Any]:
    """Gathers the machine as JSON types, lengths in mm.

    Returns:
        `mechanism`, with the stops of the arms and the lean of the rods, rad; `parts`, what a person reads of each;
        `occurrences`, link, part and (3,) way in the exploded view of each; `home_mm`, `cube`, `outline`.
    """
    moves, numbers = exploded(s.assembly, s.meshes), {part.number: k for k, part in enumerate(s.assembly.parts)}
    return {
        "mechanism": mechanism(s.assembly.placement, s.design.requirements.force_N, handle)
        | plain({"shoulder_rad": s.dimensions.stops_rad, "lean_rad": s.dimensions.forearm.tilt_limit_rad}),
        "parts": [
            {
                "number": part.piece_of or part.number,
                "description": part.description,
                "material": part.material.name,
                "make": part.is_drawn,
                "mass_g": plain(G_PER_KG * s.masses["parts"][part.number]["mass_kg"], 4),
            }
            for part in s.assembly.parts
        ],
        "occurrences": {
            o.name: [o.link, numbers[o.part.number], plain(moves[o.name], _DIGITS)] for o in s.assembly.occurrences
        },
        "home_mm": plain(s.assembly.home_mm),
        "cube": {
            "bottom_mm": s.limits.bottom_height_mm,
            "half_mm": s.limits.half_side_mm,
            "centre_x_mm": s.limits.centre_x_mm,
        },
        "outline": {"centre_mm": plain(s.stage.envelope_centre_mm), "size_mm": plain(s.stage.envelope_mm)},
    }


FILE_NAME = PAGE
# What is offered to download: the file, and what it is for.
_DOWNLOADS = (
    (ARCHIVE, "Everything"),
    ("quotation.zip", "Quotation"),
    ("assembly.step", "STEP assembly"),
    ("drawings/assembly.pdf", "Assembly drawing"),
    ("bom.csv", "Bill of materials"),
    ("design.json", "Design file"),
)
SEARCHED = "design.html"  # which `design` writes beside what it found
_CERTIFICATE = "certificate.json"  # which only some builds have beside them
_MANUAL = "manual/manual.html"  # which a build may be asked to leave out
ASSETS = Path(__file__).parent / "assets"
VENDOR = Path(__file__).parent / "vendor"
_SCRIPTS = ("kinematics.js", "picture.js", "viewer.js", "grip.js", "maps.js")  # and the page's own
# Columns of the bill of materials that come first; others that a build may write follow. Sources stand with what is
# described.
COLUMNS = (
    "item", "part_number", "description", "quantity", "make_or_buy", "specification", "unit_mass_g", "total_mass_g",
    "unit_cost_EUR", "total_cost_EUR",
)  # fmt: skip
_SPECIFIED = ("material", "standard", "order_code")  # told in one column, which a page is wide enough for
_SOURCES = ("source", "cost_source")


def write_report(s: Subject, folder: Path, versions: Mapping[str, str], poor: str = "") -> Path:
    """Writes the page of a build into its folder, where all other files but archive and manifest are.

    Args:
        s: The machine and its checks.
        folder: Holds `assembly.glb` and `bom.json`; its files are linked, and the archive that comes after the page.
        versions: Program -> version, as the manifest tells them.
        poor: In what a machine that passes is poor; "" for nothing.

    Returns:
        The file.

    Raises:
        OSError, ReadError: A file cannot be read or written.
    """
    handle = handle_of(s)
    over = fields(s, handle) if s.reachable else []
    data = scene(s, handle) | {"slices": maps(s, over)}
    rows = [_specified(row) for row in read_json(folder / "bom.json")["items"]]
    files = _files(folder)
    certified = certificate(s.design, folder / _CERTIFICATE)
    text = moving_page(
        "page.html",
        "main.js",
        ("page.css",),
        s.design.name,
        data,
        {"model": (folder / "assembly.glb").read_bytes()},
        name=s.design.name,
        poor=poor,
        passed=all(result.passed for result in s.results),
        counted=(sum(result.passed for result in s.results), len(s.results)),
        headline=headline(s, over),
        lengths=lengths(s),
        requested=requirements(s.results),
        binding=binding(s.results),
        failures=failures(s.results),
        kinds=kinds(s.results),
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
        manual=_MANUAL if (folder / _MANUAL).is_file() else "",
        files=files,
        downloads=_downloads(folder),
        drawn={name for group, names in files if group == "drawings" for name, _ in names},
        searched=SEARCHED if (folder / SEARCHED).is_file() else "",
    )
    path = folder / FILE_NAME
    path.write_text(text, encoding="utf-8")
    return path


def moving_page(
    template: str,
    script: str,
    styles: Sequence[str],
    title: str,
    data: Any,
    models: Mapping[str, bytes],
    **given: Any,
) -> str:
    """Writes a page that draws machines in 3D, in one text that asks for nothing elsewhere.

    Args:
        template: Which extends `frame.html`.
        script: The page's own, after those that all share.
        styles: Files of its style.
        title: Of the window.
        data: JSON types that its script reads.
        models: Name of an element -> GLB file that its script reads there.
        given: What the template is given besides.
    """
    from markupsafe import Markup

    scripts = [script_text(VENDOR / "three.js"), *(script_text(ASSETS / name) for name in (*_SCRIPTS, script))]
    style = "".join((ASSETS / name).read_text(encoding="utf-8") for name in styles)
    return (
        environment()
        .get_template(template)
        .render(
            **given,
            title=title,
            policy=page_policy(scripts, style),
            style=Markup(style),
            scripts=[Markup(one) for one in scripts],
            licence=Markup((VENDOR / "three.LICENSE").read_text(encoding="utf-8").strip()),
            data=Markup(json_script(data)),
            models={name: Markup(b64encode(glb).decode("ascii")) for name, glb in models.items()},
        )
    )


def environment(*folders: Path) -> Environment:
    """Makes the environment of the templates in folders and here: values are escaped, a missing one is an error."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    tidy = {"trim_blocks": True, "lstrip_blocks": True, "undefined": StrictUndefined}
    return Environment(loader=FileSystemLoader([*folders, ASSETS]), autoescape=True, **tidy)


def script_text(path: Path) -> str:
    """Reads a script that no tag within ends."""
    return path.read_text(encoding="utf-8").replace("</script", "<\\/script")


def json_script(data: Any) -> str:
    """Writes JSON that no tag within ends, whatever names it holds."""
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
    stated = [str(row[key]) for key in _SPECIFIED if row.get(key) not in ("", None)]
    rest = {key: value for key, value in row.items() if key not in _SPECIFIED}
    return rest | ({"specification": "; ".join(dict.fromkeys(stated))} if stated else {})


def _columns(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    found = {key for row in rows for key, value in row.items() if value not in ("", None)}
    return [key for key in COLUMNS if key in found] + sorted(found - {*COLUMNS, *_SOURCES})


def _downloads(folder: Path) -> list[tuple[str, str, int]]:
    """Name, purpose and size in bytes of what is offered; the archive, which holds this page, is of no size yet."""
    found = [(name, words, folder / name) for name, words in _DOWNLOADS]
    return [
        (name, words, path.stat().st_size if path.is_file() else 0)
        for name, words, path in found
        if path.is_file() or name == ARCHIVE
    ]


def _files(folder: Path) -> list[tuple[str, list[tuple[str, int]]]]:
    """Sub-folder -> its files with their sizes in bytes, those of the folder itself first."""
    groups: dict[str, list[tuple[str, int]]] = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name != FILE_NAME:
            name = path.relative_to(folder).as_posix()
            groups.setdefault(name.rpartition("/")[0], []).append((name, path.stat().st_size))
    return sorted(groups.items())
