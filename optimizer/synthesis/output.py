"""The design file of a result, with where it comes from."""

from __future__ import annotations

import errno
import importlib.metadata
import math
import os
from itertools import product
from pathlib import Path
from typing import Any

from delta_cad.common.files import write_whole
from delta_cad.common.reading import ReadError, read_json
from delta_cad.common.refusal import short
from delta_cad.design import Design, design_from_dict, design_to_json
from delta_cad.mechanism.geometry import azimuth_cosine
from delta_cad.mechanism.limits import LIMITS
from optimizer.problem.requirements import Requirements, requirements_hash
from optimizer.problem.step import step_problem
from optimizer.problem.variables import COSINE, SIDE, azimuth_deg, design_fields
from optimizer.search.result import Result

UNFINISHED = "unfinished"  # key of the provenance, only of a design that its run did not end with
_DECIMALS = 3  # decimals of a length in mm: one micrometre, finer than anything is machined to
_AZIMUTH_DECIMALS = 4  # of the azimuth in degrees: less than a micrometre on a radius of half a metre
_SAME_UM = 1e-3  # a half side this close below a whole micrometre counts as that: metres and back cost 1e-11
_DIGITS = 8  # digits of the figures in the provenance; solvers end within 1e-9
_GAP_DIGITS = 3  # digits of a gap, which is itself a small difference of two such figures
_GIVEN_UP_UM = 5  # most micrometres that the half side gives up: one of the other lengths is worth less than one or two


class OtherDesignError(ValueError):
    """A file in the place of the design that is of another origin, or no design at all; it is left as it is."""


class DesignFile:
    """The design file of one run: its best so far until the run ends, then its design.

    An unfinished design says so in its provenance and takes the place of no finished one. A file of another origin,
    with another name, of other requirements or without provenance, is replaced by force alone, and only at the end.

    Attributes:
        path: The file.
        kept: Whether the best of this run stands there so far.
    """

    def __init__(self, path: Path, given: Requirements, force: bool = False) -> None:
        """Looks at what stands there.

        Args:
            path: The file, there or not.
            given: What the customer gave.
            force: Whether a file of another origin may be replaced.

        Raises:
            OtherDesignError: It may not; the message names the field that differs and what to do.
            OSError: There is something that is no file.
        """
        self.path, self.kept = path, False
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not path.exists():
            self._open = True
            return
        try:
            provenance = _provenance(path, given)
        except OtherDesignError:
            if not force:
                raise
            provenance = {}
        self._open = UNFINISHED in provenance

    def keep(self, design: Design) -> None:
        """Writes an unfinished design, unless what stands there must wait for a finished one."""
        if self._open:
            write_design(design, self.path)
            self.kept = True

    def finish(self, design: Design) -> None:
        """Writes the design of the whole run."""
        write_design(design, self.path)
        self.kept = True

    def withdraw(self) -> None:
        """Takes away what `keep` wrote, where the run ends without a design."""
        if self.kept:
            self.path.unlink(missing_ok=True)
            self.kept = False


def _provenance(path: Path, given: Requirements) -> dict[str, Any]:
    """Reads where a design comes from; refuses one that is not of these requirements."""
    leave = "to replace it give --force, to leave it another --out"
    try:
        data = read_json(path)
    except ReadError as error:
        raise OtherDesignError(f"{error}; {leave}") from None
    name, found = (data.get("name"), data.get("provenance")) if isinstance(data, dict) else (None, None)
    if name != given.name:
        raise OtherDesignError(f"{path.name}: name = {short(name)}: must be {short(given.name)}; {leave}")
    digest = found.get("requirements_sha256") if isinstance(found, dict) else None
    own = requirements_hash(given)
    if not isinstance(found, dict) or digest != own:
        field = f"{path.name}: provenance.requirements_sha256 = {short(digest)}"
        raise OtherDesignError(f"{field}: must be {own}, that of these requirements; {leave}")
    return found


