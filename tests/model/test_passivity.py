"""Where friction feeds energy in: against closed forms, against a fine grid, and the nearest friction that does not."""

from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

import lwr_dyn
from lwr_dyn.foundation.errors import OptionError
from lwr_dyn.model.friction import Direction, JointFriction
from lwr_dyn.model.passivity import Refit, SideCurve, certificate, feeds_energy, passive_refit
from tests.examples import examples

NOTHING = 1e-14
"""[N m] Rounding of a level of a few N m from which the offset was taken and to which it was added again."""

levels = st.floats(0.0, 5.0)
slopes = st.floats(-5.0, 5.0)
offsets = st.floats(-3.0, 3.0)
extras = st.floats(0.0, 3.0)
scales = st.floats(0.01, 1.0)


@st.composite
def joints(draw):
    sides = []
    for _ in range(2):
        c = draw(levels)
        sides.append(Direction(c, draw(slopes), c + draw(extras), draw(scales)))
    return JointFriction(*sides, offset=draw(offsets), covered=0.4)


def wam():
    return lwr_dyn.load("wam7").friction


def test_the_wam_feeds_energy_in_where_table_1_has_negative_slopes_and_joint_4_has_no_net_damping():
    active = {(s.joint + 1, s.side): s.from_speed for s in certificate(wam()) if not s.passive}
    expected = {
        (2, "negative"): 3.5643 / 2.3951,
        (4, "positive"): 1.5414 / 2.7045,
        (4, "negative"): 0.7342 / 1.0969,
        (5, "positive"): 0.2798 / 0.1972,
    }
    assert active.keys() == expected.keys()
    for key, speed in expected.items():
        assert active[key] == pytest.approx(speed, rel=1e-14)
        assert active[key] > 0.4  # beyond what the maps cover
    Kd = lwr_dyn.load("wam7").gains.Kd
    undamped = {(s.joint + 1, s.side) for s in certificate(wam()) if s.net_damping(Kd[s.joint]) <= 0.0}
    assert undamped == {(4, "positive")}
    (side,) = [s for s in certificate(wam()) if (s.joint, s.side) == (3, "positive")]
    assert side.net_damping(2.0) == pytest.approx(-0.7045)


@given(joints())
@examples(150)
def test_the_certificate_agrees_with_a_fine_grid_of_speeds(model):
    v = np.geomspace(1e-4, 1e3, 4000)
    for side in certificate([model]):
        sign = 1.0 if side.side == "positive" else -1.0
        power = model.torque(sign * v) * sign * v
        curve = SideCurve.of(model, side.side)
        noise = 1e-12 * (abs(curve.a) + abs(curve.b) * v + curve.e) * v
        fed = power < -noise
        if side.passive:
            assert not fed.any()
            continue
        if fed.any():
            assert v[fed].min() >= side.from_speed * (1 - 1e-9)
        inside = (v > side.from_speed * (1 + 1e-9)) & (v < side.to_speed * (1 - 1e-9))
        assert (power[inside] <= noise[inside]).all()


def test_ranges_of_speeds_have_both_ends():
    """A dip: exp(-(v/0.1)^2) + 0.1 v - 0.1, above zero at rest, below in between, above again from 1 on."""
    model = JointFriction(Direction(0.0, 0.1, 1.0, 0.1), Direction(1.0, 0.0), offset=-0.1)
    (up, down) = certificate([model])
    assert 0.1 < up.from_speed < 0.2
    assert up.to_speed == pytest.approx(1.0)
    curve = SideCurve.of(model, "positive")
    assert max(abs(curve.at(v)) for v in (up.from_speed, up.to_speed)) < 1e-15
    assert down.passive
    # below zero from rest, above it at its local maximum alone: the first range ends before that
    hump = JointFriction(Direction(0.0, 0.5, 0.3, 0.5), Direction(1.0, 0.0), offset=-0.35)
    (up, _) = certificate([hump])
    assert up.from_speed == 0.0 < up.to_speed < 0.296
    assert abs(SideCurve.of(hump, "positive").at(up.to_speed)) < 1e-15
    # flat friction below zero has no end, and none above it no beginning
    for level, wanted in ((-0.5, (0.0, np.inf)), (0.5, (None, np.inf)), (0.0, (None, np.inf))):
        (up, _) = certificate([JointFriction(Direction(1.0, 0.0), Direction(9.0, 0.0), offset=level - 1.0)])
        assert (up.from_speed, up.to_speed) == wanted
    # an offset beyond Coulomb drives from rest
    (up, down) = certificate([JointFriction(Direction(1.0, 0.5), Direction(1.0, 0.5), offset=-2.0)])
    assert (up.from_speed, up.to_speed) == (0.0, pytest.approx(2.0))
    assert down.passive


