"""Controllers linearised by differences: the same matrices as by hand, and what cannot be linearised is refused."""

import numpy as np
import pytest

from lwr_dyn.design import sampled_loop
from lwr_dyn.design.sampled_loop import RestingLoop, Sampling, law_at_rest
from lwr_dyn.foundation.errors import OptionError
from tests.design.margin_cases import BENT, dynamics, law
from tests.slips import uncaught

Q = np.array([BENT, 0.4 * BENT])


def plain(controller):
    """The same controller as a function that knows nothing of linear forms."""
    return lambda *state: controller(*state)


def check(module):
    for name in ("pd-gravity", "inverse-dynamics"):
        own = RestingLoop.of(dynamics(), law(name), Q)
        found = module.law_at_rest(plain(law(name)), Q)
        assert found.by_differences
        loop = RestingLoop.of_plant(own.plant, found.feedback, Q)
        for matrix in ("position", "velocity"):
            mine, exact = getattr(loop.feedback, matrix), getattr(own.feedback, matrix)
            np.testing.assert_allclose(mine, exact, atol=2e-6 * np.abs(exact).max())
        np.testing.assert_allclose(loop.radius(Sampling(1000.0, 1)), own.radius(Sampling(1000.0, 1)), atol=1e-7)
        assert found.bend < 1e-3
    assert module.law_at_rest(law("pd-gravity"), Q).notes == ()
    sided = module.law_at_rest(lambda *s: 100 * (s[3] - s[1]) - 20 * np.maximum(s[2], 0.0), Q)
    assert sided.bend == pytest.approx(0.2)
    weak = module.law_at_rest(lambda *s: -0.5 * np.maximum(s[2], 0.0), Q)
    assert weak.bend == pytest.approx(2.0)  # sides 0.5 and 0 about a middle of 0.25


SLIPS = (
    ("LinearFeedback(-slopes[:, :, :n]", "LinearFeedback(slopes[:, :, :n]"),
    ("-slopes[:, :, n:])", "slopes[:, :, n:])"),
    ("(ahead - behind) / (2 * STEP)", "(ahead - behind) / STEP"),
    ("(ahead - behind) / (2 * STEP)", "(ahead - middle) / (2 * STEP)"),
    ("torque(-offset)", "torque(offset)"),
    ("pose + z[:n], z[n:]", "pose + z[n:], z[:n]"),
    ("z[n:].copy(), pose.copy()", "z[n:].copy(), pose + z[:n]"),
    ("STEP * np.eye(2 * n)", "STEP * np.eye(2 * n)[::-1]"),
    ("ahead + behind - 2 * middle", "ahead + behind"),
)


def test_planted_slips_are_caught():
    assert not uncaught(sampled_loop.__name__, SLIPS, check)


def test_a_law_that_is_not_smooth_at_rest_is_named():
    def dry(t, q, dq, q_ref, dq_ref, ddq_ref):
        return 100 * (q_ref - q) - 20 * dq - 0.5 * np.sign(dq)

    notes = law_at_rest(dry, Q).notes
    assert "linearised by central differences" in notes[0]
    bent = law_at_rest(lambda *s: -100 * (s[1] - s[3]) - 20 * np.maximum(s[2], 0.0), Q)
    assert bent.bend == pytest.approx(0.2)
    assert "not smooth at rest" in bent.notes[1]


class Counting:
    """An integral that only its answers show."""

    def __init__(self):
        self.sum = 0.0

    def __call__(self, t, q, dq, q_ref, dq_ref, ddq_ref):
        self.sum = self.sum + (q_ref - q)
        return self.sum - dq


class WithReset(Counting):
    def reset(self):
        self.sum = 0.0


@pytest.mark.parametrize("make", [Counting, WithReset])
def test_a_controller_with_memory_is_refused(make):
    with pytest.raises(
        OptionError, match=r"remembers between calls.*allowed: a controller without memory, or with lin"
    ):
        law_at_rest(make(), Q)


@pytest.mark.parametrize(
    ("answer", "fault"), [(np.zeros(3), "shape"), (np.full(7, np.nan), "not finite"), (1.0, "shape")]
)
def test_torques_that_are_no_torques_are_refused(answer, fault):
    with pytest.raises(OptionError, match=fault):
        law_at_rest(lambda *_: answer, Q)
