"""The picture of an arm: as large as the arm is, another at another pose, and with the path of a run over it."""

import base64
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from lwr_dyn.model.spatial import Pose, from_rpy
from lwr_dyn.pages.replay.look import RUN_COLOURS
from lwr_dyn.pages.still import (
    COLUMNS,
    ROWS,
    Camera,
    Solid,
    arm_solids,
    arm_still,
    camera_of,
    png_address,
    png_bytes,
    ray_cast,
)
from tests.pages.explorer.explored import explored_arm


def grey(png):
    return np.asarray(Image.open(BytesIO(png)).convert("L"), dtype=float)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lwr4plus computed", "tiago", "hung"])
def test_a_still_shows_the_arm_at_its_pose(name):
    arm = explored_arm(name)
    q = np.clip(np.full(arm.n, 0.4), arm.lower, arm.upper)
    picture = grey(arm_still(arm, q))
    assert 0.02 < (picture < 235).mean() < 0.6
    assert np.abs(picture - grey(arm_still(arm, np.clip(0.0 * q, arm.lower, arm.upper)))).max() > 50


def test_the_same_arm_gives_the_same_bytes(arm):
    assert arm_still(arm, np.zeros(7)) == arm_still(arm, np.zeros(7))


@pytest.mark.slow
def test_the_path_of_a_run_is_drawn_in_its_colour(arm, two_runs):
    run = two_runs[1]
    stills = [arm_still(arm, run.q[-1], one) for one in (run, None)]
    pictures = [np.asarray(Image.open(BytesIO(png)).convert("RGB")).astype(int) for png in stills]
    ink = [int(RUN_COLOURS[0][i : i + 2], 16) for i in (1, 3, 5)]
    with_path, alone = ((np.abs(picture - ink).max(axis=-1) <= 2).sum() for picture in pictures)
    assert with_path > 100
    assert alone == 0


CYLINDERS = tuple(
    Solid(Pose(from_rpy(rpy), np.array(place)).matrix(), *sizes)
    for rpy, place, sizes in (
        ((0.4, 0.8, 0.2), (0.02, -0.03, 0.01), (0.11, 0.3, 0.8)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.1), (0.06, 0.5, 0.86)),
        ((2.2, 0.0, 0.0), (0.05, 0.1, -0.1), (0.2, 0.05, 0.3)),
    )
)
LIGHT = np.array([0.45, -0.35, 0.82])


def marched(screen, camera):
    """Where a ray from the eye is first in a cylinder, in steps of 0.1 mm: nearness, brightness; None where nowhere."""
    eye = camera.axes[2]
    depth = np.arange(0.45, -0.45, -1e-4)
    points = screen @ camera.axes[:2] + depth[:, None] * eye
    best = None
    for solid in CYLINDERS:
        x, y, z = ((points - solid.pose[:3, 3]) @ solid.pose[:3, :3]).T
        inside = np.flatnonzero((np.hypot(x, y) <= solid.radius) & (np.abs(z) <= 0.5 * solid.length))
        if inside.size and (best is None or depth[inside[0]] > best[0]):
            k = inside[0]
            on_cap = 0.5 * solid.length - abs(z[k]) < 1.1e-4
            normal = [0.0, 0.0, np.sign(z[k])] if on_cap else [x[k] / solid.radius, y[k] / solid.radius, 0.0]
            normal = solid.pose[:3, :3] @ normal
            light = LIGHT / np.linalg.norm(LIGHT)
            half = (light + eye) / np.linalg.norm(light + eye)
            lit, shine = max(normal @ light, 0.0), max(normal @ half, 0.0) ** 24
            best = (depth[k], min(max(solid.grey * (0.52 + 0.48 * lit) + 0.14 * shine, 0.0), 1.0))
    return best


