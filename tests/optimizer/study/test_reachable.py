"""Contours and shell of the workspace against the paper's own reach function (7), evaluated here."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.mechanism import DeltaGeometry
from optimizer.study.reachable import contours_at_height, contours_in_mirror_plane, shell

PUBLISHED = DeltaGeometry(base_radius=0.040, platform_radius=0.030, upper_arm_length=0.082, forearm_length=0.112079)
LONG_ARM = DeltaGeometry(base_radius=0.030, platform_radius=0.045, upper_arm_length=0.120, forearm_length=0.100)
ROUNDING = 1e-13
"""Of h over the fourth power of the lengths: some hundred roundings."""


def reach(g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    """(K, 3) h_i = C^2 - A^2 - B^2 of [RCIM2018] eqs. (2)-(7) over the fourth power of the reach; <= 0 is reached."""
    a, L_A, L_B = g.base_radius - g.platform_radius, g.upper_arm_length, g.forearm_length
    columns = []
    for phi in np.radians([0.0, 120.0, 240.0]):
        u = p[:, 0] * np.cos(phi) + p[:, 1] * np.sin(phi)
        A, B = 2.0 * L_A * (a - u), -2.0 * L_A * p[:, 2]
        C = L_A**2 - L_B**2 + a**2 + (p * p).sum(axis=1) - 2.0 * a * u
        columns.append(C * C - A * A - B * B)
    return np.stack(columns, axis=-1) / (L_A + L_B) ** 4


@pytest.fixture(params=["published, bottom", "published, high", "published, side", "long arm", "long arm, side"])
def section(request: pytest.FixtureRequest) -> tuple[DeltaGeometry, list[np.ndarray], int]:
    """A mechanism, its contour and the coordinate that is fixed."""
    kind = request.param
    if kind == "published, bottom":
        return PUBLISHED, contours_at_height(PUBLISHED, 0.060), 2
    if kind == "published, high":
        return PUBLISHED, contours_at_height(PUBLISHED, 0.180), 2
    if kind == "long arm":
        return LONG_ARM, contours_at_height(LONG_ARM, 0.010), 2
    g = PUBLISHED if kind.startswith("published") else LONG_ARM
    return g, contours_in_mirror_plane(g), 1


def test_contour_is_where_one_chain_ends_and_the_others_reach(
    section: tuple[DeltaGeometry, list[np.ndarray], int],
) -> None:
    g, pieces, _ = section
    assert pieces
    for piece in pieces:
        h = reach(g, piece)
        assert (np.abs(h).min(axis=1) < ROUNDING).all()
        # ends are bisected until the parameter cannot be halved: 1e-16 of a turn, its root in z
        assert h.max() < ROUNDING


def test_contour_parts_what_is_reached_from_what_is_not(section: tuple[DeltaGeometry, list[np.ndarray], int]) -> None:
    g, pieces, fixed = section
    plane = [k for k in range(3) if k != fixed]
    for piece in pieces:
        along = piece[2:, plane] - piece[:-2, plane]
        across = np.stack([-along[:, 1], along[:, 0]], axis=-1) / np.linalg.norm(along, axis=1)[:, None]
        sides = []
        for sign in (-1.0, 1.0):
            p = piece[1:-1].copy()
            p[:, plane] += sign * 2e-5 * across  # the contour's own polyline is 2 um off the curve
            sides.append(reach(g, p).max(axis=1) <= 0.0)
        away = slice(3, -3)  # at a corner both sides may be outside
        assert (sides[0] != sides[1])[away].all()


def test_contour_is_closed(section: tuple[DeltaGeometry, list[np.ndarray], int]) -> None:
    _, pieces, fixed = section
    ends = np.array([piece[k] for piece in pieces for k in (0, -1)])
    if fixed == 1:
        ends = ends[ends[:, 2] > 1e-7]  # what ends on the base plane is cut there
    for k, end in enumerate(ends):
        others = np.delete(ends, k, axis=0)
        assert np.linalg.norm(others - end, axis=1).min() < 1e-7  # the root of the bisected parameter's rounding


def test_every_crossing_of_a_line_is_on_the_contour() -> None:
    pieces = contours_at_height(PUBLISHED, 0.060)
    x = np.linspace(-0.2, 0.2, 200_001)
    line = np.stack([x, np.full_like(x, 0.0123), np.full_like(x, 0.060)], axis=-1)
    inside = reach(PUBLISHED, line).max(axis=1) <= 0.0
    crossings = x[:-1][inside[1:] != inside[:-1]]
    drawn = np.concatenate([_crossings(piece, 0.0123) for piece in pieces])
    assert len(drawn) == len(crossings) == 2
    assert np.sort(drawn) == pytest.approx(crossings, abs=4e-6)  # a step of the line and the polyline's own error


def _crossings(piece: np.ndarray, y: float) -> np.ndarray:
    a, b = piece[:-1], piece[1:]
    over = (a[:, 1] - y) * (b[:, 1] - y) < 0.0
    share = (y - a[over, 1]) / (b[over, 1] - a[over, 1])
    return a[over, 0] + share * (b[over, 0] - a[over, 0])


def test_plane_out_of_reach_has_no_contour() -> None:
    assert contours_at_height(PUBLISHED, 0.300) == []


@pytest.mark.parametrize("g", [PUBLISHED, LONG_ARM])
def test_shell_is_the_limit_of_reach(g: DeltaGeometry) -> None:
    s = shell(g, 25, 12)
    for height, sign in ((s.top, 1.0), (s.bottom, -1.0)):
        p = np.stack([s.x, s.y, height], axis=-1)[:, :-1].reshape(-1, 3)
        p = p[p[:, 2] > 1e-4]  # a bottom of 0 is the base plane, not a limit
        assert (np.abs(reach(g, p)).min(axis=1) < ROUNDING).all()
        step = np.array([0.0, 0.0, sign * 1e-6])
        beyond, within = p + step, p - step
        assert (reach(g, beyond).max(axis=1) > 0.0).all()
        assert (reach(g, within).max(axis=1) < 0.0).all()
    assert np.abs(s.top - s.bottom)[:, -1].max() < 1e-6  # the root of a bisected square
