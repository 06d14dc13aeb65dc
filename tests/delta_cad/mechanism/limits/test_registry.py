"""What every limit of the registry must do, whichever it is: a limit that is added is tested here without a line."""

import math
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.mechanism import GeometryError
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.limits import LIMITS, POSE_LIMITS, Limits
from delta_cad.mechanism.limits.limit import ThresholdLimit
from delta_cad.mechanism.limits.numbers import number as limit_number
from delta_cad.mechanism.proof.extremes import worst_figures
from delta_cad.mechanism.proof.margins import BITS, FIRST, MARGINS, SIZE, START, numbers
from delta_cad.mechanism.proof.prove import prove
from tests.delta_cad.mechanism.limits.proving import CUBE, VALUES, around, extremes
from tests.delta_cad.mechanism.oracles import PUBLISHED

FIGURES = [pytest.param(kind, figure, id=figure.name or kind.name) for kind in POSE_LIMITS for figure in kind.figures]
BOUNDED = [case for case in FIGURES if case.values[1].threshold]
EACH = pytest.mark.parametrize("kind", POSE_LIMITS, ids=lambda kind: kind.name)


def ordinary(kind):
    """A limit of a kind with thresholds that a joystick could have: a little laxer than the published design."""
    return around(extremes(), 0.1, kind.name)[kind.name]


def adjacent(limit, figure, towards):
    """The limit with one figure's threshold moved by one ulp."""
    return limit.with_bound(figure, math.nextafter(limit.bound(figure), towards))


def less_strict_than(figure):
    return math.inf if figure.upper else -math.inf


def rounded(value, upwards):
    return f"{value:.3f}" + ("+" if upwards else "-")


def test_names_and_keys_are_said_once():
    assert len({kind.name for kind in LIMITS}) == len(LIMITS)
    assert len(set(Limits.keys())) == len(Limits.keys())
    fields = [field.name for kind in LIMITS for field in kind.fields_]
    assert len(set(fields)) == len(fields)


@EACH
def test_what_it_keeps_in_a_certificate_has_a_unit(kind):
    assert set(kind.measured(VALUES).record()) == set(kind.keys.values())


def test_margins_and_numbers_of_the_limits_stand_side_by_side():
    rows = [row for kind in POSE_LIMITS for row in range(FIRST[kind], FIRST[kind] + kind.enclosure.rows)]
    assert rows == list(range(MARGINS))
    taken = [place for kind in POSE_LIMITS for place in range(START[kind], START[kind] + kind.enclosure.size)]
    assert taken == list(range(forms.NUMBERS, SIZE))
    assert sum(BITS.values()) == (1 << MARGINS) - 1
    for kind in POSE_LIMITS:
        assert [row for row in range(MARGINS) if (BITS[kind] >> row) & 1] == list(
            range(FIRST[kind], FIRST[kind] + kind.enclosure.rows)
        )


@EACH
def test_its_numbers_are_as_many_as_it_says_and_stand_where_it_reads_them(kind):
    limit = ordinary(kind)
    own = limit.numbers()
    assert len(own) == kind.enclosure.size
    gathered = numbers(PUBLISHED, Limits.of(limit))
    np.testing.assert_array_equal(gathered[START[kind] : START[kind] + kind.enclosure.size], own)
    np.testing.assert_array_equal(gathered[: forms.NUMBERS], forms.lengths(PUBLISHED))


@EACH
def test_a_certificate_gives_it_back(kind):
    limit = ordinary(kind)
    again = Limits.from_record(Limits.of(limit).record())
    assert again == Limits.of(limit)
    assert again.get(kind) == limit
    assert kind.from_record(dict.fromkeys(Limits.keys())) is None or kind.always


def test_a_text_of_any_length_in_a_number_s_place_is_refused_in_a_line():
    with pytest.raises(GeometryError, match=r"^kappa_max is 'k+\.\.\.k+'; it must be") as refused:
        limit_number("kappa_max", 5000 * "k")
    assert len(str(refused.value)) < 120


@EACH
def test_its_words_contain_its_threshold(kind):
    limit = ordinary(kind)
    words = limit.words(rounded)
    assert words
    for figure in kind.figures:
        if figure.threshold:
            # an angle, a length: rounded to the side on which the words are still true
            assert rounded(limit.bound(figure) * figure.scale, figure.upper) in words


@EACH
def test_what_only_measures_bounds_nothing(kind):
    limit = kind.measured(VALUES)
    for figure in kind.figures:
        if not figure.threshold:
            continue
        end = figure.range[1] if figure.upper else figure.range[0]
        assert limit.bound(figure) == pytest.approx(end, rel=1e-15)
        with pytest.raises(GeometryError):
            adjacent(replace(limit, **{figure.threshold: end}), figure, less_strict_than(figure))


