"""Two arms side by side in headless Chromium: drawn, compared, and coupled by joints or by the flange's pose."""

import re

import numpy as np
import pytest
from scipy.optimize import minimize

import lwr_dyn
from lwr_dyn.dynamics.pinocchio_engine import flange_and_jacobian
from lwr_dyn.pages.explorer.page import write_explorer
from lwr_dyn.pages.explorer.page_data import slider_ranges
from tests.axe import violations
from tests.headless import logs
from tests.pages.explorer.by_hand import pulled
from tests.pages.explorer.explored import explored_arm, opened

pytestmark = pytest.mark.slow

Q = np.array([0.3, 0.7, 0.2, -1.2, 0.4, 0.8, 0.1])
FOLLOWED = 1e-6
"""[m]"""
FOUND = 1e-3
"""[m] of the reach, by search."""


def page(browser, folder, first, second):
    write_explorer(folder / "two.html", explored_arm(first), beside=explored_arm(second))
    return opened(browser, (folder / "two.html").as_uri())


@pytest.fixture(scope="module")
def window(browser, tmp_path_factory):
    return page(browser, tmp_path_factory.mktemp("two"), "lwr4plus computed", "wam7 manual")


def coupled(window, how, q=Q):
    """Both arms' positions and drawn flanges."""
    return window.execute_script(
        """const e = lwrExplorer; e.sides.couple(arguments[0]); e.setPose(arguments[1]); e.state.compute();
        return e.shown.map(({q, data}) => [Array.from(q), e.stage.flangePose(data.run)])""",
        how,
        q.tolist(),
    )


def column(window, place):
    script = """const {cells} = lwrExplorer.sides;
        return Object.fromEntries(Object.entries(cells).map(([name, row]) => [name, row.map((x) => x.textContent)]))"""
    return {name: texts[place] for name, texts in window.execute_script(script).items()}


def reach(arm):
    """The largest distance of the flange from the first axis, by another search."""
    to_axis = np.linalg.inv(arm.joints()[0].origin.matrix())

    def inward(q):
        return -np.hypot(*(to_axis @ lwr_dyn.forward_kinematics(arm, q)[:, 3])[:2])

    ranges, rng = slider_ranges(arm), np.random.default_rng(1)
    starts = [[rng.uniform(low, up) for low, up in ranges] for _ in range(12)]
    return -min(minimize(inward, start, bounds=ranges).fun for start in starts)


def test_arms_stand_apart_and_the_chosen_one_has_the_panels(window):
    coupled(window, "none")
    roots = window.execute_script(
        "return lwrExplorer.shown.map(({run}) => lwrExplorer.stage.node(run.root).position.toArray())"
    )
    assert np.linalg.norm(np.subtract(*roots)) > 1.0
    for place, name in ((1, "wam7"), (0, "lwr4plus")):
        window.execute_script("document.querySelectorAll('#arms button')[arguments[0]].click()", place)
        arm = lwr_dyn.load(name)
        q = np.array(window.execute_script("return lwrExplorer.positions()"))
        window.execute_script("lwrExplorer.state.compute()")
        g = window.execute_script("return Array.from(lwrExplorer.torques.g)")
        np.testing.assert_allclose(g, lwr_dyn.dynamics_of(arm).gravity_vector(q), rtol=0, atol=1e-8)
        assert window.execute_script("return document.querySelectorAll('#sliders .joint').length") == arm.n
    assert violations(window) == []
    assert logs(window)[1] == []


@pytest.mark.parametrize("pointer", ["mouse", "touch"])
def test_a_click_on_the_other_arm_makes_it_the_active_one(window, pointer):
    window.execute_script("lwrExplorer.choose(0); lwrExplorer.fit()")
    foot = """const {stage, shown, active} = lwrExplorer, {camera, canvas} = stage.viewer, other = shown[1 - active];
        camera.updateMatrixWorld(); stage.scene().updateMatrixWorld(true);
        const {root, chain} = other.run, at = stage.node(root).getWorldPosition(new THREE.Vector3());
        const pane = canvas.getBoundingClientRect(), box = new THREE.Box3().setFromObject(stage.node(chain[0]));
        at.setY(box.min.y + 0.05).project(camera);
        return [pane.left + ((at.x + 1) * pane.width) / 2, pane.top + ((1 - at.y) * pane.height) / 2]"""
    for active in (1, 0):
        pulled(window, pointer, *window.execute_script(foot), 0, 0)
        assert window.execute_script("return lwrExplorer.active") == active
    pulled(window, pointer, *window.execute_script(foot), 30, 5)  # a drag turns the view
    assert window.execute_script("return lwrExplorer.active") == 0


