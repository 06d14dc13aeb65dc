"""`simulate`: a scene of the paper on the simulated device, its series and figures, and what differs from the paper."""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, ProgressLine, print_result, refuse
from delta_cad.common.options import JSON, OUT_FOLDER, SEED, Option, number
from haptics.commands.device import DEVICE_OPTIONS, LOOP_OPTIONS, loop_given

if TYPE_CHECKING:
    from haptics.loop.choice import LoopChoice
    from haptics.model.machine import MachineModel
    from haptics.scenes.record import Scene

NAME = "simulate"
TEXT = "simulate a scene: operating resistance, way home, virtual walls, or encoder noise"
_SCENES = ("resistance", "home", "wall", "noise")
_HANDS = ("light", "medium", "firm")
_SCHEMA = "haptics-simulation/1"
_DELAY_MS = 0.5  # From reading to torque: half a period, the nominal one of `assumptions.DELAY`
_LONGEST_MS = 10.0  # Ten periods; nothing that is called haptic waits so long
_MS_PER_S = 1000.0
OPTIONS = (
    *DEVICE_OPTIONS,
    *LOOP_OPTIONS,
    Option("--scene", required=True, choices=_SCENES, help="scene to simulate"),
    Option("--hand", choices=_HANDS, help="who holds the handle, scene wall only; default: medium"),
    Option(
        "--differs",
        action="store_true",
        help="repeat the scene with one assumption changed at a time, to explain differences from the paper; not for "
        "noise",
    ),
    Option(
        "--delay",
        type=number(0.0, _LONGEST_MS, "ms"),
        default=_DELAY_MS,
        metavar="MS",
        help=f"delay of the paper loop from reading to torque, ms; default: {_DELAY_MS:g}",
    ),
    SEED.but(help="random seed, of the encoder counts; default: 0"),
    OUT_FOLDER,
    Option("--plot", action="store_true", help="also draw pictures"),
    JSON,
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    if given.hand is not None and given.scene != "wall":
        return refuse(f"--hand {given.hand}: of the scene wall only; --scene {given.scene} has no hand", BAD_INPUT)
    if given.differs and given.scene == "noise":
        return refuse("--differs: not of the scene noise, which is none of the paper's", BAD_INPUT)
    chosen = loop_given(given)
    if given.delay != _DELAY_MS and (given.scene == "noise" or chosen):
        return refuse(f"--delay {given.delay:g}: of the paper loop only; another has loop.delay_ticks", BAD_INPUT)
    if chosen and (given.differs or given.scene not in ("wall", "noise")):
        return refuse("--rate, --damping, --drive-damping: of the scenes wall and noise, without --differs", BAD_INPUT)
    if given.plot:
        import matplotlib  # noqa: F401  # if it is missing, tell so before anything is simulated
    from delta_cad.common.files import require_room
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.mass_properties, given.catalogue)
    loop = _loop(machine, given)
    folder = given.out / f"{machine.design.name}-{given.scene}"
    require_room(folder, folder=True)
    with ProgressLine() as line:
        line.show(f"{given.scene}: simulating")
        scene = _scene(machine, given, loop)
        if given.differs:
            scene = _differs(machine, given, scene, line)
        line.show(f"{given.scene}: writing")
        facts = _plain(_facts(machine, given, scene, loop))
        facts["files"] = _write(folder, machine, scene, facts, given.plot)
    print_result(given, facts, lambda: _print(facts, folder))
    return DONE if scene.kept else NOT_MET


def _loop(machine: MachineModel, given: argparse.Namespace) -> LoopChoice:
    """The paper loop for its figures unless an option chooses another; the device's own for noise."""
    from dataclasses import replace

    from haptics.loop.choice import PAPER, chosen_loop

    if given.scene == "noise" or loop_given(given):
        return chosen_loop(machine.design, given.rate, given.damping, given.drive_damping)
    return replace(PAPER, delays=(0.0, given.delay / _MS_PER_S / PAPER.period, 1.0))


