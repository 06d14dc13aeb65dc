"""Parts that are found again are those that would be made anew, whatever field of a design has changed.

25 s of processor: every machine is made twice, by way of the cache and without it.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from delta_cad.assembly import builder
from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.builder import at
from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.contact.shared_volume import common_volume
from delta_cad.common import memoize
from delta_cad.common.options import CACHE_OFF
from delta_cad.design import Design, design_from_dict, load_design
from delta_cad.dimensions import dimensions
from tests.committed import BEST, DATA

DESIGN = load_design(BEST)
CHANGED: dict[str, dict[str, dict[str, Any]]] = {  # what a person changes -> fields
    "force": {"requirements": {"force_N": 2.9}},
    "forearms": {"mechanism": {"forearm_length_mm": +0.7}},
    "arms": {"mechanism": {"upper_arm_length_mm": +0.5}},
    "platform": {"mechanism": {"platform_radius_mm": +0.4}},
    "width": {"mechanism": {"parallelogram_width_mm": +0.5}},
    "cube": {"cube": {"bottom_height_mm": +0.3}},
    "ratio": {"hardware": {"capstan_ratio": +0.02}},
    "feet": {"hardware": {"mounting": "both"}},
}
KEPT = {"force": 0, "forearms": 20}
"""Change -> how many of 44 parts it concerns at most: rods, and with the arms' travel stops, cheeks and sector."""


@pytest.fixture(autouse=True)
def empty(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """Nothing in memory, and a folder of its own on disk."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv(CACHE_OFF, raising=False)
    _forget()
    yield
    _forget()


def _forget() -> None:
    memoize._recent.clear()
    memoize._traces.clear()


def _changed(change: dict[str, dict[str, Any]]) -> Design:
    data = deepcopy(DATA)
    for section, values in change.items():
        for name, value in values.items():
            lengthened = isinstance(value, float) and section != "requirements"
            data[section][name] = data[section][name] + value if lengthened else value
    return design_from_dict(data, "changed", Path())


def _boundary(solid: Any) -> tuple[Any, ...]:
    """Corners, and areas of faces, to a picometre and its square: Booleans are not the same to the last bit.

    Its maps go by addresses: of a platform made four times two differed by 4e-15 mm.
    """
    corners = sorted(tuple(round(x, 9) for x in one.toTuple()) for one in solid.Vertices())
    return corners, sorted((one.geomType(), round(one.Area(), 9)) for one in solid.Faces())


def _content(assembly: Assembly) -> dict[str, tuple[Any, ...]]:
    """All of each part, its solid by its boundary."""
    fields = ("description", "material", "make", "holes", "mass_g", "order_code", "extent_mm")
    return {one.number: (_boundary(one.solid), *(getattr(one, name) for name in fields)) for one in assembly.parts}


@pytest.mark.quick(3)
@pytest.mark.parametrize("name", CHANGED)
def test_a_changed_machine_has_the_parts_that_are_made_without_the_cache(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    real = builder.cached_by_reads

    def counted(make: Any, *of: Any) -> Any:
        def noted(*given: Any) -> Any:
            made.append(make.__name__)
            return make(*given)

        noted.__module__, noted.__qualname__ = make.__module__, make.__qualname__
        return real(noted, *of)

    monkeypatch.setattr(builder, "cached_by_reads", counted)
    assemble(dimensions(DESIGN))
    assert len(made) > 30
    made.clear()
    d = dimensions(_changed(CHANGED[name]))
    _forget()  # as another process
    found = _content(assemble(d))
    assert len(made) <= KEPT.get(name, len(found) - 1), made
    monkeypatch.setenv(CACHE_OFF, "1")
    _forget()
    assert found == _content(assemble(d))


def test_a_mesh_and_a_common_volume_are_found_again_and_are_those_of_the_solids(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    parts = {one.number: one for one in assemble(dimensions(DESIGN)).parts}
    tube, cup = parts["rod_tube"], parts["rod_cup"]

    def found() -> tuple[Any, ...]:
        mesh = MeshLibrary([tube], 0.05, 0.35)["rod_tube"]
        return mesh.vertices.tobytes(), mesh.deviation_mm, common_volume(tube.solid, cup.solid, at(1.0))

    first = found()
    _forget()
    monkeypatch.setattr("delta_cad.assembly.tessellation.tessellate", None)  # none is made anew
    monkeypatch.setattr("delta_cad.checks.contact.shared_volume.common_size", None)
    assert found() == first
    monkeypatch.undo()
    monkeypatch.setenv(CACHE_OFF, "1")
    _forget()
    assert found() == first
    assert first[2] > 1.0
