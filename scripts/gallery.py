"""The gallery of docs/: pictures and figures of six machines, read off their builds; none is typed.

    python -m scripts.gallery [DIR]      # builds what does not stand in DIR (out) yet, and writes docs/gallery
    python -m scripts.gallery --animate  # writes docs/gallery/dashboard-joystick.webp alone: best.json in motion

A build in DIR counts where its manifest has the design's hash. Writes `docs/gallery/NAME.png` (from `views/iso.png`),
`docs/gallery/figures.json` and, from that alone, the page `docs/gallery/figures.md`.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from delta_cad.design import design_hash, load_design

ROOT = Path(__file__).resolve().parents[1]
PLACE = ROOT / "docs" / "gallery"
DESIGNS = (
    ROOT / "best.json",
    PLACE / "published-75.json",
    PLACE / "direct-83.json",
    PLACE / "desk-150.json",
    PLACE / "pocket-40.json",
    PLACE / "maker-60.json",
)
WORDS = {
    "dashboard-joystick": "The committed design: a joystick for a dashboard",
    "published-75": "The published lengths with hardware of ours",
    "direct-83": "A direct drive",
    "desk-150": "A desktop device",
    "pocket-40": "A small one",
    "maker-60": "A printed one, with gimbal motors",
}
FIGURES = {
    "force, continuous": ("force_N", "N"),
    "outline swept": ("outline_mm", "mm"),
    "clearance": ("clearance_mm", "mm"),
    "worst kappa": ("kappa", ""),
    "stiffness at the knob, worst": ("stiffness_N_mm", "N/mm"),
    "first mode": ("first_mode_Hz", "Hz"),
    "mass": ("mass_kg", "kg"),
    "moving mass": ("moving_kg", "kg"),
    "price of one, estimated": ("cost_EUR", "EUR"),
}
CHECKS = {
    "clearance_mm": "clearance",
    "kappa": "kappa",
    "stiffness_N_mm": "structure stiffness at the knob",
    "first_mode_Hz": "structure first mode",
}
WIDTH = 640  # pixels of a picture
SHOT, MOVING = (820, 820), (480, 480)  # pixels of the picture that moves, as drawn and as written
STEPS, FRAME_MS, QUALITY = 6, 80, 60  # pictures an edge of the cube; ms of each; of WebP's 100


def built(design: Path, out: Path) -> Path:
    """Finds the build of a design below a folder, or makes it there.

    Raises:
        SystemExit: A check fails, or it cannot be built.
    """
    loaded = load_design(design)
    folder = out / loaded.name
    manifest = folder / "manifest.json"
    if manifest.exists():
        was = json.loads(manifest.read_text(encoding="utf-8"))
        if was["input_sha256"] == design_hash(loaded) and "pictures" not in was["left_out"]:
            return folder
    words = ["build", "--design", str(design), "--out", str(out), "--no-drawings"]
    if code := subprocess.run([sys.executable, "-m", "delta_cad", *words], cwd=ROOT).returncode:
        raise SystemExit(code)
    return folder


def figures(design: Path, folder: Path) -> dict[str, Any]:
    """Reads the figures of a machine off its build.

    Args:
        design: Its file.
        folder: What a build of it wrote.

    Returns:
        Key with unit -> number; hash and name of the design.
    """
    loaded = load_design(design)
    data = json.loads((folder / "checks.json").read_text(encoding="utf-8"))
    assert data["passed"]
    assert data["input_sha256"] == design_hash(loaded)
    values = {check["name"]: check["value"] for check in data["checks"]}
    found = {key: values[name] for key, name in CHECKS.items() if name in values}
    return {
        "name": loaded.name,
        "file": str(design.relative_to(ROOT)),
        "input_sha256": design_hash(loaded),
        "cube_side_mm": 2.0 * loaded.cube.half_side_mm,
        "force_N": loaded.requirements.force_N,
        "motor": loaded.hardware.motor,
        "ratio": 1.0 if loaded.hardware.drive == "direct" else loaded.hardware.capstan_ratio,
        "outline_mm": [values["envelope width"], values["envelope depth"]],
        **found,
        "mass_kg": data["total_mass_kg"],
        "moving_kg": data["moving_mass_kg"],
        "cost_EUR": data["cost_EUR"],
    }


def _reported(value: float | list[float]) -> str:
    numbers = value if isinstance(value, list) else [value]
    return " x ".join(f"{number:.0f}" if number >= 100 else f"{number:.3g}" for number in numbers)


def page(machines: list[Mapping[str, Any]]) -> str:
    """Writes the machines as a page: a picture and a table each."""
    parts = ["<!-- written by scripts/gallery.py -->\n"]
    for one in machines:
        drive = "direct" if one["ratio"] == 1.0 else f"capstan {one['ratio']:g}:1"
        parts.append(f"## {WORDS[one['name']]}\n")
        parts.append(f"![{one['name']} at its home position, its cube in blue]({one['name']}.png)\n")
        title = f"{one['name']}: a cube of {one['cube_side_mm']:.4g} mm, {one['motor']}, {drive}"
        parts.append(f"{title}.\n\n```sh\npython -m delta_cad build --design {one['file']}\n```\n")
        rows = [(words, one[key], unit) for words, (key, unit) in FIGURES.items() if key in one]
        lines = [f"| {words} | {_reported(value)} {unit}".rstrip() + " |" for words, value, unit in rows]
        parts.append("\n".join(["| figure | value |", "|---|---|", *lines]) + "\n")
    return "\n".join(parts)


def picture(source: Path, target: Path) -> None:
    """Reduces a picture of a build to one of a page."""
    from PIL import Image

    with Image.open(source) as whole:
        size = (WIDTH, round(whole.height * WIDTH / whole.width))
        small = whole.convert("RGB").resize(size, Image.Resampling.LANCZOS)
    small.save(target, optimize=True)  # fewer colours would lose those of cube and outline


def animate(design: Path, target: Path, steps: int = STEPS) -> None:
    """Writes a design in motion as an animated WebP: the handle goes along the edges of its cube.

    Args:
        design: Its file.
        target: The picture.
        steps: Pictures an edge, of eight edges.
    """
    from PIL import Image

    from delta_cad.commands.pipeline import make_machine
    from delta_cad.export.views.views import Stage, edge_path, write_motion

    machine = make_machine(load_design(design))
    cube = machine.dimensions.design.cube
    stage = Stage((0.0, 0.0), (0.0, 0.0), cube.bottom_height_mm, cube.half_side_mm, cube.centre_x_mm or 0.0)
    with TemporaryDirectory() as folder:
        files = write_motion(machine.assembly, machine.meshes, Path(folder), stage, edge_path(stage, steps), SHOT)
        frames = [Image.open(file).convert("RGB").resize(MOVING, Image.Resampling.LANCZOS) for file in files]
    first, *rest = frames
    first.save(target, save_all=True, append_images=rest, duration=FRAME_MS, loop=0, quality=QUALITY, method=6)


def main(words: list[str]) -> int:
    """Writes the gallery, or the picture that moves."""
    if words == ["--animate"]:
        animate(DESIGNS[0], PLACE / f"{load_design(DESIGNS[0]).name}.webp")
        return 0
    out = Path(words[0] if words else "out").resolve()
    machines = []
    for design in DESIGNS:
        folder = built(design, out)
        machines.append(figures(design, folder))
        picture(folder / "views" / "iso.png", PLACE / f"{machines[-1]['name']}.png")
    (PLACE / "figures.json").write_text(json.dumps(machines, indent=1) + "\n", encoding="utf-8")
    (PLACE / "figures.md").write_text(page(machines), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