def _scene(machine: MachineModel, given: argparse.Namespace, loop: LoopChoice) -> Scene:
    delay = given.delay / _MS_PER_S
    if given.scene == "resistance":
        from haptics.scenes.resistance import resistance

        return resistance(machine, delay=delay, seed=given.seed)
    if given.scene == "home":
        from haptics.scenes.home import home

        return home(machine, delay=delay, seed=given.seed)
    if given.scene == "noise":
        from haptics.scenes.noise import noise

        return noise(machine, loop=loop, seed=given.seed)
    from haptics.scenes.wall import wall

    other = loop if loop_given(given) else None
    return wall(machine, hand=given.hand or "medium", delay=delay, seed=given.seed, loop=other)


def _differs(machine: MachineModel, given: argparse.Namespace, scene: Scene, line: ProgressLine) -> Scene:
    """The scene with other assumptions' cases among its facts and in its discussion."""
    from dataclasses import asdict, replace

    from haptics.scenes.differs import cases, discussion, figure_cases, figure_discussion

    hand, delay = given.hand or "medium", given.delay / _MS_PER_S

    def show(name: str) -> None:
        line.show(f"{scene.name}: {name}")

    if scene.name == "wall":
        found = cases(machine, hand, delay, given.seed, show)
        said = discussion(found, hand, delay)
    else:
        found = figure_cases(machine, scene.name, delay, given.seed, show)
        said = figure_discussion(scene.name, found)
    facts = scene.facts | {"differs": [asdict(one) for one in found]}
    return replace(scene, facts=facts, discussion=[*scene.discussion, *said])


def _plain(value: Any) -> Any:
    """Facts as JSON has them: what is not finite becomes null."""
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _facts(machine: MachineModel, given: argparse.Namespace, scene: Scene, loop: LoopChoice) -> dict[str, Any]:
    from delta_cad.design import design_hash
    from haptics.gravity.published import of_published_lengths
    from haptics.loop.assumptions import encoder_count, nominal_plant
    from haptics.loop.simulation import SUBSTEPS

    par = nominal_plant(machine)
    return {
        "schema": _SCHEMA,
        "name": machine.design.name,
        "design_sha256": design_hash(machine.design),
        "scene": scene.name,
        "paper_figures": scene.figures,
        "published_lengths": of_published_lengths(machine.geometry),
        "assumptions": {
            "loop": loop.label,
            "period_s": loop.period,
            "substeps": SUBSTEPS,
            "delay_s": loop.delay,
            "seed": given.seed,
            "current_lag_s": loop.current_lag,
            "velocity_filter_Hz": loop.corner,
            "encoder_count_rad": encoder_count(machine),
            "coulomb_friction_N_m": par.coulomb,
            "viscous_friction_N_m_s_per_rad": par.viscous,
            "presliding_rad": par.presliding,
        },
        **scene.facts,
        "runs": [{"name": run.name, "label": run.label, **run.facts} for run in scene.runs],
        "promises": [{"text": promise.text, "kept": promise.kept} for promise in scene.promises],
        "discussion": scene.discussion,
    }


def _write(folder: Path, machine: MachineModel, scene: Scene, facts: dict[str, Any], plot: bool) -> dict[str, Any]:
    """Writes everything, whole or not at all, and returns what was written."""
    from delta_cad.common.files import whole_folder
    from haptics.scenes.record import write_csv, write_parquet

    with whole_folder(folder) as part:
        (part / "series").mkdir()
        parquet = True
        for run in scene.runs:
            write_csv(part / "series" / f"{run.name}.csv", run.series)
            parquet = write_parquet(part / "series" / f"{run.name}.parquet", run.series) and parquet
        names = [f"series/{run.name}.csv" for run in scene.runs]
        names += [f"series/{run.name}.parquet" for run in scene.runs] if parquet else []
        if plot:
            from haptics.scenes.pictures import PICTURES, save

            save(PICTURES[scene.name](scene, machine.design.name), part / f"{scene.name}.png")
            names.append(f"{scene.name}.png")
        files = {"folder": str(folder), "names": ["facts.json", *names], "parquet": parquet}
        text = json.dumps({**facts, "files": files}, indent=1, allow_nan=False)
        (part / "facts.json").write_text(text + "\n", encoding="utf-8")
    return files


