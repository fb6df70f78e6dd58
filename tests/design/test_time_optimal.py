"""The least time along a path: closed forms, limits kept between points too, nothing left unused, a path unchanged."""

import sys
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.design import time_optimal
from lwr_dyn.design.path_pieces import CurveReference, joined, path_of_reference
from lwr_dyn.design.time_optimal import least_time
from lwr_dyn.design.time_optimal_speeds import JointBounds
from lwr_dyn.foundation import errors
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.model.arm import arm_with_payload
from lwr_dyn.simulation.metrics import metrics
from lwr_dyn.trajectory.motion_profile import constant_speed, quintic
from tests.simulation.sample_runs import one_joint

ARM = lwr_dyn.load("lwr4plus", "computed")
START = [0.0, 0.5, 0.0, -1.2, 0.0, 0.6, 0.0]


@pytest.fixture(scope="module")
def ist():
    return lwr_dyn.reference("ist", ARM, timing="smooth-blended")


@pytest.fixture(scope="module")
def quick(ist):
    return least_time(ARM, ist, speed_share=1.0)


def uses(reference, t, effort=ARM.effort):
    """The largest shares of torque and speed at times t, by the other engine."""
    motion = reference.sample(t)
    tau = lwr_dyn.dynamics_of(ARM, "newton-euler").inverse_dynamics(motion.q, motion.dq, motion.ddq)
    return np.abs(tau / effort).max(), np.abs(motion.dq / ARM.velocity).max()


HALF_METRE = CurveReference(
    lambda s: (0.5 * s[:, None], np.full((s.size, 1), 0.5), np.zeros((s.size, 1))), constant_speed(1.0, 1.0)
)


@pytest.mark.parametrize(
    ("options", "a", "v"),
    [
        ({}, 4.5, 0.95), ({"rate": None}, 4.5, 0.95), ({"speed_share": 0.5}, 4.5, 0.5), ({"intervals": 40}, 4.5, 0.95),
        ({"effort_share": 0.5, "rate": 500.0}, 2.5, 0.95), ({"acceleration": 1.5}, 1.5, np.inf),
    ],
)  # fmt: skip
def test_a_slider_takes_the_time_of_the_closed_form_and_says_what_rules(options, a, v):
    """2 kg, 10 N, 1 m/s over d = 0.5 m: at most a, d / v + v / a; where v is not reached, 2 sqrt(d / a)."""
    quick = least_time(one_joint(effort=10.0, velocity=1.0), HALF_METRE, **options)
    rising = v / a if np.isfinite(v) else np.sqrt(0.5 / a)
    least = 0.5 / v + rising if np.isfinite(v) else 2.0 * rising
    assert least - 1e-9 < quick.duration == pytest.approx(least, rel=3e-3)
    about, rules = quick.about["timing"], np.array([0.0, 1.0 - 2.0 * rising / least, 2.0 * rising / least])
    torque = min(a / 5.0 / options.get("effort_share", 0.9), 1.0)
    if "acceleration" not in options:
        torque, rules = 1.0, rules[[2, 1, 0]]
    assert [*about["ruled_by"]] == [*about["use"]] == ["torque", "speed", "acceleration"]
    assert [*about["ruled_by"].values()] == pytest.approx(rules, abs=0.03)
    speed = (v if np.isfinite(v) else a * rising) / options.get("speed_share", 0.95)
    uses = [torque, min(speed, 1.0), float("acceleration" in options)]
    assert [*about["use"].values()] == pytest.approx(uses, abs=0.01)
    assert (max(about["use"].values()) <= 1.0, about["duration"], about["pieces"]) == (True, quick.duration, 1)
    kept = {key: about[key] for key in ("effort_share", "speed_share", "acceleration")}
    assert kept == {"effort_share": 0.9, "speed_share": 0.95, "acceleration": None} | {
        key: value for key, value in options.items() if key in kept
    }
    rate, profile = options.get("rate", 1000.0), quick.profile
    if rate is not None:
        np.testing.assert_allclose(np.diff(profile.knots), 1.0 / rate, rtol=1e-9)
    assert (profile.length, quick.sample(quick.duration).q[0, 0]) == (pytest.approx(1.0), pytest.approx(0.5))


