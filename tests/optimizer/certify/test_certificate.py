"""Certificates: made, written, read, replayed; and what is done to them is noticed."""

import json
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.design import design_from_dict
from delta_cad.mechanism import GeometryError, conditioning, cube_extremes, worst_joint_torque
from delta_cad.mechanism.limits import AssemblyMode, Kappa, Lean, Limits, Reach, Shoulder, Torque
from optimizer.certify.certificate import CertificateError, UnreadableError, certify, limits_of, verify
from optimizer.certify.file import (
    certificate_from_dict,
    certificate_to_dict,
    read_certificate,
    write_certificate,
)
from tests.delta_cad.mechanism.stated_limits import limits
from tests.designs import minimal
from tests.optimizer.messages import refuses


def design_of(mechanism=None, cube=None, **requirements):
    data = minimal()
    data["mechanism"] |= mechanism or {}
    data["cube"] |= cube or {}
    data["requirements"] |= requirements
    return design_from_dict(data)


@pytest.fixture(scope="module")
def design():
    return design_of()


@pytest.fixture(scope="module")
def tight(design):
    """All six conditions a thousandth above the extremes."""
    e = cube_extremes(design.geometry, design.workspace, 3.0)
    return limits(
        elbow_arm_min=float(np.sqrt(e.closure_margin_min.value)) / 1.001,
        force=3.0,
        torque_max=e.torque_max.value * 1.001,
        kappa_max=e.kappa_max.value * 1.001,
        shoulder=(e.shoulder_min.value - 0.001, e.shoulder_max.value + 0.001),
        lean_max=e.lean_max.value * 1.001,
    )


@pytest.fixture(scope="module")
def proved(design, tight):
    return certify(design, tight)


@pytest.fixture(scope="module")
def refuted(design, tight):
    return certify(design, tight.with_(Kappa(2.2), Torque(3.0, 0.3), Lean(0.4), Shoulder(-0.5, 1.0)))


def test_a_proved_certificate_is_proved_again(design, proved, tight):
    assert proved.verdict == "proved"
    replay = verify(proved, design)
    assert replay.proved == tight.names
    assert replay.refuted == replay.undecided == ()
    assert replay.leaves == len(proved.leaves)
    assert replay.boxes >= replay.leaves


def test_the_points_of_a_refuted_certificate_are_confirmed(design, refuted):
    assert refuted.verdict == "refuted"
    replay = verify(refuted, design)
    assert replay.refuted == ("torque", "kappa", "lean", "shoulder")
    assert replay.proved == ("reach", "assembly_mode")
    points = {f.condition: f.point for f in refuted.findings if f.point}
    assert conditioning(design.geometry, points["kappa"]) > 2.2
    assert worst_joint_torque(design.geometry, points["torque"], 3.0).max() > 0.3


def test_reach_refuted(design, tight):
    certificate = certify(design, tight.with_(Reach(0.06)))
    replay = verify(certificate, design)
    assert replay.refuted[0] == "reach"
    assert set(replay.refuted + replay.undecided) == set(tight.names)
    assert len(certificate.leaves) == 0


def test_the_hidden_singularity():
    mechanism = {"base_radius_mm": 46.122, "platform_radius_mm": 30.0, "forearm_length_mm": 94.266}
    hidden = design_of(mechanism, {"bottom_height_mm": 22.648, "half_side_mm": 43.363})
    certificate = certify(hidden, limits(force=3.0, torque_max=0.8, kappa_max=7.0))
    replay = verify(certificate, hidden)
    assert replay.refuted == ("assembly_mode", "torque", "kappa")
    assert replay.proved == ("reach",)


def test_undecided_is_neither(design, tight):
    seen = []
    certificate = certify(design, tight, max_boxes=40, progress=lambda n, share: seen.append((n, share)))
    assert certificate.verdict == "undecided"
    assert seen
    replay = verify(certificate, design)
    assert replay.undecided
    assert not set(replay.proved) & set(replay.undecided)


