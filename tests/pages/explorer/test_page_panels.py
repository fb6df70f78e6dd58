"""The panels of the explorer's page beside Python: pose to copy, Jacobian, ellipsoids, other readings, payload."""

import re

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.pinocchio_engine import flange_and_jacobian
from lwr_dyn.pages.explorer.page_data import other_readings
from tests.pages.explorer.explored import explored_arm, opened

pytestmark = pytest.mark.slow

SHOWN = "lwr4plus physical"
Q = np.array([0.3, -0.4, 0.5, 0.9, -0.2, 0.7, 0.1])
DQ, DDQ = np.linspace(-1, 1, 7), np.linspace(2, -1, 7)
ROUNDED = 1e-10
"""[rad] the page keeps positions in deg, to nine decimals."""
AGREES = 1e-8
"""Of torques and lengths computed at positions that far away."""


@pytest.fixture(scope="module")
def arm():
    return explored_arm(SHOWN)


@pytest.fixture(scope="module")
def window(browser, page):
    opened(browser, f"{page.as_uri()}#q={','.join(map(repr, Q.tolist()))}")
    browser.execute_script("explorerState.set({dq: arguments[0], ddq: arguments[1]})", DQ.tolist(), DDQ.tolist())
    return browser


def computed(window, panel, names):
    """Arrays of a panel after it computed, at the page's own positions."""
    script = """const panel = lwrExplorer[arguments[0]], { q } = explorerState;
        panel.compute(arguments[0] === "others" ? explorerState : q);
        return arguments[1].map((name) => Array.from(panel[name]));"""
    return [np.array(values) for values in window.execute_script(script, panel, names)]


def test_a_link_opens_the_pose_it_was_copied_from(window):
    assert np.abs(np.array(window.execute_script("return lwrExplorer.positions()")) - Q).max() < ROUNDED
    link = window.execute_script("return lwrExplorer.poseCopy.text('link', lwrExplorer.positions())")
    assert np.abs(np.array(link.split("#q=")[1].split(","), float) - Q).max() < ROUNDED


def test_a_link_may_turn_a_joint_without_limits_beyond_its_slider(window):
    limits = window.execute_script(
        """const [joint] = lwrExplorer.arm.joints, { lower, upper } = joint;
        Object.assign(joint, { lower: null, upper: null });
        location.hash = "q=3.5,0,0,0,0,0,0";
        return { lower, upper };"""
    )
    window.execute_async_script("setTimeout(arguments[0], 50)")
    first = window.execute_script("return lwrExplorer.positions()[0]")
    window.execute_script("Object.assign(lwrExplorer.arm.joints[0], arguments[0])", limits)
    window.execute_script("lwrExplorer.setPose(arguments[0])", Q.tolist())
    assert abs(first - 3.5) < ROUNDED


@pytest.mark.parametrize("bad", ["1,2", "0,0,0,0,0,0,x", "0,0,0,9,0,0,0", "0,0,0,,0,0,0"])
def test_a_link_that_is_no_pose_of_the_arm_moves_nothing(window, bad):
    window.execute_script(f"location.hash = 'q={bad}'")
    window.execute_async_script("setTimeout(arguments[0], 50)")
    assert "not one of this arm" in window.execute_script("return lwrExplorer.poseCopy.word.textContent")
    assert np.abs(np.array(window.execute_script("return lwrExplorer.positions()")) - Q).max() < ROUNDED


def test_texts_to_copy_say_the_pose_of_python(window, arm):
    pose, _ = flange_and_jacobian(arm)(Q)
    python = window.execute_script("return lwrExplorer.poseCopy.text('python', lwrExplorer.positions())")
    q = eval(python.removeprefix("q = "))
    assert np.abs(np.array(q) - Q).max() < ROUNDED
    said = window.execute_script("return lwrExplorer.poseCopy.text('krl', lwrExplorer.positions())")
    x, y, z, a, b, c = map(float, re.findall(r"[XYZABC] (-?[\d.]+)", said))
    assert np.abs(np.array([x, y, z]) - 1000 * pose[:3, 3]).max() < 6e-4
    ca, sa, cb, sb, cc, sc = (f(np.radians(t)) for t in (a, b, c) for f in (np.cos, np.sin))
    turn = (
        np.array([[ca, -sa, 0], [sa, ca, 0], [0, 0, 1]])
        @ [[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]]
        @ [[1, 0, 0], [0, cc, -sc], [0, sc, cc]]
    )
    assert np.abs(turn - pose[:3, :3]).max() < 3e-6


