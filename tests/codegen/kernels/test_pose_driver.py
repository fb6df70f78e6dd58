"""The driver of the search as plain Python: around the arm's step, and around steps that are set by hand."""

from functools import cache

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels.pose_driver import NUMBERS, buffer_size, layout, pose_driver
from lwr_dyn.codegen.kernels.pose_source import pose_step
from lwr_dyn.kinematics.closed_forms.python_text import python_text
from lwr_dyn.kinematics.pose_solver import FOUND, INVALID, NOT_REACHED, OUTSIDE, TAIL, search_ranges
from tests.kinematics.solved_poses import assert_reached
from tests.public_arms import random_positions

ARM = lwr_dyn.load("lwr4plus")
EYE = np.eye(4)
TURN = 2.0 * np.pi


@cache
def driver(n=1, W=2):
    """The functions of the text without a compiler; `body` is to be set."""
    names = dict(NUMBERS)
    exec(python_text(pose_driver(n, W)), names)
    return names


def searched(body, settings, T, q0=None, W=2):
    """The rows of poses; `body` (q, T, repair, start) -> next q and measures, by columns."""
    s, n, T = np.array(settings, dtype=float), int(settings[3]), np.reshape(T, (-1, 4, 4)).astype(float)
    out, b = np.full(len(T) * (n + TAIL), 77.0), np.full(buffer_size(n, W), 77.0)
    places, functions, left = layout(n, W), driver(n, W), iter(range(5000))

    def step(memory):
        next(left)  # a search that does not end fails
        rows = memory.reshape(-1, W)
        start = rows[places["STATE"] + places["START"]]
        q, measures = body(rows[:n].copy(), rows[n : n + 12].copy(), rows[n + 12].copy(), start)
        rows[n + 14 : 2 * n + 14] = q
        for row, measure in zip(rows[2 * n + 14 :], measures, strict=False):
            row[:] = measure

    first, stride = (np.zeros(n), -1) if q0 is None else (np.ravel(q0).astype(float), n)
    functions["body"] = step
    functions["search"](T.ravel(), 16, first, stride, s, len(s), out, b, 0, len(T))
    return out.reshape(len(T), -1)


def settings(starts=((0.0,),), lower=-3.0, upper=3.0, *, turns=1.0, redundant=0.0, middle=0.0, turning=1.0):
    """Of one joint."""
    return [len(starts), turns, redundant, 1, lower, upper, middle, turning, *np.ravel(starts)]


def fixed(place, sine=0.0, cosine=1.0, outside=0.0):
    """A step that stays where it is, with these measures."""
    return lambda q, *_: (q, (place, sine, cosine, outside))


@pytest.fixture(scope="module")
def arms_own():
    """Step and settings of the LWR 4+, with 5 starts."""
    x = search_ranges(ARM, True, 5, 0)
    step = pose_step(ARM.chain, x)

    def body(q, T, repair, start):
        out = np.array(step(q, T, repair[None]))
        return out[:7], out[7:]

    given = [5, 1.0, 1.0, 7, *x.lower, *x.upper, *x.middle, *x.turning, *x.starts.ravel()]
    return body, given


@pytest.mark.parametrize("near", [False, True])
def test_poses_are_solved_one_after_the_other_as_alone(arms_own, near):
    q = random_positions(ARM, 6, seed=3)
    T, q0 = lwr_dyn.forward_kinematics(ARM, q), q + 0.05 if near else None
    rows = searched(*arms_own, T, q0)
    assert (rows[:, 7] == FOUND).all()
    assert_reached(ARM, rows[:, :7], T)
    assert (rows[:, 8:10] < 1e-18).all()
    assert (np.abs(rows[:, 10] - 1.0) < 1e-12).all()
    if near:
        assert (rows[:, 11] == 0.0).all()
        assert np.abs(rows[:, :7] - q).max() < 0.2
    for k in (0, 3):
        alone = searched(*arms_own, T[k], None if q0 is None else q0[k], W=4)
        assert np.abs(alone[0, :7] - rows[k, :7]).max() < 1e-12
        assert alone[0, 11] == rows[k, 11]


@pytest.mark.parametrize(("E", "steps"), [(2e-3, 15), (5e-4, 40), (2e-6, 40), (5e-7, 1000)])
@pytest.mark.parametrize("poses", [1, 2])
def test_a_start_gets_steps_by_its_error(E, steps, poses):
    rows = searched(fixed(2.0 * E), settings(), [EYE] * poses)
    assert rows.tolist() == [[0.0, NOT_REACHED, 2.0 * E, 0.0, 1.0, 0.0, steps]] * poses


