"""The section of the workspace: its boundary beside dense samples, and its card on the page."""

import numpy as np
import pytest
from matplotlib.path import Path as Curve
from selenium.webdriver.support.ui import WebDriverWait

import lwr_dyn
from tests.headless import logs
from tests.pages.explorer.explored import SHARE, explored_arm, opened

pytestmark = pytest.mark.slow

SAMPLES = 40_000
BOUNDARY = """const work = sectionBoundary(robot, lwrExplorer.arm);
    let piece = work.next();
    while (!piece.done) piece = work.next();
    const { loops, tolerance, faces } = piece.value;
    const curves = loops.map((loop) => loop.map(({ s, z, q }) => [s, z, ...q]));
    return [curves, tolerance, faces.flat().map(({ s, z }) => [s, z])];"""


def place(arm, q):
    """Distance from the first joint's axis and height along it, (..., 2) [m]."""
    first = arm.joints()[0].origin
    x, y, z = ((lwr_dyn.forward_kinematics(arm, q)[..., :3, 3] - first.position) @ first.rotation).T
    return np.stack([np.hypot(x, y), z], axis=-1)


def ranges(arm):
    return np.maximum(arm.lower, -np.pi), np.minimum(arm.upper, np.pi)


def sampled(arm):
    """Positions in the joints' ranges, many with joints at their ends or at zero, where the boundary is."""
    rng, (low, up), shape = np.random.default_rng(30), ranges(arm), (SAMPLES, arm.n)
    q = rng.uniform(low, up, shape)
    q = np.where(rng.random(shape) < 0.8 * rng.random((SAMPLES, 1)), np.where(rng.random(shape) < 0.5, low, up), q)
    return np.where((rng.random(shape) < 0.2) & (low < 0) & (up > 0) & (np.arange(SAMPLES) % 2 == 0)[:, None], 0.0, q)


def outside(points, loops):
    """The points that lie outside the area of closed curves, (k, 2), and how far from it, (k,) [m]."""
    times = sum(Curve(loop).contains_points(points).astype(int) for loop in loops)
    points = points[times % 2 == 0]
    away = np.full(len(points), np.inf)
    for loop in loops:
        for a, b in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            along = np.clip((points - a) @ (b - a) / max((b - a) @ (b - a), 1e-30), 0, 1)
            away = np.minimum(away, np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
    return points, away


@pytest.mark.parametrize("name", ["lwr4plus computed", "kr30ha kuka", "wam7 manual"])
def test_the_boundary_is_reached_and_no_sample_is_outside(browser, page_of, name):
    arm = explored_arm(name)
    found, tolerance, faces = opened(browser, page_of(name).as_uri()).execute_script(BOUNDARY)
    loops = [np.array(loop)[:, :2] for loop in found]
    on_curve, q = np.concatenate(loops), np.concatenate([np.array(loop)[:, 2:] for loop in found])
    np.testing.assert_allclose(place(arm, q), np.abs(on_curve[:, :1]) * [1, 0] + on_curve[:, 1:] * [0, 1], atol=1e-8)
    assert ((arm.lower <= q) & (q <= arm.upper)).all()
    points, away = outside(place(arm, sampled(arm)), loops)
    assert len(points) > 20  # some lie on the boundary
    assert away.max() < 3 * tolerance
    assert (away > tolerance).sum() < 0.002 * SAMPLES
    assert outside(np.array(faces), loops)[1].max(initial=0.0) < 60 * tolerance  # the area that is filled


def shown(window):
    window.execute_script("document.getElementById('section').click()")
    WebDriverWait(window, 100).until(lambda w: w.execute_script("return lwrExplorer.section.drawn"))
    return window.execute_script("return document.querySelector('.section').innerText")


def test_the_card_shows_the_section_and_where_the_flange_is(browser, page_of):
    arm, window = explored_arm("kr30ha kuka"), opened(browser, page_of("kr30ha kuka").as_uri())
    q = np.array([0.3, -1.2, 1.4, 0.2, 0.3, 0.4])
    text = shown(window)
    assert "farthest from the axis" in text
    window.execute_script("lwrExplorer.setPose(arguments[0]); lwrExplorer.state.compute()", q.tolist())
    dot = "const dot = document.querySelector('.section .flange'); return [dot.cx.baseVal.value, dot.cy.baseVal.value]"
    rho, z = place(arm, q)
    np.testing.assert_allclose(window.execute_script(dot), [rho, z], atol=1e-4)  # its first axis points down
    on_stage = "return [...lwrExplorer.stage.node(lwrExplorer.section.path).matrixWorld.elements]"
    window.execute_script("lwrExplorer.stage.scene().updateMatrixWorld(true)")
    m = np.reshape(window.execute_script(on_stage), (4, 4)).T
    height = (m @ [rho, 0, z, 1])[:3]  # y up in the picture
    flange = lwr_dyn.forward_kinematics(arm, q)[:3, 3]
    np.testing.assert_allclose([height[0], -height[2], height[1]], flange, atol=1e-6)
    window.execute_script("document.getElementById('section').click()")
    assert window.execute_script("return document.querySelector('.section').hidden")
    window.execute_script("document.getElementById('section').click(); lwrExplorer.choose(1)")
    assert window.execute_script("return !document.querySelector('.section').hidden")  # another arm: it stays on
    assert logs(browser)[1] == []


def test_where_the_flange_fills_no_area_the_card_says_so(browser, page_of):
    arm = lwr_dyn.load(SHARE / "double_pendulum_description/urdf/double_pendulum_continuous.urdf")
    assert "fill no area" in shown(opened(browser, page_of(arm).as_uri()))
    assert logs(browser)[1] == []