def _print(facts: dict[str, Any], folder: Path) -> None:
    paper = ""
    if facts["scene"] != "noise":
        machine = "its lengths" if facts["published_lengths"] else "another machine: other lengths"
        paper = f" for {facts['paper_figures']} of [RCIM2018], {machine}"
    assumed = facts["assumptions"]
    print(f"{facts['name']}: {facts['scene']}{paper}; {assumed['loop']}; seed {assumed['seed']}")
    printers = {"resistance": _print_resistance, "home": _print_home, "wall": _print_wall, "noise": _print_noise}
    printers[facts["scene"]](facts)
    print()
    for sentence in facts["discussion"]:
        print(f"- {sentence}")
    print()
    for promise in facts["promises"]:
        print(f"{'kept    ' if promise['kept'] else 'NOT KEPT'}  {promise['text']}")
    without = "" if facts["files"]["parquet"] else "; pyarrow is not installed: no parquet, CSV alone"
    print(f"{len(facts['files']['names'])} files in {folder}{without}")


def _print_resistance(facts: dict[str, Any]) -> None:
    for name, s in facts["settings"].items():
        print(
            f"{name}: k {s['stiffness_N_per_m']:g} N/m, r0 {s['dead_radius_mm']:g} mm, r1 {s['full_radius_mm']:g} mm; "
            f"b {s['damping_asked_N_s_per_m']:g} N s/m asked, {s['damping_applied_N_s_per_m']:.1f} applied"
        )
        print("  corner    motors N   eq. (23) N   on the hand N")
        for run in facts["runs"]:
            if run["setting"] == name:
                print(
                    f"  {run['corner']:8s} {_number(run['corner_force_N'], 3):>9s} "
                    f"{_number(run['law_at_corner_N'], 3):>12s} {_number(run['force_on_the_hand_at_corner_N'], 3):>15s}"
                )


def _print_home(facts: dict[str, Any]) -> None:
    print(f"let go {facts['distance_at_start_mm']:.1f} mm from the origin, k {facts['stiffness_N_per_m']:g} N/m")
    print("  b N s/m   settling s   overshoot mm   at the end mm   shakes um    at Hz   verdict")
    for run in facts["runs"]:
        print(
            f"  {run['damping_applied_N_s_per_m']:7.1f} {_number(run['settling_s'], 3):>12s} "
            f"{run['overshoot_mm']:14.2f} {_number(run['distance_at_end_mm'], 2):>15s} "
            f"{_number(run['swing_um'], 0):>11s} {_number(run['frequency_Hz'], 0):>8s}   {run['verdict']}"
            f"{'' if run['capped'] else ' (uncapped)'}"
        )


def _print_wall(facts: dict[str, Any]) -> None:
    hand = facts["hand"]
    print(f"hand: {hand['name']}, {hand['mass']:g} kg, {hand['damping']:g} N s/m, {hand['stiffness']:g} N/m")
    print("  axis   wall N/mm   penetration mm   force N   swing um    at Hz   verdict")
    for run in facts["runs"]:
        print(
            f"  {run['axis']:4s} {run['stiffness_N_per_mm']:11.2f} {_number(run['penetration_at_end_mm'], 3):>16s} "
            f"{_number(run['force_at_end_N'], 2):>9s} {_number(run.get('swing_um'), 1):>10s} "
            f"{_number(run.get('frequency_Hz'), 0):>8s}   {run['verdict']}"
        )


def _print_noise(facts: dict[str, Any]) -> None:
    s = facts["spring"]
    print(
        f"spring: k {s['stiffness_N_per_m']:g} N/m, b {s['damping_asked_N_s_per_m']:g} N s/m asked, "
        f"{s['damping_applied_N_s_per_m']:.1f} applied; wall: {facts['wall']['stiffness_N_per_mm']:g} N/mm"
    )
    print("  law      encoder   force N rms   predicted   motion um rms   predicted   supervisor")
    for run in facts["runs"]:
        print(
            f"  {run['law']:8s} {run['encoder']:8s} {run['force_N_rms']:12.4f} "
            f"{_number(run['force_predicted_N_rms'], 4):>11s} {run['motion_um_rms']:15.4f} "
            f"{_number(run['motion_predicted_um_rms'], 4):>11s}   {run['supervisor_findings']}"
        )


def _number(value: float | None, decimals: int) -> str:
    return "-" if value is None else f"{value:.{decimals}f}"
