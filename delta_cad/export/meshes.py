"""STL and 3MF of one part, for printers and slicers. The bytes depend only on the mesh and the name."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from delta_cad.assembly.tessellation import Mesh

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_MODEL_PATH = "3D/3dmodel.model"
_CONTENT_TYPES = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
    "</Types>\n"
)
_RELATIONS = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    f'<Relationship Id="model" Target="/{_MODEL_PATH}" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
    "</Relationships>\n"
)
_ZIP_EPOCH = (1980, 1, 1, 0, 0, 0)  # The earliest time a ZIP entry can have.
# Bytes before the count of triangles: free text, in which the unit can stand that the format does not know.
_STL_HEADER = 80


class MeshError(ValueError):
    """A mesh cannot be written: it has no triangle, or one refers to a missing vertex."""


def write_stl(mesh: Mesh, path: Path, name: str) -> None:
    """Writes a binary STL in millimetres.

    Args:
        mesh: Triangles, mm, wound outwards.
        path: File to write.
        name: Part number, for the header.

    Raises:
        MeshError: The mesh is empty or broken.
    """
    import trimesh
    from trimesh.exchange.stl import export_stl

    vertices, faces = _checked(mesh, name)
    data = export_stl(trimesh.Trimesh(vertices, faces, process=False))
    header = f"{name}, millimetres".encode("ascii", "replace")[:_STL_HEADER].ljust(_STL_HEADER)
    path.write_bytes(header + data[_STL_HEADER:])


def write_3mf(mesh: Mesh, path: Path, name: str, description: str = "", material: str = "") -> None:
    """Writes a 3MF package with one named object in millimetres.

    trimesh's own writer gives every object a random number and every entry the time, and has no place for material and
    description; ours depends on the mesh and the texts alone.

    Args:
        mesh: Triangles, mm, wound outwards.
        path: File to write.
        name: Part number, the name of the object.
        description: One line for the metadata.
        material: Material as ordered, for the metadata.

    Raises:
        MeshError: The mesh is empty or broken.
    """
    vertices, faces = _checked(mesh, name)
    model = _model_xml(vertices, faces, name, description, material)
    texts = {"[Content_Types].xml": _CONTENT_TYPES, "_rels/.rels": _RELATIONS}
    write_package(path, {**{entry: text.encode() for entry, text in texts.items()}, _MODEL_PATH: model})


def write_package(path: Path, entries: Mapping[str, bytes]) -> None:
    """Writes a ZIP archive that depends on its entries alone, in their order, and on no time or system."""
    with zipfile.ZipFile(path, "w") as package:
        for entry, content in entries.items():
            info = zipfile.ZipInfo(entry, _ZIP_EPOCH)
            info.create_system = 0
            package.writestr(info, content, zipfile.ZIP_DEFLATED, 6)


def _checked(mesh: Mesh, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices as float64 and faces as int64, if they make a mesh."""
    vertices = np.asarray(mesh.vertices, dtype=float)
    faces = np.asarray(mesh.faces, dtype=np.int64)
    if len(faces) == 0:
        raise MeshError(f"{name}: the mesh has no triangle")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise MeshError(f"{name}: a triangle refers to vertex {faces.max()}, there are {len(vertices)}")
    return vertices, faces


def _model_xml(vertices: np.ndarray, faces: np.ndarray, name: str, description: str, material: str) -> bytes:
    """The model part: one object, placed once. Coordinates to 0.1 um, far below any tessellation deviation."""
    from xml.sax.saxutils import escape, quoteattr

    points = "".join(f'<vertex x="{x:.7g}" y="{y:.7g}" z="{z:.7g}"/>' for x, y, z in vertices.tolist())
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces.tolist())
    facts = {
        "Title": name,
        "Description": "; ".join(filter(None, (description, material))),
        "Application": "delta-haptics",
    }
    metadata = "".join(f'<metadata name="{key}">{escape(value)}</metadata>' for key, value in facts.items())
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<model unit="millimeter" xml:lang="en-US" xmlns="{CORE}">{metadata}'
        f'<resources><object id="1" type="model" name={quoteattr(name)} partnumber={quoteattr(name)}><mesh>'
        f"<vertices>{points}</vertices><triangles>{triangles}</triangles></mesh></object></resources>"
        f'<build><item objectid="1" partnumber={quoteattr(name)}/></build></model>\n'
    ).encode()
