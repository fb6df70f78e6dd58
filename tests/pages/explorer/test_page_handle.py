"""The flange's handle: arrows that a mouse or a finger pulls, on the LWR 4+ and on arms of few joints."""

import numpy as np
import pytest

import lwr_dyn
from tests.headless import logs
from tests.pages.explorer.by_hand import arrow, pulled
from tests.pages.explorer.explored import SHARE, opened

pytestmark = pytest.mark.slow

SHOWN = "lwr4plus computed"
Q = [0.3, 0.7, 0.2, -1.4, 0.3, 0.9, 0.1]
FOLLOWED = 1e-6
"""[m] that the flange may be from where it is dragged."""


def flange(window):
    return np.array(window.execute_script("lwrExplorer.state.compute(); return lwrExplorer.flangePose()"))


def begin(window):
    window.execute_script(
        "const e = lwrExplorer; e.setPose(arguments[0]); e.state.compute(); e.stage.frameView(); e.stage.viewer.draw()",
        Q,
    )
    return flange(window)


@pytest.mark.parametrize("pointer", ["mouse", "touch"])
def test_an_arrow_is_pulled_along_its_axis(window, pointer):
    before = begin(window)
    pulled(window, pointer, *arrow(window, 0), 20, -15)
    after = flange(window)
    np.testing.assert_allclose(after[:3, :3], before[:3, :3], rtol=0, atol=1e-9)
    moved = before[:3, :3].T @ (after - before)[:3, 3]
    assert abs(moved[0]) > 0.005
    np.testing.assert_allclose(moved[1:], 0, atol=FOLLOWED)
    handle = window.execute_script("return lwrExplorer.flangeDrag.handle.position.toArray()")
    np.testing.assert_allclose(handle, after[:3, 3], rtol=0, atol=FOLLOWED)


@pytest.mark.parametrize(("first", "second"), [(0, 1), (1, 2), (2, 0)])
def test_a_finger_on_another_arrow_does_not_make_the_flange_jump(window, first, second):
    """three.js issue 31280: the plane of the arrow before was used."""
    begin(window)
    pulled(window, "touch", *arrow(window, first), 4, -4)
    by_finger = [flange(window)]
    for pointer in ("touch", "mouse"):
        before = begin(window)
        pulled(window, pointer, *arrow(window, second), 6, 5)
        by_finger.append(before[:3, :3].T @ (flange(window) - before)[:3, 3])
    np.testing.assert_allclose(by_finger[1], by_finger[2], rtol=0, atol=1e-3)


DRAGGED = """const e = lwrExplorer, { flangeDrag: drag } = e;
    e.setPose(arguments[0]); e.state.compute(); drag.begin();
    drag.handle.position.add(new THREE.Vector3(...arguments[1]));
    const found = drag.moved(), asked = drag.handle.position.toArray(); drag.end();
    return [found, asked, e.flangePose().map((row) => row[3]).slice(0, 3), drag.word.textContent]"""


def test_an_arm_of_few_joints_goes_as_near_as_it_gets(browser, page_of):
    arm = lwr_dyn.load(SHARE / "double_pendulum_description/urdf/double_pendulum_continuous.urdf")
    window = opened(browser, page_of(arm).as_uri())
    q = np.array([0.3, 0.4])
    begun = lwr_dyn.forward_kinematics(arm, q)[:3, 3]
    nearby = lwr_dyn.forward_kinematics(arm, np.add(q, [0.05, -0.07]))[:3, 3]
    found, asked, reached, word = window.execute_script(DRAGGED, q.tolist(), (nearby - begun).tolist())
    assert (found, word) == (0, "")
    np.testing.assert_allclose(reached, asked, rtol=0, atol=FOLLOWED)
    places = lwr_dyn.forward_kinematics(arm, np.random.default_rng(1).uniform(-1, 1, (50, 2)))[:, :3, 3]
    side = 0.1 * np.eye(3)[np.ptp(places, axis=0).argmin()]  # across the plane in which it moves
    found, asked, reached, word = window.execute_script(DRAGGED, q.tolist(), (nearby - begun + side).tolist())
    assert (found, word) == (4, "as near as the arm gets")
    np.testing.assert_allclose(np.subtract(asked, reached), side, atol=1e-4)


def test_a_long_arm_is_dragged_and_has_no_torques(browser, tmp_path, page_of):
    joints = 12
    limit = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'
    links = "".join(f'<link name="l{i}"/>' for i in range(joints + 1))
    turns = "".join(
        f'<joint name="j{i}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/><origin xyz="0.02 0 0.1"/>'
        f'<axis xyz="{"0 0 1" if i % 2 else "0 1 0"}"/>{limit}</joint>'
        for i in range(joints)
    )
    (tmp_path / "long.urdf").write_text(f'<robot name="long">{links}{turns}</robot>', encoding="utf-8")
    window = opened(browser, page_of(lwr_dyn.load(tmp_path / "long.urdf")).as_uri())
    q = np.linspace(-0.5, 0.8, joints)
    found, asked, reached, _ = window.execute_script(DRAGGED, q.tolist(), [0.03, -0.02, 0.01])
    assert found == 0
    np.testing.assert_allclose(reached, asked, rtol=0, atol=FOLLOWED)
    assert window.execute_script("return [lwrExplorer.torques, lwrExplorer.robot.inverse_dynamics]") == [None, None]
    assert window.execute_script("return lwrExplorer.jacobian.J.length") == 6 * joints
    assert logs(browser)[1] == []