@pytest.mark.slow
def test_ist_takes_the_least_time_of_the_lwr_and_passes_no_limit_between_points_either(ist, quick):
    assert quick.duration == pytest.approx(1.870, abs=0.002)
    about = quick.about["timing"]
    assert (about["ruled_by"]["speed"] > 0.9, about["pieces"], "smoothness" in quick.about) == (True, 2, False)
    torque, speed = uses(quick, np.random.default_rng(1).uniform(0.0, quick.duration, 4000))
    assert 0.8 < torque <= 0.9 * (1.0 + 1e-6)
    assert 0.99 < speed <= 1.0 + 1e-6
    # faster than any uniform scaling
    dq = ist.sample(np.linspace(0.0, ist.duration, 3000)).dq
    assert quick.duration < 0.95 * ist.duration * np.abs(dq / ARM.velocity).max()


def test_at_every_moment_some_limit_rules(ist):
    """What has room everywhere could be faster."""
    free = least_time(ARM, ist, rate=None, intervals=300)
    assert free.about["timing"]["ruled_by_none"] < 0.02


@pytest.mark.slow
def test_the_path_is_not_changed_derivatives_are_exact_and_nothing_jumps(ist, quick):
    t = np.linspace(0.0, quick.duration, 500)
    tip = flange_pose(ARM.chain, quick.sample(t).q)[:, :3, 3]
    profile = quick.poses.profile
    assert np.abs(tip - ist.poses.path.at(profile.at(t).s).p).max() < 1e-9
    ends = quick.sample(np.array([0.0, quick.duration]))
    assert ends.q == pytest.approx(ist.sample(np.array([0.0, ist.duration])).q, abs=1e-12)
    assert np.abs(ends.dq).max() < 1e-9
    t, h = 0.5 * (profile.knots[:-1] + profile.knots[1:])[::7], 1e-6
    ahead, behind, motion = quick.sample(t + h), quick.sample(t - h), quick.sample(t)
    assert (ahead.q - behind.q) / (2.0 * h) == pytest.approx(motion.dq, abs=1e-7)
    assert (ahead.dq - behind.dq) / (2.0 * h) == pytest.approx(motion.ddq, abs=1e-3)
    c, step = profile.coefficients, np.diff(profile.knots)
    at_ends = c[:, 0] + step * (c[:, 1] + step * c[:, 2]), c[:, 1] + 2.0 * step * c[:, 2]
    for at_end, begin in zip(at_ends, (c[:, 0], c[:, 1]), strict=True):
        assert at_end[:-1] == pytest.approx(begin[1:], abs=1e-12)


def test_back_along_the_path_takes_as_long():
    """C(q, dq) dq is even in dq, so the torques of the way back are those of the way, in reverse order."""
    to = np.array([0.4, -0.3, 0.5, 0.6, 0.2, -0.4, 0.3])

    def curve(s):
        bend = np.sin(2.0 * s)[:, None]
        q = np.array(START) + np.outer(s, to) + 0.2 * bend
        return q, to + 0.4 * np.cos(2.0 * s)[:, None] * np.ones(7), -0.8 * bend * np.ones(7)

    def back(s):
        q, first, second = curve(1.0 - s)
        return q, -first, second

    there, again = (
        least_time(ARM, CurveReference(f, constant_speed(1.0, 1.0)), rate=None, intervals=400) for f in (curve, back)
    )
    assert there.duration == pytest.approx(again.duration, rel=1e-4)
    assert there.sample(np.array([there.duration])).q == pytest.approx(again.sample(np.array([0.0])).q, abs=1e-9)


