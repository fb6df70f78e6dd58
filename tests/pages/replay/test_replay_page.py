"""The one-file page in headless Chromium, without a network; what is in it: `test_page_content.py`."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.look import tokens
from tests.axe import SCREENS, faint_texts, seen, sideways, violations
from tests.headless import opened, screenshot, waiting
from tests.pages.replay.driven import traffic

POSE = 1e-6
"""[m], and the same for rotation entries: largest difference between the pose on the page and FK."""


@pytest.fixture(scope="module")
def page(tmp_path_factory, arm, two_runs):
    path = tmp_path_factory.mktemp("page") / "replay.html"
    replay_page.write_replay(path, two_runs, arm)
    return path


@pytest.fixture(scope="module")
def window(browser, page):
    opened(browser, page.as_uri())
    return browser


@pytest.mark.slow
def test_page_loads_nothing_and_logs_nothing(window, page):
    # The module's first look at the page: the logs start before it was opened.
    assert traffic(window) == ([page.as_uri()], [])


@pytest.mark.slow
@pytest.mark.parametrize("k", [0, 1235, 3000])
@pytest.mark.parametrize("run", [0, 1])
def test_pose_on_the_page_is_forward_kinematics(window, arm, two_runs, run, k):
    pose = window.execute_script(
        "lwrReplay.setTime(arguments[0]); return lwrReplay.flangePose(arguments[1])", two_runs[run].t[k], run
    )
    np.testing.assert_allclose(pose, lwr_dyn.forward_kinematics(arm, two_runs[run].q[k]), rtol=0, atol=POSE)


@pytest.mark.slow
def test_side_by_side_and_back_leave_the_pose(window, arm, two_runs):
    poses = window.execute_script(
        """lwrReplay.setTime(2); const box = document.getElementById("beside"), poses = [];
        for (let i = 0; i < 2; i += 1) { box.click(); poses.push(lwrReplay.flangePose(1)); }
        return poses"""
    )
    for pose in poses:
        np.testing.assert_allclose(pose, lwr_dyn.forward_kinematics(arm, two_runs[1].q[1000]), rtol=0, atol=POSE)


@pytest.mark.slow
def test_target_and_triads_stand_where_the_chain_puts_them(window, arm, two_runs):
    from lwr_dyn.kinematics.forward import frames

    found = window.execute_script(
        """lwrReplay.setTime(2); const stage = lwrReplay.stage, run = stage.runs[0];
        const base = stage.node(run.root);
        return [run.root.concat("target"), ...run.triads].map((path) => {
          const node = stage.node(path);
          node.updateWorldMatrix(true, false);
          return base.matrixWorld.clone().invert().multiply(node.matrixWorld).elements;
        })"""
    )
    target, *triads = (np.array(elements).reshape(4, 4).T for elements in found)
    np.testing.assert_allclose(target, lwr_dyn.forward_kinematics(arm, two_runs[0].q_ref[1000]), rtol=0, atol=POSE)
    native = [np.eye(4), *frames(arm.chain, two_runs[0].q[1000])[:-1]]
    np.testing.assert_allclose(triads, native, rtol=0, atol=POSE)


@pytest.mark.slow
def test_play_moves_time_and_pause_holds_it(window):
    window.execute_script("lwrReplay.setTime(0); document.getElementById('play').click()")
    waiting(window, 60).until(lambda w: w.execute_script("return lwrReplay.time() > 0.1"))
    window.execute_script("document.getElementById('play').click()")
    before, after = window.execute_async_script(
        "const t = lwrReplay.time(); setTimeout(() => arguments[0]([t, lwrReplay.time()]), 200)"
    )
    assert before == after > 0.1


@pytest.mark.slow
def test_speed_and_end_of_play(window, two_runs):
    window.execute_script("document.getElementById('speed').value = '4'; lwrReplay.setTime(5.8); lwrReplay.play()")
    waiting(window, 60).until(lambda w: not w.execute_script("return lwrReplay.playing()"))
    assert window.execute_script("return lwrReplay.time()") == two_runs[0].t[-1]


def test_trace_grows_with_time_and_the_readout_is_the_tip_error(window, arm, two_runs):
    counts, texts = [], []
    for k in (0, 1500, 3000):
        count, text = window.execute_script(
            """lwrReplay.setTime(arguments[0]); const tube = lwrReplay.stage.runs[0].traceTube;
            return [tube.geometry.drawRange.count, document.querySelector(".numbers b").textContent]""",
            two_runs[0].t[k],
        )
        counts.append(count)
        texts.append(text)
    assert counts[0] == 0 < counts[1] < counts[2]
    shown = replay_page.replayed_runs(two_runs, arm)[0]
    assert float(texts[1].split()[0]) == pytest.approx(1e3 * shown.tip_error[1500], rel=5e-3)  # three digits shown


@pytest.mark.slow
def test_switches_hide_and_show(window):
    for name, part in (
        ("reference", "reference"),
        ("trace", "trace"),
        ("target", "target"),
        ("frames", "link_0/frame"),
    ):
        states = window.execute_script(
            """const [id, part] = arguments, path = ["arms", "run_0", ...part.split("/")];
            const seen = () => { document.getElementById(id).click(); return lwrReplay.stage.node(path).visible; };
            return [seen(), seen()]""",
            name,
            part,
        )
        assert sorted(states) == [False, True], name


def test_scrub_bar_and_strip_set_the_time(window):
    window.execute_script(
        """const bar = document.getElementById("scrub"); bar.value = 3.25; bar.dispatchEvent(new Event("input"))"""
    )
    assert window.execute_script("return lwrReplay.time()") == pytest.approx(3.25)
    assert window.find_element("id", "clock").text == "3.250 / 6.000 s"


@pytest.mark.slow
@pytest.mark.parametrize(("width", "dark"), SCREENS)
def test_page_is_accessible_and_fits_every_screen_in_both_schemes(window, width, dark):
    with seen(window, width, dark):
        screenshot(window, f"replay_{width}{'_dark' * dark}.png")
        assert violations(window) == []
        assert faint_texts(window) == []
        assert sideways(window) == 0
        sky, worn = window.execute_script(
            """const tokens = new Set();
            lwrReplay.stage.scene().traverse((part) => {
              const token = part.userData.token;
              if (token && part.material.color.getStyle().replace(/,(?! )/g, ", ") !== ink(token)) tokens.add(token);
            });
            return [ink("sky"), [...tokens]]"""
        )
        assert worn == []
        assert sky == "rgb({}, {}, {})".format(*bytes.fromhex(tokens(dark)["sky"][1:]))


@pytest.mark.slow
def test_on_a_phone_nothing_covers_the_arm(window):
    with seen(window, 420):
        boxes = window.execute_script(
            """return ["stage", "side", "bar"].map((id) => {
              const box = document.getElementById(id).getBoundingClientRect();
              return [box.top, box.bottom];
            })"""
        )
        assert boxes[0][0] == 0
        assert [boxes[i][1] <= boxes[i + 1][0] + 0.5 for i in (0, 1)] == [True, True]
        assert boxes[2][1] <= 1000.5
        assert boxes[0][1] >= 0.4 * 1000
        assert not window.find_element("id", "shown").get_property("open")
    assert window.find_element("id", "shown").get_property("open")


def test_overlaid_arms_are_grey_ghosts_with_the_bands_of_their_run(window):
    worn = window.execute_script(
        """const stage = lwrReplay.stage;
        return stage.runs.map((run) => {
          const found = new Set();
          stage.node(run.chain[0]).traverse((part) => {
            if (part.isMesh && part.renderOrder === 0) found.add(`${part.userData.token} ${part.material.opacity}`);
          });
          return [...found].sort();
        })"""
    )
    assert worn == [
        ["housing 1", "joint 1", "limb 1", "run2 1"],
        ["housing 0.25", "joint 0.25", "limb 0.25", "run1 0.8"],
    ]


def test_page_is_whole_at_the_end(window):
    window.execute_script("lwrReplay.setTime(4.2)")
    screenshot(window, "overlaid.png")
    window.execute_script("document.getElementById('beside').click(); document.getElementById('frames').click()")
    screenshot(window, "beside_frames.png")
    window.execute_script("document.getElementById('beside').click(); document.getElementById('frames').click()")
    assert traffic(window, "file:") == ([], [])  # one may load it again


def test_the_footer_says_how_many_samples_the_page_holds(window):
    assert "601 of 3001 samples (100 Hz)" in window.find_element("id", "generator").text
