"""A user's own parts: what their files may leave out, how they are refused, and what a design makes of them."""

from __future__ import annotations

import json
import pickle
import re
import shutil
from math import pi
from pathlib import Path
from typing import Any

import pytest

from delta_cad import catalogue
from delta_cad.catalogue import CHOSEN, FAMILIES, CatalogueError, Motor
from delta_cad.catalogue.reader import Family, optional_columns
from delta_cad.design import (
    HARDWARE_FAMILIES,
    DesignError,
    design_from_dict,
    design_hash,
    design_to_dict,
    load_design,
)
from delta_cad.dimensions import dimensions
from delta_cad.drive import drive_torque
from tests.committed import BEST, ROOT

MOTOR = {
    "id": "mine-32",
    "diameter_mm": "32",
    "length_mm": "70",
    "shaft_diameter_mm": "6",
    "shaft_length_mm": "16",
    "pilot_diameter_mm": "16",
    "pilot_height_mm": "3",
    "mount_thread": "M3",
    "mount_circle_mm": "22",
    "mount_count": "4",
    "mass_g": "300",
    "nominal_torque_N_m": "0.1",
    "rotor_inertia_kg_m2": "5e-06",
    "torque_constant_N_m_A": "0.03",
    "resistance_ohm": "0.6",
}
CABLE = {"id": "mine-rope", "diameter_mm": "0.5", "breaking_load_N": "150"}


def written(folder: Path, **families: dict[str, str]) -> Path:
    """A folder with one row a family."""
    folder.mkdir(exist_ok=True)
    for name, cells in families.items():
        (folder / f"{name}.csv").write_text(f"{','.join(cells)}\n{','.join(cells.values())}\n", encoding="utf-8")
    return folder


def cell(value: Any) -> str:
    return "" if value is None else ";".join(value) if isinstance(value, tuple) else str(value)


def copied(folder: Path, name: str) -> dict[str, Any]:
    """Writes our rows of a family as a user's file, under other ids; gives our rows by our ids."""
    family = CHOSEN[name]
    lines = [",".join(family.columns)]
    for row in family.rows.values():
        cells = {column: cell(getattr(row, column)) for column in family.columns} | {"id": f"own-{row.id}"}
        lines.append(",".join(f'"{text}"' for text in cells.values()))
    (folder / f"{name}.csv").write_text("\ufeff" + "\n".join(lines) + "\n", encoding="utf-8")
    return dict(family.rows)


def stated(folder: Path, name: str | None, **hardware: Any) -> Path:
    """A copy of the committed design with other hardware, its own parts in a folder."""
    data = json.loads(BEST.read_text(encoding="utf-8"))
    data["hardware"] |= hardware | ({} if name is None else {"catalogue": name})
    path = folder / "d.json"
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


# What the files may leave out


def needed_columns(family: Family) -> tuple[str, ...]:
    """Columns that a user's own file of a family must have."""
    optional = optional_columns(family.record)
    return tuple(name for name in family.columns if name not in optional)


def test_the_columns_that_must_be_there_are_enough(tmp_path: Path) -> None:
    assert set(MOTOR) == set(needed_columns(catalogue.motor))
    assert set(CABLE) == set(needed_columns(catalogue.cable))
    own = catalogue.own_parts(written(tmp_path, motor=MOTOR, cable=CABLE))
    motor, rope = own.rows["motor"]["mine-32"], own.rows["cable"]["mine-rope"]
    assert isinstance(motor, Motor)
    assert isinstance(rope, catalogue.Cable)
    assert (motor.drives, motor.nominal_voltage_V, motor.peak_torque_N_m) == (("capstan",), 24.0, 0.1)
    assert motor.stall_torque_N_m == pytest.approx(24.0 / 0.6 * 0.03)
    assert (motor.order_code, motor.maker, motor.verified[:3]) == ("mine-32", "any", "no,")
    empty = MOTOR | dict.fromkeys(("nominal_voltage_V", "stall_torque_N_m", "maker", "max_axial_load_N"), "")
    assert catalogue.own_parts(written(tmp_path, motor=empty)).rows["motor"] == {"mine-32": motor}
    assert motor.max_radial_load_N is None
    steel = rope.mass_g_m / 7.9 / (pi / 4.0 * 0.25)  # share of the circle
    assert 0.5 < steel < 0.7


