"""The list of arms of a page, in headless Chromium: panels, tables and drawing are those of the chosen arm."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.codegen.kernels import kernel
from lwr_dyn.model.chain import with_payload
from lwr_dyn.pages.explorer.arm_html import link_columns
from lwr_dyn.pages.explorer.page import write_explorer
from lwr_dyn.pages.explorer.page_data import beside_each_other, readings_shown, shown_records
from tests.headless import logs
from tests.pages.explorer.explored import explored_arm, opened

SHOWN = "lwr4plus physical"
READINGS = ("physical", "printed", "computed")
AGREES = 1e-12
"""Of the largest number."""
Q = np.array([0.3, -0.4, 0.5, 0.9, -0.2, 0.7, 0.1])
DQ, DDQ = np.linspace(-1, 1, 7), np.linspace(2, -1, 7)


def chosen(window, index):
    window.execute_script("document.querySelectorAll('#arms button')[arguments[0]].click()", index)


def test_readings_share_what_is_drawn_unless_their_kinematics_differ():
    for robot, runs in (("lwr4plus", [0, 0, 0]), ("kr30ha", [0, 1])):
        shown = readings_shown(lwr_dyn.load(robot))
        records = shown_records(shown, [0] * len(shown))
        assert [record["run"] for record in records["arms"]] == runs
        assert len(records["stage"]["runs"]) == max(runs) + 1
        assert len({record["label"] for record in records["arms"]}) == len(runs)


def test_a_mounted_arm_has_its_readings_mounted():
    arm = lwr_dyn.load("lwr4plus", "printed", mount="ceiling", tool={"mass": 2.0})
    for each in readings_shown(arm):
        np.testing.assert_allclose(each.arm.chain.gravity, arm.chain.gravity)
    masses = [each.arm.bodies()[-1].mass for each in readings_shown(arm)]
    assert min(masses) > 2.0


def test_arms_beside_each_other_have_other_labels():
    lwr, wam, printed = (lwr_dyn.load(*name) for name in (("lwr4plus",), ("wam7",), ("lwr4plus", "printed")))
    labels = [[each.label for each in beside_each_other(lwr, other)] for other in (wam, printed, lwr)]
    assert labels[0] == ["lwr4plus", "wam7"]
    assert labels[1] == ["lwr4plus physical", "lwr4plus printed"]
    assert len(set(labels[2])) == 2


@pytest.mark.slow
@pytest.mark.parametrize("index", [1, 2, 0])
def test_numbers_are_those_of_the_chosen_reading(window, index):
    chosen(window, index)
    arm = lwr_dyn.load("lwr4plus", READINGS[index])
    dynamics = lwr_dyn.dynamics_of(arm)
    found = window.execute_script(
        """const [q, dq, ddq] = arguments, { robot } = lwrExplorer;
        return [robot.gravity_vector(q), robot.mass_matrix(q), robot.coriolis_matrix(q, dq),
          robot.inverse_dynamics(q, dq, ddq)].map((x) => Array.from(x))""",
        *(x.tolist() for x in (Q, DQ, DDQ)),
    )
    expected = (
        dynamics.gravity_vector(Q),
        dynamics.mass_matrix(Q),
        dynamics.coriolis_matrix(Q, DQ),
        dynamics.inverse_dynamics(Q, DQ, DDQ),
    )
    for mine, python in zip(found, expected, strict=True):
        assert np.abs(np.array(mine) - python.ravel()).max() <= AGREES * np.abs(python).max()
    text = window.execute_script("return document.getElementById('links').innerText")
    assert all(cell.text in text for column in link_columns(arm) for cell in column.cells)
    name = window.execute_script("return document.getElementById('arm-name').textContent")
    assert name == f"lwr4plus, reading {READINGS[index]}"


@pytest.mark.slow
def test_pose_speeds_switches_and_payload_stay_and_nothing_is_left_over(window):
    window.execute_script(
        """lwrExplorer.setPose(arguments[0]); explorerState.set({dq: arguments[1]}); lwrExplorer.carry(2, [0, 0, 0.1]);
        document.getElementById("frames").click(); document.getElementById("velocity-ellipsoid").click();""",
        Q.tolist(),
        DQ.tolist(),
    )
    count = """return [document.querySelectorAll("#panels > section").length,
        document.querySelectorAll("#switches input").length, lwrExplorer.stage.viewer.world.children.length,
        (() => { let n = 0; lwrExplorer.stage.scene().traverse(() => { n += 1; }); return n; })()]"""
    before = window.execute_script(count)
    for index in (1, 2, 1, 0):
        chosen(window, index)
    window.execute_script("lwrExplorer.state.compute()")
    assert window.execute_script(count) == before
    assert np.abs(np.array(window.execute_script("return lwrExplorer.positions()")) - Q).max() < 1e-10
    assert window.execute_script("return Array.from(explorerState.dq)") == DQ.tolist()
    on = "return ['frames', 'velocity-ellipsoid'].map((id) => document.getElementById(id).checked)"
    assert window.execute_script(on) == [True, True]
    loaded = lwr_dyn.load("lwr4plus", tool={"xyz": [0, 0, 0], "mass": 2.0, "com": [0.0, 0.0, 0.1]})
    stale = """const before = lwrExplorer.torques; let asked = 0;
        lwrExplorer.choose(1); before.compute = () => { asked += 1; }; lwrExplorer.state.compute();
        lwrExplorer.choose(0); lwrExplorer.state.compute(); return asked"""
    assert window.execute_script(stale) == 0
    found = window.execute_script("return Array.from(lwrExplorer.torques.g)")
    np.testing.assert_allclose(found, lwr_dyn.dynamics_of(loaded).gravity_vector(Q), rtol=0, atol=1e-8)
    window.execute_script("lwrExplorer.carry(0, [0, 0, 0]); document.getElementById('velocity-ellipsoid').click()")


@pytest.mark.slow
def test_what_a_reading_changes_is_listed_and_added_up(window):
    chosen(window, 0)
    window.execute_script("lwrExplorer.compare(lwrExplorer.arms[2]); lwrExplorer.setPose(arguments[0])", Q.tolist())
    chosen(window, 1)
    chosen(window, 0)
    listed = window.execute_script("return lwrExplorer.others.numbers()")
    heads = window.execute_script(
        "return [...document.querySelectorAll('.numbers thead th')].map((head) => head.textContent)"
    )
    assert heads == window.execute_script(
        "return [lwrExplorer.arms[lwrExplorer.active], lwrExplorer.compared].map(({ label }) => label)"
    )
    arms = [lwr_dyn.load("lwr4plus", READINGS[k]) for k in (0, 2)]
    texts = [
        [cell.text for column in link_columns(arm) for cell in column.cells] for arm in arms
    ]  # fmt: skip
    differing = sum(a != b for a, b in zip(*texts, strict=True))
    assert len([row for row in listed if row[0].startswith("link") and "xx, yy" not in row[0]]) == differing > 0
    assert len([row for row in listed if "rotor inertia" in row[0]]) == 7
    slips = window.execute_script("return [...document.querySelectorAll('.slips summary')].map((s) => s.textContent)")
    assert len(slips) == 2
    assert all("put right in physical alone" in slip for slip in slips)
    assert logs(window)[1] == []


@pytest.mark.slow
def test_readings_with_other_kinematics_are_drawn_and_move_by_their_own(browser, page_of):
    window = opened(browser, page_of("kr30ha kuka").as_uri())
    q = [0.2, -1.2, 1.1, 0.3, 0.4, 0.5]
    for index, reading in ((1, "printed"), (0, "kuka")):
        chosen(window, index)
        window.execute_script("lwrExplorer.setPose(arguments[0])", q)
        T = lwr_dyn.forward_kinematics(lwr_dyn.load("kr30ha", reading), q)
        np.testing.assert_allclose(window.execute_script("return lwrExplorer.drawnPose()"), T, rtol=0, atol=1e-9)
        seen = window.execute_script(
            "return lwrExplorer.stage.runs.map(({root}) => lwrExplorer.stage.node(root).visible)"
        )
        assert seen == [k == index for k in range(2)]
        left = """const {stage} = lwrExplorer; let parts = 0;
            stage.node(stage.runs[arguments[0]].root).traverse((part) => { parts += part.userData.added ? 1 : 0; });
            return parts"""
        assert [window.execute_script(left, k) > 0 for k in range(2)] == seen
    assert logs(window)[1] == []


@pytest.mark.slow
def test_a_payload_is_carried_in_the_frame_of_the_flange(browser, page_of):
    arm, window = explored_arm("hung"), opened(browser, page_of("hung").as_uri())
    mass, at = 2.5, [0.03, -0.02, 0.1]
    q = np.clip(np.linspace(-0.9, 0.8, arm.n), arm.lower, arm.upper)
    window.execute_script("lwrExplorer.carry(arguments[0], arguments[1])", mass, at)
    script = "return Array.from(lwrExplorer.robot.inverse_dynamics(...arguments))"
    found = window.execute_script(script, *[q.tolist()] * 3)
    loaded = arm.with_chain(with_payload(arm.chain, mass, at))
    expected = lwr_dyn.dynamics_of(loaded).inverse_dynamics(q, q, q)
    assert np.abs(np.array(found) - expected).max() <= AGREES * np.abs(expected).max()


@pytest.mark.slow
def test_readings_can_be_chosen_on_a_page_that_does_not_compute(browser, tmp_path, monkeypatch):
    find = kernel.find_spec
    monkeypatch.setattr(kernel, "find_spec", lambda name: None if name == "casadi" else find(name))
    write_explorer(tmp_path / "arm.html", lwr_dyn.load("lwr4plus"))
    window = opened(browser, (tmp_path / "arm.html").as_uri())
    chosen(window, 2)
    arm = lwr_dyn.load("lwr4plus", READINGS[2])
    text = window.execute_script("return document.getElementById('links').innerText")
    assert all(cell.text in text for column in link_columns(arm) for cell in column.cells)
    assert window.execute_script("return [lwrExplorer.robot, lwrExplorer.torques ?? null]") == [None, None]
    assert logs(window)[1] == []
