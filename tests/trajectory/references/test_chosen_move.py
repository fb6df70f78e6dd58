"""The task `move`: torques by another engine keep the limits, other poses for weak arms, a cause for each refusal."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.friction import symmetric
from lwr_dyn.trajectory.references.chosen_move import MOST_WEIGHT, SPEED, TORQUE, chosen_move, limit_use, ranges
from tests.simulation.sample_runs import one_joint

PAPERS = ("lwr4plus", "wam7", "kr30ha")


def with_limits(arm, **changed):
    """The arm with some limits of all joints changed: a value, or one a joint."""
    rows = {name: np.broadcast_to(np.asarray(value, dtype=object), arm.n) for name, value in changed.items()}
    new = (replace(one, **{k: v[i] for k, v in rows.items()}) for i, one in enumerate(arm.limits))
    return replace(arm, limits=tuple(new))


def torques(arm, move, count=300):
    motion = move.sample(np.linspace(0.0, move.duration, count))
    other = lwr_dyn.dynamics_of(arm, engine="newton-euler")
    return np.array([other.inverse_dynamics(*row) for row in zip(motion.q, motion.dq, motion.ddq, strict=True)])


@pytest.mark.parametrize("name", PAPERS)
def test_the_move_keeps_the_limits_by_another_engine_and_is_the_same_again(name):
    arm = lwr_dyn.load(name)
    move = chosen_move(arm)
    motion = move.sample(np.linspace(0.0, move.duration, 300))
    low, up = ranges(arm)
    assert (np.minimum(motion.q - low, up - motion.q) > 0.09 * (up - low)).all()
    assert (np.abs(motion.dq) <= (SPEED + 1e-9) * arm.velocity).all()
    assert (np.abs(torques(arm, move)) <= TORQUE * arm.effort).all()
    assert np.ptp(motion.q, axis=0).min() > 0.05
    np.testing.assert_array_equal(move.waypoints, chosen_move(arm).waypoints)
    use = limit_use(arm, move, lwr_dyn.dynamics_of(arm))
    assert move.about["use"] == {"speed": use.speed, "torque": use.torque}
    assert (use.torque is None, use.fits) == (name == "kr30ha", True)  # of which none is known


def test_slow_joints_take_longer_but_not_for_ever_and_a_duration_of_ones_own_is_kept_or_refused(arm):
    move = chosen_move(with_limits(arm, velocity=0.02))
    assert 2.0 < move.duration <= 8.1
    assert np.abs(move.sample(np.linspace(0.0, move.duration, 500)).dq).max() <= SPEED * 0.02 * (1 + 1e-9)
    assert chosen_move(arm, duration=11.0).duration == 11.0
    with pytest.raises(OptionError, match="duration"):
        chosen_move(arm, duration=-1.0)


def test_an_arm_too_weak_for_the_middle_pose_moves_where_it_is_held():
    arm = lwr_dyn.load("kr30ha")
    strong = chosen_move(arm)
    weight = np.abs(lwr_dyn.dynamics_of(arm).gravity_vector(strong.waypoints)).max(axis=0)
    weak = with_limits(arm, effort=[1e5, float(weight[1] / 1.2), 1e5, 1e5, 1e5, 1e5])
    move = chosen_move(weak)
    assert not np.array_equal(move.waypoints, strong.waypoints)
    assert (np.abs(torques(weak, move)) <= 0.95 * weak.effort).all()


def test_limits_without_room_and_an_arm_that_its_torques_do_not_hold_are_refused_with_the_joint(arm):
    weak = with_limits(arm, effort=[320.0, 0.5, 176.0, 176.0, 100.0, 40.0, 40.0])
    with pytest.raises(OptionError, match=r"weight and friction take \d+ % of the torque limit of joint_2") as fault:
        chosen_move(weak)
    assert float(str(fault.value).split("take ")[1].split(" %")[0]) > 100 * MOST_WEIGHT
    narrow = with_limits(arm, lower=[-1.0, -1.0, 0.5, *[-1.0] * 4], upper=[1.0, 1.0, 0.5, *[1.0] * 4])
    with pytest.raises(OptionError, match="position limits of joint_3 leave no room; allowed"):
        chosen_move(narrow)


@pytest.mark.parametrize(
    ("lower", "upper", "low", "up"),
    [(None, None, -np.pi, np.pi), (-4.0, 6.0, 1 - np.pi, 1 + np.pi), (1.0, None, 1.0, 1 + 2 * np.pi),
     (None, 1.0, 1 - 2 * np.pi, 1.0)],
)  # fmt: skip
def test_unknown_limits_are_a_turn_about_zero_and_a_wide_range_is_cut_to_one(arm, lower, upper, low, up):
    found = ranges(with_limits(arm, lower=lower, upper=upper))
    np.testing.assert_allclose(found, [np.full(7, low), np.full(7, up)])


PEAK, TURN_OF_TORQUE = 15 / 8, 10 / 3**0.5
"""Largest speed and acceleration of a quintic over way 1 in time 1."""
SLIDE, TURNS = JointKind.PRISMATIC, JointKind.REVOLUTE
NUMBERS = [  # kind, limits, waypoints, duration to 0.1 s, largest share of the speed
    (SLIDE, {}, [-0.075, 0.075], 2.0, None),  # 15 % of half a metre
    (SLIDE, {"lower": 1.0, "upper": 3.0}, [1.9, 2.1], 2.0, None),  # at most 0.1 m to each side
    (SLIDE, {"upper": 1.0}, [0.675, 0.825], 2.0, None),
    (SLIDE, {"lower": 0.0, "upper": 0.2, "velocity": 0.04}, [0.1 - 0.0256, 0.1 + 0.0256], 8.0, 0.3),
    (TURNS, {}, [-0.35, 0.35], 2.0, None),
    (TURNS, {"lower": 0.0, "upper": 2e-6}, [0.7e-6, 1.3e-6], 2.0, None),
    (TURNS, {"velocity": 1.0}, [-0.35, 0.35], 4.4, 0.7 * PEAK / 4.4),
    (TURNS, {"velocity": 0.1}, [-0.064, 0.064], 8.0, 0.3),
    (TURNS, {"velocity": 40.0}, [-0.35, 0.35], 2.0, 0.7 * PEAK / 80.0),
]


@pytest.mark.parametrize(("kind", "limits", "ends", "duration", "speed"), NUMBERS)
def test_ends_and_duration_follow_from_the_limits(kind, limits, ends, duration, speed):
    arm = one_joint(kind, **limits)
    move = chosen_move(replace(arm, chain=replace(arm.chain, links=(replace(arm.chain.links[0], body=None),))))
    np.testing.assert_allclose(move.waypoints[:, 0], ends, atol=1e-12)
    assert move.duration == pytest.approx(duration, abs=1e-12)
    about = {"value": move.duration, "kind": "chosen"}
    assert move.about == {
        "task": "move", "duration": about, "start": [move.waypoints[0, 0]], "end": [move.waypoints[1, 0]],
        "use": {"speed": None if speed is None else pytest.approx(speed, rel=1e-6), "torque": None},
    }  # fmt: skip


@pytest.mark.parametrize(("share", "duration"), [(0.598, 2.0), (0.602, 2.9), (1.198, 2.9), (1.202, 4.0)])
def test_torque_makes_it_longer_by_the_root_of_two_until_six_tenths_are_enough(share, duration):
    inertia = 2.0 * (0.5**2 + 0.01)
    effort = inertia * 0.7 * TURN_OF_TORQUE / 2.0**2 / share
    move = chosen_move(one_joint(TURNS, lever=0.5, effort=effort))
    assert move.duration == pytest.approx(duration)
    assert move.about["use"]["torque"] == pytest.approx(share * (2.0 / duration) ** 2, rel=2e-3)


def test_the_first_pose_whose_weight_takes_half_of_the_torque_is_taken_and_the_best_of_heavier_ones():
    """A pendulum that hangs at q = 0: its weight takes m g l |sin q|, and friction a little; 85 % are refused."""
    hanging = one_joint(TURNS, lever=0.5, gravity=(9.81, 0.0, 0.0), lower=0.0, upper=1.0, effort=1.0)
    weight = 9.81 * np.sin(0.5 + 0.15)  # at the middle and 15 % of the range beyond
    drawn = np.random.default_rng(0).uniform(0.3, 0.7, 200)
    for effort, middle in (
        (weight / 0.499, 0.5), (weight / 0.501, drawn[np.sin(drawn + 0.15) * 0.501 / np.sin(0.65) <= 0.5][0]),
        (9.81 * np.sin(drawn.min() + 0.15) / 0.849, drawn.min()),
    ):  # fmt: skip
        move = chosen_move(with_limits(hanging, effort=effort))
        assert move.waypoints.mean() == pytest.approx(middle, abs=1e-12)
    effort = 9.81 * np.sin(drawn.min() + 0.15) / 0.851
    with pytest.raises(
        OptionError, match="one: weight and friction take 85 % of the torque limit of joint_1 at the best"
    ):
        chosen_move(with_limits(hanging, effort=effort))
    with pytest.raises(OptionError, match="at the best of 201 poses"):
        chosen_move(replace(with_limits(hanging, effort=100.0), friction=(symmetric(90.0, 0.0),)))
