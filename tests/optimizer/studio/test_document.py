"""A requirements file that sliders change: comments and all else stay, and what is saved is what was set."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from optimizer.commands.init import PRESETS, preset_text
from optimizer.problem.validation import RequirementsError
from optimizer.studio import knobs
from optimizer.studio.document import Document, plain
from tests.optimizer.studio.tasks import JOYSTICK


def document(text: str) -> Document:
    return Document(text, "req.toml", Path())


def test_a_number_changes_and_every_comment_stays() -> None:
    text = JOYSTICK.read_text(encoding="utf-8")
    edited = document(text).with_values({knobs.FORCE: 3.5, knobs.MASS: 0.35})
    changed = [(a, b) for a, b in zip(text.splitlines(), edited.splitlines(), strict=True) if a != b]
    assert [b.split("#")[0].rstrip() for _, b in changed] == ["force_N = 3.5", "effective_mass_max_kg = 0.35"]
    assert changed[0][1].endswith("# for ever, beside the weight")


def test_a_field_that_is_commented_out_comes_into_force_and_one_that_is_removed_is_commented_out() -> None:
    text = preset_text("dashboard")
    edited = document(text).with_values({knobs.HEIGHT: 250.0, knobs.PEAK: None})
    data = tomllib.loads(edited)["requirements"]
    assert data["height_max_mm"] == 250.0
    assert "peak_force_N" not in data
    assert len(edited.splitlines()) == len(text.splitlines())
    assert "# peak_force_N = 6" in edited


def test_the_first_editions_place_of_a_field_is_kept() -> None:
    text = 'name = "a"\n[requirements]\nenvelope_width_mm = 270\nenvelope_depth_mm = 220\n[limits]\nkappa_max = 3\n'
    edited = document(text).with_values({knobs.KAPPA: 2.5})
    assert tomllib.loads(edited)["limits"] == {"kappa_max": 2.5}
    assert document(edited).brief().feel.kappa_max == 2.5


@pytest.mark.parametrize(
    "text",
    [
        'name = "a"\nrequirements = {envelope_width_mm = 270, envelope_depth_mm = 220} # one line\n',
        'name = "a"\nrequirements.envelope_width_mm = 270\nrequirements.envelope_depth_mm = 220\n',
        'name = "a"\n[requirements]\n'
        'envelope_width_mm = "27 cm"\nenvelope_depth_mm = 220\ngravity_m_s2 = [\n 0, 0, -9.81]\n',
        'name = "a"\n["requirements"]\nenvelope_width_mm = 270\nenvelope_depth_mm = 220\n',
    ],
)
def test_whatever_form_a_file_has_the_values_are_those_that_were_set(text: str) -> None:
    values = {knobs.WIDTH: 280.0, knobs.FORCE: 2.5, "hardware.motor": "maxon-re30-310007", "placement": "symmetric"}
    brief = document(document(text).with_values(values)).brief()
    assert (brief.requirements.envelope_width_mm, brief.requirements.force_N) == (280.0, 2.5)
    assert (brief.hardware["motor"], brief.placement) == ("maxon-re30-310007", "symmetric")


@pytest.mark.parametrize("preset", PRESETS)
def test_what_is_written_plainly_is_read_as_the_same(preset: str) -> None:
    data = tomllib.loads(preset_text(preset))
    assert tomllib.loads(plain(data)) == data


@settings(max_examples=60, deadline=None)
@given(
    preset=st.sampled_from(sorted(PRESETS)),
    values=st.dictionaries(
        st.sampled_from([knobs.FORCE, knobs.KAPPA, knobs.MASS, knobs.FRICTION, knobs.STIFFNESS]),
        st.none() | st.floats(1.1, 5.0).map(lambda value: round(value, 3)),
    ),
)
def test_any_setting_survives_the_file(preset: str, values: dict[str, float | None]) -> None:
    one = document(preset_text(preset))
    if values.get(knobs.FORCE, 1.0) is None:
        values[knobs.FORCE] = 3.0
    values.setdefault(knobs.PEAK, None)  # which must not be less than the continuous one
    written = document(one.with_values(values)).brief()
    assert {name: written.value(name) for name in values} == values


def test_what_contradicts_itself_is_refused_by_name() -> None:
    with pytest.raises(RequirementsError, match="peak_force_N"):
        document(JOYSTICK.read_text(encoding="utf-8")).brief({knobs.FORCE: 9.0})


def test_no_file_and_no_toml_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RequirementsError):
        Document.read(tmp_path / "none.toml")
    (tmp_path / "bad.toml").write_text("name = ", encoding="utf-8")
    with pytest.raises(RequirementsError, match=r"bad\.toml"):
        Document.read(tmp_path / "bad.toml")
