"""What a file holds beyond its arm: links as written are welded and judged one by one."""

from dataclasses import replace

import numpy as np

import lwr_dyn
from lwr_dyn.model.chain import Body, with_payload
from lwr_dyn.model.file_layout import Drawing, WrittenLink, fitting, heavy, welded
from lwr_dyn.model.spatial import Pose, rot_x
from tests.arms.urdf import small_files
from tests.arms.urdf.small_files import LINK, joint, robot


def written(link, mass, x=0.0):
    body = None if mass is None else Body(mass, np.array([x, 0.0, 0.0]), np.zeros((3, 3)))
    return WrittenLink(link, body)


def test_a_weld_is_the_sum_of_its_heavy_links_and_an_arm_of_a_data_file_has_no_layout():
    body = welded([written("a", 1.0, 1.0), written("b", None), written("c", 3.0, -1.0)])
    assert body.mass == 4.0
    assert body.com.tolist() == [-0.5, 0.0, 0.0]
    assert welded([written("a", None)]) is None
    assert Body.massless().is_weightless
    assert not Body(1.0, np.zeros(3), np.zeros((3, 3))).is_weightless
    assert [link for link, _ in heavy([written("a", 1.0), written("b", None), written("c", 0.0)])] == ["a"]
    assert [link for link, _ in heavy([written("a", 0.0), written("b", 1.0)])] == ["a", "b"]  # the first one counts
    arm = lwr_dyn.load("lwr4")
    assert arm.layout is None
    assert fitting(None, arm.chain) is None
    assert Drawing() == Drawing(0.0, (), ())


def test_a_layout_fits_a_chain_of_the_same_joints_and_frames_alone(tmp_path):
    path = small_files.written(tmp_path, robot(joint("j", "a", "b"), joint("k", "b", "c"), a="", b=LINK, c=LINK))
    arm = lwr_dyn.load(path)
    chain, (first, last) = arm.chain, arm.chain.links
    assert fitting(arm.layout, with_payload(chain, 1.0)) is arm.layout
    turn, shift = Pose(rot_x(1e-9), np.zeros(3)), Pose(np.eye(3), np.array([0.0, 0.0, 1e-9]))
    for change in (
        {"links": (first,)},
        {"links": (first, replace(last, joint="l"))},
        *({"links": (first, replace(last, before=last.before @ pose))} for pose in (turn, shift)),
        *({"flange": pose} for pose in (turn, shift)),
    ):
        assert fitting(arm.layout, replace(chain, **change)) is None
