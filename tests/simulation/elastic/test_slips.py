"""Slips planted in the model and in its step: each is caught by laws of the model, or by SciPy's Radau."""

import numpy as np

from lwr_dyn.dynamics.engines import dynamics_of
from lwr_dyn.simulation.elastic.plant import ElasticDynamics
from tests.simulation.elastic.elastic_arms import physical, states
from tests.simulation.elastic.test_exponential import FREE, TAU, exact
from tests.slips import uncaught

MODEL_SLIPS = (
    ("turn, speed = x[..., n:] - x[..., :n], dx[..., n:] - dx[..., :n]",
     "turn, speed = x[..., n:] - x[..., :n], dx[..., n:] + dx[..., :n]"),
    ("self.stiffness * turn + self.damping * speed", "self.stiffness * turn - self.damping * speed"),
    ("return np.asarray(-(speed * speed) @ self.damping)", "return np.asarray(-(speed * speed) @ self.damping / 2)"),
    ("tau[:n] + gear)\n        out[n:]", "tau[:n] - gear)\n        out[n:]"),
    ("out[n:] = (tau[n:] - gear) / self.rotor", "out[n:] = (tau[n:] + gear) / self.rotor"),
    ("out[n:] = (tau[n:] - gear) / self.rotor", "out[n:] = tau[n:] / self.rotor"),
    ("bias_torque(x[..., :n], dx[..., :n]) - gear, gear]", "bias_torque(x[..., :n], dx[..., :n]) - gear, -gear]"),
    ("bias_torque(x[..., :n], dx[..., :n]) - gear, gear]", "bias_torque(x[..., n:], dx[..., :n]) - gear, gear]"),
    ("self.rotor = arm.armature", "self.rotor = 2 * arm.armature"),
    ("replace(link, rotor=None)", "link"),
    ("((dx[:, n:] ** 2) @ self.rotor", "((dx[:, :n] ** 2) @ self.rotor"),
    ("(turn * turn) @ self.stiffness) / 2", "(turn * turn) @ self.stiffness)"),
    ("np.subtract(over_q, spring,", "np.add(over_q, spring,"),
    ("np.subtract(over_dq, damper,", "np.subtract(over_q, damper,"),
    ("return np.array([K, -K, D, -D])", "return np.array([K, -K, -D, D])"),
)  # fmt: skip
STEP_SLIPS = (
    ("A[n2 + n + i, n2 + n + i] = d * (", "A[n2 + n + i, n2 + n + i] = -d * ("),
    ("A[:n2, -1] = (d * self._w) * dx", "A[:n2, -1] = d * dx"),
    ("link[:, :n2] *= d / self._w", "link[:, :n2] *= d"),
    ("A[n2 : 2 * n2, -1] = d * model.forward_dynamics(x, dx, net)",
     "A[n2 : 2 * n2, -1] = d * model.forward_dynamics(x, dx, tau)"),
    ("np.add(state[0], end[:n2] / self._w, out=after[0])", "np.add(state[0], end[:n2], out=after[0])"),
    ("self.damped += self._h * float(", "self.damped -= self._h * float("),
    ("friction_work -= self._h", "friction_work += self._h"),
    ("pull -= 0.5 * bend", "pull += 0.5 * bend"),
    ("rates[rows] -= self._A[rows] @ z", "rates[rows] += self._A[rows] @ z"),
    ("net = tau if self._friction is None else tau - self._friction(dx)", "net = tau"),
)  # fmt: skip


def model_check(module):
    """Both sides together are the rigid arm; accelerations solve the equations; the power is that of the torques."""
    model, rigid, step = module.ElasticDynamics(physical(), physical().elasticity), dynamics_of(physical()), 1e-6
    for x, dx in states(8, 2):
        same, speed = np.tile(x[:7], 2), np.tile(dx[:7], 2)
        sides = model.mass_matrix(same) @ np.ones(14) + model.bias_torque(same, speed)
        assert np.allclose(sides[:7] + sides[7:], rigid.inverse_dynamics(x[:7], dx[:7], np.ones(7)), atol=1e-9)
        ddx = model.forward_dynamics(x, dx, TAU)
        assert np.allclose(model.mass_matrix(x) @ ddx + model.bias_torque(x, dx), TAU, atol=1e-8)
        ahead, behind = (model.energies((x + s * dx)[None], (dx + s * ddx)[None])[0] for s in (step, -step))
        assert np.isclose((ahead - behind) / (2 * step), TAU @ dx + model.damper_power(dx), rtol=1e-6)
        slopes, i = np.zeros((14, 28)), np.arange(7)
        model.link_rows(x, dx, TAU, slopes[:7])
        for block, slope in enumerate(model.motor_slopes()):
            slopes[7 + i, 7 * block + i] = slope
        for j in range(28):
            e = step * np.eye(28)[j]
            later = model.forward_dynamics(x + e[:14], dx + e[14:], TAU)
            numeric = (later - model.forward_dynamics(x - e[:14], dx - e[14:], TAU)) / (2 * step)
            assert np.allclose(numeric, slopes[:, j], atol=1e-7 * np.abs(slopes).max())


class StepCheck:
    """A step with friction against SciPy's Radau, whose result is computed once; order 3 without friction."""

    def __init__(self):
        self.model = ElasticDynamics(physical(), physical().elasticity)
        self.mode = type(FREE)(**vars(FREE) | {"friction": lambda dx: np.repeat([0.0, 4.0], 7) * dx})
        self.state = states(9, 1)[0]
        self.expected = exact(self.model, self.state, TAU, 5e-4, self.mode.friction)

    def __call__(self, module):
        after = np.zeros((2, 14))
        held = module.HeldExponential(self.model, self.mode, 5e-4, 2)
        works = held.step(0.0, self.state, TAU, after)
        assert np.abs(after[0] - self.expected[:14]).max() <= 2e-9
        assert np.isclose(held.damped, self.expected[28], rtol=0.05)
        assert np.isclose(works[1], self.expected[29], rtol=1e-4)
        state, ends = self.state.copy(), []
        state[:, 7:] = state[:, :7]
        for substeps in (1, 2, 32):
            module.HeldExponential(self.model, FREE, 1e-3, substeps).step(0.0, state, TAU, after)
            ends.append(after[0].copy())
        errors = np.abs(np.array(ends[:2]) - ends[2]).max(axis=1)
        assert np.log2(errors[0] / errors[1]) > 2.5


def test_slips_in_the_model_are_caught():
    assert not uncaught("lwr_dyn.simulation.elastic.plant", MODEL_SLIPS, model_check)


def test_slips_in_the_step_are_caught():
    assert not uncaught("lwr_dyn.simulation.elastic.exponential", STEP_SLIPS, StepCheck())
