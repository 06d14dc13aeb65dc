"""Where the links are, against constructions that share no formula with the placement."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve
from scipy.spatial.transform import Rotation

from delta_cad.mechanism import DeltaGeometry, UnreachableError, forward_kinematics
from delta_cad.mechanism.placement import LINKS, LinkPlacement, chain_stand, chain_turn, frames, spring_sway

R, r, L_A, L_B, L_c = 40.0, 30.0, 82.0, 112.079, 54.0
RATIO, PINION = 9.85, (14.5, -36.4)
PLACE = LinkPlacement(DeltaGeometry(R / 1e3, r / 1e3, L_A / 1e3, L_B / 1e3), L_c, PINION, RATIO)
CENTRE = np.array([0.0, 0.0, 94.612])
RNG = np.random.default_rng(11)
POSES = np.concatenate(
    [CENTRE + 37.5 * np.array(list(product((-1, 0, 1), repeat=3))), CENTRE + RNG.uniform(-37.5, 37.5, (60, 3))]
)
EXACT_MM = 1e-10  # a few roundings of numbers of 100 mm


def place(p: np.ndarray) -> dict[str, np.ndarray]:
    return dict(PLACE(p))


def along(frame: np.ndarray, point: tuple[float, float, float]) -> np.ndarray:
    return frame[..., :3, :3] @ np.array(point) + frame[..., :3, 3]


def azimuth(i: int) -> tuple[np.ndarray, np.ndarray]:
    angle = 2 * np.pi * i / 3
    return np.array([np.cos(angle), np.sin(angle), 0]), np.array([-np.sin(angle), np.cos(angle), 0])


def solved_angle(p: np.ndarray, i: int) -> float:
    """Shoulder angle by bisection on the rod's length, between the arm straight out and the arm on the far side."""
    u, _ = azimuth(i)

    def excess(theta: float) -> float:
        elbow = (R + L_A * np.cos(theta)) * u + np.array([0, 0, L_A * np.sin(theta)])
        return float(np.linalg.norm(p + r * u - elbow) - L_B)

    grid = np.radians(np.arange(-90.0, 120.0, 1.0))  # outwards branch: the first closing angle from below
    values = [excess(t) for t in grid]
    k = next(k for k, (a, b) in enumerate(pairwise(values)) if a > 0 >= b)
    return float(np.asarray(brentq(excess, grid[k], grid[k + 1], xtol=1e-14)))


def test_links_are_named_once_and_all_placed() -> None:
    assert len(LINKS) == len(set(LINKS)) == 20
    assert set(place(CENTRE)) == set(LINKS)


def test_every_link_is_a_rigid_motion_and_batches_agree_with_single_poses() -> None:
    batch = place(POSES)
    for name, frame in batch.items():
        assert frame.shape == (len(POSES), 4, 4), name
        rotation = frame[:, :3, :3]
        np.testing.assert_allclose(
            rotation @ np.swapaxes(rotation, -1, -2), np.broadcast_to(np.eye(3), rotation.shape), atol=1e-13
        )
        np.testing.assert_allclose(np.linalg.det(rotation), 1, atol=1e-13)
        np.testing.assert_array_equal(frame[:, 3], np.broadcast_to([0, 0, 0, 1], (len(POSES), 4)))
    for k in (0, 13, 40):
        single = place(POSES[k])
        for name in LINKS:
            np.testing.assert_allclose(single[name], batch[name][k], rtol=0, atol=EXACT_MM)
    grid = place(POSES[:24].reshape(2, 3, 4, 3))
    np.testing.assert_allclose(grid["rod_2_1"].reshape(24, 4, 4), batch["rod_2_1"][:24], rtol=0, atol=EXACT_MM)


def test_base_stands_still_and_platform_never_turns() -> None:
    links = place(POSES)
    assert (links["base"] == np.eye(4)).all()
    assert (links["platform"][:, :3, :3] == np.eye(3)).all()
    np.testing.assert_array_equal(links["platform"][:, :3, 3], POSES)


