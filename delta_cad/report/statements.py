"""What stands in sentences: what was assumed, what is proved over the whole cube, where the machine comes from."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from delta_cad.common.reading import ReadError, read_json
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design, design_hash
from delta_cad.dimensions.joint import FRICTION_RANGE
from delta_cad.drive import drive_torque
from delta_cad.drive.friction import COULOMB
from delta_cad.mechanism.limits import GeometryError, Limits
from delta_cad.report.subject import Subject
from delta_cad.structure.beam_model import beam_model
from delta_cad.structure.report import LEFT_OUT
from delta_cad.structure.strength import LIFE_HOURS, STROKES_PER_S

_CERTIFICATE_SCHEMA = "delta-certificate/1"
_PLAINLY = {
    "reach": "within reach",
    "assembly_mode": "no singular position",
    "torque": "joint torque",
    "kappa": "conditioning",
    "lean": "lean of the rods",
    "shoulder": "arms between their stops",
    "couple_index": "platform held against turning",
}
"""Limit -> what it means."""


def assumptions(s: Subject) -> list[str]:
    """Lists what the figures rest upon."""
    table, drive = beam_model(s.dimensions), drive_torque(s.design)
    low, nominal, high = FRICTION_RANGE
    least, usual, most = (f"{100.0 * share:g}" for share in COULOMB)
    gravity = ", ".join(f"{component:g}" for component in s.design.requirements.gravity_m_s2)
    found = [
        f"Everything here is computed from the model; nothing was measured on a device. The position of the handle is "
        f"that of the platform's centre; the knob is {table.knob_mm:g} mm over the wrists.",
        f"Gravity acts along ({gravity}) m/s² in the base frame.",
        "Limits of the mechanism, clearance and outline are proved for every position in the cube, where the checks "
        f"say so; other figures are sampled on {len(s.limits.poses_mm())} positions, corners included.",
        f"Stiffness is with actuators held. Left out: {LEFT_OUT}. A ball joint with its rod's end is taken as "
        f"{table.joint_N_mm:.0f} N/mm.",
        f"Friction is nominal: ball joints slide at {nominal:g} ({low:g} to {high:g}); of a motor's idle friction "
        f"{usual} % does not depend on the speed ({least} to {most} %).",
        f"A motor gives its continuous torque without end at 25 °C ambient; {100.0 * drive.efficiency:g} % of it reach "
        f"the joint, times the ratio.",
        f"Lives are computed for {LIFE_HOURS:g} h at {STROKES_PER_S:g} full strokes a second under the whole force.",
    ]
    if s.unverified:
        found.append(f"Verify before ordering, data not fully verified: {', '.join(s.unverified)}.")
    return found


def certificate(design: Design, path: Path) -> dict[str, Any]:
    """Tells what a certificate proves, if there is one and it is about a design.

    Returns:
        `found`: whether it is; `words`: one sentence; `proved`, `open`: conditions in words.
    """
    nothing: dict[str, Any] = {"found": False, "words": "", "proved": [], "open": []}
    if not path.is_file():
        return nothing
    try:
        data = read_json(path)
        if data["schema"] != _CERTIFICATE_SCHEMA or data["design_hash"] != design_hash(design):
            return nothing | {"words": f"{path.name} in this folder is about another design."}
        return {"found": True} | _proved(data, 2.0 * design.cube.half_side_mm)
    except (ReadError, GeometryError, ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        return nothing | {"words": f"{path.name} in this folder cannot be read."}


def proof(s: Subject) -> dict[str, Any]:
    """Proves the limits of the mechanism at every point of the cube, where no certificate stands beside the page.

    Returns:
        `words`: one sentence; `proved`, `open`: the limits in words.
    """
    from delta_cad.mechanism.proof.prove import prove

    cube = s.design.cube
    try:
        found = prove(s.design.geometry, s.design.workspace, s.limits.pose)
    except GeometryError as error:
        return {"words": f"Nothing is proved of this cube: {error}.", "proved": [], "open": []}
    words = {limit.name: limit.words(_strictly) for limit in s.limits.pose}
    return {
        "words": f"This build proved by interval arithmetic over {found.boxes} boxes, which fill the cube of "
        f"{2.0 * cube.half_side_mm:.2f} mm, that at every point of it, not only at those sampled:",
        **_sorted((_plainly(one.condition, words[one.condition]), one.verdict) for one in found.findings),
    }


def _sorted(findings: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Findings, a sentence and a verdict each, by whether they are proved."""
    listed = list(findings)
    return {
        "proved": [text for text, verdict in listed if verdict == "proved"],
        "open": [f"{text}: {verdict}" for text, verdict in listed if verdict != "proved"],
    }


def _proved(data: Any, side_mm: float) -> dict[str, Any]:
    """What the data of a certificate prove; raises one error or another where they are none."""
    words = {limit.name: limit.words(_strictly) for limit in Limits.from_record(data["limits"])}
    tolerance, names = data.get("tolerance_m"), [str(one["condition"]) for one in data["findings"]]
    verdicts = [str(one["verdict"]) for one in data["findings"]]
    machines = "" if tolerance is None else f", for every machine within {MM_PER_M * tolerance:.3g} mm of the drawn one"
    return {
        "words": f"Proved at every point of the cube of {side_mm:.2f} mm, not only at those sampled, by "
        f"{int(data['boxes'])} boxes that fill it{machines}:",
        **_sorted(
            (_plainly(name, words.get(name, name.replace("_", " "))), verdict)
            for name, verdict in zip(names, verdicts, strict=True)
        ),
    }


def _plainly(name: str, words: str) -> str:
    """A limit in the words of a customer before those of its mathematics."""
    return f"{_PLAINLY[name]}: {words}" if name in _PLAINLY else words


def _strictly(value: float, upwards: bool) -> str:
    """A threshold to five digits, rounded to the lax side, so that what is proved of it is still true."""
    if value == 0.0:
        return "0"
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 4)
    return f"{(math.ceil if upwards else math.floor)(round(value / step, 6)) * step:.5g}"


def provenance(s: Subject, versions: dict[str, str]) -> dict[str, Any]:
    """Tells where the machine comes from: how its lengths were found, what built it, and the command."""
    name, masses = s.design.name, "--mass-properties mass_properties.json"
    return {
        "input_sha256": design_hash(s.design),
        "command": f"python -m delta_cad build --design {name}.json",
        "certify": f"python -m optimizer certify --design {name}.json {masses}",
        "verify": f"python -m optimizer verify certificate.json --design {name}.json {masses}",
        "lengths": {key: value for key, value in s.design.provenance.items() if isinstance(value, str | int | float)},
        "versions": versions,
    }
