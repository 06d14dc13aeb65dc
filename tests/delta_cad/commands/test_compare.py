"""`compare`: what differs of two machines, of which each figure is a build's of the same design or in closed form."""

from __future__ import annotations

import json
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from delta_cad.commands.cli import main
from delta_cad.design import design_from_dict, design_hash, design_to_json
from tests.committed import changed

A_PARTS = [
    {"part_number": "plate", "quantity": 1, "description": "plate 8", "unit_mass_g": 100.0, "unit_cost_EUR": 20.0},
    {"part_number": "arm", "quantity": 3, "description": "arm 91", "unit_mass_g": 40.0, "unit_cost_EUR": 30.0},
    {"part_number": "pin", "quantity": 6, "description": "pin", "unit_mass_g": 1.0, "unit_cost_EUR": 0.5},
    {"part_number": "rod", "quantity": 6, "description": "rod", "unit_mass_g": 3.0, "unit_cost_EUR": 5.0},
]
B_PARTS = [
    {"part_number": "plate", "quantity": 1, "description": "plate 8", "unit_mass_g": 100.0, "unit_cost_EUR": 20.0},
    {"part_number": "arm", "quantity": 3, "description": "arm 88", "unit_mass_g": 38.5, "unit_cost_EUR": 30.0},
    {"part_number": "rod", "quantity": 6, "description": "rod", "unit_mass_g": 3.0, "unit_cost_EUR": 5.0},
    {"part_number": "cap", "quantity": 3, "description": "cap", "unit_mass_g": 2.0, "unit_cost_EUR": 4.0},
]


def cost(parts: list[dict[str, Any]]) -> dict[str, Any]:
    lines = [
        {"part_number": one["part_number"], "quantity": one["quantity"], "unit_EUR": [one["unit_cost_EUR"], 1.0]}
        for one in parts
    ]
    total = sum(line["quantity"] * line["unit_EUR"][0] for line in lines)
    return {"machines": [1, 10], "made_EUR": [total, 9.0], "bought_EUR": [0.0, 0.0], "total_EUR": [total, 9.0]} | {
        "lines": lines
    }


class Maker:
    """Writes design files and folders as builds leave them, without a solid."""

    def __init__(self, folder: Path, masses: dict[str, Any]) -> None:
        self.folder, self.masses = folder, masses

    def design(self, name: str, **values: Any) -> Path:
        path = self.folder / f"{name}.json"
        path.write_text(design_to_json(design_from_dict(changed(name=name, **values))))
        return path

    def build(self, file: Path, parts: list[dict[str, Any]], width: float, failed: tuple[str, ...] = ()) -> Path:
        design = design_from_dict(json.loads(file.read_text()))
        folder = self.folder / "out" / design.name
        (folder / "parts").mkdir(parents=True)
        checks = [
            {"name": "envelope width", "value": width, "unit": "mm"},
            {"name": "clearance", "value": 2.5, "unit": "mm"},
        ]
        record = {"failed": list(failed), "total_mass_kg": 2.0, "moving_mass_kg": 0.4, "checks": checks}
        contents = {"checks.json": record, "mass_properties.json": self.masses, "cost.json": cost(parts)}
        contents |= {"bom.json": {"items": parts}, "design.json": json.loads(file.read_text())}
        files = {name: json.dumps(content).encode() for name, content in contents.items()}
        files |= {f"parts/{one['part_number']}.step": one["part_number"].encode() for one in parts}
        for name, content in files.items():
            (folder / name).write_bytes(content)
        manifest = {"input_sha256": design_hash(design), "versions": {"delta-haptics": version("delta-haptics")}}
        listed = {name: {"sha256": sha256(content).hexdigest()} for name, content in files.items()}
        (folder / "manifest.json").write_text(json.dumps(manifest | {"files": listed}))
        return folder

    def compare(self, *words: object) -> int:
        return main(["compare", *map(str, words), "--out", str(self.folder / "out")])


@pytest.fixture
def maker(tmp_path: Path, best_masses: dict[str, Any]) -> Maker:
    return Maker(tmp_path, {"schema": "delta-mass-properties/1"} | best_masses)


