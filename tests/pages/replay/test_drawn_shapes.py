"""No two cylinders that a page draws lie in one surface, where the files of arms have some that do."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.arms.urdf.geometry import primitives
from lwr_dyn.model.arm import JointLimits
from lwr_dyn.pages.replay import replay_page
from lwr_dyn.pages.replay.drawn_shapes import _travels, drawn_shapes, shared_surfaces
from lwr_dyn.pages.replay.replayed_runs import pose_as_run, replayed_runs
from tests.random_arms import arms, random_arm

ROOT = Path(__file__).parents[3]
ALIKE = 1e-4
"""[m] of two surfaces of one picture; with a camera that sees from 0.02 to 60 m, 0.01 mm are told apart at 2 m."""


@pytest.fixture
def scara(tmp_path):
    page = (ROOT / "docs/tutorials/own_arm.md").read_text(encoding="utf-8")
    path = tmp_path / "scara.toml"
    path.write_text(re.search(r"```toml file=scara.toml\n(.*?)```", page, re.DOTALL)[1], encoding="utf-8")
    return lwr_dyn.load(path)


@pytest.fixture(params=[*studied(), "puma560", "scara", "hung"])
def any_arm(request, scara):
    if request.param == "hung":
        return lwr_dyn.load("lwr4plus", mount="ceiling", tool={"xyz": [0.0, 0.0, 0.2]})
    there = {"puma560": ROOT / "tests/dynamics/puma560.toml"}
    return scara if request.param == "scara" else lwr_dyn.load(there.get(request.param, request.param))


def drawn_on_stage(arm, q):
    """Centre, axis, radius and length of each cylinder of the page's scene, in the world at q."""
    (shown,) = replayed_runs([pose_as_run(arm, q)], arm, ["x"])
    frames, out = {"/arms/run_0/link_0": np.eye(4)}, []
    for command in sorted(replay_page.arm_commands(shown, 0), key=lambda one: one["type"], reverse=True):
        above = command["path"].rpartition("/")[0]
        if command["type"] == "set_transform":
            frames[command["path"]] = frames[above] @ np.reshape(command["matrix"], (4, 4)).T
        else:
            pose = frames[above] @ np.reshape(command["object"]["object"]["matrix"], (4, 4)).T
            (solid,) = command["object"]["geometries"]
            out.append((pose[:3, 3], pose[:3, 1], solid["radiusTop"], solid["height"]))  # along y in three.js
    return out


def coincident(shapes):
    """Pairs of cylinders with one side, or with ends in one plane that look the same way, where they overlap."""
    found = []
    for i, (a, axis, radius, length) in enumerate(shapes):
        for j, (b, other, radius_b, length_b) in enumerate(shapes[i + 1 :], start=i + 1):
            if np.linalg.norm(np.cross(axis, other)) > 1e-6:
                continue
            along = (b - a) @ axis
            off = np.linalg.norm(b - a - along * axis)
            if off < ALIKE and abs(radius - radius_b) < ALIKE and abs(along) < (length + length_b) / 2:
                found.append((i, j, "side"))
            gaps = [abs(along + way * (length_b - length) / 2) for way in (-1, 1)]
            if min(gaps) < ALIKE and off < radius + radius_b:
                found.append((i, j, "end"))
    return found


def test_no_two_cylinders_of_a_page_share_a_surface(any_arm):
    rng = np.random.default_rng(5)
    low, up = np.maximum(any_arm.lower, -3.0), np.minimum(any_arm.upper, 3.0)
    for q in (np.zeros(any_arm.n), low, up, *rng.uniform(low, up, (4, any_arm.n))):
        assert coincident(drawn_on_stage(any_arm, q)) == []


def test_the_scara_had_a_housing_in_the_side_of_its_guide(scara):
    sides, _ = shared_surfaces(scara, primitives(scara))
    links = {tuple(primitives(scara)[k].link for k in pair) for pair in sides}
    assert ("link_2", "link_4") in links
    assert shared_surfaces(scara, drawn_shapes(scara))[0] == set()


def test_a_sliding_joint_moves_what_is_behind_it_against_what_is_before_it_only():
    arm = random_arm(3, "RP")
    arm = replace(arm, limits=(arm.limits[0], JointLimits(-0.3, 0.2)))
    shapes = primitives(arm)
    behind = np.array([shape.link not in ("base", "link_1") for shape in shapes])
    np.testing.assert_allclose(_travels(arm, shapes), 0.3 * (behind[:, None] != behind))


@given(arms)
def test_shapes_of_any_arm_differ_and_hardly_change(arm):
    before, after = primitives(arm), drawn_shapes(arm)
    assert shared_surfaces(arm, after) == (set(), set())
    assert [shape.link for shape in after] == [shape.link for shape in before]
    for one, other in zip(before, after, strict=True):
        assert 0.6 * one.radius <= other.radius <= one.radius
        assert 0.2 * one.length <= other.length <= one.length
        if one.link in ("base", "flange"):
            assert other.length >= 0.9 * one.length
