"""Gains on the explorer's page, and what the coupling of B and sampling do to the loop, beside Python's."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

import lwr_dyn
from lwr_dyn.control.gains import second_order_gains
from lwr_dyn.control.inertia.worst_case import worst_case_inertias
from lwr_dyn.control.paper_laws import PDGravity
from lwr_dyn.design.sampled_loop import RestingLoop, Sampling
from tests.pages.explorer.explored import explored_arm

pytestmark = pytest.mark.slow

SHOWN = "lwr4plus physical"
Q = np.array([0.3, -0.4, 0.5, 0.9, -0.2, 0.7, 0.1])
OMEGA, XI = 40.0, 0.7
AGREES = 1e-10
"""Relative; positions on the page are that far from Q."""


@pytest.fixture(scope="module")
def arm():
    return explored_arm(SHOWN)


def computed(window, q, omega=OMEGA, xi=XI):
    """The panel's arrays at a pose, and what it says of sampling."""
    script = """const { gains } = lwrExplorer, { modes } = gains, [q, omega, xi] = arguments;
        Object.assign(gains, { omega, xi }).compute({ q });
        return { ...Object.fromEntries(["b", "Kp", "Kd", "lambda"].map((name) => [name, [...modes[name]]])),
            torques: [...gains.torques], frequency: modes.frequency(6, omega), damping: modes.damping(6, xi),
            least: modes.leastRate(omega, xi) };"""
    return window.execute_script(script, list(q), omega, xi)


def test_gains_are_those_of_python(window, arm):
    found, B = computed(window, Q), lwr_dyn.dynamics_of(arm).mass_matrix(Q)
    gains = second_order_gains(np.diag(B), OMEGA, XI)
    np.testing.assert_allclose(found["Kp"], gains.Kp, rtol=AGREES)
    np.testing.assert_allclose(found["Kd"], gains.Kd, rtol=AGREES)
    np.testing.assert_allclose(found["torques"], np.radians(gains.Kp), rtol=AGREES)


def test_modes_are_the_eigenvalues_of_the_coupled_loop(window, arm):
    dynamics = lwr_dyn.dynamics_of(arm)
    for q in np.random.default_rng(3).uniform(arm.lower, arm.upper, (20, 7)):
        B, found = dynamics.mass_matrix(q), computed(window, q)
        own = eigh(B, np.diag(np.diag(B)), eigvals_only=True)
        np.testing.assert_allclose(found["lambda"], own[::-1], rtol=AGREES)
        Kp, Kd = np.diag(found["Kp"]), np.diag(found["Kd"])
        loop = np.block([[np.zeros((7, 7)), np.eye(7)], [-np.linalg.solve(B, Kp), -np.linalg.solve(B, Kd)]])
        s = np.linalg.eigvals(loop)
        w, xi = found["frequency"], found["damping"]
        fastest = w * (-xi + np.sqrt(complex(xi**2 - 1)))
        assert np.abs(s - fastest).min() < 1e-7 * w


@pytest.mark.parametrize("xi", [0.7, 0.1])  # damping, then stiffness sets the least rate
def test_sampling_is_that_of_design_with_gravity_compensated_exactly(window, arm, xi):
    floating = replace(arm, chain=replace(arm.chain, gravity=np.zeros(3)))
    dynamics, found = lwr_dyn.dynamics_of(floating), computed(window, Q, xi=xi)
    loop = RestingLoop.of(dynamics, PDGravity(dynamics, found["Kp"], found["Kd"]), Q[None])
    above, below = (loop.radius(Sampling(found["least"] * factor))[0] for factor in (1.001, 0.999))
    assert above < 1.0 < below


def test_equal_modes_and_a_singular_matrix(window):
    script = """const modes = new LoopModes(3); modes.B.set(arguments[0]); modes.compute(10, 1);
        return [modes.defined, [...modes.lambda]]"""
    assert window.execute_script(script, [2, 0, 0, 0, 2, 0, 0, 0, 5]) == [True, [1, 1, 1]]
    assert not window.execute_script(script, [1, 1, 0, 1, 1, 0, 0, 0, 1])[0]
    assert not window.execute_script(script, [1, 0, 0, 0, 0, 0, 0, 0, 1])[0]


def test_gains_of_the_largest_inertias_follow_the_payload(window, arm):
    wait = """const [, done] = arguments, { gains } = lwrExplorer, select = document.querySelector(".gains select");
        if (arguments[0]) lwrExplorer.carry(...arguments[0]);
        select.value = "largest"; select.dispatchEvent(new Event("change"));
        const ready = () => (gains.largest ? done([...gains.modes.b]) : setTimeout(ready, 10)); ready();"""
    found = window.execute_async_script(wait, None)
    np.testing.assert_allclose(found, [each.value for each in worst_case_inertias(arm)], rtol=1e-12)
    heavier = window.execute_async_script(wait, [2.0, [0, 0, 0.1]])
    assert (np.array(heavier) > np.array(found) * 1.001)[:6].all()
    back = """const select = document.querySelector(".gains select"); lwrExplorer.carry(0, [0, 0, 0]);
        select.value = "pose"; select.dispatchEvent(new Event("change"));"""
    window.execute_script(back)


WRITE = """const field = document.querySelector(`.gains [data-field="${arguments[0]}"]`), { said } = lwrExplorer.gains;
    field.value = arguments[1]; field.dispatchEvent(new Event("change"));
    return [lwrExplorer.gains[arguments[0]], said.field.textContent, said.sampled.textContent]"""


def test_fields_take_numbers_above_zero_only(window):
    assert window.execute_script(WRITE, "omega", "20,5")[:2] == [20.5, ""]
    for bad in ("0", "-3", "", "fast", "1e10", "Infinity"):
        value, word, _ = window.execute_script(WRITE, "omega", bad)
        assert value == 20.5
        assert "above 0" in word
    assert window.execute_script(WRITE, "omega", "20")[:2] == [20, ""]


def test_a_rate_that_is_too_low_is_said(window):
    window.execute_script("lwrExplorer.setPose(arguments[0])", Q.tolist())
    assert "holds at rest here" in window.execute_script(WRITE, "rate", "1000")[2]
    assert "Unstable at rest here when sampled at 20 Hz" in window.execute_script(WRITE, "rate", "20")[2]