def test_limits_of_the_requirements(design):
    assert limits_of(design, None) == limits(force=3.0, torque_max=0.8)
    requested = design_of(kappa_max=3.0, lean_max_deg=28.0, shoulder_min_deg=-45.0, shoulder_max_deg=80.0)
    found = limits_of(requested, None)
    assert found.get(Kappa) == Kappa(3.0)
    assert np.radians(28.0) * (1 - 1e-15) < found.get(Lean).lean_max < np.radians(28.0)
    shoulder = found.get(Shoulder)
    assert np.radians(-45.0) < shoulder.shoulder_min < np.radians(-45.0) * (1 - 1e-15)
    assert np.radians(80.0) * (1 - 1e-15) < shoulder.shoulder_max < np.radians(80.0)
    assert range_of(shoulder_min_deg=-180.0) == pytest.approx((-np.pi, np.pi), abs=1e-15)
    assert range_of(shoulder_max_deg=80.0)[0] == -np.pi
    certificate = certify(requested)
    assert certificate.verdict == "proved"
    assert verify(certificate, requested).proved == found.names


def range_of(**requirements):
    return limits_of(design_of(**requirements), None)["shoulder"].thresholds()


def test_written_and_read_back(tmp_path, design, proved, refuted):
    seen = []
    for certificate in (proved, refuted):
        path = tmp_path / "certificate.json"
        write_certificate(certificate, path)
        assert list(tmp_path.iterdir()) == [path]
        read = read_certificate(path)
        assert certificate_to_dict(read) == json.loads(
            json.dumps(certificate_to_dict(certificate)), object_hook=_tuples
        )
        np.testing.assert_array_equal(read.leaves, certificate.leaves)
        assert (read.limits, read.geometry, read.cube) == (certificate.limits, certificate.geometry, certificate.cube)
        verify(read, design, progress=lambda *now: seen.append(now))
    assert seen[-1][1] == 1.0  # of the leaves are done


def _tuples(data):
    """Points and pairs as the records hold them."""
    for key in ("point_m", "reference_m", "shoulder_rad", "limit", "box_m"):
        if isinstance(data.get(key), list):
            data[key] = tuple(tuple(v) if isinstance(v, list) else v for v in data[key])
    return data


def about(certificate, changed):
    """A forgery that says it is about other limits, and is consistent in that."""
    findings = tuple(replace(f, limit=changed[f.condition].thresholds()) for f in certificate.findings)
    return replace(certificate, limits=changed, findings=findings)


def test_a_changed_threshold_is_noticed(proved, refuted):
    e = proved.limits
    shoulder, torque = e.get(Shoulder), e.get(Torque)
    for changed in (
        Kappa(e.get(Kappa).kappa_max * 0.997),
        Torque(torque.force, torque.torque_max * 0.997),
        Lean(e.get(Lean).lean_max * 0.997),
        Shoulder(shoulder.shoulder_min, shoulder.shoulder_max - 0.003),
        Reach(e.get(Reach).elbow_arm_min * 1.003),
    ):
        with pytest.raises(CertificateError, match=f"^{changed.name}: "):
            verify(about(proved, e.with_(changed)))
    for changed in (Kappa(2.5), Torque(3.0, 0.8), Lean(0.6), Shoulder(-1.0, 1.4)):
        with pytest.raises(CertificateError, match=f"^{changed.name}: "):
            verify(about(refuted, refuted.limits.with_(changed)))
    with refuses(CertificateError, "assembly_mode"):
        verify(replace(proved, limits=without(e, Kappa)))


def without(requested, kind):
    return Limits(tuple(limit for limit in requested if not isinstance(limit, kind)))


def test_missing_overlapping_and_moved_leaves_are_noticed(proved):
    leaves = proved.leaves
    with pytest.raises(CertificateError, match="missing"):
        verify(replace(proved, leaves=leaves[1:]))
    with pytest.raises(CertificateError, match="overlap"):
        verify(replace(proved, leaves=np.concatenate([leaves, leaves[:1]])))
    twins = next(n for n in range(len(leaves)) if (leaves[n, ::2] == leaves[0, ::2]).all() and n)
    moved = leaves.copy()
    moved[0] = leaves[twins]
    with pytest.raises(CertificateError, match=r"overlap|in no box"):
        verify(replace(proved, leaves=moved))
    with pytest.raises(CertificateError, match="outside"):
        verify(replace(proved, leaves=np.add(leaves, [0, 64, 0, 0, 0, 0])))


