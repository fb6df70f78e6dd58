"""Friction models: levels, signs, directions, what is refused; the smooth form against the exact one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lwr_dyn.foundation.errors import OptionError, ShapeError
from lwr_dyn.model.friction import (
    FRICTIONLESS,
    Direction,
    JointFriction,
    Sigmoid,
    friction_torque,
    smooth_friction,
    symmetric,
)

ONE_SIDED = JointFriction(Direction(4.0, 0.5, 6.0, 0.1), Direction(3.0, -0.2), offset=0.25)
SMEARED = 1e-9
"""tanh is 1 to the last bit at twenty widths, so away from rest both forms differ by rounding only."""

levels = st.floats(0.0, 10.0)
slopes = st.floats(-5.0, 5.0)


def test_each_direction_has_its_own_law_and_at_rest_there_is_the_offset_within_breakaway():
    up = 0.25 + 4.0 + 0.5 * 0.3 + 2.0 * np.exp(-9.0)
    down = 0.25 - (3.0 - 0.2 * 0.3)
    assert ONE_SIDED.torque([0.3, -0.3]) == pytest.approx([up, down], rel=1e-15)
    # Static friction without a Stribeck velocity is gone with the first motion; with one it falls from static.
    stiff = JointFriction(Direction(1.0, 0.0, 2.0), Direction(1.0, 0.0))
    assert (ONE_SIDED.torque(0.0), ONE_SIDED.breakaway, stiff.breakaway) == (
        0.25,
        (0.25 - 3.0, 0.25 + 6.0),
        (-1.0, 2.0),
    )
    assert stiff.torque([1e-300, -1e-300]).tolist() == [1.0, -1.0]
    assert Direction(1.0, 0.3, 1.5, 0.05).magnitude(1e-12) == pytest.approx(1.5, rel=1e-11)


@given(levels, slopes, levels, slopes, st.floats(1e-6, 10.0))
def test_without_offset_a_mirrored_joint_mirrors_the_torque(c1, s1, c2, s2, v):
    model = JointFriction(Direction(c1, s1), Direction(c2, s2))
    mirrored = JointFriction(Direction(c2, s2), Direction(c1, s1))
    assert model.torque(v) == -mirrored.torque(-v)


def test_torques_of_an_arm_keep_the_batch_and_are_zero_where_nothing_is_known():
    dq = np.random.default_rng(0).uniform(-1, 1, (4, 5, 2))
    tau = friction_torque((None, ONE_SIDED), dq)
    assert tau.shape == dq.shape
    assert not tau[..., 0].any()
    np.testing.assert_array_equal(tau[..., 1], ONE_SIDED.torque(dq[..., 1]))
    assert not FRICTIONLESS.torque(dq).any()


@pytest.mark.parametrize("dq", [[0.0], [[1.0], [2.0]], 3.0, [np.nan, 0.0]])
def test_velocities_of_the_wrong_shape_are_refused(dq):
    for name, arrays in (("dq", (dq,)), ("carried", ([0.0, 0.0], dq))):
        with pytest.raises(ShapeError, match=f"{name}: "):
            friction_torque((None, ONE_SIDED), *arrays)


def joint(*numbers, **others):
    return JointFriction(Direction(1, 0), Direction(1, 0), *numbers, **others)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Direction(-1.0, 0.0), "friction coulomb: -1.0; allowed: 0 or more"),
        (lambda: Direction(np.nan, 0.0), "friction coulomb: nan; allowed: a finite number"),
        (lambda: Direction(1.0, np.inf), "friction viscous: inf; allowed: a finite"),
        (lambda: Direction(1.0, 0.0, 0.9), "friction static: 0.9; allowed: at least the Coulomb level 1, or none"),
        (lambda: Direction(1.0, 0.0, np.nan), "friction static: nan; allowed: a finite"),
        (lambda: Direction(1.0, 0.0, 2.0, np.inf), "friction stribeck_velocity: inf; allowed: a finite"),
        (lambda: Direction(1.0, 0.0, 2.0, 0.0), "stribeck_velocity: 0.0; allowed: above 0, or none"),
        (lambda: joint(np.inf), "friction offset: inf; allowed: a finite"),
        (lambda: joint(covered=np.inf), "friction covered: inf; allowed: a speed above 0, or none"),
        (lambda: joint(covered=0.0), "friction covered: 0.0; allowed: a speed"),
        (lambda: joint(load=-0.1), "friction load: -0.1; allowed: a share of at least 0 and below 1"),
        (lambda: joint(load=1.0), r"friction load: 1\.0; allowed"),
        (lambda: joint(load=np.nan), "friction load: nan; allowed"),
        (lambda: Sigmoid(-1e-9, 1.0, 0.0), "friction sigmoid level: -1e-09; allowed: 0 or more"),
        (lambda: Sigmoid(1.0, 0.0, 0.0), "friction sigmoid slope: 0.0; allowed: above 0"),
        (lambda: Sigmoid(1.0, 1.0, np.inf), "friction sigmoid shift: inf; allowed: a finite number"),
        *((lambda x=x: smooth_friction([ONE_SIDED], x), f"width: {x}; allowed: a speed above 0")
          for x in (0.0, np.nan, np.inf)),
    ],
)  # fmt: skip
def test_numbers_that_mean_nothing_are_refused(make, says):
    with pytest.raises(OptionError, match=says):
        make()


def test_the_least_numbers_that_mean_something_are_taken():
    Direction(0.0, -1.0, 0.0, 1e-9)
    joint(covered=1e-9, load=0.999, sigmoid=Sigmoid(0.0, 1e-9, -1.0))


def test_the_smooth_form_is_the_offset_at_rest_continuous_and_away_from_rest_the_law_itself():
    law = smooth_friction([ONE_SIDED], 1e-3)
    assert law(np.array([0.0])) == 0.25
    v = np.linspace(-5e-3, 5e-3, 20001)[:, None]
    tau = law(v)[:, 0]
    assert np.abs(np.diff(tau)).max() < 6.0 / 1e-3 * 5e-7 * 1.01  # the slope at rest is level / width
    assert tau.max() < ONE_SIDED.breakaway[1]
    assert tau.min() > ONE_SIDED.breakaway[0]
    dq = np.random.default_rng(1).uniform(-1, 1, (200, 2))
    dq = dq[(np.abs(dq) > 20e-3).all(axis=1)]
    smooth = smooth_friction((None, ONE_SIDED), 1e-3)(dq)
    np.testing.assert_allclose(smooth, friction_torque((None, ONE_SIDED), dq), atol=SMEARED)


@given(st.floats(-3.0, 3.0), st.floats(0.01, 5.0), st.booleans())
def test_the_smooth_form_is_its_formula_at_any_width(v, width, mirrored):
    up, down = Direction(4.0, 0.5, 6.0, 0.7), Direction(3.0, -0.2, 3.5, 1.9)
    joint = JointFriction(down, up, -0.25) if mirrored else JointFriction(up, down, 0.25)
    d = joint.positive if v > 0.0 else joint.negative
    level = d.coulomb + (d.static - d.coulomb) * np.exp(-((v / d.stribeck_velocity) ** 2))
    expected = joint.offset + level * np.tanh(v / width) + d.viscous * v
    assert smooth_friction([None, joint], width)(np.array([v, v])) == pytest.approx(
        [0.0, expected], rel=1e-13, abs=1e-14
    )


@pytest.mark.parametrize("kept", [0, 1, 2])
def test_friction_is_none_only_where_all_its_numbers_are(kept):
    assert FRICTIONLESS.is_zero
    assert JointFriction(Direction(0.0, 0.0, 0.0, 0.1), Direction(0.0, 0.0), 0.0, 0.3, Sigmoid(0.0, 1.0, 0.2)).is_zero
    one = [(1.0, 0.0), (0.0, 1.0), (0.0, 0.0, 1.0)][kept]
    assert not JointFriction(Direction(*one), Direction(0.0, 0.0)).is_zero
    assert not JointFriction(Direction(0.0, 0.0), Direction(*one)).is_zero
    assert not JointFriction(Direction(0.0, 0.0), Direction(0.0, 0.0), offset=-1e-9).is_zero


@pytest.mark.parametrize("shift", [0.3, -0.3])
def test_the_largest_size_and_slope_of_a_sigmoid_are_reached(shift):
    one = Sigmoid(2.0, 5.0, shift)
    ends = np.abs(one.torque([-50.0, 50.0]))
    assert one.most == pytest.approx(ends.max(), rel=1e-14)
    assert ends.sum() == pytest.approx(2.0)
    h = 1e-5
    assert one.steepest == pytest.approx(np.diff(one.torque([-shift - h, -shift + h]))[0] / (2 * h), rel=1e-8)


def gaz(v, A, alpha, qdotsign):
    """The last lines of the authors' `get_FrictionTorque.m`."""
    return A / (1 + np.exp(-alpha * (v + qdotsign))) - A / (1 + np.exp(-alpha * qdotsign))