def test_feeding_is_decided_state_by_state_and_the_least_slope_is_at_the_steepest_fall():
    dq = np.zeros((3, 7))
    dq[:, 3] = [0.56, 0.58, -0.68]
    assert feeds_energy(wam(), dq)[:, 3].tolist() == [False, True, True]
    assert not feeds_energy(wam(), dq)[:, :3].any()
    direction = Direction(1.0, 0.3, 1.5, 0.05)
    v = np.linspace(0, 0.3, 300001)
    slope = np.gradient(direction.magnitude(v), v)
    assert certificate([JointFriction(direction, direction)])[0].least_slope == pytest.approx(slope.min(), rel=1e-6)


@given(joints(), st.floats(0.1, 2.0))
@examples(60)
def test_the_refit_is_passive_and_no_passive_level_and_slope_are_nearer(model, top):
    refit = passive_refit([model], top)
    for side in certificate([model]) if refit.changes else ():
        curve = SideCurve.of(refit.models[0], side.side)
        assert min(curve.a, curve.b) > -NOTHING  # with the Stribeck part above zero: passive at every speed
    assert bool(refit.changes) == any(not side.passive for side in certificate([model]))
    v = np.linspace(0.0, top, 401)
    for change in refit.changes:
        old = SideCurve.of(model, change.side)

        def cost(x, old=old):
            return np.mean((x[0] - old.a + (x[1] - old.b) * v) ** 2)

        best = min(minimize(cost, start, bounds=[(0, None)] * 2, tol=1e-14).fun for start in ([1, 0], [0, 1]))
        assert change.rms <= np.sqrt(best) * 1.01 + 1e-3  # the grid's own error


def test_the_refit_of_the_wam_its_cost_and_what_is_left_as_it_was():
    models = (None, JointFriction(Direction(1.0, 0.2), Direction(0.5, 0.0), offset=0.1))
    assert passive_refit(models) == Refit(models, ())
    refit = passive_refit(wam())
    costs = {(c.joint + 1, c.side): c.rms for c in refit.changes}
    slopes = {(2, "negative"): 2.3951, (4, "positive"): 2.7045, (4, "negative"): 1.0969, (5, "positive"): 0.1972}
    assert costs.keys() == slopes.keys()
    for key, slope in slopes.items():  # a line replaced by its mean: slope times width over sqrt(12)
        assert costs[key] == pytest.approx(slope * 0.4 / np.sqrt(12), rel=1e-12)
    assert [m for i, m in enumerate(refit.models) if i not in (1, 3, 4)] == [wam()[i] for i in (0, 2, 5, 6)]
    assert astuple(refit.models[3].positive) == (pytest.approx(1.0005), 0.0, None, None)
    model = JointFriction(Direction(1.0, -1.0, 1.5, 0.1), Direction(1.0, 0.5), offset=0.2, covered=1.0)
    (after,) = passive_refit([model]).models
    # level 1.2 - v with the offset, nearest 0.7 flat, of which 0.2 is the offset
    assert astuple(after.positive) == (pytest.approx(0.5), 0.0, pytest.approx(1.0), 0.1)
    assert (after.negative.coulomb, after.offset) == (pytest.approx(1.0), 0.2)


def test_a_speed_that_is_none_is_refused_and_a_joint_that_does_not_know_its_range_needs_one():
    blind = [None, JointFriction(Direction(1.0, -1.0), Direction(1.0, 0.0))]
    absent = "speed: not given, and joint 2 does not say up to where it was measured"
    wrong = r"speed: .*; allowed: a number above 0"
    for models, speed, words in ((blind, None, absent), *((wam(), x, wrong) for x in (0.0, -1.0, np.nan, np.inf))):
        with pytest.raises(OptionError, match=words):
            passive_refit(models, speed)
    assert passive_refit(blind, 0.5).changes[0].speed == 0.5
