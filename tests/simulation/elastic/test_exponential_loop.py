"""What a controller is given on elastic joints: one side's positions, the readings of both, its own signals kept."""

import numpy as np
import pytest

from lwr_dyn.foundation.errors import ShapeError
from lwr_dyn.simulation.plant import Encoder
from tests.simulation.elastic.elastic_arms import physical, short_run


class Reader:
    """A law that stores what it is given; its torque is constant."""

    def __init__(self):
        self.given, self.read, self.signals = [], [], {}

    def sense(self, readings):
        self.read.append([getattr(readings, x).copy() for x in ("theta", "dtheta", "q", "dq", "torque")])

    def __call__(self, t, q, dq, q_ref, dq_ref, ddq_ref):
        self.given.append((q.copy(), dq.copy()))
        self.signals = {"count": np.array([float(len(self.given))])}
        return np.full(7, 1e3)


@pytest.mark.parametrize("delay", [0, 2])
@pytest.mark.parametrize("side", ["motor", "link"])
def test_one_side_is_given_and_both_are_read(side, delay):
    law = Reader()
    run = short_run(law, encoders=side, duration=0.01, delay=delay)
    signals = run.signals
    side_of = {"motor": (signals["theta"], signals["dtheta"]), "link": (run.q, run.dq)}
    assert np.array_equal(np.array(law.given).swapaxes(0, 1), side_of[side])
    expected = (signals["theta"], signals["dtheta"], run.q, run.dq, signals["torque_sensor"])
    assert np.array_equal(np.array(law.read).swapaxes(0, 1), expected)
    assert signals["count"][:, 0].tolist() == [float(k) for k in range(1, 12)]
    assert np.array_equal(run.tau_applied, np.tile(physical().effort, (11, 1)))


def test_encoders_and_their_filters_are_between_the_arm_and_the_law():
    law = Reader()
    run = short_run(law, duration=0.01, encoder=Encoder(noise=1e-4))
    gap = np.array([q for q, _ in law.given]) - run.signals["theta"]
    assert 1e-5 < gap.std() < 1e-3
    assert np.array_equal([read[0] for read in law.read], [q for q, _ in law.given])
    assert np.array_equal([read[4] for read in law.read], run.signals["torque_sensor"])


def test_a_torque_of_another_shape_names_the_sample():
    with pytest.raises(ShapeError, match=r"torque of the controller at sample 0: shape .14,.; allowed: 7 numbers"):
        short_run(lambda t, q, dq, *rest: np.zeros(14))


def test_a_law_without_signals_leaves_none():
    run = short_run(lambda t, q, dq, *rest: np.zeros(7), duration=0.005)
    assert set(run.signals) == {"theta", "dtheta", "torque_sensor"}
