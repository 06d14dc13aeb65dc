"""The solids of the last build of a name, which the live page shows until those of its design are made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np

from delta_cad.design import Design, DesignError, design_hash, load_design
from delta_cad.dimensions import DimensionError, dimensions, link_placement
from delta_cad.mechanism import MechanismError
from delta_cad.mechanism.placement import LINKS, LinkPlacement
from delta_cad.report.built import MODEL, Build, StaleBuildError

_LINK = "link_"  # before the name of a link in the model


@dataclass(frozen=True)
class Body:
    """A part in its place on a link.

    Attributes:
        name: Its occurrence.
        link: The link.
        points_m: (n, 3) corners in the link's frame, m.
        faces: (k, 3) triangles.
        colour: Red, green, blue, 0 to 255.
    """

    name: str
    link: str
    points_m: np.ndarray
    faces: np.ndarray
    colour: tuple[int, int, int]


@dataclass(frozen=True)
class Earlier:
    """A machine that was built.

    Attributes:
        bodies: Its parts.
        placement: Moves its links.
        same: Whether it is of the very design that is shown now.
    """

    bodies: Sequence[Body]
    placement: LinkPlacement
    same: bool


def earlier_machine(design: Design, folder: Path, own_parts: Path | None = None) -> Earlier | None:
    """Reads the machine that the last build of a design's name left.

    Args:
        design: The design that is shown.
        folder: Of the build.
        own_parts: Folder of the user's own parts, in place of the one that the built design names.

    Returns:
        The machine; None where there is no build, or none that can be read.
    """
    try:
        build = Build.read(folder)
        same = build.input_sha256 == design_hash(design)
        of = design if same else load_design(folder / "design.json", own_parts)
        return Earlier(_bodies(build.content(MODEL)), link_placement(dimensions(of)), same)
    except (StaleBuildError, DesignError, DimensionError, MechanismError):
        return None


def _bodies(model: bytes) -> list[Body]:
    """Lists the parts of a model, whose nodes hang on those of their links."""
    import trimesh

    scene = trimesh.load_scene(BytesIO(model), file_type="glb")
    graph, found = scene.graph, list[Body]()
    for name in graph.nodes_geometry:
        link = str(graph.transforms.parents[name]).removeprefix(_LINK)
        matrix, geometry = graph.get(name, graph.transforms.parents[name])
        mesh = scene.geometry[geometry]
        red, green, blue = (int(v) for v in mesh.visual.material.main_color[:3])
        if link in LINKS:
            points = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
            found.append(Body(str(name), link, np.asarray(points), np.asarray(mesh.faces), (red, green, blue)))
    return found