def design_of(
    given: Requirements,
    results: list[Result],
    method: str,
    seed: int,
    file: str,
    command: str | None = None,
    unfinished: str | None = None,
    folder: Path = Path(),
) -> Design:
    """Makes a design of the last result.

    Args:
        given: What the customer gave; its limits become the design's requirements.
        results: One for each step, the last of them wanted.
        method: Method that found them.
        seed: Seed of that method.
        file: Name that error messages start with.
        command: Command that makes the file again, for its provenance; None leaves it out.
        unfinished: What is still to come, for its provenance; None where the run is done.
        folder: Where its file will stand: a folder of own parts is named from there.

    Raises:
        DesignError: The design file refuses the lengths.
    """
    mechanism, cube = design_fields(presentable(results[-1]))
    limits, task = given.limits, given.requirements
    task_fields: dict[str, Any] = task.model_dump()
    task_fields |= {
        f.name: given.values[f.name] for limit in LIMITS for f in limit.fields_ if given.values[f.name] is not None
    }
    if limits.clearance_min_mm is not None:
        task_fields["clearance_min_mm"] = limits.clearance_min_mm
    task_fields["gravity_m_s2"] = list(limits.gravity_m_s2)
    data = {
        "schema": "delta-design/1",
        "name": given.name,
        "mechanism": mechanism | {"parallelogram_width_mm": limits.parallelogram_width_mm},
        "cube": cube,
        "requirements": task_fields,
        "hardware": given.hardware_from(folder),
        "provenance": {
            "program": "optimizer synthesize",
            "version": importlib.metadata.version("delta-haptics"),
            "method": method,
            "seed": seed,
            **({} if command is None else {"command": command}),
            "requirements_sha256": requirements_hash(given),
            **({} if unfinished is None else {UNFINISHED: unfinished}),
            "steps": [_step(result) for result in results],
        },
    }
    return design_from_dict(data, file, folder)


def presentable(result: Result) -> tuple[float, ...]:
    """Rounds the lengths of a result to whole micrometres, its azimuth to 1e-4 degrees, for manufacturing.

    Each is rounded up or down and the half side down: the choice nearest to what was found that the result's own check
    on the surface of the cube lets pass. The half side gives way by a micrometre more where none does. The lengths
    stay as they were found where that fails too, or where the half side is fixed to another figure.

    Returns:
        (9) in the order of `VARIABLES`, mm.
    """
    lengths_mm, problem = result.design_mm, result.problem
    if not result.feasible:
        return lengths_mm
    choices = [_rounded(v) for v in lengths_mm]
    choices[COSINE] = [azimuth_cosine(v) for v in _rounded(azimuth_deg(lengths_mm[COSINE]), _AZIMUTH_DECIMALS)]
    floor = math.floor(lengths_mm[SIDE] * 10**_DECIMALS + _SAME_UM)
    for um in range(_GIVEN_UP_UM + 1):
        side = (floor - um) / 10**_DECIMALS
        if side <= 0.0:  # no cube is left
            break
        smaller = step_problem(problem.requirements, problem.step, side)
        ranges = list(zip(smaller.lower, smaller.upper, strict=True))
        choices[SIDE] = [side]
        kept = [[v for v in c if low <= v <= high] for c, (low, high) in zip(choices, ranges, strict=True)]
        nearest_first = sorted(product(*kept), key=lambda lengths: math.dist(lengths, lengths_mm))
        for lengths in nearest_first:
            if Result(smaller, result.method, lengths, result.status).feasible:
                return lengths
    return lengths_mm


def _rounded(value: float, decimals: int = _DECIMALS) -> list[float]:
    """Rounds a length or an angle down and up; the nearer one comes first."""
    scaled, unit = value * 10**decimals, 10**decimals
    return sorted({math.floor(scaled) / unit, math.ceil(scaled) / unit}, key=lambda v: abs(v - value))


def write_design(design: Design, path: Path) -> None:
    """Writes a design file whole or not at all: beside its place, then renamed."""
    write_whole(path, design_to_json(design))


def _step(result: Result) -> dict[str, Any]:
    """Gathers what the provenance has of a step, without the digits in which two machines' arithmetic differs."""
    record = result.record()
    names = ("step", "objective", "objective_name", "status", "max_torque_N_m", "max_kappa", "proven_bound", "gap")
    digits = {"gap": _GAP_DIGITS}
    return {
        name: float(f"{value:.{digits.get(name, _DIGITS)}g}") if isinstance(value := record[name], float) else value
        for name in names
    }
