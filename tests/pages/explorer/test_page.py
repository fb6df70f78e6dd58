"""The explorer's page in headless Chromium without a network: it loads alone, sliders pose the arm, axe is content."""

import json

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.kinematics.forward import frames
from lwr_dyn.pages.explorer.page import explorer_html, three_bundle
from tests.axe import SCREENS, seen, sideways, violations
from tests.headless import logs, screenshot
from tests.pages.explorer.explored import explored_arm, opened
from tests.pages.replay.driven import traffic
from tests.tolerances import METRES

SHOWN = "wam7 manual"
LARGEST_PAGE = 380_000
"""Bytes without three.js (609 kB), 82 kB of them fonts; with it at most 1 MB, see `test_page_computing`."""
DRAWN = 1e-9
"""[m] three.js composes the same poses from the same numbers."""
Q = np.array([0.3, -0.4, 0.5, 0.9, -0.2, 0.7, 0.1])


@pytest.fixture(scope="module")
def wam():
    return explored_arm(SHOWN)


def slide(window, joint, value):
    """Move a slider as a hand does."""
    window.execute_script(
        """const slider = document.getElementById(`slider_${arguments[0]}`); slider.value = arguments[1];
        slider.dispatchEvent(new Event("input"));""",
        joint,
        value,
    )


def write(window, joint, text):
    """Write into a field as a hand does."""
    window.execute_script(
        """const field = document.getElementById(`value_${arguments[0]}`); field.value = arguments[1];
        field.dispatchEvent(new Event("change"));""",
        joint,
        text,
    )


def positions(window):
    return window.execute_script("return lwrExplorer.positions()")


@pytest.mark.slow
def test_page_asks_for_nothing_and_logs_nothing(window, page):
    # The module's first look at the page: the logs start before it was opened.
    assert traffic(window, "blob:") == ([page.as_uri()], [])


@pytest.mark.slow
def test_the_fonts_that_the_page_asks_for_are_inside_it(window):
    asked, loaded = window.execute_async_script(
        """const done = arguments[0];
        const first = (node) => getComputedStyle(node).fontFamily.split(",")[0].replace(/"/g, "");
        document.fonts.ready.then(() => {
          const texts = [...document.querySelectorAll("body *")].filter((node) => node.checkVisibility());
          const faces = [...document.fonts].filter(({ status }) => status === "loaded");
          const names = faces.map(({ family, weight }) => `${family.replace(/"/g, "")} ${weight}`);
          done([[...new Set(texts.map(first))], names]);
        });"""
    )
    assert set(asked) == {"Plex Sans", "Plex Mono"}
    assert set(loaded) == {"Plex Sans 400", "Plex Sans 600", "Plex Mono 400"}


@pytest.mark.slow
def test_sliders_set_the_pose_the_numbers_and_the_text_to_copy(window, wam):
    degrees = [10.0, -20.5, 30.0, 100.1, -50.0, 60.0, -70.7]
    for joint, value in enumerate(degrees, 1):
        slide(window, joint, value)
    T = lwr_dyn.forward_kinematics(wam, np.radians(degrees))
    assert positions(window) == np.radians(degrees).tolist()
    np.testing.assert_allclose(window.execute_script("return lwrExplorer.flangePose()"), T, rtol=0, atol=METRES)
    np.testing.assert_allclose(window.execute_script("return lwrExplorer.drawnPose()"), T, rtol=0, atol=DRAWN)
    script = "return ['x', 'y', 'z'].map((axis) => document.getElementById(`pose_${axis}`).textContent)"
    shown = [float(text) for text in window.execute_script(script)]
    np.testing.assert_allclose(shown, 1000.0 * T[:3, 3], rtol=0, atol=0.00051)
    copied = window.execute_script("return document.getElementById('q-deg').value")
    assert copied == "--q-deg=10,-20.5,30,100.1,-50,60,-70.7"
    screenshot(window, "explorer_wam7.png")


@pytest.mark.slow
def test_the_text_to_copy_poses_the_arm_in_the_command(window, lwr_dyn_command):
    script = "lwrExplorer.setPose(arguments[0]); return document.getElementById('q-deg').value"
    code, out, _ = lwr_dyn_command("fk", "wam7", window.execute_script(script, Q.tolist()), "--json")
    assert code == 0
    pose = window.execute_script("return lwrExplorer.flangePose()")
    np.testing.assert_allclose(json.loads(out)["T"], pose, rtol=0, atol=METRES)


@pytest.mark.slow
def test_sliders_and_fields_end_at_the_limits_and_words_change_nothing(window, wam):
    slide(window, 1, 1000)
    last_step = np.floor(10.0 * np.degrees(wam.upper[0])) / 10.0
    assert positions(window)[0] == pytest.approx(np.radians(last_step))
    for text in ("-1e9", "text", ""):
        write(window, 1, text)
        assert positions(window)[0] == pytest.approx(wam.lower[0])
    write(window, 1, "12,5")
    assert positions(window)[0] == np.radians(12.5)
    window.execute_script("document.getElementById('start').click()")
    assert positions(window) == [0.0] * 7
    window.execute_script("document.getElementById('random').click()")
    q = np.array(positions(window))
    assert ((wam.lower <= q) & (q <= wam.upper)).all()
    assert q.any()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["flange", "frames", "native", "centres", "ellipsoids", "limits", "gravity"])