def test_a_link_names_the_arm_that_was_active(window):
    coupled(window, "none")
    window.execute_script("lwrExplorer.choose(1); lwrExplorer.setPose(arguments[0])", (0.5 * Q).tolist())
    link = window.execute_script("return lwrExplorer.poseCopy.text('link', explorerState.q)")
    for bad in ("&arm=7", "&arm=x"):
        window.execute_script("location.hash = arguments[0]", link.split("#")[1].split("&")[0] + bad)
        window.execute_async_script("setTimeout(arguments[0], 50)")
        assert "not one of this arm" in window.execute_script("return document.getElementById('copied').textContent")
    window.execute_script("lwrExplorer.choose(0); location.hash = arguments[0]", link.split("#")[1])
    window.execute_async_script("setTimeout(arguments[0], 50)")
    for reopened in (False, True):
        if reopened:
            opened(window, link)
        active, q = window.execute_script("return [lwrExplorer.active, lwrExplorer.positions()]")
        assert active == 1
        np.testing.assert_allclose(q, 0.5 * Q, rtol=0, atol=1e-10)
    window.execute_script("lwrExplorer.choose(0)")


def test_by_itself_the_other_arm_stays(window):
    before = coupled(window, "none")
    after = coupled(window, "none", -Q)
    assert before[1] == after[1]
    assert np.abs(np.subtract(before[0][0], after[0][0])).max() > 0.1


def test_the_same_joint_positions_within_its_limits(window):
    wam = lwr_dyn.load("wam7")
    for q in (Q, np.array([2.9, 0.5, 0.1, 0.4, 0.3, 1.9, 0.0])):
        _, (other, pose) = coupled(window, "joints", q)
        np.testing.assert_allclose(other, q.clip(wam.lower, wam.upper), rtol=0, atol=1e-9)
        np.testing.assert_allclose(pose, lwr_dyn.forward_kinematics(wam, other), rtol=0, atol=1e-8)
        word = window.execute_script("return lwrExplorer.sides.word.textContent")
        assert (word != "") == bool(np.abs(np.array(other) - q).max() > 1e-6)


def test_the_same_flange_pose_or_it_says_that_it_does_not_get_there(window):
    (_, mine), (other, its) = coupled(window, "pose")
    np.testing.assert_allclose(its, mine, rtol=0, atol=FOLLOWED)
    assert np.abs(np.subtract(other, Q)).max() > 0.1
    window.execute_script("lwrExplorer.choose(1)")
    (stays, _), _ = coupled(window, "pose", np.array([0.0, 1.57, 0.0, 0.0, 0.0, 0.0, 0.0]))
    assert "lwr4plus does not get there" in window.execute_script("return lwrExplorer.sides.word.textContent")
    np.testing.assert_allclose(stays, Q, rtol=0, atol=1e-9)
    window.execute_script("lwrExplorer.choose(0)")


def test_the_table_is_that_of_python(window):
    found = coupled(window, "none")
    for place, name in enumerate(("lwr4plus", "wam7")):
        arm, q, said = lwr_dyn.load(name), np.array(found[place][0]), column(window, place)
        pose, jacobian = flange_and_jacobian(arm)(q)
        g = np.abs(lwr_dyn.dynamics_of(arm).gravity_vector(q))
        numbers = {key: [float(x) for x in re.findall(r"-?[\d.]+(?:e-?\d+)?", text)] for key, text in said.items()}
        assert numbers["mass"][0] == pytest.approx(sum(body.mass for body in arm.bodies()), abs=6e-4)
        assert numbers["flange"] == pytest.approx(pose[:3, 3], abs=6e-4)
        assert numbers["torque"] == pytest.approx([g.max(), g.argmax() + 1], abs=6e-3)
        shares = g / arm.effort
        assert numbers["share"] == pytest.approx([100 * shares.max(), shares.argmax() + 1], abs=6e-2)
        assert numbers["manipulability"][0] == pytest.approx(np.prod(np.linalg.svd(jacobian[:3])[1]), rel=1e-3)
        assert numbers["reach"][0] == pytest.approx(reach(arm), abs=FOUND)


def test_arms_of_other_joints_and_without_masses_stand_too(browser, tmp_path):
    window = page(browser, tmp_path, "lwr4 printed", "kr30ha kuka")
    ways = window.execute_script("return lwrExplorer.sides.buttons.map(({dataset}) => dataset.how)")
    assert ways == ["none", "pose"]
    for place in (1, 0):
        window.execute_script("lwrExplorer.choose(arguments[0]); lwrExplorer.state.compute()", place)
    assert [column(window, k)["mass"] for k in range(2)] == ["unknown", "464.040 kg"]
    assert logs(window)[1] == []
