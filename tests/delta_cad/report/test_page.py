"""The page as a file: whole, escaped, in itself, and of the figures that the build's other files tell."""

from __future__ import annotations

import hashlib
import json
import re
import zipfile
from base64 import b64decode, b64encode
from dataclasses import replace
from pathlib import Path

import pytest

from delta_cad.checks.range.feel import poor_verdict
from delta_cad.checks.registry import CHECKS
from delta_cad.checks.report import CheckResult
from delta_cad.common.reading import ReadError
from delta_cad.design import design_hash, load_design
from delta_cad.report.page import FILE_NAME, SEARCHED, VENDOR, write_report
from delta_cad.report.subject import Subject
from tests.committed import Built
from tests.delta_cad.export.machine import make_assembly, make_parts
from tests.delta_cad.report.reading import Page

MOST_BYTES = 4_000_000
BAD = "</script><script>alert('x')</script><img src=x onerror=\"alert(1)\">&amp;'\""


def written(subject: Subject, folder: Path) -> Page:
    return Page(write_report(subject, folder, {"python": BAD}).read_text(encoding="utf-8"))


def test_names_and_texts_of_others_do_no_harm(subject: Subject, folder: Path) -> None:
    parts = make_parts()
    parts["upper_arm"] = replace(
        parts["upper_arm"], description=BAD, material=replace(parts["upper_arm"].material, name=BAD)
    )
    row = {"item": 1, "part_number": BAD, "description": BAD, "quantity": 3, "cost_EUR": 1.25, "source": BAD, BAD: BAD}
    (folder / "bom.json").write_text(json.dumps({"items": [row]}), encoding="utf-8")
    (folder / "drawings").mkdir()
    (folder / "drawings" / '"onclick="x<b>.pdf').write_text("")
    failed = CheckResult(BAD, False, 1.0, 2.0, BAD, (0.0, 0.0, 90.0), (BAD,), BAD)
    other = replace(subject, assembly=make_assembly(parts), results=(failed,), unverified=(BAD,))
    found = written(other, folder)
    plain = written(subject, folder)
    assert [e.tag for e in found.all("img")] == []
    assert found.scripts() == plain.scripts()
    assert len(found.all("script")) == len(found.scripts()) + 2
    assert not any(name.startswith("on") for e in found.elements for name in e.attributes)
    assert BAD in [part["description"] for part in found.data()["parts"]]
    assert found.rows("parts")[1][2:4] == [BAD, f"{BAD}source{BAD}"]
    assert "1.25" in found.rows("parts")[1]
    assert found.rows("checks")[1][0] == BAD
    assert f"verified: {BAD}." in next(e.text for e in found.all("section", id="proof"))


def test_only_its_own_scripts_may_run_and_nothing_be_required_elsewhere(page: Page) -> None:
    (policy,) = page.all("meta", **{"http-equiv": "Content-Security-Policy"})
    rules = dict(rule.strip().split(" ", 1) for rule in policy.attributes["content"].split(";"))

    def hashes(texts: list[str]) -> str:
        digests = (b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode() for text in texts)
        return " ".join(f"'sha256-{digest}'" for digest in digests)

    assert rules["default-src"] == "'none'"
    assert rules["script-src"] == hashes(page.scripts())
    assert rules["style-src"] == hashes([e.text for e in page.all("style")])
    assert rules["img-src"] == "data: blob:"
    assert [e for e in page.elements if {"src", "srcset", "style"} & e.attributes.keys()] == []
    assert page.all("link") == page.all("iframe") == []
    assert "url(" not in page.all("style")[0].text
    assert "@import" not in page.all("style")[0].text


def test_links_lead_to_files_of_the_build(page: Page, built: Built) -> None:
    hrefs = [e.attributes["href"] for e in page.all("a")]
    within = [href.removeprefix("#") for href in hrefs if href.startswith("#")]
    assert len(within) == 12
    assert {e.attributes.get("id") for e in page.all("section")} >= set(within)
    files = {href for href in hrefs if not href.startswith("#")}
    there = {p.relative_to(built.folder).as_posix() for p in built.folder.rglob("*") if p.is_file()}
    assert files | {"manifest.json"} == there - {FILE_NAME}  # which is written last