def test_a_switch_shows_and_hides_what_it_names(window, name):
    state = """const [name] = arguments, {parts, stage} = lwrExplorer, paths = parts.paths[name];
        return [paths.map((path) => stage.node(path).visible), document.getElementById(name).checked]"""
    click = "document.getElementById(arguments[0]).click()"
    before, checked = window.execute_script(state, name)
    assert set(before) == {checked}
    window.execute_script(click, name)
    after, unchecked = window.execute_script(state, name)
    assert set(after) == {unchecked} == {not checked}
    window.execute_script(click, name)


@pytest.mark.slow
def test_centres_and_ellipsoids_are_drawn_where_the_bodies_are(window, wam):
    centres, solids = window.execute_script(
        """lwrExplorer.setPose(arguments[0]); const {parts, stage} = lwrExplorer;
        stage.scene().updateMatrixWorld(true);
        const inverse = stage.node(stage.runs[0].root).matrixWorld.clone().invert();
        const place = (path) => armKinematics.rows(inverse.clone().multiply(stage.node(path).matrixWorld).elements);
        return [parts.paths.centres.map(place), parts.paths.ellipsoids.map(place)]""",
        Q.tolist(),
    )
    drawn = np.array(centres), np.array(solids)
    rows = zip(wam.chain.links, wam.bodies(), frames(wam.chain, Q)[:-1], *drawn, strict=True)
    for link, body, pose, centre, solid in rows:
        frame = pose @ link.after.inverse().matrix()
        com = frame[:3, :3] @ body.com + frame[:3, 3]
        np.testing.assert_allclose(centre[:3, 3], com, rtol=0, atol=DRAWN)
        np.testing.assert_allclose(solid[:3, 3], com, rtol=0, atol=DRAWN)
        half = solid[:3, :3]  # of the unit ball's image the second moments of mass are m/5 half half^T
        second = body.mass / 5.0 * half @ half.T
        tensor = np.trace(second) * np.eye(3) - second
        found = frame[:3, :3].T @ tensor @ frame[:3, :3]
        np.testing.assert_allclose(found, body.inertia_com, rtol=0, atol=DRAWN)


def test_a_needle_at_the_joints_position_lies_between_marks_at_its_limits(window, wam):
    found = window.execute_script(
        """lwrExplorer.setPose(arguments[0]); const {stage} = lwrExplorer, {chain} = stage.runs[0];
        stage.scene().updateMatrixWorld(true);
        return chain.slice(1, -1).map((path, i) => {
          const range = stage.node(chain[i].concat(`range_${i + 1}`)), into = range.matrixWorld.clone().invert();
          const angles = (node) => {
            const out = [];
            node.traverse((part) => {
              const {12: x, 13: y} = into.clone().multiply(part.matrixWorld).elements;
              if (part.isMesh && Math.hypot(x, y) > 1e-6) out.push(Math.atan2(y, x));
            });
            return out;
          };
          return [...angles(stage.node(path.concat("needle"))), ...angles(range)];
        })""",
        Q.tolist(),
    )
    expected = np.exp(1j * np.column_stack([Q, wam.lower, wam.upper]))  # limits can be more than half a turn away
    np.testing.assert_allclose(np.exp(1j * np.array(found)), expected, atol=DRAWN)


def test_gravity_points_where_the_arm_says(window, wam):
    arrow = window.execute_script("return lwrExplorer.parts.arrow.map((point) => point.toArray())")
    along = np.subtract(arrow[1], arrow[0])
    np.testing.assert_allclose(along / np.linalg.norm(along), wam.chain.gravity / 9.81, atol=DRAWN)


def test_a_number_opens_its_source(window):
    assert window.execute_script(
        """const button = document.querySelector("#links .n");
        const pop = document.getElementById(button.getAttribute("popovertarget"));
        button.click();
        const found = [pop.matches(":popover-open"), pop.innerText.includes("AC-02")];
        pop.hidePopover();
        return found"""
    ) == [True, True]


@pytest.mark.slow
@pytest.mark.parametrize(("width", "dark"), SCREENS)
def test_axe_finds_nothing_and_nothing_sticks_out(window, width, dark):
    with seen(window, width, dark):
        assert violations(window) == []
        assert sideways(window) == 0
        window.execute_script("document.querySelector('#joints .n').click()")
        assert violations(window) == []
        window.execute_script("document.querySelector(':popover-open').hidePopover()")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lwr4 printed", "tiago", "hung"])
def test_pages_of_other_arms_stand_too(browser, page_of, name):
    arm, window = explored_arm(name), opened(browser, page_of(name).as_uri())
    T = lwr_dyn.forward_kinematics(arm, positions(window))
    np.testing.assert_allclose(window.execute_script("return lwrExplorer.drawnPose()"), T, rtol=0, atol=DRAWN)
    assert logs(window)[1] == []
    assert violations(window) == []


@pytest.mark.slow
def test_page_is_small_and_says_what_it_does_not_know(arm):
    text = explorer_html(arm)
    assert len(text) - len(three_bundle()) < LARGEST_PAGE
    assert "default-src 'none'" in text
    assert "limits unknown" in explorer_html(lwr_dyn.load("lwr4"))
    assert "the meshes of the file are not drawn" in explorer_html(explored_arm("panda"))
    assert "Tool centre point in world" in explorer_html(explored_arm("hung"))