def test_coarser_leaves_are_still_proved_and_only_cost_time(proved):
    replay = verify(replace(proved, leaves=np.zeros((1, 6), dtype=np.int64)))
    assert replay.boxes > 100


def test_another_design_is_noticed(proved):
    longer = design_of({"forearm_length_mm": 112.08})
    with pytest.raises(CertificateError, match="dashboard-joystick"):
        verify(proved, longer)
    with pytest.raises(CertificateError, match="dimensions"):
        verify(proved, design_of(cube={"half_side_mm": 37.6}))
    with pytest.raises(CertificateError, match="hash"):
        verify(proved, design_of(force_N=4.0))


def test_a_certificate_that_asks_less_than_the_design_is_no_proof_of_it():
    strict = design_of(kappa_max=2.5, lean_max_deg=28.0, shoulder_min_deg=-45.0, shoulder_max_deg=80.0)
    requested = limits_of(strict, None)
    verify(certify(strict, requested.with_(Kappa(2.4), Torque(6.0, 1.6))), strict)
    low, high = requested["shoulder"].thresholds()
    for less, name in (
        (without(requested, AssemblyMode), "assembly_mode"),
        (without(requested, Torque), "torque"),
        (requested.with_(Torque(3.0 - 1e-15, 0.8)), "torque"),
        (requested.with_(Torque(3.0, 0.8 + 1e-15)), "torque"),
        (without(requested, Kappa), "kappa"),
        (requested.with_(Kappa(2.5 + 1e-15)), "kappa"),
        (without(requested, Shoulder), "shoulder"),
        (requested.with_(Shoulder(low - 1e-15, high)), "shoulder"),
        (requested.with_(Shoulder(low, high + 1e-15)), "shoulder"),
        (without(requested, Lean), "lean"),
        (requested.with_(Lean(requested.get(Lean).lean_max + 1e-15)), "lean"),
    ):
        certificate = certify(strict, less)
        assert certificate.verdict == "proved"
        verify(certificate)
        with pytest.raises(CertificateError, match=f"^{name}: "):
            verify(certificate, strict)
    assert requested.less_strict_than(requested.with_(Reach(1e-3))) == "reach"
    assert requested.with_(Reach(1e-3)).less_strict_than(requested) is None


def test_a_wrong_verdict_is_noticed(proved, refuted):
    flipped = tuple(replace(f, verdict="proved") if f.condition == "kappa" else f for f in refuted.findings)
    with pytest.raises(CertificateError, match=r"^kappa: "):
        verify(replace(refuted, findings=flipped))
    pointless = tuple(replace(f, point=None) for f in refuted.findings)
    with pytest.raises(CertificateError, match=r"^torque: "):
        verify(replace(refuted, findings=pointless))
    outside = tuple(replace(f, point=(0.2, 0.0, 0.1)) if f.point else f for f in refuted.findings)
    with pytest.raises(CertificateError, match="outside"):
        verify(replace(refuted, findings=outside))
    with pytest.raises(CertificateError, match="reach"):
        verify(replace(proved, findings=proved.findings[:1]))


def test_what_is_no_certificate_is_refused(tmp_path, proved):
    data = json.loads(json.dumps(certificate_to_dict(proved)))
    for case, message in (({k: v for k, v in data.items() if k != "cube"}, "cube: "), ([], "the file: ")):
        with pytest.raises(UnreadableError, match=message):
            certificate_from_dict(case)
    path = tmp_path / "c.json"
    path.write_text("{")
    with refuses(UnreadableError, "c.json"):
        read_certificate(path)
    with refuses(UnreadableError, "none.json"):
        read_certificate(tmp_path / "none.json")


def test_impossible_limits_are_refused(design):
    with refuses(GeometryError, "kappa_max", "0.5"):
        certify(design, limits(kappa_max=0.5))
