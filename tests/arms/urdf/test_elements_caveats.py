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
def test_every_file_of_a_model_says_it(robot, reading):
    arm = lwr_dyn.load(robot, reading)
    said = caveat_lines(arm)
    assert bool(said) == bool(arm.caveat(DYNAMICS))
    for name, text in model_files(arm).items():
        if name.endswith(".provenance.json"):
            sidecar = json.loads(text)
            assert sidecar["caveat"] == arm.caveat(DYNAMICS)
            assert tuple(sidecar["caveats"]["left_in_place"]) == arm.caveats.left_in_place
        else:
            assert text.count(CAVEAT) == len(said), name
            assert all(line in text for line in said), name


def test_the_header_says_it_behind_the_name_of_the_reading():
    lines = lwr_dyn.urdf_text(lwr_dyn.load("lwr4plus", "computed")).splitlines()
    assert lines[2].endswith("robot lwr4plus, reading computed")
    assert lines[3].strip() == f"{CAVEAT}leaves rotor-inertia-power in place, a proven error"
    assert "table2-c5z (likely)" in lines[5]


@pytest.mark.parametrize(("robot", "reading"), ALL_ARMS)
@pytest.mark.parametrize("ending", [".urdf", ".toml"])
def test_what_was_written_is_read_back_with_it(robot, reading, ending, tmp_path):
    arm = lwr_dyn.load(robot, reading)
    path = tmp_path / f"arm{ending}"
    path.write_text(lwr_dyn.urdf_text(arm) if ending == ".urdf" else data_file_text(arm), encoding="utf-8")
    read = lwr_dyn.load(path).caveats
    assert read.left_in_place == arm.caveats.left_in_place
    assert read.of_numbers(DYNAMICS) == arm.caveats.of_numbers(DYNAMICS)