@pytest.mark.parametrize(
    ("torque", "words"),
    [(0.75, "no timing was found"), (1.5, "joint_1 needs 1.5 times the torque that it may use, only to stand still")],
)
def test_a_joint_is_blamed_where_its_motor_does_not_hold_it(torque, words):
    bounds = JointBounds(np.array([1.0]), np.array([np.inf]), np.array([np.inf]))
    rows = SimpleNamespace(c=np.array([[0.2], [torque]]))
    assert time_optimal._why_not(one_joint(), rows, bounds, np.array([0.0, 1.0])).startswith(words)


@pytest.mark.slow
def test_less_of_the_limits_and_the_weight_of_a_payload_take_time(ist):
    shares = ((1.0, 1.0), (0.7, 1.0), (0.7, 0.5))
    times = [least_time(ARM, ist, effort_share=e, speed_share=v, intervals=100).duration for e, v in shares]
    assert times == sorted(times)
    assert times[2] > times[0] + 1.0
    heavy = arm_with_payload(ARM, 7.0)
    loaded = least_time(heavy, lwr_dyn.reference("ist", heavy, timing="smooth-blended"), intervals=300)
    assert loaded.duration > least_time(ARM, ist, intervals=300).duration


@pytest.mark.slow
def test_the_simulated_arm_keeps_what_the_timing_left_it(ist):
    """IST as printed, with stops at its corners: 90 % of the torque, 95 % of the speed."""
    reference = least_time(ARM, lwr_dyn.reference("ist", ARM))
    run = lwr_dyn.simulate(ARM, lwr_dyn.controller("inverse-dynamics", ARM), reference)
    figures = metrics(run, ARM)
    assert figures.within_limits
    assert not (np.abs(run.tau_command) > ARM.effort).any()
    assert figures.tip_max_mm < 0.15
    assert reference.about["timing"]["pieces"] == 4


@pytest.mark.slow
def test_legs_and_their_stops():
    line = lwr_dyn.reference("line", ARM, start=START, to_xyz=[-0.3, 0.2, 0.5])
    quick = least_time(ARM, line, intervals=300)
    assert quick.duration < line.duration
    torque, speed = uses(quick, np.linspace(0.0, quick.duration, 1500))
    assert torque <= 0.9 * (1.0 + 1e-6)
    assert speed <= 0.95 * (1.0 + 1e-6)
    assert type(quick) is type(line)


def test_friction_of_the_arm_is_part_of_the_torque():
    arm = lwr_dyn.load("wam7")
    assert any(arm.friction_models())
    start, end = np.array([0.0, -1.0, 0, 1.6, 0, 0, 0]), np.array([1.5, -1.0, 0.5, 1.0, 0, 0.4, 0])
    slow = lwr_dyn.reference("point-to-point", arm, start=start, end=end, duration=5.0)
    quick = least_time(arm, slow)
    motion = quick.sample(np.linspace(0.0, quick.duration, 1000)[1:-1])
    tau = lwr_dyn.dynamics_of(arm).inverse_dynamics(motion.q, motion.dq, motion.ddq)
    models = zip(arm.friction_models(), motion.dq.T, strict=True)
    tau += np.column_stack([model.torque(dq) if model else 0.0 * dq for model, dq in models])
    assert (np.abs(tau) <= 0.9 * arm.effort * (1.0 + 1e-6)).all()


MOVE = {"start": [0.0] * 7, "end": [0.5] * 7}
BAD = [
    (dict(effort_share=0.0), errors.OptionError, "effort_share: 0.0; allowed: a share above 0, at most 1"),
    (dict(speed_share=1.2), errors.OptionError, "speed_share"),
    (dict(acceleration=-1.0), errors.OptionError, "acceleration: -1.0; allowed: a number above 0"),
    (dict(acceleration=[1.0, 2.0]), errors.ShapeError, "acceleration: shape (2,)"),
    (dict(intervals=3), errors.OptionError, "intervals: 3"),
    (dict(rate=-1.0), errors.OptionError, "rate"),
    (dict(effort_share=0.05), errors.OptionError, "joint_2 needs"),
    # of the task
    (dict(along="least-time"), errors.OptionError, "along: 'least-time'; allowed: another task"),
    (dict(along="lists"), errors.UnknownNameError, "no reference named 'lists'"),
    (dict(along="hold", start=[0.0] * 7), errors.LwrDynError, "start"),
    (dict(along="line", shift=[0.0] * 3), errors.OptionError, "shift: no option of reference line"),
    (dict(along="line"), errors.OptionError, "start: not given"),
]