@pytest.mark.parametrize("toward", [(0.5, 0.6, 0.4), (0.0, 0.0, 1.0), (-0.7, 0.2, -0.3)])
def test_rays_meet_the_cylinders_where_a_march_along_them_does(toward):
    toward = np.array(toward) / np.linalg.norm(toward)
    right = np.cross([0.3, 1.0, 0.2], toward)
    right /= np.linalg.norm(right)
    camera = Camera(np.stack([right, np.cross(toward, right), toward]), 700.0, np.array([0.03, -0.05, 0.2]))
    picture, near = ray_cast(CYLINDERS, camera)
    assert picture.shape == (ROWS, COLUMNS, 2)
    random, compared = np.random.default_rng(1), 0
    for row, column in zip(random.integers(100, 450, 25), random.integers(330, 620, 25), strict=True):
        rays = [
            marched(np.array([(column + b - 480.0) / 700.0 + 0.03, (300.0 - row - a) / 700.0 - 0.05]), camera)
            for a in (0.25, 0.75)
            for b in (0.25, 0.75)
        ]
        hits = [ray for ray in rays if ray is not None]
        assert picture[row, column, 1] == len(hits) / 4
        if len(hits) == 4 and np.ptp([d for d, _ in hits]) < 0.01:
            compared += 1
            assert near[row, column] == pytest.approx(rays[0][0] - 0.2, abs=2e-4)
            assert picture[row, column, 0] == pytest.approx(np.mean([grey for _, grey in hits]), abs=5e-3)
    assert compared > 5
    assert (near[picture[..., 1] == 0.0] == -np.inf).all()


def test_a_camera_turns_points_to_the_middle_of_the_picture(arm):
    camera = camera_of(arm, arm_solids(arm, np.zeros(7)), [])
    np.testing.assert_allclose(camera.axes @ camera.axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(camera.axes) == pytest.approx(1.0)
    assert camera.axes[2, 2] == pytest.approx(np.sin(0.27))
    np.testing.assert_allclose(camera.seen(camera.centre @ camera.axes), [COLUMNS / 2, ROWS / 2, 0.0], atol=1e-9)
    at = camera.seen(camera.centre @ camera.axes + np.array([0.0, 0.0, 0.1]))
    assert at[0] == pytest.approx(COLUMNS / 2)
    assert at[1] == pytest.approx(ROWS / 2 - 0.1 * np.cos(0.27) * camera.scale)


@pytest.mark.parametrize(
    ("sizes", "middle", "azimuth"),
    [
        ((1.0, 0.1, 1.0), (0.3, 0.0, 0.5), -0.5 * np.pi + 0.42),
        ((1.0, 0.1, 1.0), (-0.3, 0.0, 0.5), -0.5 * np.pi - 0.42),
        ((1.0, 0.1, 1.0), (0.0, 0.0, 0.5), -0.5 * np.pi + 0.42),
        ((1.0, 0.3, 1.0), (0.3, 0.2, 0.5), 0.42),
        ((1.0, 0.1, 0.2), (0.3, -0.2, 0.5), -0.42),
        ((1.0, 0.3, 1.0), (0.3, 0.0, 0.5), -0.42),
    ],
)
def test_the_camera_looks_across_a_path_that_lies_in_a_plane(arm, sizes, middle, azimuth):
    track = 10.0 * np.array(middle) + 10.0 * np.array(sizes) * np.array(
        [[-0.5, 0.5, -0.5], [0.5, -0.5, 0.5], [0.0, 0.0, 0.0]]
    )
    camera = camera_of(arm, [Solid(np.eye(4), 1e-9, 1e-9, 1.0)], [track])
    assert np.arctan2(*camera.axes[2, [1, 0]]) == pytest.approx(azimuth)
    seen = camera.seen(np.vstack([track, np.zeros(3)]))[:, :2]
    assert (np.ptp(seen, axis=0) / [COLUMNS, ROWS]).max() == pytest.approx(0.9)  # of the picture
    np.testing.assert_allclose(seen.max(axis=0) + seen.min(axis=0), [COLUMNS, ROWS], rtol=1e-9)


def test_pixels_come_back_from_the_png():
    random = np.random.default_rng(2)
    for channels, mode in ((2, "LA"), (3, "RGB")):
        pixels = random.integers(0, 256, (7, 5, channels)).astype(np.uint8)
        with Image.open(BytesIO(png_bytes(pixels))) as image:
            assert (image.mode, image.size) == (mode, (5, 7))
            np.testing.assert_array_equal(np.asarray(image), pixels)
    picture = np.array([[[0.0, 0.0], [0.5, 1.0], [1.0, 0.5], [0.7, 0.02]]])
    address = png_address(picture)
    assert address.startswith("data:image/png;base64,")
    with Image.open(BytesIO(base64.b64decode(address.split(",")[1]))) as image:
        shades = [round(x * 63) * 255 // 63 for x in (0.5, 1.0)]
        assert np.asarray(image)[0].tolist() == [[0, 0], [shades[0], 255], [shades[1], 8 * 17], [0, 0]]
