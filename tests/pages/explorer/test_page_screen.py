"""The explorer's screen: where its parts stand on a desk and on a phone, and that nothing lies on anything."""

import numpy as np
import pytest

from tests.axe import seen, sideways
from tests.pages.explorer.by_hand import mouse

pytestmark = pytest.mark.slow

SHOWN = "lwr4plus physical"
DESK, PHONE = (1400, 900), (390, 844)
LEFT, MIDDLE, RIGHT = ("#pose", "[aria-label='Arm angle']"), ("#stage", ".flange"), ("[aria-label='Torques']",)
Q = [0.3, 0.7, 0.2, -1.2, 0.3, 0.9, 0.1]
BOXES = """return arguments[0].map((name) => {
  const { left, top, right, bottom } = document.querySelector(name).getBoundingClientRect();
  return [left, top, right, bottom];
});"""

CAMERA = """const { viewer } = lwrExplorer.stage, { clientWidth, clientHeight } = viewer.pane;
const { camera, controls } = viewer, place = (point) => point.toArray().map((x) => Math.round(x * 1e6));
return [[...place(camera.position), ...place(controls.target)], camera.aspect - clientWidth / clientHeight];"""


def boxes(window, names):
    """(left, top, right, bottom) [px] of each part, in the window as it is scrolled."""
    return np.array(window.execute_script(BOXES, list(names)))


def on_top_of_each_other(rows):
    """How many pairs of boxes share an area."""
    a, b = rows[:, None], rows[None]
    width = np.minimum(a[..., 2], b[..., 2]) - np.maximum(a[..., 0], b[..., 0])
    height = np.minimum(a[..., 3], b[..., 3]) - np.maximum(a[..., 1], b[..., 1])
    return int(np.triu((width > 0.5) & (height > 0.5), 1).sum())


def test_at_a_desk_all_of_it_is_one_screen_in_three_columns(window):
    with seen(window, DESK[0], height=DESK[1]):
        window.execute_script("window.scrollTo(0, 0)")
        left, middle, right = (boxes(window, names) for names in (LEFT, MIDDLE, RIGHT))
        assert left[:, 2].max() <= middle[:, 0].min()
        assert middle[:, 2].max() <= right[:, 0].min()
        every = np.vstack([left, middle, right])
        assert every.min() >= 0
        assert every[:, 3].max() <= DESK[1]
        assert on_top_of_each_other(every) == 0
        width, height = middle[0, 2:] - middle[0, :2]
        assert width * height > 0.2 * DESK[0] * DESK[1]
        parts = [".lead", *MIDDLE, *LEFT, *RIGHT, "#panels > *", "#joints", "#links"]
        window.execute_script("window.scrollTo(0, 700)")
        assert on_top_of_each_other(boxes(window, parts)) == 0
        count = "return document.querySelectorAll('#panels > *').length"
        panels = [f"#panels > :nth-child({k + 1})" for k in range(window.execute_script(count))]
        places = boxes(window, panels)
        assert len(set(places[:, 0].round())) == 3  # columns, each full from its top
        assert [places[places[:, 0] == x, 1].min() for x in set(places[:, 0])] == [places[0, 1]] * 3
        assert on_top_of_each_other(places) == 0


def test_on_a_phone_the_arm_is_above_and_stays_while_the_rest_is_scrolled(window):
    with seen(window, PHONE[0], height=PHONE[1]):
        window.execute_script("window.scrollTo(0, 0)")
        assert sideways(window) == 0
        cards = boxes(window, [".lead", "#stage", ".flange", *LEFT, *RIGHT, "#panels", "#joints", "#links"])
        assert on_top_of_each_other(cards) == 0
        assert (np.diff(cards[:, 1]) > 0).all()
        assert cards[1, 3] < 0.75 * PHONE[1]
        window.execute_script("document.querySelector(arguments[0]).scrollIntoView()", RIGHT[0])
        arm, torques = boxes(window, ["#stage", RIGHT[0]])
        assert arm[1] >= 0
        assert arm[3] <= torques[1] + 1
        assert torques[1] < PHONE[1]


@pytest.mark.parametrize("turn", [-2.5, -0.5, 1.0, 2.5])
def test_the_whole_arm_is_in_the_picture_from_every_side(window, turn):
    q = [turn, *Q[1:]]
    ends = window.execute_script(
        """lwrExplorer.setPose(arguments[0]); document.getElementById("view").click();
        const { stage } = lwrExplorer, { camera } = stage.viewer;
        stage.viewer.world.updateMatrixWorld(true);
        return stage.outline().map(({ x, y, z }) => new THREE.Vector3(x, z, -y).project(camera).toArray())""",
        q,
    )
    reached = np.abs(np.array(ends)[:, :2]).max()
    assert 0.6 < reached < 0.9


def test_a_window_of_another_size_keeps_the_view_that_was_turned(window):
    with seen(window, DESK[0], height=DESK[1]):
        window.execute_script("window.scrollTo(0, 0); document.getElementById('view').click()")
        framed, _ = window.execute_script(CAMERA)
        left, top, *_ = boxes(window, ["#stage"])[0]
        mouse(window, (left + 20, top + 20), (left + 80, top + 40), (left + 140, top + 60))
        turned, _ = window.execute_script(CAMERA)
        assert turned != framed
    for width, height in ((1100, 900), PHONE, DESK):
        with seen(window, width, height=height):
            kept, off_shape = window.execute_script(CAMERA)
            assert kept == turned
            assert off_shape == pytest.approx(0, abs=1e-9)
    with seen(window, DESK[0], height=DESK[1]):  # framed again, it is framed in each size
        window.execute_script("document.getElementById('view').click()")
        assert window.execute_script(CAMERA)[0] == framed
    with seen(window, 1000, height=900):
        assert window.execute_script(CAMERA)[0] != framed
