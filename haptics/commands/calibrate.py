"""`calibrate`: lengths, zeros and encoders of a made device from poses at known positions."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, refuse
from delta_cad.common.options import CATALOGUE, DESIGN, JSON, Option, number

if TYPE_CHECKING:
    from delta_cad.design import Design
    from haptics.calibration.accuracy import Proposal
    from haptics.calibration.fit import Fit
    from haptics.calibration.poses import Poses
    from haptics.calibration.record import Calibration

NAME = "calibrate"
TEXT = "calibrate zeros, link lengths, offsets and encoder errors from measured poses, with uncertainties"
OPTIONS = (
    Option(
        "poses",
        type=Path,
        metavar="POSES.csv",
        help="x_mm, y_mm, z_mm of the platform's centre and reading_0_deg to reading_2_deg, one pose per line",
    ),
    DESIGN,
    CATALOGUE,
    Option(
        "--frame",
        choices=("base", "own"),
        default="base",
        help="frame of the positions: the base frame, or an unknown one that is fitted, too; default: base",
    ),
    Option(
        "--position-sigma",
        type=number(1e-4, 10.0, "mm"),
        default=0.02,
        metavar="MM",
        help="standard deviation of a coordinate, mm; default: 0.02",
    ),
    Option(
        "--reading-sigma",
        type=number(1e-5, 5.0, "degrees"),
        metavar="DEG",
        help="standard deviation of a reading, degrees; default: noise of the encoder",
    ),
    Option(
        "--accuracy",
        type=number(1e-3, 10.0, "mm"),
        default=0.1,
        metavar="MM",
        help="largest predicted error of a position in the cube (rms at the worst position), mm; default: 0.1",
    ),
    Option(
        "--out",
        type=Path,
        default=Path("calibration.json"),
        metavar="FILE",
        help="file to write if the poses pass; default: calibration.json",
    ),
    JSON,
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    import math

    from delta_cad.common.files import require_room
    from delta_cad.common.units import MM_PER_M
    from delta_cad.design import load_design
    from delta_cad.drive import encoder_count_rad
    from haptics.calibration.accuracy import accuracy, helpful_poses
    from haptics.calibration.diagnosis import MISFIT_MOST, UNLIKE_MOST, causes, fits
    from haptics.calibration.fit import FitError, Noise, fit
    from haptics.calibration.poses import load_poses
    from haptics.calibration.record import calibration_of, save_calibration, to_dict
    from haptics.model.machine import require_assembled

    design = load_design(given.design, given.catalogue)
    require_assembled(design, given.design)
    turns, wave, angle = _encoder(design)
    if given.reading_sigma is not None:
        angle = math.radians(given.reading_sigma)
    noise = Noise(given.position_sigma / MM_PER_M, angle)

    def fitted(poses: Poses, own_frame: bool) -> Fit:
        return fit(design.geometry, poses, turns=turns, noise=noise, own_frame=own_frame, wave=wave)

    poses = load_poses(given.poses)
    require_room(given.out, folder=False)
    own = given.frame == "own"
    limit, about = given.accuracy / MM_PER_M, (encoder_count_rad(design), design.geometry.three_fold)
    try:
        found = fitted(poses, own)
        fit_for_use = fits(found)
        reasons = [] if fit_for_use else causes(fitted, poses, own, found, *about)
        expected = accuracy(found, design)
        more = helpful_poses(found, design, limit) if fit_for_use and expected.worst > limit else None
    except FitError as error:
        said = [f"{given.poses.name}: {error}"]
        said += [f"likely cause: {cause.text}" for cause in causes(fitted, poses, own, error, *about)]
        return refuse("; ".join(said), BAD_INPUT)
    calibration = calibration_of(design, found, len(poses.positions), expected)
    kept = fit_for_use and expected.worst <= limit
    if kept:
        save_calibration(calibration, given.out)
    if given.json:
        facts = {**to_dict(calibration), "passed": kept, "misfit_max": MISFIT_MOST, "accuracy_max_mm": given.accuracy}
        facts |= {"causes": [asdict(cause) for cause in reasons], "helpful_poses": _proposed(more)}
        print(json.dumps({**facts, "file": str(given.out) if kept else None}, indent=1, allow_nan=False))
        return DONE if kept else NOT_MET
    _print(calibration)
    if not fit_for_use:
        (sigmas, farthest), worst = found.unlike, found.after.argmax()
        what = (
            f"what is left is {found.misfit:.1f} times what noise explains, more than {MISFIT_MOST:g}: "
            f"pose {worst + 1} is off by {MM_PER_M * found.after[worst]:.3f} mm"
        )
        if found.misfit <= MISFIT_MOST:
            what = f"{farthest}, {sigmas:.0f} standard deviations of a part's; at most {UNLIKE_MOST:g} are taken"
        print(f"NOT KEPT  {what}; nothing is written")
        for cause in reasons:
            print(f"likely cause: {cause.text}; the misfit is {cause.misfit:.2f} then")
        return NOT_MET
    print(f"what is left is {found.misfit:.2f} times what noise explains")
    if more is not None:
        print(
            f"NOT KEPT  the predicted error is {MM_PER_M * expected.worst:.3f} mm at worst, at most "
            f"{given.accuracy:g} mm is taken (--accuracy); nothing is written"
        )
        places = ", ".join("({:.1f}, {:.1f}, {:.1f})".format(*row) for row in MM_PER_M * more.positions)
        print(f"measure as well, x, y, z of the base frame in mm: {places}")
        print(f"with these {len(more.positions)} poses the error is {MM_PER_M * more.accuracy.worst:.3f} mm at worst")
        return NOT_MET
    print(f"written to {given.out}")
    return DONE


def _proposed(more: Proposal | None) -> dict[str, Any] | None:
    """Further poses as JSON types."""
    from delta_cad.common.units import MM_PER_M

    if more is None:
        return None
    return {
        "positions_mm": (MM_PER_M * more.positions).round(3).tolist(),
        "predicted_rms_mm": MM_PER_M * more.accuracy.rms,
        "predicted_worst_mm": MM_PER_M * more.accuracy.worst,
    }


def _encoder(design: Design) -> tuple[float, float, float]:
    """Turns of an encoder in one of the arm; how far its waves and one reading may be off, rad."""
    import math

    from delta_cad import catalogue
    from delta_cad.drive import drive_torque, encoder_count_rad
    from haptics.calibration.unknowns import WAVE_SIGMA

    count = encoder_count_rad(design)
    if design.hardware.encoder_at == "motor":
        return drive_torque(design).ratio, WAVE_SIGMA, count
    row = catalogue.encoder.chosen(design.hardware)
    wave = max(WAVE_SIGMA, math.radians(row.nonlinearity_deg or 0.0))
    # a pose is noted from many readings, but the handle does not sit still to better than some thousandths of a degree
    return 1.0, wave, max(count, math.radians(row.noise_rms_deg or 0.0), math.radians(0.003))


def _print(calibration: Calibration) -> None:
    from haptics.calibration.record import to_dict

    record, f = to_dict(calibration), calibration.fit
    frame = "a frame of their own" if f["frame"] == "own" else "the base frame"
    print(f"{calibration.name}: {f['poses']} poses, positions in {frame}")
    before = "not reached" if f["before_rms_mm"] is None else f"{f['before_rms_mm']:.3f} mm rms"
    print(f"off as drawn {before}, calibrated {f['after_rms_mm']:.3f} mm rms; "
          f"worst {f['worst_mm']:.3f} mm at pose {f['worst_pose']}")  # fmt: skip
    at = ", ".join(f"{f[f'predicted_worst_{axis}_mm']:.1f}" for axis in "xyz")
    print(f"predicted error over the cube {f['predicted_rms_mm']:.3f} mm rms; "
          f"worst {f['predicted_worst_mm']:.3f} mm at ({at}) mm")  # fmt: skip
    print(f"\n{'':22}" + "".join(f"{f'chain {i}':>22}" for i in range(3)))
    for key in record["chains"][0]:
        cells = zip(record["chains"], record["uncertainty"], strict=True)
        print(f"{key:22}" + "".join(f"{f'{value[key]:.4f} +- {sigma[key]:.4f}':>22}" for value, sigma in cells))
    print()
    for sentence in calibration.unidentifiable:
        print(f"- {sentence}")