@pytest.mark.parametrize(("options", "error", "words"), BAD)
def test_bad_options_are_one_line(ist, options, error, words):
    made = partial(lwr_dyn.reference, "least-time", ARM) if "along" in options else partial(least_time, ARM, ist)
    with pytest.raises(error) as caught:
        made(**options)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_has_no_path_or_no_limits_is_refused():
    with pytest.raises(errors.OptionError, match="only stands still"):
        least_time(ARM, lwr_dyn.reference("hold", ARM, q=START))
    with pytest.raises(errors.OptionError, match="not known apart from its timing"):
        path_of_reference(type("Other", (), {"duration": 1.0, "sample": None})())
    unlimited = lwr_dyn.load("kr30ha")
    slow = lwr_dyn.reference("point-to-point", unlimited, start=[0.0] * 6, end=[0.1] * 6)
    with pytest.raises(errors.MissingDataError, match="limit of torque"):
        least_time(unlimited, slow)


def test_without_toppra_the_extra_is_named(ist, monkeypatch):
    monkeypatch.setitem(sys.modules, "toppra.algorithm", None)
    with pytest.raises(errors.MissingPackageError, match=r"pip install 'lwr_dyn\[design\]'"):
        least_time(ARM, ist)


def test_it_follows_the_path_of_another_task():
    quick = lwr_dyn.reference("least-time", ARM, along="point-to-point", acceleration=2.0, **MOVE)
    assert quick.duration == pytest.approx(1.0, abs=2e-3)
    assert quick.sample(np.array([quick.duration])).q[0] == pytest.approx(MOVE["end"])


@pytest.mark.slow
def test_its_name_says_whose_path_it_is():
    quick = lwr_dyn.reference("least-time", ARM, along="line", start=START, to_xyz=[-0.3, 0.2, 0.5])
    assert quick.about["task"] == "line in the least time"
    assert quick.about["timing"]["effort_share"] == 0.9


def test_each_piece_begins_at_its_cut_to_the_last_bit():
    """0.1 + 0.2 is not 0.3: a start before the corner would take the direction before it."""
    whole = joined([quintic(0.1, 1.0), quintic(0.2, 1.0), quintic(0.3, 1.0)], np.array([0.0, 0.1, 0.3, 0.6]))
    assert whole.at(np.array([1.0, 2.0])).s.tolist() == [0.1, 0.3]
    assert whole.length == 0.6


def test_ist_is_cut_at_its_corners_and_bends_are_known():
    path = path_of_reference(lwr_dyn.reference("ist", ARM))
    assert [round(piece.length, 3) for piece in path.pieces] == [0.3, 0.721, 0.05, 0.3]
    assert [piece.breaks.size for piece in path.pieces] == [0, 6, 0, 0]
    assert path.pieces[1].breaks[:2] == pytest.approx([0.095, 0.105], abs=1e-4)  # 5 mm before and after the first arc


@pytest.mark.parametrize("task", ["ist", "line"])
def test_a_piece_is_the_path_with_its_derivatives(task):
    options = {} if task == "ist" else {"start": START, "to_xyz": [-0.3, 0.2, 0.5]}
    reference = lwr_dyn.reference(task, ARM, **options)
    piece = path_of_reference(reference).pieces[0]
    s, h = np.linspace(0.1, 0.9, 9) * piece.length, 1e-6 * piece.length
    (q, first, second), ahead, behind = (piece.curve(x) for x in (s, s + h, s - h))
    assert (ahead[0] - behind[0]) / (2.0 * h) == pytest.approx(first, abs=1e-6)
    assert (ahead[1] - behind[1]) / (2.0 * h) == pytest.approx(second, abs=1e-4)
    assert q.shape == (9, 7)
