"""The page that computes: the flange and links are dragged, branches and arm angles chosen."""

import gzip
import hashlib
from importlib.resources import files

import numpy as np
import pytest
from selenium.webdriver.support.ui import WebDriverWait

import lwr_dyn
from lwr_dyn.pages.explorer import page as computing
from lwr_dyn.pages.explorer.page import BUNDLE, explorer_html, functions_script, three_bundle
from tests.headless import logs
from tests.pages.explorer.by_hand import pulled
from tests.pages.explorer.explored import opened
from tests.pages.replay.driven import without_webgl

SHOWN = "lwr4plus computed"
FOLLOWED = 1e-6
"""[m] that the flange may be from where it is dragged."""
LARGEST, LARGEST_ZIPPED = 1_000_000, 320_000
Q = [0.3, 0.7, 0.2, -1.4, 0.3, 0.9, 0.1]
START = "const e = lwrExplorer; e.setPose(arguments[0]); e.state.compute();"
DRAG = f"""{START} const drag = e.flangeDrag; drag.begin();
    ["x", "y", "z"].forEach((axis, k) => {{ drag.handle.position[axis] += arguments[1][k]; }});
    const found = drag.moved(), asked = drag.handle.position.toArray(); drag.end();
    return [found, asked, e.flangePose().slice(0, 3).map((row) => row[3]), e.positions(), drag.word.textContent]"""


def test_the_bundle_is_the_one_of_its_digest_and_carries_its_licence():
    digest = files("lwr_dyn.pages.explorer").joinpath("bundle/three.sha256").read_text(encoding="utf-8").split()[0]
    assert hashlib.sha256(three_bundle().encode()).hexdigest() == digest
    assert "The MIT License" in three_bundle()[:300]
    assert BUNDLE.endswith(".js")


@pytest.mark.slow
def test_a_page_keeps_its_size(page):
    data = page.read_bytes()
    assert len(data) < LARGEST
    assert len(gzip.compress(data)) < LARGEST_ZIPPED


@pytest.mark.slow
def test_out_of_reach_is_a_wall(window):
    found, _, reached, q, word = window.execute_script(DRAG, Q, [3.0, 0.0, 0.0])
    assert (found, word) == (3, "out of reach")
    start = lwr_dyn.forward_kinematics(lwr_dyn.load("lwr4plus"), np.array(Q))[:3, 3]
    x, y, z = np.subtract(reached, start)
    assert x > 0.05  # it went as far as it gets on the straight way
    np.testing.assert_allclose([y, z], 0, atol=FOLLOWED)
    further, *_ = window.execute_script(DRAG, q, [1e-4, 0.0, 0.0])
    assert further in (1, 2, 3)  # the end of the way, or of what this arm angle allows


@pytest.mark.slow
@pytest.mark.parametrize("pointer", ["mouse", "touch"])
def test_a_dragged_link_turns_its_joint_alone(browser, page, pointer):
    window = opened(browser, page.as_uri())
    where = window.execute_script(
        f"""{START} e.stage.frameView(); e.flangeDrag.controls.detach();
        const canvas = e.stage.viewer.canvas.getBoundingClientRect();
        for (let y = canvas.top; y < canvas.bottom; y += 4) for (let x = canvas.left; x < canvas.right; x += 4) {{
          const hit = e.linkDrag.hit(x, y);
          if (hit && hit.joint === 3) return [x, y];
        }}""",
        Q,
    )
    pulled(window, pointer, *where, 9, 12)
    moved = np.abs(np.subtract(window.execute_script("return lwrExplorer.positions()"), Q)) > 1e-6
    assert moved.tolist() == [False, False, False, True, False, False, False]


@pytest.mark.slow
def test_keys_turn_a_joint_and_move_the_flange(window):
    press = """lwrExplorer.stage.pane.dispatchEvent(new KeyboardEvent("keydown", {key: arguments[1], shiftKey: false}));
        lwrExplorer.state.compute();"""
    window.execute_script(START, Q)
    for key in ("2", "ArrowRight"):
        window.execute_script(press, Q, key)
    q = window.execute_script("return lwrExplorer.positions()")
    np.testing.assert_allclose(np.subtract(q, Q), np.radians([0, 1, 0, 0, 0, 0, 0]), atol=1e-10)
    before = window.execute_script("return lwrExplorer.flangePose()")
    after = window.execute_script(f"{press} return lwrExplorer.flangePose()", Q, "z")
    np.testing.assert_allclose(np.subtract(after, before)[:3, 3], [0, 0, 0.005], atol=FOLLOWED)


@pytest.mark.slow
def test_the_strip_moves_the_elbow_and_keeps_the_flange_and_the_limits(window):
    arm = lwr_dyn.load("lwr4plus")
    rows = window.execute_script(
        f"""{START} const {{ strip }} = e, out = [];
        const before = e.flangePose();
        for (let k = -35; k <= 35; k += 1) {{
          const psi = (k * Math.PI) / 36, free = [];
          for (let j = 0; j < strip.counts[strip.branch]; j += 1) {{
            const at = 32 * strip.branch + 2 * j;
            free.push([strip.ends[at], strip.ends[at + 1]]);
          }}
          const went = strip.go(strip.branch, psi);
          out.push([psi, free, went, e.positions(), e.flangePose()]);
        }}
        return [before, out]""",
        Q,
    )
    before, found = rows
    went = [row[2] for row in found]
    for psi, free, reached, q, pose in found:
        inside = any(low <= x <= up for low, up in free for x in (psi, psi + 2 * np.pi))
        assert inside == reached
        assert ((arm.lower - 1e-9 <= q) & (q <= arm.upper + 1e-9)).all()
        np.testing.assert_allclose(pose, before, rtol=0, atol=1e-9)
    assert any(went)
    assert not all(went)


@pytest.mark.slow
def test_without_webgl_the_page_says_so_and_computes(browser, page):
    browser.get("about:blank")
    with without_webgl(browser):
        window = opened(browser, page.as_uri())
        assert "draws no WebGL" in window.execute_script("return document.getElementById('no-webgl').textContent")
        _, asked, reached, _, _ = window.execute_script(DRAG, Q, [0.02, -0.03, 0.01])
        np.testing.assert_allclose(reached, asked, rtol=0, atol=FOLLOWED)
        assert window.execute_script("return document.querySelectorAll('#joints .n').length > 0")
        window.execute_script("document.querySelectorAll('#switches input').forEach((box) => box.click())")
        WebDriverWait(window, 100).until(lambda w: w.execute_script("return lwrExplorer.section.drawn"))
        slide = "const s = document.getElementById('slider_1'); s.value = 30; s.dispatchEvent(new Event('input'));"
        window.execute_script(slide)
        np.testing.assert_allclose(window.execute_script("return lwrExplorer.positions()[0]"), np.radians(30))
        window.execute_script("lwrExplorer.choose(1)")
        (said,) = logs(browser)[1]
        assert "Error creating WebGL context" in said  # three.js says so itself, nothing else is said


def test_what_cannot_be_computed_is_said(monkeypatch):
    arm = lwr_dyn.load("lwr4plus")
    monkeypatch.setattr(computing, "MOST_JOINTS", 6)
    script, why = functions_script(arm, "robot")
    assert why == "torques are computed for arms of at most 6 joints; this one has 7"
    assert "jacobian" in script
    assert "inverse_dynamics" not in script
    text = explorer_html(arm)
    assert why in text
    assert "class FlangeDrag" in text