def test_everything_and_the_quotation_are_downloads(page: Page, built: Built) -> None:
    links = {e.attributes["href"]: e.text for e in page.all("a") if "download" in e.attributes}
    assert list(links)[:2] == ["everything.zip", "quotation.zip"]
    for name, words in links.items():
        size = (built.folder / name).stat().st_size
        if found := re.search(r"([\d.]+) (MB|kB)", words):
            assert float(found[1]) * {"MB": 1e6, "kB": 1e3}[found[2]] == pytest.approx(size, rel=0.05, abs=1e3)
    with zipfile.ZipFile(built.folder / "everything.zip") as archive:
        assert archive.testzip() is None
        packed = {name.partition("/")[2]: archive.read(name) for name in archive.namelist()}
        assert {name.partition("/")[0] for name in archive.namelist()} == {built.folder.name}
    files = {p.relative_to(built.folder).as_posix(): p for p in built.folder.rglob("*") if p.is_file()}
    assert packed.keys() == files.keys() - {"everything.zip", "manifest.json"}
    assert all(files[name].read_bytes() == content for name, content in packed.items())
    unpacked = sum(path.stat().st_size for path in files.values()) - len((built.folder / "everything.zip").read_bytes())
    assert (built.folder / "everything.zip").stat().st_size < 0.55 * unpacked  # the folder is not doubled


def test_it_holds_the_model_once_and_is_small(page: Page, built: Built) -> None:
    assert b64decode(page.one("model").text, validate=True) == (built.folder / "assembly.glb").read_bytes()
    assert (built.folder / FILE_NAME).stat().st_size <= MOST_BYTES
    names = set(page.data()["occurrences"])
    glb = (built.folder / "assembly.glb").read_bytes()
    nodes = json.loads(glb[20 : 20 + int.from_bytes(glb[12:16], "little")])["nodes"]
    assert names == {node["name"] for node in nodes if "mesh" in node}


def test_its_figures_are_those_of_the_checks(page: Page, built: Built) -> None:
    checks = {check["name"]: check for check in json.loads((built.folder / "checks.json").read_text())["checks"]}
    reported = {cells[0]: cells for cells in page.rows("figures") if len(cells) == 6}
    for words, name in (
        ("Joint torque, force and weight together", "torque with gravity"),
        ("Swept outline, depth", "envelope depth"),
        ("Clearance of moving bodies", "clearance"),
        ("Stiffness at the knob, worst in the cube", "structure stiffness at the knob"),
        ("Conditioning, worst in the cube", "kappa"),
        ("Shoulder, lowest", "shoulder min"),
        ("Drive torque, continuous", "drive torque"),
    ):
        check, (_, value, limit, margin, verdict, at) = checks[name], reported[words]
        assert float(value.split()[0]) == pytest.approx(check["value"], rel=5e-4)
        assert float(limit.split()[1]) == pytest.approx(check["limit"], rel=5e-4)
        assert limit[0] == ("≤" if check["value"] < check["limit"] else "≥")
        assert verdict == "holds"
        room = float(re.sub(r"[^-\d.e].*", "", margin.removeprefix("+")))
        assert room == pytest.approx(abs(check["value"] - check["limit"]), rel=5e-3)
        if at:
            shown = [float(v) for v in at.split(",")]
            assert shown == pytest.approx(check["worst_pose_mm"], abs=0.0501)


def test_every_check_and_every_part_stands_in_it(page: Page, built: Built) -> None:
    record = json.loads((built.folder / "checks.json").read_text())
    checks = record["checks"]
    rows = [row for row in page.rows("checks") if row[0] != "Check"]
    counted = sum(int(m[1]) if (m := re.search(r"\((\d+)×\)$", row[0])) else 1 for row in rows)
    assert counted == len(checks)
    sums = re.findall(r"(\d+) of (\d+) hold", " ".join(e.text for e in page.all("summary")))
    assert sum(int(holding) for holding, _ in sums) == sum(int(count) for _, count in sums) == len(checks)
    assert {kind.label for kind in CHECKS} >= {e.text for e in page.all("b")} - {"Drawings"} != set()
    assert page.one("verdict").text.strip() == poor_verdict(record["poor"]) != ""  # 0.77 kg and 1.1 N at 3 N
    assert "poor" in page.one("verdict").attributes["class"].split()
    items = json.loads((built.folder / "bom.json").read_text())["items"]
    assert [row[2] for row in page.rows("parts")[1:]] == [item["part_number"] for item in items]