@pytest.mark.parametrize("i", range(3))
def test_arms_are_where_bisection_on_the_rod_s_length_puts_them(i: int) -> None:
    u, t = azimuth(i)
    for p in POSES[::5]:
        arm = place(p)[f"upper_arm_{i}"]
        theta = solved_angle(p, i)
        np.testing.assert_allclose(arm[:3, 3], R * u, atol=EXACT_MM)
        np.testing.assert_allclose(arm[:3, 1], t, atol=1e-14)
        expected = (R + L_A * np.cos(theta)) * u + [0, 0, L_A * np.sin(theta)]
        np.testing.assert_allclose(along(arm, (L_A, 0, 0)), expected, atol=1e-9)  # bisection to 1e-14 rad and a root


def test_forward_kinematics_of_the_arms_gives_the_handle_back() -> None:
    links = place(POSES)
    angles = []
    for i in range(3):
        u, _ = azimuth(i)
        x = links[f"upper_arm_{i}"][:, :3, 0]
        angles.append(np.arctan2(x[:, 2], x @ u))
    found = forward_kinematics(PLACE.geometry, np.stack(angles, axis=-1)) * 1e3
    np.testing.assert_allclose(found, POSES, atol=1e-9)


def test_six_rods_alone_determine_the_platform() -> None:
    """Without the assumption that it does not turn: six rod lengths solved for six degrees of freedom."""
    for p in POSES[5:45:13]:
        links = place(p)
        elbows = np.array([links[f"rod_{i}_{j}"][:3, 3] for i in range(3) for j in range(2)])
        wrists = np.array([r * azimuth(i)[0] + (j - 0.5) * L_c * azimuth(i)[1] for i in range(3) for j in range(2)])

        def excess(q: np.ndarray, elbows: np.ndarray = elbows, wrists: np.ndarray = wrists) -> np.ndarray:
            moved = Rotation.from_rotvec(q[3:]).apply(wrists) + q[:3]
            return np.linalg.norm(moved - elbows, axis=1) - L_B

        found = np.asarray(
            fsolve(excess, np.concatenate([p + np.array([1.0, -2.0, 1.5]), [0.02, -0.01, 0.03]]), xtol=1e-13)
        )
        np.testing.assert_allclose(found[:3], p, atol=1e-7)
        np.testing.assert_allclose(found[3:], 0, atol=1e-9)


@pytest.mark.parametrize(("i", "j"), list(product(range(3), range(2))))
def test_rods_join_elbow_and_wrist_at_their_length(i: int, j: int) -> None:
    links = place(POSES)
    side = (j - 0.5) * L_c
    rod = links[f"rod_{i}_{j}"]
    np.testing.assert_allclose(rod[:, :3, 3], along(links[f"upper_arm_{i}"], (L_A, side, 0)), atol=EXACT_MM)
    u, t = azimuth(i)
    np.testing.assert_allclose(along(rod, (L_B, 0, 0)), POSES + r * u + side * t, atol=1e-9)


@pytest.mark.parametrize("i", range(3))
def test_the_rods_of_a_chain_stay_parallel_and_face_the_shoulder_axis(i: int) -> None:
    links = place(POSES)
    a, b = links[f"rod_{i}_0"], links[f"rod_{i}_1"]
    np.testing.assert_array_equal(a[:, :3, :3], b[:, :3, :3])
    _, t = azimuth(i)
    apart = b[:, :3, 3] - a[:, :3, 3]
    np.testing.assert_allclose(apart, np.broadcast_to(L_c * t, apart.shape), atol=EXACT_MM)
    y = a[:, :3, 1]
    assert (y @ t > 0.8).all()  # the sockets' axis leans with the rod, less than 37 deg in this cube
    normal = np.cross(a[:, :3, 0], t)  # y lies in the plane of the rod and the shoulder axis
    np.testing.assert_allclose((normal * y).sum(-1), 0, atol=1e-14)


