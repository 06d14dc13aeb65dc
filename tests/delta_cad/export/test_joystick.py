"""The committed design through the exporters: what the synthetic machine cannot show (blends, threads, 100+ parts)."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.export.bom import bill_of_materials
from delta_cad.export.glb import write_glb
from delta_cad.export.step import write_assembly_step
from delta_cad.export.views.explode import chain_of

VOLUME_RELATIVE = 1e-6
"""What a build promises to a reader that is not the writer."""

COLOUR_STEP = 1.01 / 255  # gmsh keeps eight bits a channel and cuts what is beyond


@pytest.mark.slow
def test_gmsh_reads_every_part_with_its_name_and_volume(best_assembly: Assembly, tmp_path: Path) -> None:
    import gmsh

    write_assembly_step(best_assembly, tmp_path / "assembly.step")
    gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
        gmsh.model.add("read")
        tags = [tag for _, tag in gmsh.model.occ.importShapes(str(tmp_path / "assembly.step"))]
        gmsh.model.occ.synchronize()
        found = [(gmsh.model.getEntityName(3, tag).split("/")[-1], gmsh.model.occ.getMass(3, tag)) for tag in tags]
        painted = [gmsh.model.getColor(3, tag)[:3] for tag in tags]
    finally:
        gmsh.finalize()
    assert Counter(name for name, _ in found) == Counter(o.part.number for o in best_assembly.occurrences)
    volumes = {part.number: part.solid.Volume() for part in best_assembly.parts}
    for name, volume in found:
        assert volume == pytest.approx(volumes[name], rel=VOLUME_RELATIVE), name
    colours = {part.number: part.material.colour for part in best_assembly.parts}
    for (name, _), rgb in zip(found, painted, strict=True):
        np.testing.assert_allclose(np.array(rgb) / 255, colours[name], atol=COLOUR_STEP, err_msg=name)


def test_mass_bill_and_solids_agree(best_assembly: Assembly, best_masses: dict[str, Any]) -> None:
    report = best_masses
    listed = bill_of_materials(best_assembly, {name: part["mass_kg"] for name, part in report["parts"].items()})
    whole = sum(not part.piece_of for part in best_assembly.parts)  # a cable that is drawn in pieces is one row
    rows, adjacent = listed[:whole], listed[whole:]
    assert [row.part_number for row in adjacent] == [supply.number for supply in best_assembly.supplies]
    total_g = 1000 * report["total_mass_kg"]
    # half of the last printed digit for every occurrence
    assert sum(row.total_mass_g for row in rows) == pytest.approx(total_g, abs=0.5e-4 * len(best_assembly.occurrences))
    assert sum(row.quantity for row in rows) == sum(not o.part.piece_of for o in best_assembly.occurrences)
    arms = [report["bodies"][f"upper_arm_{i}"] for i in range(3)]
    for arm in arms[1:]:  # the three chains are copies of each other: same body, same frame
        assert arm["mass_kg"] == pytest.approx(arms[0]["mass_kg"], rel=1e-12)
        np.testing.assert_allclose(arm["inertia_kg_m2"], arms[0]["inertia_kg_m2"], rtol=1e-9, atol=1e-15)


def test_glb_holds_every_occurrence(best_assembly: Assembly, tmp_path: Path) -> None:
    import trimesh

    write_glb(best_assembly, MeshLibrary(best_assembly.parts, 0.2, 0.6), tmp_path / "assembly.glb")
    scene: Any = trimesh.load_scene(tmp_path / "assembly.glb")
    assert set(scene.graph.nodes_geometry) == {o.name for o in best_assembly.occurrences}
    assert set(scene.geometry) == {part.number for part in best_assembly.parts}


def test_names_tell_the_chain(best_assembly: Assembly) -> None:
    counts = Counter(chain_of(o.name) for o in best_assembly.occurrences if o.link != "platform")
    assert counts[0] == counts[1] == counts[2] > 0
