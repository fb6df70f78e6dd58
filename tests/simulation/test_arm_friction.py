"""The friction of a run: its forms, its record, and options that are refused."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.friction import Direction, JointFriction, Sigmoid, symmetric
from lwr_dyn.simulation.arm_friction import ArmFriction, boxed_lcp, braking_rate, chosen_friction
from lwr_dyn.simulation.contact import ACTIVE_FRICTION
from lwr_dyn.simulation.flow import FastStep
from lwr_dyn.simulation.simulate import no_torque, simulate
from tests.simulation.sample_runs import Still, controllers, joint_waves, lwr, one_joint, with_limits

SMOOTH = 2e-4
"""[m] A slider that brakes from 0.2 m/s over 7 mm against tanh friction at 1e-3 m/s stops later by less."""


def slowed(arm=None, torque=no_torque, duration=0.3, speed=0.2, **options):
    """A run of a slider that begins with a speed."""
    return simulate(arm or one_joint(), torque, Still(np.zeros(1), duration), dq0=[speed], **options)


def one(*joints, **options):
    return slowed(friction=list(joints), **options)


def rough(*models):
    return replace(one_joint(), friction=models)


def test_the_arms_own_friction_is_the_default_with_true_stick():
    run = slowed(rough(symmetric(3.0, 0.5)))
    law = run.meta["friction_law"]
    assert (law["form"], law["highest"]) == ("set-valued", [3.0])
    assert "stays at rest if its static level holds it" in law["rule"]
    for each in (run, slowed(one_joint(coulomb=3.0))):  # as a URDF gives it
        assert [event.kind for event in each.events] == ["stick"]
        assert each.dq[-1, 0] == 0.0


@pytest.mark.parametrize("options", [{"arm": rough(symmetric(3.0, 0.5)), "friction": "none"}, {}])
def test_none_and_arms_without_friction(options):
    run = slowed(**options)
    assert (run.meta["friction"], run.meta["friction_law"]["form"]) == (False, "none")
    assert run.q[-1, 0] == pytest.approx(0.06, abs=1e-12)
    assert (run.tau_friction == 0.0).all()
    assert slowed(substeps=3, **options).meta["evaluations"] == 4 * 3 * 300
    assert 0 < one(symmetric(1e3, 0.0)).meta["evaluations"] < 4 * 300


def test_smooth_friction_comes_near_but_creeps():
    exact, smooth = (
        slowed(rough(symmetric(3.0, 0.0)), lambda *_: np.array([1.5]), 0.5, friction=form, substeps=4)
        for form in ("set-valued", "smooth")
    )
    assert smooth.q[-1, 0] == pytest.approx(exact.q[-1, 0], abs=5 * SMOOTH)
    assert exact.dq[-1, 0] == 0.0
    assert smooth.dq[-1, 0] == pytest.approx(1e-3 * np.arctanh(0.5), rel=0.02)


def test_a_step_too_long_for_stiff_friction_is_refused_with_what_it_takes():
    stiff = rough(symmetric(30.0, 0.0))
    with pytest.raises(OptionError, match="substeps from 6 on, method dop853, or friction set-valued"):
        slowed(stiff, friction="smooth")
    with pytest.raises(OptionError, match="too fast for RK4 steps"):
        one(symmetric(1.0, 6000.0))
    slowed(stiff, duration=0.01, friction="smooth", substeps=6)
    one(symmetric(1.0, 6000.0), method="dop853")


@pytest.mark.parametrize(
    ("friction", "error", "words"),
    [("sticky", OptionError, "friction: 'sticky'; allowed: set-valued, smooth, none"),
     ([None, None], ShapeError, "2 joints; allowed: 1"),
     ([replace(symmetric(3.0, 0.5), load=0.2)], OptionError,
      r"friction of joint 1: 0\.2 of the load; allowed: none of the load")],
)  # fmt: skip
def test_bad_options(friction, error, words):
    with pytest.raises(error, match=words):
        slowed(friction=friction)


def test_viscous_friction_alone_needs_no_events():
    friction = chosen_friction(with_limits(lwr(), viscous=0.5))
    np.testing.assert_array_equal(friction.smooth(np.arange(7.0)), 0.5 * np.arange(7))
    asymmetric = chosen_friction(one_joint(), [JointFriction(Direction(0.0, 1.0), Direction(0.0, 2.0))])
    constant = chosen_friction(one_joint(), [JointFriction(Direction(0.0, 1.0), Direction(0.0, 1.0), offset=0.3)])
    found = [(x.form, x.directional.tolist()) for x in (friction, asymmetric, constant)]
    assert found == [("viscous", [False] * 7), ("set-valued", [True]), ("set-valued", [False])]


def test_each_direction_has_its_numbers_and_what_holds_at_rest_may_fall_with_the_speed_or_at_once():
    model = JointFriction(Direction(2.0, 0.3, 3.5, 0.2), Direction(1.0, -0.4, 1.5), offset=0.25)
    friction, smooth = ArmFriction.of([model, None]), chosen_friction(rough(model), "smooth")
    wanted = {
        "coulomb": [[2.0, 0.0], [1.0, 0.0]], "viscous": [[0.3, 0.0], [-0.4, 0.0]], "slope": [0.3, 0.0],
        "stribeck_drop": [[1.5, 0.0], [0.0, 0.0]], "sharpness": [[25.0, 0.0], [0.0, 0.0]], "offset": [0.25, 0.0],
        "lowest": [-1.25, 0.0], "highest": [3.75, 0.0], "lowest_slip": [-0.75, 0.0], "highest_slip": [3.75, 0.0],
    }  # fmt: skip
    for name, value in wanted.items():
        np.testing.assert_allclose(getattr(friction, name), value, rtol=1e-12, err_msg=name)
    rest = np.zeros(2, dtype=bool)
    for side in (1, -1):
        speeds = side * np.array([0.1, 0.3])
        np.testing.assert_allclose(friction.torque(np.full(2, side), rest)(speeds), [model.torque(speeds[0]), 0.0])
        assert friction.torque(np.full(2, side), ~rest)(speeds).tolist() == [0.0, 0.0]
    record = friction.record()
    assert record == {name: record[name] for name in ("form", "rule", "coulomb", "viscous", "lowest", "highest")}
    assert (record["form"], record["highest"]) == ("set-valued", [3.75, 0.0])
    assert smooth.record() == {"form": "smooth", "smooth_speed": 1e-3}
    assert smooth.slope == pytest.approx([0.3 + 3.5 / 1e-3])
    steep = np.diff(smooth.smooth(np.array([[0.0], [1e-9]])), axis=0).ravel() / 1e-9
    assert steep == pytest.approx(smooth.slope, rel=1e-5)


def test_friction_that_drives_is_an_event_once_a_side_and_never_clamped():
    model = JointFriction(Direction(1.0, -2.0), Direction(1.0, 0.5))
    run, slow = (slowed(duration=0.4, speed=speed, friction=[model]) for speed in (0.8, 0.4))
    assert [(e.kind, e.joint, e.t, e.value) for e in run.events] == [(ACTIVE_FRICTION, 0, 0.0, pytest.approx(0.8))]
    np.testing.assert_allclose(run.dq[:, 0], 0.5 + 0.3 * np.exp(run.t), rtol=0, atol=1e-12)
    assert run.work["friction"][-1] == pytest.approx(run.dq[-1, 0] ** 2 - 0.8**2, rel=1e-9)
    assert ACTIVE_FRICTION not in [event.kind for event in slow.events]


def test_the_seven_joints_of_the_wam_have_their_table():
    arm = lwr_dyn.load("wam7")
    friction = chosen_friction(arm)
    assert friction.form == "set-valued"
    for dq in (0.1, -0.1):
        torque = friction.torque(np.full(7, int(np.sign(dq))), np.zeros(7, dtype=bool))
        want = [float(model.torque(dq)) for model in arm.friction_models()]
        np.testing.assert_allclose(torque(np.full(7, dq)), want, rtol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("external", [None, lambda t, q, dq: np.array([8.0, -6, 4, 5, 1, -0.5, 0.1]) * np.sin(9.0 * t)])
@pytest.mark.parametrize("levels", [None, (9.0, 9.0, 4.0, 4.0, 0.3, 0.3, 0.1)])
def test_the_fast_path_and_the_flow_give_the_same_run(monkeypatch, external, levels):
    """A fast step that is refused every time gives the same run, to rounding, events included."""
    wave, law = joint_waves(1.0), controllers()["pd-gravity"]
    options = {"external": external, "friction": "none" if levels is None else [symmetric(f, 0.1) for f in levels]}
    fast = simulate(lwr(), law, replace(wave, w=4 * wave.w), **options)
    monkeypatch.setattr(FastStep, "take", lambda *_: False)
    slow = simulate(lwr(), law, replace(wave, w=4 * wave.w), **options)
    assert [(e.kind, e.joint) for e in fast.events] == [(e.kind, e.joint) for e in slow.events]
    assert levels is None or len(fast.events) >= 4
    for name, close in (("q", 1e-12), ("tau_friction", 1e-8)):
        np.testing.assert_allclose(getattr(fast, name), getattr(slow, name), rtol=0, atol=close)
    for name, work in fast.work.items():
        np.testing.assert_allclose(work, slow.work[name], rtol=0, atol=1e-10, err_msg=name)


CLOSE = 1e-8
"""Relative, on random matrices with condition numbers up to 1e4."""


def problem(seed, size):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(size, size))
    lo, hi = -rng.uniform(0, 1.5, size), rng.uniform(0, 1.5, size)
    hi[rng.random(size) < 0.2] = np.inf
    return root @ root.T + 0.1 * np.eye(size), rng.normal(size=size) * 2, lo, hi


def every_solution(M, b, lo, hi):
    """Solutions found by trying every joint at every side."""
    solutions = []
    for sides in itertools.product((-1, 0, 1), repeat=b.size):
        s = np.array(sides)
        if not np.isfinite(hi[s > 0]).all():
            continue
        f = np.where(s > 0, hi, lo)
        at = s == 0
        f[at] = np.linalg.solve(M[np.ix_(at, at)], b[at] - M[np.ix_(at, ~at)] @ f[~at])
        if (f >= lo).all() and (f <= hi).all() and (s * (b - M @ f) >= 0).all():
            solutions.append((f, s))
    return solutions


@given(st.integers(0, 10**6), st.integers(1, 4))
def test_it_is_the_one_solution(seed, size):
    M, b, lo, hi = problem(seed, size)
    (f, sides), *others = every_solution(M, b, lo, hi)
    assert not others
    got = boxed_lcp(M, b, lo, hi)
    np.testing.assert_allclose(got.force, f, rtol=CLOSE, atol=CLOSE)
    np.testing.assert_array_equal(got.sides, sides)


@given(st.integers(0, 10**6), st.integers(1, 7), st.booleans())
def test_friction_of_seven_joints_and_stops_which_have_one_bound(seed, size, stops):
    """Stops of a lower limit: they push, -f >= 0, or the joint leaves, w >= 0, never both."""
    M, b, lo, hi = problem(seed, size)
    lo, hi = (np.full(size, -np.inf), np.zeros(size)) if stops else (lo, hi)
    f = boxed_lcp(M, b, lo, hi).force
    w, small = b - M @ f, CLOSE * np.abs(b).max()
    assert ((f >= lo) & (f <= hi)).all()
    assert w[f < hi].max(initial=0.0) <= small
    assert w[f > lo].min(initial=0.0) >= -small
    assert not stops or (b < 0).any() == (f < 0).any()


def test_on_the_border_the_start_decides():
    """b = hi: at rest and about to move are both right, a joint that is known to have given way moves."""
    one = np.ones(1)
    assert boxed_lcp(np.eye(1), one, -one, one).sides.tolist() == [0]
    assert boxed_lcp(np.eye(1), one, -one, one, np.array([1])).sides.tolist() == [1]
    assert boxed_lcp(np.eye(1), 0.9 * one, -one, one, np.array([1])).sides.tolist() == [0]


def test_friction_brakes_as_fast_as_the_fastest_motion_of_the_linear_equation():
    """B dv/dt = -diag(slope) v: the fastest of its motions, of one arm and of several."""
    B = np.array([[[2.0, 0.0], [0.0, 0.5]], [[2.0, 0.6], [0.6, 0.5]]])
    slope = np.array([3.0, 1.0])
    trace, det = 3.0 * 0.5 + 1.0 * 2.0, 2.0 * 0.5 - 0.6**2  # s^2 det B - s trace + 3 = 0
    coupled = (trace + np.sqrt(trace**2 - 4.0 * 3.0 * det)) / (2.0 * det)
    np.testing.assert_allclose(braking_rate(B, slope), [2.0, coupled], rtol=1e-12)
    assert braking_rate(B[1], slope) == pytest.approx(coupled, rel=1e-12)


SLIDES = JointFriction(Direction(0.0, 0.0), Direction(0.0, 0.0), sigmoid=Sigmoid(3.0, 20.0, 0.01))


def test_a_share_of_the_load_is_left_out_of_a_run():
    run, plain = (slowed(rough(model)) for model in (replace(symmetric(3.0, 0.5), load=0.2), symmetric(3.0, 0.5)))
    assert (run.tau_friction == plain.tau_friction).all()
    assert run.meta["friction_law"]["left_out"].startswith("left out: friction that grows with the load, 0.2 of it at ")
    assert "left_out" not in plain.meta["friction_law"]


def test_a_sigmoid_brakes_without_stick_and_its_work_closes_the_audit():
    """A slider alone: its kinetic energy goes into the friction, and nothing else."""
    run = one(SLIDES)
    assert run.meta["friction_law"]["form"] == "sigmoid"
    assert run.tau_friction == pytest.approx(SLIDES.torque(run.dq))
    assert run.events == ()
    assert 0.0 < run.dq[-1, 0] < 0.2
    assert run.work["friction"][-1] == pytest.approx(-np.trapezoid((run.tau_friction * run.dq)[:, 0], run.t), rel=1e-5)
    assert abs(run.meta["audit"]["residual"]) < 1e-9


def test_a_sigmoid_beside_coulomb_friction_sticks_as_that_does():
    both = replace(SLIDES, positive=Direction(2.0, 0.1), negative=Direction(2.0, 0.1))
    run, plain = one(both), one(symmetric(2.0, 0.1))
    assert [event.kind for event in run.events] == ["stick"]
    assert run.events[0].t < plain.events[0].t
    assert run.tau_friction[:5] == pytest.approx(both.torque(run.dq[:5]))
    assert slowed(rough(both), friction="smooth", substeps=40).q[-1] == pytest.approx(run.q[-1], abs=SMOOTH)


def test_the_panda_has_the_friction_of_its_authors():
    friction, level = chosen_friction(lwr_dyn.load("panda")), 0.87224
    own = [level / (1 + np.exp(-9.0657 * (speed + 0.025882))) for speed in (1.0, 0.0)]
    assert (friction.form, friction.smooth(np.ones(7))[1]) == ("sigmoid", pytest.approx(own[0] - own[1]))
