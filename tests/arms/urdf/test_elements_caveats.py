"""Headers and sidecars say what must be known before an arm's numbers, and what we wrote is read back."""

import json

import pytest

import lwr_dyn
from lwr_dyn.arms.export.data_file import data_file_text
from lwr_dyn.arms.papers.catalog import readings, studied
from lwr_dyn.arms.urdf.elements import CAVEAT, caveat_lines
from lwr_dyn.arms.urdf.model_files import model_files
from lwr_dyn.model.caveats import DYNAMICS

ALL_ARMS = [(robot, reading) for robot in studied() for reading in readings(robot)]


@pytest.mark.parametrize(("robot", "reading"), ALL_ARMS)
def test_every_file_of_a_model_says_it_and_is_read_back_with_it(robot, reading, tmp_path):
    arm = lwr_dyn.load(robot, reading)
    said, files = caveat_lines(arm), model_files(arm, "arm")
    assert bool(said) == bool(arm.caveat(DYNAMICS))
    for name, text in files.items():
        if name.endswith(".provenance.json"):
            sidecar = json.loads(text)
            assert sidecar["caveat"] == arm.caveat(DYNAMICS)
            assert tuple(sidecar["caveats"]["left_in_place"]) == arm.caveats.left_in_place
        else:
            assert text.count(CAVEAT) == len(said), name
            assert all(line in text for line in said), name
    for name, text in (("arm.urdf", files["arm.urdf"]), ("arm.toml", data_file_text(arm))):
        (tmp_path / name).write_text(text, encoding="utf-8")
        read = lwr_dyn.load(tmp_path / name).caveats
        assert read.left_in_place == arm.caveats.left_in_place
        assert read.of_numbers(DYNAMICS) == arm.caveats.of_numbers(DYNAMICS)


def test_the_header_says_it_behind_the_name_of_the_reading():
    lines = lwr_dyn.urdf_text(lwr_dyn.load("lwr4plus", "computed")).splitlines()
    assert lines[2].endswith("robot lwr4plus, reading computed")
    assert lines[3].strip() == f"{CAVEAT}leaves rotor-inertia-power in place, a proven error"
    assert "table2-c5z (likely)" in lines[5]
