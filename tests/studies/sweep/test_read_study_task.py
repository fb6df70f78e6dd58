"""The task of a study: options by the names of `simulate`, in its units."""

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import PaperError
from lwr_dyn.foundation.fields import Fields
from lwr_dyn.studies.sweep.read_study import missing_option, read_task

LINE = {
    "name": "line", "from-deg": [0, 30, 0, -60, 0, 30, 0], "to-xyz": [0.1, 0.2, 0.3], "to-rpy-deg": [0, 90, 180],
    "turn-speed-deg": 90, "speed": 1,
}  # fmt: skip


@pytest.fixture(scope="module")
def arm():
    return lwr_dyn.load("lwr4plus")


def test_degrees_become_radians_and_metres_stay(arm, tmp_path):
    task = read_task(Fields(LINE, "s.toml", "task"), tmp_path, arm)
    assert (task.name, task.files, missing_option(task, set())) == ("line", (), None)
    np.testing.assert_allclose(task.options["start"], np.radians(LINE["from-deg"]))
    np.testing.assert_allclose(task.options["to_rpy"], [0, np.pi / 2, np.pi])
    np.testing.assert_array_equal(task.options["to_xyz"], [0.1, 0.2, 0.3])
    assert (task.options["turn_speed"], task.options["speed"]) == (pytest.approx(np.pi / 2), 1.0)


def test_switches_files_and_what_is_missing(arm, tmp_path):
    task = read_task(Fields({"name": "line", "free-orientation": True}, "s.toml", "task"), tmp_path, arm)
    assert task.options == {"free_orientation": True}
    assert missing_option(task, set()) == "from-deg"
    assert missing_option(task, {"start"}) == "to-xyz"
    (tmp_path / "way.csv").write_text("x,y,z\n", encoding="utf-8")
    task = read_task(Fields({"name": "waypoints", "waypoints": "way.csv"}, "s.toml", "task"), tmp_path, arm)
    assert task.files == (tmp_path / "way.csv",)
    assert task.options == {"waypoints": str(tmp_path / "way.csv")}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"to-xyz": [0.1, 0.2]}, "task.to-xyz: 2 numbers; allowed: a list of 3 numbers"),
        ({"to-xyz": 0.1}, "task.to-xyz: 0.1; allowed: a list of 3 numbers"),
        ({"to-rpy-deg": [0, 90, "x"]}, r"task.to-rpy-deg\[2\]: 'x'; allowed: a number"),
        ({"free-orientation": 1}, "task.free-orientation: 1; allowed: true or false"),
        ({"turn-speed-deg": True}, "task.turn-speed-deg: True; allowed: a number"),
        ({"name": 3}, "task.name: 3; allowed: text"),
    ],
)
def test_other_values_are_refused(change, words, arm, tmp_path):
    with pytest.raises(PaperError, match=words):
        read_task(Fields(LINE | change, "s.toml", "task"), tmp_path, arm)
