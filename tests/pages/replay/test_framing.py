"""The opening camera holds arm, paths and base in the part of the window that the panels leave, at every width."""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.pages.replay import replay_page
from tests.axe import seen
from tests.headless import opened
from tests.pages.replay.replayed import lagging_run

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]
WIDTHS = (1600, 1024, 800, 420)
FILLED = 0.7
"""Of the free part, in the direction that is tighter: an arm that is a dot in the distance is framed as badly."""
BOXES = """const { stage } = lwrReplay, { viewer } = stage, { camera } = viewer;
const pane = stage.pane.getBoundingClientRect();
const box = [Infinity, Infinity, -Infinity, -Infinity], point = new THREE.Vector3();
const hold = (part) => {
  if (!part.visible) return;
  if (part.isMesh) {
    const { position } = part.geometry.attributes;
    for (let k = 0; k < position.count; k += 1) {
      point.fromBufferAttribute(position, k).applyMatrix4(part.matrixWorld).project(camera);
      const x = pane.left + ((point.x + 1) / 2) * pane.width, y = pane.top + ((1 - point.y) / 2) * pane.height;
      [x, y].forEach((at, i) => {
        box[i] = Math.min(box[i], at);
        box[i + 2] = Math.max(box[i + 2], at);
      });
    }
  }
  part.children.forEach(hold);
};
const times = Array.from({ length: 9 }, (_, k) => (k / 8) * lwrReplay.duration);
camera.updateMatrixWorld(true);
times.forEach((t) => {
  lwrReplay.setTime(t);
  viewer.scene.updateMatrixWorld(true);
  hold(stage.node(["arms"]));
});
lwrReplay.setTime(0);
const rows = ["stage", "side", "bar"].map((id) => {
  const { left, top, right, bottom } = document.getElementById(id).getBoundingClientRect();
  return [left, top, right, bottom];
});
return [box, ...rows];"""


def arms_of(name, folder):
    """Arms that opened outside the window, or behind a panel, once; beside each other where there are several."""
    scara = folder / "scara.toml"
    page = (ROOT / "docs/tutorials/own_arm.md").read_text(encoding="utf-8")
    scara.write_text(re.search(r"```toml file=scara.toml\n(.*?)```", page, re.DOTALL)[1], encoding="utf-8")
    files = {"scara": scara, "puma": ROOT / "tests/dynamics/puma560.toml"}
    hung = lwr_dyn.load("lwr4plus", mount="ceiling") if name == "hung" else None
    return [hung or lwr_dyn.load(files.get(each, each)) for each in name.split(" + ")]


def boxes(window):
    """(left, top, right, bottom) [px] of all that is drawn of arms and paths at nine times, of stage, cards and bar."""
    return np.array(window.execute_script(BOXES))


def overlap(one, other):
    """Whether two boxes share an area."""
    return bool((np.minimum(one[2:], other[2:]) - np.maximum(one[:2], other[:2]) > 0.5).all())


@pytest.mark.parametrize("name", ["lwr4plus", "scara", "puma", "lwr4plus + lwr4plus"])
def test_arm_paths_and_base_are_in_sight_and_no_panel_covers_them(browser, tmp_path, name):
    arms = arms_of(name, tmp_path)
    runs = [lagging_run(arm, 0.05 * (k + 1), "pid", k=601) for k, arm in enumerate(arms)]
    path = tmp_path / "page.html"
    replay_page.write_replay(path, runs, arms, layout="beside")
    for width in WIDTHS:
        with seen(browser, width):
            opened(browser, path.as_uri())
            drawn, stage, side, bar = boxes(browser)
            assert (drawn[:2] >= stage[:2]).all(), (width, drawn)
            assert (drawn[2:] <= stage[2:]).all(), (width, drawn)
            assert not overlap(drawn, side), (width, drawn, side)
            assert not overlap(drawn, bar), (width, drawn, bar)
            left, bottom = (side[2], bar[1]) if width > 700 else (0.0, stage[3])
            share = (drawn[2:] - drawn[:2]) / [stage[2] - left, bottom - stage[1]]
            assert share.max() > FILLED, (width, share)


def test_arms_beside_each_other_do_not_touch(browser, tmp_path):
    """However large they are: the spans of what is drawn, along the picture's horizontal."""
    arms = arms_of("kr30ha + lwr4plus + kr30ha", tmp_path)
    path = tmp_path / "page.html"
    runs = [lagging_run(arm, 0.05, "pid", k=601) for arm in arms]
    replay_page.write_replay(path, runs, arms, layout="beside")
    opened(browser, path.as_uri())
    spans = browser.execute_script(
        """const { stage } = lwrReplay, point = new THREE.Vector3();
        const inScene = stage.scene().matrixWorld.clone().invert();
        const right = new THREE.Vector3(-Math.sin(stage.azimuth), Math.cos(stage.azimuth), 0);
        return stage.runs.map((run) => {
          const span = [Infinity, -Infinity];
          [0, 2, 4, 6].forEach((t) => {
            lwrReplay.setTime(t);
            stage.scene().updateMatrixWorld(true);
            stage.node(run.root).traverse((part) => {
              if (!part.isMesh || part.renderOrder > 0) return;
              const { position } = part.geometry.attributes;
              for (let k = 0; k < position.count; k += 1) {
                point.fromBufferAttribute(position, k).applyMatrix4(part.matrixWorld).applyMatrix4(inScene);
                const x = point.dot(right);
                span[0] = Math.min(span[0], x);
                span[1] = Math.max(span[1], x);
              }
            });
          });
          return span;
        })"""
    )
    assert all(one[1] < other[0] for one, other in itertools.pairwise(spans))


def test_a_view_that_was_turned_stays_when_a_card_is_folded(browser, tmp_path, arm):
    path = tmp_path / "page.html"
    replay_page.write_replay(path, [lagging_run(arm, 0.05, "pid", k=601)], arm)
    opened(browser, path.as_uri())
    place = "return lwrReplay.stage.viewer.camera.position.toArray()"
    browser.execute_script(
        "const { camera, controls } = lwrReplay.stage.viewer; camera.position.x += 0.5; controls.update()"
    )
    turned = browser.execute_script(place)
    browser.execute_script("document.querySelector('.about').open = false")
    browser.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(() => arguments[0]()))")
    assert browser.execute_script(place) == turned


def test_on_a_phone_three_cards_are_seen_whole_and_the_arms_keep_their_room(browser, tmp_path):
    arms = arms_of("lwr4plus + kr30ha + scara", tmp_path)
    path = tmp_path / "page.html"
    replay_page.write_replay(path, [lagging_run(arm, 0.05, "pid", k=601) for arm in arms], arms, layout="beside")
    with seen(browser, 420, height=850):
        opened(browser, path.as_uri())
        hidden, stage = browser.execute_script(
            """const side = document.getElementById("side");
            return [side.scrollHeight - side.clientHeight, document.getElementById("stage").clientHeight]"""
        )
    assert hidden <= 1
    assert stage > 0.35 * 850
