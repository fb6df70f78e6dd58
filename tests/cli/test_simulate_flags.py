"""What flags of `lwr-dyn simulate` do to a run; friction: its form, its refit, its warning; files of foreign runs."""

import json

import numpy as np
import pytest

from lwr_dyn.cli.main import main
from lwr_dyn.model.run import Run

HOLD = ("--task", "hold", "--from-deg", "0,30,0,-60,0,30,0", "--duration", "0.3")
MOVE = (
    "--task",
    "point-to-point",
    "--from-deg",
    "0,30,0,-60,0,30,0",
    "--to-deg",
    "9,40,0,-60,0,30,0",
    "--duration",
    "1",
)


@pytest.mark.slow
def test_uses_of_limits_stand_in_their_columns(printed, recorded):
    found = recorded("simulate", "lwr4plus", *MOVE)["metrics"]
    row, row_of_all = (
        next(x.split() for x in printed("simulate", "lwr4plus", *MOVE, *more).splitlines() if x.startswith("joint_2"))
        for more in ((), ("--full",))
    )
    assert row[-3:-1] == [f"{found['torque_use'][1]:.0%}", f"{found['speed_use'][1]:.0%}"]
    assert row[-3] != row[-2]
    assert (row[1], len(row)) == ("mrad", 8)
    assert (len(row_of_all), row_of_all[-4:], row_of_all[6]) == (14, row[-4:], row[2])


@pytest.mark.slow
def test_an_error_of_zero_has_no_sign(printed):
    out = printed("simulate", "lwr4plus", *HOLD)
    assert "joint_2  mrad      0 " in out
    assert " -0 " not in out


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """What the file of a run holds."""
    path = tmp_path_factory.mktemp("stored") / "run.npz"
    with pytest.raises(SystemExit) as stop:
        main(["simulate", "lwr4plus", *HOLD[:-1], "0.01", "--out", str(path)])
    assert stop.value.code == 0
    with np.load(path) as arrays:
        return dict(arrays)


@pytest.mark.slow
def test_the_record_as_it_was_is_a_run(lwr_dyn_command, tmp_path, stored):
    np.savez(tmp_path / "run.npz", **stored)
    assert lwr_dyn_command("replay", str(tmp_path / "run.npz"), "--html", str(tmp_path / "x.html"))[0] == 0


@pytest.mark.slow
@pytest.mark.parametrize("field", ["events", "meta", "schema"])
@pytest.mark.parametrize("value", [None, 3, [[1.0]], "x"])
def test_a_foreign_record_is_no_run(refused, tmp_path, stored, field, value):
    path, arrays = tmp_path / "run.npz", dict(stored)
    record = json.loads(arrays["record"].tobytes()) | {field: value}
    arrays["record"] = np.frombuffer(json.dumps(record).encode(), dtype=np.uint8)
    np.savez(path, **arrays)
    refused("replay", str(path), "--html", str(tmp_path / "x.html"))
    with pytest.raises(OSError, match="run file"):
        Run.load(path)


def test_several_files_are_written_together_or_not_at_all(refused, tmp_path):
    (tmp_path / "x.srdf").mkdir()
    refused("urdf", "lwr4plus", "--out", str(tmp_path / "x.urdf"))
    assert [p.name for p in tmp_path.iterdir()] == ["x.srdf"]


LSPB = ("simulate", "wam7", "--task", "lspb", "--from-deg", "0,-60,0,90,0,0,0", "--own-gains", "--velocity-error")
FAST = (*LSPB, "--to-deg", "0,-60,0,130,0,0,0", "--duration", "1.0", "--blend", "0.3")


@pytest.mark.slow
def test_friction_that_drives_is_warned_of(printed):
    out = printed(*FAST)
    assert "friction of the plant: set-valued\n" in out
    assert "warning: friction of joint_4 feeds energy in from" in out
    assert "friction:" not in printed(*FAST, "--friction", "none")


@pytest.mark.slow
def test_a_passive_refit_shows_its_cost_and_drives_no_more(printed, recorded):
    record = recorded(*FAST, "--passive-refit")
    assert "friction feeds energy in" not in [event["kind"] for event in record["events"]]
    changes = record["meta"]["note"]["passive_refit"]
    assert [(c["joint"], c["side"]) for c in changes] == [
        ("joint_2", "negative"), ("joint_4", "positive"), ("joint_4", "negative"), ("joint_5", "positive"),
    ]  # fmt: skip
    assert changes[1]["rms"] == pytest.approx(0.312, abs=1e-3)
    assert record["meta"]["friction_law"]["viscous"][0][3] == 0.0
    assert "passive refit of joint_4, positive: F_c 1.5414" in printed(*FAST, "--passive-refit")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("--passive-refit", "--friction", "none"),
            "--passive-refit: with --friction none; allowed: with --friction set",
        ),
        (("--friction", "smooth"), "allowed: substeps from"),
        (("--controller", "pid"), "--own-gains: would do nothing here; allowed: with --controller pd-gravity"),
        (("--friction", "dry"), "'dry' is not one of"),
        (("--blend", "0.7"), "blend"),
    ],
)
def test_bad_input_is_one_line(refused, arguments, message):
    assert message in refused(*FAST, *arguments)