def test_jacobian_and_ellipsoids_are_those_of_python(window, arm):
    _, expected = flange_and_jacobian(arm)(Q)
    given, sizes, axes = computed(window, "jacobian", ["J", "sizes", "turned"])
    assert np.abs(given.reshape(6, 7) - expected).max() < AGREES
    axes = axes.reshape(3, 3)
    assert np.abs(np.sort(sizes)[::-1] - np.linalg.svd(expected[:3])[1]).max() < AGREES
    assert np.abs(axes @ np.diag(sizes**2) @ axes.T - expected[:3] @ expected[:3].T).max() < AGREES
    said = window.execute_script("return lwrExplorer.jacobian.said.manipulability.textContent")
    assert float(said) == pytest.approx(np.prod(np.linalg.svd(expected[:3])[1]), rel=1e-4)


def test_singular_values_keep_their_digits_and_lost_directions_are_counted(window):
    rng = np.random.default_rng(3)
    turned, rows = np.linalg.qr(rng.normal(size=(3, 3)))[0], np.linalg.qr(rng.normal(size=(7, 7)))[0][:3]
    script = """const sizes = new Float64Array(3), turned = new Float64Array(9);
        singularValues(Float64Array.from(arguments[0]), 7, sizes, turned); return [[...sizes], [...turned]]"""
    for meant in ([1.0, 0.4, 0.1], [1.0, 1.0, 1e-12], [0.7, 0.0, 0.0], [0.0, 0.0, 0.0]):
        matrix = turned @ np.diag(meant) @ rows
        sizes, axes = map(np.array, window.execute_script(script, matrix.ravel().tolist()))
        np.testing.assert_allclose(np.sort(sizes)[::-1], meant, rtol=0, atol=1e-15)
        axes = axes.reshape(3, 3)
        np.testing.assert_allclose(axes @ np.diag(sizes**2) @ axes.T, matrix @ matrix.T, atol=1e-15)
    window.execute_script("lwrExplorer.jacobian.write(new Float64Array(7))")
    lost = window.execute_script("return lwrExplorer.jacobian.said.ratio.textContent")
    assert lost == "singular: two directions are lost"  # the stretched upright arm moves along x alone
    assert "∞" in window.execute_script("return lwrExplorer.jacobian.said.force.textContent")


def test_another_reading_changes_the_torques_as_in_python(window, arm):
    others = other_readings(arm)
    assert sorted(others) == sorted(set(lwr_dyn.readings("lwr4plus")) - {"physical"})
    other = others[window.execute_script("return lwrExplorer.compared.label")]
    for mass in (0.0, 2.5):
        window.execute_script("lwrExplorer.carry(arguments[0], [0.01, -0.02, 0.1])", mass)
        tool = {"xyz": [0, 0, 0], "rpy_deg": [0, 0, 0], "mass": mass, "com": [0.01, -0.02, 0.1]}
        found = computed(window, "others", ["tau", "other"])
        for values, meant in zip(found, (arm, other), strict=True):
            dynamics = lwr_dyn.dynamics_of(lwr_dyn.load("lwr4plus", meant.reading, tool=tool))
            assert np.abs(values - dynamics.inverse_dynamics(Q, DQ, DDQ)).max() < AGREES * 100
        assert np.abs(found[1] - found[0]).max() > 1e-3
    window.execute_script("lwrExplorer.carry(0, [0, 0, 0])")


def test_ellipsoids_are_drawn_at_the_flange(window, arm):
    pose, _ = flange_and_jacobian(arm)(Q)
    window.execute_script("document.getElementById('velocity-ellipsoid').click()")
    place = window.execute_script(
        "const {path} = lwrExplorer.jacobian.drawn[0]; return lwrExplorer.stage.node(path).position.toArray();"
    )
    assert np.abs(np.array(place) - pose[:3, 3]).max() < AGREES


def test_a_payload_is_written_into_its_fields(window):
    write = """const fields = [...document.querySelectorAll(".payload input")];
        arguments[0].forEach((text, k) => { fields[k].value = text; });
        fields[0].dispatchEvent(new Event("change"));
        const {mass, at} = lwrExplorer.payload;
        return [[mass, ...at], lwrExplorer.payloadFields.word.textContent];"""
    mass, word = window.execute_script(write, ["2", "0,1", "0", "0.2"])
    assert (mass, word) == ([2, 0.1, 0, 0.2], "")
    for bad in (["-1", "0", "0", "0"], ["1", "", "0", "0"], ["x", "0", "0", "0"]):
        mass, word = window.execute_script(write, bad)
        assert mass == [2, 0.1, 0, 0.2]
        assert "four numbers" in word
