"""One simulated set for all: the WAM with the paper's friction, all joints out and back at five speeds."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.control.paper_laws import PDGravity
from lwr_dyn.identification.logs.joint_log import JointLog
from lwr_dyn.identification.logs.simulated_logs import cruise_logs
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from lwr_dyn.model.friction import friction_torque
from tests.identification.simulated import fourier_states, ideal_cruise

SPEEDS = (0.06, 0.09, 0.13, 0.18, 0.25)
START = np.array([0.0, -1.2, 0.0, 1.6, 0.0, 0.2, 0.0])


@pytest.fixture(scope="session")
def wam():
    return lwr_dyn.load("wam7")


@pytest.fixture(scope="session")
def lwr():
    return lwr_dyn.load("lwr4plus", "physical")


@pytest.fixture(scope="session")
def columns(lwr):
    return TorqueColumns(lwr.chain)


@pytest.fixture(scope="session")
def closed_loop_logs(wam):
    """Manufacturer's gains, but 8 for joint 4's Kd: with its 2 the loop has no net damping upward and no cruise."""
    Kd = np.array(wam.gains.Kd)
    Kd[3] = 8.0
    controller = PDGravity(lwr_dyn.dynamics_of(wam), wam.gains.Kp, Kd, velocity_error=True)
    return list(cruise_logs(wam, controller, START, np.full(7, 0.5), SPEEDS))


@pytest.fixture
def one_joint_at_a_time(wam):
    """Ideal logs of every joint alone, both ways at four speeds."""
    moves = [(j, sign * v) for j in range(7) for sign in (1, -1) for v in (0.05, 0.1, 0.2, 0.3)]
    return [ideal_cruise(wam.friction, v * np.eye(7)[j], wam, START, source=f"q{j + 1} at {v}") for j, v in moves]


@pytest.fixture
def fourier():
    return _fourier


def _fourier(arm, friction, seconds=20.0, seed=1, joints=None):
    """A log of five harmonics of 0.1 Hz at every joint, its torques exact."""
    t, q, dq, ddq = fourier_states(arm.n, seconds, seed, joints)
    tau = lwr_dyn.dynamics_of(arm, "newton-euler").inverse_dynamics(q, dq, ddq) + friction_torque(friction, dq)
    return JointLog("fourier", tuple(range(1, arm.n + 1)), t, q, tau)
