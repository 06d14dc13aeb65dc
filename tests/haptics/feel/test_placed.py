"""The feel of machines whose chains do not stand alike: maps about the cube's middle, alike in their mirror halves."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.mechanism import jacobian
from haptics.feel.field import feel_at
from haptics.feel.sheet import cube_points, joint_drive
from haptics.feel.summary import QUANTITIES, WALL
from haptics.loop.hardware import wall_cap
from haptics.loop.walls import centre_and_corners, rendered
from tests.haptics.model.textbook import cube_points as corners_of
from tests.haptics.model.textbook import textbook
from tests.haptics.scene_machine import PLACED, placed_machine

MIRROR = np.array([1.0, -1.0, 1.0])


@pytest.mark.parametrize("name", PLACED)
def test_the_grid_fills_the_cube_where_it_stands_and_its_halves_are_alike(name: str) -> None:
    machine = placed_machine(name)
    p, cube = cube_points(machine, 5, 7, 3), machine.design.workspace
    np.testing.assert_allclose(p.reshape(-1, 3).min(axis=0), cube.lower, atol=1e-16)
    np.testing.assert_allclose(p.reshape(-1, 3).max(axis=0), cube.upper, atol=1e-16)
    drive = joint_drive(machine)
    here, there = feel_at(machine, drive, p), feel_at(machine, drive, p * MIRROR)
    for quantity in QUANTITIES:
        if quantity is not WALL:
            np.testing.assert_allclose(here[quantity.name], there[quantity.name], rtol=1e-9, err_msg=quantity.name)
    turned = feel_at(machine, drive, machine.centre + (p - machine.centre) * [-1.0, 1.0, 1.0])
    assert np.abs(turned["mass_max"] / here["mass_max"] - 1.0).max() > 0.01  # and no symmetry beyond that


@pytest.mark.parametrize("name", PLACED)
def test_mass_and_wall_are_those_of_the_textbook_at_every_corner(name: str) -> None:
    """Stability is looked at in the middle and in all eight corners."""
    machine = placed_machine(name)
    poses, corners = centre_and_corners(machine), corners_of(machine.design, 8, 0)
    np.testing.assert_allclose(np.sort(poses[1:], axis=0), np.sort(corners, axis=0), atol=1e-16)
    book, cap = textbook(machine.design), wall_cap(machine)
    for p in poses:
        J = book.jacobian(book.angles(p), p)
        assert rendered(cap, jacobian(machine.geometry, p))[0] == pytest.approx(rendered(cap, J)[0], rel=1e-6)
        kinetic = [book.kinetic(machine.masses, p, e) for e in np.eye(3)]
        both = [book.kinetic(machine.masses, p, np.eye(3)[i] + np.eye(3)[k]) for i, k in ((0, 1), (0, 2), (1, 2))]
        xy, xz, yz = (both[n] - kinetic[i] - kinetic[k] for n, (i, k) in enumerate(((0, 1), (0, 2), (1, 2))))
        xx, yy, zz = (2.0 * one for one in kinetic)
        mass = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        found = feel_at(machine, joint_drive(machine), p)
        assert (found["mass_min"], found["mass_max"]) == pytest.approx((mass[0], mass[2]), rel=1e-6)