def test_limits_that_only_measure_are_proved_together():
    required = Limits.of(*(kind.measured(VALUES) for kind in POSE_LIMITS))
    assert required.names == tuple(kind.name for kind in POSE_LIMITS)
    assert {finding.verdict for finding in prove(PUBLISHED, CUBE, required).findings} == {"proved"}


def test_what_needs_more_than_lengths_is_measured_only_where_that_is_known():
    without = {"force_N": 3.0}
    assert [kind.name for kind in POSE_LIMITS if kind.measured(without) is None] == [
        kind.name for kind in POSE_LIMITS if kind.needs
    ]
    reported = {found.figure.name for found in worst_figures(PUBLISHED, CUBE, Limits.measured(without))}
    assert reported == {case.values[1].name for case in FIGURES if not case.values[0].needs}


@pytest.mark.parametrize(("kind", "figure"), BOUNDED)
def test_another_bound_changes_that_figure_alone(kind, figure):
    limit = ordinary(kind)
    other = adjacent(limit, figure, less_strict_than(figure))
    assert other.bound(figure) == math.nextafter(limit.bound(figure), less_strict_than(figure))
    assert replace(other, **{figure.threshold: limit.bound(figure)}) == limit


@pytest.mark.parametrize(("kind", "figure"), BOUNDED)
def test_one_ulp_looser_is_noticed_and_stricter_is_not(kind, figure):
    limit = ordinary(kind)
    required = Limits.of(limit)
    assert required.less_strict_than(required) is None
    assert Limits.of(adjacent(limit, figure, less_strict_than(figure))).less_strict_than(required) == kind.name
    assert Limits.of(adjacent(limit, figure, -less_strict_than(figure))).less_strict_than(required) is None


@EACH
def test_a_limit_that_is_left_out_is_noticed(kind):
    if not kind.always:
        assert Limits.of().less_strict_than(Limits.of(kind.measured(VALUES))) == kind.name


@pytest.mark.parametrize(("kind", "figure"), FIGURES)
def test_the_worst_figure_is_that_of_the_worst_chain(kind, figure):
    limit, p = kind.measured(VALUES), np.array([[0.01, 0.02, 0.09], [0.0, 0.0, 0.1], [0.0, 0.0, 0.4]])
    each = figure.values(limit, PUBLISHED, p)
    assert each.shape[:-1] == (3,)
    worst = figure.worst(limit, PUBLISHED, p)
    np.testing.assert_array_equal(worst, np.max(each, axis=-1) if figure.upper else np.min(each, axis=-1))
    assert np.isnan(worst[2]) or worst[2] < 0.0  # open: no value, or for the reach one by how much
    assert figure.stricter(1.0, 2.0) == (1.0 if figure.upper else 2.0)
    assert figure.sense == ("<=" if figure.upper else ">=" if figure.threshold else ">")


@EACH
def test_the_value_of_what_is_broken_is_that_of_the_figure_farthest_beyond(kind):
    limit = ordinary(kind)
    point = np.array([0.01, 0.02, 0.09])
    for figure in kind.figures:
        if figure.threshold:
            value = float(figure.worst(limit, PUBLISHED, point))
            # so strict that this point, inside the published cube, is far beyond it
            strict = limit.with_bound(figure, value - 0.01 * abs(value) if figure.upper else value + 0.01 * abs(value))
            assert strict.broken(PUBLISHED, point) == value


@EACH
def test_what_is_reported_of_it_names_its_field(kind):
    stated = {field.name: 30.0 + k for k, field in enumerate(field for every in LIMITS for field in every.fields_)}
    text = ordinary(kind).describe(VALUES | stated)
    assert text
    if issubclass(kind, ThresholdLimit):
        assert text == f"limits.{kind.fields_[0].name} = {stated[kind.fields_[0].name]}"


def test_limits_of_requirements():
    values = {
        "force_N": 3.0,
        "joint_torque_N_m": 0.8,
        "gravity_torque_N_m": 0.1,
        "lean_max_deg": 30.0,
        "shoulder_max_deg": 60.0,
    }
    found = Limits.stated(values)
    assert found.names == ("reach", "assembly_mode", "torque", "lean", "shoulder")
    assert found["torque"].thresholds() == pytest.approx(0.7)
    assert found["lean"].thresholds() < math.radians(30.0)
    assert found["shoulder"].thresholds() == (-math.pi, pytest.approx(math.radians(60.0)))