def test_the_design_in_it_builds_the_same_machine(page: Page, built: Built, tmp_path: Path) -> None:
    origin = next(e for e in page.all("section", id="origin"))
    begin = origin.text.index("{")
    path = tmp_path / "again.json"
    path.write_text(origin.text[begin : origin.text.rindex("}") + 1], encoding="utf-8")
    again = design_hash(load_design(path))
    assert again == built.record["input_sha256"]
    assert again in origin.text


def test_the_library_is_what_its_record_says(page: Page) -> None:
    record = json.loads((VENDOR / "three.json").read_text(encoding="utf-8"))
    library = (VENDOR / "three.js").read_bytes()
    assert hashlib.sha256(library).hexdigest() == record["sha256"]
    assert page.scripts()[0] == library.decode("utf-8")
    assert record["version"] in record["source"]
    assert "MIT License" in (VENDOR / "three.LICENSE").read_text(encoding="utf-8")


def test_what_fails_comes_first_and_out_of_reach_there_are_no_maps(subject: Subject, folder: Path) -> None:
    reach = CheckResult("reach", False, -3.0, 0.0, "mm", (1.0, 2.0, 90.0), ("chain_0",), "out of reach")
    fine = CheckResult("parts attached", True, 0.0, 0.0, "")
    found = written(replace(subject, results=(fine, reach)), folder)
    assert [row[0] for row in found.rows("checks") if row[0] != "Check"] == ["reach", "reach", "parts attached"]
    assert found.one("verdict").text.strip() == "1 of 2 checks FAIL"
    assert found.rows("figures")[1][1:5] == ["-3 mm", "≥ 0 mm", "−3 mm", "FAILS"]
    assert found.data()["slices"]["maps"] == []
    assert not any(e.attributes.get("id") == "maps" for e in found.elements)


def test_a_certificate_next_to_it_is_reported_with_the_command_that_replays_it(subject: Subject, folder: Path) -> None:
    limits = {"torque_max_N_m": 0.39, "force_N": 3.0, "kappa_max": 2.27}
    findings = [{"condition": "kappa", "verdict": "proved"}, {"condition": "torque", "verdict": "refuted"}]
    data = {"schema": "delta-certificate/1", "design_hash": design_hash(subject.design), "boxes": 12, "limits": limits}
    (folder / "certificate.json").write_text(json.dumps(data | {"findings": findings}), encoding="utf-8")
    (proof,) = written(subject, folder).all("section", id="proof")
    for words in ("by 12 boxes", "kappa <= 2.27", ": refuted", "optimizer verify certificate.json"):
        assert words in proof.text
    assert "This build proved" not in proof.text
    (folder / "certificate.json").unlink()
    (proof,) = written(subject, folder).all("section", id="proof")
    assert "This build proved" in proof.text
    assert "optimizer certify" in proof.text


def test_how_it_was_found_is_a_page_next_to_it(subject: Subject, folder: Path) -> None:
    assert "How it was found" not in [e.text for e in written(subject, folder).all("a")]
    (folder / SEARCHED).write_text("")
    (link,) = [e for e in written(subject, folder).all("a") if e.text == "How it was found"]
    assert link.attributes["href"] == SEARCHED


def test_the_same_machine_gives_the_same_bytes(subject: Subject, folder: Path) -> None:
    first = write_report(subject, folder, {}).read_bytes()
    assert write_report(subject, folder, {}).read_bytes() == first


def test_without_the_model_there_is_no_page(subject: Subject, folder: Path) -> None:
    (folder / "assembly.glb").unlink()
    with pytest.raises(OSError, match=r"assembly\.glb"):
        write_report(subject, folder, {})
    assert not (folder / FILE_NAME).exists()
    (folder / "bom.json").write_text("no JSON")
    with pytest.raises(ReadError, match=r"bom\.json"):
        write_report(subject, folder, {})
