"""The sidecar: every attribute has quantities with cells or a word, and what a URDF cannot hold is in SI."""

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.arms.papers.catalog import studied
from lwr_dyn.arms.urdf import model_files
from lwr_dyn.arms.urdf.model_files import UNSOURCED, provenance_text, quantity_sources
from lwr_dyn.foundation.errors import MissingDataError
from lwr_dyn.model.arm import Source
from lwr_dyn.model.spatial import Pose, rot_x
from tests.random_arms import random_arm

SPLIT = ("dh.alpha", "dh.d", "dh.theta_offset")


@pytest.mark.parametrize("robot", studied())
def test_every_attribute_names_cells_that_are_listed_or_has_a_word(robot):
    arm = lwr_dyn.load(robot)
    sidecar = json.loads(provenance_text(arm))
    assert (sidecar["robot"], sidecar["source_sha256"]) == (arm.name, arm.digest)
    for attribute in sidecar["attributes"].values():
        assert attribute["written"]
        assert attribute.get("word") or any(sidecar["quantities"][name] for name in attribute["quantities"])
        assert attribute.get("word") != UNSOURCED


def test_an_arm_that_was_built_in_code_has_no_source_and_blocks_only_what_the_arm_has():
    text = provenance_text(replace(random_arm(3, "RP"), title="Größe"))
    assert '"title": "Größe"' in text
    sidecar = json.loads(text)
    mass = sidecar["attributes"]["/robot/link[@name='link_1']/inertial/mass/@value"]
    assert mass["word"] == UNSOURCED
    assert sidecar["quantities"]["link_1.mass"] == []
    arm = lwr_dyn.load("wam7")
    blocks = model_files.sidecar_blocks(arm)
    assert set(blocks) == {"friction", "transmission", "gains"}
    assert blocks["transmission"]["motors_by_joints"] == arm.transmission.matrix.tolist()
    assert all(arm.sources[name] for name in model_files.sidecar_quantities(arm))
    one_rotor = lwr_dyn.load("kr30ha", rotor={"A2": 80.0})
    assert sorted(model_files.model_files(one_rotor, "k")) == ["k.provenance.json", "k.srdf", "k.urdf", "k.xml"]
    assert sorted(model_files.model_files(lwr_dyn.load("lwr4"))) == ["lwr4.provenance.json", "lwr4.urdf"]
    with pytest.raises(MissingDataError, match="lwr4: rotors not given; needed for an SRDF"):
        model_files.srdf_text(lwr_dyn.load("lwr4"))
    plain = random_arm(3, "RP")
    assert (model_files.sidecar_blocks(plain), model_files.sidecar_quantities(plain)) == ({}, ())


def test_a_standard_dh_row_is_all_after_the_motion():
    arm = lwr_dyn.load("lwr4plus")
    assert all(source.cell.startswith("dh.sign") for source in quantity_sources(arm, "joint_2.before"))
    assert {source.cell.split(".")[1] for source in quantity_sources(arm, "joint_2.after")} >= {"alpha", "a", "d"}
    assert quantity_sources(arm, "joint_2.colour") == ()
    links = list(arm.chain.links)
    links[1] = replace(links[1], before=Pose(rot_x(0.3), np.zeros(3)))  # one row is enough to know the convention
    modified = replace(arm, chain=replace(arm.chain, links=tuple(links)))
    assert "alpha" in {source.cell.split(".")[1] for source in quantity_sources(modified, "joint_3.before")}
    alone = random_arm(3, "R")  # with its row alone, what stands before the joint says which it is
    for before, rows in (
        (Pose.identity(), ("dh.alpha", "dh.d", "dh.theta_offset")),
        (Pose(rot_x(0.3), np.zeros(3)), ("dh.d", "dh.theta_offset")),
    ):
        link = replace(alone.chain.links[0], before=before)
        cells = {
            f"{link.joint}.dh": tuple(
                Source(name, "p", "printed", 1, "m", "") for name in ("base.xyz", "base.rpy", *SPLIT)
            )
        }
        one = replace(alone, chain=replace(alone.chain, links=(link,)), sources=cells)
        assert tuple(source.cell for source in quantity_sources(one, f"{link.joint}.after")) == rows
        placed = ["base.xyz", "base.rpy", *(name for name in SPLIT if name not in rows)]
        assert [source.cell for source in quantity_sources(one, f"{link.joint}.before")] == placed