@pytest.mark.parametrize("name", CHOSEN)
def test_our_own_rows_are_read_as_a_users_file_under_other_ids(name: str, tmp_path: Path) -> None:
    """Every column spelled out is fine, too: the same rows come back."""
    rows = copied(tmp_path, name)
    own = catalogue.own_parts(tmp_path).rows[name]
    assert [vars(row) | {"id": key} for key, row in rows.items()] == [
        vars(row) | {"id": key.removeprefix("own-")} for key, row in own.items()
    ]


def test_every_entry_of_the_hardware_that_is_a_part_may_be_ones_own() -> None:
    assert set(CHOSEN) == set(HARDWARE_FAMILIES)
    assert set(CHOSEN) < set(FAMILIES)


def test_partners_are_columns_that_name_a_row_of_their_family() -> None:
    for family in FAMILIES.values():
        assert set(family.record.partners) < set(family.columns)
        assert set(family.record.partners.values()) < set(FAMILIES)
    for name in CHOSEN:  # our own rows keep it
        for row in catalogue.family(name).values():
            for column, partner in row.partners.items():
                assert getattr(row, column) in catalogue.family(partner)


# What is refused, in one line


def test_a_missing_column_is_named(tmp_path: Path) -> None:
    cells = {column: cell for column, cell in MOTOR.items() if column != "resistance_ohm"}
    with pytest.raises(CatalogueError, match=r"motor\.csv: columns missing \['resistance_ohm'\]"):
        catalogue.own_parts(written(tmp_path, motor=cells))


def test_a_folder_without_parts_is_refused(tmp_path: Path) -> None:
    (tmp_path / "README.md").write_text("no part\n")
    with pytest.raises(CatalogueError, match=r"no CSV file.*motor\.csv"):
        catalogue.own_parts(tmp_path)
    with pytest.raises(CatalogueError, match=r"none: cannot be read: .*motor\.csv"):
        catalogue.own_parts(tmp_path / "none")


# What a design makes of them


def test_a_design_takes_its_rows_from_the_folder_next_to_it(tmp_path: Path) -> None:
    written(tmp_path / "my-parts", motor=MOTOR, cable=CABLE)
    design = load_design(stated(tmp_path, "my-parts", motor="mine-32", cable="mine-rope", capstan_ratio=4.8))
    wider = design.model_copy(update={"mechanism": design.mechanism.model_copy(update={"base_radius_mm": 36.0})})
    made, drive = dimensions(wider), drive_torque(design)
    assert (made.motor.id, made.motor.length_mm, made.cable.diameter_mm) == ("mine-32", 70.0, 0.5)
    assert made.bearing is catalogue.bearing("688")
    assert (drive.motor, drive.cable) == ("mine-32", "mine-rope")
    assert drive.continuous_torque_N_m == pytest.approx(4.8 * 0.96 * 0.1)


def test_all_parts_may_be_ones_own(tmp_path: Path) -> None:
    """With our numbers under other ids nothing changes but the ids."""
    parts = tmp_path / "my-parts"
    parts.mkdir()
    for name in CHOSEN:
        copied(parts, name)
    best = load_design(BEST)
    design = load_design(stated(tmp_path, "my-parts", **{n: f"own-{getattr(best.hardware, n)}" for n in CHOSEN}))
    made, project = dimensions(design), dimensions(best)
    for name in CHOSEN:
        assert getattr(made, name).id == f"own-{getattr(project, name).id}"
    assert (made.arm, made.capstan, made.bracket, made.shaft) == (
        project.arm,
        project.capstan,
        project.bracket,
        project.shaft,
    )
    assert (made.forearm, made.platform, made.base) == (project.forearm, project.platform, project.base)
    own, shared = drive_torque(design), drive_torque(best)
    assert vars(own) | {"motor": shared.motor, "cable": shared.cable} == vars(shared)