def test_late_starts_are_given_up_sooner():
    """From the 41st on: 39 starts of 15 steps, one of 1000, then 2 of 40."""

    def body(q, T, repair, start):
        return q, (np.where(start < 39, 2.0, 1e-8), 0.0, 1.0, 0.0)

    rows = searched(body, settings(np.zeros((42, 1))), [EYE, EYE])
    assert rows[:, -1].tolist() == [39 * 15 + 1000 + 2 * 40] * 2
    assert rows[:, -2].tolist() == [41.0] * 2


@pytest.mark.parametrize(("T", "steps"), [([EYE], 16), ([EYE, EYE], 3 * 15 + 1)])
def test_all_lanes_of_one_pose_share_its_starts_and_the_first_that_is_solved_wins(T, steps):
    """Start 3 (of 6) is solved, and start 4; two lanes have the even and the odd ones."""

    def body(q, T, repair, start):
        return q, (np.where((q[0] == 3.0) | (q[0] == 4.0), 0.0, 1.0), 0.0, 1.0, 0.0)

    rows = searched(body, settings(np.arange(6.0)[:, None], 0.0, 9.0, turning=0.0), T)
    assert rows.tolist() == [[3.0, FOUND, 0.0, 0.0, 1.0, 3.0, steps]] * len(T)


@pytest.mark.parametrize(("solved", "start"), [(0.5, 0.0), (1.0, 1.0), (2.0, 2.0)])
def test_a_position_that_is_given_is_the_start_before_those_of_the_table(solved, start):
    def body(q, T, repair, start):
        return q, (np.where(q[0] == solved, 0.0, 1.0), 0.0, 1.0, 0.0)

    given = settings([[1.0], [2.0]], turning=0.0)
    given[0] = 3
    rows = searched(body, given, [EYE, EYE], q0=[[0.5], [0.5]])
    assert rows[:, [0, 1, 5]].tolist() == [[solved, FOUND, start]] * 2


@pytest.mark.parametrize("poses", [1, 2])
def test_the_nearest_miss_is_kept(poses):
    """Of starts that miss by 3, 1 and 2."""
    rows = searched(lambda q, *_: (q, (q[0], 0.0, 1.0, 0.0)), settings([[3.0], [1.0], [2.0]]), [EYE] * poses)
    assert rows[:, :5].tolist() == [[1.0, NOT_REACHED, 1.0, 0.0, 1.0]] * poses


@pytest.mark.parametrize(
    ("q", "options", "found"),
    [
        (7.0, {}, 7.0 - TURN), (3.0, {}, 3.0), (-3.0, {}, -3.0), (3.1, {}, None),
        (-3.2, {"lower": -4.0, "middle": 2.9}, -3.2), (3.2, {"upper": 4.0, "middle": -2.9}, 3.2),
        (7.0, {"upper": 8.0, "turns": 0.0}, 7.0), (7.0, {"upper": 8.0, "turning": 0.0}, 7.0),
        (7.0, {"turns": 0.0}, None), (7.0, {"turning": 0.0}, None),
    ],
)  # fmt: skip
def test_an_angle_is_moved_by_whole_turns_to_the_middle_and_into_the_limits(q, options, found):
    (row,) = searched(fixed(0.0), settings([[q]], **options), EYE)
    assert row[1] == (OUTSIDE if found is None else FOUND)
    assert row[0] == pytest.approx(q if found is None else found, abs=1e-15)


@pytest.mark.parametrize(("q0", "near"), [(7.0, 7.0), (8.0, 8.0 - TURN)])
def test_the_solution_is_near_to_a_position_that_is_given(q0, near):
    """One beyond the limits counts as at them."""
    (row,) = searched(fixed(0.0), settings(lower=-7.0, upper=7.5, middle=-6.0), EYE, [[q0]])
    assert row[0] == pytest.approx(near, abs=1e-15)


PULLED, HELD = [0.0] + [1.0] * 20, [0.0] + [2.0] * 20


@pytest.mark.parametrize(
    ("excess", "redundant", "starts", "log"),
    [
        (0.5, 1.0, 1, PULLED), (0.5, 0.0, 1, [0.0]), (0.5e-4, 0.0, 1, HELD), (0.5e-4, 1.0, 1, HELD),
        (0.5, 1.0, 7, PULLED * 7 + HELD[1:]),
    ],
)  # fmt: skip
def test_a_solution_outside_the_limits_is_pulled_then_held_at_them(excess, redundant, starts, log):
    """A step of 1 mm off in every repair; the row is that of the miss."""
    seen = []

    def body(q, T, repair, start):
        seen.append(repair.tolist())
        return q * 0.0 + 3.0 + excess, (np.where(repair > 0.0, 1e-6, 0.0), 0.0, 1.0, 0.0)

    table = np.full((starts, 1), 3.0 + excess)
    rows = searched(body, settings(table, redundant=redundant, turning=0.0), [EYE, EYE, 2.0 * EYE])
    assert seen == [[mode, mode] for mode in log]
    assert rows[:2, :2].tolist() == [[3.0 + excess, OUTSIDE]] * 2
    assert rows[2].tolist() == [0.0, INVALID, *[0.0] * 5]


