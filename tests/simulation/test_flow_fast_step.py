"""The fast step of a sampled run on its own: closed forms for one joint, what it refuses, what it keeps of a step."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.model.friction import Direction, JointFriction, symmetric
from lwr_dyn.simulation.arm_friction import chosen_friction
from lwr_dyn.simulation.flow import FastStep, Flow
from lwr_dyn.simulation.integrators import rk4
from lwr_dyn.simulation.plant import plant_of
from tests.simulation.sample_runs import one_joint

ASYMMETRIC = JointFriction(Direction(3.0, 0.5, static=4.0), Direction(2.0, 1.5, static=2.5))


def fast(friction=None, external=None, h=0.01, substeps=1, tau=0.0, state=(0.0, 0.0), **options):
    """The flow and the fast step of one slider or wheel, begun at a state under a torque."""
    arm = one_joint(**options)
    flow = Flow(plant_of(arm, lwr_dyn.dynamics_of(arm), friction), rk4(substeps), external)
    start = np.array([*state, *np.zeros(flow.works)])
    flow.begin(lambda t, q, dq, memory: (np.array([tau]), np.zeros(0)), 0.0, start)
    return flow, FastStep(flow, h, substeps)


def taken(flow, step, state, tau, t=0.0):
    """Whether a step was taken, and the state after it."""
    after = np.full((2, 1), np.nan)
    return step.take(t, np.array(state)[:, None], np.array([tau]), after), after[:, 0]


@pytest.mark.parametrize("substeps", [1, 3])
def test_a_fast_step_is_the_parabola_up_to_limits_and_speeds_that_can_be_followed(substeps):
    """2 kg under 3 N: q + v h + 0.75 h^2; a limit may be reached, and 2 pi a step, and neither passed."""
    h, cap = 0.01, 2 * np.pi / 0.01
    flow, step = fast(substeps=substeps, lower=-1.0, upper=1.0)
    done, after = taken(flow, step, (0.2, -0.3), 3.0)
    assert done
    np.testing.assert_allclose(after, [0.2 - 0.3 * h + 0.75 * h**2, -0.3 + 1.5 * h], rtol=1e-14)
    assert (flow.evaluations, step.work) == (4 * substeps, (0.0, 0.0))
    assert taken(flow, step, (0.999, 0.05), 0.0)[0]
    wide, free = fast(substeps=substeps)
    for sign in (1.0, -1.0):
        assert not taken(flow, step, (sign * 0.9995, sign * 0.06), 0.0)[0]
        found = [taken(wide, free, (0.0, sign * cap * (1 + off)), 0.0)[0] for off in (-1e-9, 1e-9)]
        assert found == [True, False]
    assert not taken(wide, free, (0.0, 0.0), np.nan)[0]


def test_a_fast_step_with_friction_keeps_its_torque_and_work_and_refuses_to_turn_round():
    """4 N against 3 N and 0.5 N s/m of 2 kg; at rest up to 4 N nothing moves."""
    friction, h = chosen_friction(one_joint(), [ASYMMETRIC]), 0.01
    flow, step = fast(friction, tau=4.0, state=(0.0, 0.2))
    done, after = taken(flow, step, (0.0, 0.2), 4.0)
    v = 2.0 + (0.2 - 2.0) * np.exp(-0.25 * h)  # 2 dv = 1 - 0.5 v
    assert done
    assert after[1] == pytest.approx(v, rel=1e-12)
    assert step.friction == pytest.approx([3.0 + 0.5 * 0.2])
    kinetic, done_by = 0.5 * 2.0 * (v**2 - 0.2**2), 4.0 * after[0]
    assert step.work[-1] == pytest.approx(kinetic - done_by, rel=1e-8)
    assert not taken(flow, step, (0.0, 1e-3), -4.0)[0]  # it would turn round
    flow, step = fast(friction, tau=3.9)
    for tau, held in ((3.9, True), (4.0, True), (4.1, False), (-2.4, True), (-2.6, False)):
        done, after = taken(flow, step, (0.3, 0.0), tau)
        assert done == held
        if held:
            assert after.tolist() == [0.3, 0.0]
            assert step.friction == pytest.approx([tau])
            assert step.work == (0.0, 0.0)
    assert flow.stop_seconds.tolist() == [0.0]


def test_a_joint_that_its_stop_holds_counts_the_time_and_leaves_when_it_is_pulled():
    flow, step = fast(tau=2.0, state=(0.5, 0.0), upper=0.5, lower=-1.0)
    assert (flow.mode.all_at_rest, flow.on_stop.tolist()) == (True, [True])
    assert taken(flow, step, (0.5, 0.0), 2.0)[0]
    assert taken(flow, step, (0.5, 0.0), 1e-9)[0]
    assert flow.stop_seconds == pytest.approx([0.02])
    assert not taken(flow, step, (0.5, 0.0), -1e-9)[0]
    both = chosen_friction(one_joint(), [symmetric(1.5, 0.0)])
    flow, step = fast(both, tau=2.0, state=(0.5, 0.0), upper=0.5, lower=-1.0)
    assert (flow.friction.tolist(), flow.on_stop.tolist()) == ([1.5], [True])
    assert taken(flow, step, (0.5, 0.0), 1.0)[0]
    assert (step.friction.tolist(), step.on_stop.tolist()) == ([1.0], [False])
    assert not taken(flow, step, (0.5, 0.0), -1.6)[0]
    edge, _ = fast(both, tau=-1.5, state=(0.5, 0.0), upper=0.5, lower=-1.0)
    assert edge.mode.all_at_rest  # where rest and motion are both right, friction holds
    bare, _ = fast(tau=0.0, state=(0.5, 0.0), upper=0.5, lower=-1.0)
    assert not bare.mode.any_at_rest  # and a stop alone releases


def test_what_pushes_from_outside_moves_a_fast_step_and_has_its_work():
    def pushing(t, q, dq):
        return np.array([2.0 + 10.0 * t])

    h = 0.01
    flow, step = fast(external=pushing, tau=1.0)
    done, after = taken(flow, step, (0.0, 0.3), 1.0, t=0.5)
    assert done
    assert after[1] == pytest.approx(0.3 + (1.0 + 2.0 + 5.0) * h / 2 + 5.0 * h**2 / 2, rel=1e-13)
    kinetic = after[1] ** 2 - 0.3**2
    assert step.work[-1] == pytest.approx(kinetic - 1.0 * after[0], rel=1e-8)
    held, step = fast(chosen_friction(one_joint(), [symmetric(3.5, 0.0)]), pushing)
    assert taken(held, step, (0.0, 0.0), 0.0, t=0.1)[0]
    assert step.friction == pytest.approx([3.0])
    assert not taken(held, step, (0.0, 0.0), 0.0, t=0.2)[0]
