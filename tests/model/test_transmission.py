"""The motor map: equal power on both sides, rotors and friction as joints feel them; springs and dampers of gears."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lwr_dyn
from lwr_dyn.foundation.errors import MissingDataError, OptionError, ShapeError
from lwr_dyn.model.caveats import KINEMATICS
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
from lwr_dyn.model.transmission import JointElasticity, Transmission, chosen_elasticity

POWER = 1e-12
"""Relative to the largest of the powers that are summed: seven products and a solve with a well-conditioned T."""
ROUNDING = 1e-14
N2, N3, n3, N5 = 28.25, 28.25, 1.68, 9.48

states = st.integers(0, 10**6).map(lambda seed: np.random.default_rng(seed).normal(size=(2, 5, 7)))


WAM, ARM = lwr_dyn.load("wam7"), lwr_dyn.load("lwr4plus")
MAP = WAM.transmission


def test_the_wams_map_is_the_manuals():
    T = np.diag([-42.0, 0, 0, -18.0, 0, 0, -14.93])
    T[1:3, 1:3] = [[N2, -N3 / n3], [-N2, -N3 / n3]]
    T[4:6, 4:6] = [[N5, -N5], [N5, N5]]
    np.testing.assert_array_equal(MAP.matrix, T)
    assert MAP.matrix[1, 2] == pytest.approx(-16.8155, abs=5e-5)
    assert not MAP.matrix.flags.writeable


@given(states)
def test_power_and_energy_are_the_same_at_joints_and_motors_and_friction_takes_power_out(state):
    dq, tau_m = state
    tau, dq_m = MAP.joint_torque(tau_m), MAP.motor_velocity(dq)
    scale = np.abs(tau * dq).max() + np.abs(tau_m * dq_m).max()
    assert np.abs((tau * dq).sum(-1) - (tau_m * dq_m).sum(-1)).max() <= POWER * scale
    J = np.linspace(1e-5, 2e-4, 7)
    energy = np.einsum("ki,ij,kj->k", dq, MAP.reflected_inertia(J), dq)
    assert energy == pytest.approx((J * dq_m**2).sum(-1), rel=1e-12)
    motors = tuple(JointFriction(Direction(0.1, 1e-3, 0.2, 1.0), Direction(0.2, 0.0)) for _ in range(7))
    assert ((MAP.reflected_friction(motors, dq) * dq).sum(-1) > 0).all()


def test_a_pair_of_equal_motors_stays_apart_unequal_ones_are_coupled_and_friction_comes_to_both_joints():
    J = np.full(7, 1.16e-4)
    expected = 1.16e-4 * np.array([42**2, 2 * N2**2, 2 * (N3 / n3) ** 2, 18**2, 2 * N5**2, 2 * N5**2, 14.93**2])
    np.testing.assert_allclose(MAP.reflected_inertia(J), np.diag(expected), rtol=ROUNDING, atol=ROUNDING)
    J[1] *= 1.5
    B = MAP.reflected_inertia(J)
    assert B[1, 2] == pytest.approx(-0.5 * 1.16e-4 * N2 * N3 / n3, rel=ROUNDING)
    np.testing.assert_array_equal(B, B.T)
    # Joint 2 alone: both motors of the pair turn, in opposite directions.
    motors = tuple(symmetric(0.02 * (i + 1), 1e-4) for i in range(7))
    f = [0.04 + 1e-4 * N2 * 0.5, -(0.06 + 1e-4 * N2 * 0.5)]
    expected = [0.0, N2 * (f[0] - f[1]), -N3 / n3 * (f[0] + f[1]), 0.0, 0.0, 0.0, 0.0]
    assert MAP.reflected_friction(motors, 0.5 * np.eye(7)[1]) == pytest.approx(expected, rel=1e-12)


def test_the_sheets_reflected_inertias_are_those_of_nearly_one_motor():
    """Erratum rotor-inertia-conflict: the second source is far from one motor for joints 2 and 4."""
    per_unit = np.diag(MAP.reflected_inertia(np.ones(7)))
    motors = WAM.armature / per_unit
    assert motors[:4] == pytest.approx([1.139e-4, 1.140e-4, 1.185e-4, 1.049e-4], rel=1e-3)
    assert motors[4:] == pytest.approx([1.848e-5, 1.848e-5, 2.095e-6], rel=1e-3)
    assert 0.094 / per_unit[[1, 3]] == pytest.approx([5.9e-5, 2.9e-4], rel=1e-2)


SINGULAR = "singular matrix; allowed: as many independent motors as joints"


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        *((lambda x=x: Transmission(x), ShapeError, "transmission: ")
          for x in (np.zeros((2, 3)), np.zeros(3), np.zeros((0, 0)), [[np.nan]], [["a"]])),
        *((lambda x=x: Transmission(x), OptionError, SINGULAR)
          for x in (np.zeros((2, 2)), [[1.0, 2.0], [2.0, 4.0]], np.diag([1.0, 0.9e-12]))),
        *((lambda x=x: x(np.zeros(6)), ShapeError, "6 numbers")
          for x in (MAP.motor_velocity, MAP.joint_torque, MAP.reflected_inertia, MAP.between_joints)),
        (lambda: MAP.reflected_friction((None,) * 6, np.zeros(7)), ShapeError, "dq"),
        (lambda: MAP.reflected_inertia([-1.0] + [0.0] * 6), OptionError, r"rotor_inertia: -1.0; allowed: 0 or more"),
        *((lambda x=x: JointElasticity(*x), (OptionError, ShapeError), words) for x, words in (
            (([1.0, 0.0], [0.0, 0.0]), "stiffness of joint 2: 0; allowed: numbers above 0"),
            (([-5.0, 1.0], [0.0, 0.0]), "stiffness of joint 1: -5; allowed"),
            (([1.0, 1.0], [0.0, -1e-9]), "damping of joint 2: -1e-09; allowed: numbers of at least 0"),
            (([1.0, np.inf], [0.0, 0.0]), "joint stiffness: inf at index"),
            (([1.0, 1.0], [0.0]), "joint damping: 1 number; allowed: 2 numbers"),
            (([[1.0, 1.0]], [[0.0, 0.0]]), "joint stiffness: an array of 1 x 2 numbers; allowed: 2 numbers"))),
        *((lambda x=x: chosen_elasticity(ARM, x), OptionError, r'stiffness: .* allowed: "file", a number above 0')
          for x in (0.0, -1.0, np.nan, np.inf, "soft", True)),
        (lambda: chosen_elasticity(replace(ARM, elasticity=None), "file"), MissingDataError,
         "lwr4plus: joint stiffness not given; needed for elastic joints"),
        (lambda: chosen_elasticity(ARM, JointElasticity([1.0, 1.0], [0.0, 0.0])), ShapeError, "2 numbers; allowed: 7"),
    ],
)  # fmt: skip
def test_what_is_no_map_rotor_spring_or_choice_is_refused(make, error, words):
    with pytest.raises(error, match=words):
        make()


def test_a_number_is_the_largest_stiffness_and_keeps_the_proportions_of_the_file():
    stiff = chosen_elasticity(ARM, 3e4)
    assert np.allclose(stiff.stiffness, 3.0 * ARM.elasticity.stiffness, rtol=1e-15)
    assert np.allclose(stiff.damping, 3.0 * ARM.elasticity.damping, rtol=1e-15)
    assert stiff.source == f"{ARM.elasticity.source}, times 3"
    even = chosen_elasticity(replace(ARM, elasticity=None), 3e4)
    assert (even.stiffness.tolist(), even.damping.tolist()) == ([3e4] * 7, [30.0] * 7)
    own = JointElasticity(np.full(7, 5.0), np.zeros(7))
    assert chosen_elasticity(ARM, None) is None
    assert chosen_elasticity(ARM, "file") is ARM.elasticity
    assert chosen_elasticity(ARM, own) is own
    locked = ARM.with_locked_joint("joint_4", 0.0)  # which takes its spring along
    assert locked.elasticity.stiffness.tolist() == [1e4, 1e4, 1e4, 6e3, 6e3, 6e3]
    assert Transmission(np.diag([1.0, 1.1e-12])).n == 2


def test_rotors_of_a_coupled_wrist_stand_between_joints_and_equal_ones_of_a_differential_do_not():
    """TX40: motor 6 turns with joints 5 and 6; WAM: two equal motors turn joints 2 and 3, and 5 and 6."""
    tx40 = lwr_dyn.load("tx40")
    J = np.array([0.0, 0.0, 0.0, 0.0, (0.0468 - 0.0105) / 45**2, 0.0105 / 32**2])
    whole = tx40.transmission.reflected_inertia(J)
    added = tx40.transmission.between_joints(tx40.armature)
    np.testing.assert_allclose(added[4:, 4:], whole[4:, 4:] - np.diag(np.diag(whole))[4:, 4:], atol=1e-15)
    assert np.abs(MAP.between_joints(WAM.armature)).max() < 1e-12
    assert WAM.coupled_rotors == ""
    weak = np.diag([1.0, 0.0, 0.0])
    # Of singular values of squared ratios, those below 1e-9 of the largest count as 0.
    for smallest, shared in ((1.1e-9, True), (0.9e-9, False)):
        weak[1:, 1:] = np.sqrt(smallest * (np.sqrt(5.0) + 1.0) / 2.0) * np.tri(2)
        found = Transmission(weak).between_joints([0.0, 2.0, 1.0])[1, 2]
        assert bool(found == pytest.approx(1.0, rel=1e-6)) == shared
    assert tx40.caveat().startswith("tx40 (body): ")
    assert "a rotor that turns with joint_5 and joint_6 adds 0.0105 kg m^2 between them" in tx40.caveat()
    assert "an MJCF cannot hold it" in lwr_dyn.urdf_text(tx40)
    assert "rotor" not in tx40.caveat(used=KINEMATICS)


def test_motors_are_seen_at_the_joints_of_their_numbers():
    """Inertia by the square of a motor's own ratio: the same mass matrix; a second time changes nothing."""
    for name, shared in (("tx40", [4, 5]), ("wam7", [1, 2, 4, 5]), ("lwr4plus", [])):
        arm = lwr_dyn.load(name)
        motors = arm.transmission or Transmission(np.diag([160.0] * arm.n))
        seen, own = motors.at_joints(), np.diag(motors.matrix)
        J = np.linspace(1e-4, 2e-4, arm.n)
        assert seen.reflected_inertia(J * own**2) == pytest.approx(motors.reflected_inertia(J), rel=1e-12)
        assert np.flatnonzero(seen.coupled).tolist() == np.flatnonzero(motors.coupled).tolist() == shared
        assert (seen.seen_at_joints, motors.seen_at_joints) == (True, False)
        assert np.array_equal(seen.at_joints().matrix, seen.matrix)
    swapped = Transmission([[0.0, -20.0], [30.0, 0.0]]).at_joints()  # seen at no joint of their number
    assert swapped.matrix.tolist() == [[0.0, 1.0], [1.0, 0.0]]
    assert not swapped.seen_at_joints
    assert not swapped.coupled.any()