def found(capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    return json.loads(capsys.readouterr().out)


def figures(facts: dict[str, Any], of: str = "figures") -> dict[str, dict[str, Any]]:
    return {row["quantity"]: row for row in facts[of]}


def test_figures_that_differ_come_with_both_values_and_which_is_better(
    maker: Maker, capsys: pytest.CaptureFixture[str]
) -> None:
    a, b = maker.design("a"), maker.design("b", cube__half_side_mm=40.0, hardware__arm_thickness_mm=7.0)
    maker.build(a, A_PARTS, 250.0)
    maker.build(b, B_PARTS, 240.0)
    assert maker.compare(a, b, "--json") == 0
    facts = found(capsys)
    differ, same = figures(facts), figures(facts, "same")
    side = differ["cube side"]
    assert (side["a"], side["b"], side["better"]) == (pytest.approx(86.33), pytest.approx(80.0), "a")
    assert side["difference"] == pytest.approx(-6.33)
    width = differ["swept outline, width"]
    assert (width["a"], width["b"], width["better"], width["unit"]) == (250.0, 240.0, "b", "mm")
    assert same["mass"]["a"] == same["mass"]["b"] == 2.0
    assert same["mass"]["better"] is None
    thick = differ["hardware.arm_thickness_mm"]
    assert (thick["a"], thick["b"], thick["unit"], thick["better"]) == (6, 7.0, "mm", None)
    fields = differ | same
    assert fields["requirements.stiffness_min_N_mm"]["unit"] == "N/mm"
    assert (fields["requirements.gravity_m_s2"]["a"], fields["requirements.gravity_m_s2"]["unit"]) == (
        "0.0, 0.0, -9.81",
        "m/s^2",
    )
    # a smaller cube is never worse in what is worst over it
    for words, sense in (
        ("conditioning (kappa), worst", 1),
        ("rotational stiffness index, least", -1),
        ("lean of the rods, largest", 1),
    ):
        assert sense * (differ[words]["a"] - differ[words]["b"]) > 0.0
        assert differ[words]["better"] == "b"


def test_parts_and_cost_lines_that_differ(maker: Maker, capsys: pytest.CaptureFixture[str]) -> None:
    a, b = maker.design("a"), maker.design("b")
    folders = maker.build(a, A_PARTS, 250.0), maker.build(b, B_PARTS, 250.0)
    assert maker.compare(*folders, "--json") == 0
    facts = found(capsys)
    assert facts["figures"] == []
    parts = facts["parts"]
    assert [row["part_number"] for row in parts["only_a"]] == ["pin"]
    assert [row["part_number"] for row in parts["only_b"]] == ["cap"]
    assert parts["changed"] == [
        {"part_number": "arm", "shape": False, "description": ["arm 91", "arm 88"], "unit_mass_g": [40.0, 38.5]}
    ]
    assert parts["same"] == 2
    lines = {row["part_number"]: row for row in facts["cost"]["lines"]}
    assert list(lines) == ["cap", "pin"]
    assert lines["cap"] == {"part_number": "cap", "a_EUR": None, "b_EUR": 12.0, "difference_EUR": 12.0}
    assert lines["pin"]["difference_EUR"] == -3.0
    assert facts["cost"]["total_EUR"]["b"][0] - facts["cost"]["total_EUR"]["a"][0] == pytest.approx(9.0)


def test_the_table_names_what_differs_and_where_the_page_is(maker: Maker, capsys: pytest.CaptureFixture[str]) -> None:
    a, b = maker.design("a"), maker.design("b", cube__half_side_mm=40.0)
    page = maker.folder / "out" / "compare-a-b.html"
    assert maker.compare(a, b) == 0
    out = capsys.readouterr().out
    for words in ("A a: figures in closed form; not built: no build in", "cube side", "-6.33", "both machines must be"):
        assert words in out
    assert page.is_file()
    maker.build(a, A_PARTS, 250.0)
    maker.build(b, B_PARTS, 240.0)
    assert maker.compare(a, b) == 0
    out = capsys.readouterr().out
    for words in ("only in A: 6 x pin", "arm: description arm 91 -> arm 88", "-10 (-4 %)", f"open {page}"):
        assert words in out


@pytest.mark.parametrize("why", ["no build", "another design", "was changed", "of version"])
def test_a_build_that_is_not_of_the_design_is_not_read(
    why: str, maker: Maker, capsys: pytest.CaptureFixture[str]
) -> None:
    a, b = maker.design("a"), maker.design("b", cube__half_side_mm=40.0)
    maker.build(b, B_PARTS, 240.0)
    if why != "no build":
        folder = maker.build(a, A_PARTS, 250.0)
    if why == "another design":
        maker.design("a", cube__half_side_mm=42.0)
    elif why == "was changed":
        (folder / "checks.json").write_text((folder / "checks.json").read_text().replace("250.0", "150.0"))
    elif why == "of version":
        text = (folder / "manifest.json").read_text()
        (folder / "manifest.json").write_text(text.replace(version("delta-haptics"), "0.0.1"))
    assert maker.compare(a, b, "--json") == 0
    facts = found(capsys)
    assert why in facts["a"]["not_built"]
    assert facts["a"]["folder"] is facts["parts"] is facts["cost"] is None
    width, side = figures(facts)["swept outline, width"], figures(facts)["cube side"]
    assert (width["a"], width["b"], width["difference"], width["better"]) == (None, 240.0, None, None)
    assert side["a"] == pytest.approx(84.0 if why == "another design" else 86.33)


def test_what_fails_is_named_and_is_exit_code_1(maker: Maker, capsys: pytest.CaptureFixture[str]) -> None:
    a, b = maker.design("a"), maker.design("b", requirements__kappa_max=1.5)
    maker.build(a, A_PARTS, 250.0, failed=("drawings",))
    assert maker.compare(a, b, "--json") == 1
    facts = found(capsys)
    assert (facts["a"]["failed"], facts["b"]["failed"]) == (["drawings"], ["kappa"])


def test_what_is_no_machine_is_one_line(maker: Maker, capsys: pytest.CaptureFixture[str]) -> None:
    a, wrong = maker.design("a"), maker.folder / "wrong.json"
    wrong.write_text(json.dumps(changed(cube__half_side_mm=-1.0)))
    high = maker.folder / "high.json"
    high.write_text(json.dumps(changed(cube__bottom_height_mm=200.0)))
    for path, words in (
        (maker.folder / "none.json", "none.json"),
        (maker.folder, "holds no design.json; must be the folder of a build, or a design file"),
        (wrong, "cube.half_side_mm"),
        (high, "high.json"),
    ):
        assert maker.compare(a, path) == 2
        reported = capsys.readouterr()
        assert reported.out == ""
        assert reported.err.count("\n") == 1
        assert words in reported.err
    (maker.folder / "out").write_text("no folder")
    assert maker.compare(a, a) == 2
    assert "--out" in capsys.readouterr().err
