"""assembly.glb: the machine at home for viewers: metres, Y up, one mesh a part, one node an occurrence."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.common.units import M_PER_MM
from delta_cad.export.views.polydata import poly_data, shaded
from delta_cad.mechanism.placement import LINKS
from delta_cad.solids.part import Material

if TYPE_CHECKING:
    from delta_cad.assembly.tessellation import Mesh

# glTF has Y up: (x, y, z) of the machine is (x, z, -y) there.
_Z_UP_TO_Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0], [0, 0, 0, 1.0]])
_METALS = ("EN AW", "alumin", "steel", "brass", "bronze", "1.4")


def write_glb(assembly: Assembly, meshes: Meshes, path: Path) -> None:
    """Writes the assembly in its home position.

    Nodes: one per link, carrying the occurrences by name; meshes carry the part numbers of the bill of materials.

    Raises:
        KeyError: A part has no mesh.
    """
    import trimesh

    root = assembly.name
    scene = trimesh.Scene(base_frame=root)
    for part in assembly.parts:
        scene.geometry[part.number] = _display_mesh(meshes[part.number], part.material)
    for link, frame in _used_links(assembly).items():
        scene.graph.update(frame_from=root, frame_to=_link_node(link), matrix=_Z_UP_TO_Y_UP @ _metres(frame))
    for occurrence in assembly.occurrences:
        scene.graph.update(
            frame_from=_link_node(occurrence.link),
            frame_to=occurrence.name,
            matrix=_metres(occurrence.placement),
            geometry=occurrence.part.number,
        )
    data = scene.export(file_type="glb", include_normals=True)
    path.write_bytes(cast("bytes", data))


def _used_links(assembly: Assembly) -> dict[str, np.ndarray]:
    used = {occurrence.link for occurrence in assembly.occurrences}
    frames = assembly.placement(assembly.home_mm)
    return {link: frames[link] for link in LINKS if link in used}


def _link_node(link: str) -> str:
    """Links and occurrences share one space of node names."""
    return f"link_{link}"


def _metres(frame: np.ndarray) -> np.ndarray:
    out = np.array(frame, dtype=float)
    out[:3, 3] *= M_PER_MM
    return out


def _display_mesh(mesh: Mesh, material: Material) -> Any:
    """One trimesh in metres with split edges, normals and a physically based material."""
    import trimesh
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial
    from vtkmodules.util.numpy_support import vtk_to_numpy

    split = shaded(poly_data(mesh.vertices, mesh.faces))
    metal = any(word.lower() in material.name.lower() for word in _METALS)
    surface = PBRMaterial(
        name=material.name,
        baseColorFactor=[*_linear(material.colour), 1.0],
        metallicFactor=0.6 if metal else 0.0,
        roughnessFactor=0.45 if metal else 0.6,
    )
    return trimesh.Trimesh(
        vertices=vtk_to_numpy(split.GetPoints().GetData()) * M_PER_MM,
        faces=vtk_to_numpy(split.GetPolys().GetConnectivityArray()).reshape(-1, 3),
        vertex_normals=vtk_to_numpy(split.GetPointData().GetNormals()),
        visual=TextureVisuals(material=surface),
        process=False,
    )


def _linear(colour: tuple[float, float, float]) -> list[float]:
    """SRGB to the linear values that glTF asks for (IEC 61966-2-1)."""
    return [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
