"""`lwr-dyn identify friction` as a user types it; bad input of all subcommands of `identify`."""

import sys
from types import SimpleNamespace

import pytest

from lwr_dyn.identification.friction.friction_map import CruiseRule
from lwr_dyn.identification.friction.identify_friction import (
    FitOptions,
    friction_document,
    identify_friction_files,
)
from lwr_dyn.identification.logs.joint_log import write_log

WITH_ROBOT = "would do nothing here; allowed: with a robot: ROBOT LOG..."
FIRST = "a log; allowed: a robot first, then its logs, as in ROBOT LOG..."
OWN = FitOptions("viscous+coulomb", True, True, CruiseRule(shortest=0.5, tolerance=0.1))


@pytest.fixture
def logs(tmp_path, one_joint_at_a_time):
    """Joint 1 alone, then the others: two ways at four speeds each."""
    paths = [tmp_path / f"{i:02d}.csv" for i in range(len(one_joint_at_a_time))]
    for path, log in zip(paths, one_joint_at_a_time, strict=True):
        write_log(path, log)
    return paths


@pytest.mark.parametrize(
    ("words", "arm", "subtract", "fit"),
    [
        (("x.csv", "y.csv"), None, "gravity", FitOptions()),
        (("wam7", "x.csv", "y.csv", "--subtract", "all", "--robust", "--equal-weights", "--shortest", 0.5,
          "--tolerance", 0.1), "wam7", "all", OWN),
    ],
)  # fmt: skip
def test_options_reach_the_fit(asked, lwr_dyn_command, words, arm, subtract, fit):
    place = "lwr_dyn.identification.friction.identify_friction.identify_friction_files"
    calls = asked(place, SimpleNamespace(points=(), faults=()))
    line = ("identify", "friction", *words, "--units", "q=deg", "--columns", "q=pos_*")
    assert lwr_dyn_command(*line) == (0, "", "")
    ((paths, units, model, *more, columns), _) = calls[0]
    assert (paths, dict(units), model and model.name, *more) == (("x.csv", "y.csv"), {"q": "deg"}, arm, subtract, fit)
    assert "pos_*" in repr(columns)


def test_the_record_and_the_table_are_those_of_the_library(recorded, lwr_dyn_command, as_recorded, wam, logs, folder):
    """Of eight cruises of the first joint, and of two files that cannot be read, which end it with 2."""
    (folder / "bad.csv").write_text("time,q1\n0,0\n")
    found = identify_friction_files(logs[:8], {}, wam, "all", FitOptions(robust=True))
    document = friction_document(found, "wam7")
    line = ("identify", "friction", "wam7", *logs[:8], "--robust", "--subtract", "all")
    record = recorded(*line, "--plot", "map")
    assert record == as_recorded(document, wam)
    assert record["fits"][0]["parameters"]["coulomb"]["value"] == pytest.approx(4.4748)
    code, out, err = lwr_dyn_command(*line, "bad.csv", "none.csv", "--plot", "map.svg")
    assert (code, out.splitlines()[-1]) == (2, "wrote map.png and map.svg")
    assert out.count("0.05 to 0.3") == 2
    assert err.splitlines() == [
        "lwr-dyn: bad.csv: columns: tau1 missing; the file has time, q1; "
        "needed: time, q1.., tau1.. (and dq1.. if measured)",
        "lwr-dyn: none.csv: no such file or directory; allowed: a log (.csv or .parquet)",
    ]
    assert (folder / "map.png").read_bytes()[:4] == b"\x89PNG"
    assert b"<svg" in (folder / "map.svg").read_bytes()


@pytest.mark.slow
def test_the_table_names_the_torques_taken_out(printed, logs):
    out = printed("identify", "friction", "wam7", *logs, "--robust")
    assert "56 cruises in 56 files, Huber's loss, taken out of the torques: g" in out
    assert "--subtract all takes it out" in out
    assert out.count("0.05 to 0.3") == 14


def test_without_matplotlib_a_plot_is_refused_before_anything_is_read(refused, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert "pip install 'lwr_dyn[plots]'" in refused("identify", "friction", "none.csv", "--plot", "map")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("friction",), "Missing argument '[ROBOT]'"),
        (("friction", "wam7"), "Missing argument 'LOG...'"),
        (("friction", "kuka", "x.csv"), "no robot named 'kuka'"),
        (("friction", "none.csv", "--json"), "none.csv: no such file or directory"),
        (("friction", "x.csv", "--robot", "wam7"),
         "--robot is now the first argument: lwr-dyn identify friction ROBOT LOG"),
        (("friction", "x.csv", "--units", "q=turns"), "units of q: 'turns'; allowed: rad, deg"),
        (("friction", "x.csv", "--model", "lugre"), "'lugre' is not one of"),
        (("friction", "x.csv", "--shortest", "0"), "cruise shortest: 0.0; allowed: a number above 0"),
        (("friction", "x.csv", "--plot", "none/map"), "none"),
        (("friction", "x.csv", "--plot", "m.jpg"), "m.jpg: ends in .jpg; allowed: no suffix, .png or .svg"),
        (("friction", "x.csv", "--subtract", "all"), f"--subtract: {WITH_ROBOT}"),
        (("friction", "x.csv", "--reading", "printed"), f"--reading: {WITH_ROBOT}"),
        (("friction", "x.csv", "--mount", "wall"), f"--mount: {WITH_ROBOT}"),
        (("motion", "x.csv"), "Missing argument 'LOG...'"),
        (("motion", "x.csv", "y.csv"), f"ROBOT: x.csv, {FIRST}"),
        (("elastic", "x.npz", "y.csv"), f"ROBOT: x.npz, {FIRST}"),
        (("payload", "x.mcap", "y.csv"), f"ROBOT: x.mcap, {FIRST}"),
        (("table", "x.parquet", "y.csv"), f"ROBOT: x.parquet, {FIRST}"),
        (("motion", "lwr4plus", "x.csv", "--tool", "mass=1", "--out", "x.toml"),
         "--tool: given, which changes the arm"),
        (("motion", "wam7", "x.csv", "--folds", "1"), "folds: 1; allowed: a number of at least 2"),
        (("motion", "wam7", "x.csv", "--deviation", "0"), "deviation: 0.0; allowed: a share above 0"),
        (("motion", "wam7", "x.csv", "--fit-friction", "lugre"), "'lugre' is not one of"),
    ],
)  # fmt: skip
def test_bad_input_gets_one_line(refused, arguments, message, folder):
    assert message in refused("identify", *arguments)