def test_a_sigmoid_is_the_formula_of_its_source():
    v, numbers = np.linspace(-3.0, 3.0, 61), (0.87224, 9.0657, 0.025882)
    joint = JointFriction(Direction(0.0, 0.0), Direction(0.0, 0.0), sigmoid=Sigmoid(*numbers))
    expected = gaz(v, *numbers)
    assert joint.torque(v) == pytest.approx(expected, abs=1e-15)
    assert smooth_friction([joint, symmetric(1.0, 0.0)])(np.array([0.7, 0.0]))[0] == pytest.approx(gaz(0.7, *numbers))
    both = friction_torque((joint, None), np.array([[0.3, 0.3]]))
    assert both[0] == pytest.approx([gaz(0.3, *numbers), 0.0])
    assert joint.torque(0.0) == 0.0
    assert joint.breakaway == (0.0, 0.0)
    assert not joint.is_zero
    assert joint.sigmoid.most >= np.abs(expected).max()
    assert np.abs(np.gradient(expected, v)).max() <= joint.sigmoid.steepest


@given(st.floats(0.0, 5.0), st.floats(0.1, 50.0), st.floats(-0.1, 0.1), st.sampled_from([-40.0, -1.0, 3.0]))
def test_a_sigmoid_of_a_motor_is_seen_at_its_joint(level, slope, shift, ratio):
    motor, v = Sigmoid(level, slope, shift), np.linspace(-1.0, 1.0, 11)
    assert motor.from_motor(ratio).torque(v) == pytest.approx(ratio * motor.torque(ratio * v), abs=1e-9)
