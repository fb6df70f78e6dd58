"""The still of the 3D view: rays meet cylinders where they are, paths behind the arm are hidden; a PNG."""

import base64
import io
import re
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

import lwr_dyn
from lwr_dyn.kinematics.forward import flange_pose
from lwr_dyn.pages.replay.replayed_runs import replayed_runs
from lwr_dyn.pages.still import COLUMNS, ROWS, Camera, Solid, arm_solids, png_address, ray_cast
from lwr_dyn.reproduction.report import still_image
from lwr_dyn.reproduction.report.content import Replay, Still

FROM_ABOVE = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
FROM_SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def cylinder(x=0.0, radius=0.1, length=0.4, grey=0.8):
    pose = np.eye(4)
    pose[0, 3] = x
    return Solid(pose, radius, length, grey)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("axes", "area", "nearest"), [(FROM_ABOVE, np.pi * 0.1**2, 0.2), (FROM_SIDE, 0.2 * 0.4, 0.1)], ids=["top", "side"]
)
def test_a_cylinder_covers_its_projection_and_is_as_near_as_its_surface(axes, area, nearest):
    scale = 1000.0
    picture, near = ray_cast([cylinder()], Camera(axes, scale, np.zeros(3)))
    assert picture[..., 1].sum() / scale**2 == pytest.approx(area, rel=0.01)
    assert near.max() == pytest.approx(nearest, abs=1e-3)
    assert near[ROWS // 2, COLUMNS // 2] == pytest.approx(nearest, abs=1e-3)
    assert not np.isfinite(near[0, 0])


@pytest.mark.slow
def test_what_is_nearer_hides_what_is_behind():
    front, back = cylinder(grey=1.0), cylinder(grey=0.2)
    front.pose[1, 3] = -0.5  # toward the eye
    for order in ([front, back], [back, front]):
        picture, near = ray_cast(order, Camera(FROM_SIDE, 1000.0, np.zeros(3)))
        assert near.max() == pytest.approx(0.6, abs=1e-3)
        assert picture[ROWS // 2, COLUMNS // 2, 0] > 0.5


def test_the_arm_stands_as_forward_kinematics_says(arm):
    q = np.linspace(-0.5, 0.7, 7)
    solids = arm_solids(arm, q)
    tip = flange_pose(arm.chain, q)[:3, 3]
    assert min(np.linalg.norm(one.pose[:3, 3] - tip) for one in solids) < 0.1


def test_paths_behind_the_arm_are_not_drawn():
    near = np.full((ROWS, COLUMNS), -np.inf)
    near[:, : COLUMNS // 2] = 5.0  # a wall over the left half
    points = np.column_stack([np.linspace(-0.4, 0.4, 100), np.zeros(100), np.zeros(100)])
    line = still_image._line(points, "r1", Camera(FROM_SIDE, 1000.0, np.zeros(3)), near)
    columns = [float(x) for x in re.findall(r"([\d.]+),", line)]
    assert min(columns) >= COLUMNS // 2


def test_a_line_stands_at_its_pixels_and_the_floor_has_a_line_each_half_metre(arm):
    side, near = Camera(FROM_SIDE, 100.0, np.zeros(3)), np.full((ROWS, COLUMNS), -np.inf)
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.0, 0.0, 1.0], [1.0, 0.0, 1.5]])
    x, y = COLUMNS / 2, ROWS / 2
    d = f"M{x:.1f},{y:.1f} {x + 100:.1f},{y - 50:.1f} {x + 100:.1f},{y - 150:.1f}"
    assert still_image._line(points, "r1", side, near) == f'<path class="l r1" d="{d}"/>'
    floor = still_image._floor(arm, Camera(FROM_ABOVE, 100.0, np.zeros(3)))
    lines = re.findall(r"M(-?\d+),(-?\d+)L(-?\d+),(-?\d+)", floor)
    assert len(lines) == 2 * 13
    ends = [[round(float(a)) for a in line] for line in lines]
    across = [round(x) + 50 * k for k in range(-6, 7)]
    assert [end[0] for end in ends[:13]] == [end[2] for end in ends[:13]] == across
    assert {(end[1], end[3]) for end in ends[:13]} == {(round(y) + 300, round(y) - 300)}