def test_a_repair_that_holds_ends_at_the_limits():
    """Held joints begin at their limits and return to them after every step."""
    seen = []

    def body(q, T, repair, start):
        seen.append(q[0, 0])
        return q + 0.25, (np.where((repair == 2.0) & (len(seen) < 4), 1e-6, 0.0), 0.0, 1.0, 0.0)

    (row,) = searched(body, settings([[3.0 + 0.5e-4]], turning=0.0), EYE)
    assert seen == [3.0 + 0.5e-4, 3.0, 3.0, 3.0]
    assert row.tolist() == [3.0, FOUND, 0.0, 0.0, 1.0, 0.0, 4.0]


@pytest.mark.parametrize(
    ("measures", "code"),
    [
        ((0.99e-9**2, 0.99e-9**2, 1.0), FOUND), ((1e-18, 0.0, 1.0), NOT_REACHED), ((0.0, 1e-18, 1.0), NOT_REACHED),
        ((0.0, 0.0, -1.0), NOT_REACHED), ((np.nan, 0.0, 1.0), NOT_REACHED),
    ],
)  # fmt: skip
def test_what_counts_as_reached(measures, code):
    (row,) = searched(fixed(*measures), settings(), EYE)
    assert row[1] == code


@pytest.mark.parametrize(("outside", "code"), [(1.0, OUTSIDE), (0.0, FOUND)])
def test_a_pull_is_done_when_no_joint_is_outside(outside, code):
    q = iter([3.5] + [1.0] * 30)
    given = settings([[3.5]], redundant=1.0, turning=0.0)
    (row,) = searched(lambda *_: (next(q), (0.0, 0.0, 1.0, outside)), given, EYE)
    assert row[1] == code


SHEARED = EYE + 1.1e-6 * np.eye(4, k=1) * [[1], [1], [0], [0]]


def scaled(*diagonal):
    return np.diag([*diagonal, 1.0])


@pytest.mark.parametrize(
    ("T", "is_one"),
    [
        (EYE, True), (scaled(1, -1, -1), True), (scaled(-1, -1, -1), False), (scaled(1 + 0.4e-6, 1, 1), True),
        (scaled(1 + 0.6e-6, 1, 1), False), (scaled(1, 1, 1 - 0.6e-6), False), (SHEARED, False),
        (np.diag([1.0, 1.0, 1.0, 2.0]), False), (EYE[[1, 2, 0, 3]], True), (EYE[[1, 0, 2, 3]], False),
        *((EYE + np.eye(4)[3][:, None] * np.eye(4)[k] * 1e-9, False) for k in range(3)),
    ],
)  # fmt: skip
def test_what_is_a_pose(T, is_one):
    padded = np.concatenate([[5.0], T.ravel()])
    assert driver()["is_pose"](padded, 1) == is_one
    for k in range(3):
        moved = padded.copy()
        moved[1 + 4 * k + 3] = 0.9e300
        assert driver()["is_pose"](moved, 1) == is_one
        moved[1 + 4 * k + 3] = 1.1e300
        assert not driver()["is_pose"](moved, 1)


def test_positions_are_numbers_below_1e5():
    q = np.array([1e9, 99999.0, -99999.0, np.nan])
    assert [driver(n)["is_finite"](q, at) for at, n in ((1, 2), (0, 2), (2, 2), (1, 1))] == [True, False, False, True]
    (row,) = searched(fixed(0.0), settings(), EYE, [[1e5]])
    assert row.tolist() == [0.0, INVALID, *[0.0] * 5]


def test_a_rotation_is_made_exact_and_the_place_is_kept():
    """A Newton step of the polar decomposition leaves the square of what was off."""
    R = lwr_dyn.forward_kinematics(ARM, np.full((1, 7), 0.4))[0]
    T, taken = R.copy(), []
    T[:3, :3] += 1e-7 * np.arange(9.0).reshape(3, 3) / 9.0

    def body(q, given, repair, start):
        taken.append(given[:, 0].reshape(3, 4))
        return q, (0.0, 0.0, 1.0, 0.0)

    searched(body, settings(), T)
    found = taken[0]
    assert (found[:, 3] == T[:3, 3]).all()
    assert np.abs(found[:, :3].T @ found[:, :3] - np.eye(3)).max() < 1e-13
    u, _, v = np.linalg.svd(T[:3, :3])
    assert np.abs(found[:, :3] - u @ v).max() < 1e-13