@pytest.mark.parametrize("i", range(3))
def test_the_pinion_turns_by_the_ratio_the_other_way(i: int) -> None:
    """Followed in steps small enough that no turn is lost, and by equal lengths of cable."""
    _, t = azimuth(i)
    path = CENTRE + np.linspace([-20, -15, -30], [25, 20, 30], 400)
    links = place(path)

    def turned(frame: np.ndarray) -> np.ndarray:
        steps = np.swapaxes(frame[:-1, :3, :3], -1, -2) @ frame[1:, :3, :3]
        vector = np.einsum("kab,kbc->kac", frame[:-1, :3, :3], steps) @ np.swapaxes(frame[:-1, :3, :3], -1, -2)
        return Rotation.from_matrix(vector).as_rotvec() @ t

    arm, pinion = turned(links[f"upper_arm_{i}"]), turned(links[f"pinion_{i}"])
    assert np.abs(pinion).max() < 0.5
    np.testing.assert_allclose(pinion, -RATIO * arm, atol=1e-11)
    assert np.abs(arm).sum() > 0.2
    u, _ = azimuth(i)
    centre = PINION[0] * u + [0, 0, PINION[1]]
    np.testing.assert_allclose(links[f"pinion_{i}"][:, :3, 3], np.broadcast_to(centre, (400, 3)), atol=EXACT_MM)
    np.testing.assert_allclose(links[f"pinion_{i}"][:, :3, 1], np.broadcast_to(t, (400, 3)), atol=1e-14)


def test_a_direct_drive_turns_with_its_arm() -> None:
    direct = LinkPlacement(PLACE.geometry, L_c, (R, 0.0), 1.0)(POSES)
    for i in range(3):
        np.testing.assert_allclose(direct[f"pinion_{i}"], direct[f"upper_arm_{i}"], atol=EXACT_MM)


def test_a_third_of_a_turn_moves_each_chain_to_the_next() -> None:
    turn = np.eye(4)
    turn[:2, :2] = [[-0.5, -(0.75**0.5)], [0.75**0.5, -0.5]]
    links, next_links = place(POSES), place(POSES @ turn[:3, :3].T)
    for name in ("upper_arm_{}", "pinion_{}", "rod_{}_0", "rod_{}_1"):
        for i in range(3):
            expected = turn @ links[name.format(i)]
            np.testing.assert_allclose(next_links[name.format((i + 1) % 3)], expected, atol=1e-10)


def test_mirrored_poses_exchange_chains_one_and_two() -> None:
    mirror = np.diag([1.0, -1.0, 1.0])
    links, mirrored = place(POSES), place(POSES @ mirror)
    for a, b in ((0, 0), (1, 2), (2, 1)):
        np.testing.assert_allclose(
            mirrored[f"upper_arm_{a}"][:, :3, 0], links[f"upper_arm_{b}"][:, :3, 0] @ mirror, atol=1e-13
        )
        np.testing.assert_allclose(mirrored[f"rod_{a}_0"][:, :3, 0], links[f"rod_{b}_1"][:, :3, 0] @ mirror, atol=1e-13)


def test_a_pose_out_of_reach_is_refused() -> None:
    with pytest.raises(UnreachableError, match="chain"):
        PLACE(np.array([0.0, 0.0, 195.0]))  # R - r + L_A + L_B = 204 in line, 194 straight above
    with pytest.raises(UnreachableError):
        PLACE(np.stack([CENTRE, CENTRE + np.array([0, 0, 150.0])]))