def test_runs_have_a_row_with_their_errors_and_their_torque(arm, two_runs):
    runs = replayed_runs(two_runs, arm)
    html = still_image.run_table_html(runs)
    rows = re.findall(r"<tr>(<th scope=.row.>.*?)</tr>", html)
    for one, run, row in zip(runs, two_runs, rows, strict=True):
        tip = [lwr_dyn.forward_kinematics(arm, q)[:, :3, 3] for q in (run.q, run.q_ref)]
        away = 1e3 * np.linalg.norm(tip[0] - tip[1], axis=1)
        share = 100 * (np.abs(run.tau_applied).max(axis=0) / arm.effort).max()
        shown = [float(re.sub(" %", "", x)) for x in re.findall(r'class="num mono">(.*?)<', row)]
        assert shown == pytest.approx([np.sqrt((away**2).mean()), away.max(), share], rel=5e-3, abs=0.5)
        assert shown[:2] == pytest.approx([np.sqrt((away**2).mean()), away.max()], rel=5e-3)
        assert f'<i class="sw r{one.place + 1}"></i>{one.caption}</th>' in row
    assert "<caption>2 runs, 6 s</caption>" in html
    assert "<caption>1 run, 6 s</caption>" in still_image.run_table_html(runs[:1])
    unknown = SimpleNamespace(arm=lwr_dyn.load("kr30ha"), run=SimpleNamespace(tau_applied=np.ones((2, 6))))
    assert still_image.torque_share(unknown) == "unknown"


@pytest.mark.parametrize(("rate", "whole"), [(100.0, True), (101.0, True), (102.0, False), (1000.0, False)])
def test_a_page_with_fewer_samples_than_its_runs_says_so(rate, whole):
    run = SimpleNamespace(run=SimpleNamespace(t=np.arange(0, 11) / rate))
    assert still_image.rate_note([run]) == (
        "All samples of the runs are on this page."
        if whole
        else f"Replay and cursors have 100 samples a second; the run files have {rate:g}. "
        "Curves, peaks and this table are drawn from all of them."
    )


def test_the_png_is_read_back():
    picture = np.zeros((ROWS, COLUMNS, 2))
    picture[100:200, 300:500] = (0.5, 1.0)
    address = png_address(picture)
    image = np.asarray(Image.open(io.BytesIO(base64.b64decode(address.split(",")[1]))))
    assert image.shape == (ROWS, COLUMNS, 2)
    np.testing.assert_allclose(image[150, 400] / 255.0, (0.5, 1.0), atol=0.01)
    assert image[50, 50].tolist() == [0, 0]


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["lwr4plus", "kr30ha", "wam7", "lwr4"])
def test_every_arm_has_a_small_still_that_is_the_same_twice(robot):
    arm = lwr_dyn.load(robot)
    replay = Replay(stills=(Still("rest", arm, np.zeros(arm.n)),))
    first = still_image.still_html(replay)
    assert first == still_image.still_html(replay)
    assert len(first) < 100_000
    assert f'alt="{arm.title} at rest"' in first


def test_the_runs_of_a_still_have_their_colours(arm, two_runs):
    text = still_image.still_html(Replay(replayed_runs(two_runs, arm)))
    labels = ", ".join(one.label for one in replayed_runs(two_runs, arm))
    assert f'alt="{arm.title} on its path; 2 runs: {labels}"' in text
    assert {f"r{one.place + 1}" for one in replayed_runs(two_runs, arm)} | {"ref"} == set(
        re.findall(r'class="l (\w+)"', text)
    )
