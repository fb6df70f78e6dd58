"""`lwr-dyn identify friction` as a user types it."""

import sys

import pytest

from lwr_dyn.identification.logs.joint_log import write_log


@pytest.fixture
def logs(tmp_path, one_joint_at_a_time):
    paths = [tmp_path / f"{i:02d}.csv" for i in range(len(one_joint_at_a_time))]
    for path, log in zip(paths, one_joint_at_a_time, strict=True):
        write_log(path, log)
    return paths


@pytest.mark.slow
def test_friction_as_json_and_as_a_plot(recorded, logs, tmp_path):
    out_file = tmp_path / "map"
    found = recorded("identify", "friction", "wam7", *logs, "--plot", out_file)
    assert len(found["fits"]) == 14
    assert len(found["map"]) == 56
    first = found["fits"][0]
    assert first["parameters"]["coulomb"]["value"] == pytest.approx(4.4748)
    assert {"standard_error", "three_sigma", "bias_of_averaging"} <= set(first["parameters"]["viscous"])
    assert first["speeds"] == pytest.approx([0.05, 0.3])
    assert first["residual_rms"] < 1e-9
    assert out_file.with_suffix(".png").read_bytes()[:4] == b"\x89PNG"
    assert b"<svg" in out_file.with_suffix(".svg").read_bytes()


def test_without_matplotlib_a_plot_is_refused_before_anything_is_printed(refused, logs, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert "pip install 'lwr_dyn[plots]'" in refused("identify", "friction", *logs, "--plot", tmp_path / "map")


@pytest.mark.slow
def test_the_table_names_the_torques_taken_out(printed, logs):
    out = printed("identify", "friction", "wam7", *logs, "--robust")
    assert "56 cruises in 56 files, Huber's loss, taken out of the torques: g" in out
    assert "--subtract all takes it out" in out
    assert out.count("0.05 to 0.3") == 14


@pytest.mark.slow
def test_good_files_are_reported_and_every_bad_one_gets_a_line(lwr_dyn_command, logs, tmp_path):
    bad = tmp_path / "bad.csv"
    bad.write_text("time,q1\n0,0\n")
    code, out, err = lwr_dyn_command("identify", "friction", "wam7", bad, *logs, tmp_path / "none.csv")
    assert code == 2
    assert out.count("0.05 to 0.3") == 14
    assert err.splitlines() == [
        f"lwr-dyn: {bad}: columns: tau1 missing; the file has time, q1; "
        "needed: time, q1.., tau1.. (and dq1.. if measured)",
        f"lwr-dyn: {tmp_path / 'none.csv'}: no such file or directory; allowed: a log (.csv or .parquet)",
    ]


def test_nothing_but_bad_files_prints_no_report(refused, tmp_path):
    refused("identify", "friction", tmp_path / "none.csv", "--json")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("friction",), "Missing argument '[ROBOT]'"),
        (("friction", "wam7"), "Missing argument 'LOG...'"),
        (("friction", "kuka", "x.csv"), "no robot named 'kuka'"),
        (
            ("friction", "x.csv", "--robot", "wam7"),
            "--robot is now the first argument: lwr-dyn identify friction ROBOT LOG",
        ),
        (("friction", "x.csv", "--units", "q=turns"), "units of q: 'turns'; allowed: rad, deg"),
        (("friction", "x.csv", "--model", "lugre"), "'lugre' is not one of"),
        (("friction", "x.csv", "--shortest", "0"), "cruise shortest: 0.0; allowed: a number above 0"),
        (("friction", "x.csv", "--plot", "none/map"), "none"),
        (("friction", "x.csv", "--plot", "m.jpg"), "m.jpg: ends in .jpg; allowed: no suffix, .png or .svg"),
        (
            ("friction", "x.csv", "--subtract", "all"),
            "--subtract: would do nothing here; allowed: with a robot: ROBOT LOG...",
        ),
        (
            ("friction", "x.csv", "--reading", "printed"),
            "--reading: would do nothing here; allowed: with a robot: ROBOT LOG...",
        ),
        (
            ("friction", "x.csv", "--mount", "wall"),
            "--mount: would do nothing here; allowed: with a robot: ROBOT LOG...",
        ),
        (("motion", "x.csv"), "Missing argument 'LOG...'"),
        (("motion", "x.csv", "y.csv"), "ROBOT: x.csv, a log; allowed: a robot first, then its logs"),
        (("elastic", "x.npz", "y.csv"), "ROBOT: x.npz, a log; allowed: a robot first, then its logs"),
        (("payload", "x.mcap", "y.csv"), "ROBOT: x.mcap, a log; allowed: a robot first, then its logs"),
        (("table", "x.parquet", "y.csv"), "ROBOT: x.parquet, a log; allowed: a robot first, then its logs"),
        (
            ("motion", "lwr4plus", "x.csv", "--tool", "mass=1", "--out", "x.toml"),
            "--tool: given, which changes the arm",
        ),
        (("motion", "wam7", "x.csv", "--folds", "1"), "folds: 1; allowed: a number of at least 2"),
        (("motion", "wam7", "x.csv", "--deviation", "0"), "deviation: 0.0; allowed: a share above 0"),
        (("motion", "wam7", "x.csv", "--fit-friction", "lugre"), "'lugre' is not one of"),
    ],
)
def test_bad_input_gets_one_line(refused, arguments, message, folder):
    assert message in refused("identify", *arguments)