def test_frames_put_their_axes_where_they_are_reported() -> None:
    frame = frames(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), np.array([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(frame, [[0, 0, 1, 1], [1, 0, 0, 2], [0, 1, 0, 3], [0, 0, 0, 1]])
    for i in range(3):
        u, t = azimuth(i)
        turn = chain_turn(PLACE.geometry, i)
        np.testing.assert_allclose(turn[:3, :3], np.stack([u, t, [0, 0, 1]], axis=-1), atol=1e-15)
        np.testing.assert_array_equal(chain_stand(PLACE.geometry, i), turn)  # equal radii: nothing is moved out


def test_three_equal_chains_stand_each_in_its_place() -> None:
    """What stands on the base lies in its chain's stand as chain 0's does, and each arm reaches its wrist by a rod."""
    phi, side = 113.0, 47.5
    g = DeltaGeometry(R / 1e3, r / 1e3, L_A / 1e3, L_B / 1e3, (side - R) / 1e3, np.cos(np.radians(phi)))
    links = dict(LinkPlacement(g, L_c, PINION, RATIO)(POSES))
    for i, azimuth_deg in enumerate((0.0, phi, -phi)):
        turn = Rotation.from_euler("z", azimuth_deg, degrees=True).as_matrix()
        stand = chain_stand(g, i)
        np.testing.assert_allclose(stand[:3, :3], turn, atol=1e-15)
        np.testing.assert_allclose(stand[:3, 3], turn @ [(R, side, side)[i] - R, 0.0, 0.0], atol=EXACT_MM)
        arm, pinion = (np.linalg.inv(stand) @ links[f"{name}_{i}"] for name in ("upper_arm", "pinion"))
        np.testing.assert_allclose(arm[:, :3, 3], np.tile([R, 0.0, 0.0], (len(POSES), 1)), atol=EXACT_MM)
        np.testing.assert_allclose(pinion[:, :3, 3], np.tile([PINION[0], 0, PINION[1]], (len(POSES), 1)), atol=EXACT_MM)
        elbow = along(links[f"upper_arm_{i}"], (L_A, 0.0, 0.0))
        wrist = POSES + turn @ [r, 0.0, 0.0]
        np.testing.assert_allclose(np.linalg.norm(wrist - elbow, axis=-1), L_B, rtol=1e-13)
        for j in range(2):
            aside = turn @ [0.0, (j - 0.5) * L_c, 0.0]
            np.testing.assert_allclose(links[f"rod_{i}_{j}"][:, :3, 3], elbow + aside, atol=EXACT_MM)
            np.testing.assert_allclose(along(links[f"rod_{i}_{j}"], (L_B, 0.0, 0.0)), wrist + aside, atol=1e-9)


@pytest.mark.parametrize("eye_mm", [(0.8, 5.5), (4.0, 0.5)])
def test_no_pair_of_rods_lets_its_spring_stray_farther(eye_mm: tuple[float, float]) -> None:
    """Eyes as vectors on rods 54 mm apart along y; and no bound is far beyond what some pair does.

    A rod that leans turns about itself by no more than `cos(lean) cos(turn) >= cos(tilt)`. The spring runs from the eye
    of the one rod to that of the other; its direction is taken against the shoulder axis, its middle against where it
    lies while neither rod turns.
    """
    width, tilt, (inside, aside) = 54.0, np.radians(31.0), eye_mm
    bound = spring_sway(width, inside, aside, tilt)
    along, across, turned = [], [], []
    for lean in np.linspace(0.0, tilt, 25):
        most = float(np.arccos(min(np.cos(tilt) / np.cos(lean), 1.0)))
        rod = np.array([np.cos(lean), np.sin(lean), 0.0])  # x square to the shoulder axis y
        facing, normal = np.array([-np.sin(lean), np.cos(lean), 0.0]), np.array([0.0, 0.0, 1.0])
        near, far = inside * facing + aside * normal, -inside * facing + aside * normal
        for first, second in product(np.linspace(-most, most, 9), repeat=2):
            a, b = Rotation.from_rotvec(first * rod).apply(near), Rotation.from_rotvec(second * rod).apply(far)
            spring = np.array([0.0, width, 0.0]) + b - a
            moved = (a - near + b - far) / 2.0
            turned.append(np.arccos(spring[1] / np.linalg.norm(spring)))
            along.append(abs(moved[1]))
            across.append(np.hypot(moved[0], moved[2]))
    for found, limit, share in (
        (max(along), bound.along_mm, 0.5),  # the eyes' turns inwards cancel
        (max(across), bound.across_mm, 0.95),
        (max(turned), bound.turn_rad, 0.85),
    ):
        assert share * limit <= found <= limit * (1.0 + 1e-12)


def test_a_spring_at_its_rods_own_height_strays_as_a_closed_form_says() -> None:
    """Eyes 4 mm inside rods 54 mm apart, none aside: across its line by 8 mm times the sines of lean and turn at once.

    With `cos(lean) cos(turn) = cos(tilt)` the sum of their squares is largest where both are alike: 2 - 2 cos(tilt).
    """
    tilt = np.radians(31.0)
    sway = spring_sway(54.0, 4.0, 0.0, tilt)
    assert sway.turn_rad == pytest.approx(np.arctan(8.0 * np.sqrt(2.0 - 2.0 * np.cos(tilt)) / 46.0), rel=0.01)
    assert sway.along_mm == pytest.approx(4.0 * (1.0 - np.cos(tilt)))
    assert sway.across_mm == pytest.approx(4.0 * np.sin(tilt), rel=1e-3)