def test_no_code_asks_for_the_part_that_a_design_names_among_own_alone() -> None:
    """`catalogue.motor(design.hardware.motor)` knows ours alone; `catalogue.motor.chosen(design.hardware)` all."""
    own_alone = re.compile(rf"catalogue\.({'|'.join(CHOSEN)})\((?!\")")
    found = [
        str(path.relative_to(ROOT))
        for package in ("delta_cad", "haptics", "optimizer")
        for path in (ROOT / package).rglob("*.py")
        if own_alone.search(path.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_it_is_the_same_design_in_another_place_and_another_one_with_another_part(tmp_path: Path) -> None:
    written(tmp_path / "my-parts", motor=MOTOR)
    path = stated(tmp_path, "my-parts", motor="mine-32")
    design = load_design(path)
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    shutil.copytree(tmp_path / "my-parts", moved / "parts")
    again = load_design(stated(moved, "parts", motor="mine-32"))
    assert design_hash(again) == design_hash(design)
    assert load_design(stated(moved, None, motor="mine-32"), tmp_path / "my-parts").hardware.motor == "mine-32"
    written(tmp_path / "my-parts", motor=MOTOR | {"mass_g": "301"})
    assert design_hash(load_design(path)) != design_hash(design)
    written(tmp_path / "my-parts", motor=MOTOR | {"id": "other"})
    assert design_hash(load_design(stated(tmp_path, "my-parts"))) == design_hash(load_design(BEST))  # none is named


def test_a_copy_of_the_design_keeps_its_parts(tmp_path: Path) -> None:
    """Another process gets it pickled, a search changes a length of it."""
    written(tmp_path / "my-parts", motor=MOTOR)
    design = load_design(stated(tmp_path, "my-parts", motor="mine-32"))
    for copy in (
        pickle.loads(pickle.dumps(design)),
        design.model_copy(update={"name": "n"}),
        design.model_copy(deep=True),
    ):
        assert catalogue.motor.chosen(copy.hardware).diameter_mm == 32.0
    data = design_to_dict(design)
    assert data["hardware"]["catalogue"] == "my-parts"
    assert design_from_dict(data, folder=tmp_path) == design


def test_a_bad_row_is_refused_with_the_designs_field(tmp_path: Path) -> None:
    written(tmp_path / "my-parts", motor=MOTOR | {"resistance_ohm": "0"})
    with pytest.raises(DesignError) as caught:
        load_design(stated(tmp_path, "my-parts"))
    assert (caught.value.file, caught.value.field) == ("d.json", "hardware.catalogue")
    assert "motor.csv line 2: resistance_ohm = '0'" in str(caught.value)


def test_unknown_ids_and_unfit_drives_are_refused_with_own_rows_among_the_legal_ones(tmp_path: Path) -> None:
    written(tmp_path / "my-parts", motor=MOTOR)
    with pytest.raises(DesignError, match=r"hardware\.motor = \"mine-33\".*maxon-re30-310007.*mine-32"):
        load_design(stated(tmp_path, "my-parts", motor="mine-33"))
    with pytest.raises(DesignError, match=r"hardware\.motor = \"mine-32\".*direct"):
        load_design(stated(tmp_path, "my-parts", motor="mine-32", drive="direct"))
    with pytest.raises(DesignError, match=r"hardware\.motor"):
        load_design(stated(tmp_path, None, motor="mine-32"))  # of nobody


def test_the_page_lists_the_columns_that_must_be_there() -> None:
    text = (ROOT / "docs" / "how-to" / "own-parts.md").read_text(encoding="utf-8")
    for name, family in CHOSEN.items():
        assert f"| `{name}.csv` | {', '.join(f'`{column}`' for column in needed_columns(family))} |" in text
